"""Messages of contact: rclpy reads what is written, and it comes back to the bit."""

import numpy as np
from geometry_msgs.msg import PoseArray, WrenchStamped
from rclpy.serialization import deserialize_message, serialize_message
from visualization_msgs.msg import Marker, MarkerArray

from ur5_ros.cdr.contact_messages import (
    ARROW_SCALE,
    ContactForce,
    FixedWrench,
    decode_markers,
    decode_poses,
    encode_markers,
    encode_poses,
)

STAMP = 3_000_000_007
RNG = np.random.default_rng(4)
CONTACTS = [ContactForce((f'link_{i}', 'table'), *RNG.normal(size=(3, 3)), 0.3) for i in range(3)]


def test_rclpy_reads_a_wrench():
    wrench = np.arange(6.0)
    message = deserialize_message(FixedWrench('tool0').encode(STAMP, wrench), WrenchStamped)
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (3, 7)
    assert message.header.frame_id == 'tool0'
    assert (message.wrench.force.x, message.wrench.torque.z) == (0.0, 5.0)


def test_rclpy_reads_arrows_and_writes_the_same_bytes():
    data = encode_markers(STAMP, 'base', CONTACTS)
    message = deserialize_message(data, MarkerArray)
    assert message.markers[0].action == Marker.DELETEALL
    arrow = message.markers[1]
    assert (arrow.type, arrow.action, arrow.ns) == (Marker.ARROW, Marker.ADD, 'link_0 / table')
    assert arrow.points[1].x - arrow.points[0].x == np.float64(
        CONTACTS[0].place[0] + ARROW_SCALE * CONTACTS[0].normal[0]) - CONTACTS[0].place[0]
    assert deserialize_message(serialize_message(message), MarkerArray) == message


def test_forces_come_back_from_their_arrows():
    stamp, found = decode_markers(encode_markers(STAMP, 'base', CONTACTS))
    assert stamp == STAMP
    for given, read in zip(CONTACTS, found, strict=True):
        assert read.bodies == given.bodies and read.friction == given.friction
        assert np.array_equal(read.place, given.place)
        assert np.abs(read.normal - given.normal).max() < 1e-12
        assert np.abs(read.lateral - given.lateral).max() < 1e-12
    assert decode_markers(encode_markers(STAMP, 'base', [])) == (STAMP, [])


def test_poses_come_back_to_the_bit():
    poses = RNG.normal(size=(2, 7))
    data = encode_poses(STAMP, 'base', [(pose[:3], pose[3:]) for pose in poses])
    stamp, found = decode_poses(data)
    assert stamp == STAMP and np.array_equal(found, poses)
    assert deserialize_message(data, PoseArray).poses[1].orientation.w == poses[1, 6]
