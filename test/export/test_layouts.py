"""Layouts of PlotJuggler and Foxglove: their panels, and curves that a recorded run really has."""

import importlib
import json
import re
from xml.etree import ElementTree

import pytest

from ur5_ros import open_bag
from ur5_ros.config import config_folder
from ur5_ros.signals import JOINT_NAMES


@pytest.fixture(scope='module')
def messages(repo):
    """Return the type and the first message of each topic of a run."""
    found = {}
    for node in ('sim', 'control'):
        bag = open_bag(repo / 'bags/golden' / node)
        for topic, kind in bag.topics.items():
            _, first = next(bag.messages(topic), (0, None))
            found[topic] = kind, first
    return found


@pytest.fixture(scope='module')
def plotjuggler():
    return ElementTree.parse(config_folder() / 'layouts/plotjuggler.xml').getroot()


@pytest.fixture(scope='module')
def foxglove():
    return json.loads((config_folder() / 'layouts/foxglove.json').read_text(encoding='utf-8'))


def series_names(messages) -> set[str]:
    """Return the names that PlotJuggler gives to joint states and poses (its ParserROS)."""
    names = set()
    for topic, (kind, message) in messages.items():
        if message is not None and kind == 'sensor_msgs/msg/JointState':
            names |= {f'{topic}/{joint}/{field}' for field in ('position', 'velocity', 'effort')
                      for joint, _ in zip(message['name'], message[field], strict=False)}
        if message is not None and kind == 'geometry_msgs/msg/PoseStamped':
            names |= {f'{topic}/pose/position/{axis}' for axis in 'xyz'}
    return names


def test_every_curve_of_plotjuggler_is_in_a_recorded_run(messages, plotjuggler):
    curves = {curve.get('name') for curve in plotjuggler.iter('curve')}
    assert curves - series_names(messages) == set()
    for joint in JOINT_NAMES:
        assert {f'/joint_states/{joint}/position', f'/joint_states/{joint}/velocity',
                f'/joint_states/{joint}/effort', f'/joint_command/{joint}/effort',
                f'/ur5_control/error/{joint}/position'} <= curves


def test_plotjuggler_finds_the_structure_that_it_writes_itself(plotjuggler):
    window, = plotjuggler.findall('tabbed_widget')
    assert (plotjuggler.tag, window.get('parent')) == ('root', 'main_window')
    for tab in window.findall('Tab'):
        containers = tab.findall('Container')
        assert tab.get('tab_name') and int(tab.get('containers')) == len(containers) == 1
        for splitter in containers[0].iter('DockSplitter'):
            sizes = [float(size) for size in splitter.get('sizes').split(';')]
            assert splitter.get('orientation') in ('-', '|')
            assert int(splitter.get('count')) == len(sizes) == len(list(splitter))
            assert sum(sizes) == pytest.approx(1.0, abs=1e-3)
        for area in containers[0].iter('DockArea'):
            plot, = area.findall('plot')
            assert '[' in area.get('name'), 'with its unit'
            assert (plot.get('mode'), plot.get('style')) == ('TimeSeries', 'Lines')
            assert plot.findall('curve'), 'no empty plot'


def fields_of(kind: str) -> dict[str, str]:
    """Return the fields of a message type as rosidl has them."""
    package, _, name = kind.split('/')
    message = getattr(importlib.import_module(f'{package}.msg'), name)
    return message.get_fields_and_field_types()


def test_every_path_of_foxglove_is_in_a_recorded_run(messages, foxglove):
    panels = foxglove['configById']
    paths = [path['value'] for panel in panels.values() for path in panel.get('paths', ())]
    paths.append(panels['RawMessages!events']['topicPath'])
    assert len(paths) == 19
    for path in paths:
        topic, field, index = re.fullmatch(r'(/[\w/]+)\.(\w+)\[(\d|:)\]', path).groups()
        kind, message = messages[topic]
        assert fields_of(kind)[field].startswith('sequence<'), path
        if index != ':':
            label, = (each['label'] for panel in panels.values()
                      for each in panel.get('paths', ()) if each['value'] == path)
            assert message['name'][int(index)] == label, 'the joint that its legend names'
            assert len(message[field]) == len(JOINT_NAMES)


def test_the_arm_of_foxglove_moves_by_the_joint_states(messages, foxglove):
    view = foxglove['configById']['3D!arm']
    layer = view['layers']['urdf']
    assert messages[layer['topic']][0] == 'std_msgs/msg/String'
    assert (layer['controlMode'], layer['sourceType']) == ('jointStates', 'topic')
    assert messages[layer['jointStatesTopic']][0] == 'sensor_msgs/msg/JointState'
    for topic in view['topics'].keys() - {'/ur5_sim/contacts'}:  # recorded with a world only
        assert topic in messages
    links = re.findall(r'<link name="(\w+)"', messages[layer['topic']][1]['data'])
    assert view['followTf'] in links
    assert view['layers']['grid']['frameId'] in links


def test_foxglove_finds_panels_that_it_has(messages, foxglove):
    assert {'configById', 'globalVariables', 'userNodes', 'playbackConfig',
            'layout'} == set(foxglove)
    assert {name.partition('!')[0] for name in foxglove['configById']} == {
        '3D', 'Plot', 'DiagnosticSummary', 'RawMessages'}, 'names of panels in Foxglove'
    assert foxglove['configById']['DiagnosticSummary!all']['topicToRender'] in messages
    for name, panel in foxglove['configById'].items():
        if name.startswith('Plot!'):
            assert panel['yAxisLabel'] in ('rad', 'mrad', 'rad/s', 'N m'), 'its unit'
            assert panel['foxglovePanelTitle'] == panel['lichtblickPanelTitle'] != ''


def test_every_foxglove_panel_that_is_placed_is_described(foxglove):
    def panels(place):
        if isinstance(place, str):
            return {place}
        return panels(place['first']) | panels(place['second'])

    assert panels(foxglove['layout']) == set(foxglove['configById'])
