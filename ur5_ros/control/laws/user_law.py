"""A law in a file of the user: loaded, called, and refused in one line where it is wrong."""

import importlib.util
import sys
import traceback
from functools import lru_cache
from pathlib import Path

import numpy as np

from ur5_ros.config.node_parameters import ControlParameters
from ur5_ros.control.gains import Gains
from ur5_ros.control.laws.law import Law, model_terms
from ur5_ros.errors import InputError
from ur5_ros.model.parameters import ArmParameters
from ur5_ros.signals import ArmState, Reference, Torque

#: The class that a file defines.
CLASS = 'Law'


def load_law(file: str) -> type:
    """
    Return the class ``Law`` of a Python file.

    Parameters
    ----------
    file : str
        Path.

    Raises
    ------
    InputError
        If there is no such file, it cannot be imported, or has no such class.

    """
    path = Path(file)
    if not path.is_file():
        raise InputError(f'no file {file}; give a Python file that defines class {CLASS}')
    return _load(str(path.resolve()), path.stat().st_mtime_ns)


@lru_cache(maxsize=64)
def _load(file: str, _: int) -> type:
    """Return the class of a file, imported once for each time that it is written."""
    name = f'ur5_ros_law_{abs(hash(file))}'
    spec = importlib.util.spec_from_file_location(name, file)
    if spec is None or spec.loader is None:
        raise InputError(f'{file} is no Python file; give one whose name ends in .py')
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # dataclasses in it look their module up
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        raise InputError(f'{file}: {reason(error, file)}; the file must be importable') from None
    law = getattr(module, CLASS, None)
    if not isinstance(law, type):
        raise InputError(f'{file} defines no class {CLASS}; give it one with __init__(arm, gains, '
                         'parameters) and __call__(state, reference, dt)')
    return law


def reason(error: BaseException, file: str) -> str:
    """Return an exception of somebody's file in one line, with the line where it arose."""
    lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__)
             if frame.filename == file]
    if isinstance(error, SyntaxError) and error.filename == file:
        lines = [error.lineno]
    text = ' '.join(str(getattr(error, 'msg', error)).split())
    where = f' (line {lines[-1]})' if lines else ''
    return f'{type(error).__name__}: {text}{where}'


class UserLaw(Law):
    """The law of ``law_file``."""

    def __init__(self, arm: ArmParameters, gains: Gains, parameters: ControlParameters) -> None:
        super().__init__(arm, gains, parameters)
        self._file = str(Path(parameters.law_file).resolve())
        law = load_law(parameters.law_file)
        try:
            self._law = law(arm, gains, parameters)
        except Exception as error:
            raise self._refusal(error) from None
        if not callable(self._law):
            raise InputError(f'{parameters.law_file}: class {CLASS} has no __call__(state, '
                             'reference, dt)')

    @classmethod
    def check(cls, gains: Gains, parameters: ControlParameters, arm: ArmParameters,
              control_rate: int) -> None:
        """Refuse what the class itself refuses in a method ``check``; else nothing is known."""
        law = load_law(parameters.law_file)
        if issubclass(law, Law) and law.check.__func__ is not Law.check.__func__:  # type: ignore
            law.check(gains, parameters, arm, control_rate)

    def reset(self) -> None:
        """Reset the law, where it has something to forget."""
        if hasattr(self._law, 'reset'):
            self._law.reset()

    def __call__(self, state: ArmState, reference: Reference, dt: float) -> Torque:
        """Return its torque, checked; where it gives six numbers, all but g(q) is feedback."""
        try:
            given = self._law(state, reference, dt)
            torque = np.array(given, dtype=float)
        except InputError:
            raise
        except Exception as error:
            raise self._refusal(error) from None
        if torque.shape not in ((6,), (5, 6)):
            raise InputError(f'{self.parameters.law_file}: the torque has the shape '
                             f'{torque.shape}; return six numbers or a Torque')
        if not np.isfinite(torque).all():
            joint = int(np.argmin(np.isfinite(torque).reshape(-1, 6).all(axis=0)))
            raise InputError(f'{self.parameters.law_file}: the torque of joint {joint + 1} is '
                             f'{torque.reshape(-1, 6)[:, joint].sum()}; return finite numbers')
        if torque.shape == (5, 6):
            return Torque(*torque)
        g, zero = model_terms(state, self.arm)[2], np.zeros(6)
        return Torque(torque, zero, torque - g, zero, g)

    def _refusal(self, error: Exception) -> InputError:
        return InputError(f'{self.parameters.law_file}: {reason(error, self._file)}')
