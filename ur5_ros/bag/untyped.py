"""Topics whose file does not state their type: recognised by their messages."""

from ur5_ros.bag.reader import Bag
from ur5_ros.cdr.codec import decode
from ur5_ros.errors import BagError

#: Messages that must be of the type.
SAMPLE = 20


def declare_by_content(bag: Bag, topic: str, type_name: str) -> bool:
    """Declare a topic to be of a recorded type if its first messages are; return whether so."""
    raw = bag.columns(topic)
    count = min(len(raw.log_time), SAMPLE)
    for i in range(count):
        try:
            decode(type_name, raw.data[raw.offsets[i]:raw.offsets[i + 1]].tobytes())
        except BagError:
            return False
    if count:
        bag.declare(topic, type_name)
    return count > 0
