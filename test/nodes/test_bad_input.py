"""Command lines and environments that are wrong: one line, exit code 2, nothing begun."""

import pytest


def refused(process) -> str:
    """Return the one line with which a node refused to start."""
    assert process.ends() == 2, process.text
    assert 'Traceback' not in process.text
    lines = [line for line in process.text.splitlines()
             if line and not line.startswith('pybullet build')]
    assert len(lines) == 1, lines
    return lines[0]


@pytest.mark.parametrize(('node', 'parameters', 'printed'), [
    ('sim', {'control_rate': 300}, 'physics_rate'),
    ('sim', {'control_rate': -1}, 'control_rate'),
    ('sim', {'initial_positions': [0.0, 1.0]}, 'give 6'),
    ('sim', {'arm': 'ur7'}, 'unknown arm'),
    ('sim', {'use_sim_time': True}, 'use_sim_time'),
    ('sim', {'fallback': 'panic'}, 'brake'),
    ('sim', {'no_such': 1}, 'unknown parameter'),
    ('sim', {'noise__position': float('nan')}, 'noise.position'),
    ('sim', {'bag': '.'}, 'exists'),
    ('sim', {'arm': 'ur5_controller'}, 'ur5_controller'),
    ('control', {'kp': [10.0, 10.0]}, 'kp'),
    ('control', {'kp': [-10.0]}, 'kp'),
    ('control', {'experiment': 'no_such'}, 'no_such'),
    ('control', {'mode': 'magic'}, 'computed_torque'),
])
def test_a_wrong_parameter_is_refused_in_one_line(ros, node, parameters, printed):
    assert printed in refused(ros.start(node, **parameters))


@pytest.mark.fault(35, 36)
@pytest.mark.parametrize(('variable', 'value'), [
    ('ROS_DOMAIN_ID', 'abc'), ('ROS_DOMAIN_ID', '233'), ('ROS_SECURITY_ENABLE', 'true'),
    ('ROS_DOMAIN_ID', '9999'), ('UR5_ROS_CORE', '999'), ('ROS_LOG_DIR', '/proc/none'),
    ('UR5_ROS_SPIN', 'fast'),
    ('RMW_IMPLEMENTATION', 'rmw_none_cpp'), ('RMW_IMPLEMENTATION', '../../x'),
    ('FASTRTPS_DEFAULT_PROFILES_FILE', '/nowhere/loopback.xml'),
    ('FASTRTPS_DEFAULT_PROFILES_FILE', '/etc/passwd'),
    ('RCUTILS_LOGGING_BUFFERED_STREAM', '7'), ('ROS_STATIC_PEERS', 'not..a;host')])
@pytest.mark.parametrize('node', ['sim', 'control'])
def test_a_wrong_environment_is_refused_in_one_line(ros, node, variable, value):
    printed = refused(ros.start(node, environment={variable: value}))
    assert variable in printed or value in printed


def test_the_middleware_that_is_there_may_be_named(ros):
    sim = ros.start('sim', environment={'RMW_IMPLEMENTATION': 'rmw_fastrtps_cpp'}, stop_after=0)
    sim.wait_for_line('recorded in')
    assert sim.stop() == 0


@pytest.mark.parametrize(('text', 'printed'), [
    ('/other_node:\n  ros__parameters:\n    arm: ur5\n', '/other_node'),
    ('/ur5_sim:\n  ros__parameters:\n    arm: ur5\n    arm: ur10\n', 'twice'),
    ('/ur5_sim:\n  ros__parameters:\n    armm: ur5\n', 'armm'),
    ('', 'sections'),
    ('a: [', 'YAML'),
    ('/ur5_sim:\n  ros__parameters:\n    payload.mass: heavy\n', 'payload.mass'),
])
def test_a_wrong_parameter_file_is_refused_in_one_line(ros, text, printed):
    file = ros.folder / 'parameters.yaml'
    file.write_text(text)
    assert printed in refused(ros.start('sim', ['--params-file', str(file)]))


def test_a_missing_parameter_file_and_a_stray_argument_are_refused(ros):
    assert 'nowhere.yaml' in refused(ros.start('sim', ['--params-file', 'nowhere.yaml']))
    assert '--speed' in refused(ros.start('control', ['--', '--speed']))


def test_whole_numbers_serve_as_numbers_and_files_of_the_package_are_read(ros, repo):
    sim = ros.start('sim', ['--params-file', str(repo / 'config' / 'sim.yaml')],
                    payload__mass=1, stop_after=0)
    control = ros.start('control', ['--params-file', str(repo / 'config' / 'control.yaml')], kp=20)
    control.wait_for_line('recording')
    assert control.stop() == 0
    assert sim.stop() == 0
