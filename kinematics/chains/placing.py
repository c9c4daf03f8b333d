"""Code for the first three joints, which place the point where a wrist's axes meet, in five ways.

Joint 1's frame sees the point at p; joint 3 carries it at w. Between them h = Rz(-q1) p is what
joint 1's frame carries, g = Rz(q2) k what joint 2's frame sees, and k what that frame carries.
Sources: Pieper (1968), and McKerrow, chapter 4, section 16. Lengths in mm, angles in rad.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from kinematics.chains.code_lines import ZERO, CodeLines, Term, Vector3, Z
from kinematics.chains.structure import FirstThree, Layout
from kinematics.chains.subproblems import (
    Linear,
    Turn,
    across,
    along,
    angle_from,
    angle_or_free,
    at,
    each_linear,
    each_on_conic,
    each_root,
    linear,
    turn_of,
    turned,
    unturned,
)

UNEQUAL = 1e-6
"""Links whose lengths differ by more than this share of the arm's never fold onto a joint."""


class Placed(NamedTuple):
    """The first three turns, and the last two as one where their axes are parallel."""

    turns: tuple[Turn, Turn, Turn]
    last_two: Turn | None = None


def carried(arm: Layout, index: int, turn: Turn, v: Vector3) -> Vector3:
    """Return a point carried by joint `index` + 1, in the frame that joint `index` carries."""
    code = arm.code
    return code.plus(arm.place(index), code.times(arm.rows(index), turned(code, turn, v)))


def height_of(code: CodeLines, row: Vector3, v: Vector3) -> tuple[Term, Term, Term]:
    """Return the factors of cos q, sin q and nothing of row . Rz(q) v."""
    return along(code, row, v), across(code, v, row), code.total((row[2], v[2]))


def _level(v: Vector3) -> Vector3:
    return v[0], v[1], ZERO


def _second_and_third_parallel(arm: Layout) -> Placed:
    """The point's height along axis 2 gives joint 1, then the triangle of joints 2 and 3 is level.

    McKerrow, chapter 4, section 16, for any offsets. Where axes 1 and 2 meet, or axis 2 is only
    moved along itself, the point is as far from axis 2 for both turns of joint 1: the elbow bends
    alike, and its angles need not be found twice.
    """
    code, p, start = arm.code, arm.origin, arm.place(1)
    height = code.total((arm.tilt(2), arm.place(3)[2]), (arm.place(2)[2],))
    shoulder = _by_height(arm, p, height)
    elbow = None
    if across(code, shoulder.axis, start) == ZERO:
        elbow = _elbow(arm, _square_from_second(arm, shoulder, height))
    first, seen = _each_first(arm, p, shoulder)
    g = arm.into(1, code.minus(seen, start))
    second, third = _second_and_third(arm, g, elbow or _elbow(arm, along(code, g, g)))
    both = code.total((second,), (arm.tilt(2), third.angle))
    return Placed((first, Turn(second, ZERO, ZERO), third), turn_of(code, both))


def _square_from_second(arm: Layout, shoulder: _ByHeight, height: Term) -> Term:
    """Return the square of the point's distance from axis 2, where it is that of both turns."""
    code, p, start = arm.code, arm.origin, arm.place(1)
    two, level_square = Term(2.0), along(code, p, p)
    share = code.reciprocal(along(code, shoulder.axis, shoulder.axis))
    towards = code.total((share, along(code, shoulder.axis, start)))
    return code.total(
        (level_square,),
        (p[2], p[2]),
        (code.dot(start, start),),
        (-two, start[2], p[2]),
        (-two, towards, shoulder.level),
        (-height, height),
    )


class _ByHeight(NamedTuple):
    """What brings a point to a height along axis 2 by joint 1, in whose frame the axis is given.

    `level` is the part of the height, from joint 1's origin, that joint 1 has a say in.
    """

    solved: Linear
    axis: Vector3
    level: Term


def _by_height(arm: Layout, point: Vector3, height: Term) -> _ByHeight:
    code = arm.code
    axis = code.times(arm.rows(1), Z)
    a, minus_b, c = height_of(code, axis, point)
    level = code.total((height,), (-c,), *zip(axis, arm.place(1), strict=True))
    solved = linear(code, a, -minus_b, level, arm.free[0], arm.size)
    return _ByHeight(solved, axis, level)


