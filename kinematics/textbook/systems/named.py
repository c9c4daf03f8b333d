"""The named systems of the textbook: figure, link table, forward and inverse kinematics.

Lengths in mm, angles in rad. A system is a row: its link table, its lengths and joint ranges, the
formulas of one branch, written with the functions of `kinematics.frames.numbers` so that they run
on numbers of any kind, and its singularities. The rest follows for every system in the same way:
forward kinematics is the product of the table's A matrices, and of the branches those meet a goal
whose frame has it. `notes.toml` has what the notes say of each system.
"""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, lru_cache
from importlib import resources
from itertools import product
from typing import Any

from kinematics.chains.chain import Chain
from kinematics.chains.links import Convention, JointKind
from kinematics.errors import KinematicsError, OutOfReach
from kinematics.five_axis import FiveAxisArm
from kinematics.frames.numbers import goal_numbers, numbers
from kinematics.frames.orientations import RPY, solve_rpy, turn_between
from kinematics.frames.transforms import Transform, check_transform, position_of, rotation_of
from kinematics.geometry import AXIS_MM
from kinematics.limits import LimitViolation, wrap
from kinematics.text import filled

# The texts of the lecture notes, from `notes.toml`: what they say of a system, and their rules.


@dataclass(frozen=True, slots=True)
class NamedStep:
    """One step of a derivation: what is done, the formula in the notes' notation, and why."""

    title: str
    formula: str
    why: str = ""


@dataclass(frozen=True, slots=True)
class SystemNotes:
    """What the notes say of a system: its figure, and how it is solved, step by step.

    `angles` says how its joint angles count, where other arms of its build count them otherwise.
    """

    title: str
    source: str
    drawing: str
    derivation: tuple[NamedStep, ...]
    angles: str = ""


@cache
def notes_of(name: str) -> SystemNotes:
    """Return what the notes say of a system."""
    entry = _texts()[name]
    return SystemNotes(**entry | {"derivation": tuple(_steps(entry["derivation"]))})


@cache
def _texts() -> dict[str, dict[str, Any]]:
    return tomllib.loads(
        resources.files("kinematics.textbook").joinpath("notes.toml").read_text("utf-8")
    )


def assignment_rules(convention: Convention) -> tuple[str, ...]:
    """Return what each of the thirteen steps does, for frame or link {k}.

    Craig's six rules are in the second list.
    """
    return tuple(_texts()["thirteen-steps"][convention.value])


def _steps(text: str) -> Iterator[NamedStep]:
    """Yield the steps of a derivation as `notes.toml` has them."""
    for step in re.split(r"\n(?=\S)", text.strip()):
        first, *others = step.split("\n")
        title, _, formula = first.partition(": ")
        more = [line.strip() for line in others if not line.startswith("    ")]
        why = [line.strip() for line in others if line.startswith("    ")]
        yield NamedStep(title, "  ".join((formula, *more)), " ".join(why))


QUARTER_TURN = math.pi / 2.0

# Columns of a figure in text.
WIDTH = 79

ON_AXIS = "the tip is on the base axis: the base is free"

# In mm or rad: postures this near to each other are one, and a goal this near is met. Rounding
# next to a singularity takes less.
MET = 1e-6

# How far a joint is turned to see whether its angle makes a difference.
PROBE_RAD = 0.7

WHOLE_TURN = ("phi_rad", "theta_rad", "psi_rad")

# Joint values, or a goal's coordinates: mm and rad.
Values = tuple[float, ...]

# Lowest and highest value of a joint, in rad or mm.
Span = tuple[float, float]

ENDLESS: Span = (-math.inf, math.inf)


def frame_coordinates(frame: Transform) -> Values:
    """Return x, y, z in mm and phi, theta, psi in rad of a frame (sections 8 and 10)."""
    angles = solve_rpy(rotation_of(frame)).first
    return *position_of(frame), angles.phi_rad, angles.theta_rad, angles.psi_rad


