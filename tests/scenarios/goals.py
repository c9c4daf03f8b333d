"""Where a successful call has to bring the physical arm, and goals near its present posture.

A goal follows from the request and the posture before the call; the driver is not asked. Motors
stand on whole steps, so an angle may be off by what two steps of each motor turn it.
"""

import math
import random
from collections.abc import Mapping
from dataclasses import replace

from armdrive.motion.jog import Jogged
from armdrive.runtime.position import ArmCoordinates
from armdrive.sim.bus import DrivesBoard
from armdrive.sim.world import World
from kinematics import Joints, Motors, Pose
from tests.conformance.motions import shifted
from tests.conformance.observation import place

from .stage import Stage
from .watch import Reaches, depth_mm

ALMOST = 1e-6
LONGEST_S = 0.8
"""The longest motion of an action; goals of slow arms are brought nearer."""
TRIP_STEPS = 4
"""A grasp closes two steps at a time until the switch trips, which it does on a whole step."""


def angle_tolerances(stage: Stage) -> list[float]:
    """Return how far each joint may be from a goal, in rad, and the fingers, in mm."""
    steps = 2.0 * stage.watch.on_the_step  # start and goal are both rounded
    return [
        steps * math.fsum(map(abs, row)) + ALMOST for row in stage.world.body.transmission.inverse
    ]


def joints_reached(
    stage: Stage, angles_rad: Mapping[str, float], opening_mm: float | None = None
) -> Reaches:
    """Expect some joints at new angles, or the fingers at a new opening; everything else stays.

    A jog whose result has a note was clipped: it may end anywhere on the way.
    """
    start, opening_there = stage.posture()
    names = (*start.names, "fingers")
    tolerances = angle_tolerances(stage)
    if not stage.world.body.transmission.has_gripper:
        names, opening_mm = start.names, None
    before = (*start, opening_there)
    wanted = (
        *start.replace(**angles_rad),
        opening_there if opening_mm is None else opening_mm,
    )

    def wrong(world: World, result: object) -> str:
        joints, opening = world.body.transmission.to_joints(world.motors)
        clipped = isinstance(result, Jogged) and bool(result.note)
        for name, there, goal, here, most in zip(
            names, before, wanted, (*joints, opening), tolerances, strict=False
        ):
            start_at = there if clipped else goal
            if not min(start_at, goal) - most <= here <= max(start_at, goal) + most:
                return f"the {name} is at {here:.4f}, and its goal is {goal:.4f}"
        return ""

    return wrong


def posture_reached(stage: Stage, joints: Joints, opening_mm: float) -> Reaches:
    """Expect the whole arm in a posture, to the step: a reference."""
    wanted = stage.world.body.transmission.to_motors(joints, opening_mm)

    def wrong(world: World, _: object) -> str:
        off = (world.motors - wanted).largest
        near = stage.watch.on_the_step
        return f"it stands {off} steps from the reference posture" if off > near else ""

    return wrong


def pose_reached(stage: Stage, goal: Pose) -> Reaches:
    """Expect the tip at a pose, in any posture; a clipped jog may end anywhere on the line."""
    first = stage.config.model.arm.fk(stage.posture()[0])
    tolerances = angle_tolerances(stage)

    def wrong(world: World, result: object) -> str:
        arm = world.body.arm
        joints, _ = world.body.transmission.to_joints(world.motors)
        here, there = arm.fk(joints), goal
        turns = tolerances[: len(joints)]
        most_mm = math.fsum(a * b for a, b in zip(turns, arm.levers_mm(joints), strict=True))
        if isinstance(result, Jogged) and result.note:
            there = nearest_between(first, goal, here)
            most_mm += stage.config.motion.line_tolerance_mm
        off_mm = math.dist(place(here), place(there))
        if off_mm > most_mm + ALMOST:
            return f"the tip is at {here}, {off_mm:.1f} mm from {there}"
        off_rad = max(
            abs(math.remainder(getattr(here, name) - getattr(there, name), math.tau))
            for name in ("pitch_rad", "roll_rad")
        )
        if off_rad > math.fsum(turns):
            return f"the hand points {math.degrees(off_rad):.1f} degrees away from {there}: {here}"
        return ""

    return wrong


def grasped(world: World, result: object) -> str:
    """Expect the width of what is between the fingers, which press it."""
    if not isinstance(result, float):
        return ""
    if not world.grip_switch:
        return f"the fingers press with {world.grip_force_n:.1f} N, and hold nothing"
    wide_mm = world.scene.contact_mm
    if abs(result - wide_mm) > TRIP_STEPS / world.body.grip_steps_per_mm:
        return f"{result:.2f} mm were measured, and {wide_mm:.2f} mm are between the fingers"
    return ""


def nearest_between(start: Pose, goal: Pose, here: Pose) -> Pose:
    """Return the pose between two with the same orientation whose point is nearest to `here`."""
    way = [b - a for a, b in zip(place(start), place(goal), strict=True)]
    made = [b - a for a, b in zip(place(start), place(here), strict=True)]
    long2 = math.fsum(each * each for each in way)
    share = math.fsum(a * b for a, b in zip(way, made, strict=True)) / long2 if long2 else 0.0
    x, y, z = (min(max(share, 0.0), 1.0) * each for each in way)
    return shifted(start, x, y, z)


# -- Goals ----------------------------------------------------------------------------------------

