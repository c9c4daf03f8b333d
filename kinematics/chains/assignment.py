"""Frame assignment: from an arm's joint axes in its zero position to its link table.

Standard (distal) frames by McKerrow, chapter 4, section 4; frames of the other convention by
Craig, chapter 3, "affixing frames to links". Where the rules leave something free, the result
says what was chosen. Lengths in mm, angles in rad, everything as seen from the world.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

from kinematics.chains.chain import Chain
from kinematics.chains.links import (
    Convention,
    DHLink,
    JointKind,
    assigned_parameters,
    link_parameters,
)
from kinematics.errors import KinematicsError, require
from kinematics.frames.numbers import as_list, numbers
from kinematics.frames.rotations import from_columns
from kinematics.frames.transforms import (
    IN_PLACE,
    Transform,
    check_transform,
    compose,
    homogeneous,
    inverted,
    position_of,
    translation,
)
from kinematics.frames.vectors import (
    X_AXIS,
    Y_AXIS,
    Vector,
    add,
    angle_between,
    any_normal,
    cross,
    distance,
    dot,
    norm,
    reject,
    scale,
    subtract,
    unit,
)

# Two joint axes in space: skew, intersecting, parallel or the same, and their common normal.
#
# Source: McKerrow, chapter 4, section 3 (the common normal of a link).

# Sine of the angle below which two axes count as parallel.
#
# The common normal of axes so nearly parallel is a kilometre away for each tenth of a millimetre
# between them, and says more about rounding than about the arm. Taken as parallel, they put the end
# of a link of a metre some 1e-4 mm elsewhere at most.
SAME_DIRECTION = 1e-7

# Sine of the angle below which only rounding keeps two axes from being parallel.
EXACTLY_PARALLEL = 1e-12

# Axes nearer to each other than this intersect, or are the same.
TOUCHING_MM = 1e-6

# No point of an arm is further away: a double still resolves 1e-8 mm there.
FARTHEST_MM = 1e8


class Relation(Enum):
    """How two axes lie to each other."""

    SKEW = "skew"
    INTERSECTING = "intersecting"
    PARALLEL = "parallel"
    COINCIDENT = "coincident"


@dataclass(frozen=True, slots=True)
class AxisLine:
    """A line in space: any point on it, and its direction, which is made 1 long.

    Raises `ZeroVector` for no direction and `BadNumber` for what is not a finite number.
    """

    point: Vector
    direction: Vector

    def __post_init__(self) -> None:
        for name in ("point", "direction"):
            vector = numbers(f"an axis' {name}", getattr(self, name), "xyz")
            object.__setattr__(self, name, vector)
        object.__setattr__(self, "direction", unit(self.direction))

    def foot(self, point: Vector) -> Vector:
        """Return the point of the line that is nearest to a point."""
        along = dot(subtract(point, self.point), self.direction)
        return add(self.point, scale(along, self.direction))


@dataclass(frozen=True, slots=True)
class AxisPair:
    """Two axes' common normal: its ends on the one and on the other, and how the axes lie.

    The common normal of parallel axes may be anywhere along them; the caller of `relate` chooses.
    `sine` is the sine of the angle between the axes.
    """

    relation: Relation
    near: Vector
    far: Vector
    sine: float


def relate(
    first: AxisLine,
    second: AxisLine,
    level: Vector,
    same_direction: float = SAME_DIRECTION,
    touching_mm: float = TOUCHING_MM,
) -> AxisPair:
    """Return the common normal of two axes; of parallel ones, the one nearest to `level`."""
    across = cross(first.direction, second.direction)
    sine = norm(across)
    if sine <= same_direction:
        near = first.foot(level)
        far = second.foot(near)
        same = distance(near, far) <= touching_mm
        return AxisPair(Relation.COINCIDENT if same else Relation.PARALLEL, near, far, sine)
    between = subtract(second.point, first.point)
    size = dot(across, across)
    along_first = dot(cross(between, second.direction), across) / size
    along_second = dot(cross(between, first.direction), across) / size
    near = add(first.point, scale(along_first, first.direction))
    far = add(second.point, scale(along_second, second.direction))
    meet = distance(near, far) <= touching_mm
    return AxisPair(Relation.INTERSECTING if meet else Relation.SKEW, near, far, sine)


# Dot product of unit vectors above which one leans towards the other.
_LEANS = 1e-9

# Dot product of two unit vectors, as people type them, that are at a right angle.
SQUARE = 1e-6

# Steps of the algorithm that leave a choice (Asokan, lecture 2.7).
BASE_FRAME, Z_AXIS, ORIGIN, X_AXIS_OF_FRAME, LAST_FRAME = 2, 3, 4, 5, 8


@dataclass(frozen=True, slots=True)
class JointAxis:
    """A joint of an arm in its zero position: a point on its axis, and its positive direction.

    A revolute joint turns right-handed about the direction, a prismatic one slides along it;
    its value is zero in this position. `low` and `high` bound the value, in rad or mm.
    """

    point: Vector
    direction: Vector
    kind: JointKind = JointKind.REVOLUTE
    name: str = ""
    low: float = -math.inf
    high: float = math.inf

    @property
    def line(self) -> AxisLine:
        """The axis without its joint."""
        return AxisLine(self.point, self.direction)


@dataclass(frozen=True, slots=True)
class ZeroPosition:
    """An arm with every joint at zero: its joint axes, and the tool's frame, in the world."""

    axes: tuple[JointAxis, ...]
    tool: Transform = IN_PLACE


