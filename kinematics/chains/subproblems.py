"""The canonical subproblems of which every closed form here consists.

Each turns about the z axis of some frame, in which the rest is known. Two suffice. A direction
turned to another one (Paden and Kahan's first subproblem; SP1 of Elias and Wen, 2022, "IK-Geo") has
one angle. A cos q + B sin q = C has two: every condition on a turned point's height (SP4) or on its
distance from another point (SP3) has that form, and a turn about two axes that meet (SP2) is one of
each.

The first part writes code (`CodeLines`), which calls the second part. Angles in rad.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from math import cos, sin, sqrt
from typing import NamedTuple

from kinematics.chains.code_lines import CodeLines, Term, Vector3

# Share of their usual size below which an angle's coefficients leave that angle free.
NO_MATTER = 1e-10

# How far (squared, as a share) a goal may lie beyond an edge and still be solved at the edge.
#
# Rounding needs far less. The solver compares every posture with the goal afterwards.
TOUCHING = 1e-6


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


# What the code calls.

# The factors of an equation, the share that makes them a unit vector, and the sines' roots.
Solved = tuple[float, float, float, float, tuple[float, ...]]


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
