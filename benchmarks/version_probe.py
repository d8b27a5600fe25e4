"""
What one checkout takes for its work: figures as JSON, for ``versions.py``.

Run by the Python of that checkout; it knows the names of version 0.1 and of this one.
``python version_probe.py GROUP SCALE`` prints a group of figures; a scale below 1 takes fewer
calls.  As a node (``python -m version_probe`` with the variable VERSION_PROBE) it is that node
with a clock around each step of the plant or each update of the controller.
"""

import json
import os
import runpy
import signal
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median
from typing import Any

#: The node that this process is: ``sim`` or ``control``, the file for the times, and whether the
#: fast ways of version 0.1 are left out.
NODE = 'VERSION_PROBE'

if NODE in os.environ:  # as the nodes do before they import anything that starts a thread
    signal.pthread_sigmask(signal.SIG_BLOCK, (signal.SIGINT, signal.SIGTERM, signal.SIGHUP))
    os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')

import numpy as np  # noqa: E402  after the signals

#: Control periods that are measured, after those that warm up.
PERIODS, FIRST = 3000, 300
DURATION = 5.0
#: Numbers that are read to leave the caches of a core with nothing else: 8 MB.
CACHES = 1_000_000
CONFIGURATIONS = {
    'a command within the limits': {},
    'with friction': {'friction.viscous': [1.0] * 6, 'friction.coulomb': [1.0] * 6},
    'with noise and delays': {'noise.position': 1e-6, 'noise.velocity': 1e-6,
                              'delay.command_periods': 1, 'delay.state_periods': 1},
    'gravity left out of commands': {'effort_convention': 'gravity_excluded'},
}
#: Where both nodes run.
ONE_CORE, ANY_CORE = 'two nodes, both on one core', 'two nodes, on any core'
QUIET_DEMO, ONE_PROCESS = 'the demo, as it runs on a quiet machine', 'both nodes in one process'
MODULES = {'sim': 'ur5_ros.nodes.sim_node', 'control': 'ur5_ros.nodes.control_node'}

try:
    from ur5_ros.control.controller import controller_from_parameters as new_controller
    from ur5_ros.sim.plant import plant_from_parameters as new_plant
    GENERAL_ALONE = False
except ImportError:  # version 0.1
    GENERAL_ALONE = True
    from ur5_ros.config import SIM_PARAMETERS, complete
    from ur5_ros.control.controller import Controller
    from ur5_ros.sim.plant import plant_from_parameters

    def new_controller(parameters: dict[str, Any], rate: int) -> Controller:
        return Controller(parameters, rate)

    def new_plant(parameters: dict[str, Any]) -> Any:
        return plant_from_parameters(complete(SIM_PARAMETERS, parameters))


def leave_out_fast_ways() -> None:
    """Let version 0.1 do all by its general way; there is one way alone since then."""
    if GENERAL_ALONE:
        from ur5_ros.control.controller import Controller
        from ur5_ros.sim.plant import Plant
        Plant.takes = lambda self, tau: False
        Controller._ordinary_answer = lambda self, state: None


def start_of_experiment() -> list[float]:
    """Return the joint positions at which the paper's experiment begins."""
    from ur5_ros.config import load_arm
    from ur5_ros.config.experiments import load_experiment
    from ur5_ros.control.experiment import initial_positions
    return initial_positions(load_experiment('kebria_fig11'), load_arm('ur5')).tolist()


class Loop:
    """Plant and law in turn on the paper's experiment, with a clock around each."""

    def __init__(self, sim: dict[str, Any], periods: int, cold: bool = False) -> None:
        convention = {key: value for key, value in sim.items() if key == 'effort_convention'}
        self._plant = new_plant({'initial_positions': start_of_experiment(), **sim})
        self._controller = new_controller(
            {'experiment': 'kebria_fig11', 'autostart': True, **convention}, 1000)
        self._periods, self._caches = FIRST + periods, np.ones(CACHES if cold else 1)

    def times(self, step: Callable[[Any, np.ndarray], Any]) -> tuple[float, float]:
        """Return the median times of a step and an update [s]."""
        state, steps, updates = self._plant.state, [], []
        for _ in range(self._periods):
            self._caches.sum()
            begin = time.perf_counter_ns()
            output = self._controller.update(state)
            updates.append(time.perf_counter_ns() - begin)
            torque = output.torque.total
            self._caches.sum()
            begin = time.perf_counter_ns()
            step(self._plant, torque)
            steps.append(time.perf_counter_ns() - begin)
            state = self._plant.state
        self._plant.close()
        return median(steps[FIRST:]) * 1e-9, median(updates[FIRST:]) * 1e-9


    def engine_time(self) -> float:
        """Return the median time of PyBullet's own calls within a step [s]."""
        bullet, times = self._plant.mechanics.bullet, []
        advance = bullet.advance

        def clocked(tau: Any) -> Any:
            begin = time.perf_counter_ns()
            result = advance(tau)
            times.append(time.perf_counter_ns() - begin)
            return result

        bullet.advance = clocked
        self.times(lambda plant, torque: plant.step(torque))
        return median(times[FIRST:]) * 1e-9


