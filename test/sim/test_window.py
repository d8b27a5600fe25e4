"""PyBullet's window, on a screen that nobody sees."""

import os
import subprocess
import sys

import pytest

RUN = """
import hashlib
import sys
import numpy as np
from ur5_ros.config import SIM_PARAMETERS, complete
from ur5_ros.sim.plant import plant_from_parameters

for gui in (False, True):
    plant = plant_from_parameters(complete(SIM_PARAMETERS, {'gui': gui}))
    random, found = np.random.default_rng(0), hashlib.sha256()
    for _ in range(200):
        state = plant.step(random.normal(size=6))
        found.update(state.q.tobytes() + state.qd.tobytes())
    print('states', found.hexdigest(), flush=True)
    plant.close()
"""


@pytest.fixture
def screen():
    """Yield the name of a screen of an X server of our own."""
    read, write = os.pipe()
    server = subprocess.Popen(
        ['Xvfb', '-displayfd', str(write), '-screen', '0', '800x600x24', '-nolisten', 'tcp'],
        pass_fds=(write,), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    os.close(write)
    try:
        with os.fdopen(read) as reported:
            yield ':' + reported.readline().strip()  # comes when it takes connections
    finally:
        server.terminate()
        server.wait()


@pytest.mark.browser
def test_the_window_changes_no_bit_of_the_states(screen):
    done = subprocess.run([sys.executable, '-c', RUN], capture_output=True, text=True, timeout=300,
                          env={**os.environ, 'DISPLAY': screen})
    assert done.returncode == 0, done.stderr
    states = [line for line in done.stdout.splitlines() if line.startswith('states')]
    assert len(states) == 2 and states[0] == states[1]
