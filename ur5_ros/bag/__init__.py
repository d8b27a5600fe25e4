"""The rosbag2 folder: writing, reading, recovery, metadata; no rclpy."""
