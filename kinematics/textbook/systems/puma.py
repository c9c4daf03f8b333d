"""The simplified Puma: six revolute joints, a spherical wrist, eight branches.

Source: McKerrow, chapter 4, section 16, which neglects l3, the elbow's small offset; link table
and joint ranges after Fu, Gonzalez and Lee (1987), chapter 2. Any lengths may be given, the
offsets of shoulder and elbow included. Lengths in mm, angles in rad.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import product
from types import MappingProxyType

from kinematics.chains.branches import STRAIGHT
from kinematics.chains.chain import Chain
from kinematics.chains.closed_form import closed_form
from kinematics.chains.goals import frame_goal
from kinematics.chains.links import DHLink
from kinematics.errors import OutOfReach
from kinematics.five_axis.closed_form import REACH_MM
from kinematics.frames.numbers import atan2, cos, sin
from kinematics.frames.orientations import RPY
from kinematics.frames.transforms import (
    LAST_ROW,
    Transform,
    compose,
    homogeneous,
    position_of,
    translation,
)
from kinematics.textbook.systems.named import (
    QUARTER_TURN,
    NamedBranch,
    NamedSingularity,
    Quantity,
    Solved,
    System,
    Values,
    frame_coordinates,
)
from kinematics.textbook.systems.triangle import (
    broken_bound,
    brought_within,
    elbow_loss,
    elbow_singularities,
    root,
    to_half_turn,
    triangle,
)

WRIST_STRAIGHT = "joint 5 is straight: only joints 4 and 6 together turn the hand"
BASE_EDGE = "the wrist is as near to the base axis as it goes: front and back are one"
BASE_FREE = "the wrist is on the base axis: the base is free"

RANGES_DEG = ((-160, 160), (-225, 45), (-45, 225), (-110, 170), (-100, 100), (-266, 266))


def _table(d1: float, a1: float, d2: float, a2: float, a3: float, d4: float, d6: float) -> Chain:
    """Return the link table of Fu, Gonzalez and Lee, the zero position theirs too."""
    rows = (
        (d1, a1, -QUARTER_TURN),
        (d2, a2, 0.0),
        (0.0, a3, QUARTER_TURN),
        (d4, 0.0, -QUARTER_TURN),
        (0.0, 0.0, QUARTER_TURN),
        (d6, 0.0, 0.0),
    )
    links = tuple(DHLink(0.0, d, a, alpha) for d, a, alpha in rows)
    return Chain(links, joint_names=tuple(f"theta{number}" for number in range(1, 7)))


def _forward(one: System, joints: Values) -> Transform:
    d1, a1, d2, a2, a3, d4, d6 = one.sizes
    first, second, third, fourth, fifth, sixth = joints
    both = second + third
    c1, s1, c, s = cos(first), sin(first), cos(both), sin(both)
    out = a1 + a2 * cos(second) + a3 * c + d4 * s
    up = d1 - a2 * sin(second) - a3 * s + d4 * c
    forearm = (
        (c1 * c, -s1, c1 * s, c1 * out - s1 * d2),
        (s1 * c, c1, s1 * s, s1 * out + c1 * d2),
        (-s, 0.0, c, up),
        LAST_ROW,
    )
    c4, s4, c5, s5 = cos(fourth), sin(fourth), cos(fifth), sin(fifth)
    c6, s6 = cos(sixth), sin(sixth)
    wrist = (
        (c4 * c5 * c6 - s4 * s6, -(c4 * c5 * s6) - s4 * c6, c4 * s5, d6 * c4 * s5),
        (s4 * c5 * c6 + c4 * s6, c4 * c6 - s4 * c5 * s6, s4 * s5, d6 * s4 * s5),
        (-(s5 * c6), s5 * s6, c5, d6 * c5),
        LAST_ROW,
    )
    return compose(forearm, wrist)


def _frame_of(goal: Sequence[float]) -> Transform:
    """Return the hand's frame of a goal x, y, z, phi, theta, psi (sections 8 and 10)."""
    x, y, z, phi, theta, psi = goal
    return homogeneous(RPY(phi, theta, psi).rotation(), (x, y, z))


def _coordinates_of(_one: System, frame: Transform) -> Values:
    return frame_coordinates(frame)


def _formulas(one: System, goal: Values, side: float, bend: float, flip: float) -> Solved:
    return _of_frame_by_formulas(one, _frame_of(goal), side, bend, flip)


