"""A planned move on the wire: its steps one after another, each as it was audited."""

from __future__ import annotations

import math
from collections.abc import Sequence

from armdrive.errors import BadRequest
from armdrive.motion.context import MotionContext
from armdrive.motion.execute import Moved, follow
from armdrive.motion.gripper import Grasped, grasp, set_gripper
from armdrive.motion.plan import MotionPlan
from armdrive.motion.resolve import PlannedMove, PlannedStep
from armdrive.motion.segments import SpeedLimits
from armdrive.moves import GraspMove, GripperMove
from armdrive.tasks import TaskBody


def carry_out(
    wire: MotionContext, speeds: SpeedLimits, planned: PlannedMove
) -> TaskBody[Moved | Grasped]:
    """Carry out a planned move. A stop ends all of it: no step begins behind one.

    Returns what a grasp at its end has found, else where the arm is and what all steps cost.
    """
    moved: list[Moved] = []
    for step in planned.steps:
        done = yield from _step(wire, speeds, step)
        if isinstance(done, Grasped):
            return done
        moved.append(done)
    return _together(moved)


def _step(wire: MotionContext, speeds: SpeedLimits, step: PlannedStep) -> TaskBody[Moved | Grasped]:
    match step:
        case PlannedStep(plan=MotionPlan() as plan):
            return (yield from follow(wire, plan))
        case PlannedStep(move=GraspMove(force_n=force_n)):
            return (yield from grasp(wire, speeds, force_n))
        case PlannedStep(move=GripperMove(opening_mm=float() as opening_mm)):
            return (yield from set_gripper(wire, opening_mm))
    raise BadRequest(f"{step.move} was not planned")


def _together(moved: Sequence[Moved]) -> Moved:
    """Return what several moves did as one: where the last one ended, and what they cost."""
    last = moved[-1]
    if len(moved) == 1:
        return last
    return Moved(
        last.joints,
        last.pose,
        last.rounding_mm,
        math.fsum(each.duration_s for each in moved),
        sum(each.bursts for each in moved),
        max(each.straying_mm for each in moved),
        "; ".join(filter(None, (each.note for each in moved))),
    )
