"""Identification: beside mujoco[sysid] on one recording, and on recordings of real robots."""

import csv
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from side_by_side import Row, arguments, interleave, publish, ratio

from ur5_ros.analysis.data.load import load_run
from ur5_ros.analysis.data.logs.robot_log import import_log
from ur5_ros.analysis.data.run import Run, States
from ur5_ros.analysis.identification.base_parameters import base_of
from ur5_ros.analysis.identification.exciting.excitation import excite
from ur5_ros.analysis.identification.friction.families import LINEAR
from ur5_ros.analysis.identification.identify import identify, identify_payload
from ur5_ros.analysis.identification.rows import rows_of
from ur5_ros.config import load_arm
from ur5_ros.config.arm_writer import arm_file_text
from ur5_ros.config.experiments import JointWaves
from ur5_ros.control.profiles import joint_waves
from ur5_ros.loop.closed_loop import run_closed_loop
from ur5_ros.loop.loop_run import as_run
from ur5_ros.loop.run_config import run_config
from ur5_ros.model.dynamics import inverse_dynamics
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.sim.urdf import urdf_text

#: Friction of the simulated arm, and noise of its encoders.
VISCOUS, COULOMB = [2.0, 2.0, 2.0, 0.5, 0.5, 0.5], [1.0, 1.0, 1.0, 0.2, 0.2, 0.1]
NOISE = {'noise.velocity': 1e-3, 'noise.position': 1e-5}

#: Control rate [Hz], and length of the pieces that mujoco rolls out [s].
RATE, PIECE = 500, 0.25

#: Most iterations of mujoco's optimiser.
ITERATIONS = 15

#: Recordings of the UR10e that are fitted, and the one that is predicted.
FITTED = ('ur-20_02_10-30sec_12harm.csv', 'ur-20_02_12-40sec_12harm.csv',
          'ur-20_02_12-50sec_12harm.csv')
TRIED = 'ur-20_01_17-ptp_10_points.csv'
UNLOADED, LOADED = 'ur-20_02_19_14harm50sec.csv', 'ur-20_02_19_14harm50secLoad.csv'
OTHER_UNLOADED = 'ur-20_02_19_15harm50sec.csv'

#: Load of the guided UR5e, which its own log declares [kg]; and time for an excitation [s].
GUIDED_LOAD, SEARCH = 1.28, 60.0

#: What the recordings' page says: torque [N m], current [A], Coulomb friction of the UR10 [N m].
TORQUE_BARS = (0.13, 0.18, 0.09, 0.015, 0.012, 0.008)
CURRENT_BARS = (0.634, 0.705, 0.444, 0.118, 0.143, 0.137)
UR10_COULOMB = (13.6, 14.6, 8.7, 3.0, 2.4, 2.6)


def changed_arm() -> ArmParameters:
    """Return ``ur5_real`` with other masses and centres of mass."""
    arm = load_arm('ur5_real')
    times = np.array([1.1, 0.9, 1.2, 0.85, 1.15, 1.1])
    return replace(arm, name='changed', mass=arm.mass * times, com=arm.com * 1.1,
                   inertia=arm.inertia * times[:, None, None])


def record(folder: Path, experiment: str, seconds: float, noise: dict[str, float]) -> Run:
    """Return a run of the changed arm."""
    file = folder / 'changed.yaml'
    file.write_text(arm_file_text(changed_arm(), 'An arm.', 'ur5_real, changed for this benchmark',
                                    'as ur5_real'))
    return as_run(run_closed_loop(run_config(
        experiment, str(file), control_arm='ur5_real', control_rate=RATE, duration=seconds,
        sim={'friction.viscous': VISCOUS, 'friction.coulomb': COULOMB, **noise})))


class Found(NamedTuple):
    """What an identification found."""

    torque: Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]
    """Torque of a motion without friction."""
    viscous: np.ndarray
    coulomb: np.ndarray


