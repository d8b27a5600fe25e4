"""The command ``ur5 warm-up``: compile the kernels for this processor, on all of its cores."""

import multiprocessing
import os
import time
from concurrent.futures import ProcessPoolExecutor, as_completed
from importlib import import_module
from signal import SIGTERM

from ur5_ros.cli import terminal
from ur5_ros.cli.exit_codes import YES
from ur5_ros.launcher.signals import end_with_parent
from ur5_ros.model.kernels.compile_notice import on_compile

_MODEL = 'ur5_ros.model.kernels'
#: Module, kernel and whether its form for many states is needed; what takes longest is first.
#: These serve the demo, any verdict, also one that names a cause, and nodes without a world.
KERNELS = (
    (f'{_MODEL}.inverse_kinematics', 'solve', True),
    ('ur5_ros.control.kernel', 'law', False),
    (f'{_MODEL}.dynamics', 'inverse', True),
    (f'{_MODEL}.kinematics', 'pose', True),
    (f'{_MODEL}.regressor', 'regressor', True),
    (f'{_MODEL}.dynamics', 'inertia', True),
    (f'{_MODEL}.kinematics', 'jacobian_rate', True),
    (f'{_MODEL}.kinematics', 'jacobian', True),
    ('ur5_ros.sim.integrator_kernel', 'engine_torque', False),
    ('ur5_ros.sim.integrator_kernel', 'friction', False),
    (f'{_MODEL}.dynamics', 'gravity', False),
    (f'{_MODEL}.dynamics', 'gravity', True),
    (f'{_MODEL}.kinematics', 'links', True),
)
#: These serve contact, force control, pictures and single calls, and take as long again.
FURTHER_KERNELS = (
    ('ur5_ros.sim.world.contact_kernel', 'contact_step', False),
    ('ur5_ros.control.laws.impedance_kernel', 'impedance_torque', False),
    ('ur5_ros.viewer.picture.ray_kernel', 'cast', False),
    (f'{_MODEL}.forward_dynamics', 'forward', False),
    (f'{_MODEL}.dynamics', 'terms', False),
    (f'{_MODEL}.dynamics', 'terms', True),
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
    return YES


def compile_kernel(module: str, name: str, many: bool) -> bool:
    """Compile a kernel, or find it in the cache; return whether it was compiled."""
    compiled: list[str] = []
    on_compile(compiled.append)
    kernel = getattr(import_module(module), name)
    if many:
        kernel.prepare_many()
    else:
        kernel.prepare()
    return bool(compiled)
