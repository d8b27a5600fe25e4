"""Units of what a sweep varies and measures, for figures, columns and messages."""

import re

import polars

from ur5_ros.config.parameters import CONTROL_PARAMETERS, SIM_PARAMETERS

#: Results that are shown in mrad, and kept in rad in table and specification.
_ERRORS, _MRAD = ('max_error', 'rms_error', 'final_error'), 1e3
_MEASURED = {**dict.fromkeys(_ERRORS, 'mrad'), 'max_torque': 'N m', 'max_speed': 'rad/s',
             'control_rate': 'Hz', 'physics_rate': 'Hz', 'duration': 's', 'initial_error': 'rad'}
_DECLARED = {f'{side}.{parameter.name}': parameter.description
             for side, parameters in (('sim', SIM_PARAMETERS), ('control', CONTROL_PARAMETERS))
             for parameter in parameters}


def with_unit(name: str) -> str:
    """Return a key or a column with its unit in brackets, where it has one."""
    unit = _MEASURED.get(name, '')
    if not unit:
        found = re.search(r'\[([^\]]+)\]', _DECLARED.get(name, ''))
        unit = found[1] if found else ''
    return f'{name} [{unit}]' if unit else name


def shown(name: str, value: float) -> float:
    """Return a result in the unit of :func:`with_unit`."""
    return value * _MRAD if name in _ERRORS else value


def table_shown(table: polars.DataFrame) -> polars.DataFrame:
    """Return a table with the results in the units of :func:`with_unit`."""
    return table.with_columns(polars.col(name) * _MRAD
                              for name in _ERRORS if name in table.columns)


def quantity(name: str, value: float) -> str:
    """Return a result in four digits, with its unit."""
    return f'{shown(name, value):.4g} {_MEASURED.get(name, "")}'.rstrip()
