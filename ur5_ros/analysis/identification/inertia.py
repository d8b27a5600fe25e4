"""Physical inertial parameters: the arm that bodies can have, as near as may be to a fit."""

from dataclasses import replace

import numpy as np

from ur5_ros.errors import InputError
from ur5_ros.model.parameters import ArmParameters, Payload

#: Least eigenvalue of a pseudo-inertia matrix, in units of the arm's own; and in kg, kg m^2.
FLOOR, SMALLEST = 1e-4, 1e-6

#: What the matrix of the arm is enlarged by, as a share of its trace: bodies without a tensor.
POINT_MASS = 1e-5

#: Sharpest information that the solver is given, in parts of a parameter's usual size; what is
#: known better is put right by one step onto it.
SHARPEST = 1e5

#: How well the arm that is there is known: each body to its own size, rotors to this [kg m^2].
ROTOR_SPREAD = 30.0


def physical(
    combination: np.ndarray, value: np.ndarray, factor: np.ndarray, start: np.ndarray,
    typical: np.ndarray,
) -> np.ndarray:
    r"""
    Return the physical parameters nearest to a fit and to the arm that is there.

    Minimises :math:`|F (C x - b)|^2 + \sum_i |P_{0i}^{-1/2} (P_i(x) - P_{0i}) P_{0i}^{-1/2}|^2 +
    |(r - r_0)/s|^2` with all pseudo-inertia matrices :math:`P_i` positive definite and rotors r
    not negative (Sousa and Cortesao 2014; Wensing, Kim, Slotine 2018, IEEE RA-L 3(1), eq. 8; the
    second term is the quadratic form of the metric of Lee, Wensing, Park 2020, IEEE T-RO 36(3)).
    Directions that the fit does not determine stay as they are.  Where a physical arm predicts
    the fit's torques, that one is returned.

    ``combination`` (b, 66): C: base parameters as combinations of the parameters; ``value`` (b,):
    b: their fitted values; ``factor`` (r, b): F: square root of their information, see
    :class:`~ur5_ros.analysis.identification.least_squares.Estimate`; ``start`` (66,): the arm that
    is there: ten inertial parameters a link, then six rotor inertias; ``typical`` (66,): how large
    each of them is for bodies like those.  Returned: parameters, (66,).
    """
    cvxpy = _solver()
    x = cvxpy.Variable(66)
    known, sharp = _information(factor, np.abs(combination) @ typical)
    cost = cvxpy.sum_squares(known @ combination @ x - known @ value)
    limits = [x[60:] >= 0.0]
    for i in range(6):
        units, own = _in_units_of(start[10 * i:10 * i + 10])
        body = sum(x[10 * i + k] * units[k] for k in range(10))
        upper = np.triu_indices(4)
        times = np.where(upper[0] == upper[1], 1.0, np.sqrt(2.0))
        cost += cvxpy.sum_squares((units[:, upper[0], upper[1]] * times).T @ x[10 * i:10 * i + 10]
                                  - own[upper] * times)
        limits.append(body >> FLOOR * np.eye(4))
    cost += cvxpy.sum_squares((x[60:] - start[60:]) / ROTOR_SPREAD)
    problem = cvxpy.Problem(cvxpy.Minimize(cost), limits)
    try:
        problem.solve(solver=cvxpy.CLARABEL)
    except cvxpy.error.SolverError as error:
        raise InputError(f'no physical arm was found: {error}; give another --arm to begin '
                         'with') from None
    if x.value is None:
        raise InputError(f'no physical arm was found ({problem.status}); give another --arm to '
                         'begin with')
    return _onto_fit(nearest_bodies(np.asarray(x.value)), sharp @ combination, sharp @ value)


def with_parameters(arm: ArmParameters, x: np.ndarray, name: str) -> ArmParameters:
    """
    Return the arm with other bodies and rotors.

    ``x`` (66,): ten inertial parameters a link, then the rotor inertias.
    """
    links = x[:60].reshape(6, 10)
    mass = links[:, 0].copy()
    com = links[:, 1:4] / mass[:, None]
    tensor = np.empty((6, 3, 3))
    for i, (m, c) in enumerate(zip(mass, com, strict=True)):
        tensor[i] = _tensor(links[i]) - m * (np.dot(c, c) * np.eye(3) - np.outer(c, c))
        tensor[i] = 0.5 * (tensor[i] + tensor[i].T)
    return replace(arm, name=name, mass=mass, com=com, inertia=tensor,
                   armature=np.maximum(x[60:], 0.0), payload=Payload())


def pseudo_inertia(body: np.ndarray) -> np.ndarray:
    """
    Return the pseudo-inertia matrix of a body.

    ``body`` (10,): m, m c (3), tensor about the origin as xx, xy, yy, xz, yz, zz.  Returned:
    [[tr(I)/2 - I, m c], [m c^T, m]]: positive definite for every body of some extent, (4, 4).
    """
    matrix = np.empty((4, 4))
    tensor = _tensor(body)
    matrix[:3, :3] = 0.5 * np.trace(tensor) * np.eye(3) - tensor
    matrix[:3, 3] = matrix[3, :3] = body[1:4]
    matrix[3, 3] = body[0]
    return matrix


def nearest_bodies(x: np.ndarray) -> np.ndarray:
    """Return the nearest parameters with positive definite pseudo-inertias and rotors."""
    out = x.copy()
    for i in range(6):
        value, vector = np.linalg.eigh(pseudo_inertia(x[10 * i:10 * i + 10]))
        if value[0] >= SMALLEST:
            continue
        pseudo = (vector * np.maximum(value, SMALLEST)) @ vector.T
        second = pseudo[:3, :3]
        inertia = np.trace(second) * np.eye(3) - second
        out[10 * i:10 * i + 10] = [pseudo[3, 3], *pseudo[:3, 3], *inertia[
            [0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2]]]
    out[60:] = np.maximum(x[60:], 0.0)
    return out


def _information(factor: np.ndarray, size: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return rows of the information, no sharper than :data:`SHARPEST`, and those that were."""
    _, strength, basis = np.linalg.svd(factor * size, full_matrices=False)
    rows = basis / size
    return np.minimum(strength, SHARPEST)[:, None] * rows, rows[strength > SHARPEST]


def _onto_fit(x: np.ndarray, rows: np.ndarray, value: np.ndarray) -> np.ndarray:
    """Return the parameters moved onto rows @ x = value, where they stay physical there."""
    moved = x + np.linalg.lstsq(rows, value - rows @ x, rcond=None)[0]
    stays = moved[60:].min() >= 0.0 and all(
        np.linalg.eigvalsh(pseudo_inertia(body))[0] > 0.0
        for body in moved[:60].reshape(6, 10))
    return moved if stays else x


def _tensor(body: np.ndarray) -> np.ndarray:
    xx, xy, yy, xz, yz, zz = body[4:]
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def _in_units_of(body: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return pseudo-inertias of the ten units, (10, 4, 4), and of a body, in its own units."""
    own = pseudo_inertia(body)
    size = own + POINT_MASS * np.trace(own) * np.eye(4)
    root = np.linalg.inv(np.linalg.cholesky(size))
    units = np.array([root @ pseudo_inertia(unit) @ root.T for unit in np.eye(10)])
    return units, root @ own @ root.T


def _solver():
    try:
        import clarabel  # noqa: F401
        import cvxpy
    except ImportError:
        raise InputError("identification needs cvxpy and Clarabel; pip install "
                         "'ur5_ros[identify]'") from None
    return cvxpy
