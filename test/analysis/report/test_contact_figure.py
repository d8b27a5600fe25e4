"""The report of a run in contact shows recorded and estimated torque."""

from ur5_ros.analysis.report.figures import figures
from ur5_ros.analysis.validate import validate
from ur5_ros.loop.closed_loop import run_closed_loop
from ur5_ros.loop.loop_run import as_run
from ur5_ros.loop.run_config import run_config


def test_the_torque_of_contact_is_drawn_beside_its_estimate():
    result = validate(as_run(run_closed_loop(run_config('tap_wall', duration=1.0))))
    figure, = (each for each in figures(result) if each.key == 'contact')
    names = [trace['name'] for trace in figure.traces]
    assert names[:2] == ['pan', 'pan, estimated']
    assert len(names) == 12
