"""The numbers that kernels read: geometry, gravity, and the inertial parameters, combined."""

import numpy as np

# Where each number of the packed array stands.
D1, A2, A3, D4, D5, D6 = range(6)
GRAVITY = 6     # 3 numbers, in base
ARMATURE = 9    # 6 numbers
SPIN = 15       # second moment of link 1 about joint axis 1
SHOULDER = 16   # mass, and first moments x, y, z of link 1 in its own frame
BODY = 20       # links 2 to 6: hx, hy, xx, xy, yy, xz, yz each
WIDTH = 7
SIZE = BODY + 5 * WIDTH


def pack(arm) -> np.ndarray:
    """
    Return what the kernels need of an arm in one array.

    Mass that lies on a joint axis moves alike on either side of the joint.  So of every link the
    mass, the first moment along its joint axis and the second moment along it are handed to the
    link before it; nothing changes, and the links 2 to 6 are left with seven numbers each and
    no mass (the regrouping of Gautier and Khalil 1990).

    Returned: laid out as the constants of this module say, (SIZE,).
    """
    bodies = [_pseudo_inertia(m, c, tensor) for m, c, tensor in zip(*arm.bodies, strict=True)]
    # from the distal frame of link i (standard DH) to the frame that only turns with joint i:
    # origin on joint axis i, z along it
    for i in range(1, 6):
        own = _pose(arm.alpha[i], arm.a[i], arm.d[i])
        bodies[i] = own @ bodies[i] @ own.T
    for i in range(5, 0, -1):
        line = bodies[i].copy()
        line[:2] = line[:, :2] = 0.0
        bodies[i] = bodies[i] - line
        mount = _mount(arm, i)
        bodies[i - 1] = bodies[i - 1] + mount @ line @ mount.T
    packed = np.empty(SIZE)
    packed[:GRAVITY] = arm.d[0], arm.a[1], arm.a[2], arm.d[3], arm.d[4], arm.d[5]
    packed[GRAVITY:ARMATURE] = arm.gravity
    packed[ARMATURE:SPIN] = arm.armature
    first = bodies[0]  # turns about its own y
    packed[SPIN] = first[0, 0] + first[2, 2]
    packed[SHOULDER:BODY] = first[3, 3], *first[:3, 3]
    for i, body in enumerate(bodies[1:]):
        at = BODY + WIDTH * i
        packed[at:at + 2] = body[:2, 3]
        packed[at + 2:at + WIDTH] = (body[0, 0], body[0, 1], body[1, 1], body[0, 2], body[1, 2])
    return packed


def _pseudo_inertia(mass: float, com: np.ndarray, tensor: np.ndarray) -> np.ndarray:
    body = np.empty((4, 4))  # integral of [x, 1] [x, 1]^T dm
    body[:3, :3] = 0.5 * np.trace(tensor) * np.eye(3) - tensor + mass * np.outer(com, com)
    body[:3, 3] = body[3, :3] = mass * com
    body[3, 3] = mass
    return body


def _pose(twist: float, along_x: float, along_z: float) -> np.ndarray:
    c, s = np.cos(twist), np.sin(twist)
    return np.array([[1.0, 0.0, 0.0, along_x], [0.0, c, -s, 0.0], [0.0, s, c, along_z],
                     [0.0, 0.0, 0.0, 1.0]])


def _mount(arm, i: int) -> np.ndarray:
    # pose of joint axis i + 1 (0-based i) in the frame of link i; link 1 keeps its distal frame
    return np.eye(4) if i == 1 else _pose(arm.alpha[i - 1], arm.a[i - 1], arm.d[i - 1])