def errors_of(found: Found, run: Run) -> dict[str, float]:
    """Return the error of the torque on a motion as a share of it, and of friction, RMS."""
    q, qd, _ = run.states
    qdd = np.gradient(qd, 1.0 / RATE, axis=0)
    true = inverse_dynamics(q, qd, qdd, changed_arm())
    wrong = (found.torque(q, qd, qdd) - true) / np.sqrt(np.mean(true**2, axis=0))
    return {'torque': float(np.sqrt(np.mean(wrong**2))),
            'viscous': float(np.sqrt(np.mean((found.viscous - VISCOUS)**2))),
            'Coulomb': float(np.sqrt(np.mean((found.coulomb - COULOMB)**2)))}


def ours(run: Run) -> Found:
    """Return what ``identify`` finds from the measured states, beginning with ``ur5_real``."""
    found = identify([replace(run, truth=None)], load_arm('ur5_real'))
    return Found(lambda q, qd, qdd: inverse_dynamics(q, qd, qdd, found.arm), found.viscous,
                 found.coulomb)


class MujocoIdentification:
    """mujoco.sysid with the same freedom: bodies, rotors and friction of every joint."""

    def __init__(self, run: Run):
        import mujoco
        from mujoco import sysid
        self.mujoco, self.sysid = mujoco, sysid
        start = load_arm('ur5_real')
        spec = mujoco.MjSpec.from_string(urdf_text(start, bare=True))
        spec.option.timestep = 1.0 / RATE
        spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        spec.option.gravity = start.gravity
        self.names = [joint.name for joint in spec.joints]
        self.bodies = [joint.parent.name for joint in spec.joints]
        for i, joint in enumerate(spec.joints):
            joint.armature = float(start.armature[i])
            spec.add_actuator(name=f'motor_{i}', target=joint.name,
                              trntype=mujoco.mjtTrn.mjTRN_JOINT).set_to_motor()
        for prefix, kind in (('q', mujoco.mjtSensor.mjSENS_JOINTPOS),
                             ('qd', mujoco.mjtSensor.mjSENS_JOINTVEL)):
            for name in self.names:
                spec.add_sensor(name=f'{prefix}_{name}', type=kind, objname=name,
                                objtype=mujoco.mjtObj.mjOBJ_JOINT)
        self.spec, self.model = spec, spec.compile()
        self.sequences = self._sequences(run)

    def _sequences(self, run: Run):
        """Return the recording in pieces, each rolled out from its first measured state."""
        q, qd, effort = run.states
        length = round(PIECE * RATE)
        t, states, controls, sensors = np.arange(length) / RATE, [], [], []
        for first in range(0, len(q) - length - 1, length):
            rows = slice(first, first + length)
            states.append(self.sysid.create_initial_state(
                self.model, q[first], qd[first], np.zeros(0)))
            controls.append(self.sysid.TimeSeries(t, effort[first + 1:first + length + 1]))
            sensors.append(self.sysid.TimeSeries.from_names(
                t, np.hstack([q[rows], qd[rows]]), self.model))
        names = [f'piece_{i}' for i in range(len(states))]
        return self.sysid.ModelSequences('arm', self.spec, names, states, controls, sensors)

    def parameters(self):
        """Return the parameters with their bounds."""
        sysid, found = self.sysid, self.sysid.ParameterDict()
        for body in self.bodies:
            found.add(sysid.body_inertia_param(
                self.spec, self.model, body, inertia_type=sysid.InertiaType.Pseudo,
                modifier=lambda spec, p, b=body: _set_body(spec, b, p.value)))
        start = load_arm('ur5_real')
        for i, name in enumerate(self.names):
            for field, value, most in (('armature', float(start.armature[i]), 5.0),
                                       ('damping', 0.5, 20.0), ('frictionloss', 0.2, 20.0)):
                found.add(sysid.Parameter(
                    f'{name}_{field}', value, 1e-4, most,
                    modifier=lambda spec, p, n=name, f=field: _set_joint(spec, n, f, p.value[0])))
        return found

    def __call__(self) -> Found:
        """Return the torque of the model that was found, and its friction."""
        residual = self.sysid.build_residual_fn(models_sequences=[self.sequences])
        found, _ = self.sysid.optimize(
            initial_params=self.parameters(), residual_fn=residual, optimizer='mujoco',
            verbose=False, max_iters=ITERATIONS)
        spec = self.sysid.apply_param_modifiers_spec(found, self.spec.copy())
        model = spec.compile()
        damping, loss = model.dof_damping.copy(), model.dof_frictionloss.copy()
        model.dof_damping[:] = model.dof_frictionloss[:] = 0.0
        data = self.mujoco.MjData(model)

        def torque(q, qd, qdd):
            out = np.empty_like(q)
            for k in range(len(q)):
                data.qpos[:], data.qvel[:], data.qacc[:] = q[k], qd[k], qdd[k]
                self.mujoco.mj_inverse(model, data)
                out[k] = data.qfrc_inverse
            return out

        return Found(torque, damping, loss)


