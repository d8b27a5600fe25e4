"""
Moments of bodies in motion, from which M, C and g are read off.

Kinetic energy is T = sum of x' x' dm / 2, so M_ij = sum of d_i x . d_j x dm and the Christoffel
matrix is C_ij = sum of d_i x . (d_j x)' dm, with d_j x = w_j x x + u_j for the bodies beyond joint
j.  Only moments of the bodies appear: h = sum of x dm, E = sum of x x^T dm, p = sum of x' dm and
D = sum of x x'^T dm, added up from the tool to the shoulder.
"""

from ur5_ros.model.kernels.compiled import inlined
from ur5_ros.model.kernels.plane_geometry import add, cross, dot


@inlined
def moment(e, v):
    """Return I v, with the inertia tensor I = tr(E) 1 - E."""
    xx, xy, yy, xz, yz, zz = e
    return ((yy + zz) * v[0] - xy * v[1] - xz * v[2], (xx + zz) * v[1] - xy * v[0] - yz * v[2],
            (xx + yy) * v[2] - xz * v[0] - yz * v[1])


@inlined
def six(a, b):
    """Return the sum of two sets of second moments."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3], a[4] + b[4], a[5] + b[5])


@inlined
def momentum(h, e, w, u):
    """Return momentum and angular momentum of a composite that moves about one axis."""
    return cross(w, h), add(moment(e, w), cross(h, u))


@inlined
def flow(body, speed):
    """Return h, E, p and D (row by row) of a body that moves at (w, v)."""
    h, e = body
    w, v = speed
    xx, xy, yy, xz, yz, zz = e
    return (h, e, cross(w, h),
            (w[1] * xz - w[2] * xy + h[0] * v[0], w[2] * xx - w[0] * xz + h[0] * v[1],
             w[0] * xy - w[1] * xx + h[0] * v[2],
             w[1] * yz - w[2] * yy + h[1] * v[0], w[2] * xy - w[0] * yz + h[1] * v[1],
             w[0] * yy - w[1] * xy + h[1] * v[2],
             w[1] * zz - w[2] * yz + h[2] * v[0], w[2] * xz - w[0] * zz + h[2] * v[1],
             w[0] * yz - w[1] * xz + h[2] * v[2]))


@inlined
def joined(a, b):
    """Return h, E, p and D of two composites together."""
    d, f = a[3], b[3]
    return (add(a[0], b[0]), six(a[1], b[1]), add(a[2], b[2]),
            (d[0] + f[0], d[1] + f[1], d[2] + f[2], d[3] + f[3], d[4] + f[4], d[5] + f[5],
             d[6] + f[6], d[7] + f[7], d[8] + f[8]))


@inlined
def coriolis_force(h, e, p, d, axis, axis_rate):
    """Return force and moment of a composite for unit speed of one joint."""
    w, u = axis
    wd, ud = axis_rate
    trace = d[0] + d[4] + d[8]
    g = (trace * w[0] - d[0] * w[0] - d[3] * w[1] - d[6] * w[2],
         trace * w[1] - d[1] * w[0] - d[4] * w[1] - d[7] * w[2],
         trace * w[2] - d[2] * w[0] - d[5] * w[1] - d[8] * w[2])
    return (add(cross(wd, h), cross(w, p)),
            add(add(moment(e, wd), cross(h, ud)), g))


@inlined
def coriolis_row(p, d, w, u):
    """Return the vector whose product with w_j is the moving part of C_ij, j < i."""
    trace = d[0] + d[4] + d[8]
    g = (trace * w[0] - d[0] * w[0] - d[1] * w[1] - d[2] * w[2],
         trace * w[1] - d[3] * w[0] - d[4] * w[1] - d[5] * w[2],
         trace * w[2] - d[6] * w[0] - d[7] * w[1] - d[8] * w[2])
    return add(g, cross(p, u))


@inlined
def column(f, n, lines):
    """Return the products of the six axes with the wrench (f, n)."""
    u3, u4, w5, u5, w6, u6 = lines
    return (n[1], n[2], n[2] + u3[0] * f[0] + u3[1] * f[1], n[2] + u4[0] * f[0] + u4[1] * f[1],
            w5[0] * n[0] + w5[1] * n[1] + dot(u5, f), dot(w6, n) + dot(u6, f))
