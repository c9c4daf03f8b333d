"""The canonical subproblems of which every closed form here consists.

Each turns about the z axis of some frame, in which the rest is known. Two suffice. A direction
turned to another one (Paden and Kahan's first subproblem; SP1 of Elias and Wen, 2022, "IK-Geo") has
one angle. A cos q + B sin q = C has two: every condition on a turned point's height (SP4) or on its
distance from another point (SP3) has that form, and a turn about two axes that meet (SP2) is one of
each. Two conditions on two angles (SP5 and SP6) leave a conic on the unit circle, which has up to
four.

The first part writes code (`CodeLines`). The second part is called by that code: it solves the two
kinds of equations. Angles in rad.
"""

from __future__ import annotations

import math
from cmath import sqrt as complex_sqrt
from collections.abc import Sequence
from math import cos, pi, sin, sqrt
from typing import NamedTuple

from kinematics.chains.code_lines import CodeLines, Term, Vector3

NO_MATTER = 1e-10
"""Share of their usual size below which an angle's coefficients leave that angle free."""

TOUCHING = 1e-6
"""How far (squared, as a share) a goal may lie beyond an edge and still be solved at the edge.

Rounding needs far less. The solver compares every posture with the goal afterwards.
"""


class Turn(NamedTuple):
    """A turn about z in code: its angle, cosine and sine."""

    angle: Term
    cos: Term
    sin: Term


def turn_of(code: CodeLines, angle: Term) -> Turn:
    """Return the turn by an angle."""
    return Turn(angle, code.call("cos", angle), code.call("sin", angle))


def turned(code: CodeLines, turn: Turn, v: Vector3) -> Vector3:
    """Return a vector turned about z."""
    _, c, s = turn
    return code.total((c, v[0]), (-s, v[1])), code.total((s, v[0]), (c, v[1])), v[2]


def unturned(code: CodeLines, turn: Turn, v: Vector3) -> Vector3:
    """Return a vector turned back about z."""
    return turned(code, Turn(-turn.angle, turn.cos, -turn.sin), v)


def across(code: CodeLines, u: Sequence[Term], v: Sequence[Term]) -> Term:
    """Return the sine part of the turn from u to v, seen along z."""
    return code.total((u[0], v[1]), (-u[1], v[0]))


def along(code: CodeLines, u: Sequence[Term], v: Sequence[Term]) -> Term:
    """Return the cosine part of the turn from u to v, seen along z."""
    return code.total((u[0], v[0]), (u[1], v[1]))


def angle_from(code: CodeLines, u: Sequence[Term], v: Sequence[Term]) -> Term:
    """Return the angle about z that turns u to v (SP1)."""
    return code.call("atan2", across(code, u, v), along(code, u, v))


def angle_or_free(
    code: CodeLines, u: Sequence[Term], v: Sequence[Term], square: Term, free: Term, size: float
) -> Term:
    """Return what `angle_from` does; the free angle where v, of this square, is on the axis."""
    angle, least = code.variable(), Term((NO_MATTER * size) ** 2)
    turn = across(code, u, v), along(code, u, v)
    code.set(angle, "atan2({}, {}) if {} > {} else {}", *turn, square, least, free)
    return angle


def each_linear(code: CodeLines, a: Term, b: Term, c: Term, free: Term, size: float) -> Turn:
    """Begin a loop over the angles with a cos q + b sin q = c; see `each_root`."""
    return each_root(code, a, b, c, free, size)[0]


def each_root(
    code: CodeLines, a: Term, b: Term, c: Term, free: Term, size: float
) -> tuple[Turn, Term]:
    """Begin a loop over the angles with a cos q + b sin q = c; also return a sin q - b cos q.

    `size` is the usual size of a and b. If both are zero, any angle is a solution: `free` is used.
    """
    a_name, b_name, c_name, share, roots = names = [code.variable() for _ in range(5)]
    call = "{}, {}, {}, {}, {} = linear({}, {}, {}, {}, {})"
    code.write(call, *names, a, b, c, free, Term(size))
    root = code.variable()
    code.loop(roots, root)
    sine = code.total((b_name, c_name), (a_name, root))
    cosine = code.total((a_name, c_name), (-b_name, root))
    angle = code.call("atan2", sine, cosine)
    return Turn(angle, code.total((share, cosine)), code.total((share, sine))), root


def each_on_conic(code: CodeLines, left: Sequence[Vector3], right: Sequence[Vector3]) -> Turn:
    """Begin a loop over the angles for which two sums of squares are equal (SP5 and SP6).

    What is squared is given by its factors of cos q, of sin q, and of nothing.
    """
    total = code.total

    def summed(first: int, second: int) -> Term:
        share = Term(1.0 if first == second else 2.0)
        return total(
            *((share, one[first], one[second]) for one in left),
            *((-share, one[first], one[second]) for one in right),
        )

    pairs = ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2))
    parts = [summed(first, second) for first, second in pairs]
    angle = code.variable()
    code.loop(code.call("on_conic", *parts), angle)
    return turn_of(code, angle)


def at(code: CodeLines, turn: Turn, linear: Vector3) -> Term:
    """Return the value of a cos q + b sin q + c."""
    return code.dot(linear, (turn.cos, turn.sin, Term(1.0)))


# What the code calls.

Solved = tuple[float, float, float, float, tuple[float, ...]]
"""The factors of an equation, the share that makes them a unit vector, and the sines' roots."""


