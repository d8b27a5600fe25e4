"""Rays against simple bodies, compiled: depth, light and shadows of every pixel."""

from math import fabs, sqrt

import numpy as np
from numba import types

from ur5_ros.model.kernels.compiled import R1, R2, inlined, kernel

#: Kinds of bodies.
CYLINDER, SPHERE, BOX, TRIANGLE = 0, 1, 2, 3
#: Columns of a body: kind, rotation (corners of a triangle), place, size, ball around it, colour.
TURN, PLACE, SIZE, BALL, COLOUR, COLUMNS = 1, 10, 13, 16, 20, 23
#: Where the view has eye, right, down and ahead, length of focus, and height of the floor.
FOCUS, FLOOR = 12, 13

_DEPTHS, _BYTES = types.Array(types.float32, 2, 'C'), types.Array(types.uint8, 2, 'C')
_OWNERS, _NORMALS = types.Array(types.int16, 2, 'C'), types.Array(types.float32, 3, 'C')
_MISS = 1e30
_NOTHING = (_MISS, (0.0, 0.0, 0.0))
#: Distance from a surface at which its own shadow begins [m].
_CLEAR = 2e-3
#: Light from above and below, what a shadow leaves of the first light, shine.
_SKY, _GROUND, _IN_SHADOW, _GLOSS = 0.46, 0.20, 0.25, 0.25
#: Light as a screen shows it.
_DISPLAY = 1.0 / 2.2


@inlined
def cylinder_hit(x, y, z, u, v, w, radius, half):
    """
    Return how far along (u, v, w) a ray from (x, y, z) meets a cylinder along z, and the normal.

    Nothing is written, so that where the normal is of no use it is not computed either.
    """
    a, b = u * u + v * v, x * u + y * v
    inside = b * b - a * (x * x + y * y - radius * radius)
    far, normal = _MISS, (0.0, 0.0, 0.0)
    if inside >= 0.0 and a > 1e-18:
        side = (-b - sqrt(inside)) / a
        if side > 0.0 and fabs(z + side * w) <= half:
            far = side
            normal = ((x + side * u) / radius, (y + side * v) / radius, 0.0)
    if fabs(z) > half and z * w < 0.0:
        top = half if z > 0.0 else -half
        end = (top - z) / w
        p, q = x + end * u, y + end * v
        if end < far and p * p + q * q <= radius * radius:
            far = end
            normal = (0.0, 0.0, 1.0 if z > 0.0 else -1.0)
    return far, normal


@inlined
def sphere_hit(x, y, z, u, v, w, radius):
    """Return how far a ray meets a sphere, and the normal; as :func:`cylinder_hit`."""
    a, b = u * u + v * v + w * w, x * u + y * v + z * w
    inside = b * b - a * (x * x + y * y + z * z - radius * radius)
    if inside < 0.0:
        return _NOTHING
    far = (-b - sqrt(inside)) / a
    if far <= 0.0:
        return _NOTHING
    return far, ((x + far * u) / radius, (y + far * v) / radius, (z + far * w) / radius)


@inlined
def box_hit(x, y, z, u, v, w, size):
    """Return how far a ray meets a box with three half edges, and the normal."""
    enter, leave, axis, sign = -_MISS, _MISS, 0, 1.0
    for i in range(3):
        place = x if i == 0 else (y if i == 1 else z)
        way = u if i == 0 else (v if i == 1 else w)
        if fabs(way) < 1e-12:
            if fabs(place) > size[i]:
                return _NOTHING
            continue
        side = 1.0 if way > 0.0 else -1.0
        first, last = (-side * size[i] - place) / way, (side * size[i] - place) / way
        if first > enter:
            enter, axis, sign = first, i, -side
        leave = min(leave, last)
    if enter > leave or enter <= 0.0:
        return _NOTHING
    return enter, (sign if axis == 0 else 0.0, sign if axis == 1 else 0.0,
                   sign if axis == 2 else 0.0)


