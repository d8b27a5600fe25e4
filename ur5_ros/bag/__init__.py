"""The bag format: CDR, rosbag2 folders with MCAP inside, reading, recovery; no rclpy."""
