"""Random goals near the arm's present posture, and the commands and aims that belong to them."""

import math
import random
from collections.abc import Mapping
from dataclasses import replace

from armdrive.arm import Arm
from armdrive.runtime.position import ArmCoordinates
from armdrive.sim.bus import DrivesBoard
from kinematics import Joints, Motors, Pose
from kinematics.guards import GuardedArm
from tests.conformance.motions import shifted

from .arrival import JointsAim, PoseAim
from .physical import Aim, Command
from .stage import Stage

LONGEST_S = 0.8
"""The longest motion of an action; goals of slow arms are brought nearer."""


NEAR_LIMIT_DEG = (0.2, 0.6)
"""The distance from a limit. Nearer than this, an arm on whole steps could be beyond the limit."""
COUPLED = (1, 2, 3)
"""Joints that share motors with other joints."""
TRIES = 8


def place_near_limits(stage: Stage) -> None:
    """Place the arm with some joints near their limits, and outside all guards."""
    draw, arm, body = stage.draw, stage.config.model.arm, stage.world.body
    for _ in range(TRIES):
        joints, opening_mm = body.transmission.to_joints(stage.world.motors)
        for index in draw.sample(COUPLED, draw.randint(1, 2)):
            bounds, inside_rad = arm.limits[index], math.radians(draw.uniform(*NEAR_LIMIT_DEG))
            angle = draw.choice((bounds.low_rad + inside_rad, bounds.high_rad - inside_rad))
            joints = joints.replace(**{joints.names[index]: angle})
        if not stage.watch.guard_depth_mm(joints):
            stage.place_by_hand(joints, opening_mm)
            return


def speed_of(draw: random.Random) -> float:
    return draw.choice((0.3, 0.6, 1.0))


def command_of(
    stage: Stage,
    what: str,
    aim: Aim | None = None,
    *,
    speed: float = 1.0,
    span: tuple[Motors, Motors] | None = None,
) -> Command:
    """Return a command, with its aim if the position is known."""
    arm = arm_of(stage)
    slack_mm = 0.0 if arm.abilities.coordinated else stage.config.motion.deviation_mm
    known = arm.parts.core.position_known
    return Command(what, known, span, aim if known else None, speed, slack_mm=slack_mm)


def arm_of(stage: Stage) -> Arm:
    assert stage.arm is not None
    return stage.arm


def joint_goal(
    stage: Stage, most_deg: float = 15.0, longest_s: float = LONGEST_S
) -> tuple[dict[str, float], float]:
    """Return joint angles near the present posture, and the time to get there at full speed."""
    arm, draw = arm_of(stage), stage.draw
    start = ArmCoordinates(*stage.posture())
    chosen = draw.sample(start.joints.names, draw.randint(1, 3))
    turns = {name: math.radians(draw.uniform(-most_deg, most_deg)) for name in chosen}
    here = dict(zip(start.joints.names, start.joints, strict=True))
    if draw.random() < 0.5:  # no further than the limits
        limits = dict(zip(start.joints.names, arm.model.arm.limits, strict=True))
        for name, turn in turns.items():
            low, high = limits[name].low_rad, limits[name].high_rad
            turns[name] = min(max(here[name] + turn, low), high) - here[name]
    whole = ArmCoordinates(
        start.joints.replace(**{name: here[name] + turn for name, turn in turns.items()}),
        start.opening_mm,
    )
    whole_s = arm.parts.speeds.duration_s(start, whole, 1.0)
    share = min(longest_s / whole_s, 1.0) if whole_s > 0.0 else 1.0
    goal = {f"{name}_deg": math.degrees(here[name] + share * turn) for name, turn in turns.items()}
    return goal, whole_s * share


BEYOND_DEG = (1.0, 6.0)
"""How far beyond a limit: so little that an arm could be driven there."""


def beyond_a_limit(stage: Stage) -> dict[str, float]:
    """Return a goal of one joint just beyond the nearer one of its limits."""
    joints, limits = stage.posture()[0], stage.config.model.arm.limits
    index = stage.draw.randrange(len(joints))
    bounds, here = limits[index], joints[index]
    past_deg = stage.draw.uniform(*BEYOND_DEG)
    up = bounds.high_rad - here < here - bounds.low_rad
    bound_deg = math.degrees(bounds.high_rad if up else bounds.low_rad)
    return {f"{joints.names[index]}_deg": bound_deg + (past_deg if up else -past_deg)}


