"""The message types that are recorded: their definitions, ros2msg schema texts and type hashes."""

import hashlib
import json
from functools import cache

from ur5_ros.cdr.message_definition import Definition, parse_definition
from ur5_ros.errors import InputError

#: Fields of every recorded type, as in its .msg file of ROS 2 Jazzy (common_interfaces 5.3,
#: rcl_interfaces 2.0), comments left out. Types of the same package are named in full.
DEFINITIONS = {
    'builtin_interfaces/msg/Duration': 'int32 sec\nuint32 nanosec\n',
    'builtin_interfaces/msg/Time': 'int32 sec\nuint32 nanosec\n',
    'diagnostic_msgs/msg/DiagnosticArray':
        'std_msgs/Header header\ndiagnostic_msgs/DiagnosticStatus[] status\n',
    'diagnostic_msgs/msg/DiagnosticStatus':
        'byte OK=0\nbyte WARN=1\nbyte ERROR=2\nbyte STALE=3\nbyte level\nstring name\n'
        'string message\nstring hardware_id\ndiagnostic_msgs/KeyValue[] values\n',
    'diagnostic_msgs/msg/KeyValue': 'string key\nstring value\n',
    'geometry_msgs/msg/Point': 'float64 x\nfloat64 y\nfloat64 z\n',
    'geometry_msgs/msg/Pose':
        'geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n',
    'geometry_msgs/msg/PoseArray': 'std_msgs/Header header\ngeometry_msgs/Pose[] poses\n',
    'geometry_msgs/msg/PoseStamped': 'std_msgs/Header header\ngeometry_msgs/Pose pose\n',
    'geometry_msgs/msg/Quaternion':
        'float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n',
    'geometry_msgs/msg/Vector3': 'float64 x\nfloat64 y\nfloat64 z\n',
    'geometry_msgs/msg/Wrench':
        'geometry_msgs/Vector3 force\ngeometry_msgs/Vector3 torque\n',
    'geometry_msgs/msg/WrenchStamped': 'std_msgs/Header header\ngeometry_msgs/Wrench wrench\n',
    'nav_msgs/msg/Path': 'std_msgs/Header header\ngeometry_msgs/PoseStamped[] poses\n',
    'rosgraph_msgs/msg/Clock': 'builtin_interfaces/Time clock\n',
    'sensor_msgs/msg/CompressedImage':
        'std_msgs/Header header\nstring format\nuint8[] data\n',
    'sensor_msgs/msg/JointState':
        'std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\n'
        'float64[] effort\n',
    'std_msgs/msg/ColorRGBA': 'float32 r\nfloat32 g\nfloat32 b\nfloat32 a\n',
    'std_msgs/msg/Float64': 'float64 data\n',
    'std_msgs/msg/Float64MultiArray': 'std_msgs/MultiArrayLayout layout\nfloat64[] data\n',
    'std_msgs/msg/Header': 'builtin_interfaces/Time stamp\nstring frame_id\n',
    'std_msgs/msg/MultiArrayDimension': 'string label\nuint32 size\nuint32 stride\n',
    'std_msgs/msg/MultiArrayLayout':
        'std_msgs/MultiArrayDimension[] dim\nuint32 data_offset\n',
    'std_msgs/msg/String': 'string data\n',
    'trajectory_msgs/msg/JointTrajectory':
        'std_msgs/Header header\nstring[] joint_names\n'
        'trajectory_msgs/JointTrajectoryPoint[] points\n',
    'trajectory_msgs/msg/JointTrajectoryPoint':
        'float64[] positions\nfloat64[] velocities\nfloat64[] accelerations\n'
        'float64[] effort\nbuiltin_interfaces/Duration time_from_start\n',
    'visualization_msgs/msg/Marker':
        'std_msgs/Header header\nstring ns\nint32 id\nint32 type\nint32 action\n'
        'geometry_msgs/Pose pose\ngeometry_msgs/Vector3 scale\nstd_msgs/ColorRGBA color\n'
        'builtin_interfaces/Duration lifetime\nbool frame_locked\ngeometry_msgs/Point[] points\n'
        'std_msgs/ColorRGBA[] colors\nstring texture_resource\n'
        'sensor_msgs/CompressedImage texture\n'
        'visualization_msgs/UVCoordinate[] uv_coordinates\nstring text\n'
        'string mesh_resource\nvisualization_msgs/MeshFile mesh_file\n'
        'bool mesh_use_embedded_materials\n',
    'visualization_msgs/msg/MarkerArray': 'visualization_msgs/Marker[] markers\n',
    'visualization_msgs/msg/MeshFile': 'string filename\nuint8[] data\n',
    'visualization_msgs/msg/UVCoordinate': 'float32 u\nfloat32 v\n',
}

#: Line between the parts of a ros2msg schema (MCAP registry of well-known schema encodings).
SEPARATOR = '=' * 80

#: Kinds of field in the type description that is hashed (REP-2016, type_description_interfaces).
_KINDS = {'nested': 1, 'int8': 2, 'uint8': 3, 'int16': 4, 'uint16': 5, 'int32': 6, 'uint32': 7,
          'int64': 8, 'uint64': 9, 'float32': 10, 'float64': 11, 'bool': 15, 'byte': 16,
          'string': 17}
_BOUNDED_STRING = 21
_ARRAY, _BOUNDED_SEQUENCE, _SEQUENCE = 48, 96, 144


@cache
def definition(type_name: str) -> Definition:
    """Return the fields of a recorded type; InputError for any other type."""
    if type_name not in DEFINITIONS:
        raise InputError(f'message type {type_name!r} is not recorded; known: '
                         + ', '.join(sorted(DEFINITIONS)))
    return parse_definition(type_name, DEFINITIONS[type_name])


def dependencies(type_name: str) -> list[str]:
    """Return the types that a recorded type is made of, itself left out, in order of use."""
    found: list[str] = []

    def visit(name: str) -> None:
        for field in definition(name):
            if field.nested and field.base not in found:
                found.append(field.base)
                visit(field.base)

    visit(type_name)
    return found


def schema_text(type_name: str) -> str:
    """Return the ros2msg schema of a recorded type: its definition and those that it needs."""
    definition(type_name)
    text = DEFINITIONS[type_name]
    for name in dependencies(type_name):
        package, _, short = name.partition('/msg/')
        text += f'{SEPARATOR}\nMSG: {package}/{short}\n{DEFINITIONS[name]}'
    return text


def _description(type_name: str) -> dict:
    """Return the type description of one type, in the order of keys that is hashed."""
    fields = []
    for field in definition(type_name):
        kind = _KINDS['nested' if field.nested else field.base]
        if field.text_bound:
            kind = _BOUNDED_STRING
        if field.array:
            kind += {'fixed': _ARRAY, 'bounded': _BOUNDED_SEQUENCE, 'open': _SEQUENCE}[field.array]
        fields.append({'name': field.name, 'type': {
            'type_id': kind, 'capacity': field.size, 'string_capacity': field.text_bound,
            'nested_type_name': field.base if field.nested else ''}})
    return {'type_name': type_name, 'fields': fields}


@cache
def type_hash(type_name: str) -> str:
    """Return the RIHS01 hash of a recorded type (REP-2016), as rclpy and rosbag2 name it."""
    described = {
        'type_description': _description(type_name),
        'referenced_type_descriptions': [_description(name)
                                         for name in sorted(dependencies(type_name))],
    }
    return 'RIHS01_' + hashlib.sha256(json.dumps(described).encode()).hexdigest()
