"""Fingerprint of a machine: what repeatability to the last bit depends on."""

import platform
from pathlib import Path

from ur5_ros.config.distributions import providers

#: Packages that compute, or that decide how others do.
COMPUTING_PACKAGES = ('numpy', 'numba', 'llvmlite', 'pybullet', 'ruckig')

#: Processor features for which compilers and numpy choose other instructions and rounding.
ROUNDING_FEATURES = ('sse4_2', 'avx', 'avx2', 'fma', 'avx512f', 'avx512dq', 'avx512vl', 'amx_tile',
                     'asimd', 'sve', 'sve2')


def fingerprint() -> dict[str, str]:
    """
    Return what two machines must share for a run to be equal to the last bit.

    Python, C library, machine, processor features, and the version of each package that computes
    (``absent`` where it is not installed; with the name of the distribution where that is a fork).

    """
    found = {
        'python': f'{platform.python_implementation()} {platform.python_version()}',
        'c_library': ' '.join(platform.libc_ver()).strip() or platform.system(),
        'machine': f'{platform.system()} {platform.machine()}',
        'processor': processor_features(),
    }
    for package in COMPUTING_PACKAGES:
        found[package] = ' and '.join(providers(package)).removeprefix(f'{package} ') or 'absent'
    return found


def processor_features(source: Path = Path('/proc/cpuinfo')) -> str:
    """Return the processor's features that change rounding, in a fixed order, as one text."""
    try:
        lines = source.read_text(encoding='ascii', errors='replace').splitlines()
    except OSError:
        return platform.processor() or 'unknown'
    for line in lines:
        name, _, value = line.partition(':')
        if name.strip() in ('flags', 'Features'):
            flags = set(value.split())
            return ' '.join(feature for feature in ROUNDING_FEATURES if feature in flags)
    return platform.processor() or 'unknown'