def _each_first(arm: Layout, point: Vector3, shoulder: _ByHeight) -> tuple[Turn, Vector3]:
    """Begin the loop over joint 1's turns; return the turn and the point as its frame sees it.

    The root that tells the turns apart is the point's distance from the plane of axes 1 and 2.
    """
    code = arm.code
    turn, root = each_root(code, shoulder.solved)
    (x, y, _), level = shoulder.axis, shoulder.level
    share = code.reciprocal(along(code, shoulder.axis, shoulder.axis))
    seen_x = code.total((share, x, level), (share, y, root))
    seen_y = code.total((share, y, level), (-share, x, root))
    return turn, (seen_x, seen_y, point[2])


def first_by_height(arm: Layout, point: Vector3, height: Term) -> tuple[Turn, Vector3]:
    """Begin a loop over the turns of joint 1 that bring a point to a height along axis 2 (SP4).

    Return the turn, and the point as the frame sees it that joint 1 turns.
    """
    return _each_first(arm, point, _by_height(arm, point, height))


def triangle(arm: Layout, g: Vector3) -> tuple[Term, Turn]:
    """Begin a loop over joint 3's turns (SP3); return joint 2's angle and joint 3's turn.

    Axes 2 and 3 are parallel, and g is where the point is seen by joint 2's frame.
    """
    return _second_and_third(arm, g, _elbow(arm, along(arm.code, g, g)))


def _elbow(arm: Layout, square: Term) -> Linear:
    """Write what bends joint 3 so that the point's distance from axis 2 has this square."""
    code, w, hinge = arm.code, _level(arm.place(3)), _hinge(arm)
    a, b, _ = height_of(code, hinge, w)
    two = Term(2.0)
    wanted = code.total((square,), (-along(code, w, w),), (-along(code, hinge, hinge),))
    a, b = code.total((two, a)), code.total((two, b))
    return linear(code, a, b, wanted, arm.free[2], arm.size**2)


def _hinge(arm: Layout) -> Vector3:
    """Return the level way from axis 2 to axis 3 as joint 3's frame sees it, before it turns."""
    return _level(arm.into(2, arm.place(2)))


def _second_and_third(arm: Layout, g: Vector3, elbow: Linear) -> tuple[Term, Turn]:
    """Begin the loop over joint 3's turns; return joint 2's angle and joint 3's turn."""
    code, w = arm.code, _level(arm.place(3))
    third, _ = each_root(code, elbow)
    k = carried(arm, 2, third, w)
    if _unequal(_hinge(arm), w, arm.size):  # then the point is never on axis 2
        return angle_from(code, k, g), third
    return angle_or_free(code, k, g, along(code, g, g), arm.free[1], arm.size), third


def _unequal(u: Vector3, v: Vector3, size: float) -> bool:
    """Whether two level vectors are of constant lengths that differ."""
    if any(one.variable for one in (*u, *v)):
        return False
    lengths = [math.hypot(one[0].factor, one[1].factor) for one in (u, v)]
    return abs(lengths[0] - lengths[1]) > UNEQUAL * size


def _first_and_second_meet(arm: Layout) -> Placed:
    """The distance from where axes 1 and 2 meet gives joint 3, the height joint 2 (Pieper)."""
    code, w = arm.code, arm.place(3)
    hinge = arm.into(2, arm.place(2))
    a, b, c = height_of(code, hinge, w)
    two = Term(2.0)
    wanted = code.total(
        (code.dot(arm.origin, arm.origin),),
        (-code.dot(w, w),),
        (-code.dot(hinge, hinge),),
        (-two, c),
    )
    third = each_linear(
        code, code.total((two, a)), code.total((two, b)), wanted, arm.free[2], arm.size**2
    )
    k = carried(arm, 2, third, w)
    return _second_by_height(arm, third, k)


def _second_by_height(arm: Layout, third: Turn, k: Vector3) -> Placed:
    """Begin a loop over joint 2's turns by the point's height along axis 1, which gives joint 1."""
    code = arm.code
    a, b, c = height_of(code, arm.rows(1)[2], k)
    wanted = code.total((arm.origin[2],), (-c,), (-arm.place(1)[2],))
    second = each_linear(code, a, b, wanted, arm.free[1], arm.size)
    return _first_at_last(arm, second, third, k)


def _first_at_last(arm: Layout, second: Turn, third: Turn, k: Vector3) -> Placed:
    """Return the turns, joint 1's from where the others bring the point (SP1)."""
    code, p = arm.code, arm.origin
    h = carried(arm, 1, second, k)
    first = angle_or_free(code, h, p, along(code, p, p), arm.free[0], arm.size)
    return Placed((turn_of(code, first), second, third))


