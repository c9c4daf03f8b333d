"""Generate code that finds every posture of an arm for a frame of its tool, by its structure.

As in `generated`, the solution is written once for each link table as a Python function with
constants folded: an offset of zero costs nothing. Each structure is solved by a sequence of
`subproblems`, joint by joint from the first of a `Layout`: the loop over the angles of one joint
contains the code for all later joints. Lengths in mm, angles in rad.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from math import atan2, cos, sin, sqrt
from typing import NamedTuple

from kinematics.chains.chain import Chain
from kinematics.chains.code_lines import ZERO, CodeLines, Term, Vector3, X, Z, functions_of
from kinematics.chains.structure import Family, Layout
from kinematics.chains.subproblems import (
    Turn,
    across,
    along,
    angle_from,
    angle_or_free,
    each_linear,
    each_root,
    linear,
    turn_of,
    turned,
    unturned,
)
from kinematics.frames.transforms import Transform

Posture = tuple[float, ...]

# Return the postures for a frame. The second argument gives the values of free joints.
BranchFinder = Callable[[Transform, Sequence[float]], list[Posture]]

# Below this sine of the wrist's middle joint its outer joints are solved as a pair, at no loss of
# digits.
NEAR_STRAIGHT = 1e-3

# Below this sine only the outer joints' sum is defined. The hand is off by at most twice this.
STRAIGHT = 5e-11

# What generated code calls.
CALLED = {
    "atan2": atan2,
    "cos": cos,
    "sin": sin,
    "sqrt": sqrt,
    "remainder": math.remainder,
    "linear": linear,
}


def branch_finder(chain: Chain, family: Family, *, heading_free: bool = False) -> BranchFinder:
    """Return the function that finds every posture of a chain of this class.

    With `heading_free` the goal may be turned about the world's z axis through its origin: what is
    asked of five joints, the first axis vertical and the next three parallel.
    """
    arm = Layout(chain, family)
    if family is Family.THREE_PARALLEL:
        _write_parallel(arm, heading_free=heading_free)
    else:
        _write_spherical(arm)
    names = ", ".join(f"f{index}" for index in range(len(chain)))
    body = [
        "(g00, g01, g02, g03), (g10, g11, g12, g13), (g20, g21, g22, g23), _ = goal",
        f"{names} = free",
        "found = []",
        *arm.code.live(),
        "return found",
    ]
    source = "def branches(goal, free):\n" + "\n".join(f"    {line}" for line in body)
    found: BranchFinder = functions_of(source, CALLED, "inverse kinematics")["branches"]
    return found


# The first three joints, which place the wrist's centre.
#
# The wrist's centre is the point in which the wrist's axes meet. It is at p in the frame in which
# joint 1 turns, and at w in the frame that joint 3 carries. In between it is at h = Rz(-q1) p in
# the frame that joint 1 carries, at g = Rz(q2) k in the frame in which joint 2 turns, and at k in
# the frame that joint 2 carries. Sources: Pieper (1968), and McKerrow, chapter 4, section 16.


# The first three turns.
Placed = tuple[Turn, Turn, Turn]


def _carried(arm: Layout, index: int, turn: Turn, v: Vector3) -> Vector3:
    """Return a point carried by joint `index` + 1, in the frame that joint `index` carries."""
    code = arm.code
    return code.plus(arm.place(index), code.times(arm.rows(index), turned(code, turn, v)))


def _height_of(code: CodeLines, row: Vector3, v: Vector3) -> tuple[Term, Term, Term]:
    """Return the factors of cos q, sin q and nothing of row . Rz(q) v."""
    return along(code, row, v), across(code, v, row), code.total((row[2], v[2]))


def _each_at_height(
    arm: Layout, joint: int, row: Vector3, v: Vector3, height: Term, size: float
) -> Turn:
    """Begin a loop over the turns of a joint that bring row . Rz(q) v to a height (SP4).

    `joint` is its index, and `size` the usual size of a height.
    """
    a, b, c = _height_of(arm.code, row, v)
    return each_linear(arm.code, a, b, arm.code.total((height,), (-c,)), arm.free[joint], size)


def _each_at_distance(arm: Layout, joint: int, u: Vector3, v: Vector3, square: Term) -> Turn:
    """Begin a loop over a joint's turns that give u + Rz(q) v this squared length (SP3)."""
    code, two = arm.code, Term(2.0)
    a, b, c = _height_of(code, u, v)
    wanted = code.total((square,), (-code.dot(u, u),), (-code.dot(v, v),), (-two, c))
    return each_linear(
        code, code.total((two, a)), code.total((two, b)), wanted, arm.free[joint], arm.size**2
    )


