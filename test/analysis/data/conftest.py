import pytest
from foreign_recordings import motion


@pytest.fixture(scope='session')
def made():
    """States of an arm ur5e in motion, as :func:`foreign_recordings.motion` gives them."""
    return motion()
