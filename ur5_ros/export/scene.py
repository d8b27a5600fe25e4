"""A run as a recording of Rerun: the arm of its URDF, moving, its tool path, and the curves."""

from pathlib import Path
from typing import Any

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.injected import injections
from ur5_ros.analysis.report.palette import (
    JOINT_COLOURS,
    MEASURED,
    REFERENCE,
    SHORT_NAMES,
    rgb,
)
from ur5_ros.errors import InputError
from ur5_ros.model.rotations import quaternion_of
from ur5_ros.signals import JOINT_NAMES
from ur5_ros.sim.urdf import urdf_text
from ur5_ros.viewer.picture.frame import AXES
from ur5_ros.viewer.stage import BASE_AXES, TOOL_AXES
from ur5_ros.viewer.track import (
    Track,
    arm_of,
    drawable,
    joint_angles,
    number_frame,
    track,
    tree_of,
)
from ur5_ros.viewer.urdf_tree import UrdfTree, Visual, turn
from ur5_ros.viewer.world_track import WorldTrack

#: Poses of the arm that are written at most; curves have every state.
POSES = 3000
#: Entity of what was added to the plant.
ADDED = 'added_to_the_plant'
#: Entities of the curves, and the names of their views.
QUANTITIES = (('position', 'joint position [rad]'), ('velocity', 'joint velocity [rad/s]'),
              ('effort', 'torque [N m]'), ('error', 'joint error [mrad]'))


def write_scene(run: Run, out: Path) -> None:
    """Write a recording that ``rerun FILE`` opens, with its layout in it."""
    try:
        import rerun
    except ImportError:
        raise InputError("Rerun's file needs rerun-sdk; in the checkout: make setup-all, or pip "
                         "install '.[export]'; or write a .csv") from None
    arm = drawable(arm_of(run))
    tree = tree_of(arm, run.sim.world if run.sim else None)
    recording = rerun.RecordingStream('ur5_ros', recording_id=run.name)
    recording.save(str(out))
    scene = _Scene(rerun, recording, tree)
    recording.log('urdf', rerun.TextDocument(urdf_text(arm)), static=True)
    scene.draw()
    rows = track(run, tree, POSES)
    scene.move(rows)
    scene.world(WorldTrack(run), rows.t)
    scene.path('tool/measured', rows.tool, MEASURED)
    scene.path('tool/reference', rows.tool_reference, REFERENCE)
    _curves(rerun, recording, run)
    _added(rerun, recording, run)
    recording.send_blueprint(_layout(run))
    recording.flush()
    recording.disconnect()


