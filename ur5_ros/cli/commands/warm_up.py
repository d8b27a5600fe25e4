"""The command ``ur5 warm-up``: compile the kernels for this processor, on all of its cores."""

import multiprocessing
import os
import time
from concurrent.futures import ProcessPoolExecutor, as_completed
from importlib import import_module
from signal import SIGTERM

from ur5_ros.cli import terminal
from ur5_ros.cli.exit_codes import SUCCESS
from ur5_ros.launcher.signals import end_with_parent
from ur5_ros.model.kernels.compile_notice import on_compile

_MODEL = 'ur5_ros.model.kernels'
#: Module and kernel; what takes longest is first.
#: These serve the demo, verdicts with and without a cause or friction, and nodes without a world.
KERNELS = (
    (f'{_MODEL}.inverse_kinematics', 'solve'),
    ('ur5_ros.control.kernel', 'law'),
    ('ur5_ros.sim.integrator_kernel', 'engine_torque'),
    ('ur5_ros.sim.integrator_kernel', 'friction'),
    (f'{_MODEL}.dynamics', 'inverse'),
    (f'{_MODEL}.kinematics', 'pose'),
    (f'{_MODEL}.dynamics', 'terms'),
    (f'{_MODEL}.regressor', 'regressor'),
    (f'{_MODEL}.dynamics', 'inertia'),
    (f'{_MODEL}.kinematics', 'jacobian_rate'),
    (f'{_MODEL}.kinematics', 'jacobian'),
    (f'{_MODEL}.dynamics', 'gravity'),
    (f'{_MODEL}.kinematics', 'links'),
)
#: These serve contact, force control, pictures and single calls, and take as long again.
FURTHER_KERNELS = (
    ('ur5_ros.sim.world.contact_kernel', 'contact_step'),
    ('ur5_ros.control.laws.impedance_kernel', 'impedance_torque'),
    ('ur5_ros.viewer.picture.ray_kernel', 'cast'),
    (f'{_MODEL}.forward_dynamics', 'forward'),
)


def warm_up(everything: bool) -> int:
    """Compile what is not in the cache yet; see ``ur5 warm-up --help``."""
    out, began = terminal.console(), time.monotonic()
    kernels = (*FURTHER_KERNELS, *KERNELS) if everything else KERNELS
    spawn = multiprocessing.get_context('spawn')
    workers = min(len(os.sched_getaffinity(0)), len(kernels))
    compiled = 0
    with terminal.progress('compiling for this processor', len(kernels), 'kernels') as advance, \
            ProcessPoolExecutor(workers, spawn, end_with_parent, (SIGTERM, os.getpid())) as pool:
        tasks = [pool.submit(compile_kernel, *each) for each in kernels]
        for done, task in enumerate(as_completed(tasks), 1):
            compiled += task.result()
            advance(done)
    seconds = time.monotonic() - began
    cached = '; the others were in the cache' if compiled < len(kernels) else ''
    terminal.show_text(out, f'{compiled} of {len(kernels)} kernels compiled in {seconds:.1f} s'
                       f'{cached}')
    return SUCCESS


def compile_kernel(module: str, name: str) -> bool:
    """Compile a kernel, or find it in the cache; return whether it was compiled."""
    compiled: list[str] = []
    on_compile(compiled.append)
    getattr(import_module(module), name).prepare()
    return bool(compiled)
