"""The desired wrenches that a controller received, and from which state on each acted."""

from ur5_ros.analysis.data.bags import BagData
from ur5_ros.analysis.data.node_records import messages_of
from ur5_ros.analysis.data.run import States, TargetWrench
from ur5_ros.cdr.codec import decode
from ur5_ros.cdr.decoded import force_and_torque
from ur5_ros.model.frames import wrench_in_base


def target_wrenches(bag: BagData, states: States) -> tuple[TargetWrench, ...]:
    """
    Return the desired wrenches in a controller's bag, in order.

    The controller takes one message after the other and records each when it has taken it: a
    wrench acts on the answers to the states that were recorded after it.
    """
    if bag.record is None or not bag.has('target_wrench') or not bag.has('joint_states'):
        return ()
    raw, received = bag.data['target_wrench'], bag.data['joint_states']
    arm, prefix = bag.record.arm, str(bag.record.parameters.get('tf_prefix', ''))
    found = []
    for data, time in zip(messages_of(raw), raw.log_time.tolist(), strict=True):
        first = int((received.log_time < time).sum())
        if not 0 < first < len(received.stamp):
            continue
        message = decode('geometry_msgs/msg/WrenchStamped', data)
        row = min(first, len(states.q)) - 1
        found.append(TargetWrench(int(received.stamp[first]), wrench_in_base(
            *force_and_torque(message['wrench']), message['header']['frame_id'], states.q[row],
            arm, prefix)))
    return tuple(found)
