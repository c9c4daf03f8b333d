"""The demonstration: take three blocks of unknown width and stack them, and check that they stand.

An ordinary program on an ordinary `Arm`. Only the check at the end uses the simulation: it looks at
the simulated world itself and not at any register.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from armdrive.arm import Arm
from armdrive.motion.resolve import raised
from armdrive.sim.world import World
from armdrive.sim.world.table import TableBlock
from kinematics.spaces import Pose
from kinematics.text import mm_text

# Height of the straight lifts above the places of the blocks.
SAFE_MM = 60.0
# How much wider than a block the fingers open to release it without touching another.
CLEARANCE_MM = 12.0
# How far a block may stand from its place: rounding to steps, and the fingers that push it.
NEAR_ENOUGH_MM = 2.0
DOWN_DEG = -90.0


@dataclass(frozen=True, slots=True)
class Job:
    """One block: its name, its size, where it lies and where it belongs (bottom centre)."""

    name: str
    width_mm: float
    height_mm: float
    from_mm: tuple[float, float, float]
    to_mm: tuple[float, float, float]


# A tower of three at the right, from three places at the left.
JOBS = (
    Job("A", 38.0, 30.0, (240.0, 110.0, 0.0), (260.0, -90.0, 0.0)),
    Job("B", 30.0, 30.0, (310.0, 60.0, 0.0), (260.0, -90.0, 30.0)),
    Job("C", 22.0, 30.0, (190.0, 40.0, 0.0), (260.0, -90.0, 60.0)),
)


@dataclass(frozen=True, slots=True)
class CarriedBlock:
    """A block that was carried, and its measured width."""

    job: Job
    measured_mm: float


def perform(arm: Arm, jobs: tuple[Job, ...], tell: Callable[[str], None]) -> list[CarriedBlock]:
    """Reference the arm, carry every block to its place, and park."""
    tell("referencing: the fingers go to the mark on the table")
    arm.home()
    tell(f"referenced at {arm.pose}")
    done = [_carry(arm, job, tell) for job in jobs]
    tell("parking")
    arm.park()
    return done


def _carry(arm: Arm, job: Job, tell: Callable[[str], None]) -> CarriedBlock:
    take, put = _middle(job, job.from_mm), _middle(job, job.to_mm)
    tell(f"block {job.name}: approach")
    if arm.pose.z_mm < SAFE_MM:  # straight up first: a joint motion could sweep blocks away
        arm.move_l(raised(arm.pose, SAFE_MM - arm.pose.z_mm))
    arm.gripper.open()
    arm.move_to(raised(take, SAFE_MM))
    arm.move_l(take)
    width_mm = arm.gripper.grasp()
    tell(f"block {job.name}: grasped, it measures {mm_text(width_mm)}")
    arm.move_l(raised(take, SAFE_MM))
    tell(f"block {job.name}: to its place")
    arm.move_to(raised(put, SAFE_MM))
    arm.move_l(put)
    arm.gripper.open(width_mm + CLEARANCE_MM)
    arm.move_l(raised(put, SAFE_MM))
    return CarriedBlock(job, width_mm)


def misplaced(world: World, jobs: tuple[Job, ...]) -> list[str]:
    """Return a sentence for every block that is physically not where it belongs."""
    found = []
    for job in jobs:
        block = world.scene.blocks.get(job.name)
        away_mm = math.inf if block is None else math.dist(block.place, job.to_mm)
        if away_mm > NEAR_ENOUGH_MM:
            found.append(f"block {job.name} is {mm_text(away_mm)} from where it belongs")
    return found


def blocks_of(jobs: tuple[Job, ...]) -> list[TableBlock]:
    """Return the blocks as they lie before the demonstration."""
    return [TableBlock(job.name, *job.from_mm, job.width_mm, job.height_mm) for job in jobs]


def _middle(job: Job, place: tuple[float, float, float]) -> Pose:
    x, y, z = place
    return Pose.of(x_mm=x, y_mm=y, z_mm=z + job.height_mm / 2, pitch_deg=DOWN_DEG)
