"""An arm as a subject of study, and all that follows from one of its postures.

A subject is a named system, a built-in arm, or any chain. A study of one of its postures contains
the matrices, the Jacobian, how well the hand moves, and the other postures for the same place of
the hand. These are values; `worked_example` writes them, and also takes goals. Lengths in mm,
angles in rad.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from types import MappingProxyType

from kinematics.chains.assignment import ZeroPosition, zero_position
from kinematics.chains.chain import Chain
from kinematics.chains.closed_form import closed_form
from kinematics.chains.evaluation import evaluator
from kinematics.chains.goals import frame_goal
from kinematics.chains.inverse import Solution
from kinematics.chains.jacobians import (
    Condition,
    condition,
    condition_of,
    default_rows,
)
from kinematics.chains.links import DHLink, JointKind
from kinematics.errors import KinematicsError
from kinematics.frames.orientations import RPY, OrientationSolution, solve_rpy
from kinematics.frames.transforms import IN_PLACE, Transform, rotation_of
from kinematics.limits import LimitViolation
from kinematics.spaces import Jacobian
from kinematics.textbook.systems.mini_movers import own_angle_rows
from kinematics.textbook.systems.named import NamedBranch, NamedSingularity, System

# The Jacobian of a named system in its own coordinates, and its singularities with reasons.
#
# A planar arm has no z and a five-axis one no yaw: judged by all six rows of the geometric Jacobian
# the first is always singular, and the second never where its tip is over the base. Lengths in mm,
# angles in rad, rates per second of whatever the joint is measured in.

# Rows that no geometric Jacobian has: those of the five-axis build's own angles.
PITCH_ROW, ROLL_ROW = 6, 7

# What each row's number stands for.
ROW_NAMES = ("x", "y", "z", "about x", "about y", "about z", "pitch", "roll")

# An entry below this moves nothing, in mm or rad a unit of the joint.
_STILL = 1e-9

_ROWS: Mapping[str, int] = MappingProxyType(
    {
        "x_mm": 0,
        "y_mm": 1,
        "z_mm": 2,
        "phi_rad": 3,
        "theta_rad": 4,
        "psi_rad": 5,
        "pitch_rad": PITCH_ROW,
        "roll_rad": ROLL_ROW,
    }
)
# The only angle of a planar arm is about z.
_IN_THE_PLANE = 5


def own_rows(system: System) -> tuple[int, ...]:
    """Return the numbers of the rows that a system's own coordinates stand for.

    The three angles of a whole orientation stand for turning about x, y and z.
    """
    rows = tuple(_ROWS[name] for name in system.coordinates)
    angles = [row for row in rows if row >= 3]
    planar = angles == [_ROWS["phi_rad"]]
    return (*(row for row in rows if row < 3), *((_IN_THE_PLANE,) if planar else angles))


def own_jacobian(system: System, values: Sequence[float]) -> Jacobian:
    """Return the rows of `own_rows`, a column a joint. Raises as `System.fk` does.

    Pitch and roll of the five-axis build are its own, with the roll in the hand.
    """
    chain, rows = system.chain(), own_rows(system)
    checked = chain.directions(values)
    if system.arm is None:
        return chain_jacobian(chain, checked, rows)
    return (*chain_jacobian(chain, checked, rows[:3]), *own_angle_rows(system, checked))


# Angles of the example posture: no two are alike, and none is a right angle.
_EXAMPLE_DEG = (30.0, 40.0, -60.0, -20.0, 45.0, 60.0)

# The share of its range at which a joint stands whose range does not hold its example angle.
_TRAVEL = 0.4

# Where a slide without limits stands.
_FREE_TRAVEL_MM = 100.0


def example_posture(chain: Chain) -> tuple[float, ...]:
    """Return a posture to show: round numbers within the limits, degenerate in no way."""
    return tuple(
        _example_value(link, _EXAMPLE_DEG[index % len(_EXAMPLE_DEG)])
        for index, link in enumerate(chain.links)
    )


def _example_value(link: DHLink, angle_deg: float) -> float:
    """Return a joint's example value: the angle, or as far into the range as it is of a turn."""
    if link.kind is JointKind.REVOLUTE:
        angle = math.radians(angle_deg)
        for value in (angle, -angle):
            if link.low <= value <= link.high:
                return value
    elif not link.bounded:
        return min(max(_FREE_TRAVEL_MM, link.low), link.high)
    return link.low + _TRAVEL * (link.high - link.low)


