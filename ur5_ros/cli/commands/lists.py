"""The commands ``ur5 arm`` and ``ur5 experiments``: what comes with the package, a line each."""

import re
from collections.abc import Mapping
from typing import Any

from rich.table import Table
from rich.text import Text

from ur5_ros.cli import terminal
from ur5_ros.cli.exit_codes import SUCCESS
from ur5_ros.config.experiments import load_experiment
from ur5_ros.config.strict_yaml import config_folder, file_names, read_yaml


def arms() -> int:
    """List the arms; see ``ur5 arm --help``."""
    def rotors(data: Mapping[str, Any]) -> str:
        if any(data['armature']['value']):
            return 'measured'
        return 'assumed' if 'armature_assumed' in data else 'none'
    _show('arm', {'rotors': rotors})
    terminal.console().print(Text('rotors assumed: NAME+armature_assumed uses them'))
    terminal.show_next(terminal.console(), 'ur5 demo --arm ur5_real', 'runs one of them')
    return SUCCESS


def experiments() -> int:
    """List the experiments; see ``ur5 experiments --help``."""
    _show('experiment', {'length': lambda data: f'{load_experiment(data["name"]).duration:g} s'})
    terminal.show_next(terminal.console(), 'ur5 demo --experiment multi_sine', 'runs one of them')
    return SUCCESS


def _show(kind: str, columns: Mapping[str, Any]) -> None:
    table = Table(box=None, pad_edge=False, header_style='bold')
    for name in (kind, *columns, 'description'):
        table.add_column(name, no_wrap=name != 'description')
    for name in sorted(file_names(kind), key=_natural):
        data: Any = read_yaml(config_folder() / f'{kind}s' / f'{name}.yaml')
        table.add_row(name, *(Text(column(data)) for column in columns.values()),
                      Text(data.get('description', '')))
    terminal.console().print(table)


def _natural(name: str) -> list[str]:
    """Return a key that sorts ur5 before ur10."""
    return [part.zfill(4) if part.isdigit() else part for part in re.split(r'(\d+)', name)]
