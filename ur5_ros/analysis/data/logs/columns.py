"""Columns of a robot's log: which quantity each one is, and in which unit, by its name."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from ur5_ros.errors import InputError

#: Quantity -> names of its six columns: the UR real-time interface as published by K. Kufieta,
#: then UR's RTDE recorder and ur_rtde.
COLUMNS: dict[str, tuple[str, ...]] = {
    'q': ('q_actual_{1}', 'actual_q_{0}'),
    'qd': ('qd_actual_{1}', 'actual_qd_{0}'),
    'torque': ('m_target_{1}', 'target_moment_{0}'),
    'q_star': ('q_target_{1}', 'target_q_{0}'),
    'qd_star': ('qd_target_{1}', 'target_qd_{0}'),
    'qdd_star': ('qdd_target_{1}', 'target_qdd_{0}'),
    'current': ('i_actual_{1}', 'actual_current_{0}'),
    'tool': ('tool_vector_{1}', 'actual_TCP_pose_{0}'),
    'temperature': ('joint_temperature_{1}', 'joint_temperatures_{0}'),
    'torque_actual': ('actual_current_as_torque_{0}', 'actual_torque_{0}', 'actual_moment_{0}',
                      'actual_joint_torque_{0}', 'joint_torque_{0}', 'joint_torques_{0}',
                      'measured_torque_{0}', 'effort_{0}'),
}

#: What a name has in it that is a torque of a joint.
_TORQUES = re.compile(r'torque|moment|effort|(^|_)tau(_|$)')

#: Names of the time; words of which one is in another name of it; names of its seconds and
#: nanoseconds where they are two columns.
TIME = ('t', 'timestamp', 'time')
TIME_WORDS = {'time', 'timestamp', 'stamp', 'seconds', 'sec', 'secs'}
NANOSECONDS = {'nanosec', 'nsec', 'nsecs', 'nanoseconds', 'nanosecs'}

#: Names of the declared payload: mass [kg], centre of mass [m].
PAYLOAD = ('payload', 'payload_mass')
PAYLOAD_COM = 'payload_cog_{0}'

#: Largest magnitude that a quantity can have: rad, rad/s, rad/s^2, N m, A, m or rad, deg C, kg, m,
#: and s or nanoseconds since 1970.
LARGEST = {'q': 1e3, 'qd': 1e3, 'torque': 1e5, 'torque_actual': 1e5, 'q_star': 1e3,
           'qd_star': 1e3, 'qdd_star': 1e5, 'current': 1e5, 'tool': 1e3, 'temperature': 200.0,
           'payload': 1e4, 'payload_com': 1e2, 'time': 1e19}

_DEGREE = 0.017453292519943295
_SECOND = {'s': 1.0, 'sec': 1.0, 'seconds': 1.0, 'ms': 1e-3, 'msec': 1e-3, 'us': 1e-6, 'µs': 1e-6,
           'μs': 1e-6, 'ns': 1e-9, 'nsec': 1e-9}
_ANGLE = {'rad': 1.0, 'radians': 1.0, 'deg': _DEGREE, 'degrees': _DEGREE, '°': _DEGREE}
_TORQUE = {'nm': 1.0, 'n m': 1.0, 'n*m': 1.0, 'n·m': 1.0, 'n.m': 1.0, 'mnm': 1e-3}

#: Quantity -> units that its name may state, each with its factor; without one it is SI.
UNITS: dict[str, Mapping[str, float]] = {
    'time': _SECOND, 'q': _ANGLE, 'q_star': _ANGLE,
    **{name: {f'{unit}/s': factor for unit, factor in _ANGLE.items()}
       for name in ('qd', 'qd_star')},
    'qdd_star': {f'{unit}/s{square}': factor for unit, factor in _ANGLE.items()
                 for square in ('^2', '2', '²')},
    'torque': _TORQUE, 'torque_actual': _TORQUE, 'current': {'a': 1.0, 'ma': 1e-3},
    'tool': {'m': 1.0, 'rad': 1.0},
    'temperature': {'c': 1.0, '°c': 1.0, 'degc': 1.0}, 'payload': {'kg': 1.0, 'g': 1e-3},
    'payload_com': {'m': 1.0, 'mm': 1e-3},
}

_UNIT = re.compile(r'(.*?)\s*[\[(]\s*([^\])\d][^\])]*?)\s*[\])]')
_TIME_UNIT = re.compile(rf'({"|".join(TIME)})_({"|".join(_SECOND)})')


class Column(NamedTuple):
    """A name of a column, in the form in which it is compared."""

    name: str
    unit: str
    """As the name states it; empty where it does not."""


class LogColumns(NamedTuple):
    """The columns of a log that are used."""

    places: dict[str, list[int]]
    """Quantity -> places; ``time`` and ``q`` always."""
    factors: dict[str, float]
    """Quantity -> factor to SI, of those whose unit is stated."""
    remarks: list[str]
    """What is named, but not whole."""


def plain_name(text: str) -> Column:
    """
    Return a name in lower case with its index behind ``_``, and the unit that it states.

    ``Actual_q[0] (rad)``, ``actual_q.0`` and ``actual_q_0`` are one column.

    """
    text = text.strip().strip('"\'').strip().lower()
    stated = _UNIT.fullmatch(text)
    unit = ''
    if stated:
        text, unit = stated[1], stated[2]
    text = re.sub(r'[\s.:/\[\](){}-]+', '_', text).strip('_')
    in_time = _TIME_UNIT.fullmatch(text)
    if in_time and not unit:
        text, unit = in_time[1], in_time[2]
    return Column(re.sub(r'(?<=[a-z])(\d)$', r'_\1', text), unit)


def column_names(columns: str) -> list[str]:
    """Return the names that ``--columns`` gives; ``actual_q`` stands for its six columns."""
    six = {form.removesuffix('_{0}').removesuffix('_{1}'): form
           for forms in COLUMNS.values() for form in forms}
    names = []
    for name in (each.strip() for each in columns.split(',')):
        bare, unit = plain_name(name)
        form = six.get(name) or six.get(bare)
        if form is not None:
            stated = f' [{unit}]' if unit else ''
            names += [form.format(i, i + 1) + stated for i in range(6)]
        else:
            names.append(name)
    return names


def is_header(names: Sequence[str]) -> bool:
    """Return whether these are names of columns, a time and positions among them."""
    plain = {plain_name(name).name for name in names}
    known = {name for form in COLUMNS['q'] for name in (form.format(1, 1), form[:-4])}
    return bool(plain.intersection(TIME)) and bool(plain & known)


def find_columns(names: Sequence[str], log: Path) -> LogColumns:
    """
    Return the columns that the log has.

    InputError if time or positions are missing, a name that is used stands twice, or a unit is
    not known.

    """
    plain = [plain_name(name) for name in names]
    places: dict[str, int] = {}
    for i, (name, _) in enumerate(plain):
        places.setdefault(name, i)
    remarks: list[str] = []
    found = {'time': _time_columns(places, names, log, remarks)}
    for quantity, forms in COLUMNS.items():
        columns, missing = _six(forms, places)
        if columns:
            found[quantity] = columns
        elif missing and quantity == 'q':
            raise InputError(f'{log}: no column {missing[0]} beside the others of its six; all '
                             'are needed: add it, or name the columns with --columns')
        elif missing:
            remarks.append(f'no column {missing[0]}: the others of its six are not used')
    if 'q' not in found:
        either, other = COLUMNS['q']
        raise InputError(f'{log}: no columns {either.replace("{1}", "1..6")} or '
                         f'{other.replace("{0}", "0..5")}; they are needed, the first columns are '
                         f'{_first(names)}; name them with --columns')
    mass = next((places[name] for name in PAYLOAD if name in places), None)
    if mass is not None:
        found['payload'] = [mass]
        com = [places.get(PAYLOAD_COM.format(i)) for i in range(3)]
        if all(column is not None for column in com):
            found['payload_com'] = [column for column in com if column is not None]
    if 'torque' in found:
        found.pop('torque_actual', None)  # one torque is enough
    elif 'torque_actual' not in found:
        unused = [names[i].strip() for i, (name, _) in enumerate(plain) if _TORQUES.search(name)]
        if unused:
            remarks.append(f'columns that may be torques are not used: {_first(unused)}; name '
                           'them with --columns')
    _refuse_doubles(plain, names, found, log)
    return LogColumns(found, _factors(found, plain, names, log), remarks)


def _time_columns(places: Mapping[str, int], names: Sequence[str], log: Path,
                  remarks: list[str]) -> list[int]:
    """Return the place of the time, or those of its seconds and nanoseconds."""
    known = next((name for name in TIME if name in places), None)
    if known is not None:
        return [places[known]]
    words = {name: set(name.split('_')) for name in places}
    whole = [name for name, each in words.items() if each & TIME_WORDS and not each & NANOSECONDS]
    parts = [name for name, each in words.items() if each & NANOSECONDS]
    if len(whole) == 1 and len(parts) <= 1:
        remarks.append(f'the time is that of the column{"s" if parts else ""} '
                       f'{" and ".join([*whole, *parts])}')
        return [places[name] for name in (*whole, *parts)]
    raise InputError(f'{log}: no column {" or ".join(TIME)}; the first columns are '
                     f'{_first(names)}; name them with --columns')


def _first(names: Sequence[str]) -> str:
    return repr(', '.join(names[:4])[:80])


def _refuse_doubles(plain: Sequence[Column], names: Sequence[str], found: dict[str, list[int]],
                    log: Path) -> None:
    every = [name for name, _ in plain]
    used = {every[i] for columns in found.values() for i in columns} | {
        form.format(i, i + 1).lower() for forms in COLUMNS.values() for form in forms
        for i in range(6)}
    for i, name in enumerate(every):
        if name in used and every.index(name) != i:
            raise InputError(f'{log}: column {names[i].strip()!r} stands twice; remove one')


def _factors(found: dict[str, list[int]], plain: Sequence[Column], names: Sequence[str],
             log: Path) -> dict[str, float]:
    """Return quantity -> factor of the unit that its columns state."""
    factors = {}
    for quantity, columns in found.items():
        units = {plain[i].unit for i in columns} - {''}
        for unit in units:
            known = UNITS[quantity]
            if unit not in known or (len(units) > 1 and quantity != 'tool'):
                raise InputError(f'{log}: column {names[columns[0]].strip()!r}: its unit '
                                 f'{unit[:20]!r} is not one of {", ".join(known)}; convert it, '
                                 'or name the columns with --columns')
            factors[quantity] = known[unit]
    return factors


def _six(forms: Sequence[str], places: Mapping[str, int]) -> tuple[list[int], list[str]]:
    """Return the places of six columns; of a set that is not whole, the names that are missing."""
    incomplete: list[str] = []
    for form in (each.lower() for each in forms):
        names = [form.format(i, i + 1) for i in range(6)]
        if all(name in places for name in names):
            return [places[name] for name in names], []
        counted = [form.replace('{0}', '{1}').format(i, i + 1) for i in range(6)]
        if names != counted and all(name in places for name in counted):
            return [places[name] for name in counted], []  # counted from 1
        missing = [name for name in names if name not in places]
        if len(missing) < 6:
            incomplete = missing
    return [], incomplete
