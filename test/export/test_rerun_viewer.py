"""Rerun's own viewer opens an exported run: no complaint, every view, and an arm that moves."""

import io
import os
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from ur5_ros.analysis.data.load import load_run
from ur5_ros.export.export import export
from ur5_ros.signals import JOINT_NAMES

pytestmark = pytest.mark.browser
#: Complaints about the machine, not about the file.
MACHINE = ('egui_wgpu', 're_renderer')


@pytest.fixture(scope='module')
def viewer(tmp_path_factory):
    from rerun.experimental import ViewerClient
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv('PATH', str(Path(sys.executable).parent), prepend=os.pathsep)
        patch.setenv('TMPDIR', str(tmp_path_factory.mktemp('rerun')))  # it leaves a folder there
        viewer = ViewerClient.spawn(headless=True, port=18391, hide_welcome_screen=True)
    yield viewer
    viewer.quit()


def test_the_viewer_shows_the_moving_arm_and_every_curve_without_a_complaint(viewer, repo,
                                                                             tmp_path):
    run = load_run(repo / 'bags/golden')
    export(run, tmp_path / 'run.rrd')
    assert viewer.open(str(tmp_path / 'run.rrd')).store_ids
    state = viewer.get_state()
    timeline, = state.recordings[0].timelines
    assert (timeline.name, timeline.start) == ('time', 0)
    assert timeline.end == pytest.approx(1e9 * run.t[-1], abs=1e3)
    assert {view.name for view in state.views} == {
        'arm', 'joint position [rad]', 'joint velocity [rad/s]', 'torque [N m]',
        'joint error [mrad]'}
    assert not [view for view in state.views if view.reports]
    schema = viewer.get_recording_schema(paths_only=True)
    paths = {entity.entity_path for entity in schema.entities}
    assert {f'/{quantity}/{joint}' for joint in JOINT_NAMES
            for quantity in ('position', 'velocity', 'effort', 'error')} <= paths
    assert {'/urdf', '/tool/measured', '/tool/reference', '/arm/base/axes'} <= paths
    assert [path for path in paths if path.endswith('/wrist_3_link/flange/tool0/axes')]
    pictures = []
    for seconds in (0.0, 5.0):
        viewer.set_time('time', duration=seconds, play_state='paused')
        time.sleep(2.0)
        arm = next(view.view_id for view in state.views if view.name == 'arm')
        data = viewer.take_screenshot(arm)
        pictures.append(np.asarray(Image.open(io.BytesIO(data)).convert('RGB')).astype(int))
    assert (np.abs(pictures[0] - pictures[1]).max(axis=-1) > 60).mean() > 0.01
    assert not [each for each in viewer.get_logs() if each.level in ('WARN', 'ERROR')
                and not each.target.startswith(MACHINE)]
