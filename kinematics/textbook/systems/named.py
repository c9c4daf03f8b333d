"""What every named system of the textbook offers: figure, link table, forward, inverse branches.

Lengths in mm, angles in rad. A system is a frozen dataclass of its lengths and joint ranges; its
closed forms are written with the functions of `kinematics.frames.numbers`, so that they run on
numbers of any kind.
"""

from __future__ import annotations

import math
import textwrap
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

from kinematics.chains.chain import Chain, JointViolation
from kinematics.chains.links import JointKind
from kinematics.errors import KinematicsError, OutOfReach, finite
from kinematics.frames.rotations import columns
from kinematics.frames.transforms import Transform, position_of, rotation_of
from kinematics.frames.vectors import angle_between, distance
from kinematics.limits import turn_into

REACH_MM = 1e-9
"""How far beyond its reach rounding may put a goal that touches it."""

QUARTER_TURN = math.pi / 2.0

WIDTH = 79
"""Columns of a figure in text."""

ON_AXIS = "the tip is on the base axis: the base is free"


@dataclass(frozen=True, slots=True)
class NamedStep:
    """One step of a derivation: what is done, the formula in the notes' notation, and why."""

    title: str
    formula: str
    why: str = ""


@dataclass(frozen=True, slots=True)
class Quantity:
    """A number on the way to a branch, a side or an angle; `unit` is mm, rad or empty."""

    symbol: str
    value: float
    unit: str


Solved = tuple[tuple[float, ...], tuple[Quantity, ...]]
"""Joint values, and the quantities on the way to them."""


@dataclass(frozen=True, slots=True)
class NamedBranch:
    """One posture that meets a goal, named in words ("base front, elbow up").

    `joints` in rad (revolute) and mm (prismatic). `free` names the joints that any value would
    serve, whose value here is the seed's; `degenerate` says in words what the posture loses, and
    is empty where it loses nothing. `violations` are the joint limits that it would break.
    """

    name: str
    joints: tuple[float, ...]
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


