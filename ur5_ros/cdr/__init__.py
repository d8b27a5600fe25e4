"""Bytes of ROS messages (CDR): layouts, schemas, encoding, decoding; no bag and no rclpy."""