def zero_position(chain: Chain) -> ZeroPosition:
    """Return a chain's joint axes and tool with every joint at zero."""
    rows = zip(chain.axes(chain.zero), chain.links, chain.joint_names, strict=True)
    axes = tuple(
        JointAxis(point, direction, link.kind, name, link.low, link.high)
        for (point, direction), link, name in rows
    )
    return ZeroPosition(axes, chain.fk(chain.zero))


def tip_frame(
    last: JointAxis, point: Vector, approach: Vector | None = None, normal: Vector | None = None
) -> Transform:
    """Return the frame of a tool at a point: z along its approach, x along its normal.

    Without an approach, z keeps the last joint's direction (McKerrow, section 4). Without a normal,
    x points as four link parameters need it: away from the last axis, or normal to it and to the
    approach. Raises `ZeroVector` for a direction of length zero, and `KinematicsError` for a normal
    that is not at a right angle to the approach.
    """
    axis = last.line
    tip = numbers("the tip's point", point, "xyz")
    z = axis.direction if approach is None else unit(numbers("the approach", approach, "xyz"))
    if normal is not None:
        x = unit(numbers("the normal", normal, "xyz"))
        if abs(dot(x, z)) > SQUARE:
            apart = math.degrees(angle_between(x, z))
            raise KinematicsError(
                f"the tip's normal must be at 90° to its approach, not at {apart:.6g}°"
            )
        return _frame(tip, x, z)
    across, away = cross(axis.direction, z), subtract(tip, axis.foot(tip))
    if norm(across) > SAME_DIRECTION:
        return _frame(tip, across, z)
    if norm(away) > TOUCHING_MM:
        return _frame(tip, away, z)
    return _frame(tip, _world_x(z)[0], z)


@dataclass(frozen=True, slots=True)
class Choice:
    """A choice that the rules leave at one frame, and what was chosen.

    `step` is the step of the algorithm with this choice (`kinematics.textbook.thirteen_steps`).
    """

    frame: int
    step: int
    sentence: str

    def __str__(self) -> str:
        return f"frame {self.frame}: {self.sentence}"


@dataclass(frozen=True, slots=True)
class Assignment:
    """A chain with its frames 0 to n in the zero position, the pairs of neighbouring axes, choices.

    `pairs` hold how axes 1 and 2, 2 and 3, ... lie to each other.
    """

    zero: ZeroPosition
    chain: Chain
    frames: tuple[Transform, ...]
    pairs: tuple[AxisPair, ...]
    choices: tuple[Choice, ...]

    @property
    def relations(self) -> tuple[Relation, ...]:
        """How neighbouring axes lie to each other."""
        return tuple(pair.relation for pair in self.pairs)

    @property
    def points(self) -> tuple[Vector, ...]:
        """The points b1 to bn, where the x axis of each link meets the z axis of its joint.

        The link's distance d leads along z from or to this point, its length a along x.
        """
        standard = self.chain.convention is Convention.STANDARD
        found = []
        for number, link in enumerate(self.chain.links, 1):
            frame = self.frames[number if standard else number - 1]
            x = frame[0][0], frame[1][0], frame[2][0]
            along = -link.a_mm if standard else link.a_mm
            found.append(add(position_of(frame), scale(along, x)))
        return tuple(found)


