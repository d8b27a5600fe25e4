"""The description of a bag: its node, arm, parameters and versions."""

import json
from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, version
from typing import Any

#: Version of the description and of the summary.
FORMAT = '1'

#: Packages whose versions a bag names.
PACKAGES = ('ur5_ros', 'numpy', 'numba', 'pybullet', 'ruckig', 'rclpy', 'ros-jazzy-rclpy')


def describe(
    node: str,
    run: str,
    arm_name: str,
    arm_text: str,
    parameters: Mapping[str, Any],
    topics: Mapping[str, str],
    fingerprint: Mapping[str, str],
    world_text: str = '',
) -> dict[str, str]:
    """
    Return the description that goes into a bag's metadata record and its metadata.yaml.

    ``node``: ``'sim'`` or ``'control'``; ``topics``: role to resolved topic name, such as
    ``{'joint_states': '/joint_states'}``; ``world_text``: the YAML text of what stands around the
    arm; empty for nothing.  Returned: texts; a value of another type is JSON.
    """
    return {
        'format': FORMAT,
        'run': run,
        'node': node,
        'arm_name': arm_name,
        'arm': arm_text,
        'parameters': json.dumps(dict(parameters), sort_keys=True),
        'versions': json.dumps(_versions(), sort_keys=True),
        'fingerprint': json.dumps(dict(fingerprint), sort_keys=True),
        'seed': str(parameters.get('seed', 0)),
        'topics': json.dumps(dict(topics), sort_keys=True),
        **({'world': world_text} if world_text else {}),
    }


def _versions() -> dict[str, str]:
    found = {}
    for package in PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            continue
    return found
