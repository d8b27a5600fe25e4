"""An arm as the YAML text of an arm file."""

import json
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from ur5_ros.errors import InputError
from ur5_ros.model.friction import JointFriction
from ur5_ros.model.parameters import ArmParameters

#: Parts of friction that an arm need not have.
_MORE_FRICTION = ('static', 'load_factor', 'viscous_quadratic', 'viscous_cubic', 'asymmetry')

_LINKS = ('shoulder', 'upper_arm', 'forearm', 'wrist_1', 'wrist_2', 'wrist_3')


def arm_file_text(arm: ArmParameters, description: str, links: str, rest: str) -> str:
    """
    Return an arm, its payload left out, as the text of an arm file.

    ``links`` is the source of masses, tensors, rotors and friction, ``rest`` that of geometry,
    gravity and limits.

    """
    quoted, other = json.dumps(links), json.dumps(rest)
    lines = [f'name: {json.dumps(arm.name)}', f'description: {json.dumps(description)}',
             'dh:', f'  source: {other}', f'  a: {numbers(arm.a)}', f'  d: {numbers(arm.d)}',
             f'  alpha: {numbers(arm.alpha)}',
             'angle_offset:', f'  source: {other}', f'  value: {numbers(arm.angle_offset)}',
             'links:']
    for name, mass, com, tensor in zip(_LINKS, arm.mass, arm.com, arm.inertia, strict=True):
        six = tensor[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
        lines += [f'  - name: {name}', f'    mass: {float(mass)!r}', f'    com: {numbers(com)}',
                  f'    inertia: {numbers(six)}', f'    source: {quoted}']
    position = ['null' if not np.isfinite(low) else numbers([low, high])
                for low, high in zip(arm.limits.lower, arm.limits.upper, strict=True)]
    lines += ['armature:', f'  source: {quoted}', f'  value: {numbers(arm.armature)}',
              'gravity:', f'  source: {other}', f'  value: {numbers(arm.gravity)}',
              'limits:', f'  source: {other}',
              '  position:', *(f'    - {each}' for each in position),
              f'  velocity: {numbers(arm.limits.velocity)}',
              f'  effort: {numbers(arm.limits.effort)}']
    lines += _friction(arm.friction, quoted)
    motors = {name: value for name in ('torque_constant', 'unexplained_torque')
              if (value := getattr(arm, name)) is not None}
    lines += ['motors:'] if motors else []
    for name, value in motors.items():
        lines += [f'  {name}:', f'    source: {quoted}', f'    value: {numbers(value)}']
    return '\n'.join(lines) + '\n'


def _friction(friction: JointFriction, source: str) -> list[str]:
    """Return the section of friction: viscous and Coulomb, and the parts that are there."""
    if friction.none:
        return []
    parts = ['viscous', 'coulomb', *(name for name in _MORE_FRICTION
                                     if np.any(getattr(friction, name)))]
    if 'static' in parts:
        parts.append('stribeck_velocity')
    return ['friction:', *(line for name in parts for line in (
        f'  {name}:', f'    source: {source}', f'    value: {numbers(getattr(friction, name))}'))]


def numbers(values: Iterable[float]) -> str:
    """Return numbers as a YAML list."""
    return '[' + ', '.join(repr(float(value)) for value in values) + ']'


def write_new_file(path: Path | str, text: str) -> None:
    """Write a file that must not exist; InputError if it does or cannot be written."""
    try:
        Path(path).parent.mkdir(parents=True, exist_ok=True)
        with open(path, 'x', encoding='utf-8') as file:
            file.write(text)
    except FileExistsError:
        raise InputError(f'{path} exists already; give another file') from None
    except OSError as error:
        raise InputError(f'{path}: cannot be written: {error.strerror}') from None
