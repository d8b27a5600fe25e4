"""The arm that a recorded /robot_description describes."""

from collections.abc import Sequence
from typing import NamedTuple

from ur5_ros.analysis.data.bags import BagData
from ur5_ros.analysis.data.node_records import messages_of
from ur5_ros.cdr.codec import decode
from ur5_ros.config.foreign_arms.known_arm import known_arm
from ur5_ros.errors import BagError, InputError

ROLE = 'robot_description'


class DescribedArm(NamedTuple):
    """What a robot description says of the arm."""

    names: tuple[str, ...]
    """The known arms that it can be; empty where it is none of them."""
    sentence: str
    """How it was recognised, or what it is and what to do."""

    @property
    def name(self) -> str:
        """The known arm that is taken, or empty."""
        return self.names[0] if self.names else ''


def urdf_in(bag: BagData) -> bytes | None:
    """Return the last robot description of a bag, None without one."""
    if not bag.has(ROLE):
        return None
    for data in reversed(list(messages_of(bag.data[ROLE]))):
        try:
            text: str = decode('std_msgs/msg/String', data)['data']
        except BagError:
            continue
        return text.encode()
    return None


def described_arm(bags: Sequence[BagData]) -> DescribedArm | None:
    """Return what the robot description of a recording says; None where there is none."""
    bag = next((each for each in bags if each.has(ROLE)), None)
    data = urdf_in(bag) if bag is not None else None
    if bag is None or data is None:
        return None
    topic = bag.topics[ROLE]
    try:
        found = known_arm(bag.path / topic.strip('/'), data, bag.prefix)
    except InputError as problem:
        return DescribedArm((), f'{topic} helps no further: {problem}')
    make = f'make an arm of it: ur5 arm --urdf {bag.path} -o arm.yaml'
    if found.names:
        name, *others = found.names
        same = f'; {", ".join(others)} would have the same one' if others else ''
        away = f', the tool within {found.away * 1e3:.2g} mm' if found.away > 1e-6 else ''
        return DescribedArm(found.names, f'the arm is {name}, whose kinematics and inertias '
                            f'{topic} has{away}{same}')
    if found.like:
        return DescribedArm((), f'{topic} has the lengths of {found.like} and other masses or '
                            f'inertias, {found.found.mass.sum():.4g} kg in all: {make}')
    return DescribedArm((), f'{topic} is of a robot of the UR family, {found.found.name!r}, of '
                        f'{found.found.mass.sum():.4g} kg, that is none of the known arms: {make}')
