"""
The simulator's step computed again, from what the bag states: arm, friction and wrench in force.

This is a second implementation on purpose: it shares no code with ``sim/integrator.py``, is
written for many rows at once, and is the independent witness that the residual is judged by. A
test holds its sticking joints against the simulator's.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.config.friction import joint_friction
from ur5_ros.model.dynamics import forward_dynamics, inertia_matrix, inverse_dynamics
from ur5_ros.model.friction import AT_REST, JointFriction
from ur5_ros.model.kinematics import jacobian
from ur5_ros.model.parameters import ArmParameters, Payload, with_payload

#: Guesses at which joints stick: of all joints at once, and in total.
ALL_JOINTS_GUESSES, MAX_GUESSES = 10, 300


@dataclass(frozen=True, eq=False)
class PlantModel:
    """The plant between two states: arm, friction and wrench, beside the recorded effort."""

    arm: ArmParameters
    """The arm with every payload and the gravity in force."""
    friction: JointFriction = field(default_factory=JointFriction)
    """What resists the motion of each joint."""
    wrench: np.ndarray = field(default_factory=lambda: np.zeros(6))
    """Force [N] and torque [N m] on the tool at the origin of tool0, in base, shape (6,)."""

    def friction_terms(self, q: np.ndarray, qd: np.ndarray) -> tuple[np.ndarray, ...]:
        """
        Return friction as it is in the step after a state.

        The torque against the motion is damping qd' + offset + level Sgn(qd') at the new speed.
        Written anew here, not taken from :mod:`ur5_ros.model.friction`: the analysis is a witness
        of the simulator.

        ``q``, ``qd`` (n, 6): states [rad, rad/s], manufacturer's angles.  Returned: ``damping``,
        ``level``, ``offset`` (n, 6): [N m s/rad], [N m], [N m].
        """
        part, speed = self.friction, np.abs(qd)
        if part.none:
            return tuple(np.zeros((3, *qd.shape)))
        peak = np.maximum(part.static - part.coulomb, 0.0)
        level = part.coulomb + peak * np.exp(-np.square(speed / part.stribeck_velocity))
        level = part.temperature_factor * (level + part.load_factor * self._load(q, qd))
        growth = np.polynomial.polynomial.polyval(speed, np.array([
            part.viscous, part.viscous_quadratic, part.viscous_cubic]), tensor=False)
        forwards = 1.0 + part.asymmetry * np.where(speed < AT_REST, 0.0, np.sign(qd))
        damping = part.temperature_factor * forwards * np.maximum(growth, 0.0)
        return damping, level, part.asymmetry * level

    def _load(self, q: np.ndarray, qd: np.ndarray) -> np.ndarray:
        """Return the size of the torque that the joints transmit without acceleration [N m]."""
        if not np.any(self.friction.load_factor):
            return np.zeros(q.shape)
        carried = inverse_dynamics(q + self.arm.angle_offset, qd, np.zeros(q.shape), self.arm)
        return np.abs(carried - self.external(q))

    def external(self, q: np.ndarray) -> np.ndarray:
        """Return J^T w, the joint torque of the wrench at q [rad]; both of shape (..., 6)."""
        if not np.any(self.wrench):
            return np.zeros(q.shape)
        return np.einsum('...ij,i->...j', jacobian(q + self.arm.angle_offset, self.arm),
                         self.wrench)


def law_model(run: Run, arm: ArmParameters) -> PlantModel:
    """Return the plant as the law has it: an arm, and its friction where that is fed forward."""
    if run.control is not None and run.control.parameters.get('friction_feedforward'):
        return PlantModel(arm, arm.friction)
    return PlantModel(arm)


def plant_models(run: Run) -> list[tuple[int, PlantModel]]:
    """Return the model in force from each row on: ``(first row, model)``, from row 0."""
    sim = run.required_sim
    values = {name: value for name, value in sim.parameters.items()
              if name == 'gravity' or name.startswith(('payload.', 'friction.'))}
    wrench, payload = np.zeros(6), _payload(values)
    found = [(0, _plant_model(sim.arm, values, payload, wrench))]
    for event in run.events:
        if event.kind == 'parameter' and event.values.get('name') in values:
            values[event.values['name']] = event.values['value']
            if values['payload.transition_time'] == 0.0:
                payload = _payload(values)
        elif event.kind == 'payload':
            payload = tuple(event.values[name] for name in ('mass', 'com', 'inertia'))
        elif event.kind == 'wrench':
            wrench = np.array([*event.values['force'], *event.values['torque']], dtype=float)
        else:
            continue
        row = int(np.searchsorted(run.stamp, event.stamp))
        if found[-1][0] == row:
            found.pop()
        found.append((row, _plant_model(sim.arm, values, payload, wrench)))
    return found


def predict(
    model: PlantModel, q: np.ndarray, qd: np.ndarray, effort: np.ndarray, h: float, substeps: int,
) -> tuple[np.ndarray, np.ndarray]:
    """
    Return positions and velocities one control period later, (n, 6).

    ``effort`` is the torque in each physics step [N m], shape (n, substeps, 6).

    Each physics step of ``h`` [s] solves M (qd' - qd)/h + C qd + g + f(qd') = effort + J^T w for
    qd', f being friction at the new velocity, and takes q' = q + h qd'.  NaN where no set of
    sticking joints was found.

    """
    for i in range(substeps):
        q, qd = _step(model, q, qd, effort[:, i], h)
    return q, qd


def path(
    model: PlantModel, states: tuple[np.ndarray, np.ndarray], ends: tuple[np.ndarray, np.ndarray],
    effort: np.ndarray, h: float, substeps: int,
) -> tuple[np.ndarray, ...]:
    """
    Return the physics steps of recorded periods; those between two states are predicted.

    ``states`` and ``ends`` are (q, qd) at the beginning and the end of each period, (n, 6);
    ``effort`` is the torque of each physics step, (n substeps, 6).  The result is q, qd before
    and q, qd after every physics step, (n substeps, 6).

    """
    if substeps == 1:
        return *states, *ends
    between = [states]
    for i in range(substeps - 1):
        between.append(_step(model, *between[-1], effort[i::substeps], h))
    before = (np.stack(part, axis=1).reshape(-1, 6) for part in zip(*between, strict=True))
    after = (np.stack(part, axis=1).reshape(-1, 6)
             for part in zip(*between[1:], ends, strict=True))
    return *before, *after


def _step(model: PlantModel, q, qd, effort, h: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the states one physics step later."""
    arm = model.arm
    if not (known := np.isfinite(q).all(axis=1)).all():  # where the step before was found
        after = np.full((2, *q.shape), np.nan)
        after[:, known] = _step(model, q[known], qd[known], effort[known], h)
        return after[0], after[1]
    angles = q + arm.angle_offset
    torque = effort + model.external(q)
    if model.friction.none:
        qd = qd + h * forward_dynamics(angles, qd, torque, arm)
    else:
        A = inertia_matrix(angles, arm) / h
        drive = torque - inverse_dynamics(angles, qd, np.zeros(qd.shape), arm)
        damping, level, offset = model.friction_terms(q, qd)
        A[:, range(6), range(6)] += damping
        qd = qd + friction_step(A, drive - damping * qd - offset, qd, level)
    return q + h * qd, qd


