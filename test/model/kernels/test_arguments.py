"""What the public functions take and refuse, and how one state relates to many."""

import os
import shutil
import subprocess
import sys
import textwrap
import threading
from pathlib import Path

import numba
import numpy as np
import pytest

from ur5_ros.config import load_arm
from ur5_ros.model import dynamics, energy, kinematics
from ur5_ros.model.kernels import compiled
from ur5_ros.model.kernels.base_parameters import pack
from ur5_ros.model.kernels.kernel_cache import compiled_sources, seems_cached

FUNCTIONS = [
    (kinematics.forward_kinematics, 1, (4, 4)), (kinematics.link_transforms, 1, (6, 4, 4)),
    (kinematics.jacobian, 1, (6, 6)), (kinematics.jacobian_rate, 2, (6, 6)),
    (dynamics.inertia_matrix, 1, (6, 6)), (dynamics.coriolis_matrix, 2, (6, 6)),
    (dynamics.gravity_torque, 1, (6,)), (dynamics.inverse_dynamics, 3, (6,)),
    (dynamics.forward_dynamics, 3, (6,)), (energy.kinetic_energy, 2, ()),
    (energy.potential_energy, 1, ()),
]
NAMES = {1: ['q'], 2: ['q', 'qd'], 3: ['q', 'qd', None]}
IDS = [function.__name__ for function, _, _ in FUNCTIONS]


def arguments(count, shape):
    return list(np.random.default_rng(1).uniform(-2.0, 2.0, (count, *shape, 6)))


@pytest.mark.parametrize(('function', 'count', 'tail'), FUNCTIONS, ids=IDS)
def test_one_state_and_some_give_the_same_bits(function, count, tail):
    arm = load_arm('ur5_real')
    some = arguments(count, (100,))
    out = function(*some, arm)
    assert out.shape == (100, *tail)
    for i in (0, 5, 99):
        np.testing.assert_array_equal(function(*(x[i] for x in some), arm), out[i])


@pytest.mark.parametrize(('function', 'count', 'tail'), FUNCTIONS, ids=IDS)
@pytest.mark.parametrize('extra', [0, 1, 7, 13])
def test_many_states_on_all_processors_give_the_same_bits(function, count, tail, extra):
    arm = load_arm('ur5_real')
    size = compiled.HOT_PARALLEL_STATES + extra
    many = arguments(count, (size,))
    out = function(*many, arm)
    parts = np.concatenate([function(*(x[i:i + 500] for x in many), arm)
                            for i in range(0, size, 500)])
    assert out.shape == parts.shape == (size, *tail)
    np.testing.assert_array_equal(out, parts)


@pytest.mark.parametrize(('function', 'count', 'tail'), FUNCTIONS, ids=IDS)
def test_leading_dimensions_broadcast(function, count, tail):
    arm = load_arm('ur5')
    given = arguments(count, (3, 4))
    given[0] = given[0][:, :1]
    lead = (3, 4) if count > 1 else (3, 1)
    out = function(*given, arm)
    assert out.shape == lead + tail
    one = function(*(np.broadcast_to(x, (3, 4, 6))[2, 0] for x in given), arm)
    np.testing.assert_array_equal(out[2, 0], one)
    assert function(*(np.zeros((0, 6)) for _ in given), arm).shape == (0, *tail)


@pytest.mark.parametrize(('function', 'count', 'tail'), FUNCTIONS, ids=IDS)
def test_lists_integers_slices_and_read_only_arrays_are_taken(function, count, tail):
    arm = load_arm('ur5')
    given = [np.round(x) for x in arguments(count, ())]
    desired = function(*given, arm)
    strided = [np.repeat(x, 2)[::2] for x in given]
    locked = [x.copy() for x in given]
    for x in locked:
        x.flags.writeable = False
    for form in ([x.tolist() for x in given], [x.astype(int) for x in given], strided, locked):
        np.testing.assert_array_equal(function(*form, arm), desired)


