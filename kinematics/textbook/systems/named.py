"""The named systems of the textbook: figure, link table, forward and inverse kinematics.

Lengths in mm, angles in rad. A system is a row: its lengths and joint ranges, and its closed forms
as functions of it, written with the functions of `kinematics.frames.numbers` so that they run on
numbers of any kind. `notes.toml` has what the notes say of each system.
"""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, lru_cache
from importlib import resources
from typing import Any

from kinematics.chains.chain import Chain, JointViolation
from kinematics.chains.links import Convention
from kinematics.errors import KinematicsError, OutOfReach
from kinematics.five_axis import FiveAxisArm
from kinematics.frames.numbers import goal_numbers, numbers
from kinematics.frames.orientations import solve_rpy
from kinematics.frames.rotations import IDENTITY, columns, multiply, rotate
from kinematics.frames.transforms import Transform, check_transform, position_of, rotation_of
from kinematics.frames.vectors import ZERO, Vector, add, angle_between, distance
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

WIDTH = 79
"""Columns of a figure in text."""

ON_AXIS = "the tip is on the base axis: the base is free"

Values = tuple[float, ...]
"""Joint values, or a goal's coordinates: mm and rad."""

Span = tuple[float, float]
"""Lowest and highest value of a joint, in rad or mm."""

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


Solved = tuple[Values, tuple[Quantity, ...]]
"""Joint values, and the quantities on the way to them."""


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
    violations: tuple[JointViolation, ...] = ()

    @property
    def within_limits(self) -> bool:
        """Whether the arm can take this posture."""
        return not self.violations


@dataclass(frozen=True, slots=True)
class Miss:
    """How far a posture leaves the hand from the frame that was asked: mm and rad."""

    mm: float
    rad: float


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


def no_singularities(_one: System, _joints: Values) -> list[NamedSingularity]:
    """Return no singularity: that of slides alone."""
    return []


def by_formulas(one: System, goal: Values, _seed: Values) -> Sequence[NamedBranch]:
    """Return every branch by its formulas, for a goal that every branch meets."""
    return [one.solution(goal, branch) for branch in one.signs]


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

    forward: Callable[[System, Values], Transform] = field(compare=False, repr=False)
    """The hand's frame by the closed form."""

    formulas: Callable[..., Solved] = field(compare=False, repr=False)
    """One branch by the formulas alone, nothing checked: of the system, a goal and its signs."""

    sizes: tuple[float, ...] = ()
    """The constant lengths in mm, in the order of `length_names`."""

    length_names: tuple[str, ...] = field(default=(), compare=False)
    """The lengths as figure and derivation call them."""

    ranges: tuple[Span, ...] = ()
    """The range of each joint; where none are given, every joint is endless."""

    postures: Callable[[System, Values, Values], Sequence[NamedBranch]] = field(
        default=by_formulas, compare=False, repr=False
    )
    """The branches of a checked goal near a seed, limits and turns aside; raises `OutOfReach`."""

    coordinates_of: Callable[[System, Transform], Values] = field(
        default=tip_of, compare=False, repr=False
    )
    """The system's own coordinates of a hand's frame."""

    of_frame: Callable[[System, Transform, Values], Sequence[NamedBranch]] | None = field(
        default=None, compare=False, repr=False
    )
    """The branches of a whole frame, where they are not those of its coordinates."""

    singularities: Callable[[System, Values], Sequence[NamedSingularity]] = field(
        default=no_singularities, compare=False, repr=False
    )
    """Every singularity in a fixed order, joint limits not looked at."""

    orientation: Callable[..., Vector] | None = field(default=None, compare=False, repr=False)
    """phi, theta, psi of RPY = Rot(z, phi) Rot(y, theta) Rot(x, psi) (section 8), of the joints."""

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
        """Return the hand's frame in the base's, by the closed form.

        Raises `KinematicsError` for the wrong number of joint values and `BadNumber` for one
        that is not finite.
        """
        return self.forward(self, self.chain().directions(joints))

    def by_trigonometry(self, *joints: float) -> Vector:
        """Return the tip (x, y, z) in mm from its coordinates written down (section 5)."""
        return position_of(self.forward(self, self.chain().directions(joints)))

    def by_matrices(self, *joints: float) -> Transform:
        """Return the hand's frame as the product of the A matrices (section 7)."""
        return self.chain().fk(joints)

    def by_vectors(self, *joints: float) -> Vector:
        """Return the tip as the sum of the link vectors, each turned into the base frame."""
        chain = self.chain()
        tip, turned = ZERO, IDENTITY
        for step in (chain.base, *chain.matrices(joints), chain.tool):
            tip = add(tip, rotate(turned, position_of(step)))
            turned = multiply(turned, rotation_of(step))
        return tip

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

        Each angle is of the turn nearest to the seed (zero by default) that the limits allow.
        Raises `OutOfReach` where no posture at all meets the goal, and `KinematicsError` or
        `BadNumber` for a goal that is none.
        """
        near = self._near(seed)
        return self.finished(self.postures(self, self._checked(goal), near), near)

    def ik_frame(
        self, frame: Transform, seed: Sequence[float] | None = None
    ) -> tuple[tuple[NamedBranch, Miss], ...]:
        """Return every branch for a whole frame, each with what it leaves of the frame unmet.

        A system of fewer than six joints holds only its own coordinates of a frame. Raises
        `OutOfReach`, and as `check_transform` does.
        """
        checked = check_transform(frame)
        found = (
            self.ik(self.goal_of(checked), seed)
            if self.of_frame is None
            else self.of_frame(self, checked, self._near(seed))
        )
        return tuple((branch, self._miss(branch.joints, checked)) for branch in found)

    def _miss(self, joints: Sequence[float], frame: Transform) -> Miss:
        """Return how far a posture leaves the hand from a frame: mm, and rad of the worst axis."""
        reached = self.fk(joints)
        pairs = zip(columns(rotation_of(reached)), columns(rotation_of(frame)), strict=True)
        return Miss(
            distance(position_of(reached), position_of(frame)),
            max(angle_between(one, other) for one, other in pairs),
        )

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

    def finished(self, found: Sequence[NamedBranch], near: Values) -> tuple[NamedBranch, ...]:
        """Return branches with each angle on the turn to take, and the limits they break."""
        chain = self.chain()
        return tuple(_held(branch, chain, near) for branch in found)

    def out_of_reach(
        self, quantity: str, value: float, bound: float, nearest: Values
    ) -> OutOfReach:
        """Return the error for a goal that no posture meets, with the nearest one that is met."""
        return OutOfReach(self.name, quantity, value, bound, self.coordinates, nearest)

    def _near(self, seed: Sequence[float] | None) -> Values:
        """Return the seed within the joint limits, where a free joint can take it."""
        chain = self.chain()
        return chain.clamp(chain.zero if seed is None else seed)

    def _checked(self, goal: Sequence[float]) -> Values:
        return goal_numbers(f"a goal of {self.name}", goal, self.coordinates)


@lru_cache(maxsize=64)
def _chain(one: System) -> Chain:
    return replace(one.table(*one.sizes).within(one.ranges or None), name=one.name)


def _held(branch: NamedBranch, chain: Chain, near: Sequence[float]) -> NamedBranch:
    """Return the branch with each angle on the turn to take, and the limits it breaks."""
    joints = chain.turned(branch.joints, near)
    return replace(branch, joints=joints, violations=chain.violations(joints))
