"""
The model against Pinocchio, MuJoCo, EAIK and ssik, side by side in one process.

    python benchmarks/bench_model.py [--json FILE] [--quick]

Each round times ours and theirs one after the other, so that both see the same machine; the ratio
is the median over the rounds.  Bars are upper limits of the ratio ours / theirs.  Start-up times
are wall clock, which a busy machine stretches; the processor time stands beside them.
"""

import argparse
import json
import os
import runpy
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from statistics import median
from time import perf_counter
from typing import NamedTuple

import child
import eaik.IK_DH
import numpy as np
import pinocchio as pin
import side_by_side
from rivals import mujoco_dynamics, ssik_kinematics

from ur5_ros.config import load_arm
from ur5_ros.model.dynamics import dynamics_terms, forward_dynamics, inverse_dynamics
from ur5_ros.model.inverse_kinematics import inverse_kinematics, inverse_kinematics_batch
from ur5_ros.model.kinematics import forward_kinematics
from ur5_ros.model.parameters import ArmParameters

BATCH = 100_000
pinocchio_model = runpy.run_path(
    str(Path(__file__).resolve().parents[1] / 'test' / 'witnesses.py'))['pinocchio_model']


class Row(NamedTuple):
    """One measured comparison."""

    what: str
    peer: str
    ours_us: float
    theirs_us: float
    ratio: float
    bar: float


