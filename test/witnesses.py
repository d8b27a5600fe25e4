"""Arms in other engines, built from the explicit inertias."""

import numpy as np
import pinocchio as pin


def pinocchio_model(arm, bodies=None):
    """Return an arm as a pinocchio.Model with frame 'tool0'."""
    model = pin.Model()
    model.gravity.linear = arm.gravity
    placement, parent = pin.SE3.Identity(), 0
    for i, (mass, com, inertia) in enumerate(zip(*(bodies or arm.bodies), strict=True)):
        c, s = np.cos(arm.alpha[i]), np.sin(arm.alpha[i])
        link = pin.SE3(np.array([[1, 0, 0], [0, c, -s], [0, s, c]]),
                       np.array([arm.a[i], 0, arm.d[i]]))
        parent = model.addJoint(parent, pin.JointModelRZ(), placement, f'joint_{i + 1}')
        model.appendBodyToJoint(parent, pin.Inertia(mass, com, inertia), link)
        placement = link
    model.addFrame(pin.Frame('tool0', parent, 0, placement, pin.FrameType.OP_FRAME))
    model.armature = arm.armature
    return model