class System(ABC):
    """A named system: `fk` of joint values, `ik` of a goal in the system's own `coordinates`.

    `coordinates` name the goal's numbers with their units, as many as the system can hold.
    """

    __slots__ = ()

    name: ClassVar[str]
    title: ClassVar[str]
    source: ClassVar[str]
    coordinates: ClassVar[tuple[str, ...]]
    signs: ClassVar[Mapping[str, tuple[float, ...]]]
    """The branches by name, each with the signs that pick it in the formulas."""
    derivation: ClassVar[tuple[NamedStep, ...]]
    drawing: ClassVar[str]

    @abstractmethod
    def chain(self) -> Chain:
        """Return the system's link table as a chain, joint names and limits included."""

    @abstractmethod
    def _fk(self, joints: tuple[float, ...]) -> Transform:
        """Return the hand's frame by the closed form, on numbers of any kind."""

    @abstractmethod
    def _solution(self, goal: tuple[float, ...], *signs: float) -> Solved:
        """Return one branch by the formulas alone, on numbers of any kind, nothing checked."""

    @abstractmethod
    def _ik(self, goal: tuple[float, ...], seed: tuple[float, ...]) -> Sequence[NamedBranch]:
        """Return the branches of a checked goal, limits and turns aside; raise `OutOfReach`."""

    @abstractmethod
    def goal_of(self, frame: Transform) -> tuple[float, ...]:
        """Return the system's own coordinates of a hand's frame."""

    def solution(self, goal: Sequence[float], branch: str) -> NamedBranch:
        """Return the branch of this name by the formulas alone, on numbers of any kind.

        Nothing is checked: neither the reach nor the joint limits, and where a branch is
        degenerate the formulas say what they say. `ik` is the call that checks. Raises
        `KinematicsError` for a branch that the system has not.
        """
        if branch not in self.signs:
            raise KinematicsError(
                f"{self.name} has no branch {branch!r}; it has {', '.join(self.signs)}"
            )
        return NamedBranch(branch, *self._solution(tuple(goal), *self.signs[branch]))

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The joints' names, from the base."""
        return self.chain().joint_names

    def fk(self, joints: Sequence[float]) -> Transform:
        """Return the hand's frame in the base's, by the closed form.

        Raises `KinematicsError` for the wrong number of joint values and `BadNumber` for one
        that is not finite.
        """
        return self._fk(self.chain().checked(joints))

    def ik(
        self, goal: Sequence[float], seed: Sequence[float] | None = None
    ) -> tuple[NamedBranch, ...]:
        """Return every branch that meets a goal, those beyond the joint limits included.

        Each angle is of the turn nearest to the seed (zero by default) that the limits allow.
        Raises `OutOfReach` where no posture at all meets the goal, and `KinematicsError` or
        `BadNumber` for a goal that is none.
        """
        near = self._seed(seed)
        return self._finished(self._ik(self._checked(goal), near), near)

    def ik_frame(
        self, frame: Transform, seed: Sequence[float] | None = None
    ) -> tuple[tuple[NamedBranch, Miss], ...]:
        """Return every branch for a whole frame, each with what it leaves of the frame unmet.

        A system of fewer than six joints holds only its own coordinates of a frame.
        """
        return self._missed(self.ik(self.goal_of(frame), seed), frame)

    def _missed(
        self, branches: Sequence[NamedBranch], frame: Transform
    ) -> tuple[tuple[NamedBranch, Miss], ...]:
        return tuple((branch, self.miss(branch.joints, frame)) for branch in branches)

    def miss(self, joints: Sequence[float], frame: Transform) -> Miss:
        """Return how far a posture leaves the hand from a frame: mm, and rad of the worst axis."""
        reached = self.fk(joints)
        pairs = zip(columns(rotation_of(reached)), columns(rotation_of(frame)), strict=True)
        return Miss(
            distance(position_of(reached), position_of(frame)),
            max(angle_between(one, other) for one, other in pairs),
        )

    def figure(self) -> str:
        """Return the system's figure in text, with its own lengths in mm."""
        drawing = self.drawing.strip("\n").rstrip()
        legend = ", ".join(f"{name} = {value:g} mm" for name, value in self.lengths().items())
        return f"{drawing}\n\n{textwrap.fill(legend, WIDTH)}" if legend else drawing

    @abstractmethod
    def lengths(self) -> dict[str, float]:
        """Return the constant lengths by the names that figure and derivation use, in mm."""

    def _seed(self, seed: Sequence[float] | None) -> tuple[float, ...]:
        """Return the seed within the joint limits, where a free joint can take it."""
        chain = self.chain()
        return chain.clamp(chain.zero if seed is None else seed)

    def _finished(
        self, found: Sequence[NamedBranch], near: tuple[float, ...]
    ) -> tuple[NamedBranch, ...]:
        """Return the branches with each angle on the turn to take, and the limits they break."""
        chain = self.chain()
        return tuple(_held(branch, chain, near) for branch in found)

    def _checked(self, goal: Sequence[float]) -> tuple[float, ...]:
        if len(goal) != len(self.coordinates):
            raise KinematicsError(
                f"a goal of {self.name} is {', '.join(self.coordinates)}, not {len(goal)} numbers"
            )
        return tuple(
            finite(name, value) for name, value in zip(self.coordinates, goal, strict=True)
        )

    def _out_of_reach(
        self, quantity: str, value: float, bound: float, nearest: tuple[float, ...]
    ) -> OutOfReach:
        return OutOfReach(self.name, quantity, value, bound, self.coordinates, nearest)


def _held(branch: NamedBranch, chain: Chain, near: Sequence[float]) -> NamedBranch:
    """Return the branch with each angle on the turn to take, and the limits it breaks."""
    joints = tuple(
        _turned(value, low, high, seed) if kind is JointKind.REVOLUTE else value
        for value, (low, high), seed, kind in zip(
            branch.joints, chain.limits, near, chain.kinds, strict=True
        )
    )
    return replace(branch, joints=joints, violations=chain.violations(joints))


def _turned(angle: float, low: float, high: float, near: float) -> float:
    if low == -math.inf or high == math.inf:
        return near + math.remainder(angle - near, math.tau)
    return turn_into(angle, low, high, near)