def _set_body(spec, name: str, theta: np.ndarray) -> None:
    """Set the body that mujoco's ten parameters stand for, tensor in principal axes."""
    from mujoco import mju_mat2Quat
    from mujoco.sysid._src.model_modifier import pi_from_theta
    pi = pi_from_theta(theta)
    body, mass = spec.body(name), pi[0]
    centre, about_origin = pi[1:4] / mass, pi[4:].reshape(3, 3)
    tensor = about_origin - mass * (centre @ centre * np.eye(3) - np.outer(centre, centre))
    moments, axes = np.linalg.eigh(0.5 * (tensor + tensor.T))
    axes *= [1.0, 1.0, np.sign(np.linalg.det(axes))]
    quaternion = np.zeros(4)
    mju_mat2Quat(quaternion, axes.ravel())
    body.mass, body.ipos, body.inertia, body.iquat = mass, centre, moments, quaternion


def _set_joint(spec, name: str, field: str, value: float) -> None:
    """Set a number of a joint, which MuJoCo keeps as one or as one a degree of freedom."""
    joint = spec.joint(name)
    current = getattr(joint, field)
    if np.ndim(current):
        current[0] = value
    else:
        setattr(joint, field, value)


def timed(name: str, work: Callable[[], Found], kept: dict[str, Found]) -> float:
    """Return the processor seconds of one identification; keep what it found."""
    start = time.process_time()
    kept[name] = work()
    return time.process_time() - start


def side_by_side(folder: Path, given) -> tuple[list[Row], dict[str, Any]]:
    """Return the rows of the comparison on one recording of a simulated arm."""
    run = record(folder, 'exciting', given.seconds, NOISE)
    tried = record(folder, 'multi_sine', 6.0, {})
    work = {'here': lambda: ours(run)}
    work['here']()  # loads the solver
    if not given.alone:
        work['mujoco'] = MujocoIdentification(run)
    found: dict[str, Found] = {}
    taken = interleave({name: lambda name=name, each=each: timed(name, each, found)
                        for name, each in work.items()}, given.repeats)
    errors = {name: errors_of(each, tried) for name, each in found.items()}
    minute = min(taken['here']) * 60.0 / given.seconds * 100.0 / RATE
    rows = [Row('identify, 60 s at 100 Hz', '10 s', minute / 10.0, 1.0, False,
                f'{min(taken["here"]):.1f} s of processor time for {given.seconds:g} s at '
                f'{RATE} Hz')]
    if 'mujoco' in taken:
        rows.append(Row('mujoco[sysid], processor time', 'identify', ratio(
            taken, 'mujoco', 'here'), 10.0, True,
            f'{min(taken["mujoco"]):.0f} s in at most {ITERATIONS} iterations, pieces of '
            f'{PIECE:g} s'))
        rows += [Row(f'error of {what}, identify', 'mujoco[sysid]',
                     errors['here'][what] / errors['mujoco'][what], 1.0, False,
                     f'{errors["here"][what]:.2g} and {errors["mujoco"][what]:.2g} {unit}')
                 for what, unit in (('torque', 'of the torque'), ('viscous', 'N m s/rad'),
                                    ('Coulomb', 'N m'))]
    return rows, {'seconds': taken, 'errors': errors}