def _first_and_second_parallel(arm: Layout) -> Placed:
    """The height along axes 1 and 2 gives joint 3, the distance from axis 1 joint 2."""
    code, w = arm.code, arm.place(3)
    a, b, c = height_of(code, arm.rows(2)[2], w)
    level = code.total((arm.tilt(1), arm.origin[2]), (-arm.tilt(1), arm.place(1)[2]))
    third = each_linear(
        code, a, b, code.total((level,), (-c,), (-arm.place(2)[2],)), arm.free[2], arm.size
    )
    k = carried(arm, 2, third, w)
    hinge = _level(arm.into(1, arm.place(1)))
    a, b, _ = height_of(code, hinge, _level(k))
    two = Term(2.0)
    wanted = code.total(
        (along(code, arm.origin, arm.origin),),
        (-along(code, k, k),),
        (-along(code, hinge, hinge),),
    )
    second = each_linear(
        code, code.total((two, a)), code.total((two, b)), wanted, arm.free[1], arm.size**2
    )
    return _first_at_last(arm, second, third, k)


def _second_and_third_meet(arm: Layout) -> Placed:
    """The distance from where axes 2 and 3 meet gives joint 1, then two axes meet (SP2)."""
    code, p, w, meet = arm.code, arm.origin, arm.place(3), arm.place(1)
    two = Term(2.0)
    wanted = code.total(
        (code.dot(p, p),), (code.dot(meet, meet),), (-code.dot(w, w),), (-two, meet[2], p[2])
    )
    a, minus_b, _ = height_of(code, meet, p)
    first = each_linear(
        code, code.total((two, a)), code.total((-two, minus_b)), wanted, arm.free[0], arm.size**2
    )
    g = arm.into(1, code.minus(unturned(code, first, p), meet))
    a, b, c = height_of(code, arm.rows(2)[2], w)
    third = each_linear(code, a, b, code.total((g[2],), (-c,)), arm.free[2], arm.size)
    k = carried(arm, 2, third, w)
    second = angle_or_free(code, k, g, along(code, g, g), arm.free[1], arm.size)
    return Placed((first, turn_of(code, second), third))


def _three_of_any_kind(arm: Layout) -> Placed:
    """Height along axis 1 and distance from it give g by k, and a conic for joint 3 (Pieper).

    Both are linear in g, whose level part has the length of k's.
    """
    code, w, meet = arm.code, arm.place(3), arm.place(1)
    total = code.total
    k = [
        (*height_of(code, row, w)[:2], total((code.total((row[2], w[2])),), (start,)))
        for row, start in zip(arm.rows(2), arm.place(2), strict=True)
    ]
    n, m = arm.rows(1)[2], arm.into(1, meet)
    hinge = arm.into(2, arm.place(2))
    a, b, c = height_of(code, hinge, w)
    half = Term(0.5)
    square = (code.dot(w, w), code.dot(hinge, hinge), code.dot(meet, meet))
    distance = total((half, code.dot(arm.origin, arm.origin)), *((-half, one) for one in square))
    raised = total((arm.origin[2],), (-meet[2],))
    # n . g = raised and m . g = distance - hinge . Rz(q3) w, where g is as high as k
    right_n = [total((-n[2], k[2][i]), *((raised,),) * (i == 2)) for i in range(3)]
    less = (a, b, total((c,), (-distance,)))
    right_m = [total((-m[2], k[2][i]), (-less[i],)) for i in range(3)]
    share = code.reciprocal(total((n[0], m[1]), (-n[1], m[0])))
    pairs = list(zip(right_n, right_m, strict=True))
    x = [total((share, m[1], p), (-share, n[1], q)) for p, q in pairs]
    y = [total((share, n[0], q), (-share, m[0], p)) for p, q in pairs]
    g_x, g_y = (x[0], x[1], x[2]), (y[0], y[1], y[2])
    third = each_on_conic(code, (g_x, g_y), (k[0], k[1]))
    seen = [at(code, third, one) for one in k]
    g = (at(code, third, g_x), at(code, third, g_y), seen[2])
    kept: Vector3 = (seen[0], seen[1], seen[2])
    square_g = along(code, g, g)
    second = turn_of(code, angle_or_free(code, kept, g, square_g, arm.free[1], arm.size))
    return _first_at_last(arm, second, third, kept)


PLACING: dict[FirstThree, Callable[[Layout], Placed]] = {
    FirstThree.SECOND_AND_THIRD_PARALLEL: _second_and_third_parallel,
    FirstThree.FIRST_AND_SECOND_PARALLEL: _first_and_second_parallel,
    FirstThree.FIRST_AND_SECOND_MEET: _first_and_second_meet,
    FirstThree.SECOND_AND_THIRD_MEET: _second_and_third_meet,
    FirstThree.GENERAL: _three_of_any_kind,
}