class _Scene:
    """The arm below the entity ``arm``, one entity a link."""

    def __init__(self, rerun: Any, recording: Any, tree: UrdfTree):
        self._rerun, self._recording, self._tree = rerun, recording, tree
        self._paths = {tree.root: 'arm'}
        self._base, self._base_name = number_frame(tree)
        for joint in tree.joints:
            self._paths[joint.child] = f'{self._paths[joint.parent]}/{joint.child}'

    def draw(self) -> None:
        """Log what does not change: fixed frames, named axes and shapes."""
        self._axes(self._paths[self._base_name], self._base_name, BASE_AXES)
        for link, path in self._paths.items():
            if link.endswith('tool0'):
                self._axes(path, link, TOOL_AXES)
        for joint in self._tree.joints:
            if not joint.axis.any():  # what is static would hide poses over time
                self._recording.log(self._paths[joint.child], self._transform(joint.pose),
                                    static=True)
        for link, visuals in self._tree.visuals.items():
            for i, visual in enumerate(visuals):
                self._recording.log(f'{self._paths[link]}/shape_{i}', self._shape(visual),
                                    static=True)

    def move(self, rows: Track) -> None:
        """Log the poses of the moving joints over time."""
        angles = joint_angles(self._tree, rows.q)
        for joint in self._tree.joints:
            if joint.name not in angles:
                continue
            self._move(self._paths[joint.child], rows.t,
                       joint.pose @ turn(joint.axis, angles[joint.name]))

    def world(self, world: WorldTrack, t: np.ndarray) -> None:
        """Log the bodies that the arm can touch, and their poses over time."""
        poses = np.array([self._base @ world.poses(each) for each in t])
        for i, (body, visual) in enumerate(zip(world.bodies, world.visuals, strict=True)):
            path = f'world/{body.name}'
            self._recording.log(f'{path}/shape', self._shape(visual), static=True)
            if body.free:
                self._move(path, t, poses[:, i])
            else:
                self._recording.log(path, self._transform(poses[0, i]), static=True)

    def _move(self, path: str, t: np.ndarray, poses: np.ndarray) -> None:
        quaternions = np.array([quaternion_of(pose[:3, :3]) for pose in poses])
        self._recording.send_columns(
            path, [self._rerun.TimeColumn('time', duration=t)],
            self._rerun.Transform3D.columns(translation=poses[:, :3, 3], quaternion=quaternions))

    def _axes(self, path: str, name: str, length: float) -> None:
        self._recording.log(f'{path}/axes', self._rerun.Arrows3D(
            vectors=length * np.eye(3), colors=AXES, radii=0.003,
            labels=[f'{name} x', 'y', 'z']), static=True)

    def path(self, name: str, points: np.ndarray, colour: str) -> None:
        """Log a line through the points that are known."""
        points = points[np.isfinite(points).all(axis=1)]
        if len(points) > 1:
            self._recording.log(name, self._rerun.LineStrips3D(
                [points], colors=[rgb(colour)], radii=0.002), static=True)

    def _transform(self, pose: np.ndarray) -> Any:
        return self._rerun.Transform3D(translation=pose[:3, 3],
                                       quaternion=quaternion_of(pose[:3, :3]))

    def _shape(self, visual: Visual) -> Any:
        place = {'centers': [visual.pose[:3, 3]], 'colors': [visual.colour],
                 'quaternions': [quaternion_of(visual.pose[:3, :3])], 'fill_mode': 'solid'}
        if visual.kind == 'cylinder':
            return self._rerun.Cylinders3D(radii=[visual.size[0]], lengths=[visual.size[1]],
                                           **place)
        if visual.kind == 'sphere':
            return self._rerun.Ellipsoids3D(radii=[visual.size[0]], **place)
        if visual.triangles is not None:
            corners = visual.triangles.reshape(-1, 3)
            return self._rerun.Mesh3D(vertex_positions=corners,
                                      albedo_factor=[*visual.colour, 255])
        return self._rerun.Boxes3D(sizes=[visual.size], **place)


def _curves(rerun: Any, recording: Any, run: Run) -> None:
    """Log positions, velocities, torques and errors of the joints."""
    time = rerun.TimeColumn('time', duration=run.t)
    for (quantity, _), values in zip(QUANTITIES, _values(run), strict=True):
        if values is None:
            continue
        for i, joint in enumerate(JOINT_NAMES):
            path = f'{quantity}/{joint}'
            recording.log(path, rerun.SeriesLines(colors=[rgb(JOINT_COLOURS[i])],
                                                  names=[SHORT_NAMES[i]]), static=True)
            recording.send_columns(path, [time], rerun.Scalars.columns(scalars=values[:, i]))


def _added(rerun: Any, recording: Any, run: Run) -> None:
    """Log what was added to the plant, each at its time."""
    added = injections(run)
    if added:
        time = rerun.TimeColumn('time', duration=[each.t for each in added])
        recording.send_columns(ADDED, [time], rerun.TextLog.columns(
            text=[each.text for each in added]))


def _values(run: Run) -> tuple[np.ndarray | None, ...]:
    """Return the curves in the order of :data:`QUANTITIES`; None for what the run lacks."""
    error = None if run.reference is None else 1e3 * (run.states.q - run.reference.q)
    return tuple(values if values is not None and np.isfinite(values).any() else None
                 for values in (run.states.q, run.states.qd, run.states.effort, error))


def _layout(run: Run) -> Any:
    """Return the arrangement of the window: the arm, and curves beside it."""
    import rerun.blueprint as layout
    views: list[Any] = [layout.TimeSeriesView(origin=quantity, name=name)
             for (quantity, name), values in zip(QUANTITIES, _values(run), strict=True)
             if values is not None]
    if injections(run):
        views.append(layout.TextLogView(origin=ADDED, name='added to the plant'))
    return layout.Blueprint(layout.Horizontal(
        layout.Spatial3DView(origin='/', name='arm', contents=['+ /arm/**', '+ /tool/**',
                                                               '+ /world/**']),
        layout.Vertical(*views)), collapse_panels=True)
