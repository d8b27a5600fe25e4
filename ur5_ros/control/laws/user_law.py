"""A law in a file of the user: loaded, called, and refused in one line where it is wrong."""

import importlib.util
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from ur5_ros.config.node_parameters import ControlParameters
from ur5_ros.control.gains import Gains
from ur5_ros.control.laws.law import Law, model_terms
from ur5_ros.errors import InputError
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import ArmState, Reference, Torque

#: The class that a file defines.
CLASS = 'Law'
#: Of a text that an exception of the file brings, so much is shown [characters].
_LONGEST = 200
#: Kinds of arrays that are no real numbers.
_NO_NUMBERS = {'c': 'complex numbers', 'U': 'text', 'S': 'text', 'M': 'dates', 'm': 'times',
               'V': 'records'}


def load_law(file: str) -> type:
    """Return the class ``Law`` of a Python file."""
    path = Path(file)
    if not path.is_file():
        what = f'{file} is a folder' if path.is_dir() else f'no file {file}'
        raise InputError(f'{what}; give a Python file that defines class {CLASS}')
    return _load(str(path.resolve()), path.stat().st_mtime_ns)


@lru_cache(maxsize=64)
def _load(file: str, _: int) -> type:
    """Return the class of a file, imported once for each time that it is written."""
    name = f'ur5_ros_law_{abs(hash(file))}'
    spec = importlib.util.spec_from_file_location(name, file)
    if spec is None or spec.loader is None:
        raise InputError(f'{file} is not a Python file; give one whose name ends in .py')
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # dataclasses in it look their module up
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:
        raise InputError(f'{file}: {reason(error, file)}; the file must be importable') from None
    law = getattr(module, CLASS, None)
    if not isinstance(law, type):
        raise InputError(f'{file} defines no class {CLASS}; give it one with __init__(arm, gains, '
                         'parameters) and __call__(state, reference, dt)')
    return law


def reason(error: BaseException, file: str) -> str:
    """Return an exception of a user's file in one line, with the line where it arose."""
    lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__)
             if frame.filename == file]
    if isinstance(error, SyntaxError) and error.filename == file:
        lines = [error.lineno]
    try:
        text = ' '.join(str(getattr(error, 'msg', error)).split())
    except Exception:  # its own text may be what is wrong
        text = 'its text cannot be shown'
    text = ''.join(c if c.isprintable() else '?' for c in text[:_LONGEST])
    where = f' (line {lines[-1]})' if lines and lines[-1] else ''
    return type(error).__name__ + (f': {text}' if text else '') + where


def real_numbers(given: Any) -> np.ndarray:
    """Return what a user's function gave, as real numbers."""
    if given is None:
        raise ValueError('nothing (None)')
    try:
        array = np.asarray(given)
        if array.dtype.kind not in _NO_NUMBERS:
            return np.array(array, dtype=float)  # a copy: it may go on using its own
    except (TypeError, ValueError, OverflowError):
        raise ValueError(f'no numbers but {type(given).__name__}') from None
    raise ValueError(_NO_NUMBERS[array.dtype.kind])


class UserLaw(Law):
    """The law of ``law_file``."""

    def __init__(self, arm: ArmParameters, gains: Gains, parameters: ControlParameters) -> None:
        super().__init__(arm, gains, parameters)
        law = load_law(parameters.law_file)
        with _refusing(parameters.law_file):
            self._law = law(arm, gains, parameters)
        if not callable(self._law):
            raise InputError(f'{parameters.law_file}: class {CLASS} has no __call__(state, '
                             'reference, dt)')

    @classmethod
    def check(cls, gains: Gains, parameters: ControlParameters, arm: ArmParameters,
              control_rate: int) -> None:
        """Refuse what the class itself refuses in a method ``check``; else nothing is known."""
        law = load_law(parameters.law_file)
        if issubclass(law, Law) and next(each for each in law.__mro__
                                         if 'check' in vars(each)) is not Law:
            with _refusing(parameters.law_file):
                law.check(gains, parameters, arm, control_rate)

    def reset(self) -> None:
        """Reset the law, where it has something to forget."""
        if hasattr(self._law, 'reset'):
            with _refusing(self.parameters.law_file):
                self._law.reset()

    def __call__(self, state: ArmState, reference: Reference, dt: float) -> Torque:
        """Return its torque, checked; where it gives six numbers, all but g(q) is feedback."""
        file = self.parameters.law_file
        with _refusing(file):
            given = self._law(ArmState(state.stamp, *map(_read_only, state[1:])),
                              Reference(*map(_read_only, reference)), dt)
        try:
            torque = real_numbers(given)
        except ValueError as error:
            raise InputError(f'{file}: the law returns {error}; return six numbers or a '
                             'Torque') from None
        if torque.shape not in ((6,), (5, 6)):
            raise InputError(f'{file}: the torque has the shape {torque.shape}; return six '
                             'numbers or a Torque')
        if not np.isfinite(torque).all():
            joint = int(np.argmin(np.isfinite(torque).reshape(-1, 6).all(axis=0)))
            raise InputError(f'{file}: the torque of joint {joint + 1} is '
                             f'{torque.reshape(-1, 6)[:, joint].sum()}; return finite numbers')
        if torque.shape == (5, 6):
            return Torque(*torque)
        g, zero = model_terms(state, self.arm)[2], np.zeros(6)
        return Torque(torque, zero, torque - g, zero, g)


@contextmanager
def _refusing(file: str) -> Iterator[None]:
    """Turn what a file raises into InputError, with its name."""
    try:
        yield
    except InputError as error:
        raise InputError(f'{file}: {error}') from None
    except (Exception, SystemExit) as error:
        raise InputError(f'{file}: {reason(error, str(Path(file).resolve()))}') from None


def _read_only(values: np.ndarray) -> np.ndarray:
    """Return a view that the law cannot write through."""
    view = values.view()
    view.flags.writeable = False
    return view
