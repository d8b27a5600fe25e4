"""The simulator's own scheme, from what the bag says: which arm, friction and wrench when."""

from dataclasses import dataclass, field, replace

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.model.dynamics import forward_dynamics, inertia_matrix, inverse_dynamics
from ur5_ros.model.kinematics import jacobian
from ur5_ros.model.parameters import ArmParameters, Payload, with_payload

#: Guesses at which joints stick: of all at once, and altogether.
AT_ONCE, MOST_GUESSES = 10, 300


@dataclass(frozen=True, eq=False)
class PlantModel:
    """What moves the arm between two states, beside the recorded effort."""

    arm: ArmParameters
    """The arm with every payload and the gravity in force."""
    viscous: np.ndarray = field(default_factory=lambda: np.zeros(6))
    """Viscous friction [N m s/rad], shape (6,)."""
    coulomb: np.ndarray = field(default_factory=lambda: np.zeros(6))
    """Coulomb friction [N m], shape (6,)."""
    wrench: np.ndarray = field(default_factory=lambda: np.zeros(6))
    """Force [N] and torque [N m] on the tool at the origin of tool0, in base, shape (6,)."""

    @property
    def frictionless(self) -> bool:
        """Tell whether no friction acts."""
        return not (np.any(self.viscous) or np.any(self.coulomb))

    def friction(self, qd: np.ndarray) -> np.ndarray:
        """Return the friction torque that opposes the speeds ``qd``, shape (..., 6) [N m]."""
        return self.viscous * qd + self.coulomb * np.sign(qd)

    def external(self, q: np.ndarray) -> np.ndarray:
        """
        Return the joint torque of the wrench.

        Parameters
        ----------
        q : numpy.ndarray, shape (..., 6)
            Joint positions, manufacturer's angles [rad].

        Returns
        -------
        numpy.ndarray, shape (..., 6)
            J^T w [N m].

        """
        if not np.any(self.wrench):
            return np.zeros(q.shape)
        return np.einsum('...ij,i->...j', jacobian(q + self.arm.angle_offset, self.arm),
                         self.wrench)


def plant_models(run: Run) -> list[tuple[int, PlantModel]]:
    """
    Return the scheme in force from each row on: ``(first row, scheme)``, the first row being 0.

    Parameters
    ----------
    run : Run
        A recording with the simulator's description.

    """
    values = {name: run.sim.parameters[name] for name in (
        'payload.mass', 'payload.com', 'friction.viscous', 'friction.coulomb', 'gravity')}
    wrench = np.zeros(6)
    found = [(0, _plant_model(run.sim.arm, values, wrench))]
    for event in run.events:
        if event.kind == 'parameter' and event.values.get('name') in values:
            values[event.values['name']] = event.values['value']
        elif event.kind == 'wrench':
            wrench = np.array([*event.values['force'], *event.values['torque']], dtype=float)
        else:
            continue
        row = int(np.searchsorted(run.stamp, event.stamp))
        if found[-1][0] == row:
            found.pop()
        found.append((row, _plant_model(run.sim.arm, values, wrench)))
    return found


def predict(
    scheme: PlantModel, q: np.ndarray, qd: np.ndarray, effort: np.ndarray, h: float, substeps: int,
) -> tuple[np.ndarray, np.ndarray]:
    """
    Return the states one control period later, in the simulator's scheme under constant effort.

    Each physics step solves M (qd' - qd)/h + C qd + g + D qd' + f(qd') = effort + J^T w for qd',
    f being Coulomb friction at the new velocity, and takes q' = q + h qd'.

    Parameters
    ----------
    scheme : PlantModel
        What acts beside the effort.
    q, qd, effort : numpy.ndarray, shape (n, 6)
        States [rad, rad/s] and the torque that acts [N m].
    h : float
        Physics step [s].
    substeps : int
        Physics steps a control period.

    Returns
    -------
    tuple of numpy.ndarray
        Positions and velocities, shapes (n, 6); NaN where sticking joints could not be told.

    """
    for _ in range(substeps):
        q, qd = _step(scheme, q, qd, effort, h)
    return q, qd


