"""The page that both views share: an arm, charts and a line of numbers, on this machine only."""

from collections.abc import Sequence

import numpy as np

from ur5_ros.analysis.injected import Injection
from ur5_ros.analysis.report import palette
from ur5_ros.viewer.arm_scene import ArmScene
from ur5_ros.viewer.curves import Curves, colour_key
from ur5_ros.viewer.page_server import PageServer, View
from ur5_ros.viewer.track import Track
from ur5_ros.viewer.urdf_tree import UrdfTree

#: Lines of what was added to the plant that a chart can carry.
MARKS = 40
#: Where the camera stands and what it looks at, in a wide and in an upright window, where the
#: panel lies across the lower half; in lengths of the stretched arm.
_WIDE = (0.82, 1.14, 0.87), (0.0, 0.0, 0.32)
_UPRIGHT = (1.27, 1.59, 0.42), (0.33, 0.28, -0.21)


class Page:
    """
    The page, served on 127.0.0.1 until :meth:`close`.

    ``port``: port to serve on; the next free one where it is taken; ``injected``: what was added
    to the plant of the run; ``controls``: title of the box above the charts.

    """

    def __init__(self, tree: UrdfTree, track: Track, title: str, port: int,
                 injected: Sequence[Injection] = (), controls: str = 'Time'):
        length = sum(float(np.linalg.norm(joint.pose[:3, 3])) for joint in tree.joints)
        self._serving = PageServer(title, port, _scaled(_WIDE, length), _scaled(_UPRIGHT, length))
        self.server = self._serving.viser
        gui = self.server.gui
        gui.configure_theme(show_logo=False, show_share_button=False)
        gui.set_panel_label(title)
        gui.main_panel.dock_right()
        gui.main_panel.set_width(400)
        self.arm = ArmScene(self.server, tree)
        self.numbers = gui.add_markdown('')
        self.controls = gui.add_folder(controls)
        with gui.add_folder('Curves'):
            self.curves = Curves(self.server, track, injected)

    @property
    def port(self) -> int:
        """Return the port that the page is served on."""
        return self._serving.port

    @property
    def address(self) -> str:
        """Return where the page is."""
        return f'http://127.0.0.1:{self.port}'

    def add_key(self) -> None:
        """Name the colours of the tool paths."""
        self.server.gui.add_markdown('tool path: ' + colour_key(
            {'measured': palette.MEASURED, 'reference': palette.REFERENCE}))

    def show(self, track: Track, row: int) -> None:
        """Show one row of a track: pose, numbers, marks."""
        self.arm.pose(track.q[row])
        self.curves.mark(row)
        self.numbers.content = numbers(track, row)

    def close(self) -> None:
        """Stop serving."""
        self._serving.close()


def _scaled(view: View, length: float) -> View:
    (x, y, z), (u, v, w) = view
    return (length * x, length * y, length * z), (length * u, length * v, length * w)


def numbers(track: Track, row: int) -> str:
    """
    Return a row in words.

    Returned: time [s], tool position [m], tool error [mm] and largest torque [N m], as Markdown.
    """
    x, y, z = track.tool_in_base(row)
    text = f'**t = {track.t[row]:.3f} s**, tool at ({x:.4f}, {y:.4f}, {z:.4f}) m in {track.frame}'
    if np.isfinite(track.tool_error[row]):
        text += f', {1e3 * track.tool_error[row]:.4g} mm from the reference'
    if np.isfinite(track.effort[row]).any():
        text += f'; largest torque {np.nanmax(np.abs(track.effort[row])):.1f} N m'
    return text