@inlined
def triangle_hit(x, y, z, u, v, w, corners):
    """Return how far a ray meets a triangle of nine numbers, and the normal."""
    a, b, c = corners[3] - corners[0], corners[4] - corners[1], corners[5] - corners[2]
    d, e, f = corners[6] - corners[0], corners[7] - corners[1], corners[8] - corners[2]
    p, q, r = v * f - w * e, w * d - u * f, u * e - v * d
    whole = a * p + b * q + c * r
    if fabs(whole) < 1e-18:
        return _NOTHING
    k, m, n = x - corners[0], y - corners[1], z - corners[2]
    first = (k * p + m * q + n * r) / whole
    s, t, o = m * c - n * b, n * a - k * c, k * b - m * a
    second = (u * s + v * t + w * o) / whole
    far = (d * s + e * t + f * o) / whole
    if first < 0.0 or second < 0.0 or first + second > 1.0 or far <= 0.0:
        return _NOTHING
    p, q, r = b * f - c * e, c * d - a * f, a * e - b * d
    length = sqrt(p * p + q * q + r * r)
    if p * u + q * v + r * w > 0.0:  # either side is drawn
        length = -length
    return far, (p / length, q / length, r / length)


@inlined
def body_hit(body, x, y, z, u, v, w):
    """Return how far a ray meets a body, and the normal there."""
    kind = int(body[0])
    if kind == TRIANGLE:
        return triangle_hit(x, y, z, u, v, w, body[TURN:])
    x, y, z = x - body[PLACE], y - body[PLACE + 1], z - body[PLACE + 2]
    a = body[1] * x + body[4] * y + body[7] * z
    b = body[2] * x + body[5] * y + body[8] * z
    c = body[3] * x + body[6] * y + body[9] * z
    d = body[1] * u + body[4] * v + body[7] * w
    e = body[2] * u + body[5] * v + body[8] * w
    f = body[3] * u + body[6] * v + body[9] * w
    if kind == CYLINDER:
        far, (p, q, r) = cylinder_hit(a, b, c, d, e, f, body[SIZE], body[SIZE + 1])
    elif kind == SPHERE:
        far, (p, q, r) = sphere_hit(a, b, c, d, e, f, body[SIZE])
    else:
        far, (p, q, r) = box_hit(a, b, c, d, e, f, body[SIZE:])
    return far, (body[1] * p + body[2] * q + body[3] * r, body[4] * p + body[5] * q + body[6] * r,
                 body[7] * p + body[8] * q + body[9] * r)


@inlined
def in_shadow(bodies, x, y, z, light):
    """Return whether a body stands between a point and the light."""
    for i in range(len(bodies)):
        body = bodies[i]
        a, b, c = body[BALL] - x, body[BALL + 1] - y, body[BALL + 2] - z
        along = a * light[0] + b * light[1] + c * light[2]
        radius = body[BALL + 3]
        if along < -radius or a * a + b * b + c * c - along * along > radius * radius:
            continue
        if body_hit(body, x, y, z, light[0], light[1], light[2])[0] < _MISS:
            return True
    return False


@inlined
def ray(view, row, column, height, width):
    """Return the direction in which a pixel looks; ahead it is 1 m long."""
    down = (row + 0.5 - 0.5 * height) / view[FOCUS]
    right = (column + 0.5 - 0.5 * width) / view[FOCUS]
    u = view[9] + right * view[3] + down * view[6]
    v = view[10] + right * view[4] + down * view[7]
    w = view[11] + right * view[5] + down * view[8]
    return u, v, w


@inlined
def find_bodies(bodies, windows, view, depth, owner, normals):
    """Write the nearest body of each pixel, how far ahead it is, and its normal there."""
    height, width = depth.shape
    for i in range(len(bodies)):
        for row in range(int(windows[i, 0]), int(windows[i, 1])):
            for column in range(int(windows[i, 2]), int(windows[i, 3])):
                u, v, w = ray(view, row, column, height, width)
                far, normal = body_hit(bodies[i], view[0], view[1], view[2], u, v, w)
                if far < _MISS and far < depth[row, column]:
                    depth[row, column], owner[row, column] = far, i
                    normals[row, column, 0] = normal[0]
                    normals[row, column, 1] = normal[1]
                    normals[row, column, 2] = normal[2]