def joints_aim(stage: Stage, goal_deg: Mapping[str, float], *, clipped: bool = False) -> JointsAim:
    """Return the aim of a motion of some joints, with names such as `shoulder_deg`."""
    named = {name.removesuffix("_deg"): math.radians(deg) for name, deg in goal_deg.items()}
    return JointsAim(stage.look(), named, near=stage.near_steps, clipped=clipped)


def span_to(stage: Stage, aim: JointsAim) -> tuple[Motors, Motors]:
    """Return the range in which every motor stays on the way to an aim, with rounding."""
    transmission = stage.world.body.transmission
    rounding = [int(most) - aim.near for most in aim.tolerance(transmission)]
    ends = list(zip(aim.start, aim.goal(transmission), rounding, strict=True))
    low = Motors(min(a, b) - most for a, b, most in ends)
    return low, Motors(max(a, b) + most for a, b, most in ends)


def nearby_pose(stage: Stage) -> Pose:
    """Return a pose a few mm away, or sometimes one that is out of reach."""
    draw, arm = stage.draw, arm_of(stage)
    here = arm.model.arm.fk(stage.posture()[0])
    reach = 12.0 if draw.random() < 0.9 else 2000.0
    return shifted(here, *(draw.uniform(-reach, reach) for _ in range(3)))


def pose_aim(stage: Stage, goal: Pose, *, clipped: bool = False) -> PoseAim:
    """Return the aim of a motion of the tip to a pose."""
    deviation_mm = stage.config.motion.line_tolerance_mm
    return PoseAim(stage.look(), goal, stage.near_steps, clipped, deviation_mm)


CERTAIN_DEG = (4.0, 10.0)
CERTAIN_STEPS = 5
CERTAIN_MOTORS = 3
CERTAIN_SAMPLES = 12
CERTAIN_TRIES = 60


def certain_goal(stage: Stage) -> dict[str, float] | None:
    """Return a goal that the driver must allow and that turns several motors; None without one.

    Each joint turns towards the middle of its range, no motor turns as far as its limit switch, and
    the path leads no deeper into any guard.
    """
    draw, arm = stage.draw, stage.config.model.arm
    transmission = stage.world.body.transmission
    strict = replace(stage.config.model.guards, tolerance_mm=0.0).over(arm)
    joints, opening_mm = transmission.to_joints(stage.look())
    depth_mm = _depth_mm(strict, joints)
    if stage.watch.guard_depth_mm(joints):
        return None
    for _ in range(CERTAIN_TRIES):
        goal = joints
        for index in draw.sample(range(len(joints)), 3):
            limits, turn = arm.limits[index], math.radians(draw.uniform(*CERTAIN_DEG))
            up = joints[index] < (limits.low_rad + limits.high_rad) / 2.0
            goal = goal.replace(**{joints.names[index]: joints[index] + (turn if up else -turn)})
        motors = transmission.to_motors(goal, opening_mm)
        steps = motors - stage.world.motors
        if sum(abs(each) >= CERTAIN_STEPS for each in steps) < CERTAIN_MOTORS:
            continue
        if _reaches_switch(stage, motors):
            continue
        path = (_between(joints, goal, n / CERTAIN_SAMPLES) for n in range(1, CERTAIN_SAMPLES + 1))
        if all(_depth_mm(strict, each) <= depth_mm for each in path):
            return {
                f"{name}_deg": math.degrees(angle)
                for name, angle, before in zip(goal.names, goal, joints, strict=True)
                if angle != before
            }
    return None


def _reaches_switch(stage: Stage, motors: Motors) -> bool:
    """Return whether a motor turns to its limit switch, where its drive may stop by itself.

    Two drives that share joints can reach one although each joint is within its limits.
    """
    board = stage.twin.board
    if not isinstance(board, DrivesBoard):
        return False
    return any(
        (goal - here) * switch.way > 0 and (goal - switch.at) * switch.way >= 0
        for here, goal, switch in zip(
            stage.world.motors, motors, (node.motor.switch for node in board.nodes), strict=True
        )
    )


def _between(start: Joints, end: Joints, share: float) -> Joints:
    return Joints(tuple(a + share * (b - a) for a, b in zip(start, end, strict=True)), start.names)


def _depth_mm(guarded: GuardedArm, joints: Joints) -> float:
    return max((each.excess_mm for each in guarded.violations(joints)), default=0.0)
