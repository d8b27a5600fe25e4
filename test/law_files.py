"""Laws in files, as users write them."""

#: A law whose torque is computed by ``{body}``.
LAW = """
from ur5_ros import dynamics_terms, gravity_torque

class Law:
    def __init__(self, arm, gains, parameters):
        self.arm, self.gains = arm, gains

    def __call__(self, state, reference, dt):
        {body}
"""
