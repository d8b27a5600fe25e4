"""The service of UR's friction_model_controller, with the type of ur_msgs."""

import numpy as np
from rcl_interfaces.srv import GetParameters
from ros_processes import wait_until

VISCOUS, COULOMB = [0.9, 0.9, 0.8, 0.9, 0.9, 0.9], [0.8, 0.8, 0.7, 0.8, 0.8, 0.8]


def scales(watcher):
    """Return the scales in force."""
    names = [f'friction_compensation.{kind}_scale' for kind in ('viscous', 'coulomb')]
    answer = watcher.call(GetParameters, '/ur5_sim/get_parameters',
                          GetParameters.Request(names=names))
    return [list(value.double_array_value) for value in answer.values]


def test_the_drivers_service_sets_what_the_robot_compensates(ros, interfaces):
    from ur_msgs.srv import SetFrictionModelParameters as Service
    watcher = ros.observer()
    sim = ros.start('sim', environment=interfaces, arm='ur5e_real', friction__from_arm=True,
                    lockstep=False, bag='none')

    def asked(viscous, coulomb):
        request = Service.Request()
        request.parameters.viscous_scale, request.parameters.coulomb_scale = viscous, coulomb
        return watcher.call(Service, '/ur5_sim/set_friction_model_parameters', request).success

    assert scales(watcher) == [[0.0] * 6, [0.0] * 6]
    assert asked(VISCOUS, COULOMB)
    assert np.allclose(scales(watcher), [VISCOUS, COULOMB], rtol=1e-12)
    for wrong in ([-0.1, *VISCOUS[1:]], [3.0] * 6, VISCOUS[:5]):
        assert not asked(wrong, [0.0] * 6), wrong
    wait_until(lambda: 'friction_compensation.viscous_scale' in sim.text, 'the reason in the log')
    assert np.allclose(scales(watcher), [VISCOUS, COULOMB], rtol=1e-12), 'all or nothing'
    assert sim.stop() == 0