@dataclass(frozen=True, slots=True)
class Quantity:
    """A number on the way to a branch, a side or an angle; `unit` is mm, rad or empty."""

    symbol: str
    value: float
    unit: str


# Joint values, and the quantities on the way to them.
Solved = tuple[Values, tuple[Quantity, ...]]


@dataclass(frozen=True, slots=True)
class NamedBranch:
    """One posture that meets a goal, named in words ("base front, elbow up").

    `joints` in rad (revolute) and mm (prismatic). `free` names the joints that any value would
    serve, whose value here is the seed's; `degenerate` says in words what the posture loses, and
    is empty where it loses nothing. `violations` are the joint limits that it would break.
    """

    name: str
    joints: Values
    workings: tuple[Quantity, ...] = ()
    free: tuple[str, ...] = ()
    degenerate: str = ""
    violations: tuple[LimitViolation, ...] = ()

    @property
    def within_limits(self) -> bool:
        """Whether the arm can take this posture."""
        return not self.violations


@dataclass(frozen=True, slots=True)
class NamedSingularity:
    """One singularity: what is lost there, and how far the posture is from it.

    `distance_rad` is the joint move that leads there, None where it takes a slide;
    `distance_mm` is how far the point in question (the tip, the wrist) has to go, None where it
    does not concern a point.
    """

    reason: str
    distance_rad: float | None
    distance_mm: float | None

    @property
    def is_here(self) -> bool:
        """Whether the posture is this singular one, but for rounding."""
        away = self.distance_mm if self.distance_rad is None else self.distance_rad
        return away is not None and away < MET


def no_singularities(_one: System, _joints: Values) -> list[NamedSingularity]:
    """Return no singularity: that of slides alone."""
    return []


def tip_of(_one: System, frame: Transform) -> Values:
    """Return the coordinates of a system that only positions: x, y and z."""
    return position_of(frame)


