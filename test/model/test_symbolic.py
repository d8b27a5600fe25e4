"""The formulas, at 50 digits, agree with the kernels; so does the code written from them."""

import ctypes
import re
import shutil
import subprocess

import mpmath
import numpy as np
import pytest
import sympy as sp

from ur5_ros.config import load_arm
from ur5_ros.model.dynamics import dynamics_terms
from ur5_ros.model.kinematics import forward_kinematics, jacobian
from ur5_ros.model.symbolic import derive, parameter_values, write_code


@pytest.fixture(scope='module')
def general():
    return derive()


@pytest.fixture(scope='module')
def numbers():
    return derive(load_arm('ur5'))


def states(count, seed):
    return np.random.default_rng(seed).uniform(-2.0, 2.0, (2, count, 6))


def assert_is_the_model(arm, q, qd, t, m, c, g):
    ours = dynamics_terms(q, qd, arm)
    np.testing.assert_allclose(np.array(t, float), forward_kinematics(q, arm), atol=1e-12)
    for theirs, own in zip((m, c, g), ours, strict=True):
        theirs = np.array(theirs, float).reshape(own.shape)
        np.testing.assert_allclose(theirs, own, rtol=0.0, atol=1e-12 * np.abs(own).max())


@pytest.fixture(scope='module')
def fifty_digits(general):
    arguments = [*general.q, *general.qd, *general.parameters]
    return sp.lambdify(arguments, [general.T[-1], general.M, general.C, general.g],
                       modules='mpmath', cse=True)


def test_fifty_digits_of_the_formulas_confirm_the_kernels(arm, fifty_digits):
    with mpmath.workdps(50):
        fixed = [mpmath.mpf(repr(x)) for x in parameter_values(arm).values()]
        for q, qd in zip(*states(3, 1), strict=True):
            t, m, c, g = fifty_digits(*map(mpmath.mpf, q), *map(mpmath.mpf, qd), *fixed)
            assert_is_the_model(arm, q, qd, t.tolist(), m.tolist(), c.tolist(), g.tolist())


def test_numbers_stand_in_the_formulas_as_exact_decimals(numbers, general):
    arm = load_arm('ur5')
    assert numbers.parameters == ()
    assert list(general.parameters) == list(parameter_values(arm))
    assert sp.Rational('-0.39225') in numbers.M.atoms(sp.Rational)
    assert not numbers.M.atoms(sp.Float)


def test_the_flange_position_is_equation_2_with_the_missing_factor(general):
    q1, q2, q3, q4, q5, _ = general.q
    d1, a2, a3, d4, d5, d6 = sp.symbols('d1 a2 a3 d4 d5 d6')
    c, s, q23, q234 = sp.cos, sp.sin, q2 + q3, q2 + q3 + q4
    px = (a2 * c(q1) * c(q2) + a3 * c(q1) * c(q23) + d4 * s(q1) + d5 * c(q1) * s(q234)
          - d6 * c(q1) * c(q234) * s(q5) + d6 * s(q1) * c(q5))
    py = (a2 * s(q1) * c(q2) + a3 * s(q1) * c(q23) - d4 * c(q1) + d5 * s(q1) * s(q234)
          - d6 * s(q1) * c(q234) * s(q5) - d6 * c(q1) * c(q5))
    pz = d1 + a2 * s(q2) + a3 * s(q23) - d5 * c(q234) - d6 * s(q234) * s(q5)
    assert sp.expand(general.T[-1][:3, 3] - sp.Matrix([px, py, pz])) == sp.zeros(3, 1)


def test_the_jacobian_of_the_kernels_is_the_derivative_of_the_formula(numbers):
    q = states(1, 3)[0, 0]
    point = dict(zip(numbers.q, q, strict=True))
    linear = numbers.T[-1][:3, 3].jacobian(numbers.q).subs(point)
    np.testing.assert_allclose(np.array(linear, float), jacobian(q, load_arm('ur5'))[:3],
                               atol=1e-13)


