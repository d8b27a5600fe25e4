"""Thin rclpy shells around plant and law."""