def chain_rows(chain: Chain) -> tuple[int, ...]:
    """Return the rows that a chain is judged by: `default_rows`, without those it never moves in.

    A planar arm leaves some out; two postures tell which, as good as any others.
    """
    made = evaluator(chain)
    first = example_posture(chain)
    postures = (first, tuple(0.7 * value for value in first))
    seen = [made.jacobian(posture) for posture in postures]
    return tuple(
        row
        for row in default_rows(chain)
        if any(abs(entry) > _STILL for one in seen for entry in one[row])
    )


def chain_jacobian(chain: Chain, values: Sequence[float], rows: Sequence[int]) -> Jacobian:
    """Return some rows of the geometric Jacobian. Raises as `Chain.fk` does."""
    whole = evaluator(chain).jacobian(chain.directions(values))
    return tuple(whole[row] for row in rows)


def named_singularities(system: System, values: Sequence[float]) -> tuple[NamedSingularity, ...]:
    """Return every singularity of a named system, in a fixed order; joint limits not looked at.

    They are where the system's Jacobian in its own coordinates loses a rank, and nowhere else: the
    determinants are products of these measures. Sources: McKerrow, chapter 4, section 12; Craig,
    chapter 5. Empty for a system that has none (all slides). Raises as `System.fk` does.
    """
    return tuple(system.singularities(system, system.chain().directions(values)))


@dataclass(frozen=True, slots=True)
class Subject:
    """An arm as a chain of links, and the named system with closed forms where it is one.

    `rows` number the rows of its Jacobian: `kinematics.textbook.study.ROW_NAMES` has their
    names. `axes` are those that a model file gives instead of links. `angles` says how joint angles
    count, if that needs saying, and `unused` what a description holds and the chain does not.
    """

    name: str
    title: str
    source: str
    chain: Chain
    system: System | None
    rows: tuple[int, ...]
    axes: ZeroPosition | None = None
    angles: str = ""
    unused: tuple[str, ...] = ()

    @property
    def zero(self) -> ZeroPosition:
        """The joint axes and the tool with every joint at zero: as given, or as the links say."""
        return self.axes or zero_position(self.chain)


def subject_of_system(one: System) -> Subject:
    """Return a named system as a subject."""
    notes, rows = one.notes, own_rows(one)
    return Subject(one.name, one.title, notes.source, one.chain(), one, rows, angles=notes.angles)


def subject_of_chain(name: str, title: str, source: str, chain: Chain) -> Subject:
    """Return a chain as a subject: it has a Jacobian, but no closed form."""
    return Subject(name, title, source, chain, None, chain_rows(chain))


def named_factors(
    base: Transform, matrices: Sequence[Transform], tool: Transform
) -> list[tuple[str, Transform]]:
    """Return the factors of the tool's frame by name: A1 to An, with base and tool if they move."""
    ends = [("base", base), *((f"A{n}", one) for n, one in enumerate(matrices, 1)), ("tool", tool)]
    return [(name, one) for name, one in ends if name.startswith("A") or one != IN_PLACE]


# The goal of a chain that is no named system: a position, or a position and an orientation.
FRAME_COORDINATES = ("x_mm", "y_mm", "z_mm", "phi_rad", "theta_rad", "psi_rad")

# Postures whose study is remembered.
KEPT = 64

# A branch this near in every joint (rad or mm) is the posture itself.
SAME = 1e-6