def friction_step(
    A: np.ndarray, drive: np.ndarray, qd: np.ndarray, level: np.ndarray,
) -> np.ndarray:
    """
    Return delta with A delta + f = drive, f in level Sgn(qd + delta), for n rows at once.

    Joints are guessed to move on or to stick, and the guess is corrected until it holds: all
    joints at once, which is fast but may cycle, then the first wrong one alone, which ends
    (Murty's least-index rule; A is positive definite).

    """
    level = np.broadcast_to(level, qd.shape)
    sign = np.where(qd < 0.0, -1.0, 1.0)
    sign[(qd == 0.0) & (level > 0.0)] = 0.0
    delta = np.full(qd.shape, np.nan)
    open_rows = np.arange(len(qd))
    for attempt in range(MAX_GUESSES):
        a, s, v = A[open_rows], sign[open_rows], qd[open_rows]
        dry = level[open_rows]
        still = (s == 0.0)
        matrix = np.where(still[:, :, None], np.eye(6), a)
        right = np.where(still, -v, drive[open_rows] - s * dry)
        change = np.linalg.solve(matrix, right[:, :, None])[:, :, 0]
        force = np.where(still, drive[open_rows] - np.einsum('nij,nj->ni', a, change), s * dry)
        z = np.einsum('nii->ni', a) * (v + change) + force
        better = np.where(z < 0.0, -1.0, 1.0)
        better[(np.abs(z) <= dry) & (dry > 0.0)] = 0.0
        wrong = (better != s) & (dry > 0.0)
        done = ~wrong.any(axis=1)
        delta[open_rows[done]] = change[done]
        if attempt >= ALL_JOINTS_GUESSES:
            wrong[:, 1:] &= ~np.maximum.accumulate(wrong, axis=1)[:, :-1]
            better[(better == -s) & (dry > 0.0)] = 0.0
        sign[open_rows] = np.where(wrong, better, s)
        open_rows = open_rows[~done]
        if not len(open_rows):
            break
    return delta


def _payload(values: dict) -> tuple:
    """Return mass, centre of mass and tensor of the body that the parameters describe."""
    return tuple(values[f'payload.{part}'] for part in ('mass', 'com', 'inertia'))


def _plant_model(arm: ArmParameters, values: dict, payload: tuple,
                 wrench: np.ndarray) -> PlantModel:
    mass, com, (xx, yy, zz, xy, xz, yz) = payload
    if mass:
        masses, coms, tensors = (np.array(part) for part in arm.bodies)
        declared = replace(arm, mass=masses, com=coms, inertia=tensors, payload=Payload())
        arm = with_payload(declared, float(mass), com,
                           np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))
    if len(values['gravity']):
        arm = replace(arm, gravity=np.array(values['gravity'], dtype=float))
    return PlantModel(arm, joint_friction(values), wrench)
