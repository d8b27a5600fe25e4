"""One colour a joint, wherever joints are drawn."""

import json
import re

import numpy as np
import pytest

from ur5_ros.analysis.report.palette import (
    AXIS_COLOURS,
    BAD,
    GOOD,
    JOINT_COLOURS,
    MEASURED,
    REFERENCE,
    SERIES_COLOURS,
    rgb,
)
from ur5_ros.cdr.contact_messages import FORCE_COLOURS
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


def lightness_and_tint(colour: str) -> np.ndarray:
    """Return L*, a* and b* (CIE 1976, white D65): equal steps look equally different."""
    share = np.array(rgb(colour)) / 255
    linear = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055)**2.4)
    xyz = np.array([[0.4125, 0.3576, 0.1804], [0.2127, 0.7152, 0.0722],
                    [0.0193, 0.1192, 0.9503]]) @ linear / (0.9505, 1.0, 1.0888)
    x, y, z = np.where(xyz > 0.008856, np.cbrt(xyz), 7.787 * xyz + 16 / 116)
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


@pytest.mark.parametrize('colour', [
    MEASURED, REFERENCE, GOOD, BAD, *AXIS_COLOURS, *SERIES_COLOURS,
    *(f'#{red:02x}{green:02x}{blue:02x}' for red, green, blue in FORCE_COLOURS)])
def test_no_other_thing_has_the_colour_of_a_joint(colour):
    nearest = min(np.linalg.norm(lightness_and_tint(colour) - lightness_and_tint(joint))
                  for joint in JOINT_COLOURS)
    assert nearest > 24


@pytest.mark.parametrize('together', [
    JOINT_COLOURS, SERIES_COLOURS, AXIS_COLOURS,
    (MEASURED, REFERENCE, *(f'#{r:02x}{g:02x}{b:02x}' for r, g, b in FORCE_COLOURS))])
def test_things_in_one_figure_differ_in_colour(together):
    places = np.array([lightness_and_tint(colour) for colour in together])
    apart = np.linalg.norm(places[:, None] - places, axis=-1)
    assert apart[np.triu_indices(len(places), 1)].min() > 24
