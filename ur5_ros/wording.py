"""Words in sentences: noun and verb agree with the number before them; how a run is called."""

from pathlib import Path

_SINGULAR = {'have': 'has', 'are': 'is', 'go': 'goes', 'do': 'does', 'pass': 'passes'}


def number_of(count: int, noun: str, total: int | None = None) -> str:
    """Return ``1 state``, ``2 states`` or, with a total, ``2 states of 9``."""
    whole = '' if total is None else f' of {total}'
    return f'{count} {noun}{"" if count == 1 else "s"}{whole}'


def agree(count: int, predicate: str) -> str:
    """Return a predicate, such as ``have no stamp``, whose verb agrees with a number."""
    verb, _, rest = predicate.partition(' ')
    if count == 1:
        verb = _SINGULAR.get(verb, f'{verb}s')
    return f'{verb} {rest}'.strip()


def run_title(folder: str, name: str) -> str:
    """Return how people call a run: by its folder, or by its name where it has none."""
    path = Path(folder)
    return f'{path.parent.name}/{path.name}' if path.name in ('sim', 'control') else (
        path.name or name)