@pytest.mark.parametrize(('function', 'count', 'tail'), FUNCTIONS, ids=IDS)
@pytest.mark.parametrize('lead', [(), (2,)])
def test_bad_numbers_are_refused_by_name(function, count, tail, lead):
    arm = load_arm('ur5')
    for which in range(count):
        name = NAMES[count][which] or 'qdd|tau'
        for value in (np.nan, np.inf, -np.inf):
            for joint in range(6):
                given = arguments(count, lead)
                given[which][..., joint] = value
                with pytest.raises(ValueError, match=rf'^({name})\[.*{joint}\] is .*finite'):
                    function(*given, arm)
        given = arguments(count, lead)
        given[which] = given[which][..., :5]
        with pytest.raises(ValueError, match=rf'^({name}) has shape .*; give \(\.\.\., 6\)'):
            function(*given, arm)
        given[which] = ['a'] * 6
        with pytest.raises(ValueError, match=rf'^({name}) is no array of real numbers'):
            function(*given, arm)


def test_leading_dimensions_that_do_not_match_are_named():
    with pytest.raises(ValueError, match=r'do not match: q \(2, 6\), qd \(3, 6\)'):
        dynamics.coriolis_matrix(np.zeros((2, 6)), np.zeros((3, 6)), load_arm('ur5'))


def test_numbers_too_large_for_a_finite_result_are_refused():
    arm, q = load_arm('ur5'), np.zeros(6)
    for lead in ((), (3,), (compiled.HOT_PARALLEL_STATES,)):
        large = np.full((*lead, 6), 1e200)
        with pytest.raises(ValueError, match='q, qd, qdd: numbers so large'):
            dynamics.inverse_dynamics(q, large, q, arm)
        for function, count, _ in FUNCTIONS:
            if count == 1:
                with pytest.raises(ValueError, match='q: numbers so large'):
                    function(large, arm)


@pytest.mark.parametrize('where', [0, 517, compiled.HOT_PARALLEL_STATES + 2])
def test_a_bad_number_among_many_states_is_named(where):
    arm = load_arm('ur5')
    for function, count, _ in FUNCTIONS:
        for which in range(count):
            given = arguments(count, (compiled.HOT_PARALLEL_STATES + 3,))
            given[which][where, 4] = np.nan
            with pytest.raises(ValueError, match=rf'\[{where}, 4\] is nan'):
                function(*given, arm)


