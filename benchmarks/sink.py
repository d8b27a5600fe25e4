"""A process that subscribes to one JointState topic and takes what comes, until it is killed."""

import subprocess
import sys
import time

import child
from ping_pong import QOS, Taker


def start(topic: str) -> subprocess.Popen:
    """Return such a process, in the ROS domain of this one."""
    return child.start([sys.executable, __file__, topic])


def wait_for(publisher) -> None:
    """Wait until somebody hears a publisher."""
    limit = time.monotonic() + 30.0
    while not publisher.get_subscription_count():
        if time.monotonic() > limit:
            raise SystemExit('no subscription within 30 s')
        time.sleep(0.01)


def main() -> None:
    """Take messages without end."""
    import rclpy
    from sensor_msgs.msg import JointState
    rclpy.init()
    node = rclpy.create_node('sink')
    taker = Taker(node, node.create_subscription(
        JointState, sys.argv[1], lambda _: None, QOS, raw=True))
    while True:
        taker.take(1.0)


if __name__ == '__main__':
    main()
