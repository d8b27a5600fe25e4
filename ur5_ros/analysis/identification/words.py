"""Numbers with their errors, and units of parameters, as people read them."""

import math

#: What is smaller is rounding in every unit here.
ROUNDING = 1e-12


def with_error(value: float, error: float) -> str:
    """
    Return a value to the digits that its standard error leaves.

    Parameters
    ----------
    value, error : float
        In the same unit.

    Returns
    -------
    str
        Such as ``2.001 +- 0.002``; ``0`` for what is rounding, ``-`` for what is not known.

    Examples
    --------
    >>> with_error(2.00123, 0.0016), with_error(-6.7e-05, 5e-5), with_error(3e-16, 1e-17)
    ('2.001 +- 0.002', '-0.00007 +- 0.00005', '0')
    >>> with_error(5.64507, 4.7e-14)
    '5.645'

    """
    if not math.isfinite(value):
        return '-'
    if abs(value) < ROUNDING:
        return '0'
    if not math.isfinite(error) or abs(error) < 1e-6 * abs(value):
        return f'{value:.4g}'
    places = -math.floor(math.log10(error))
    if places > 6:
        return f'{value:.2g} +- {error:.1g}'
    return f'{value:.{max(places, 0)}f} +- {error:.{max(places, 0)}f}'


def or_dash(value: float, digits: int = 3) -> str:
    """Return a number, ``-`` where it is not known."""
    return f'{value:.{digits}g}' if math.isfinite(value) else '-'


def unit_of(parameter: str) -> str:
    """
    Return the unit of a base parameter or of friction by its name.

    Examples
    --------
    >>> unit_of('m2'), unit_of('mcx4'), unit_of('Iyy5'), unit_of('rotor3')
    ('kg', 'kg m', 'kg m^2', 'kg m^2')
    >>> unit_of('viscous elbow_joint'), unit_of('Coulomb elbow_joint')
    ('N m s/rad', 'N m')

    """
    if ' ' in parameter:
        return 'N m s/rad' if parameter.startswith('viscous') else 'N m'
    if parameter.startswith('mc'):
        return 'kg m'
    return 'kg' if parameter.startswith('m') else 'kg m^2'