def assign_frames(
    axes: Sequence[JointAxis],
    tool: Transform = IN_PLACE,
    convention: Convention = Convention.STANDARD,
    name: str = "",
) -> Assignment:
    """Return the chain whose joints have these axes and whose tool has this frame at zero.

    `tool` is the tool's frame in the world, z along its approach. The chain's forward kinematics
    in the zero position is that frame. Raises `KinematicsError` where there are no axes,
    `ZeroVector` for an axis without a direction, and as `check_transform` does for the tool.
    """
    given = as_list(axes)
    if not given:
        raise KinematicsError(f"an arm needs at least one joint axis, not {axes!r}")
    for axis in given:
        require("an axis", axis, JointAxis, "JointAxis((0, 0, 0), (0, 0, 1))")
    require("convention", convention, Convention, "Convention.STANDARD")
    work = _Work(given, check_transform(tool), [], [])
    places = [axis.line.point for axis in given] + [position_of(work.tool)]
    for place in places:
        if max(map(abs, place)) > FARTHEST_MM:
            raise KinematicsError(
                f"the point {place} is no point of an arm: it is more than {FARTHEST_MM:g} mm away"
            )
    if convention is Convention.STANDARD:
        frames, tip = _standard(work)
    else:
        frames, tip = _craig(work)
    names = tuple(axis.name or f"joint_{index}" for index, axis in enumerate(given, 1))
    links = []
    for number, axis in enumerate(given, 1):
        step = compose(inverted(frames[number - 1]), frames[number])
        theta, d, a, alpha = assigned_parameters(number, step, convention)
        links.append(DHLink(theta, d, a, alpha, axis.kind, 0.0, axis.low, axis.high))
    chain = Chain(tuple(links), convention, frames[0], tip, name, names)
    zero = ZeroPosition(given, work.tool)
    return Assignment(zero, chain, tuple(frames), tuple(work.pairs), tuple(work.choices))


@dataclass(frozen=True, slots=True)
class _Work:
    """The given axes and tool, and the pairs and choices found so far."""

    axes: tuple[JointAxis, ...]
    tool: Transform
    pairs: list[AxisPair]
    choices: list[Choice]

    def chose(self, frame: int, step: int, sentence: str) -> None:
        self.choices.append(Choice(frame, step, sentence))

    def say_free_origin(self, frame: int, pair: AxisPair, axis: JointAxis) -> None:
        """Note the choice of the origin of a frame on this axis, if there is one."""
        if pair.relation in (Relation.PARALLEL, Relation.COINCIDENT):
            self.chose(frame, ORIGIN, "its origin may lie anywhere along its axis; it makes d zero")
        if axis.kind is JointKind.PRISMATIC:
            self.chose(
                frame,
                Z_AXIS,
                "a slide has a direction and no place; its axis is taken through the given point",
            )

    def pair(self, index: int, level: Vector) -> AxisPair:
        """Return the common normal of axes `index` and `index` + 1, counted from 1."""
        near, far = self.axes[index - 1], self.axes[index]
        found = relate(near.line, far.line, level)
        self.pairs.append(found)
        if EXACTLY_PARALLEL < found.sine <= SAME_DIRECTION:
            self.chose(
                index,
                ORIGIN,
                f"axes {index} and {index + 1} are nearly parallel ({found.sine:.1g} rad apart), "
                "and taken as parallel",
            )
        return found


def _standard(work: _Work) -> tuple[list[Transform], Transform]:
    """Return frames 0 to n and the tool's frame in the last one."""
    first = work.axes[0]
    origin, (x, why) = first.line.point, _world_x(first.line.direction)
    work.chose(0, BASE_FRAME, "its origin may lie anywhere on axis 1; it is the given point")
    work.chose(0, BASE_FRAME, f"x may point anywhere about axis 1; it points along {why}")
    frames = [_frame(origin, x, first.line.direction)]
    for k in range(1, len(work.axes)):
        pair = work.pair(k, origin)
        x = _x_axis(work, k, pair, x)
        work.say_free_origin(k, pair, work.axes[k])
        origin = pair.far
        frames.append(_frame(origin, x, work.axes[k].line.direction))
    last, tip = _standard_tip(work, frames[-1])
    return [*frames, last], tip


