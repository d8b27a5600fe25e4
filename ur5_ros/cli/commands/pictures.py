"""Commands that show the arm: view, render, urdf."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ur5_ros.cli.exit_codes import SUCCESS


def view(run: Path | None, live: bool, port: int, given: Mapping[str, Any]) -> int:
    """Show a run, or what runs now, in the browser."""
    from ur5_ros import viewer
    viewer.view(run, live, port, given)
    return SUCCESS


def render(run: Path, out: Path, given: Mapping[str, Any]) -> int:
    """Write a video or a picture of a run."""
    from ur5_ros.cli.terminal import progress
    from ur5_ros.viewer.render import render as draw
    with progress(f'drawing {out.name}', 100.0, '%') as advance:
        draw(run, out, lambda share: advance(100.0 * share), given)
    print(f'written: {out}')
    return SUCCESS


def urdf(arm: str, tf_prefix: str, ros2_control: bool) -> int:
    """Print the URDF of an arm."""
    from ur5_ros.config import load_arm
    from ur5_ros.sim.urdf import urdf_text
    from ur5_ros.sim.urdf_ros2_control import with_ros2_control
    text = urdf_text(load_arm(arm), tf_prefix)
    print((with_ros2_control(text, tf_prefix) if ros2_control else text).rstrip())
    return SUCCESS
