"""What a run's bags hold of each role, at the stamps of its states."""

from typing import Any

import numpy as np

from ur5_ros.analysis.data.bags import BagData
from ur5_ros.analysis.data.contact import contact_rows, contact_series
from ur5_ros.analysis.data.node_records import messages_of
from ur5_ros.analysis.data.run import NodeRecord, States
from ur5_ros.analysis.data.states.fields import FIELDS
from ur5_ros.analysis.data.topic_roles import PART_NAMES
from ur5_ros.bag.arrays.columns import RawColumns
from ur5_ros.cdr.codec import decode
from ur5_ros.signals import Reference

#: Nodes whose bag is preferred for what the simulator, and what the law, publishes.
FROM_SIM, FROM_LAW = ('sim', 'robot', '', 'control'), ('control', 'robot', '', 'sim')


def first_bag(bags: list[BagData], role: str, order: tuple[str, ...]) -> BagData | None:
    """Return the bag that has a role, of several the first in the order of nodes."""
    ranked = sorted((bag for bag in bags if bag.has(role)), key=lambda bag: order.index(bag.node))
    return ranked[0] if ranked else None


def matching_rows(stamp: np.ndarray, others: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return rows and rows of the others with equal stamp; of equal others the first."""
    unique, first = np.unique(others, return_index=True)
    _, rows, found = np.intersect1d(stamp, unique, assume_unique=True, return_indices=True)
    return rows, first[found]


def aligned(stamp: np.ndarray, others: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return ``values`` at the states' stamps; NaN where there is none."""
    out = np.full((len(stamp), values.shape[1]), np.nan)
    rows, found = matching_rows(stamp, others)
    out[rows] = values[found]
    return out


def reference_of(bags: list[BagData], stamp: np.ndarray) -> Reference | None:
    """Return the reference; None where none is recorded."""
    bag = first_bag(bags, 'reference', FROM_LAW)
    if bag is None:
        return None
    columns = bag.data['reference']
    return Reference(*(aligned(stamp, columns.stamp, columns.fields[name])
                       for name in ('positions', 'velocities', 'accelerations')))


def truth_of(bags: list[BagData], stamp: np.ndarray) -> States | None:
    """Return the exact states; None where none are recorded."""
    bag = first_bag(bags, 'ground_truth', FROM_SIM)
    if bag is None:
        return None
    columns = bag.data['ground_truth']
    return States(*(aligned(stamp, columns.stamp, columns.fields[field]) for field in FIELDS))


def _efforts(bags: list[BagData], role: str, order: tuple[str, ...],
             stamp: np.ndarray) -> np.ndarray | None:
    """Return the efforts of a role at the states' stamps; None where it is not recorded."""
    bag = first_bag(bags, role, order)
    return None if bag is None else aligned(stamp, bag.data[role].stamp, bag.data[role].effort)


def parts_of(bags: list[BagData], stamp: np.ndarray) -> dict[str, np.ndarray]:
    """Return the parts of the torque by name; none where they are not recorded."""
    values = _efforts(bags, 'torque_parts', FROM_LAW, stamp)
    if values is None:
        return {}
    return {part: values[:, 6 * i:6 * i + 6] for i, part in enumerate(PART_NAMES)}


def current_of(bags: list[BagData], stamp: np.ndarray) -> np.ndarray | None:
    """Return the motor currents [A]; None where none are recorded."""
    return _efforts(bags, 'motor_current', ('robot', '', 'sim', 'control'), stamp)


def temperature_of(bags: list[BagData], stamp: np.ndarray) -> np.ndarray | None:
    """Return the temperatures of the joints [deg C], between those recorded."""
    bag = first_bag(bags, 'joint_temperature', ('robot', '', 'sim', 'control'))
    if bag is None:
        return None
    columns = bag.data['joint_temperature']
    recorded = efforts_of_arrays(columns)
    whole = np.isfinite(recorded).all(axis=1)
    if not whole.any():
        return None
    return np.column_stack([np.interp(stamp, columns.log_time[whole], part)
                            for part in recorded[whole].T])


def efforts_of_arrays(raw: RawColumns) -> np.ndarray:
    """Return the numbers of std_msgs/Float64MultiArray messages, shape (n, 6); NaN for others."""
    efforts = np.full((len(raw.log_time), 6), np.nan)
    for i, (begin, end) in enumerate(zip(raw.offsets[:-1].tolist(), raw.offsets[1:].tolist(),
                                         strict=True)):
        message = decode('std_msgs/msg/Float64MultiArray', raw.data[begin:end].tobytes())
        if len(message['data']) == 6:
            efforts[i] = message['data']
    return efforts


def contact_of(bags: list[BagData], stamp: np.ndarray, sim: NodeRecord | None) -> dict[str, Any]:
    """Return what the arm touched, where there is a world."""
    if sim is None or sim.world.empty:
        return {}
    bag = next(bag for bag in bags if bag.node == 'sim')
    rate = float(sim.parameters['physics_rate'])
    steps = round(rate / sim.parameters['control_rate'])
    rows = np.zeros((len(stamp), steps, 6))
    if bag.has('contact_effort'):
        columns = bag.data['contact_effort']
        rows = contact_rows(stamp, rate, steps, columns.stamp, columns.effort)
    messages = ((role, data) for role in ('contacts', 'objects') if bag.has(role)
                for data in messages_of(bag.data[role]))
    return {'contact': rows, **contact_series(messages)}
