"""Units of what a sweep varies and measures, for the titles of figures and columns."""

import re

from ur5_ros.config.parameters import CONTROL_PARAMETERS, SIM_PARAMETERS

_MEASURED = {'max_error': 'rad', 'rms_error': 'rad', 'final_error': 'rad', 'max_torque': 'N m',
             'max_speed': 'rad/s', 'control_rate': 'Hz', 'physics_rate': 'Hz', 'duration': 's',
             'initial_error': 'rad'}
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
