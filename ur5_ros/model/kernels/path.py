"""Kernel that follows a path of poses from one configuration to the next."""

from math import floor, inf, pi

import numpy as np

from ur5_ros.model.kernels.compiled import R1, R2, W2, kernel
from ur5_ros.model.kernels.inverse_kinematics import branches, is_rigid

TURN = 2.0 * pi


@kernel(R2, R1, R1, R1, R1, W2)
def follow(t, start, lower, upper, k, out):
    """
    Write for every pose the solution nearest to that of the pose before.

    Rows of ``out`` are six angles and what was met: 0, 1 unreachable, 2 outside the limits, and
    -1 where the pose is not rigid.  Where there is no solution the one before is carried on.
    """
    slots = np.empty((8, 6))
    last = np.empty(6)
    last[:] = start
    for i in range(out.shape[0]):
        out[i, 6] = 0.0
        found = 0
        if is_rigid(t, 4 * i):
            found = branches(t, 4 * i, last[5], k, slots, np.intp(0))
        else:
            out[i, 6] = -1.0
        best = inf
        for slot in range(8):
            if not found >> slot & 1:
                continue
            way, inside = 0.0, True
            for j in range(6):
                x = slots[slot, j]
                x += TURN * floor((last[j] - x) / TURN + 0.5)
                slots[slot, j] = x
                inside = inside and lower[j] - 1e-9 <= x <= upper[j] + 1e-9
                way += (x - last[j]) ** 2
            if way < best:
                best = way
                out[i, :6] = slots[slot]
                out[i, 6] = 0.0 if inside else 2.0
        if best == inf:
            out[i, :6] = last
            if out[i, 6] == 0.0:
                out[i, 6] = 1.0
        last[:] = out[i, :6]
    return 0
