"""Were limits touched: positions, speeds, torques, stops."""

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.result import FAIL, PASS, Check, not_applicable
from ur5_ros.signals import JOINT_NAMES
from ur5_ros.wording import number_of


def limits_check(run: Run) -> Check:
    """Return whether every joint kept off the limits of the simulated, or the model's, arm."""
    record = run.sim or run.control
    if record is None:
        return not_applicable('limits', 'no arm is known; give one: --arm NAME')
    limits = record.arm.limits
    q, qd, effort = run.exact
    touched, use = [], {}
    for what, value, low, high in (
            ('position', q, limits.lower, limits.upper),
            ('speed', qd, -limits.velocity, limits.velocity),
            ('torque', effort, -limits.effort, limits.effort)):
        beyond = (value >= high) | (value <= low)
        finite = np.isfinite(value).all(axis=1)
        size = np.abs(value[finite])
        share = (size / np.where(np.isfinite(high), np.maximum(np.abs(low), high), np.inf))
        use[what] = dict(zip(JOINT_NAMES, share.max(axis=0, initial=0.0).tolist(), strict=True))
        for i in np.flatnonzero(beyond.any(axis=0)):
            count, first = int(beyond[:, i].sum()), int(np.argmax(beyond[:, i]))
            touched.append(f'{JOINT_NAMES[i]} {what} in {number_of(count, "state")} from '
                           f'{run.t[first]:.4g} s')
    stops = [event for event in run.events if event.kind == 'protective_stop']
    touched += [f'protective stop at {event.stamp * 1e-9:.6g} s' for event in stops[:3]]
    if touched:
        return Check('limits', FAIL, 'limits touched: ' + '; '.join(touched), float(len(touched)),
                     0.0, 'limits', {'touched': touched, 'share_of_limit': use})
    most = {what: max(joints.values()) for what, joints in use.items()}
    return Check('limits', PASS, 'none touched; at most {position:.0%} of a position limit, '
                 '{speed:.0%} of a speed limit, {torque:.0%} of a torque limit'.format(**most),
                 0.0, 0.0, 'limits', {'share_of_limit': use})
