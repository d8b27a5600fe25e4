"""A run as one table: a row a state, a column a quantity and joint, the unit in its name."""

import csv
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.tracking import tool_tracking
from ur5_ros.errors import InputError
from ur5_ros.model.kinematics import forward_kinematics
from ur5_ros.signals import JOINT_NAMES


def columns_of(run: Run) -> dict[str, np.ndarray]:
    """
    Return the columns of a run.

    Returned: ``time [s]``, ``stamp [ns]``, then ``position/JOINT [rad]`` and so on: what was
    recorded; NaN where a state lacks it, (n,).
    """
    columns = {'time [s]': run.t, 'stamp [ns]': run.stamp}
    columns |= _joints('position', 'rad', run.states.q)
    columns |= _joints('velocity', 'rad/s', run.states.qd)
    columns |= _joints('effort', 'N m', run.states.effort)
    if run.command is not None:
        columns |= _joints('command', 'N m', run.command)
    if run.reference is not None:
        for name, unit, values in zip(('reference_position', 'reference_velocity',
                                       'reference_acceleration'),
                                      ('rad', 'rad/s', 'rad/s^2'), run.reference, strict=True):
            columns |= _joints(name, unit, values)
    for name, values in run.parts.items():
        if name != 'total':
            columns |= _joints(f'torque_{name}', 'N m', values)
    if run.current is not None:
        columns |= _joints('motor_current', 'A', run.current)
    return columns | _tool(run)


def _joints(name: str, unit: str, values: np.ndarray) -> dict[str, np.ndarray]:
    return {f'{name}/{joint} [{unit}]': values[:, i] for i, joint in enumerate(JOINT_NAMES)}


def _tool(run: Run) -> dict[str, np.ndarray]:
    """Return the tool's position in ``base``, and its error where there is a reference."""
    record = run.sim or run.control
    if record is None:
        return {}
    arm = record.arm
    position = forward_kinematics(run.exact.q + arm.angle_offset, arm)[:, :3, 3]
    columns = {f'tool_in_base/{axis} [m]': position[:, i] for i, axis in enumerate('xyz')}
    if run.reference is not None:
        tracking = tool_tracking(run, arm, (run.control or record).arm)
        columns['tool_error [m]'] = tracking.distance
    return columns


def write_csv(columns: Mapping[str, np.ndarray], path: Path) -> None:
    """Write columns as CSV: a header, numbers to their last digit, empty where there is none."""
    with path.open('w', newline='', encoding='utf-8') as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        lists = [values.tolist() for values in columns.values()]
        for row in zip(*lists, strict=True):
            writer.writerow(['' if value != value else repr(value) for value in row])


def write_parquet(columns: Mapping[str, np.ndarray], path: Path) -> None:
    """Write columns as Parquet; NaN becomes null."""
    try:
        import polars
    except ImportError:
        raise InputError("Parquet needs Polars; in the checkout: make setup-all, or pip install "
                         "'.[sweep]'; or write a .csv") from None
    polars.DataFrame(dict(columns)).fill_nan(None).write_parquet(path)
