"""Columns of a robot's log: which quantity each one is, by its name."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from ur5_ros.errors import InputError

#: Quantity -> names of its six columns: the UR real-time interface as published by K. Kufieta,
#: then UR's RTDE recorder and ur_rtde.
COLUMNS = {
    'q': ('q_actual_{1}', 'actual_q_{0}'),
    'qd': ('qd_actual_{1}', 'actual_qd_{0}'),
    'torque': ('m_target_{1}', 'target_moment_{0}'),
    'q_star': ('q_target_{1}', 'target_q_{0}'),
    'qd_star': ('qd_target_{1}', 'target_qd_{0}'),
    'qdd_star': ('qdd_target_{1}', 'target_qdd_{0}'),
    'current': ('i_actual_{1}', 'actual_current_{0}'),
    'tool': ('tool_vector_{1}', 'actual_TCP_pose_{0}'),
}

#: Names of the time, and of the declared payload: mass [kg], centre of mass [m].
TIME = ('t', 'timestamp', 'time')
PAYLOAD = ('payload', 'payload_mass')
PAYLOAD_COM = 'payload_cog_{0}'

#: Largest magnitude that a quantity can have: rad, rad/s, rad/s^2, N m, A, and m or rad.
LARGEST = {'q': 1e3, 'qd': 1e3, 'torque': 1e5, 'q_star': 1e3, 'qd_star': 1e3, 'qdd_star': 1e5,
           'current': 1e4, 'tool': 1e3, 'payload': 1e4, 'payload_com': 1e2, 'time': 1e15}


def column_names(columns: str) -> list[str]:
    """Return the names that ``--columns`` gives; ``actual_q`` stands for its six columns."""
    six = {form.removesuffix('_{0}').removesuffix('_{1}'): form
           for forms in COLUMNS.values() for form in forms}
    names = []
    for name in (each.strip() for each in columns.split(',')):
        if name in six:
            names += [six[name].format(i, i + 1) for i in range(6)]
        else:
            names.append(name)
    return names


def find_columns(names: Sequence[str], log: Path) -> dict[str, list[int]]:
    """
    Return quantity -> columns, of those that the log has; ``time`` and ``q`` always.

    InputError if these are missing, or a name that is used stands twice.

    """
    places: dict[str, int] = {}
    twice = set()
    for i, name in enumerate(names):
        if name in places and name not in ('', '-'):
            twice.add(name)
        places.setdefault(name, i)
    lower = {name.lower(): i for name, i in reversed(places.items())}
    time = next((lower[name] for name in TIME if name in lower), None)
    if time is None:
        raise InputError(f'{log}: no column {" or ".join(TIME)}; the first columns are '
                         f'{", ".join(names[:4])[:80]!r}; name them with --columns')
    found = {'time': [time]}
    for quantity, forms in COLUMNS.items():
        columns = _six(forms, places)
        if columns:
            found[quantity] = columns
    if 'q' not in found:
        either, other = COLUMNS['q']
        raise InputError(f'{log}: no columns {either.replace("{1}", "1..6")} or '
                         f'{other.replace("{0}", "0..5")}; they are needed: name them with '
                         '--columns')
    mass = next((places[name] for name in PAYLOAD if name in places), None)
    if mass is not None:
        found['payload'] = [mass]
        com = [places.get(PAYLOAD_COM.format(i)) for i in range(3)]
        if all(column is not None for column in com):
            found['payload_com'] = [column for column in com if column is not None]
    known = {form.format(i, i + 1) for forms in COLUMNS.values() for form in forms
             for i in range(6)} | {names[i] for columns in found.values() for i in columns}
    if known & twice:
        raise InputError(f'{log}: column {sorted(known & twice)[0]!r} stands twice; remove one')
    return found


def _six(forms: tuple[str, str], places: Mapping[str, int]) -> list[int] | None:
    for form in forms:
        names = [form.format(i, i + 1) for i in range(6)]
        if all(name in places for name in names):
            return [places[name] for name in names]
    return None