def test_threads_may_call_at_the_same_time():
    arm = load_arm('ur5')
    q, qd, qdd = arguments(3, (5000,))
    many = dynamics.inverse_dynamics(q, qd, qdd, arm)
    desired = np.array([dynamics.inverse_dynamics(*x, arm) for x in zip(q, qd, qdd, strict=True)])
    wrong = []

    def work():
        for i in range(0, 5000, 5):
            if not np.array_equal(dynamics.inverse_dynamics(q[i], qd[i], qdd[i], arm), desired[i]):
                wrong.append(i)
        if not np.array_equal(dynamics.inverse_dynamics(q, qd, qdd, arm), many):
            wrong.append('all')

    threads = [threading.Thread(target=work) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not wrong


def test_constants_are_derived_once_for_a_record():
    arm = load_arm('ur5')
    assert arm.constants is arm.constants
    np.testing.assert_array_equal(arm.constants, pack(arm))


def run(code, **environment):
    done = subprocess.run([sys.executable, '-c', textwrap.dedent(code)], capture_output=True,
                          text=True, env={**os.environ, **environment})
    assert done.returncode == 0, done.stderr
    return done.stdout


CALL = """
import numpy as np
from ur5_ros.config import load_arm
from ur5_ros.model.dynamics import gravity_torque
print(gravity_torque(np.ones(6), load_arm('ur5')).tolist())
"""


def test_without_a_folder_to_write_the_kernels_still_work():
    desired = str(dynamics.gravity_torque(np.ones(6), load_arm('ur5')).tolist())
    no_folder = 'from numba.core import caching\ncaching.CacheImpl._locator_classes = []\n'
    assert run(no_folder + CALL).strip() == desired


SORT = """
import numba
@numba.njit
def least(x):
    return np.sort(x)[0]
print(least(np.array([3.0, 1.0, 2.0])))
"""


@pytest.fixture(scope='module')
def filled(tmp_path_factory):
    """Return a cache that a process has filled, and what the process printed."""
    folder = tmp_path_factory.mktemp('cache')
    return folder, run(CALL + SORT, NUMBA_CACHE_DIR=str(folder))


@pytest.fixture
def cache(filled, tmp_path):
    """Return a copy of the cache, times of files included, as Numba compares them."""
    return shutil.copytree(filled[0], tmp_path / 'cache')


def test_compiled_kernels_are_kept_and_taken_from_the_cache(cache):
    kept = sorted(cache.rglob('*.nbc'))
    assert kept
    count = """
    from numba.core import dispatcher
    compiled = []
    old = dispatcher._FunctionCompiler.compile
    dispatcher._FunctionCompiler.compile = lambda *a: compiled.append(a) or old(*a)
    """
    again = run(textwrap.dedent(count) + CALL + 'print(len(compiled))', NUMBA_CACHE_DIR=str(cache))
    assert again.split()[-1] == '0'
    assert sorted(cache.rglob('*.nbc')) == kept


def test_a_helper_is_compiled_once_for_all_whole_numbers():
    @compiled.inlined
    def entry(x, i):
        return x[i]

    ends = numba.njit(lambda x: entry(x, 0) + entry(x, 2))
    assert ends(np.array([1.0, 2.0, 4.0])) == 5.0
    assert len(entry.signatures) == 1


def test_a_kernel_that_allocates_is_not_compiled():
    """Then no call counts references, which took up to half of its time."""
    @compiled.kernel(compiled.R1, compiled.W1)
    def doubled(x, y):
        y[:] = np.full(x.size, 2.0) * x
        return 0

    with pytest.raises(numba.TypingError, match='function full'):
        doubled.prepare()


def test_nothing_is_collected_while_a_kernel_is_compiled(tmp_path):
    watch = """
    import gc
    from ur5_ros.model.kernels.compile_notice import on_compile
    on_compile(lambda name: print(gc.isenabled()))
    """
    printed = run(textwrap.dedent(watch) + CALL + 'print(gc.isenabled())',
                  NUMBA_CACHE_DIR=str(tmp_path)).splitlines()
    assert (printed[0], printed[-1]) == ('False', 'True')


def test_a_damaged_cache_does_no_harm(filled, cache):
    desired = filled[1].splitlines()[0]
    for path in cache.rglob('*.nbi'):
        path.write_bytes(b'damaged')
    assert run(CALL, NUMBA_CACHE_DIR=str(cache)).strip() == desired
    for path in cache.rglob('*.nb?'):
        path.write_bytes(path.read_bytes()[:100])
    assert run(CALL, NUMBA_CACHE_DIR=str(cache)).strip() == desired


def test_kernels_count_as_kept_while_no_file_that_is_compiled_is_newer(tmp_path, monkeypatch):
    monkeypatch.setenv('NUMBA_CACHE_DIR', str(tmp_path))
    module = Path('sim/some_kernel.py')
    kept = tmp_path / 'sim_0' / 'some_kernel.f-1.nbi'
    kept.parent.mkdir()
    assert not seems_cached(module)
    kept.touch()
    newest = max(path.stat().st_mtime for path, _ in compiled_sources())
    for second, expected in ((1.0, True), (-1.0, False)):
        os.utime(kept, (newest + second,) * 2)
        assert seems_cached(module) is expected
    compiled_names = {path.name for path, _ in compiled_sources()}
    assert {'integrator_kernel.py', 'compiled.py'} <= compiled_names
    assert 'plant.py' not in compiled_names


def test_a_changed_source_file_makes_the_cache_stale(monkeypatch):
    before = compiled.source_digest()
    reads = type(Path()).read_bytes
    monkeypatch.setattr(type(Path()), 'read_bytes', lambda path: reads(path) + b' ')
    compiled.source_digest.cache_clear()  # read once in a process
    assert compiled.source_digest() != before
    compiled.source_digest.cache_clear()


def test_taking_kernels_from_the_cache_leaves_the_compiler_unloaded(cache):
    ask = 'import sys\nprint("numba.np.linalg" in sys.modules)'
    assert run(CALL + ask, NUMBA_CACHE_DIR=str(cache)).split()[-1] == 'False'


def test_what_users_compile_is_declared_all_the_same(filled, cache):
    for printed in (filled[1], run(CALL + SORT, NUMBA_CACHE_DIR=str(cache))):
        assert printed.split()[-1] == '1.0'


def test_importing_the_model_parameters_does_not_import_numba():
    code = 'import sys\nimport ur5_ros.config\nprint("numba" in sys.modules)'
    assert run(code).strip() == 'False'
