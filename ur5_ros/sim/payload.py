"""A mass on the tool that the arm record does not declare."""

from dataclasses import replace

import numpy as np

from ur5_ros.model.parameters import ArmParameters, Payload, with_payload


def loaded_arm(arm: ArmParameters, mass: float, com: list[float]) -> ArmParameters:
    """
    Return the arm whose last link carries its declared payload and a further point mass.

    Parameters
    ----------
    arm : ArmParameters
        The arm; its own payload stays.
    mass : float
        Further mass [kg].
    com : list of float
        Where, in ``tool0`` [m].

    Returns
    -------
    ArmParameters
        A record with the same geometry.

    """
    if mass == 0.0:
        return arm
    masses, coms, tensors = (np.array(part) for part in arm.bodies)
    declared = replace(arm, mass=masses, com=coms, inertia=tensors, payload=Payload())
    return with_payload(declared, mass, np.array(com))