@dataclass(frozen=True, slots=True)
class Study:
    """A posture of a subject, and everything computed from it.

    `matrices` are the A matrices, `frame` the tool's frame. `jacobian` has the subject's rows.
    `singularities` are the named ones. `goal` is what was asked, in `coordinates`: by
    default the system's own coordinates of the hand. `branches` is every posture that meets it,
    none of a link table without a closed form; `refusal` says why a named system has none. A link
    table that was asked for a goal has the `solution` of the numerical solver too.
    """

    subject: Subject
    values: tuple[float, ...]
    matrices: tuple[Transform, ...]
    frame: Transform
    orientation: OrientationSolution[RPY]
    jacobian: Jacobian
    condition: Condition
    singularities: tuple[NamedSingularity, ...]
    goal: tuple[float, ...]
    branches: tuple[NamedBranch, ...]
    refusal: str
    solution: Solution | None = None

    @property
    def factors(self) -> list[tuple[str, Transform]]:
        """What the tool's frame is the product of, by name."""
        chain = self.subject.chain
        return named_factors(chain.base, self.matrices, chain.tool)

    @property
    def violations(self) -> tuple[LimitViolation, ...]:
        """The joint limits that the posture breaks."""
        return self.subject.chain.violations(self.values)

    @property
    def coordinates(self) -> tuple[str, ...]:
        """The names of the goal's numbers, with their units."""
        system = self.subject.system
        return FRAME_COORDINATES[: len(self.goal)] if system is None else system.coordinates

    def comes_to(self, branch: NamedBranch) -> tuple[float, ...]:
        """Return the goal that a branch of a named system really meets."""
        system = self.subject.system
        return () if system is None else system.goal_of(system.fk(branch.joints))

    @property
    def here(self) -> int | None:
        """The place of this very posture among the branches; None where it is none of them."""
        near = ((self._away(branch), index) for index, branch in enumerate(self.branches))
        away, index = min(near, default=(SAME, -1))
        return index if away < SAME else None

    @property
    def conditioning(self) -> float:
        """The largest singular value by the smallest; infinite where the posture is singular."""
        values = self.condition.singular_values
        return float("inf") if self.condition.is_singular else values[0] / values[-1]

    def _away(self, branch: NamedBranch) -> float:
        pairs = zip(branch.joints, self.values, strict=True)
        return max(abs(one - other) for one, other in pairs)


@lru_cache(maxsize=KEPT)
def study(subject: Subject, values: tuple[float, ...]) -> Study:
    """Return the study of a posture. Raises as `Chain.fk` does."""
    chain, system = subject.chain, subject.system
    checked = chain.checked(values)
    frame = chain.fk(checked)
    if system is not None:
        jacobian = own_jacobian(system, checked)
    else:
        jacobian = chain_jacobian(chain, checked, subject.rows)
    goal, branches, refusal = _solved(subject, frame, checked)
    return Study(
        subject,
        checked,
        chain.matrices(checked),
        frame,
        solve_rpy(rotation_of(frame)),
        jacobian,
        condition_of(chain, jacobian, subject.rows),
        () if system is None else named_singularities(system, checked),
        goal,
        branches,
        refusal,
    )


def table_branches(
    chain: Chain, frame: Transform, near: Sequence[float]
) -> tuple[NamedBranch, ...]:
    """Return every posture of a link table that has this frame, none without a closed form.

    They have numbers for names; each angle is of the allowed turn nearest to `near`.
    """
    form = closed_form(chain)
    found = [] if form is None else form.branches(frame_goal(frame), near)
    return tuple(
        NamedBranch(
            f"solution {number}",
            joints,
            degenerate=_lost_at(chain, joints),
            violations=chain.violations(joints),
        )
        for number, joints in enumerate(found, 1)
    )


def _lost_at(chain: Chain, joints: Sequence[float]) -> str:
    state = condition(chain, joints)
    return state.sentence if state.is_singular else ""


def _solved(
    subject: Subject, frame: Transform, values: tuple[float, ...]
) -> tuple[tuple[float, ...], tuple[NamedBranch, ...], str]:
    """Return the goal of a posture and every branch that meets it, or why there is none."""
    system = subject.system
    if system is None:
        return (), table_branches(subject.chain, frame, values), ""
    goal = system.goal_of(frame)
    try:
        return goal, system.ik(goal, values), ""
    except KinematicsError as error:
        return goal, (), str(error)
