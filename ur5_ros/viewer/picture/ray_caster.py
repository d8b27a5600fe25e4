"""A picture of simple bodies by casting rays: exact surfaces, soft light, shadows."""

from collections.abc import Sequence
from itertools import product
from typing import NamedTuple

import numpy as np

from ur5_ros.viewer.picture import ray_kernel
from ur5_ros.viewer.picture.camera import Camera
from ur5_ros.viewer.urdf_tree import Visual

#: Directions towards the lights, and their strengths; the first one throws shadows.
_LIGHTS = np.array([[0.25, 0.55, 1.0, 0.62], [-0.9, 0.6, 0.35, 0.16], [0.9, 0.4, 0.2, 0.14]])
_LIGHTS[:, :3] /= np.linalg.norm(_LIGHTS[:, :3], axis=1, keepdims=True)
_KINDS = {'cylinder': ray_kernel.CYLINDER, 'sphere': ray_kernel.SPHERE, 'box': ray_kernel.BOX}
_GAMMA = 2.2
#: What a body before another keeps of its own colour where the other shows through.
_VEIL = 0.45
_CORNERS = np.array(list(product((-1.0, 1.0), repeat=3)))


class Placed(NamedTuple):
    """A body at a place in ``base_link``."""

    visual: Visual
    pose: np.ndarray
    """Of the body itself, shape (4, 4)."""


class Picture(NamedTuple):
    """What the camera sees."""

    colour: np.ndarray
    """Red, green and blue as bytes, shape (height, width, 3); black where nothing is."""
    depth: np.ndarray
    """How far ahead the body is [m]; infinite where there is none. Shape (height, width)."""
    shadow: np.ndarray
    """1 where the floor is in a shadow, else 0. Shape (height, width)."""


def cast(camera: Camera, placed: Sequence[Placed], floor: float = 0.0) -> Picture:
    """
    Return a picture of bodies.

    ``floor``: height on which shadows fall [m].
    """
    found = [piece for each in placed for piece in _pieces(*each)]
    bodies = np.array([numbers for numbers, _ in found]).reshape(-1, ray_kernel.COLUMNS)
    light = _LIGHTS[0, :3]
    seen = [camera.window(corners) for _, corners in found]
    shaded = [camera.window(corners - np.outer((corners[:, 2] - floor) / light[2], light))
              for _, corners in found]
    windows, shades = (np.array(each, dtype=float).reshape(-1, 4) for each in (seen, shaded))
    depth = np.empty((camera.height, camera.width), dtype=np.float32)
    owner, normals = np.empty(depth.shape, np.int16), np.empty((*depth.shape, 3), np.float32)
    shadow, colour = np.empty(depth.shape, np.uint8), np.zeros((depth.size, 3), np.uint8)
    ray_kernel.cast.run(1, (bodies, windows, shades, np.append(camera.view, floor), _LIGHTS),
                        (owner, normals), (depth, colour, shadow))
    return Picture(colour.reshape(*depth.shape, 3), depth, shadow)


def seen_through(picture: Picture, behind: Picture) -> Picture:
    """
    Return a picture in which some of the bodies show through those before them.

    ``behind``: the picture of these alone.
    """
    hidden = np.isfinite(behind.depth) & (picture.depth < behind.depth)
    colour = picture.colour.copy()
    colour[hidden] = np.rint(_VEIL * picture.colour[hidden]
                             + (1.0 - _VEIL) * behind.colour[hidden])
    return picture._replace(colour=colour)


def _pieces(visual: Visual, pose: np.ndarray):
    """Yield the numbers of a body as the kernel takes them, and corners around it."""
    turn, place = pose[:3, :3], pose[:3, 3]
    colour = (np.array(visual.colour) / 255.0)**_GAMMA
    if visual.kind == 'mesh':
        for corners in () if visual.triangles is None else visual.triangles @ turn.T + place:
            centre = corners.mean(axis=0)
            radius = np.linalg.norm(corners - centre, axis=1).max()
            yield np.concatenate([[ray_kernel.TRIANGLE], corners.ravel(), centre, np.zeros(3),
                                  centre, [radius], colour]), corners
        return
    half = np.zeros(3)
    half[:len(visual.size)] = visual.size
    if visual.kind == 'box':
        half /= 2
        around = half
    elif visual.kind == 'cylinder':
        half[1] /= 2
        around = half[[0, 0, 1]]
    else:
        around = half[[0, 0, 0]]
    radius = half[0] if visual.kind == 'sphere' else np.linalg.norm(around)
    yield np.concatenate([[_KINDS[visual.kind]], turn.ravel(), place, half, place, [radius],
                          colour]), (_CORNERS * around) @ turn.T + place
