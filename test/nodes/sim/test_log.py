"""What a person reads in the log: each kind once a second, and the present state last."""

from types import SimpleNamespace

import numpy as np

from ur5_ros.config.node_parameters import SimParameters
from ur5_ros.nodes.sim import simulation as module
from ur5_ros.nodes.sim.simulation import Simulation
from ur5_ros.sim.events import event
from ur5_ros.throttle import Throttle


def test_the_last_line_is_the_present_state_however_often_it_changed(monkeypatch):
    now, lines, events = [0.0], [], []
    monkeypatch.setattr(module, 'Throttle', lambda: Throttle(1.0, lambda: now[0]))
    plant = SimpleNamespace(world=SimpleNamespace(empty=True), k=1, stamp=0)
    outputs = SimpleNamespace(event=events.append)
    logger = SimpleNamespace(warning=lines.append)
    simulation = Simulation(plant, outputs, logger, SimParameters.of())
    random = np.random.default_rng(1)
    acts = True
    for _ in range(500):
        now[0] += random.choice([0.001, 0.3, 1.2])
        acts = not acts
        message = 'brake acts' if acts else 'brake ends: a command acts'
        simulation.send_events(SimpleNamespace(
            drain_events=lambda text=message: [event(1, 'fallback', text)]))
        if random.random() < 0.3:  # the report of a second later
            now[0] += 1.0
            simulation.log_present()
            assert lines[-1].startswith(message)
    assert len(events) == 500, 'the bag has them all'
    assert len(lines) <= now[0] + 1
    assert any('changes since the last line' in line for line in lines)