def _standard_tip(work: _Work, before: Transform) -> tuple[Transform, Transform]:
    """Return frame n: the tool's where four parameters lead there, else in line with joint n."""
    number = len(work.axes)
    step = compose(inverted(before), work.tool)
    if link_parameters(step) is not None:
        return work.tool, IN_PLACE
    last = compose(before, translation(0.0, 0.0, position_of(step)[2]))
    work.chose(
        number,
        LAST_FRAME,
        "four parameters do not lead to the tool's frame, so z keeps joint "
        f"{number}'s direction and a constant tool transform does the rest",
    )
    return last, compose(inverted(last), work.tool)


def _craig(work: _Work) -> tuple[list[Transform], Transform]:
    """Return frames 0 to n and the tool's frame in the last one."""
    count = len(work.axes)
    level = work.axes[0].line.point
    x, why = _world_x(work.axes[0].line.direction)
    frames: list[Transform] = []
    for i in range(1, count):
        pair = work.pair(i, level)
        free = pair.relation is Relation.COINCIDENT and i == 1
        x = _x_axis(work, i, pair, x, f"points along {why}" if free else AS_BEFORE)
        work.say_free_origin(i, pair, work.axes[i - 1])
        frames.append(_frame(pair.near, x, work.axes[i - 1].line.direction))
        level = pair.far
    frames.append(_frame(level, x, work.axes[-1].line.direction))
    if count > 1:
        work.chose(
            count, LAST_FRAME, "it is free along and about its axis; theta and d are made zero"
        )
    else:
        work.chose(1, LAST_FRAME, f"x may point anywhere about axis 1; it points along {why}")
    work.chose(0, BASE_FRAME, "it is free along and about axis 1; it is frame 1 at zero")
    frames.insert(0, frames[0])
    return frames, compose(inverted(frames[-1]), work.tool)


def _world_x(z: Vector) -> tuple[Vector, str]:
    """Return an x for the first frame and its name: the world's x, or y where z is in the way."""
    for name, towards in (("x", X_AXIS), ("y", Y_AXIS)):
        across = reject(towards, z)
        if norm(across) > _LEANS:
            return unit(across), f"the world's {name}"
    return any_normal(z), "any normal"


AS_BEFORE = "stays as the frame before has it"


def _x_axis(
    work: _Work, number: int, pair: AxisPair, before: Vector, free: str = AS_BEFORE
) -> Vector:
    """Return x of a frame: along the common normal, or normal to both axes where they meet.

    In both conventions frame `number` lies on the normal of the axes `number` and the next. `free`
    says where x points if the axes are the same.
    """
    if pair.relation is Relation.COINCIDENT:
        work.chose(
            number,
            X_AXIS_OF_FRAME,
            f"axes {number} and {number + 1} are the same, so x may point anywhere about them; "
            f"it {free}",
        )
        return before
    if pair.relation is not Relation.INTERSECTING:
        return unit(subtract(pair.far, pair.near))
    near, far = work.axes[number - 1], work.axes[number]
    normal = unit(cross(near.line.direction, far.line.direction))
    towards, why = _nearer(normal, before)
    work.chose(
        number,
        X_AXIS_OF_FRAME,
        f"axes {number} and {number + 1} intersect, so x may point either way along "
        f"their normal; it points {why}",
    )
    return towards


def _nearer(normal: Vector, before: Vector) -> tuple[Vector, str]:
    """Return the normal or its opposite: as x was before, else upwards, else as it is.

    The first keeps angles at zero in the zero position, the second is how the Alpha II's fourth
    frame is drawn.
    """
    for lean, why in (
        (dot(normal, before), "the way that x before it leans"),
        (normal[2], "up"),
    ):
        if abs(lean) > _LEANS:
            return scale(math.copysign(1.0, lean), normal), why
    return normal, "along the cross product of the axes"


def _frame(origin: Vector, x: Vector, z: Vector) -> Transform:
    """Return a right-handed frame with this z, and x as near to the given one as z lets it."""
    level = unit(reject(x, z))
    return homogeneous(from_columns(level, cross(z, level), z), origin)