def linear(a: float, b: float, c: float, free: float, size: float) -> Solved:
    """Return what solves a cos q + b sin q = c: the values of a sin q - b cos q.

    They are none where the goal is beyond the edge of what can be reached, and one, zero, at the
    edge or where rounding has put it there. Before them come a, b and c of an equation that
    rounding has not spoiled, and 1 / (a² + b²). The free angle solves an equation of zeros.
    """
    square = a * a + b * b
    if square <= (NO_MATTER * size) ** 2:
        met = abs(c) <= 10.0 * NO_MATTER * size
        return cos(free), sin(free), 1.0, 1.0, (0.0,) if met else ()
    gap = square - c * c
    if gap > 0.0:
        root = sqrt(gap)
        return a, b, c, 1.0 / square, (root, -root)
    roots = (0.0,) if gap >= -TOUCHING * square else ()
    return a, b, math.copysign(sqrt(square), c), 1.0 / square, roots


NEARLY_REAL = 1e-3
"""Imaginary part, as a share, of a root that rounding may have taken off the real line: the square
root of the precision of a double root's coefficients, with room."""

MET = 1e-9
"""What a conic may have left, as a share of its coefficients, at an angle that solves it."""


def on_conic(cc: float, cs: float, ss: float, c: float, s: float, one: float) -> tuple[float, ...]:
    """Return the angles with cc cos² + cs cos sin + ss sin² + c cos + s sin + one = 0.

    By the tangent of half the angle, counted from where the conic is far from zero, so that no
    root is at infinity; each is then improved by Newton's steps on the angle.
    """
    size = max(abs(cc), abs(cs), abs(ss), abs(c), abs(s), abs(one))
    if size == 0.0:
        return ()

    def value(q: float) -> float:
        x, y = cos(q), sin(q)
        return x * (cc * x + cs * y + c) + y * (ss * y + s) + one

    away = max((0.3, 1.5, 2.7, 3.9, 5.1), key=lambda q: abs(value(q)))
    back = away - pi  # the half angle's tangent is infinite at `away`
    x, y = cos(back), sin(back)
    cc, cs, ss = (
        cc * x * x + cs * x * y + ss * y * y,
        2.0 * (ss - cc) * x * y + cs * (x * x - y * y),
        cc * y * y - cs * x * y + ss * x * x,
    )
    c, s = c * x + s * y, s * x - c * y
    found: list[float] = []
    for root in quartic_roots(
        cc - c + one,
        2.0 * (s - cs),
        4.0 * ss - 2.0 * cc + 2.0 * one,
        2.0 * (s + cs),
        cc + c + one,
    ):
        if abs(root.imag) > NEARLY_REAL * (1.0 + abs(root)):
            continue
        angle = 2.0 * math.atan(root.real)
        angle = _improved(angle, cc, cs, ss, c, s, one)
        x, y = cos(angle), sin(angle)
        left = x * (cc * x + cs * y + c) + y * (ss * y + s) + one
        turned_back = math.remainder(angle + back, math.tau)
        if abs(left) <= MET * size and all(
            abs(math.remainder(turned_back - other, math.tau)) > MET for other in found
        ):
            found.append(turned_back)
    return tuple(found)


def _improved(q: float, cc: float, cs: float, ss: float, c: float, s: float, one: float) -> float:
    """Return an angle after a few of Newton's steps, as long as they gain."""
    best, before = math.inf, q
    for _ in range(8):
        x, y = cos(q), sin(q)
        left = x * (cc * x + cs * y + c) + y * (ss * y + s) + one
        if abs(left) >= best:
            return before
        slope = 2.0 * (ss - cc) * x * y + cs * (x * x - y * y) - c * y + s * x
        if left == 0.0 or slope == 0.0:
            return q
        best, before = abs(left), q
        q -= left / slope
    return q


def quartic_roots(a: float, b: float, c: float, d: float, e: float) -> Sequence[complex]:
    """Return the roots of a x⁴ + b x³ + c x² + d x + e (Ferrari); a is not zero."""
    b, c, d, e = b / a, c / a, d / a, e / a
    shift = b / 4.0
    p = c - 6.0 * shift * shift
    q = d - 2.0 * c * shift + 8.0 * shift**3
    r = e - d * shift + c * shift * shift - 3.0 * shift**4
    m = _largest_root(p, p * p / 4.0 - r, -q * q / 8.0)
    if m <= 0.0:  # q is zero: a quadratic equation of the square
        inner = complex_sqrt(p * p / 4.0 - r)
        squares = (complex_sqrt(-p / 2.0 + inner), complex_sqrt(-p / 2.0 - inner))
        return [sign * root - shift for root in squares for sign in (1.0, -1.0)]
    width = sqrt(2.0 * m)
    found = []
    for sign in (1.0, -1.0):
        inner = complex_sqrt(-2.0 * p - 2.0 * m - sign * 2.0 * q / width)
        found += [0.5 * (sign * width + inner) - shift, 0.5 * (sign * width - inner) - shift]
    return found


def _largest_root(b: float, c: float, d: float) -> float:
    """Return the largest real root of x³ + b x² + c x + d, by its formula and Newton's steps."""
    p, q = c - b * b / 3.0, 2.0 * b**3 / 27.0 - b * c / 3.0 + d
    inner = q * q / 4.0 + p**3 / 27.0
    if inner >= 0.0:
        half = sqrt(inner)
        u = -q / 2.0 + (half if q <= 0.0 else -half)
        u = math.copysign(abs(u) ** (1.0 / 3.0), u)
        x = u - p / (3.0 * u) if u != 0.0 else 0.0
    else:
        radius = sqrt(-p / 3.0)
        share = max(-1.0, min(1.0, -q / (2.0 * radius**3)))
        x = 2.0 * radius * cos(math.acos(share) / 3.0)
    x -= b / 3.0
    for _ in range(3):
        slope = (3.0 * x + 2.0 * b) * x + c
        if slope == 0.0:
            break
        x -= (((x + b) * x + c) * x + d) / slope
    return x
