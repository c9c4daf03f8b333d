"""Serial chains of links: the manipulator transform of any number of joints, frames and limits.

Source: McKerrow, chapter 4, section 7 (the product of the A matrices) and section 8. Lengths in
mm, angles in rad; a joint's value is in rad where it is revolute and in mm where it is prismatic.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from kinematics.chains.links import Convention, DHLink, JointKind
from kinematics.errors import KinematicsError, require
from kinematics.frames.numbers import QUARTER_TOLERANCE_RAD, as_list, is_own_kind, numbers
from kinematics.frames.transforms import (
    IN_PLACE,
    Transform,
    check_transform,
    compose,
    position_of,
    translation,
    z_axis_of,
)
from kinematics.frames.vectors import Vector, norm
from kinematics.limits import LIMIT_TOLERANCE_RAD, LimitViolation, few_turns, turn_into
from kinematics.text import aligned, counted

# How far beyond a limit a prismatic joint may lie and still be taken for at the limit.
LIMIT_TOLERANCE_MM = 1e-6


@dataclass(frozen=True, slots=True)
class Chain:
    """Links in order from the base, in one convention, with what stands before and after them.

    `base` is frame 0 in the world and `tool` the tool's frame in the last link's, both constant.
    Joints are named `joint_names`, by default joint_1, joint_2 and so on. Raises
    `KinematicsError` for a chain without links, or names that do not fit the links, and as
    `check_transform` does for a base or a tool that is none.
    """

    links: tuple[DHLink, ...]
    convention: Convention = Convention.STANDARD
    base: Transform = IN_PLACE
    tool: Transform = IN_PLACE
    name: str = ""
    joint_names: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        links = as_list(self.links)
        if not links:
            raise KinematicsError(f"a chain needs at least one link, not {self.links!r}")
        for link in links:
            require("a link", link, DHLink, "DHLink(a_mm=200.0)")
        object.__setattr__(self, "links", links)
        require("convention", self.convention, Convention, "Convention.STANDARD")
        for frame in ("base", "tool"):
            if getattr(self, frame) is not IN_PLACE:
                object.__setattr__(self, frame, check_transform(getattr(self, frame)))
        names = tuple(self.joint_names) or tuple(
            f"joint_{number}" for number in range(1, len(self.links) + 1)
        )
        if len(names) != len(self.links) or len(set(names)) != len(names):
            raise KinematicsError(
                f"{counted(len(self.links), 'joint name is', 'different joint names are')} needed, "
                f"not {', '.join(names)}"
            )
        object.__setattr__(self, "joint_names", names)

    def __len__(self) -> int:
        return len(self.links)

    @property
    def kinds(self) -> tuple[JointKind, ...]:
        """What each joint does."""
        return tuple(link.kind for link in self.links)

    @property
    def limits(self) -> tuple[tuple[float, float], ...]:
        """Lowest and highest value of each joint, infinite where it does not end; rad or mm."""
        return tuple((link.low, link.high) for link in self.links)

    @property
    def is_plain(self) -> bool:
        """Whether all parameters are plain numbers, and none of another kind, such as symbols."""
        return not any(is_own_kind(one) for link in self.links for one in link.parameters(0.0))

    @property
    def zero(self) -> tuple[float, ...]:
        """The zero position: every joint's value is zero, within its limits or not."""
        return (0.0,) * len(self.links)

    @property
    def longest_reach_mm(self) -> float:
        """A distance from the first joint's frame that the tool's origin never exceeds.

        The sum of all lengths and distances, infinite with a prismatic joint without limits; the
        reach that a chain has is often less.
        """
        total = norm(position_of(self.tool))
        for link in self.links:
            total += abs(link.a_mm)
            if link.kind is JointKind.REVOLUTE:
                total += abs(link.d_mm)
            else:
                still = link.d_mm + link.offset
                total += max(abs(still + link.low), abs(still + link.high))
        return total

    @property
    def reach_sphere(self) -> tuple[Vector, float]:
        """A centre in the world and a radius in mm that the tool's origin never leaves.

        Where the first joint turns, the end of its own distance stays where it is, and the
        sphere is about that point: the shoulder of most arms.
        """
        first = self.links[0]
        if first.kind is JointKind.PRISMATIC:
            return position_of(self.base), self.longest_reach_mm
        length = first.a_mm if self.convention is Convention.CRAIG else 0.0
        shoulder = compose(self.base, first.matrix(0.0, self.convention))
        if self.convention is Convention.STANDARD:
            shoulder = compose(self.base, translation(0.0, 0.0, first.d_mm))
        return position_of(shoulder), self.longest_reach_mm - abs(first.d_mm) - abs(length)

    @property
    def constants(self) -> tuple[Transform, ...]:
        """The constant frames before, between and after the joints, each in the one before it.

        The tool's frame is their product with each joint's turn about z, or move along it, between
        two of them.
        """
        rows = self.matrices(self.zero)
        if self.convention is Convention.CRAIG:
            return (compose(self.base, rows[0]), *rows[1:], self.tool)
        return (self.base, *rows[:-1], compose(rows[-1], self.tool))

    def matrices(self, values: Sequence[float]) -> tuple[Transform, ...]:
        """Return the A matrix of every link: each frame in the one before it."""
        return tuple(
            link.matrix(value, self.convention)
            for link, value in zip(self.links, self.directions(values), strict=True)
        )

    def frames(self, values: Sequence[float]) -> tuple[Transform, ...]:
        """Return frames 0 to n in the world: the base's, then every link's, without the tool."""
        found = [self.base]
        for matrix in self.matrices(values):
            found.append(compose(found[-1], matrix))
        return tuple(found)

    def fk(self, values: Sequence[float]) -> Transform:
        """Return the tool's frame in the world, the manipulator transform (section 7).

        Works on any kind of number. Raises `KinematicsError` for the wrong number of values and
        `BadNumber` for one that is not finite. `evaluation` is faster on floats.
        """
        return compose(self.base, *self.matrices(values), self.tool)

    def axes(self, values: Sequence[float]) -> tuple[tuple[Vector, Vector], ...]:
        """Return a point on each joint's axis and its direction, in the world."""
        frames = self.frames(values)
        standard = self.convention is Convention.STANDARD
        return tuple(
            (position_of(frame), z_axis_of(frame))
            for frame in (frames[:-1] if standard else frames[1:])
        )

    def violations(self, values: Sequence[float]) -> tuple[LimitViolation, ...]:
        """Return the limits that a posture breaks."""
        broken = []
        checked = self.checked(values)
        for name, link, value in zip(self.joint_names, self.links, checked, strict=True):
            bound = min(max(value, link.low), link.high)
            revolute = link.kind is JointKind.REVOLUTE
            tolerance = LIMIT_TOLERANCE_RAD if revolute else LIMIT_TOLERANCE_MM
            if abs(value - bound) > tolerance:
                broken.append(LimitViolation(name, value, bound, link.kind.unit))
        return tuple(broken)

    def clamp(self, values: Sequence[float]) -> tuple[float, ...]:
        """Return the posture within the limits that is nearest, joint by joint."""
        return tuple(
            min(max(value, link.low), link.high)
            for link, value in zip(self.links, self.checked(values), strict=True)
        )

    def turned(self, values: Sequence[float], near: Sequence[float]) -> tuple[float, ...]:
        """Return each turning joint on the turn, within its range, nearest to another posture.

        See `turn_into`; sliding joints stay as they are.
        """
        return tuple(
            turn_into(value, link.low, link.high, seed)
            if link.kind is JointKind.REVOLUTE
            else value
            for link, value, seed in zip(self.links, values, near, strict=True)
        )

    def checked(self, values: Sequence[float]) -> tuple[float, ...]:
        """Return one number a joint; raises as `numbers` does."""
        return numbers("a posture of this chain", values, self.joint_names)

    def directions(self, values: Sequence[float]) -> tuple[float, ...]:
        """Return what `checked` does, an angle of many turns as the same direction of none.

        Formulas add joint angles, and the sum of two angles of 1e8 turns is off by 1e-7 rad.
        """
        return tuple(
            few_turns(value) if link.kind is JointKind.REVOLUTE and type(value) is float else value
            for link, value in zip(self.links, self.checked(values), strict=True)
        )

    def within(self, limits: Iterable[tuple[float, float]] | None = None) -> Chain:
        """Return this chain with other limits of its joints; with none, every joint is endless.

        Raises `KinematicsError` for another count of limits, or for limits that are no pairs.
        """
        bounds = ((-math.inf, math.inf),) * len(self) if limits is None else as_list(limits) or ()
        if len(bounds) != len(self) or any(len(as_list(pair) or ()) != 2 for pair in bounds):
            raise KinematicsError(
                f"the limits of this chain are {counted(len(self), 'pair')}, lowest and "
                "highest value of each "
                f"joint, not {limits!r}"
            )
        links = tuple(
            replace(link, low=low, high=high)
            for link, (low, high) in zip(self.links, bounds, strict=True)
        )
        return replace(self, links=links)


