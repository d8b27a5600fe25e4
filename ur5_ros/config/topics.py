"""Topics of the two nodes, declared once for nodes, bags, loop, analysis and documents."""

from collections.abc import Iterable
from typing import NamedTuple


class Qos(NamedTuple):
    """Quality of service, in the words of rosbag2."""

    reliability: str = 'reliable'
    durability: str = 'volatile'
    depth: int = 1


#: States, commands and everything else that is published.
NEWEST = Qos()
#: /clock: a lost one is harmless, as the next one replaces it.
UNACKNOWLEDGED = Qos('best_effort')
#: What a late joiner gets too.
LATCHED = Qos(durability='transient_local')
#: Events come in bursts, and none may be lost.
BURST = Qos(depth=100)
#: Our own subscriptions of every period: no acknowledgement travels back, a third of the period.
HOT = Qos('best_effort', depth=10)
#: Our other subscriptions.
QUEUED = Qos(depth=10)


class Topic(NamedTuple):
    """One topic of a node, published or subscribed to, and recorded."""

    role: str
    """The part that it plays, by which a bag's description names it."""
    name: str
    """Before remapping and namespace; ``~`` is the node's own name."""
    type: str
    published: bool
    """Whether the node publishes it; it subscribes to the others."""
    unit: str
    notes: str
    qos: Qos = NEWEST
    lazy: bool = False
    """Whether it is published only while there is a subscription; it is recorded always."""

    def absolute(self, node: str) -> str:
        """Return the name in the root namespace, without remapping."""
        return '/' + self.name.replace('~', node).removeprefix('/')


_JOINTS, _STATUS = 'sensor_msgs/msg/JointState', 'diagnostic_msgs/msg/DiagnosticArray'
_TEXT, _NUMBER = 'std_msgs/msg/String', 'std_msgs/msg/Float64'
_POSE = 'geometry_msgs/msg/PoseStamped'
_TRAJECTORY = 'trajectory_msgs/msg/JointTrajectory'

SIM_NODE, CONTROL_NODE = 'ur5_sim', 'ur5_control'

SIM_TOPICS = (
    Topic('joint_states', 'joint_states', _JOINTS, True, 'rad, rad/s, N m',
          'every period, also before the first command; effort = torque that acted, after limits'),
    Topic('clock', '/clock', 'rosgraph_msgs/msg/Clock', True, 's', '`publish_clock`',
          UNACKNOWLEDGED, lazy=True),
    Topic('ground_truth', '~/ground_truth', _JOINTS, True, 'rad, rad/s, N m',
          'exact state; only while noise, delay or `effort_feedback` hides it'),
    Topic('events', '~/events', _STATUS, True, '', 'see below', BURST),
    Topic('diagnostics', '/diagnostics', _STATUS, True, '',
          '1 Hz; counts of everything refused'),
    Topic('run', '~/run', _TEXT, True, '', 'the name of the run', LATCHED),
    Topic('control_rate', '~/control_rate', _NUMBER, True, 'Hz', 'control periods a second',
          LATCHED),
    Topic('robot_description', 'robot_description', _TEXT, True, '',
          'the URDF that the simulator loads', LATCHED),
    Topic('joint_command', 'joint_command', _JOINTS, False, 'N m',
          '`name`, `effort`; stamp of the state it answers, or zero', HOT),
    Topic('forward_command', 'forward_effort_controller/commands',
          'std_msgs/msg/Float64MultiArray', False, 'N m', 'six torques in joint order', QUEUED),
    Topic('external_wrench', '~/external_wrench', 'geometry_msgs/msg/WrenchStamped', False,
          'N, N m', 'at the tool, until zero is sent or `wrench_duration` is over', QUEUED),
)

