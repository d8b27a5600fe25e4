"""The arm in a viser scene: one frame a link, moved by setting the joints' frames."""

from typing import Any

import numpy as np
import viser

from ur5_ros.analysis.report import palette
from ur5_ros.model.rotations import quaternion_of
from ur5_ros.viewer.track import joint_angles
from ur5_ros.viewer.urdf_tree import UrdfTree, Visual, turn

MEASURED, REFERENCE = palette.rgb(palette.MEASURED), palette.rgb(palette.REFERENCE)


class ArmScene:
    """
    An arm drawn in the browser; its root stands at the origin.

    Parameters
    ----------
    server : viser.ViserServer
        Where to draw.
    tree : UrdfTree
        The arm.

    """

    def __init__(self, server: viser.ViserServer, tree: UrdfTree):
        self._server, self._tree = server, tree
        scene = server.scene
        scene.set_up_direction('+z')
        scene.add_grid('/ground', width=3.0, height=3.0, cell_size=0.25, plane='xy')
        paths = {tree.root: '/arm'}
        self._frames = {}
        for joint in tree.joints:
            paths[joint.child] = f'{paths[joint.parent]}/{joint.child}'
            self._frames[joint.name] = scene.add_frame(
                paths[joint.child], show_axes=joint.child.endswith('tool0'), axes_length=0.1,
                axes_radius=0.004, wxyz=_wxyz(joint.pose[:3, :3]),
                position=joint.pose[:3, 3])
        for link, visuals in tree.visuals.items():
            for i, visual in enumerate(visuals):
                self._draw(f'{paths[link]}/shape_{i}', visual)

    def pose(self, q: np.ndarray) -> None:
        """Put the joints at ``q`` [rad], shape (6,)."""
        angles = joint_angles(self._tree, q)
        with self._server.atomic():
            for joint in self._tree.joints:
                if joint.name in angles:
                    rotation = (joint.pose @ turn(joint.axis, angles[joint.name]))[:3, :3]
                    self._frames[joint.name].wxyz = _wxyz(rotation)

    def path(self, name: str, points: np.ndarray, colour: tuple[int, int, int]) -> None:
        """
        Draw a line.

        Parameters
        ----------
        name : str
            A line of the same name is replaced.
        points : numpy.ndarray, shape (n, 3)
            Where it goes, in the root frame [m]; rows with NaN are left out.
        colour : tuple of int
            Red, green and blue, 0 to 255.

        """
        points = points[np.isfinite(points).all(axis=1)]
        if len(points) < 2:
            return
        self._server.scene.add_line_segments(
            f'/{name}', points=np.stack([points[:-1], points[1:]], axis=1).astype(np.float32),
            colors=np.array(colour, dtype=np.uint8), thickness=0.004)

    def _draw(self, path: str, visual: Visual) -> None:
        scene = self._server.scene
        place: dict[str, Any] = {
            'color': visual.colour, 'wxyz': _wxyz(visual.pose[:3, :3]),
            'position': visual.pose[:3, 3]}
        if visual.kind == 'cylinder':
            scene.add_cylinder(path, radius=visual.size[0], height=visual.size[1], **place)
        elif visual.kind == 'sphere':
            scene.add_icosphere(path, radius=visual.size[0], **place)
        else:
            scene.add_box(path, dimensions=np.array(visual.size), **place)


def _wxyz(rotation: np.ndarray) -> np.ndarray:
    return np.roll(quaternion_of(rotation), 1)