def fast_step(plant: Any, torque: np.ndarray) -> None:
    """Take a step as the nodes of version 0.1 took most of theirs."""
    tau = tuple(torque.tolist())
    assert plant.takes(tau) and plant.step_plainly(tau) is not None


def loops(scale: float) -> dict[str, float]:
    """Return the times of a step and an update in each configuration [s]."""
    periods, found = int(PERIODS * scale), {}
    if GENERAL_ALONE:
        usual = next(iter(CONFIGURATIONS))
        found[f'fast copy of step, {usual}'], found[f'fast copy of update, {usual}'] = Loop(
            {}, periods).times(fast_step)
    leave_out_fast_ways()
    configurations = {name: (sim, False) for name, sim in CONFIGURATIONS.items()}
    configurations['caches emptied before each call'] = ({}, True)
    for name, (sim, cold) in configurations.items():
        found[f'step, {name}'], found[f'update, {name}'] = Loop(sim, periods, cold).times(
            lambda plant, torque: plant.step(torque))
        if not GENERAL_ALONE and not sim:
            found[f'PyBullet alone in step, {name}'] = Loop(sim, periods, cold).engine_time()
    return found


def runs(scale: float) -> dict[str, float]:
    """Return the time of a period of the loop without ROS [s]: as runs take it, and in full."""
    if GENERAL_ALONE:
        from ur5_ros.loop.closed_loop import full_loop, run_closed_loop
        from ur5_ros.loop.plan import plan_run as config
    else:
        from ur5_ros.loop.closed_loop import full_loop, run_closed_loop
        from ur5_ros.loop.run_config import run_config as config
    plan, found = config(duration=DURATION * scale), {}
    for name, run in (('a run', run_closed_loop), ('plant and controller', full_loop)):
        run(plan)
        begin = time.perf_counter()
        run(plan)
        found[f'period of the loop without ROS, {name}'] = (
            (time.perf_counter() - begin) / plan.periods)
    return found


def model(scale: float) -> dict[str, float]:
    """Return the times of the model's functions for a state, and for each of many [s]."""
    from ur5_ros.config import load_arm
    from ur5_ros.model.dynamics import dynamics_terms, forward_dynamics, inverse_dynamics
    from ur5_ros.model.inverse_kinematics import inverse_kinematics
    from ur5_ros.model.kinematics import forward_kinematics, jacobian
    arm, rng = load_arm('ur5'), np.random.default_rng(0)
    q, qd, x = rng.normal(size=(3, 6))
    many = rng.normal(size=(3, 100_000, 6))
    pose = forward_kinematics(q, arm)
    calls: dict[str, tuple[Callable[[], object], int]] = {
        'M, C and g of a state': (lambda: dynamics_terms(q, qd, arm), 1),
        'inverse dynamics of a state': (lambda: inverse_dynamics(q, qd, x, arm), 1),
        'forward dynamics of a state': (lambda: forward_dynamics(q, qd, x, arm), 1),
        'tool pose of a state': (lambda: forward_kinematics(q, arm), 1),
        'Jacobian of a state': (lambda: jacobian(q, arm), 1),
        'inverse kinematics of a pose': (lambda: inverse_kinematics(pose, arm), 1),
        'inverse dynamics of 100,000': (lambda: inverse_dynamics(*many, arm), 100_000),
        'forward dynamics of 100,000': (lambda: forward_dynamics(*many, arm), 100_000),
    }
    return {name: timed(call, states, scale) / states for name, (call, states) in calls.items()}