def csv_run(path: Path) -> Run:
    """Return a recording of the UR10e: rows of 31 numbers, others passed over."""
    rows = []
    with open(path, encoding='utf-8') as file:
        for row in csv.reader(file):
            try:
                rows.append([float(number) for number in row])
            except ValueError:
                continue
    table = np.array([row for row in rows if len(row) == 31 and max(map(abs, row)) < 1e5])
    table = table[np.concatenate([[True], np.diff(table[:, 0]) > 0.0])]
    stamp = np.rint((table[:, 0] - table[0, 0]) * 1e9).astype(np.int64) + 1_000_000
    return Run(path.name, stamp, States(table[:, 1:7], table[:, 7:13], table[:, 25:31]), 100.0,
               current=table[:, 13:19])


def real_ur10e(folder: Path) -> tuple[list[Row], dict[str, Any]]:
    """Return the rows of the recordings of a real UR10e."""
    arm, runs = load_arm('ur10e'), {path.name: path for path in folder.rglob('*.csv')}
    found = identify([csv_run(runs[name]) for name in FITTED], arm, csv_run(runs[TRIED]))
    as_it_is = identify([csv_run(runs[FITTED[0]])], load_arm('ur10e_controller'),
                        csv_run(runs[TRIED]))
    loaded, none = (identify([csv_run(runs[UNLOADED])], arm, payload=csv_run(runs[name])).payload
                    for name in (LOADED, OTHER_UNLOADED))
    rotors = {name: identify([csv_run(path)], arm).arm.armature.tolist()
              for name, path in sorted(runs.items()) if 'harm' in name and 'Load' not in name}
    wrists = np.array(list(rotors.values()))[:, 3:]
    assert found.motors is not None and loaded is not None and none is not None
    rows = [
        *_bars('UR10e, torque held out, joint', found.test_rms, TORQUE_BARS, 'N m RMS'),
        *_bars('UR10e, current held out, joint', found.motors.current_rms, CURRENT_BARS, 'A RMS'),
        Row('UR10e, payload from current', '2.805 kg within 5 %',
            abs(loaded.mass / 2.805 - 1.0) / 0.05, 1.0, False,
            f'{loaded.mass:.3f} +- {loaded.mass_error:.2g} kg'),
        Row('UR10e, no payload, from current', '0 within 0.1 kg', abs(none.mass) / 0.1, 1.0, False,
            f'{none.mass:.3f} +- {none.mass_error:.2g} kg'),
        Row('UR10e, rotors of the wrists, from their median', '1 %',
            float(np.abs(wrists / np.median(wrists, axis=0) - 1.0).max()) / 0.01, 1.0, False)]
    return rows, {'ur10e': {'identified': found.to_plain(), 'rotors': rotors,
                            'begun with ur10e_controller': as_it_is.to_plain()['test'],
                            'payload': loaded.to_plain(), 'no payload': none.to_plain()}}


def real_ur10(bag: Path) -> tuple[list[Row], dict[str, Any]]:
    """Return the rows of the recording of a real UR10."""
    found = identify([load_run(bag, arm='ur10')], load_arm('ur10'))
    away = np.abs(found.coulomb / UR10_COULOMB - 1.0)
    return [Row('UR10, Coulomb friction, from a least squares of others', '10 %',
                float(away.max()) / 0.1, 1.0, False,
                ', '.join(f'{value:.3g}' for value in found.coulomb) + ' N m')], {
                    'ur10': found.to_plain()}