#: What the simulator publishes besides, where there is a world to touch.
WORLD_TOPICS = (
    Topic('contact_effort', '~/contact_effort', _JOINTS, True, 'N m',
          'joint torque of all contacts, adds to `effort`; one message a physics step, stamped at '
          'its end; only with a `world`'),
    Topic('wrench', 'force_torque_sensor_broadcaster/wrench', 'geometry_msgs/msg/WrenchStamped',
          True, 'N, N m', 'of the environment on the tool, at and in `tool0`, every period; only '
          'with a `world`'),
    Topic('contacts', '~/contacts', 'visualization_msgs/msg/MarkerArray', True, 'm',
          'forces as arrows, 10 mm a newton: red normal, olive friction, at `monitor_rate`; '
          'only with a `world`'),
    Topic('objects', '~/objects', 'geometry_msgs/msg/PoseArray', True, 'm',
          'free bodies in `base`, in the order of the file, at `monitor_rate`; only with a '
          '`world`'),
)

CONTROL_TOPICS = (
    Topic('joint_command', 'joint_command', _JOINTS, True, 'N m', '`name`, `effort`'),
    Topic('reference', '~/reference', _TRAJECTORY, True, 'rad, rad/s, rad/s^2, N m',
          'every period one point: q*, q̇*, q̈*, feed-forward torque', lazy=True),
    Topic('torque_parts', '~/torque_parts', _JOINTS, True, 'N m',
          'efforts named `part/joint`: total, inertial, feedback, coriolis, gravity; recorded '
          'every period, published at `monitor_rate`', lazy=True),
    Topic('error', '~/error', _JOINTS, True, 'rad, rad/s',
          'state less reference, at `monitor_rate`', lazy=True),
    Topic('tool_pose', '~/tool_pose', _POSE, True, 'm', 'in `base`, at `monitor_rate`',
          lazy=True),
    Topic('reference_pose', '~/reference_pose', _POSE, True, 'm', 'in `base`, at `monitor_rate`',
          lazy=True),
    Topic('diagnostics', '/diagnostics', _STATUS, True, '', 'state, inverse-kinematic branch, '
          'distance to singularity, refused inputs'),
    Topic('target_joints', '~/target_joints', _JOINTS, False, 'rad', '`name`, `position`',
          QUEUED),
    Topic('target_pose', '~/target_pose', _POSE, False, 'm', 'in `base` or `base_link`; nearest '
          'inverse-kinematic solution, then a jerk-limited motion', QUEUED),
    Topic('joint_trajectory', '~/joint_trajectory', _TRAJECTORY, False,
          'rad, rad/s, rad/s^2', 'rules of the joint_trajectory_controller', QUEUED),
    Topic('path', '~/path', 'nav_msgs/msg/Path', False, 'm', 'tool poses to pass in straight '
          'lines, timed by stamps or by `tool_speed`', QUEUED),
    Topic('target_wrench', '~/target_wrench', 'geometry_msgs/msg/WrenchStamped', False, 'N, N m',
          'of the tool on its surroundings, in `base`, `base_link` or `tool0` as it stands; mode '
          'cartesian_impedance', QUEUED),
    Topic('joint_states', 'joint_states', _JOINTS, False, 'rad, rad/s, N m', 'the robot', HOT),
    Topic('run', f'{SIM_NODE}/run', _TEXT, False, '', 'the name of the run', LATCHED),
    Topic('control_rate', f'{SIM_NODE}/control_rate', _NUMBER, False, 'Hz',
          'control periods a second', LATCHED),
)

#: What a real robot's log is imported as, beside what ur5_control publishes.
ROBOT_TOPICS = (
    Topic('motor_current', '~/motor_current', _JOINTS, True, 'A', 'measured motor currents'),
    Topic('joint_temperature', '~/joint_temperature', 'std_msgs/msg/Float64MultiArray', True,
          'deg C', 'six measured temperatures in joint order, once a second'),
)


def by_role(topics: Iterable[Topic]) -> dict[str, Topic]:
    """Return topics by their role."""
    return {topic.role: topic for topic in topics}
