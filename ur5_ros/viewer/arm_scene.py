"""The arm in a viser scene: one frame a link, moved by setting the joints' frames."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import viser

from ur5_ros.analysis.report import palette
from ur5_ros.model.rotations import quaternion_of
from ur5_ros.viewer.stage import BASE_AXES, TOOL_AXES
from ur5_ros.viewer.track import joint_angles, number_frame
from ur5_ros.viewer.urdf_tree import UrdfTree, Visual, turn

MEASURED, REFERENCE = palette.rgb(palette.MEASURED), palette.rgb(palette.REFERENCE)


class ArmScene:
    """An arm drawn in the browser; its root stands at the origin."""

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
                paths[joint.child], show_axes=joint.child.endswith('tool0'), axes_length=TOOL_AXES,
                axes_radius=0.004, wxyz=_wxyz(joint.pose[:3, :3]),
                position=joint.pose[:3, 3])
        self._name_frames(paths)
        for link, visuals in tree.visuals.items():
            for i, visual in enumerate(visuals):
                draw_visual(scene, f'{paths[link]}/shape_{i}', visual)

    def _name_frames(self, paths: Mapping[str, str]) -> None:
        """Draw the axes of the frame that numbers are given in, and write names to the frames."""
        scene, (pose, name) = self._server.scene, number_frame(self._tree)
        scene.add_frame('/numbers', axes_length=BASE_AXES, axes_radius=0.003,
                        wxyz=_wxyz(pose[:3, :3]), position=pose[:3, 3])
        scene.add_label('/numbers/name', name, anchor='top-center')
        for axis, end in zip('xyz', 1.12 * BASE_AXES * np.eye(3), strict=True):
            scene.add_label(f'/numbers/{axis}', axis, position=end, anchor='center-center',
                            font_screen_scale=0.8)
        for link, path in paths.items():
            if link.endswith('tool0'):
                scene.add_label(f'{path}/name', link, anchor='top-center')

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

        ``points`` (n, 3): where it goes, in the root frame [m]; rows with NaN are left out.
        """
        points = points[np.isfinite(points).all(axis=1)]
        if len(points) < 2:
            return
        self._server.scene.add_line_segments(
            f'/{name}', points=np.stack([points[:-1], points[1:]], axis=1).astype(np.float32),
            colors=np.array(colour, dtype=np.uint8), thickness=0.004)


def draw_visual(scene: viser.SceneApi, path: str, visual: Visual,
                opacity: float | None = None) -> None:
    """Draw a body at its pose in the frame above it; ``opacity``: 0 to 1, None for 1."""
    place: dict[str, Any] = {
        'color': visual.colour, 'opacity': opacity, 'wxyz': _wxyz(visual.pose[:3, :3]),
        'position': visual.pose[:3, 3]}
    if visual.kind == 'cylinder':
        scene.add_cylinder(path, radius=visual.size[0], height=visual.size[1],
                           radial_segments=64, **place)
    elif visual.kind == 'sphere':
        scene.add_icosphere(path, radius=visual.size[0], **place)
    elif visual.kind == 'box':
        scene.add_box(path, dimensions=np.array(visual.size), **place)
    elif visual.triangles is not None and len(visual.triangles):
        corners = visual.triangles.reshape(-1, 3)
        scene.add_mesh_simple(path, corners, np.arange(len(corners)).reshape(-1, 3),
                              flat_shading=True, side='double', **place)


def _wxyz(rotation: np.ndarray) -> np.ndarray:
    return np.roll(quaternion_of(rotation), 1)
