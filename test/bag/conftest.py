"""Small bags whose contents are known."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from ur5_ros.bag.writer import BagWriter
from ur5_ros.cdr.fixed_messages import FixedJointState, encode, encode_clock
from ur5_ros.signals import JOINT_NAMES

DESCRIPTION = {'format': '1', 'run': 'r', 'node': 'sim', 'arm': 'name: ur5\nmass: 1\n',
               'parameters': '{"kp": [100.0]}'}


class Recorded(NamedTuple):
    """A bag and what was written into it."""

    folder: Path
    stamp: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    effort: np.ndarray


def record(folder: Path, periods: int = 200, seed: int = 0, **options) -> Recorded:
    """Write a bag of states, clock and events at 1 kHz."""
    rng = np.random.default_rng(seed)
    position, velocity, effort = rng.normal(size=(3, periods, 6))
    stamp = np.arange(1, periods + 1) * 1_000_000
    codec = FixedJointState(JOINT_NAMES)
    with BagWriter(folder, DESCRIPTION, **options) as writer:
        states = writer.topic('/joint_states', 'sensor_msgs/msg/JointState')
        clock = writer.topic('/clock', 'rosgraph_msgs/msg/Clock')
        events = writer.topic('/ur5_sim/events', 'diagnostic_msgs/msg/DiagnosticArray')
        for k in range(periods):
            time = int(stamp[k])
            writer.write(clock, time, encode_clock(time))
            writer.write(states, time, codec.encode(time, position[k], velocity[k], effort[k]),
                         time + 1)
            if k % 50 == 0:
                writer.write(events, time, encode('diagnostic_msgs/msg/DiagnosticArray', {
                    'status': [{'name': 'pause', 'message': f'period {k}'}]}))
        writer.note('summary', {'periods': periods})
    assert writer.failure is None and writer.lost == 0
    return Recorded(folder, stamp, position, velocity, effort)


@pytest.fixture
def recorded(tmp_path):
    """Return a finished bag of 200 periods."""
    return record(tmp_path / 'bag')


@pytest.fixture(name='record')
def record_fixture():
    """Return the function that writes such a bag."""
    return record