@dataclass(frozen=True, slots=True)
class System:
    """A named system: `fk` of joint values, `ik` of a goal in the system's own `coordinates`.

    `coordinates` name the goal's numbers with their units, as many as the system can hold, and
    `signs` the branches, each with the signs that pick it in the formulas. `sized` makes another
    one of the same build. Two systems of one name are equal where lengths and ranges are.
    """

    name: str
    coordinates: tuple[str, ...] = field(compare=False)
    signs: Mapping[str, tuple[float, ...]] = field(compare=False)

    table: Callable[..., Chain] = field(compare=False, repr=False)
    """The link table with joint names, of the lengths in order."""

    formulas: Callable[..., Solved] = field(compare=False, repr=False)
    """One branch by the formulas alone, nothing checked: of the system, a goal and its signs."""

    sizes: tuple[float, ...] = ()
    """The constant lengths in mm, in the order of `length_names`."""

    length_names: tuple[str, ...] = field(default=(), compare=False)
    """The lengths as figure and derivation call them."""

    ranges: tuple[Span, ...] = ()
    """The range of each joint; where none are given, every joint is endless."""

    coordinates_of: Callable[[System, Transform], Values] = field(
        default=tip_of, compare=False, repr=False
    )
    """The system's own coordinates of a hand's frame."""

    singularities: Callable[[System, Values], Sequence[NamedSingularity]] = field(
        default=no_singularities, compare=False, repr=False
    )
    """Every singularity in a fixed order, joint limits not looked at."""

    space: Callable[[System], str] | None = field(default=None, compare=False, repr=False)
    """Where the tip can be put, joint ranges included: the shape and its measures (figures c)."""

    of_notes: str = field(default="", compare=False, repr=False)
    """The system whose notes are this one's too; by default it has its own."""

    called: str = field(default="", compare=False)
    """A title of its own, in the place of the notes'."""

    arm: FiveAxisArm | None = None
    """The arm with its limits, of a system of the Mini-mover's build."""

    senses: tuple[tuple[float, float], ...] = field(default=(), compare=False)
    """For such a system, each joint's sign and offset against the arm's relative angles."""

    @property
    def notes(self) -> SystemNotes:
        """What the notes say of it."""
        return notes_of(self.of_notes or self.name)

    @property
    def title(self) -> str:
        """What it is, in a line."""
        return self.called or self.notes.title

    def sized(self, *sizes: float, ranges: Sequence[Span] | None = None, **named: float) -> System:
        """Return a system of this build with other lengths (in order, or by name) and ranges.

        The ranges of an arm of the Mini-mover's build stay its limits. Raises `KinematicsError` for
        lengths that the system has not, and as `Chain.within` does.
        """
        unknown = named.keys() - set(self.length_names)
        if unknown or len(sizes) not in (0, len(self.sizes)):
            raise KinematicsError(
                f"the lengths of {self.name} are {', '.join(self.length_names) or 'none'}"
            )
        pairs = zip(self.length_names, sizes or self.sizes, strict=True)
        made = tuple(named.get(name, value) for name, value in pairs)
        if self.arm is not None:
            height, upper, fore, hand = made
            return replace(
                self, sizes=made, arm=FiveAxisArm(height, upper, fore, hand, self.arm.limits)
            )
        limits = self.ranges if ranges is None else self.chain().within(ranges or None).limits
        one = replace(self, sizes=made, ranges=limits)
        one.chain()  # refuses lengths that are none
        return one

    def lengths(self) -> dict[str, float]:
        """Return the constant lengths by the names that figure and derivation use, in mm."""
        return dict(zip(self.length_names, self.sizes, strict=True))

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The joints' names, from the base."""
        return self.chain().joint_names

    def chain(self) -> Chain:
        """Return the system's link table as a chain, joint names and limits included."""
        return _chain(self)

    def fk(self, joints: Sequence[float]) -> Transform:
        """Return the hand's frame in the base's, the product of the A matrices (section 7).

        Works on numbers of any kind. Raises `KinematicsError` for the wrong number of joint values
        and `BadNumber` for one that is not finite.
        """
        return self.chain().fk(joints)

    def goal_of(self, frame: Transform) -> Values:
        """Return the system's own coordinates of a hand's frame. Raises `NotARotation`."""
        return self.coordinates_of(self, check_transform(frame))

    def solution(self, goal: Sequence[float], branch: str) -> NamedBranch:
        """Return the branch of this name by the formulas alone, on numbers of any kind.

        Nothing is checked: neither the reach nor the joint limits, and where a branch is
        degenerate the formulas say what they say. `ik` is the call that checks. Raises
        `KinematicsError` for a branch that the system has not, or a goal of another count.
        """
        if not isinstance(branch, str) or branch not in self.signs:
            raise KinematicsError(
                f"{self.name} has no branch {branch!r}; it has {', '.join(self.signs)}"
            )
        given = numbers(f"a goal of {self.name}", goal, self.coordinates)
        return NamedBranch(branch, *self.formulas(self, given, *self.signs[branch]))

    def ik(
        self, goal: Sequence[float], seed: Sequence[float] | None = None
    ) -> tuple[NamedBranch, ...]:
        """Return every branch that meets a goal, those beyond the joint limits included.

        Each angle is of the turn nearest to the seed (zero by default) that the limits allow, and
        of a joint that any value would serve, the seed's. Branches that are one posture have the
        name of the first. Raises `OutOfReach` where no posture at all meets the goal, and
        `KinematicsError` or `BadNumber` for a goal that is none.
        """
        chain = self.chain()
        near = chain.clamp(chain.zero if seed is None else seed)
        asked = goal_numbers(f"a goal of {self.name}", goal, self.coordinates)
        if self.coordinates[:2] == ("x_mm", "y_mm") and math.hypot(*asked[:2]) <= AXIS_MM:
            asked = (0.0, 0.0, *asked[2:])  # rounding has no direction
        tried = [self.solution(asked, branch) for branch in self.signs]
        found: list[NamedBranch] = []
        for branch in tried:
            if self.meets(branch.joints, asked):
                settled = self._settled(branch, asked, near)
                if not any(self._same(settled.joints, one.joints) for one in found):
                    found.append(settled)
        if not found:
            raise self._out_of_reach(asked, tried)
        return tuple(found)

    def meets(self, joints: Values, goal: Values) -> bool:
        """Whether a posture meets a goal, limits aside."""
        return max(self._missed(joints, goal)) <= MET

    def holds(self, goal: Sequence[float]) -> bool:
        """Whether some branch within the joint limits meets a goal: its workspace."""
        try:
            return any(branch.within_limits for branch in self.ik(goal))
        except OutOfReach:
            return False

    def figure(self) -> str:
        """Return the system's figure in text, with its own lengths in mm."""
        drawing = self.notes.drawing.rstrip()
        legend = ", ".join(f"{name} = {value:g} mm" for name, value in self.lengths().items())
        return "\n".join((drawing, "", *filled(legend, WIDTH))) if legend else drawing

    def _missed(self, joints: Values, goal: Values) -> tuple[float, float]:
        """Return by how many mm and rad a posture misses a goal."""
        pairs = zip(self.coordinates, self.goal_of(self.fk(joints)), goal, strict=True)
        off_mm, turns = [], []
        for name, reached, asked in pairs:
            if name.endswith("_mm"):
                off_mm.append(reached - asked)
            else:
                turns.append((reached, asked))
        if len(turns) == len(WHOLE_TURN):  # a degenerate orientation has many such angles
            one, other = (RPY(*angles).rotation() for angles in zip(*turns, strict=True))
            return math.hypot(*off_mm), turn_between(one, other)
        off_rad = [abs(wrap(reached - asked)) for reached, asked in turns]
        return math.hypot(*off_mm), max(off_rad, default=0.0)

    def _settled(self, branch: NamedBranch, goal: Values, near: Values) -> NamedBranch:
        """Return a branch on the turns to take, with what it loses and the limits it breaks."""
        chain, joints, free = self.chain(), branch.joints, list[str]()
        lost = [one.reason for one in self.singularities(self, joints) if one.is_here]
        for index in self._turning() if lost else ():
            freed = self._freed(joints, index, goal, near[index])
            if freed is not None:
                joints = freed
                free.append(chain.joint_names[index])
        joints = chain.turned(joints, near)
        broken = chain.violations(joints)
        return replace(
            branch, joints=joints, free=tuple(free), degenerate="; ".join(lost), violations=broken
        )

    def _freed(self, joints: Values, index: int, goal: Values, value: float) -> Values | None:
        """Return a posture with a joint at a value that serves as any other would, or None.

        Turned by any angle, the joint either changes nothing, or one further joint makes up for it.
        """
        further = [other for other in self._turning() if other > index]
        for other, sign in ((index, 0.0), *product(further, (-1.0, 1.0))):

            def turned(by: float, other: int = other, sign: float = sign) -> Values:
                made = list(joints)
                made[other] += sign * by
                made[index] += by
                return tuple(made)

            if self.meets(turned(PROBE_RAD), goal):
                return turned(value - joints[index])
        return None

    def _turning(self) -> list[int]:
        kinds = enumerate(self.chain().kinds)
        return [index for index, kind in kinds if kind is JointKind.REVOLUTE]

    def _same(self, one: Values, other: Values) -> bool:
        """Whether two postures are one, but for rounding and whole turns."""
        turning = self._turning()
        return all(
            abs(wrap(a - b) if index in turning else a - b) < MET
            for index, (a, b) in enumerate(zip(one, other, strict=True))
        )

    def _out_of_reach(self, goal: Values, tried: Sequence[NamedBranch]) -> OutOfReach:
        """Return the error for a goal that no branch meets.

        Formulas of a goal too far away give a posture that points at it.
        """
        nearest = min((one.joints for one in tried), key=lambda one: self._missed(one, goal)[0])
        away_mm, _ = self._missed(nearest, goal)
        return OutOfReach(self.name, away_mm, self.coordinates, self.goal_of(self.fk(nearest)))


@lru_cache(maxsize=64)
def _chain(one: System) -> Chain:
    return replace(one.table(*one.sizes).within(one.ranges or None), name=one.name)
