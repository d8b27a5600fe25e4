"""Pass marks: ``config/validation.yaml`` to a record."""

from pathlib import Path
from typing import Annotated

from ur5_ros.config.records import Meta, Record, validate
from ur5_ros.config.strict_yaml import config_folder, read_yaml
from ur5_ros.errors import InputError


class Mark(Record, frozen=True, kw_only=True):
    """One limit, with its unit and its source."""

    limit: Annotated[float, Meta(ge=0.0)]
    """Highest value that passes."""
    unit: str
    """Unit of the limit."""
    reason: str
    """Where the number comes from."""


class Marks(Record, frozen=True, kw_only=True):
    """The limits of all checks, by name."""

    name: str
    marks: dict[str, Mark]

    def __getitem__(self, name: str) -> float:
        """Return the limit called ``name``."""
        return self.marks[name].limit


def load_marks(path: str | Path = '') -> Marks:
    """
    Return the pass marks.

    ``path``: A YAML file of the same form as ``config/validation.yaml``, which is the default.
    Marks that it leaves out keep their default.
    """
    default_path = config_folder() / 'validation.yaml'
    default = validate(Marks, read_yaml(default_path), str(default_path))
    if not path:
        return default
    given = validate(Marks, read_yaml(Path(path)), str(path))
    for name in given.marks:
        if name not in default.marks:
            raise InputError(f'{path}: unknown mark {name!r}; the marks are: '
                             f'{", ".join(sorted(default.marks))}')
    return Marks(name=given.name, marks={**default.marks, **given.marks})