def timed(call: Callable[[], object], states: int, scale: float) -> float:
    """Return the median time of a call [s]."""
    number = max(3, int((20 if states > 1 else 20_000) * scale))
    times = []
    for _ in range(number):
        begin = time.perf_counter_ns()
        call()
        times.append(time.perf_counter_ns() - begin)
    return median(times[number // 10:]) * 1e-9


def two_nodes(scale: float) -> dict[str, float]:
    """Return the time of a period of both nodes, and of step and update within them [s]."""
    found = {f'period of {where}': run_nodes(DURATION * scale, where)[0]
             for where in placements()}
    period, times = run_nodes(DURATION * scale, general=True)
    return found | {
        'period of two nodes, general way': period,
        'step within the node, general way': times['sim'],
        'update within the node, general way': times['control']}


def placements() -> dict[str, tuple[str | None, dict[str, Any]]]:
    """Return where the nodes run: by name, UR5_ROS_CORE and more that ``run_two_nodes`` takes."""
    one_core, any_core = (str(max(os.sched_getaffinity(0))), {}), ('', {})
    if GENERAL_ALONE:  # on a quiet machine its demo had both on one core
        return {ONE_CORE: one_core, ANY_CORE: any_core, QUIET_DEMO: one_core}
    from ur5_ros.launcher.node_processes import lockstep_cores
    return {ONE_CORE: one_core, ANY_CORE: any_core,
            QUIET_DEMO: (None, {'environments': lockstep_cores(0.0)}),
            ONE_PROCESS: (None, {'composed': True})}


def run_nodes(seconds: float, where: str = ONE_CORE, general: bool = False,
              ) -> tuple[float, dict[str, float]]:
    """Return the mean time of a period, and the median ones of a step and an update [s]."""
    if GENERAL_ALONE:
        from ur5_ros.loop.plan import plan_run as config
        from ur5_ros.loop.processes import NodeProcesses
        from ur5_ros.loop.two_nodes import run_two_nodes
    else:
        from ur5_ros.launcher.node_processes import NodeProcesses
        from ur5_ros.launcher.two_nodes import run_two_nodes
        from ur5_ros.loop.run_config import run_config as config
    from ur5_ros.bag.reader import open_bag
    core, more = placements()[where]
    os.environ.pop('UR5_ROS_CORE', None)
    if core is not None:
        os.environ['UR5_ROS_CORE'] = core
    start = NodeProcesses.start
    with tempfile.TemporaryDirectory(prefix='ur5-bench-') as name:
        folder = Path(name)
        files = {node: folder / f'{node}.npy' for node in MODULES}

        def start_timed(self: Any, node: str, module: str, parameters: Any, **rest: Any) -> None:
            self.environment['PYTHONPATH'] = str(Path(__file__).parent)
            self.environment[NODE] = json.dumps([node, str(files[node]), general])
            start(self, node, 'version_probe', parameters, **rest)

        if general:
            NodeProcesses.start = start_timed
        try:
            run_two_nodes(config(duration=seconds), folder, **more)
        finally:
            NodeProcesses.start = start
        sent = np.sort(open_bag(folder / 'sim').columns('/joint_states').log_time)
        period = float(np.mean(np.diff(sent[len(sent) // 10:]))) * 1e-9
        return period, {node: median(np.load(file)[FIRST:]) * 1e-9
                        for node, file in files.items() if general}


def be_a_node() -> None:
    """Be the node that the environment names, with a clock around what it computes."""
    node, file, general = json.loads(os.environ[NODE])
    if general:
        leave_out_fast_ways()
    if node == 'sim':
        from ur5_ros.sim.plant import Plant as timed_class
        name = 'step'
    else:
        from ur5_ros.control.controller import Controller as timed_class
        name = 'update'
    function, times = getattr(timed_class, name), []

    def clocked(self: Any, given: Any) -> Any:
        begin = time.perf_counter_ns()
        result = function(self, given)
        times.append(time.perf_counter_ns() - begin)
        if len(times) % 500 == 0:
            np.save(file, times)
        return result

    setattr(timed_class, name, clocked)
    runpy.run_module(MODULES[node], run_name='__main__')


def main() -> None:
    """Print the figures of the group that the command line names."""
    group, scale = sys.argv[1], float(sys.argv[2])
    if group in ('loops', 'runs', 'model'):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    print(json.dumps({'loops': loops, 'runs': runs, 'model': model,
                      'two_nodes': two_nodes}[group](scale)))


if __name__ == '__main__':
    be_a_node() if NODE in os.environ else main()