NEAR_LIMIT_DEG = (0.2, 0.6)
"""The distance from a limit. Nearer than this, an arm on whole steps could be beyond the limit."""
COUPLED = (1, 2, 3)
"""Joints that share motors with other joints."""
BEYOND_DEG = (1.0, 6.0)
"""How far beyond a limit: so little that an arm could be driven there."""
TRIES = 8


def place_near_limits(stage: Stage, draw: random.Random) -> None:
    """Place the arm with some joints near their limits, and outside all guards."""
    arm = stage.config.model.arm
    for _ in range(TRIES):
        joints, opening_mm = stage.posture()
        for index in draw.sample(COUPLED, draw.randint(1, 2)):
            limits, inside_rad = arm.limits[index], math.radians(draw.uniform(*NEAR_LIMIT_DEG))
            angle = draw.choice((limits.low_rad + inside_rad, limits.high_rad - inside_rad))
            joints = joints.replace(**{joints.names[index]: angle})
        if not stage.watch.guard_depth_mm(joints):
            stage.place_by_hand(joints, opening_mm)
            return


def joint_goal(
    stage: Stage, draw: random.Random, most_deg: float = 15.0, longest_s: float = LONGEST_S
) -> tuple[dict[str, float], float]:
    """Return angles of some joints near the present posture, and the time to get there, in s."""
    assert stage.arm is not None
    start = ArmCoordinates(*stage.posture())
    limits = dict(zip(start.joints.names, stage.config.model.arm.limits, strict=True))
    here = dict(zip(start.joints.names, start.joints, strict=True))
    within = draw.random() < 0.5
    turns = {}
    for name in draw.sample(start.joints.names, draw.randint(1, 3)):
        turn = math.radians(draw.uniform(-most_deg, most_deg))
        if within:
            low, high = limits[name].low_rad, limits[name].high_rad
            turn = min(max(here[name] + turn, low), high) - here[name]
        turns[name] = turn
    whole = start.joints.replace(**{name: here[name] + turn for name, turn in turns.items()})
    end = ArmCoordinates(whole, start.opening_mm)
    whole_s = stage.arm.parts.speeds.duration_s(start, end, 1.0)
    share = min(longest_s / whole_s, 1.0) if whole_s > 0.0 else 1.0
    goal = {name: math.degrees(here[name] + share * turn) for name, turn in turns.items()}
    return goal, whole_s * share


def beyond_a_limit(stage: Stage, draw: random.Random) -> dict[str, float]:
    """Return a goal of one joint just beyond the nearer one of its limits."""
    joints, limits = stage.posture()[0], stage.config.model.arm.limits
    index = draw.randrange(len(joints))
    bounds, here = limits[index], joints[index]
    past_deg = draw.uniform(*BEYOND_DEG)
    up = bounds.high_rad - here < here - bounds.low_rad
    bound_deg = math.degrees(bounds.high_rad if up else bounds.low_rad)
    return {joints.names[index]: bound_deg + (past_deg if up else -past_deg)}


def span_to(stage: Stage, goal_deg: Mapping[str, float]) -> tuple[Motors, Motors]:
    """Return where the motors stand now, and where they have to stand at joint angles."""
    joints, opening_mm = stage.posture()
    goal = joints.replace(**{name: math.radians(deg) for name, deg in goal_deg.items()})
    return stage.look(), stage.world.body.transmission.to_motors(goal, opening_mm)


def nearby_pose(stage: Stage, draw: random.Random) -> Pose:
    """Return a pose a few mm away, or sometimes one that is out of reach."""
    here = stage.config.model.arm.fk(stage.posture()[0])
    reach = 12.0 if draw.random() < 0.9 else 2000.0
    return shifted(here, *(draw.uniform(-reach, reach) for _ in range(3)))


CERTAIN_DEG = (4.0, 10.0)
CERTAIN_STEPS = 5
CERTAIN_MOTORS = 3
CERTAIN_SAMPLES = 12
CERTAIN_TRIES = 60


def certain_goal(stage: Stage, draw: random.Random) -> dict[str, float] | None:
    """Return a goal that the driver must allow and that turns several motors; None without one.

    Each joint turns towards the middle of its range, no motor turns as far as its limit switch, and
    the path leads no deeper into any guard.
    """
    arm, transmission = stage.config.model.arm, stage.world.body.transmission
    guarded = replace(stage.config.model.guards, tolerance_mm=0.0).over(arm)
    joints, opening_mm = stage.posture()
    for _ in range(CERTAIN_TRIES):
        turns = {}
        for index in draw.sample(range(len(joints)), 3):
            limits, turn = arm.limits[index], math.radians(draw.uniform(*CERTAIN_DEG))
            up = joints[index] < (limits.low_rad + limits.high_rad) / 2.0
            turns[joints.names[index]] = turn if up else -turn
        path = [
            joints.replace(
                **{
                    name: joints.angles_rad[joints.names.index(name)]
                    + turn * number / CERTAIN_SAMPLES
                    for name, turn in turns.items()
                }
            )
            for number in range(CERTAIN_SAMPLES + 1)
        ]
        motors = transmission.to_motors(path[-1], opening_mm)
        steps = motors - stage.world.motors
        enough = sum(abs(each) >= CERTAIN_STEPS for each in steps) >= CERTAIN_MOTORS
        clear = max(depth_mm(guarded, each) for each in path) <= depth_mm(guarded, joints)
        if enough and clear and not _reaches_switch(stage, motors):
            there = dict(zip(joints.names, path[-1], strict=True))
            return {name: math.degrees(there[name]) for name in turns}
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