def _of_frame_by_formulas(one: System, frame: Transform, *signs: float) -> Solved:
    """Solve one branch of a frame as the derivation does, on numbers of any kind."""
    d1, a1, d2, a2, a3, d4, d6 = one.sizes
    side, bend, flip = signs
    (nx, ox, ax, px), (ny, oy, ay, py), (nz, oz, az, pz), _ = frame
    x, y, z = px - d6 * ax, py - d6 * ay, pz - d6 * az
    out = side * root(x * x + y * y - d2 * d2)
    first = atan2(y, x) - atan2(d2, out)
    elbow = triangle(out - a1, z - d1, a2, root(a3 * a3 + d4 * d4), -(side * bend))
    lean = atan2(d4, a3)
    both = lean - elbow.second - elbow.first
    c1, s1, c, s = cos(first), sin(first), cos(both), sin(both)
    n, o, a = c1 * nx + s1 * ny, c1 * ox + s1 * oy, c1 * ax + s1 * ay
    wx, wy, wz = c * a - s * az, c1 * ay - s1 * ax, s * a + c * az
    bent = flip * root(wx * wx + wy * wy)
    fourth = atan2(flip * wy, flip * wx)
    sixth = atan2(flip * (s * o + c * oz), -(flip * (s * n + c * nz)))
    joints = (first, -elbow.first, lean - elbow.second, fourth, atan2(bent, wz), sixth)
    workings = (
        Quantity("xw", x, "mm"),
        Quantity("yw", y, "mm"),
        Quantity("zw", z, "mm"),
        Quantity("rho", out, "mm"),
        *elbow.workings(),
        Quantity("S5", bent, ""),
    )
    return joints, workings


def _postures(one: System, goal: Values, seed: Values) -> Sequence[NamedBranch]:
    return _postures_of_frame(one, _frame_of(goal), seed)


def _of_frame(one: System, frame: Transform, near: Values) -> Sequence[NamedBranch]:
    """Return every branch for a whole frame; six joints miss nothing but rounding."""
    return one.finished(_postures_of_frame(one, frame, near), near)


def _postures_of_frame(one: System, frame: Transform, seed: Values) -> list[NamedBranch]:
    closed = closed_form(one.chain())
    postures = [] if closed is None else closed.postures(frame_goal(frame), seed)
    names = {signs: name for name, signs in one.signs.items()}
    named = {
        (name := names[_signs(one, frame, joints)]): _named(one, name, frame, joints)
        for joints in postures
    }
    if not named:
        raise _refusal(one, frame)
    return [named[name] for name in one.signs if name in named]


def _signs(one: System, frame: Transform, joints: Values) -> tuple[float, float, float]:
    """Return which branch a posture is: the signs that the formulas take for base, elbow, wrist."""
    x, y, _ = _wrist(one, frame)
    out = math.cos(joints[0]) * x + math.sin(joints[0]) * y
    side = 1.0 if out >= -REACH_MM else -1.0
    _, _, _, _, a3, d4, _ = one.sizes
    bend = -side * math.sin(math.atan2(d4, a3) - joints[2])
    return side, 1.0 if bend >= 0.0 else -1.0, math.copysign(1.0, joints[4])


def _named(one: System, branch: str, frame: Transform, joints: Values) -> NamedBranch:
    _, _, d2, a2, a3, d4, _ = one.sizes
    singularities, free = [], []
    x, y, _ = _wrist(one, frame)
    out = math.hypot(x, y)
    if out <= REACH_MM:
        singularities.append(BASE_FREE)
        free.append("theta1")
    elif abs(out - abs(d2)) <= REACH_MM:
        singularities.append(BASE_EDGE)
    lost, first_free = elbow_loss(math.atan2(d4, a3) - joints[2], a2, _fore(one))
    singularities += [lost] if lost else []
    free += ["theta2"] if first_free else []
    if abs(math.sin(joints[4])) <= STRAIGHT:
        singularities.append(WRIST_STRAIGHT)
        free.append("theta4")
    workings = _of_frame_by_formulas(one, frame, *one.signs[branch])[1]
    return NamedBranch(branch, joints, workings, tuple(free), "; ".join(singularities))


def _wrist(one: System, frame: Transform) -> tuple[float, float, float]:
    """Return the wrist's centre: the hand's origin less d6 along the approach axis."""
    return position_of(compose(frame, translation(0.0, 0.0, -one.sizes[-1])))


