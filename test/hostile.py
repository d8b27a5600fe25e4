"""Commands with fields as they should not be."""

import math
import random

from ur5_ros.cdr.fixed_messages import encode
from ur5_ros.signals import JOINT_NAMES

NUMBERS = (0.0, -0.0, 1.0, -150.0, 1e-320, 1e30, -1e308, math.inf, -math.inf, math.nan, 5e-324)
TEXTS = ('', 'elbow_joint', 'ELBOW_JOINT', 'x' * 300, '../../etc', '<script>', '\u202e', 'a\nb')


def hostile_command(dice: random.Random, stamp: int) -> bytes:
    """Return a JointState with some fields as they should not be."""
    names = list(JOINT_NAMES)
    effort = [dice.uniform(-30.0, 30.0) for _ in names]
    for _ in range(dice.choice([0, 1, 1, 2, 5])):
        spoil = dice.randrange(6)
        if spoil == 0 and effort:
            effort[dice.randrange(len(effort))] = dice.choice(NUMBERS)
        elif spoil == 1 and names:
            names[dice.randrange(len(names))] = dice.choice(TEXTS)
        elif spoil == 2:
            dice.shuffle(names)
        elif spoil == 3:
            effort = effort[:dice.randrange(7)] + [0.0] * dice.randrange(3)
        elif spoil == 4:
            names = names[:dice.randrange(7)]
        else:
            stamp = dice.choice([0, 1, stamp + 1, -(2**31) * 10**9, (2**31 - 1) * 10**9])
    seconds, nanoseconds = divmod(stamp, 10**9)
    data = encode('sensor_msgs/msg/JointState', {
        'header': {'stamp': {'sec': seconds, 'nanosec': nanoseconds}, 'frame_id': ''},
        'name': names, 'position': [math.nan] * dice.randrange(3), 'velocity': [],
        'effort': effort})
    if dice.random() < 0.2:
        spoiled = bytearray(data)
        spoiled[dice.randrange(len(spoiled))] ^= 1 << dice.randrange(8)
        data = bytes(spoiled)
    return data
