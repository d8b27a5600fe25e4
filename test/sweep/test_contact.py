"""Sweeps over worlds and contact parameters."""

import pytest

from ur5_ros.errors import InputError
from ur5_ros.sweep.run import config_of, row_of
from ur5_ros.sweep.spec import expand, parse_sweep

SPEC = ('name: walls\nexperiment: tap_wall\nduration: 1.0\njudge: checks\n'
        'success: {max_error: 1.0}\nvary:\n  sim.contact.stiffness: [50000.0, 200000.0]\n')


def test_contact_parameters_and_worlds_can_be_varied():
    spec = parse_sweep(SPEC, 'test')
    rows = [row_of(spec, run, None) for run in expand(spec)]
    assert [row['status'] for row in rows] == ['pass', 'pass']
    assert rows[0]['states'] != rows[1]['states'], 'another wall, another rebound'


def test_an_unknown_world_is_refused_before_the_first_run():
    spec = parse_sweep(SPEC.replace('sim.contact.stiffness: [50000.0, 200000.0]',
                                    'sim.world: [wall, moon]'), 'test')
    with pytest.raises(InputError, match='unknown world'):
        for run in expand(spec):
            config_of(spec, run)
