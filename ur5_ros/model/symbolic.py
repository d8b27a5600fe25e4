r"""
The model as formulas: kinematics, M, C and g derived with SymPy by the paper's own route.

The derivation starts from the DH table and follows eqs. (8) to (10) of Kebria 2016; it shares
nothing with the compiled kernels and is a witness for them.  SymPy is an optional dependency
(``pip install '.[symbolic]'`` in the checkout).
"""

from typing import NamedTuple

import sympy as sp
from sympy.simplify.fu import TR10i

from ur5_ros.model.parameters import ArmParameters
from ur5_ros.model.symbolic_code import LANGUAGES, write_code

__all__ = ['LANGUAGES', 'Formulas', 'derive', 'parameter_values', 'write_code']

_TENSOR = ('xx', 'yy', 'zz', 'xy', 'xz', 'yz')
_ENTRIES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


class Formulas(NamedTuple):
    """Expressions in the symbols ``q``, ``qd`` and, where they are not numbers, ``parameters``."""

    q: tuple[sp.Symbol, ...]
    """Joint positions q1 to q6."""
    qd: tuple[sp.Symbol, ...]
    """Joint velocities qd1 to qd6."""
    parameters: tuple[sp.Symbol, ...]
    """Parameters left as symbols, in the order that written code takes them; may be empty."""
    T: tuple[sp.Matrix, ...]
    """Poses of the six link frames in base; the last is the flange, eq. (1)."""
    M: sp.Matrix
    """Inertia matrix, eq. (8)."""
    C: sp.Matrix
    """Coriolis matrix, eq. (9)."""
    g: sp.Matrix
    """Gravity torque, eq. (10)."""


def derive(arm: ArmParameters | None = None) -> Formulas:
    """
    Return kinematics and dynamics as expressions.

    ``arm``: its numbers stand in the formulas as exact rationals of their decimal digits; without
    an arm the parameters are symbols: d1, a2, ..., m1, c1x, ..., I1xx, ..., J1 (armature), gx.
    Returned: expressions; M, C and g are not multiplied out.
    """
    q, qd = sp.symbols('q1:7'), sp.symbols('qd1:7')
    symbols = _symbols()
    value = {s: s for s in symbols}
    if arm is not None:
        value = {s: sp.Rational(repr(x)) for s, x in parameter_values(arm).items()}

    def of(name: str) -> sp.Expr:
        return value[symbols[_INDEX[name]]]

    links = [_dh_transform(q[i], i, of) for i in range(6)]
    poses = [links[0]]
    for link in links[1:]:
        poses.append(_joined_angles(poses[-1] * link))
    mass_matrix = _inertia(links, of)
    return Formulas(
        q, qd, tuple(s for s in symbols if value[s] is s), tuple(poses), mass_matrix,
        _christoffel(mass_matrix, q, qd), _gravity(poses, q, of))


def parameter_values(arm: ArmParameters) -> dict[sp.Symbol, float]:
    """Return the number of an arm for each symbol that :func:`derive` uses."""
    mass, com, inertia = arm.bodies
    values = [arm.d[0], arm.a[1], arm.a[2], arm.d[3], arm.d[4], arm.d[5], *arm.gravity]
    for i in range(6):
        values += [mass[i], *com[i], *(inertia[i][entry] for entry in _ENTRIES), arm.armature[i]]
    return dict(zip(_symbols(), map(float, values), strict=True))


def _names() -> list[str]:
    names = ['d1', 'a2', 'a3', 'd4', 'd5', 'd6', 'gx', 'gy', 'gz']
    for i in range(1, 7):
        names += [f'm{i}', f'c{i}x', f'c{i}y', f'c{i}z', *(f'I{i}{e}' for e in _TENSOR), f'J{i}']
    return names


_INDEX = {name: i for i, name in enumerate(_names())}


def _symbols() -> tuple[sp.Symbol, ...]:
    return sp.symbols(_names())


def _dh_transform(angle: sp.Symbol, i: int, of) -> sp.Matrix:
    # Table I as standard DH; the twists are right angles
    twist = (1, 0, 0, 1, -1, 0)[i]
    a = of(f'a{i + 1}') if i in (1, 2) else 0
    d = of(f'd{i + 1}') if i in (0, 3, 4, 5) else 0
    c, s, ca, sa = sp.cos(angle), sp.sin(angle), 1 - abs(twist), twist
    return sp.Matrix([[c, -s * ca, s * sa, a * c], [s, c * ca, -c * sa, a * s],
                      [0, sa, ca, d], [0, 0, 0, 1]])


def _joined_angles(matrix: sp.Matrix) -> sp.Matrix:
    # c2 c3 - s2 s3 = c23 and its like, along the parallel axes
    return matrix.applyfunc(lambda entry: TR10i(sp.expand(entry)))


def _inertia(links: list[sp.Matrix], of) -> sp.Matrix:
    # eq (8), with both Jacobians in the axes of link i, where they are shortest
    unit = sp.Matrix([0, 0, 1])
    w, v, total = sp.zeros(3, 6), sp.zeros(3, 6), sp.zeros(6)
    for i, link in enumerate(links):
        turn, step = link[:3, :3], link[:3, 3]
        w[:, i] = unit
        v = sp.Matrix.hstack(*[v[:, j] + w[:, j].cross(step) for j in range(6)])
        w, v = _joined_angles(turn.T * w), _joined_angles(turn.T * v)
        com = sp.Matrix([of(f'c{i + 1}{x}') for x in 'xyz'])
        tensor = sp.zeros(3)
        for name, (r, c) in zip(_TENSOR, _ENTRIES, strict=True):
            tensor[r, c] = tensor[c, r] = of(f'I{i + 1}{name}')
        at_com = sp.Matrix.hstack(*[v[:, j] + w[:, j].cross(com) for j in range(6)])
        total += of(f'm{i + 1}') * at_com.T * at_com + w.T * tensor * w
    return total + sp.diag(*[of(f'J{i}') for i in range(1, 7)])


def _christoffel(mass_matrix: sp.Matrix, q, qd) -> sp.Matrix:
    # eq (9)
    slope = [mass_matrix.diff(x) for x in q]
    return sp.Matrix(6, 6, lambda i, j: sp.Add(*[
        (slope[k][i, j] + slope[j][i, k] - slope[i][j, k]) * qd[k] / 2 for k in range(6)]))


def _gravity(poses: list[sp.Matrix], q, of) -> sp.Matrix:
    # eq (10): the slope of the potential energy
    field = sp.Matrix([of('gx'), of('gy'), of('gz')])
    energy = 0
    for i, pose in enumerate(poses):
        com = sp.Matrix([*(of(f'c{i + 1}{x}') for x in 'xyz'), 1])
        energy -= of(f'm{i + 1}') * field.dot((pose * com)[:3, :])
    return sp.Matrix([sp.diff(energy, x) for x in q])
