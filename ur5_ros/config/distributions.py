"""Which installed distribution provides a package: forks provide it under another name."""

from importlib.metadata import PackageNotFoundError, version

#: Distributions that provide a package under the name of another one.
FORKS = {'pybullet': ('pybullet-arm64',)}


def providers(package: str) -> list[str]:
    """Return name and version of each installed distribution that provides a package."""
    found = []
    for name in (package, *FORKS.get(package, ())):
        try:
            found.append(f'{name} {version(name)}')
        except PackageNotFoundError:
            continue
    return found