def _level(v: Vector3) -> Vector3:
    return v[0], v[1], ZERO


def _second_and_third_parallel(arm: Layout) -> Placed:
    """The point's height along axis 2 gives joint 1, then the triangle of joints 2 and 3 is level.

    McKerrow, chapter 4, section 16, for any offsets.
    """
    code = arm.code
    height = code.total((arm.tilt(2), arm.place(3)[2]), (arm.place(2)[2],))
    first, seen = _first_by_height(arm, arm.origin, height)
    second, third = _triangle(arm, arm.into(1, code.minus(seen, arm.place(1))))
    return first, turn_of(code, second), third


def _first_by_height(arm: Layout, point: Vector3, height: Term) -> tuple[Turn, Vector3]:
    """Begin a loop over the turns of joint 1 that bring a point to a height along axis 2 (SP4).

    Return the turn, and the point as the frame sees it that joint 1 turns.
    """
    code = arm.code
    axis = code.times(arm.rows(1), Z)
    a, minus_b, c = _height_of(code, axis, point)
    level = code.total((height,), (-c,), *zip(axis, arm.place(1), strict=True))
    turn, root = each_root(code, a, -minus_b, level, arm.free[0], arm.size)
    # the root is the point's distance from the plane of axes 1 and 2
    (x, y, _), share = axis, code.reciprocal(along(code, axis, axis))
    seen_x = code.total((share, x, level), (share, y, root))
    seen_y = code.total((share, y, level), (-share, x, root))
    return turn, (seen_x, seen_y, point[2])


def _triangle(arm: Layout, g: Vector3) -> tuple[Term, Turn]:
    """Begin a loop over joint 3's turns (SP3); return joint 2's angle and joint 3's turn.

    Axes 2 and 3 are parallel, and g is where the point is seen by joint 2's frame.
    """
    code, w, square = arm.code, _level(arm.place(3)), along(arm.code, g, g)
    third = _each_at_distance(arm, 2, _level(arm.into(2, arm.place(2))), w, square)
    k = _carried(arm, 2, third, w)
    return angle_or_free(code, k, g, square, arm.free[1], arm.size), third


# The joints beyond the third, whose axes meet: they turn the hand.


def _write_spherical(arm: Layout) -> None:
    """Write the postures of an arm whose last three axes meet."""
    placed = _second_and_third_parallel(arm)
    if _square(arm):
        _write_square_wrist(arm, placed)
    else:
        _write_wrist(arm, placed)


def _seen(arm: Layout, placed: Placed, v: Vector3) -> Vector3:
    """Return a direction as joint 4's frame sees it."""
    for index, turn in enumerate(placed, 1):
        v = arm.into(index, unturned(arm.code, turn, v))
    return v


def _angles(placed: Placed) -> list[Term]:
    return [turn.angle for turn in placed]


def _square(arm: Layout) -> bool:
    """Whether the wrist's axes are at right angles, and joint 5's zero is where it is straight."""
    across_4, across_5 = arm.rows(4)[2], arm.code.times(arm.rows(5), Z)
    straight = arm.code.dot(across_4, across_5)
    return abs(straight.factor) == 1.0 and not straight.variable and across_4[2] == ZERO


