"""A run as a recording of Rerun: the arm of its URDF, moving, its tool path, and the curves."""

from pathlib import Path
from typing import Any

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.report.palette import JOINT_COLOURS, MEASURED, REFERENCE, rgb
from ur5_ros.errors import InputError
from ur5_ros.model.rotations import quaternion_of
from ur5_ros.signals import JOINT_NAMES
from ur5_ros.sim.urdf import urdf_text
from ur5_ros.viewer.track import Track, arm_of, drawable, joint_angles, track, tree_of
from ur5_ros.viewer.urdf_tree import UrdfTree, Visual, turn

#: Poses of the arm that are written at most; curves have every state.
POSES = 3000


def write_scene(run: Run, out: Path) -> None:
    """
    Write a recording that ``rerun FILE`` opens, with its layout in it.

    Raises
    ------
    InputError
        If rerun-sdk is not installed.

    """
    try:
        import rerun
    except ImportError:
        raise InputError("Rerun's file needs rerun-sdk; in the checkout: make setup-all, or pip "
                         "install '.[export]'; or write a .csv") from None
    arm = drawable(arm_of(run))
    tree = tree_of(arm)
    recording = rerun.RecordingStream('ur5_ros', recording_id=run.name)
    recording.save(str(out))
    scene = _Scene(rerun, recording, tree)
    recording.log('urdf', rerun.TextDocument(urdf_text(arm)), static=True)
    scene.draw()
    rows = track(run, tree, POSES)
    scene.move(rows)
    scene.path('tool/measured', rows.tool, MEASURED)
    scene.path('tool/reference', rows.tool_reference, REFERENCE)
    _curves(rerun, recording, run)
    recording.send_blueprint(_layout())
    recording.flush()
    recording.disconnect()


class _Scene:
    """The arm below the entity ``arm``, one entity a link."""

    def __init__(self, rerun: Any, recording: Any, tree: UrdfTree):
        self._rerun, self._recording, self._tree = rerun, recording, tree
        self._paths = {tree.root: 'arm'}
        for joint in tree.joints:
            self._paths[joint.child] = f'{self._paths[joint.parent]}/{joint.child}'

    def draw(self) -> None:
        """Log what does not change: fixed frames and shapes."""
        for joint in self._tree.joints:
            self._recording.log(self._paths[joint.child], self._transform(joint.pose), static=True)
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
            poses = joint.pose @ turn(joint.axis, angles[joint.name])
            quaternions = np.array([quaternion_of(pose[:3, :3]) for pose in poses])
            self._recording.send_columns(
                self._paths[joint.child] + '/',
                [self._rerun.TimeColumn('time', duration=rows.t)],
                self._rerun.Transform3D.columns(translation=poses[:, :3, 3],
                                                quaternion=quaternions))

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
        return self._rerun.Boxes3D(sizes=[visual.size], **place)


def _curves(rerun: Any, recording: Any, run: Run) -> None:
    """Log positions, velocities, torques and errors of the joints."""
    quantities = {'position [rad]': run.states.q, 'velocity [rad_s]': run.states.qd,
                  'effort [N m]': run.states.effort}
    if run.reference is not None:
        quantities['error [rad]'] = run.states.q - run.reference.q
    time = rerun.TimeColumn('time', duration=run.t)
    for quantity, values in quantities.items():
        for i, joint in enumerate(JOINT_NAMES):
            path = f'{quantity}/{joint}'
            recording.log(path, rerun.SeriesLines(colors=[rgb(JOINT_COLOURS[i])], names=[joint]),
                          static=True)
            recording.send_columns(path, [time], rerun.Scalars.columns(scalars=values[:, i]))


def _layout() -> Any:
    """Return the arrangement of the window: the arm, and curves beside it."""
    import rerun.blueprint as layout
    names = ('position [rad]', 'velocity [rad_s]', 'effort [N m]', 'error [rad]')
    return layout.Blueprint(layout.Horizontal(
        layout.Spatial3DView(origin='/', name='arm'),
        layout.Vertical(*(layout.TimeSeriesView(origin=name, name=name) for name in names))))