@inlined
def light_at(bodies, lights, x, y, z, u, v, w, n):
    """Return light and gloss of a point with normal n, seen along (u, v, w)."""
    length = sqrt(u * u + v * v + w * w)
    light = _GROUND + (_SKY - _GROUND) * (0.5 + 0.5 * n[2])
    gloss = 0.0
    for i in range(len(lights)):
        facing = n[0] * lights[i, 0] + n[1] * lights[i, 1] + n[2] * lights[i, 2]
        if facing <= 0.0:
            continue
        share = lights[i, 3]
        if i == 0 and in_shadow(bodies, x + _CLEAR * n[0], y + _CLEAR * n[1],
                                z + _CLEAR * n[2], lights[0]):
            share *= _IN_SHADOW
        light += share * facing
        p, q = lights[i, 0] - u / length, lights[i, 1] - v / length
        r = lights[i, 2] - w / length
        half = (n[0] * p + n[1] * q + n[2] * r) / sqrt(p * p + q * q + r * r)
        gloss += _GLOSS * share * max(half, 0.0)**40
    return light, gloss


@inlined
def shades_floor(body, view, light, u, v, w):
    """Return whether a body stands between a light and the floor that is seen along (u, v, w)."""
    if w >= 0.0:
        return False
    far = (view[FLOOR] - view[2]) / w
    return body_hit(body, view[0] + far * u, view[1] + far * v, view[FLOOR],
                    light[0], light[1], light[2])[0] < _MISS


@inlined
def find_shadows(bodies, shades, view, lights, owner, shadow):
    """Write which pixels see the floor where a body stands before the first light."""
    for i in range(len(bodies)):
        for row in range(int(shades[i, 0]), int(shades[i, 1])):
            for column in range(int(shades[i, 2]), int(shades[i, 3])):
                if owner[row, column] < 0 and shadow[row, column] == 0:
                    u, v, w = ray(view, row, column, *shadow.shape)
                    shadow[row, column] = shades_floor(bodies[i], view, lights[0], u, v, w)


@kernel(R2, R2, R2, R1, R2, _OWNERS, _NORMALS, _DEPTHS, _BYTES, _BYTES)
def cast(bodies, windows, shades, view, lights, owner, normals, depth, colour, shadow):
    """
    Write what each pixel sees.

    ``bodies``: A row of COLUMNS numbers each; colours are linear, 0 to 1; ``view``: eye, right,
    down, ahead, focus [pixels], floor [m]; ``lights``: unit direction towards each light, and its
    strength; the first one throws shadows; ``owner``, ``normals``: working space, the body that a
    pixel shows and its normal there; ``depth``: written: how far ahead the nearest body is
    [m]; infinite where there is none; ``colour``: written: red, green and blue, 0 to 255, a row a
    pixel; nothing where no body is.
    """
    height, width = depth.shape
    owner[:] = -1
    depth[:] = np.inf
    find_bodies(bodies, windows, view, depth, owner, normals)
    for row in range(height):
        for column in range(width):
            if owner[row, column] < 0:
                continue
            u, v, w = ray(view, row, column, height, width)
            far, n = depth[row, column], normals[row, column]
            x, y, z = view[0] + far * u, view[1] + far * v, view[2] + far * w
            light, gloss = light_at(bodies, lights, x, y, z, u, v, w, n)
            pixel = colour[row * width + column]
            for k in range(3):
                linear = min(bodies[owner[row, column], COLOUR + k] * light + gloss, 1.0)
                pixel[k] = np.uint8(255.0 * linear**_DISPLAY + 0.5)
    shadow[:] = 0
    find_shadows(bodies, shades, view, lights, owner, shadow)
    return 0