def _write_square_wrist(arm: Layout, placed: Placed) -> None:
    """A wrist at right angles has two postures: joint 5 bent either way, the others half a turn."""
    code = arm.code
    x, y, z = (_seen(arm, placed, column) for column in (arm.x, arm.y, arm.z))
    rows_4, rows_5 = arm.rows(4), arm.rows(5)
    u, row = code.times(rows_5, Z), rows_4[2]
    side = code.dot(row, u)
    bent = code.call("sqrt", along(code, z, z))
    fifth = code.call("atan2", code.total((side, bent)), code.total((side, z[2])))
    # Rz(q4)'s argument and the row that Rz(q6) turns, both for joint 5 bent by a quarter turn
    quarter: Vector3 = (-u[1], u[0], ZERO)
    level = tuple(code.total((side, code.dot(one, quarter))) for one in rows_4[:2])
    aside: Vector3 = (row[1], -row[0], ZERO)
    turning = tuple(
        code.total((side, code.dot(aside, (rows_5[0][i], rows_5[1][i], ZERO)))) for i in range(2)
    )
    fourth, sixth = angle_from(code, level, z), code.variable()
    code.open("if {} > {}:", bent, Term(NEAR_STRAIGHT))
    last = (x[2], y[2])
    code.set(sixth, "atan2({}, {})", across(code, last, turning), along(code, last, turning))
    code.close()
    code.open("else:")
    code.set(fourth, "{} if {} > {} else {}", fourth, bent, Term(STRAIGHT), arm.free[3])
    v = arm.into(4, unturned(code, turn_of(code, fourth), x))
    v = arm.into(5, unturned(code, turn_of(code, fifth), v))
    code.set(sixth, "atan2({}, {})", across(code, X, v), along(code, X, v))
    code.close()
    plain_posture = (*_angles(placed), fourth, fifth, sixth)
    flipped = []
    for angle in (fourth, sixth):
        other = code.variable()
        half = Term(math.pi)
        code.set(other, "{}-{} if {} > 0.0 else {}+{}", angle, half, angle, angle, half)
        flipped.append(other)
    arm.found(plain_posture, (*_angles(placed), flipped[0], -fifth, flipped[1]))


def _write_wrist(arm: Layout, placed: Placed) -> None:
    """A wrist of any angles: axis 6's lean to axis 4 gives joint 5 (SP4), then SP1 twice."""
    code = arm.code
    x, z = (_seen(arm, placed, column) for column in (arm.x, arm.z))
    u = code.times(arm.rows(5), Z)
    fifth = _each_at_height(arm, 4, arm.rows(4)[2], u, z[2], 1.0)
    axis = code.times(arm.rows(4), turned(code, fifth, u))
    fourth = angle_or_free(code, axis, z, along(code, z, z), arm.free[3], 1.0)
    v = arm.into(4, unturned(code, turn_of(code, fourth), x))
    v = arm.into(5, unturned(code, fifth, v))
    arm.found((*_angles(placed), fourth, fifth.angle, angle_from(code, X, v)))


# Axes 2, 3 and 4 parallel: what is seen along them gives the joints before and beyond them, and the
# triangle of joints 2 and 3 is level (Elias and Wen, 2022, section 5.4).


class _Outer(NamedTuple):
    """The joints that are not about the three parallel axes, and what is left for those.

    `level` is where the three together turn `X` to, in joint 2's frame; that frame sees the last
    joint's origin at `g`, and the frame that joint 4 carries has it at `beyond`.
    """

    first: Term
    last: tuple[Term, ...]
    level: Vector3
    g: Vector3
    beyond: Vector3


def _write_parallel(arm: Layout, *, heading_free: bool) -> None:
    """Write the postures of an arm whose axes 2, 3 and 4 are parallel."""
    code = arm.code
    outer = _outer_of_six(arm) if len(arm) == 6 else _outer_of_five(arm, heading_free=heading_free)
    start = _through_three(arm, X)
    cosine, sine = along(code, start, outer.level), across(code, start, outer.level)
    three = Turn(code.call("atan2", sine, cosine), cosine, sine)
    hinge = code.minus(outer.g, turned(code, three, _through_three(arm, outer.beyond)))
    second, third = _triangle(arm, hinge)
    tilt = code.total((arm.tilt(2), arm.tilt(3)))
    left = code.total((tilt, three.angle), (-tilt, second), (-arm.tilt(3), third.angle))
    fourth = code.call("remainder", left, Term(math.tau))
    arm.found((outer.first, second, third.angle, fourth, *outer.last))


def _through_three(arm: Layout, v: Vector3) -> Vector3:
    """Return a direction of joint 4's frame in joint 2's, where the three joints' sum is zero."""
    return arm.code.times(arm.rows(2), arm.code.times(arm.rows(3), v))


def _height_beyond(arm: Layout) -> Term:
    """Return the height along axis 2, as joint 1 carries it, of joint 4's end of the arm."""
    code, both = arm.code, arm.code.total((arm.tilt(2), arm.tilt(3)))
    return code.total((arm.place(2)[2],), (arm.tilt(2), arm.place(3)[2]), (both, arm.place(4)[2]))