def compare(what: str, peer: str, bar: float, ours: Callable[[], object],
            theirs: Callable[[], object], rounds: int, calls: tuple[int, int],
            states: int = 1) -> Row:
    """Time both in turn and return the medians, in microseconds a state."""
    times = []
    for function, n in ((ours, calls[0]), (theirs, calls[1])):
        for _ in range(max(1, n // 10)):
            function()
    for _ in range(rounds):
        pair = []
        for function, n in ((ours, calls[0]), (theirs, calls[1])):
            start = perf_counter()
            for _ in range(n):
                function()
            pair.append((perf_counter() - start) / n / states * 1e6)
        times.append(pair)
    return Row(what, peer, median(t[0] for t in times), median(t[1] for t in times),
               median(t[0] / t[1] for t in times), bar)


def single_calls(arm: ArmParameters, rounds: int) -> list[Row]:
    """Compare one state at a time, public functions with their checks."""
    model = pinocchio_model(arm)
    data = model.createData()
    q, qd, qdd = np.random.default_rng(1).uniform(-2.0, 2.0, (3, 6))
    calls = (200, 200)  # short, so that few rounds are interrupted

    def three():
        pin.crba(model, data, q)
        pin.computeCoriolisMatrix(model, data, q, qd)
        pin.computeGeneralizedGravity(model, data, q)

    pose = forward_kinematics(q, arm)
    robot = eaik.IK_DH.DhRobot(arm.alpha, arm.a, arm.d)
    rows = [
        compare('dynamics_terms (M, C, g)', 'pin.crba + computeCoriolisMatrix + '
                'computeGeneralizedGravity', 0.55, lambda: dynamics_terms(q, qd, arm), three,
                rounds, calls),
        compare('inverse_dynamics', 'pin.rnea', 0.95,
                lambda: inverse_dynamics(q, qd, qdd, arm),
                lambda: pin.rnea(model, data, q, qd, qdd), rounds, calls),
        compare('forward_dynamics', 'pin.aba', 0.75,
                lambda: forward_dynamics(q, qd, qdd, arm),
                lambda: pin.aba(model, data, q, qd, qdd), rounds, calls),
        compare('inverse_kinematics, all branches', 'EAIK IK', 0.4,
                lambda: inverse_kinematics(pose, arm), lambda: robot.IK(pose), rounds, calls),
    ]
    mujoco = mujoco_dynamics(arm, q, qd, qdd)
    if mujoco is not None:
        rows += [
            compare('inverse_dynamics', 'mujoco.mj_inverse', 0.5,
                    lambda: inverse_dynamics(q, qd, qdd, arm), mujoco[0], rounds, calls),
            compare('forward_dynamics', 'mujoco.mj_forward', 0.5,
                    lambda: forward_dynamics(q, qd, qdd, arm), mujoco[1], rounds, calls),
        ]
    ssik = ssik_kinematics(q - arm.angle_offset, len(inverse_kinematics(pose, arm).q))
    if ssik is not None:
        rows.append(compare('inverse_kinematics, all branches', "ssik's prebuilt UR5", 0.1,
                            lambda: inverse_kinematics(pose, arm), ssik, rounds, calls))
    return rows


def batches(arm: ArmParameters, rounds: int) -> list[Row]:
    """Compare arrays of states with a Python loop over Pinocchio, and EAIK's own batch."""
    model = pinocchio_model(arm)
    data = model.createData()
    q, qd, qdd = np.random.default_rng(2).uniform(-3.0, 3.0, (3, BATCH, 6))
    part = BATCH // 10  # the loops over the peers are linear: a tenth of the states tells

    def three():
        for a, b in zip(q[:part], qd[:part], strict=True):
            pin.crba(model, data, a)
            pin.computeCoriolisMatrix(model, data, a, b)
            pin.computeGeneralizedGravity(model, data, a)

    def rnea():
        for a, b, c in zip(q[:part], qd[:part], qdd[:part], strict=True):
            pin.rnea(model, data, a, b, c)

    def aba():
        for a, b, c in zip(q[:part], qd[:part], qdd[:part], strict=True):
            pin.aba(model, data, a, b, c)

    poses = forward_kinematics(q, arm)
    robot = eaik.IK_DH.DhRobot(arm.alpha, arm.a, arm.d)
    rows = []
    for what, peer, bar, ours, theirs in (
        ('dynamics_terms', 'a Python loop over Pinocchio', 0.1,
         lambda: dynamics_terms(q, qd, arm), three),
        ('inverse_dynamics', 'a Python loop over pin.rnea', 0.1,
         lambda: inverse_dynamics(q, qd, qdd, arm), rnea),
        ('forward_dynamics', 'a Python loop over pin.aba', 0.1,
         lambda: forward_dynamics(q, qd, qdd, arm), aba),
        ('inverse_kinematics_batch', 'EAIK IK_batched', 1 / 8,
         lambda: inverse_kinematics_batch(poses, arm),
         lambda: robot.IK_batched(poses[:part])),
    ):
        row = compare(f'{what}, {BATCH} states', peer, bar, ours, theirs, rounds, (1, 1), part)
        tenth = part / BATCH
        rows.append(row._replace(ours_us=row.ours_us * tenth, ratio=row.ratio * tenth))
    return rows


def start_up() -> list[dict]:
    """Time import with a warm cache, and the first calls where nothing is cached."""
    imports = ('import ur5_ros.model.dynamics, ur5_ros.model.kinematics, '
               'ur5_ros.model.inverse_kinematics\n')
    first = (f'{imports}import numpy as np\nfrom ur5_ros.config import load_arm\n'
             'arm = load_arm("ur5")\nx = np.ones(6)\n{start}'
             'ur5_ros.model.dynamics.dynamics_terms(x, x, arm)\n'
             'ur5_ros.model.dynamics.inverse_dynamics(x, x, x, arm)\n'
             'ur5_ros.model.dynamics.forward_dynamics(x, x, x, arm)\n'
             'T = ur5_ros.model.kinematics.forward_kinematics(x, arm)\n'
             'ur5_ros.model.inverse_kinematics.inverse_kinematics(T, arm)\n')
    start = ('from time import perf_counter, process_time\n'
             'wall, cpu = perf_counter(), process_time()\n')
    stop = 'print(perf_counter() - wall, process_time() - cpu)'
    with tempfile.TemporaryDirectory() as folder:
        fresh = {**os.environ, 'NUMBA_CACHE_DIR': folder}
        cold = _run(first.replace('{start}', start) + stop, fresh)
        warm = min(_run(start + imports + stop, fresh) for _ in range(7))
    return [{'what': 'import of the model, warm cache', 'seconds': warm[0],
             'processor_seconds': warm[1], 'bar': 1.0},
            {'what': 'first calls of five functions, no cache', 'seconds': cold[0],
             'processor_seconds': cold[1], 'bar': 30.0}]


def _run(code: str, environment: dict[str, str]) -> tuple[float, float]:
    done = child.call([sys.executable, '-c', code], env=environment, capture_output=True,
                      text=True)
    wall, cpu = map(float, done.stdout.split())
    return wall, cpu


def main() -> int:
    """Measure, print the table, write the JSON; exit code 1 where a bar is missed."""
    parser = argparse.ArgumentParser(description=__doc__.strip().splitlines()[0])
    parser.add_argument('--json', type=Path, help='write the ratios to this file')
    parser.add_argument('--quick', action='store_true', help='fewer rounds, no start-up times')
    parser.add_argument('--arm', default='ur5')
    options = parser.parse_args()
    arm = load_arm(options.arm)
    rows = single_calls(arm, 151 if options.quick else 1001)
    rows += batches(arm, 3 if options.quick else 9)
    print(f'| ours ({options.arm}) | peer | ours us | theirs us | ratio | bar | |\n'
          '|---|---|---|---|---|---|---|')
    for row in rows:
        verdict = 'met' if row.ratio <= row.bar else 'MISSED'
        print(f'| {row.what} | {row.peer} | {row.ours_us:.3f} | {row.theirs_us:.3f} '
              f'| {row.ratio:.3f} | {row.bar:.3g} | {verdict} |')
    starts = [] if options.quick else start_up()
    for start in starts:
        print(f'| {start["what"]} | | {start["seconds"]:.2f} s '
              f'(processor {start["processor_seconds"]:.2f} s) | | | {start["bar"]} s '
              f'| {"met" if start["seconds"] <= start["bar"] else "MISSED"} |')
    if not options.quick:
        side_by_side.publish(f'model_{options.arm}', f'The model, one call ({options.arm})', [
            side_by_side.Row(row.what, row.peer, row.ratio, row.bar, False,
                             f'{row.ours_us:.2f} us against {row.theirs_us:.2f} us')
            for row in rows])
    if options.json:
        options.json.write_text(json.dumps(
            {'arm': options.arm, 'ratios': [row._asdict() for row in rows], 'start_up': starts},
            indent=1))
    met = all(row.ratio <= row.bar for row in rows)
    return 0 if met and all(start['seconds'] <= start['bar'] for start in starts) else 1


if __name__ == '__main__':
    sys.exit(main())
