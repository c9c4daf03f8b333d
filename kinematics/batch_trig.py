"""Sine, cosine and arc tangent of whole arrays, from products and quotients alone.

Angles in rad. The C library's sines and arc tangents work on one number at a time on many
processors (20 to 40 ns each), while numpy's products work on several. Both functions here are
therefore quotients of two polynomials, in Horner's form and in place, on arrays that stay in the
processor's cache. They are exact to a few units in the last place; the coefficients minimise the
largest relative error (Remez in the Lawson form, computed with 60 digits).
"""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

Array: TypeAlias = npt.NDArray[np.float64]

_TINY = 1e-300
"""Keeps a quotient of two zeros from being no number, and changes no other."""

_ARCTAN_OVER = (
    1.0,
    2.2765284166557884,
    1.8190722532173773,
    0.6064657316624958,
    0.07732920279856478,
    0.0025207285084859793,
)
_ARCTAN_UNDER = (
    1.0,
    2.6098617499890664,
    2.4890261698840708,
    1.0570259143877427,
    0.19359222332525175,
    0.012145895204678984,
    0.0001125665346465461,
)
"""atan(t) = t * over(t^2) / under(t^2) for t from -1 to 1, with a relative error of 3e-16."""

_TAN_OVER = (1.0, -0.12828349603647296, 0.0028059210960441204, -7.483662590665358e-06)
_TAN_UNDER = (1.0, -0.46161682936980347, 0.023344864219242256, -0.00020844845398152633)
"""tan(a) = a * over(a^2) / under(a^2) for a up to 45 degrees, with a relative error of 2e-17."""

_QUARTER_OVER = tuple(0.25 * c / 16.0**k for k, c in enumerate(_TAN_OVER))
_QUARTER_UNDER = tuple(c / 16.0**k for k, c in enumerate(_TAN_UNDER))
"""The same for the tangent of a quarter of the angle, so that the angle may be half a turn."""


def sine_cosine(angle: Array, sine: Array, cosine: Array, spare: Array) -> None:
    """Fill `sine` and `cosine` from angles of any turn; `spare` is overwritten.

    From the tangent t of the quarter angle: the sine of the half angle is 2t / (1 + t^2), its
    cosine (1 - t^2) / (1 + t^2), and both are doubled once more.
    """
    wrap(angle, spare, sine)
    np.multiply(spare, spare, sine)
    _polynomial(sine, _QUARTER_OVER, cosine)
    spare *= cosine
    _polynomial(sine, _QUARTER_UNDER, cosine)
    spare /= cosine
    np.multiply(spare, spare, sine)
    sine += 1.0
    np.divide(2.0, sine, cosine)
    np.multiply(spare, cosine, sine)  # of the half angle
    cosine -= 1.0
    np.multiply(sine, sine, spare)
    sine *= cosine
    sine *= 2.0
    np.multiply(spare, -2.0, cosine)
    cosine += 1.0


def arc_tangent(tangent: Array, out: Array, spare: Array, other: Array) -> None:
    """Fill `out` with the arc tangent of what lies between -1 and 1; the spares are overwritten."""
    np.multiply(tangent, tangent, spare)
    _polynomial(spare, _ARCTAN_OVER, out)
    _polynomial(spare, _ARCTAN_UNDER, other)
    out /= other
    out *= tangent


def directions(y: Array, x: Array, length: Array, tangents: Array) -> None:
    """Fill `tangents` with those of the half angles of (x, y), whose lengths are known.

    That is y / (length + x); to the left of the y axis the mirror image is taken, whose
    denominator does not cancel, and `mirror_back` undoes it. A point without direction has 0.
    """
    np.abs(x, tangents)
    tangents += length
    tangents += _TINY
    np.divide(y, tangents, tangents)


def mirror_back(angles: Array, y: Array, x: Array) -> None:
    """Turn half angles of `directions` into the directions of (x, y); `x` is overwritten."""
    np.copysign(2.0, x, x)
    angles *= x
    np.subtract(2.0, x, x)
    x *= math.pi / 4.0
    np.copysign(x, y, x)
    angles += x


def wrap(angle: Array, out: Array, spare: Array) -> None:
    """Fill `out` with the turn of each angle within half a circle either way."""
    np.multiply(angle, 1.0 / math.tau, spare)
    np.rint(spare, spare)
    spare *= math.tau
    np.subtract(angle, spare, out)


def _polynomial(x: Array, coefficients: tuple[float, ...], out: Array) -> None:
    np.multiply(x, coefficients[-1], out)
    for coefficient in coefficients[-2:0:-1]:
        out += coefficient
        out *= x
    out += coefficients[0]
