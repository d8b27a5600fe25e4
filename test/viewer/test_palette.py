"""One colour a joint, wherever joints are drawn."""

import json
import re

from ur5_ros.analysis.report.palette import JOINT_COLOURS, rgb
from ur5_ros.config import config_folder
from ur5_ros.signals import JOINT_NAMES
from ur5_ros.viewer.picture.frame import COLOURS


def test_the_layouts_of_other_tools_colour_joints_as_report_and_viewer_do():
    colours = dict(zip(JOINT_NAMES, JOINT_COLOURS, strict=True))
    foxglove = json.loads((config_folder() / 'layouts/foxglove.json').read_text())
    paths = [path for panel in foxglove['configById'].values() for path in panel.get('paths', ())
             if path.get('label') in colours]
    assert len(paths) >= 18
    assert all(path['color'] == colours[path['label']] for path in paths)
    plotjuggler = (config_folder() / 'layouts/plotjuggler.xml').read_text()
    curves = re.findall(r'name="(?!\S*torque_parts)[^"]*/(\w+_joint)/\w+" color="(#\w+)"',
                        plotjuggler)
    assert len(curves) >= 18
    assert all(colour == colours[joint] for joint, colour in curves)


def test_pictures_have_the_same_colours():
    assert tuple(map(rgb, JOINT_COLOURS)) == COLOURS
