"""The ROS nodes: thin rclpy shells around plant and control law."""