def test_written_python_computes_the_model(general, numbers):
    arm = load_arm('ur5')
    p = list(parameter_values(arm).values())
    for formulas, extra in ((general, [p]), (numbers, [])):
        space = {}
        exec(compile(write_code(formulas, 'python'), 'written', 'exec'), space)
        for q, qd in zip(*states(5, 4), strict=True):
            assert_is_the_model(
                arm, q, qd, space['forward_kinematics'](q, *extra),
                space['inertia_matrix'](q, *extra), space['coriolis_matrix'](q, qd, *extra),
                space['gravity_torque'](q, *extra))


@pytest.mark.skipif(shutil.which('cc') is None, reason='no C compiler (cc)')
def test_written_c_computes_the_model(general, tmp_path):
    arm = load_arm('ur10e')
    source, library = tmp_path / 'model.c', tmp_path / 'model.so'
    source.write_text(write_code(general, 'c'))
    subprocess.run(['cc', '-std=c99', '-Wall', '-Werror', '-O1', '-shared', '-fPIC', source, '-o',
                    library, '-lm'], check=True)
    code = ctypes.CDLL(str(library))
    p = np.array(list(parameter_values(arm).values()))

    def call(name, size, *arguments):
        out = np.empty(size)
        getattr(code, name)(*(ctypes.c_void_p(x.ctypes.data) for x in (*arguments, out)))
        return out

    for q, qd in zip(*(np.ascontiguousarray(x) for x in states(5, 5)), strict=True):
        t = call('forward_kinematics', 16, q, p).reshape(4, 4)
        m, c = call('inertia_matrix', 36, q, p), call('coriolis_matrix', 36, q, qd, p)
        assert_is_the_model(arm, q, qd, t, m, c, call('gravity_torque', 6, q, p))


def test_written_matlab_computes_the_model(numbers):
    # read as Python: indices from one in brackets, ^ for powers, functions in one name space
    text = write_code(numbers, 'matlab')
    assert text.startswith('function out = ur_model(what, q, qd, p)')
    space = {'sin': np.sin, 'cos': np.cos}
    for name, body in re.findall(r'^function out = (\w+)\([^)]*\)\n(.*?)^end$', text,
                                 re.MULTILINE | re.DOTALL):
        if name == 'ur_model':
            continue
        lines = []
        for line in body.splitlines():
            line = re.sub(r'zeros\((\d), (\d)\)', r'np.zeros((\1, \2))', line.strip(' ;'))
            line = re.sub(r'out\((\d), (\d)\)', r'out[\1 - 1, \2 - 1]', line)
            line = re.sub(r'\b(qd?)\((\d)\)', r'\1[\2 - 1]', line)
            lines.append('    ' + line.replace('.^', '**').replace('^', '**').replace('.*', '*')
                         .replace('./', '/'))
        exec('\n'.join(['import numpy as np', f'def {name}(q, qd=None):', *lines,
                        '    return out']), space)
    arm = load_arm('ur5')
    for q, qd in zip(*states(3, 6), strict=True):
        assert_is_the_model(arm, q, qd, space['forward_kinematics'](q), space['inertia_matrix'](q),
                            space['coriolis_matrix'](q, qd), space['gravity_torque'](q))


def test_written_latex_has_every_entry(numbers):
    text = write_code(numbers, 'latex')
    assert text.count(r'\begin{align*}') == text.count(r'\end{align*}') == 4
    for entry in [f'M_{{{i}{j}}}' for i in range(1, 7) for j in range(1, 7)]:
        assert f'\n{entry} &= ' in text
    assert r'\dot q_{6}' in text
    assert text.count('{') == text.count('}')


def test_an_unknown_language_is_refused(numbers):
    with pytest.raises(ValueError, match="language is 'fortran'; give one of: python, c"):
        write_code(numbers, 'fortran')
