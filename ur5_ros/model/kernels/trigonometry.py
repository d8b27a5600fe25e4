"""
Sine, cosine and arctangent as plain arithmetic: no branches, the same digits everywhere.

Compilers can work on several states at once where a kernel holds no library call; these are good
to two units in the last place and independent of the C library of the machine.
"""

from math import copysign, nan, pi

from ur5_ros.model.kernels.compiled import inlined

#: Adding and subtracting this rounds to a whole number (1.5 * 2^52).
ROUND = 6755399441055744.0
#: pi / 2 as a sum of three numbers, the first two with 33 bits, so that multiples are exact.
HALF_PI_1 = 1.5707963267341256
HALF_PI_2 = 6.077100506303966e-11
HALF_PI_3 = 2.0222662487959506e-21

TAN_PI_8 = 0.41421356237309503


@inlined
def sine_cosine(x):
    """Return (sin x, cos x); nan where x is so large (1e15) that neither has a meaning."""
    quarter = x * (2.0 / pi) + ROUND - ROUND
    r = ((x - quarter * HALF_PI_1) - quarter * HALF_PI_2) - quarter * HALF_PI_3
    r = r if abs(r) < 1.0 else nan
    z = r * r
    # Taylor series to the last digit for |r| <= pi / 4
    s = r + r * z * (-1 / 6 + z * (1 / 120 + z * (-1 / 5040 + z * (1 / 362880 + z * (
        -1 / 39916800 + z * (1 / 6227020800 + z * (-1 / 1307674368000)))))))
    c = 1.0 - 0.5 * z + z * z * (1 / 24 + z * (-1 / 720 + z * (1 / 40320 + z * (
        -1 / 3628800 + z * (1 / 479001600 + z * (-1 / 87178291200 + z / 20922789888000))))))
    quadrant = quarter - 4.0 * (0.25 * quarter - 0.375 + ROUND - ROUND)
    odd = quadrant == 1.0 or quadrant == 3.0
    sine, cosine = c if odd else s, s if odd else c
    return (-sine if quadrant >= 2.0 else sine,
            -cosine if quadrant == 1.0 or quadrant == 2.0 else cosine)


@inlined
def arctangent(y, x):
    """Return the angle of the point (x, y) in [-pi, pi], zero for the origin."""
    ax, ay = abs(x), abs(y)
    low, high = min(ax, ay), max(ax, ay)
    beyond = low > TAN_PI_8 * high
    t = (low - high if beyond else low) / max(low + high if beyond else high, 1e-300)
    u = t * t
    # interpolated at Chebyshev nodes on [0, tan(pi/8)^2]; off by 5e-18
    angle = t + t * u * (-0.3333333333333333 + u * (0.1999999999999552 + u * (
        -0.14285714284666542 + u * (0.11111111015256361 + u * (-0.09090904578123903 + u * (
            0.07692183190826087 + u * (-0.06664511447381948 + u * (0.0585814891280221 + u * (
                -0.0508544973794026 + u * (0.03923165829558719
                                           - u * 0.01917688711906226))))))))))
    angle = angle + 0.25 * pi if beyond else angle
    angle = 0.5 * pi - angle if ay > ax else angle
    return copysign(pi - angle if x < 0.0 else angle, y)