def path(
    scheme: PlantModel, states: tuple[np.ndarray, np.ndarray], ends: tuple[np.ndarray, np.ndarray],
    effort: np.ndarray, h: float, substeps: int,
) -> tuple[np.ndarray, ...]:
    """
    Return the physics steps of recorded periods: those between two states are predicted.

    Parameters
    ----------
    scheme : PlantModel
        What acts beside the effort.
    states, ends : tuple of numpy.ndarray, shapes (n, 6)
        Positions and velocities at the beginning and at the end of each period [rad, rad/s].
    effort : numpy.ndarray, shape (n substeps, 6)
        Torque in each physics step [N m].
    h : float
        Physics step [s].
    substeps : int
        Physics steps a period.

    Returns
    -------
    tuple of numpy.ndarray
        q, qd before and q, qd after every physics step, shapes (n substeps, 6).

    """
    if substeps == 1:
        return *states, *ends
    between = [states]
    for i in range(substeps - 1):
        between.append(_step(scheme, *between[-1], effort[i::substeps], h))
    before = (np.stack(part, axis=1).reshape(-1, 6) for part in zip(*between, strict=True))
    after = (np.stack(part, axis=1).reshape(-1, 6)
             for part in zip(*between[1:], ends, strict=True))
    return *before, *after


def _step(scheme: PlantModel, q, qd, effort, h: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the states one physics step later."""
    arm = scheme.arm
    if not (known := np.isfinite(q).all(axis=1)).all():  # as long as its step could be told
        after = np.full((2, *q.shape), np.nan)
        after[:, known] = _step(scheme, q[known], qd[known], effort[known], h)
        return after[0], after[1]
    angles = q + arm.angle_offset
    torque = effort + scheme.external(q)
    if scheme.frictionless:
        qd = qd + h * forward_dynamics(angles, qd, torque, arm)
    else:
        A = inertia_matrix(angles, arm) / h
        drive = torque - inverse_dynamics(angles, qd, np.zeros(qd.shape), arm)
        A[:, range(6), range(6)] += scheme.viscous
        qd = qd + _change(A, drive - scheme.viscous * qd, qd, scheme.coulomb)
    return q + h * qd, qd


def _change(A: np.ndarray, drive: np.ndarray, qd: np.ndarray, level: np.ndarray) -> np.ndarray:
    """
    Return delta with A delta + f = drive, f in level Sgn(qd + delta), for n rows at once.

    Joints are guessed to move on or to stick, the guess is solved and mended until it stands: all
    joints at once, which is quick but may go in circles, then the first wrong one alone, which
    ends (Murty's least-index rule; A is positive definite).

    """
    sign = np.where(qd < 0.0, -1.0, 1.0)
    sign[(qd == 0.0) & (level > 0.0)] = 0.0
    delta = np.full(qd.shape, np.nan)
    open_rows = np.arange(len(qd))
    for attempt in range(MOST_GUESSES):
        a, s, v = A[open_rows], sign[open_rows], qd[open_rows]
        still = (s == 0.0)
        matrix = np.where(still[:, :, None], np.eye(6), a)
        right = np.where(still, -v, drive[open_rows] - s * level)
        change = np.linalg.solve(matrix, right[:, :, None])[:, :, 0]
        force = np.where(still, drive[open_rows] - np.einsum('nij,nj->ni', a, change), s * level)
        z = np.einsum('nii->ni', a) * (v + change) + force
        better = np.where(z < 0.0, -1.0, 1.0)
        better[(np.abs(z) <= level) & (level > 0.0)] = 0.0
        wrong = (better != s) & (level > 0.0)
        done = ~wrong.any(axis=1)
        delta[open_rows[done]] = change[done]
        if attempt >= AT_ONCE:
            wrong[:, 1:] &= ~np.maximum.accumulate(wrong, axis=1)[:, :-1]
            better[(better == -s) & (level > 0.0)] = 0.0
        sign[open_rows] = np.where(wrong, better, s)
        open_rows = open_rows[~done]
        if not len(open_rows):
            break
    return delta


def _plant_model(arm: ArmParameters, values: dict, wrench: np.ndarray) -> PlantModel:
    mass = float(values['payload.mass'])
    if mass:
        masses, coms, tensors = (np.array(part) for part in arm.bodies)
        declared = replace(arm, mass=masses, com=coms, inertia=tensors, payload=Payload())
        arm = with_payload(declared, mass, values['payload.com'])
    if len(values['gravity']):
        arm = replace(arm, gravity=np.array(values['gravity'], dtype=float))
    return PlantModel(arm, np.array(values['friction.viscous'], dtype=float),
                  np.array(values['friction.coulomb'], dtype=float), wrench)
