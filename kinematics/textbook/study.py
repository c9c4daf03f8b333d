"""An arm as a subject of study, and all that follows from one of its postures.

A subject is a named system, a built-in arm, or a chain of one's own; of a posture follow its
matrices, Jacobian, how well the hand moves, and what other postures would do. Values only, worked
out once a posture; `pages` writes them. Lengths in mm, angles in rad.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

from kinematics.chains.arm import ChainArm
from kinematics.chains.chain import Chain
from kinematics.chains.generated import Jacobian
from kinematics.chains.singularities import Condition, nearest_singularity
from kinematics.errors import KinematicsError, UnknownSystem, nearest_word
from kinematics.five_axis.arm import FiveAxisArm
from kinematics.five_axis.tool_arm import ToolArm
from kinematics.frames.orientations import RPY, OrientationSolution, solve_rpy
from kinematics.frames.transforms import Transform, rotation_of
from kinematics.geometry import ArmGeometry
from kinematics.presets import PRESETS, preset
from kinematics.textbook.jacobians import (
    chain_jacobian,
    chain_rows,
    judged,
    named_singularities,
    own_jacobian,
    own_rows,
)
from kinematics.textbook.systems import SYSTEMS
from kinematics.textbook.systems.mini_movers import MINI_MOVER, with_arm
from kinematics.textbook.systems.named import Lost, NamedBranch, System


@dataclass(frozen=True, slots=True)
class Subject:
    """An arm as a chain of links, and the named system with closed forms where it is one.

    `rows` number the rows of its Jacobian: `kinematics.textbook.jacobians.ROW_NAMES` has their
    names.
    """

    name: str
    title: str
    source: str
    chain: Chain
    system: System | None
    rows: tuple[int, ...]


def subject_names() -> tuple[str, ...]:
    """Return every name that can be studied: the named systems, then the built-in arms."""
    return tuple(dict.fromkeys((*SYSTEMS, *PRESETS)))


def named_subject(name: str) -> Subject:
    """Return the named system or built-in arm; raises `UnknownSystem` with the nearest name."""
    if name in SYSTEMS:
        return _of_system(name, SYSTEMS[name].title, SYSTEMS[name])
    if name in PRESETS:
        return _of_system(name, preset(name).title, with_arm(MINI_MOVER, preset(name).arm))
    names = subject_names()
    raise UnknownSystem(name, names, nearest_word(name, names))


@lru_cache(maxsize=8)
def subject_of_arm(name: str, arm: ArmGeometry) -> Subject | None:
    """Return the theory of an arm that is driven; None for a build that none is known of.

    Of an arm that holds a tool it is the theory of its finger tips.
    """
    if isinstance(arm, ToolArm):
        return subject_of_arm(f"{name}, without its tool", arm.bare)
    if isinstance(arm, FiveAxisArm):
        return _of_system(name, name, with_arm(MINI_MOVER, arm))
    if isinstance(arm, ChainArm):
        return subject_of_chain(name, name, "", arm.chain)
    return None


def _of_system(name: str, title: str, system: System) -> Subject:
    return Subject(name, title, system.source, system.chain(), system, own_rows(system))


def subject_of_chain(name: str, title: str, source: str, chain: Chain) -> Subject:
    """Return a chain as a subject: it has a Jacobian, but no closed form."""
    return Subject(name, title, source, chain, None, chain_rows(chain))


KEPT = 64
"""Postures whose study is remembered."""

SAME = 1e-6
"""A branch this near in every joint (rad or mm) is the posture itself."""


@dataclass(frozen=True, slots=True)
class Study:
    """A posture of a subject, and what follows from it.

    `matrices` are the A matrices, `frame` the tool's frame. `jacobian` has the subject's rows.
    `lost` are its singularities, named ones only; `goal` are the system's own coordinates of the
    hand, and `branches` every posture that meets them; `refusal` says why there are none.
    """

    subject: Subject
    values: tuple[float, ...]
    matrices: tuple[Transform, ...]
    frame: Transform
    orientation: OrientationSolution[RPY]
    jacobian: Jacobian
    condition: Condition
    lost: tuple[Lost, ...]
    goal: tuple[float, ...]
    branches: tuple[NamedBranch, ...]
    refusal: str

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
    """Return what follows from a posture. Raises as `Chain.fk` does."""
    chain, system = subject.chain, subject.system
    checked = chain.checked(values)
    frame = chain.fk(checked)
    jacobian = jacobian_of(subject, checked)
    goal, branches, refusal = _solved(system, frame, checked)
    return Study(
        subject,
        checked,
        chain.matrices(checked),
        frame,
        solve_rpy(rotation_of(frame)),
        jacobian,
        judged(chain, jacobian, subject.rows),
        () if system is None else named_singularities(system, checked),
        goal,
        branches,
        refusal,
    )


def jacobian_of(subject: Subject, values: Sequence[float]) -> Jacobian:
    """Return the subject's rows of the Jacobian. Raises as `Chain.fk` does."""
    if subject.system is not None:
        return own_jacobian(subject.system, values)
    return chain_jacobian(subject.chain, values, subject.rows)


@lru_cache(maxsize=KEPT)
def searched(subject: Subject, values: tuple[float, ...]) -> tuple[Lost, ...]:
    """Return the singularity of a link table that descent finds nearest, none where it finds none.

    It takes up to seconds: not for where somebody waits. Slides count in lengths of the arm, as
    radians of the joint move.
    """
    found = nearest_singularity(subject.chain, values, subject.rows)
    return () if found is None else (Lost(found.condition.sentence, found.distance, None),)


def _solved(
    system: System | None, frame: Transform, values: tuple[float, ...]
) -> tuple[tuple[float, ...], tuple[NamedBranch, ...], str]:
    """Return the goal of a posture and every branch that meets it, or why there is none."""
    if system is None:
        return (), (), "a link table has no closed form: it is solved by numbers, one at a time"
    goal = system.goal_of(frame)
    try:
        return goal, system.ik(goal, values), ""
    except KinematicsError as error:
        return goal, (), str(error)
