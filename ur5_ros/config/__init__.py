"""YAML files to records; the only reader of the folder ``config/``."""

from ur5_ros.config.arms import arm_text, known_arms, list_arms, load_arm, parse_arm
from ur5_ros.config.parameters import CONTROL_PARAMETERS, SIM_PARAMETERS, Parameter, complete
from ur5_ros.config.strict_yaml import config_folder, parse_yaml, read_yaml

__all__ = [
    'CONTROL_PARAMETERS', 'SIM_PARAMETERS', 'Parameter', 'arm_text', 'complete', 'config_folder',
    'known_arms', 'list_arms', 'load_arm', 'parse_arm', 'parse_yaml', 'read_yaml',
]
