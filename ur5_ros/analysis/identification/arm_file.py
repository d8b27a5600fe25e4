"""An identified arm as an arm file."""

import json
from pathlib import Path

import numpy as np

from ur5_ros.analysis.identification.identify import Identified
from ur5_ros.errors import InputError
from ur5_ros.model.parameters import ArmParameters

_LINKS = ('shoulder', 'upper_arm', 'forearm', 'wrist_1', 'wrist_2', 'wrist_3')


def write_arm(found: Identified, path: Path | str) -> None:
    """
    Write an identified arm as a file that every command takes for ``--arm``.

    Raises
    ------
    InputError
        If the file exists or cannot be written.

    """
    path = Path(path)
    try:
        with open(path, 'x', encoding='utf-8') as file:
            file.write(identified_yaml(found))
    except FileExistsError:
        raise InputError(f'{path} exists already; give another file') from None
    except OSError as error:
        raise InputError(f'{path}: cannot be written: {error.strerror}') from None


def identified_yaml(found: Identified) -> str:
    """Return an identified arm, its friction included, as the YAML text of an arm file."""
    source = (f'identified by least squares and the nearest physical arm; torque error on '
              f'{found.test_run}: '
              + ', '.join(f'{value:.2g}' if np.isfinite(value) else '-'
                          for value in found.test_rms) + ' N m RMS a joint')
    return arm_yaml(found.arm, source, 'Identified from recorded torques.')


def arm_yaml(arm: ArmParameters, source: str, description: str = 'An arm.') -> str:
    """
    Return an arm as the YAML text of an arm file.

    Parameters
    ----------
    arm : ArmParameters
        The arm; its payload is left out.
    source : str
        Where masses, tensors, rotor inertia and friction come from.
    description : str
        One sentence.

    """
    quoted = json.dumps(source)
    lines = [f'name: {json.dumps(arm.name)}', f'description: {json.dumps(description)}',
             'dh:', '  source: "as the arm that the identification began with"',
             f'  a: {_numbers(arm.a)}', f'  d: {_numbers(arm.d)}',
             f'  alpha: {_numbers(arm.alpha)}',
             'angle_offset:', '  source: "likewise"', f'  value: {_numbers(arm.angle_offset)}',
             'links:']
    for name, mass, com, tensor in zip(_LINKS, arm.mass, arm.com, arm.inertia, strict=True):
        six = tensor[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
        lines += [f'  - name: {name}', f'    mass: {float(mass)!r}', f'    com: {_numbers(com)}',
                  f'    inertia: {_numbers(six)}', f'    source: {quoted}']
    position = ['null' if not np.isfinite(low) else _numbers([low, high])
                for low, high in zip(arm.limits.lower, arm.limits.upper, strict=True)]
    lines += ['armature:', f'  source: {quoted}', f'  value: {_numbers(arm.armature)}',
              'gravity:', '  source: "as the arm that the identification began with"',
              f'  value: {_numbers(arm.gravity)}',
              'limits:', '  source: "likewise"',
              '  position:', *(f'    - {each}' for each in position),
              f'  velocity: {_numbers(arm.limits.velocity)}',
              f'  effort: {_numbers(arm.limits.effort)}']
    for name in ('viscous', 'coulomb') if not arm.friction.none else ():
        lines += ['friction:'] if name == 'viscous' else []
        lines += [f'  {name}:', f'    source: {quoted}',
                  f'    value: {_numbers(getattr(arm.friction, name))}']
    return '\n'.join(lines) + '\n'


def _numbers(values) -> str:
    return '[' + ', '.join(repr(float(value)) for value in values) + ']'