def guided(log: Path) -> tuple[list[Row], dict[str, Any]]:
    """Return the row of a UR5e that is guided by hand, its log one of ur_rtde."""
    with tempfile.TemporaryDirectory() as folder:
        import_log(log, Path(folder) / 'guided', 'ur5e')
        found = identify_payload(load_run(Path(folder) / 'guided'), load_arm('ur5e'))
    return [Row('UR5e guided by hand, payload from torque', f'{GUIDED_LOAD:g} kg within 3 %',
                abs(found.mass / GUIDED_LOAD - 1.0) / 0.03, 1.0, False,
                f'{found.mass:.3f} +- {found.mass_error:.2g} kg')], {'guided': found.to_plain()}


def excitation(folder: Path) -> tuple[list[Row], dict[str, Any]]:
    """Return the row of an excitation beside the optimised recordings of the UR10e."""
    arm = load_arm('ur10e')
    recorded = {path.name: condition_of(csv_run(path), arm)
                for path in sorted(folder.rglob('*harm*.csv'))}
    best = min(recorded, key=recorded.__getitem__)
    start = time.process_time()
    found = excite(arm, 20.0, SEARCH)
    taken = time.process_time() - start
    own = condition_of(motion_of(found.experiment, arm), arm)
    return [Row('excite, condition number', f'best of {len(recorded)} recordings',
                own / recorded[best], 0.8, False,
                f'{own:.3g} after {taken:.0f} s of processor time, {best}: '
                f'{recorded[best]:.3g}')], {'condition': {**recorded, 'excite': own}}


def motion_of(experiment: JointWaves, arm: ArmParameters) -> Run:
    """Return an excitation as if a UR10e had recorded it, with the torque of its model."""
    t = np.arange(0.0, experiment.duration, 0.01)
    q, qd, qdd = joint_waves(t, experiment)
    effort = inverse_dynamics(q + arm.angle_offset, qd, qdd, arm)
    return Run('excite', np.rint(t * 1e9).astype(np.int64) + 1_000_000, States(q, qd, effort),
               100.0)


def condition_of(run: Run, arm: ArmParameters) -> float:
    """Return the condition number of the regressor of a run, columns scaled to length one."""
    rows, base = rows_of([run], arm), base_of(arm)
    friction = [rows.friction[..., i, None] * np.eye(6) for i in range(LINEAR)]
    x = np.concatenate([rows.inertial[..., base.columns], *friction], axis=-1)
    x = x.reshape(-1, x.shape[-1])
    return float(np.linalg.cond(x / np.linalg.norm(x, axis=0)))


def _bars(what: str, values: np.ndarray, bars: Sequence[float], unit: str) -> list[Row]:
    return [Row(f'{what} {i + 1}', f'{bar:g} {unit}', float(value) / bar, 1.0, False,
                f'{value:.3g} {unit}')
            for i, (value, bar) in enumerate(zip(values, bars, strict=True))]


def main() -> None:
    options = arguments(__doc__, 1)
    options.add_argument('--seconds', type=float, default=20.0, help='length of the recording')
    options.add_argument('--alone', action='store_true', help='without mujoco[sysid]')
    options.add_argument('--ur10e', type=Path, help='folder dataset_ur10e of the recordings')
    options.add_argument('--guided', type=Path, help='log recorded_data.csv of a guided UR5e')
    options.add_argument('--ur10', type=Path, help='bag ur10_exciting_trajectory.db3')
    given = options.parse_args()
    if given.quick:
        given.seconds, given.alone = 15.0, True
    with tempfile.TemporaryDirectory() as folder:
        rows, more = side_by_side(Path(folder), given)
    for work, place in ((real_ur10e, given.ur10e), (guided, given.guided),
                        (real_ur10, given.ur10), (excitation, given.ur10e)):
        if place is not None:
            added, figures = work(place)
            rows, more = rows + added, {**more, **figures}
    publish('identification', 'Identification', rows, more, keep=not given.quick)


if __name__ == '__main__':
    main()
