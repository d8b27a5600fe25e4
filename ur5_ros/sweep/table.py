"""The rows of a sweep on disk: parts as they come, one Parquet table at the end."""

import fcntl
import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import polars

from ur5_ros.config.records import as_data
from ur5_ros.errors import InputError
from ur5_ros.sweep.provenance import write_provenance
from ur5_ros.sweep.run import METRICS
from ur5_ros.sweep.spec import SweepSpec, parse_sweep

TABLE = 'table.parquet'
_SPEC = 'sweep.json'
_LEADING = ('status', 'success', 'why', *METRICS, 'states', 'verdict', 'causes')


class SweepFolder:
    """A folder that holds a sweep: its specification, the rows done so far, its table."""

    def __init__(self, path: Path, spec: SweepSpec) -> None:
        self.path = path
        self.parts = path / 'parts'
        self.spec = spec
        text = json.dumps(as_data(spec), indent=1) + '\n'
        file = path / _SPEC
        if file.exists() and file.read_text(encoding='utf-8') != text:
            raise InputError(f'{path} holds another sweep, or an older form of this one; '
                             'give another folder with --out')
        if path.exists() and not file.exists() and any(path.iterdir()):
            raise InputError(f'{path} is not empty and holds no sweep; give another folder '
                             'with --out')
        self.parts.mkdir(parents=True, exist_ok=True)
        if not file.exists():
            file.write_text(text, encoding='utf-8')
            write_provenance(path)

    @contextmanager
    def lock(self) -> Iterator[None]:
        """Keep other sweeps out of the folder while the block works."""
        with open(self.path / _SPEC, encoding='utf-8') as held:
            try:
                fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                raise InputError(f'another ur5 sweep works in {self.path}; wait for it, or give '
                                 'another folder with --out') from None
            yield

    def done(self) -> set[int]:
        """Return the indices of the rows that are there; parts cut short are removed."""
        found: set[int] = set()
        for part in sorted(self.parts.glob('*.parquet')):
            found.update(polars.read_parquet(part, columns=['index'])['index'].to_list())
        for unfinished in self.parts.glob('*.unfinished'):
            unfinished.unlink()
        return found

    def add(self, rows: list[dict[str, Any]]) -> None:
        """Write rows so that they are there whole or not at all."""
        first = min(row['index'] for row in rows)
        part = self.parts / f'{first:07d}-{len(rows)}.parquet'
        unfinished = part.with_suffix('.unfinished')
        polars.DataFrame(rows, infer_schema_length=None, strict=False).write_parquet(unfinished)
        os.replace(unfinished, part)

    def table(self) -> polars.DataFrame:
        """Return all rows in the order of their indices; equal for every way of getting there."""
        parts = [polars.read_parquet(part) for part in sorted(self.parts.glob('*.parquet'))]
        if not parts:
            raise InputError(f'{self.path} has no finished run; run the sweep first')
        table = polars.concat(parts, how='diagonal_relaxed')
        table = table.unique('index', keep='first').sort('index')
        inputs = [key for key in input_keys(self.spec) if key in table.columns]
        leading = ['index', *inputs, *(key for key in _LEADING if key in table.columns)]
        rest = sorted(set(table.columns) - set(leading))
        return table.select(leading + rest).rechunk()

    def write_table(self) -> Path:
        """Write :meth:`table` as Parquet and return its path."""
        path = self.path / TABLE
        self.table().write_parquet(path, compression='zstd')
        return path


def input_keys(spec: SweepSpec) -> list[str]:
    """Return the keys that differ from run to run, in the order of the specification."""
    return [*(spec.cases[0] if spec.cases else ()), *spec.vary]


def open_sweep(path: Path) -> SweepFolder:
    """Return a sweep folder that exists."""
    file = path / _SPEC
    if not file.is_file():
        raise InputError(f'{path} holds no sweep (no {_SPEC}); give the folder that ur5 sweep '
                         'wrote')
    return SweepFolder(path, parse_sweep(file.read_text(encoding='utf-8'), str(file)))
