"""What every node needs of rclpy: start, topics, parameters, recording, loops, shutdown."""
