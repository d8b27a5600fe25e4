"""What the arm looks like: tubes and joint housings, scaled by its geometry."""

from typing import NamedTuple

import numpy as np

from ur5_ros.model.parameters import ArmParameters

COLOURS = {
    'aluminium': (0.78, 0.79, 0.80, 1.0),
    'cap_blue': (0.44, 0.62, 0.76, 1.0),
    'joint_dark': (0.25, 0.26, 0.28, 1.0),
}
_ALONG_X = (0.0, np.pi / 2, 0.0)
_ALONG_Y = (-np.pi / 2, 0.0, 0.0)
_ALONG_Z = (0.0, 0.0, 0.0)


class Shape(NamedTuple):
    """A cylinder, or a sphere where the length is zero, in a link frame [m, rad]."""

    xyz: tuple[float, float, float]
    rpy: tuple[float, float, float]
    radius: float
    length: float
    colour: str

    def geometry(self) -> str:
        """Return the URDF element."""
        if self.length == 0.0:
            return f'<sphere radius="{self.radius:.6g}"/>'
        return f'<cylinder radius="{self.radius:.6g}" length="{self.length:.6g}"/>'


def arm_shapes(arm: ArmParameters) -> dict[str, list[Shape]]:
    """
    Return the shapes of ``base`` and of each link, by link name.

    Sizes are assumed: those of a UR5 scaled by the reach, with the side offset of the upper arm
    and the forearm taken from their centres of mass (the DH table does not hold it).
    """
    upper, fore = float(abs(arm.a[1])), float(abs(arm.a[2]))
    d1, d4, d5, d6 = (float(arm.d[i]) for i in (0, 3, 4, 5))
    scale = (upper + fore) / 0.817
    big, mid, small = 0.060 * scale, 0.052 * scale, 0.040 * scale
    side_upper = 1.2 * float(arm.com[1, 2]) or 1.2 * d4
    side_fore = 0.6 * float(arm.com[2, 2])
    return {
        'base': [
            _rod((0, 0, 0), (0, 0, 0.2 * d1), 1.25 * big, 'aluminium'),
            _rod((0, 0, 0.2 * d1), (0, 0, d1 - 0.9 * big), 0.95 * big, 'joint_dark'),
        ],
        'shoulder_link': [
            _rod((0, 0, -0.9 * big), (0, 0, 0.9 * big), big, 'aluminium'),
            _cap((0, 0, 0.9 * big), 'z', big),
            _rod((0, 0, 0), (0, -(side_upper - 1.1 * big), 0), 0.98 * big, 'aluminium'),
        ],
        'upper_arm_link': [
            _rod((0, 0, side_upper - 1.05 * big), (0, 0, side_upper + 0.95 * big), big,
                 'aluminium'),
            _cap((0, 0, side_upper + 0.95 * big), 'z', big),
            _rod((0, 0, side_upper), (-upper, 0, side_upper), 0.75 * big, 'aluminium'),
            _rod((-upper, 0, side_upper - 1.05 * mid), (-upper, 0, side_upper + 0.95 * mid), mid,
                 'aluminium'),
            _cap((-upper, 0, side_upper + 0.95 * mid), 'z', mid),
        ],
        'forearm_link': [
            _rod((0, 0, side_fore - 0.9 * mid), (0, 0, side_upper - 1.1 * mid), mid,
                 'aluminium'),
            _cap((0, 0, side_fore - 0.9 * mid), '-z', mid),
            _rod((0, 0, side_fore), (-fore, 0, side_fore), 0.72 * mid, 'aluminium'),
            _rod((-fore, 0, side_fore - 1.1 * small), (-fore, 0, side_fore + 1.1 * small), small,
                 'aluminium'),
            _cap((-fore, 0, side_fore - 1.1 * small), '-z', small),
        ],
        'wrist_1_link': [
            _rod((0, 0, side_fore + 1.15 * small - d4), (0, 0, 1.15 * small), 0.86 * small,
                 'joint_dark'),
            _rod((0, 1.1 * small, 0), (0, -1.1 * small, 0), small, 'aluminium'),
            _cap((0, 1.1 * small, 0), 'y', small),
            _cap((0, 0, 1.15 * small), 'z', 0.86 * small),
        ],
        'wrist_2_link': [
            _rod((0, 0, 1.15 * small - d5), (0, 0, 1.15 * small), 0.86 * small, 'joint_dark'),
            _rod((0, -1.1 * small, 0), (0, 1.1 * small, 0), small, 'aluminium'),
            _cap((0, 0, 1.15 * small), 'z', 0.86 * small),
            _cap((0, -1.1 * small, 0), '-y', small),
        ],
        'wrist_3_link': [
            _rod((0, 0, 1.15 * small - d6), (0, 0, 0), 0.9 * small, 'aluminium'),
        ],
    }


def _rod(start: tuple, end: tuple, radius: float, colour: str) -> Shape:
    """Return a cylinder between two points on a line along one axis."""
    span = [abs(b - a) for a, b in zip(start, end, strict=True)]
    axis = int(np.argmax(span))
    centre = tuple((a + b) / 2 for a, b in zip(start, end, strict=True))
    return Shape(centre, (_ALONG_X, _ALONG_Y, _ALONG_Z)[axis], radius, span[axis], colour)


def _cap(centre: tuple, direction: str, radius: float) -> Shape:
    """Return the blue lid of a joint: a flat cylinder on its end."""
    axis = 'xyz'.index(direction[-1])
    sign = -1.0 if direction[0] == '-' else 1.0
    end = list(centre)
    end[axis] += sign * 0.25 * radius
    return _rod(centre, tuple(end), 0.93 * radius, 'cap_blue')
