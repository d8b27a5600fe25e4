"""Poses and wrenches that come in other frames, in ``base``: a ``prefix`` is that of the names."""

from collections.abc import Sequence

import numpy as np

from ur5_ros.errors import InputError
from ur5_ros.model.parameters import ArmParameters

#: Largest force [N] and torque [N m] that an input may ask for.
LARGEST_WRENCH = 1e5
#: No pose is further away [m].
_LARGEST_DISTANCE = 1e6
#: base_link = base turned by Rz(pi) (REP-103).
BASE_FROM_BASE_LINK = np.diag([-1.0, -1.0, 1.0, 1.0])


def wrench_in_base(force: Sequence[float], torque: Sequence[float], frame: str, q: np.ndarray,
                   arm: ArmParameters, prefix: str = '') -> np.ndarray:
    """
    Return force [N] and torque [N m] at the origin of ``tool0`` in the axes of ``base``, (6,).

    ``force``, ``torque`` (3,): in the axes of ``frame``; ``frame``: ``base`` (also if it is
    empty), ``base_link`` or ``tool0``; ``q`` (6,): where the arm stands [rad], for ``tool0``.
    """
    parts = [np.asarray(part, dtype=float) for part in (force, torque)]
    if any(part.shape != (3,) or not (np.abs(part) <= LARGEST_WRENCH).all() for part in parts):
        raise InputError(f'wrench {[part.tolist() for part in parts]}; give three finite numbers '
                         f'each [N], [N m], of at most {LARGEST_WRENCH:g}')
    wrench = np.array(parts)
    if frame in ('', prefix + 'base'):
        return wrench.ravel()
    if frame == prefix + 'base_link':
        return (wrench @ BASE_FROM_BASE_LINK[:3, :3].T).ravel()
    if frame == prefix + 'tool0':
        from ur5_ros.model.kinematics import forward_kinematics  # loads Numba
        turn = forward_kinematics(q + arm.angle_offset, arm)[:3, :3]
        return (wrench @ turn.T).ravel()
    raise InputError(f'wrench in frame {frame[:60]!r}; give {prefix}base, {prefix}base_link or '
                     f'{prefix}tool0')


def pose_in_base(transform: np.ndarray, frame: str, prefix: str = '') -> np.ndarray:
    """
    Return a pose given in ``base`` or ``base_link`` in ``base``.

    ``transform`` (..., 4, 4): the pose.  Returned: in ``base``, (..., 4, 4).
    """
    transform = np.asarray(transform, dtype=float)
    if transform.shape[-2:] != (4, 4) or not np.all(np.isfinite(transform)):
        raise InputError(f'pose of shape {transform.shape}; give finite (4, 4) transforms')
    if np.abs(transform).max(initial=0.0) > _LARGEST_DISTANCE:
        raise InputError(f'pose with {np.abs(transform).max():.6g} in it; give metres')
    rotation = transform[..., :3, :3]
    product = np.matmul(rotation, np.swapaxes(rotation, -1, -2))
    skewness = float(np.abs(product - np.eye(3)).max(initial=0.0))
    if skewness > 1e-6 or np.any(np.linalg.det(rotation) < 0.0):
        raise InputError(f'the rotation is off by {skewness:.3g} from an orthonormal right-handed '
                         'matrix; give a rotation')
    if frame == prefix + 'base':
        return transform
    if frame == prefix + 'base_link':
        return np.matmul(BASE_FROM_BASE_LINK, transform)
    raise InputError(f'frame {frame!r} is not known; give the pose in {prefix}base or '
                     f'{prefix}base_link')