def _refusal(one: System, frame: Transform) -> OutOfReach:
    x, y, z = _wrist(one, frame)
    quantity, value, bound = _reach_broken(one, x, y, z)
    near_x, near_y, near_z = _nearest_wrist(one, x, y, z)
    moved = compose(translation(near_x - x, near_y - y, near_z - z), frame)
    return one.out_of_reach(quantity, value, bound, one.goal_of(moved))


def _fore(one: System) -> float:
    """Return the distance from the elbow to the wrist's centre, across the elbow's offset."""
    return math.hypot(one.sizes[4], one.sizes[5])


def _reach_broken(one: System, x: float, y: float, z: float) -> tuple[str, float, float]:
    """Return what a wrist's centre out of reach breaks: the quantity, its value, its bound."""
    height, offset, lateral, upper, *_ = one.sizes
    radius, lateral, fore = math.hypot(x, y), abs(lateral), _fore(one)
    if radius < lateral:
        return "the wrist's distance from the base axis", radius, lateral
    out = math.sqrt(radius * radius - lateral * lateral)
    up = z - height
    distance = min(
        (math.hypot(side - offset, up) for side in (out, -out)),
        key=lambda value: abs(value - (broken_bound(value, upper, fore) or value)),
    )
    bound = broken_bound(distance, upper, fore)
    return "the wrist's distance from the shoulder", distance, distance if bound is None else bound


def _nearest_wrist(one: System, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Return a wrist's centre within reach near to this one, in the same direction of the base."""
    height, _, lateral, *_ = one.sizes
    radius = math.hypot(x, y)
    out = math.sqrt(max(radius * radius - lateral * lateral, 0.0))
    up = z - height
    near_out, near_up = min(
        _candidates(one, out, up), key=lambda point: math.hypot(point[0] - out, point[1] - up)
    )
    wide = math.hypot(near_out, lateral)
    along = (x / radius, y / radius) if radius > 0.0 else (1.0, 0.0)
    return along[0] * wide, along[1] * wide, near_up + height


def _candidates(one: System, out: float, up: float) -> Iterator[tuple[float, float]]:
    """Yield points (outwards, upwards of the shoulder's height) that front or back reach."""
    _, shoulder, _, upper, *_ = one.sizes
    fore = _fore(one)
    longest = upper + fore
    for side in (1.0, -1.0):
        offset = side * shoulder
        near_out, near_up = brought_within(out - offset, up, upper, fore)
        if near_out + offset >= 0.0:
            yield near_out + offset, near_up
        if longest + offset >= 0.0:
            yield longest + offset, 0.0


def _singularities(one: System, joints: Values) -> list[NamedSingularity]:
    (_, a1, d2, a2, a3, d4, _), (_, second, third, _, fifth, _) = one.sizes, joints
    both = second + third
    out = a1 + a2 * math.cos(second)
    out += a3 * math.cos(both) + d4 * math.sin(both)
    return [
        *elbow_singularities(third - math.atan2(d4, a3), a2, math.hypot(a3, d4)),
        NamedSingularity(WRIST_STRAIGHT, to_half_turn(fifth), None),
        NamedSingularity(BASE_EDGE if d2 else BASE_FREE, None, abs(out)),
    ]


PUMA = System(
    name="puma",
    coordinates=("x_mm", "y_mm", "z_mm", "phi_rad", "theta_rad", "psi_rad"),
    signs=MappingProxyType(
        {
            f"base {base}, elbow {elbow}, wrist {wrist}": (side, bend, flip)
            for (base, side), (elbow, bend), (wrist, flip) in product(
                (("front", 1.0), ("back", -1.0)),
                (("up", 1.0), ("down", -1.0)),
                (("plain", 1.0), ("flipped", -1.0)),
            )
        }
    ),
    length_names=("d1", "a1", "d2", "a2", "a3", "d4", "d6"),
    sizes=(0.0, 0.0, 149.09, 431.8, 0.0, 433.07, 56.25),
    ranges=tuple((math.radians(low), math.radians(high)) for low, high in RANGES_DEG),
    table=_table,
    forward=_forward,
    formulas=_formulas,
    postures=_postures,
    coordinates_of=_coordinates_of,
    of_frame=_of_frame,
    singularities=_singularities,
)
"""A Puma of any lengths; by default those of the Puma 560 with its elbow offset neglected."""