# Chains as tables of plain rows, in mm and degrees, as model files have them, and as text.

Row = dict[str, str | float]

_OWN = ("offset", "low", "high")


def rows_of(chain: Chain) -> tuple[Row, ...]:
    """Return the rows of [[links]] in a model file that describe this chain."""
    return tuple(
        _row(name, link) for name, link in zip(chain.joint_names, chain.links, strict=True)
    )


def table_text(chain: Chain) -> str:
    """Return the link table as text in mm and degrees, `*` at what the joint varies.

    The heading names the convention, since the same numbers mean another arm in the other one.
    """
    cells = [("joint", "theta", "d", "a", "alpha")]
    for name, link in zip(chain.joint_names, chain.links, strict=True):
        theta, distance, length, twist = link.parameters(0.0)
        revolute = link.kind is JointKind.REVOLUTE
        cells.append(
            (
                name,
                _plain(_degrees(theta)) + ("*" if revolute else ""),
                _plain(distance) + ("" if revolute else "*"),
                _plain(length),
                _plain(_degrees(twist)),
            )
        )
    title = f"{chain.name}: " if chain.name else ""
    craig = chain.convention is Convention.CRAIG
    before = "; a and alpha of the link before" if craig else ""
    said = f"{title}{chain.convention.value} convention, mm and degrees, * varies{before}"
    return "\n".join([said, *aligned(cells, left=1)])


def _row(name: str, link: DHLink) -> Row:
    revolute = link.kind is JointKind.REVOLUTE
    row: Row = {
        "joint": name,
        "kind": link.kind.value,
        "theta_deg": _degrees(link.theta_rad),
        "d_mm": link.d_mm,
        "a_mm": link.a_mm,
        "alpha_deg": _degrees(link.alpha_rad),
    }
    for key in _OWN:
        value = getattr(link, key)
        if math.isfinite(value) and not (key == "offset" and value == 0.0):
            row[f"{key}_{'deg' if revolute else 'mm'}"] = _degrees(value) if revolute else value
    return row


def _degrees(angle_rad: float) -> float:
    """Return degrees, whole ones where the radians are a whole number of them but for rounding."""
    degrees = math.degrees(angle_rad)
    whole = round(degrees)
    return (
        float(whole) if abs(math.radians(whole) - angle_rad) <= QUARTER_TOLERANCE_RAD else degrees
    )


def _plain(value: float) -> str:
    """Format without the minus sign of a rounded zero."""
    return f"{round(value, 4) + 0.0:g}"
