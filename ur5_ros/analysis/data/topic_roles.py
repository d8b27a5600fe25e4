"""The roles that topics play in a run, their types and columns."""

from ur5_ros.analysis.data.joint_names import with_prefix
from ur5_ros.config.topics import (
    CONTROL_TOPICS,
    ROBOT_TOPICS,
    SIM_TOPICS,
    WORLD_TOPICS,
    by_role,
)

#: Parts of a recorded torque, in the order of its columns.
PART_NAMES = ('total', 'inertial', 'feedback', 'coriolis', 'gravity')

#: Roles that are read -> fields that the messages must fill.
ROLE_FIELDS: dict[str, tuple[str, ...]] = {
    'joint_states': ('position',), 'joint_command': ('effort',),
    'ground_truth': ('position', 'velocity'), 'torque_parts': ('effort',),
    'reference': ('positions',), 'events': (), 'contact_effort': ('effort',), 'contacts': (),
    'objects': (), 'motor_current': ('effort',), 'joint_temperature': (),
    'forward_command': (), 'target_wrench': (), 'robot_description': ()}

#: Roles that are no numbers by joint.
RAW_ROLES = ('events', 'contacts', 'objects', 'joint_temperature', 'forward_command',
             'target_wrench', 'robot_description')

_DECLARED = by_role((*SIM_TOPICS, *WORLD_TOPICS, *CONTROL_TOPICS, *ROBOT_TOPICS))
ROLE_TYPES = {role: _DECLARED[role].type for role in ROLE_FIELDS}
#: How the name of a topic ends in bags that do not state its role.
ROLE_ENDINGS = {role: _DECLARED[role].name.removeprefix('~') for role in ROLE_FIELDS}


def role_columns(role: str, prefix: str) -> list[str] | None:
    """Return the names of the columns of a role."""
    joints = with_prefix(prefix)
    if role in RAW_ROLES:
        return None
    if role == 'torque_parts':
        return [f'{part}/{joint}' for part in PART_NAMES for joint in joints]
    return joints
