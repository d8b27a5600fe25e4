"""A solution judged: run in a limited process, points by line, usual mistakes by name."""

import sys
from importlib import import_module
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ur5_ros.bench.limited_process import OUT_OF_MEMORY, end_with, limit_resources, run_limited
from ur5_ros.control.laws.user_law import reason
from ur5_ros.course.exercise import Exercise, Line, Mark, WrongAnswer
from ur5_ros.course.untouched import attributes, replaced
from ur5_ros.errors import InputError

EXERCISES = ('kinematics', 'dynamics', 'computed_torque', 'identification', 'friction', 'contact')
#: Wall-clock time that a solution gets [s].
TIMEOUT = 60.0


class Grade(NamedTuple):
    """What a solution earned."""

    exercise: str
    seed: int
    marks: tuple[Mark, ...]
    why: str
    """Why nothing could be judged; empty where all lines were."""

    @property
    def points(self) -> float:
        """The sum of the lines."""
        return sum(mark.points for mark in self.marks)

    @property
    def full(self) -> bool:
        """Whether no point was lost."""
        return not self.why and all(mark.points == mark.of for mark in self.marks)


def exercise_named(name: str) -> Exercise:
    """Return an exercise; InputError if there is none of the name."""
    if name not in EXERCISES:
        raise InputError(f'unknown exercise {name!r}; give one of: {", ".join(EXERCISES)}')
    return import_module(f'ur5_ros.course.{name}').EXERCISE


def grade(name: str, file: Path, seed: int = 0, seconds: float = TIMEOUT) -> Grade:
    """Return what a solution earns."""
    lines = exercise_named(name).lines
    if not file.is_file():
        what = f'{file} is a folder' if file.is_dir() else f'no file {file}'
        raise InputError(f'{what}; give the Python file of the solution')
    found = run_limited(__name__, [name, str(file.resolve()), str(seed)], seconds)
    why = found.why or found.result['why']
    if why:
        return Grade(name, seed, tuple(Mark(line.name, 0.0, line.points, why)
                                       for line in lines), why)
    return Grade(name, seed, tuple(Mark(*each) for each in found.result['marks']), '')


def judge(exercise: Exercise, file: str, seed: int) -> dict[str, Any]:
    """Return marks of a file in this process, or why it cannot be judged."""
    before, marks = attributes(), []
    try:
        module = _load(file)
    except MemoryError:
        return {'why': f'the import takes {OUT_OF_MEMORY}', 'marks': []}
    except BaseException as error:
        return {'why': f'the file cannot be imported: {reason(error, file)}', 'marks': []}
    for line in exercise.lines:
        marks.append(_mark(line, module, file, seed))
        changed = replaced(before)
        if changed:
            return {'why': f'the file replaces {changed}; leave the packages as they are',
                    'marks': []}
    return {'why': '', 'marks': marks}


def _mark(line: Line, module: Any, file: str, seed: int) -> Mark:
    random = np.random.default_rng([seed, *line.name.encode()])
    mistake = ''
    try:
        why, mistake = line.check(module, random)
    except WrongAnswer as error:
        why = str(error)
    except MemoryError:
        why = f'it takes {OUT_OF_MEMORY}'
    except BaseException as error:  # SystemExit and KeyboardInterrupt of the file's too
        why = reason(error, file)
    return Mark(line.name, 0.0 if why else line.points, line.points, why, mistake)


def _load(file: str) -> Any:
    spec = spec_from_file_location('solution', file)
    if spec is None or spec.loader is None:
        raise ImportError('not a Python file; its name should end in .py')
    module = module_from_spec(spec)
    sys.modules['solution'] = module
    spec.loader.exec_module(module)
    return module


def main(result: str, name: str, file: str, seed: str) -> None:
    """Judge a file and end; the model is loaded before memory is limited."""
    exercise = exercise_named(name)
    limit_resources()
    end_with(result, judge(exercise, file, int(seed)))


if __name__ == '__main__':
    main(*sys.argv[1:])
