"""The lecture's worked example for anybody's numbers: everything to be said of an arm's posture.

Content only, as values; `worked_text` writes it. Lengths in mm, angles in rad.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from kinematics.chains import Chain, JointViolation
from kinematics.errors import KinematicsError, finite
from kinematics.frames import Transform, position_of, rotation_of, transform
from kinematics.links import DHLink, JointKind
from kinematics.orientations import RPY, Degeneracy, OrientationSolution, solve_rpy
from kinematics.singularities import condition
from kinematics.systems import NamedBranch, Step, System

if TYPE_CHECKING:
    from kinematics.ik_account import Solution

FRAME_COORDINATES = ("x_mm", "y_mm", "z_mm", "phi_rad", "theta_rad", "psi_rad")
"""The goal of a chain that is no named system: a position, or a position and an orientation."""

_EXAMPLE_DEG = (30.0, 40.0, -60.0, -20.0, 45.0, 60.0)
_TRAVEL = 0.4
_FREE_TRAVEL_MM = 100.0


@dataclass(frozen=True, slots=True)
class WorkedBranch:
    """A branch of the inverse solution, and the goal's coordinates that its posture gives."""

    branch: NamedBranch
    comes_to: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class WorkedExample:
    """An arm, a posture, and all that follows from it.

    `matrices` are the A matrices of the posture, `frame` the tool's frame. `condition` says how
    well the posture can move. A named system has `branches` for the `goal`, in `coordinates`;
    any other chain has the `solution` of the numerical solver.
    """

    name: str
    title: str
    source: str
    figure: str
    derivation: tuple[Step, ...]
    chain: Chain
    joints: tuple[float, ...]
    matrices: tuple[Transform, ...]
    frame: Transform
    orientation: OrientationSolution[RPY]
    violations: tuple[JointViolation, ...]
    condition: str
    coordinates: tuple[str, ...]
    goal: tuple[float, ...]
    branches: tuple[WorkedBranch, ...] = ()
    solution: Solution | None = None

    @property
    def orientation_degeneracy(self) -> Degeneracy | None:
        """What the orientation's angles lose, or None."""
        return self.orientation.degeneracy


def work_system(
    system: System, joints: Sequence[float] | None = None, goal: Sequence[float] | None = None
) -> WorkedExample:
    """Return the worked example of a named system.

    Without joints, the first branch of the goal within the limits is taken, or an example
    posture. Without a goal, the one that the joints reach. Raises as `System.fk` and `System.ik`
    do.
    """
    chain = system.chain()
    if goal is None:
        posture = example_posture(chain) if joints is None else chain.checked(joints)
        asked = system.goal_of(system.fk(posture))
        found = system.ik(asked, posture)
    else:
        found = system.ik(goal, joints)
        asked = tuple(goal)
        taken = min(found, key=lambda branch: not branch.within_limits)
        posture = taken.joints if joints is None else chain.checked(joints)
    frame = system.fk(posture)
    return WorkedExample(
        system.name,
        system.title,
        system.source,
        system.figure(),
        system.derivation,
        chain,
        posture,
        chain.matrices(posture),
        frame,
        solve_rpy(rotation_of(frame)),
        chain.violations(posture),
        condition(chain, posture).sentence,
        system.coordinates,
        asked,
        branches=tuple(
            WorkedBranch(branch, system.goal_of(system.fk(branch.joints))) for branch in found
        ),
    )


def work_chain(
    chain: Chain,
    title: str = "",
    source: str = "",
    joints: Sequence[float] | None = None,
    goal: Sequence[float] | None = None,
) -> WorkedExample:
    """Return the worked example of any chain, solved numerically.

    A goal is x, y, z, or these with phi, theta, psi; without one it is the whole frame that the
    joints reach, asked from the middle of the joints' ranges. Raises as `Chain.fk` does, and
    `KinematicsError` for another number of goal coordinates.
    """
    from kinematics.goals import ALL_PARTS, Part
    from kinematics.numeric_ik import solve_frame_ik

    parts = ALL_PARTS
    if goal is None:
        posture = example_posture(chain) if joints is None else chain.checked(joints)
        target = chain.fk(posture)
    else:
        if len(goal) not in (3, 6):
            raise KinematicsError(
                "a goal is x, y, z, or x, y, z, phi, theta, psi (mm and angles), "
                f"not {len(goal)} numbers"
            )
        if len(goal) == 3:
            parts = frozenset({Part.POSITION})
        target = _frame_of(goal)
    solution = solve_frame_ik(chain, target, joints if goal is not None else None, parts=parts)
    if goal is not None:
        posture = solution.joints if joints is None else chain.checked(joints)
    frame = chain.fk(posture)
    asked = FRAME_COORDINATES if parts == ALL_PARTS else FRAME_COORDINATES[:3]
    return WorkedExample(
        chain.name,
        title,
        source,
        "",
        (),
        chain,
        tuple(posture),
        chain.matrices(posture),
        frame,
        solve_rpy(rotation_of(frame)),
        chain.violations(posture),
        condition(chain, posture).sentence,
        asked,
        frame_coordinates(target)[: len(asked)],
        solution=solution,
    )


def example_posture(chain: Chain) -> tuple[float, ...]:
    """Return a posture to show: round numbers within the limits, degenerate in no way."""
    return tuple(
        _example(link, _EXAMPLE_DEG[index % len(_EXAMPLE_DEG)])
        for index, link in enumerate(chain.links)
    )


def frame_coordinates(frame: Transform) -> tuple[float, ...]:
    """Return x, y, z, phi, theta and psi of a frame."""
    angles = solve_rpy(rotation_of(frame)).first
    return *position_of(frame), angles.phi_rad, angles.theta_rad, angles.psi_rad


def _frame_of(goal: Sequence[float]) -> Transform:
    names = FRAME_COORDINATES[: len(goal)]
    numbers = [finite(name, value) for name, value in zip(names, goal, strict=True)]
    x, y, z, phi, theta, psi = (*numbers, 0.0, 0.0, 0.0)[:6]
    return transform(RPY(phi, theta, psi).rotation(), (x, y, z))


def _example(link: DHLink, angle_deg: float) -> float:
    """Return a joint's example value: the angle, or as far into the range as it is of a turn."""
    if link.kind is JointKind.REVOLUTE:
        angle = math.radians(angle_deg)
        for value in (angle, -angle):
            if link.low <= value <= link.high:
                return value
    elif not (math.isfinite(link.low) and math.isfinite(link.high)):
        return min(max(_FREE_TRAVEL_MM, link.low), link.high)
    return link.low + _TRAVEL * (link.high - link.low)
