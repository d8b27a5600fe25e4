"""What was added to the plant of a run: payload, friction, noise, delay, wrench, gravity."""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from ur5_ros.analysis.data.run import NodeRecord, Run
from ur5_ros.config.parameters import SIM_PARAMETERS

#: Live parameters that add nothing to the plant.
_NEUTRAL = ('fallback', 'overspeed_stop', 'wrench_duration', 'seed')


class Injection(NamedTuple):
    """One addition to the plant."""

    t: float
    """Time since the first state from which it acts [s]."""
    text: str


def injections(run: Run) -> list[Injection]:
    """Return what was added to the plant from the start and later, in order of time."""
    return [*_at_start(run), *_later(run)]


def _at_start(run: Run) -> Iterator[Injection]:
    if run.sim is None:
        return
    own = _of_arm_file(run.sim)
    if own:
        yield Injection(0.0, f'friction of {run.sim.arm_name}')
    for parameter in SIM_PARAMETERS:
        value = run.sim.parameters.get(parameter.name, parameter.default)
        if (parameter.live and parameter.name not in (*_NEUTRAL, *own)
                and value != parameter.default):
            yield Injection(0.0, f'{parameter.name} {_value(value)}')


def _of_arm_file(sim: NodeRecord) -> list[str]:
    """Return the parameters of friction that have their values from the arm's file."""
    if not sim.parameters.get('friction.from_arm'):
        return []
    parts = {f'friction.{part}': value.tolist() for part, value in vars(sim.arm.friction).items()}
    return [name for name, value in parts.items() if sim.parameters.get(name) == value]


def _later(run: Run) -> Iterator[Injection]:
    for event in run.events:
        if text := injected_by(event.kind, event.values):
            yield Injection((event.stamp - int(run.stamp[0])) * 1e-9, text)


def injected_by(kind: str, values: Mapping[str, Any]) -> str:
    """Return what an event of the simulator adds to the plant; empty for nothing."""
    name = values.get('name')
    if kind == 'parameter' and name not in _NEUTRAL:
        return f'{name} {_value(values.get("value"))}'
    if kind == 'wrench':
        force, torque = values.get('force', []), values.get('torque', [])
        ended = not any(force) and not any(torque)
        return 'wrench ends' if ended else f'wrench {_value(force)} N, {_value(torque)} N m'
    return kind.replace('_', ' ') if kind in ('reset', 'protective_stop') else ''


def _value(value: Any) -> str:
    if isinstance(value, list | tuple):
        numbers = [_value(each) for each in value]
        return numbers[0] if len(set(numbers)) == 1 and len(numbers) > 3 else ' '.join(numbers)
    return f'{value:.4g}' if isinstance(value, int | float) else str(value)
