"""Shapes at a place, of a tool or of a body, as files write them."""

from collections.abc import Sequence
from typing import Annotated, Literal

import msgspec
import numpy as np

from ur5_ros.config.records import Meta, Record, Three
from ur5_ros.errors import InputError
from ur5_ros.model.frames import BASE_FROM_BASE_LINK
from ur5_ros.model.rotations import rotation_of_rpy

Size = Annotated[float, Meta(gt=0.0, le=100.0)]

#: What each shape needs.
_NEEDS = {'plane': (), 'box': ('size',), 'sphere': ('radius',), 'cylinder': ('radius', 'length'),
          'mesh': ('file',)}
_GEOMETRY = ('size', 'radius', 'length', 'file')


class Solid(Record, frozen=True, kw_only=True):
    """A shape at a place: of the tool in ``tool0``, of a body in the frame of the world."""

    shape: Literal['box', 'sphere', 'cylinder', 'plane', 'mesh']
    position: Three = msgspec.field(default_factory=lambda: [0.0] * 3)
    """Of its centre [m]."""
    rpy_degrees: Three = msgspec.field(default_factory=lambda: [0.0] * 3)
    """Roll, pitch, yaw."""
    size: Annotated[list[Size], Meta(min_length=3, max_length=3)] = []
    """Edges of a box [m]."""
    radius: Size = 0.0
    """Of a sphere or a cylinder [m]."""
    length: Size = 0.0
    """Of a cylinder, along its z [m]."""
    file: str = ''
    """Of a mesh: OBJ or STL, relative to the world's file."""


def base_pose(solid: Solid, frame: str = 'base') -> np.ndarray:
    """
    Return the pose of a shape in the frame it stands in, (4, 4); of bodies in ``base``.

    ``solid``: A shape; ``frame``: ``base``, or ``base_link``, which is ``base`` turned by Rz(pi).
    """
    pose = np.eye(4)
    pose[:3, :3] = rotation_of_rpy(*np.deg2rad(solid.rpy_degrees))
    pose[:3, 3] = solid.position
    return BASE_FROM_BASE_LINK @ pose if frame == 'base_link' else pose


def check_shape(solid: Solid, where: str) -> None:
    """Refuse (InputError) a shape whose size is missing, or that has one too many."""
    needs = _NEEDS[solid.shape]
    for key in needs:
        if not getattr(solid, key):
            raise InputError(f'{where}: a {solid.shape} needs {key}')
    for key in _GEOMETRY:
        if key not in needs and getattr(solid, key):
            raise InputError(f'{where}: a {solid.shape} has no {key}; leave it out')


def check_tool(tool: Sequence[Solid], source: str) -> None:
    """Refuse (InputError) a tool that is no rigid shape on the flange."""
    for i, solid in enumerate(tool):
        check_shape(solid, f'{source}: tool shape {i + 1}')
        if solid.shape in ('plane', 'mesh'):
            raise InputError(f'{source}: tool shape {i + 1} is a {solid.shape}; give sphere, '
                             'cylinder or box')
