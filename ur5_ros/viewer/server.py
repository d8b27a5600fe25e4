"""The page that both views share: an arm, charts and a line of numbers, on this machine only."""

import contextlib
import io

import numpy as np
import viser

from ur5_ros.viewer.arm_scene import ArmScene
from ur5_ros.viewer.curves import Curves
from ur5_ros.viewer.track import Track
from ur5_ros.viewer.urdf_tree import UrdfTree

#: Where the camera stands and what it looks at [m], in a wide and in an upright window.
_WIDE = (0.9, 1.25, 0.95), (0.0, 0.0, 0.35)
_UPRIGHT = (0.9, 2.25, 1.0), (-0.3, 0.25, -0.1)


def _aim(client: viser.ClientHandle) -> None:
    """Keep the arm out from under the panel of an upright window."""
    if client.camera.aspect < 0.8:
        client.camera.position, client.camera.look_at = _UPRIGHT


class Page:
    """
    The page, served on 127.0.0.1 until :meth:`close`.

    Parameters
    ----------
    tree : UrdfTree
        The arm to draw.
    track : Track
        What the charts show at first.
    title : str
        The headline.
    port : int
        Wanted port; the next free one is taken.

    """

    def __init__(self, tree: UrdfTree, track: Track, title: str, port: int):
        with contextlib.redirect_stdout(io.StringIO()):  # it would draw a box of its own
            self.server = viser.ViserServer(host='127.0.0.1', port=port, label=title,
                                            verbose=False)
        gui = self.server.gui
        gui.configure_theme(show_logo=False, show_share_button=False)
        gui.set_panel_label(title)
        gui.main_panel.dock_right()
        gui.main_panel.set_width(400)
        self.server.initial_camera.position, self.server.initial_camera.look_at = _WIDE
        self.server.on_client_connect(_aim)
        self.arm = ArmScene(self.server, tree)
        self.numbers = gui.add_markdown('')
        self.controls = gui.add_folder('Time')
        with gui.add_folder('Curves'):
            self.curves = Curves(self.server, track)
        self.dark = gui.add_checkbox('Dark', initial_value=False)
        self.dark.on_update(lambda _: gui.configure_theme(
            dark_mode=self.dark.value, show_logo=False, show_share_button=False))

    @property
    def address(self) -> str:
        """Return where the page is."""
        return f'http://127.0.0.1:{self.server.get_port()}'

    def show(self, track: Track, row: int) -> None:
        """Show one row of a track: pose, numbers, marks."""
        self.arm.pose(track.q[row])
        self.curves.mark(row)
        self.numbers.content = numbers(track, row)

    def close(self) -> None:
        """Stop serving."""
        with contextlib.redirect_stdout(io.StringIO()):
            self.server.stop()


def numbers(track: Track, row: int) -> str:
    """Return time, tool position, tool error and largest torque of a row, as one sentence."""
    x, y, z = track.tool[row]
    said = f'**t = {track.t[row]:.3f} s**, tool at ({x:.4f}, {y:.4f}, {z:.4f}) m'
    if np.isfinite(track.tool_error[row]):
        said += f', {1e3 * track.tool_error[row]:.3f} mm from where it should be'
    if np.isfinite(track.effort[row]).any():
        said += f'; largest torque {np.nanmax(np.abs(track.effort[row])):.1f} N m'
    return said