def _outer_of_six(arm: Layout) -> _Outer:
    """Axis 6's lean to axis 2 and the height of its origin are conditions on joints 1 and 5."""
    code, total = arm.code, arm.code.total
    both = total((arm.tilt(2), arm.tilt(3)))
    u, v = code.times(arm.rows(5), Z), arm.place(5)
    row = arm.rows(4)[2]
    lean = [total((both, one)) for one in _height_of(code, row, u)]
    rise = total((both, _height_of(code, row, v)[2]), (_height_beyond(arm),))
    first, _ = _first_by_height(arm, arm.origin, rise)
    x, y, z = (arm.into(1, unturned(code, first, column)) for column in (arm.x, arm.y, arm.z))
    fifth = each_linear(code, lean[0], lean[1], total((z[2],), (-lean[2],)), arm.free[4], 1.0)
    g = arm.into(1, code.minus(unturned(code, first, arm.origin), arm.place(1)))
    row = arm.into(5, unturned(code, fifth, row))
    turning = [total((both, one)) for one in row[:2]]
    square = along(code, turning, turning)
    sixth = angle_or_free(code, (x[2], y[2]), turning, square, arm.free[5], 1.0)
    w = unturned(code, fifth, arm.into(4, X))
    w = unturned(code, turn_of(code, sixth), arm.into(5, w))
    level = _combined(code, (x, y, z), w)
    beyond = _carried(arm, 4, fifth, v)
    return _Outer(first.angle, (fifth.angle, sixth), level, g, beyond)


def _first_by_lean(arm: Layout, lean: Term) -> Turn:
    """Begin a loop over the turns of joint 1 that lean the last axis to axis 2 as it must (SP4)."""
    code = arm.code
    a, minus_b, c = _height_of(code, code.times(arm.rows(1), Z), arm.z)
    return each_linear(code, a, -minus_b, code.total((lean,), (-c,)), arm.free[0], 1.0)


def _outer_of_five(arm: Layout, *, heading_free: bool) -> _Outer:
    """Height and lean of axis 5 each give joint 1: the one that says more is taken."""
    code, total = arm.code, arm.code.total
    both = total((arm.tilt(2), arm.tilt(3)))
    row = arm.rows(4)[2]
    lean, height = total((both, row[2])), _height_beyond(arm)
    if heading_free:
        heading = _first_by_lean(arm, lean)
        hand = [unturned(code, heading, column) for column in (arm.x, arm.y, arm.z)]
        way = _combined(code, hand, arm.last_origin)
        ahead = code.dot(code.times(arm.rows(1), Z), way)
        first, tip = _first_by_height(arm, arm.tip, total((height,), (ahead,)))
        origin = code.minus(tip, way)
    else:
        first = _first_by_either(arm, lean, height)
        hand = [unturned(code, first, column) for column in (arm.x, arm.y, arm.z)]
        origin = unturned(code, first, arm.origin)
    x, y, z = (arm.into(1, column) for column in hand)
    g = arm.into(1, code.minus(origin, arm.place(1)))
    turning = [total((both, one)) for one in row[:2]]
    fifth = angle_from(code, (x[2], y[2]), turning)
    w = unturned(code, turn_of(code, fifth), arm.into(4, X))
    return _Outer(first.angle, (fifth,), _combined(code, (x, y, z), w), g, arm.place(4))


def _first_by_either(arm: Layout, lean: Term, height: Term) -> Turn:
    """Begin a loop over joint 1's turns by the height of axis 5's origin, or by that axis's lean.

    Near the base axis the height says little of joint 1, and a vertical hand's lean nothing.
    """
    code = arm.code
    axis = code.times(arm.rows(1), Z)
    size = Term(arm.size)
    a, minus_b, c = _height_of(code, axis, arm.origin)
    by_height = a, -minus_b, code.total((height,), (code.dot(axis, arm.place(1)),), (-c,))
    a, minus_b, c = _height_of(code, axis, arm.z)
    right = code.total((size, lean), (-size, c))
    by_lean = code.total((size, a)), code.total((-size, minus_b)), right
    says = [code.total((one[0], one[0]), (one[1], one[1])) for one in (by_height, by_lean)]
    names = [code.variable() for _ in range(3)]
    for name, one, other in zip(names, by_height, by_lean, strict=True):
        code.set(name, "{} if {} >= {} else {}", one, *says, other)
    return each_linear(code, names[0], names[1], names[2], arm.free[0], arm.size)


def _combined(code: CodeLines, columns: Sequence[Vector3], v: Vector3) -> Vector3:
    """Return a vector given in axes, which are these columns."""
    x, y, z = (code.dot(row, v) for row in zip(*columns, strict=True))
    return x, y, z
