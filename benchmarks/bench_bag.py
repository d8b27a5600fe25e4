"""Reading and writing bags beside rosbags, both mcap-ros2-support, mcap and rclpy."""

import gc
import os
import sys
import tempfile
import time
from importlib import import_module
from pathlib import Path

import child
import numpy as np
from rivals import optional
from side_by_side import Row, arguments, interleave, publish, ratio

from ur5_ros.bag.reader import open_bag
from ur5_ros.bag.writer import MAX_WAITING, BagWriter
from ur5_ros.cdr.fixed_messages import FixedJointState
from ur5_ros.cdr.recorded_types import schema_text
from ur5_ros.launcher.node_processes import private_environment
from ur5_ros.signals import JOINT_NAMES

JOINT_STATE = 'sensor_msgs/msg/JointState'
MESSAGES = 1_000_000
REPEATS = 3
#: Messages handed over in one go when the cost of writing is measured.
BURST = 20_000
#: Other readers, and the module of the newest of them.
PEERS = ('rosbags', 'mcap-ros2-support', 'mcap-ros2-support-fast')
FAST = 'mcap_ros2_support_fast.decoder'


def write_bag(folder: Path, messages: int) -> int:
    """Write states of a moving arm at 1 kHz; return the decoded size of the bag [bytes]."""
    codec = FixedJointState(JOINT_NAMES)
    rng = np.random.default_rng(0)
    values = rng.normal(size=(1000, 3, 6))
    with BagWriter(folder, {'run': 'benchmark'}) as writer:
        topic = writer.topic('/joint_states', JOINT_STATE)
        for k in range(1, messages + 1):
            writer.write(topic, k * 1_000_000, codec.encode(k * 1_000_000, *values[k % 1000]))
            if k % (MAX_WAITING // 4) == 0:
                time.sleep(0.5)
    assert writer.lost == 0
    return messages * codec.size


def load_ours(folder: Path) -> float:
    """Return the processor seconds in which we load all states into arrays."""
    start = time.process_time()
    states = open_bag(folder).joint_states('/joint_states')
    taken = time.process_time() - start
    assert states.position.shape[1] == 6 and states.skipped == 0
    return taken


def load_rosbags(folder: Path) -> float:
    """Return the processor seconds in which rosbags and a loop fill the same arrays."""
    from rosbags.highlevel import AnyReader
    start = time.process_time()
    with AnyReader([folder]) as reader:
        number = reader.message_count
        stamp, table = np.empty(number, np.int64), np.empty((3, number, 6))
        for k, (connection, _, data) in enumerate(reader.messages()):
            state = reader.deserialize(data, connection.msgtype)
            stamp[k] = state.header.stamp.sec * 1_000_000_000 + state.header.stamp.nanosec
            table[0, k], table[1, k], table[2, k] = state.position, state.velocity, state.effort
    return time.process_time() - start


def load_mcap_ros2(folder: Path, decoder: str = 'mcap_ros2.decoder') -> float:
    """Return the processor seconds in which mcap, a decoder and a loop fill the same arrays."""
    from mcap.reader import make_reader
    factory = import_module(decoder).DecoderFactory
    start = time.process_time()
    stamp, position, velocity, effort = [], [], [], []
    for path in sorted(folder.glob('*.mcap')):
        with open(path, 'rb') as file:
            reader = make_reader(file, validate_crcs=True, decoder_factories=[factory()])
            for _, _, _, state in reader.iter_decoded_messages(log_time_order=False):
                stamp.append(state.header.stamp.sec * 1_000_000_000 + state.header.stamp.nanosec)
                position.append(state.position)
                velocity.append(state.velocity)
                effort.append(state.effort)
    np.array(stamp), np.array(position), np.array(velocity), np.array(effort)
    return time.process_time() - start


MEMORY = """
import sys
from pathlib import Path
from ur5_ros.bag.reader import open_bag
from ur5_ros.bag.mcap.message_index import CompiledMessageIndex
def memory(name):
    lines = Path('/proc/self/status').read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith(name))
CompiledMessageIndex()
before = memory('VmRSS')
states = open_bag(sys.argv[1]).joint_states('/joint_states')
print(memory('VmHWM') - before)
"""


def memory_of_loading(folder: Path) -> int:
    """Return by how much the peak memory of a fresh process grows when it loads a bag [bytes]."""
    out = child.call([sys.executable, '-c', MEMORY, str(folder)], capture_output=True,
                     text=True).stdout
    return int(out) * 1024


def burst(action) -> float:
    """Return the seconds that one call costs its caller, in a burst of calls."""
    gc.collect()
    start = time.perf_counter()
    for k in range(BURST):
        action(k)
    return (time.perf_counter() - start) / BURST


def hand_over(folder: Path, data: bytes) -> float:
    """Return the seconds that the loop spends to record one message."""
    with BagWriter(folder, {}) as writer:
        topic = writer.topic('/joint_states', JOINT_STATE)
        return burst(lambda k: writer.write(topic, k, data))


def record_all(folder: Path, data: bytes) -> float:
    """Return the seconds a message from the first hand-over to the closed bag."""
    start = time.perf_counter()
    hand_over(folder, data)
    return (time.perf_counter() - start) / BURST


def record_mcap(path: Path, data: bytes, whole: bool) -> float:
    """Return the seconds a message that mcap's writer takes (64 KiB LZ4 chunks)."""
    from mcap.writer import CompressionType, Writer
    start = time.perf_counter()
    with open(path, 'wb') as file:
        writer = Writer(file, chunk_size=64 << 10, compression=CompressionType.LZ4)
        writer.start('ros2')
        schema = writer.register_schema(JOINT_STATE, 'ros2msg', schema_text(JOINT_STATE).encode())
        channel = writer.register_channel('/joint_states', 'cdr', schema)
        each = burst(lambda k: writer.add_message(channel, k, data, k))
        writer.finish()
    return (time.perf_counter() - start) / BURST if whole else each


def writing(folder: Path) -> dict:
    """Return what can be measured of writing, by name."""
    data = FixedJointState(JOINT_NAMES).encode(1, *np.random.default_rng(1).normal(size=(3, 6)))
    count = iter(range(10**9))

    def fresh() -> Path:
        return folder / f'write{next(count)}'

    candidates = {
        'handing over': lambda: hand_over(fresh(), data),
        'recording': lambda: record_all(fresh(), data),
        'mcap, in the loop': lambda: record_mcap(fresh(), data, whole=False),
        'mcap': lambda: record_mcap(fresh(), data, whole=True),
    }
    try:
        import rclpy
        from rclpy.qos import QoSProfile
        from sensor_msgs.msg import JointState
    except ImportError:
        return candidates
    os.environ.update(private_environment())
    rclpy.init()
    publisher = rclpy.create_node('benchmark').create_publisher(
        JointState, '/benchmark', QoSProfile(depth=1))
    return candidates | {'publishing': lambda: burst(lambda k: publisher.publish(data))}


def main() -> None:
    """Measure and keep the table."""
    parser = arguments(__doc__, REPEATS)
    parser.add_argument('--messages', type=int, default=MESSAGES)
    options = parser.parse_args()
    if options.quick:
        options.messages, options.repeats = 20_000, 1
    with tempfile.TemporaryDirectory(prefix='ur5-bench-') as name:
        folder = Path(name) / 'bag'
        decoded = write_bag(folder, options.messages)
        tenth = Path(name) / 'tenth'
        write_bag(tenth, options.messages // 10)
        load_ours(folder)  # compiled code is loaded once a process
        # the others loop over the messages: ten times as many take ten times as long
        readers = {
            'ours': lambda: load_ours(folder),
            'a tenth': lambda: load_ours(tenth),
            'rosbags': lambda: 10.0 * load_rosbags(tenth),
            'mcap-ros2-support': lambda: 10.0 * load_mcap_ros2(tenth),
        }
        if optional(FAST):
            readers['mcap-ros2-support-fast'] = lambda: 10.0 * load_mcap_ros2(tenth, FAST)
        reading = interleave(readers, options.repeats)
        memory = memory_of_loading(folder)
        figures = reading | interleave(
            writing(Path(name)), 1 if options.quick else 7)
    loading = f'loading {options.messages} JointState messages into arrays'
    rows = [
        *(Row(f'speed of {loading}', peer, ratio(figures, peer, 'ours'), 20, True,
              'ten times the time of a tenth')
          for peer in PEERS if peer in figures),
        Row(f'time of {loading}', 'a tenth of them', ratio(figures, 'ours', 'a tenth'), 13, False),
        Row(f'peak memory of {loading}', 'their decoded size', memory / decoded, 3, False),
        Row('handing a message over to the writer', "mcap's add_message",
            ratio(figures, 'handing over', 'mcap, in the loop'), 0.5, False),
        Row('recording a message, thread included', 'mcap, LZ4, 64 KiB chunks',
            ratio(figures, 'recording', 'mcap'), 1, False),
    ]
    if 'publishing' in figures:
        rows.append(Row('handing a message over to the writer', 'publish(bytes)',
                        ratio(figures, 'handing over', 'publishing'), 1, False))
    publish('bag', 'Bags', rows, {'seconds': figures, 'messages': options.messages},
            keep=not options.quick)


if __name__ == '__main__':
    main()
