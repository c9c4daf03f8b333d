"""Behaviours of planned motion, of the gripper, and of the position afterwards."""

import math

from armdrive.arm import Arm
from armdrive.config.arm import ArmConfig
from armdrive.errors import OutOfBounds
from armdrive.status import State, Trust
from kinematics import Motors

from .behaviour import ALSO_UDP, cartesian, finger_motor, grip_switch, row, rows_of
from .bench import Bench
from .motions import begin_joints, check_refused, joints_from, shifted
from .observation import ON_THE_STEP, Observation, Point, check, place, rests_within

PATIENCE_S = 60.0
FINGERS_MM = 1.0
LINE_MM = 110.0
"""A motion straight in joint space would leave a line of this length by some 6 mm."""


def check_arrived(bench: Bench, arm: Arm) -> None:
    """Check that a standing arm is referenced where the physical motors and the read-back are."""
    arm.parts.look()
    status, seen = arm.status, bench.look()
    check(status.state is State.STANDBY, f"in {status.state} after a motion")
    check(status.trust is Trust.REFERENCED, f"{status.trust}: {status.trust_reason}")
    check(status.commanded == status.acknowledged, "not acknowledged where it was commanded")
    check(
        status.read_back == status.acknowledged,
        f"read back at {status.read_back}, acknowledged at {status.acknowledged}",
    )
    off = seen.off_steps(status.acknowledged)
    check(
        off <= max(ON_THE_STEP, rests_within(bench.config.device)),
        f"the motors are {off} steps from the acknowledged position",
    )


def check_moves(bench: Bench, arm: Arm) -> None:
    """Check that the arm moves a little, and knows where it is then."""
    arm.move_j(**joints_from(arm, -1.0, 0.5))
    check_arrived(bench, arm)


def check_between(seen: Observation, start: Motors, goal: Motors) -> None:
    """Check that no motor is outside of where it was commanded from and to."""
    for here, a, b in zip(seen.motors, start, goal, strict=True):
        inside = min(a, b) - ON_THE_STEP <= here <= max(a, b) + ON_THE_STEP
        check(inside, f"a motor was at {here}, and was commanded from {a} to {b}")


@row(
    "a joint motion arrives, and its read-back says so",
    "move",
    watched=True,
    smoke=True,
    transports=ALSO_UDP,
)
def a_joint_motion_arrives(bench: Bench) -> None:
    """No motor leaves the range between start and goal, so none overshoots."""
    arm = bench.ready()
    start, goal = bench.look().motors, joints_from(arm)
    handle = begin_joints(arm)
    seen = list(bench.watch(lambda: handle.done, PATIENCE_S))
    handle.wait()
    check_arrived(bench, arm)
    end = bench.look().motors
    reached, _ = bench.posture(end)
    for name, wanted_deg in goal.items():
        off = abs(reached.deg[name.removesuffix("_deg")] - wanted_deg)
        check(off <= 0.5, f"{name} is {off:.2f} degrees off")
    for each in seen:
        check_between(each, start, end)
    if bench.sees_motion:
        check(len({each.motors for each in seen}) > 2, "the arm was never seen on its way")


@row("there and back leaves no drift, and a slower speed takes longer", "move", watched=True)
def there_and_back_is_no_drift(bench: Bench) -> None:
    arm = bench.ready()
    start = bench.look().motors
    here = {f"{name}_deg": angle for name, angle in arm.joints.deg.items()}
    for _ in range(2):
        arm.move_j(**joints_from(arm, 1.3, -0.7))
        arm.move_j(**here)
    fast = arm.move_j(**joints_from(arm, 8.0, -4.0))
    slow = arm.move_j(**here, speed=0.3)
    check(
        slow.duration_s > 1.5 * fast.duration_s,
        f"at speed 0.3 it took {slow.duration_s:.2f} s, at full speed {fast.duration_s:.2f} s",
    )
    check_arrived(bench, arm)
    off = bench.look().off_steps(start)
    check(off <= ON_THE_STEP, f"three times there and back, and {off} steps off")


@row("beyond a limit nothing moves", "move", watched=True)
def beyond_a_limit_nothing_moves(bench: Bench) -> None:
    arm = bench.ready()
    name = arm.model.arm.joint_names[0]
    beyond = math.degrees(arm.model.arm.limits[0].high_rad) + 5.0
    with bench.check_unmoved("a refused motion"):
        refusal = check_refused(
            lambda: arm.move_j(**{f"{name}_deg": beyond}), OutOfBounds, "beyond a limit"
        )
        bench.sleep(0.3)
    check(name in str(refusal), f"the refusal does not name the joint: {refusal}")


@row("a Cartesian goal is reached", "Cartesian", needs=(cartesian,), watched=True)
def a_pose_is_reached(bench: Bench) -> None:
    arm = bench.ready()
    goal = shifted(arm.pose, y_mm=25.0, z_mm=-10.0)
    moved = arm.move_to(goal)
    check_arrived(bench, arm)
    seen = bench.look()
    off = math.dist(seen.tip, place(goal))
    allowed = moved.rounding_mm + bench.step_mm(seen.motors)
    check(off <= allowed, f"the tip is {off:.2f} mm from the goal, {allowed:.2f} mm announced")


@row("a line is straight within what is announced", "Cartesian", needs=(cartesian,))
def a_line_is_straight(bench: Bench) -> None:
    arm = bench.ready()
    arm.move_to(shifted(arm.pose, y_mm=-LINE_MM / 2.0))
    start = bench.look()
    goal = shifted(arm.pose, y_mm=LINE_MM, z_mm=-20.0)
    handle = arm.move_l(goal, wait=False)
    seen = [each.motors for each in bench.watch(lambda: handle.done, PATIENCE_S)]
    moved = handle.wait()
    check_arrived(bench, arm)
    allowed = line_allowance_mm(bench.config, bench.step_mm(start.motors), moved.deviation_mm)
    worst = max(off_line_mm(bench.tip(each), start.tip, place(goal)) for each in seen)
    check(worst <= allowed, f"the tip left the line by {worst:.2f} mm, {allowed:.2f} announced")
    check(len(set(seen)) > 4, "the arm was never seen on its way")


def line_allowance_mm(config: ArmConfig, step_mm: float, deviation_mm: float) -> float:
    """Return the announced deviation: the tolerance, a step, and the uncoordinated motors' part."""
    return config.motion.line_tolerance_mm + ON_THE_STEP * step_mm + deviation_mm


def off_line_mm(point: Point, start: Point, end: Point) -> float:
    """Return the distance of a point from a line segment, which may have no length."""
    way = [b - a for a, b in zip(start, end, strict=True)]
    at = [b - a for a, b in zip(start, point, strict=True)]
    length = math.fsum(each * each for each in way)
    share = math.fsum(a * b for a, b in zip(at, way, strict=True)) / length if length else 0.0
    nearest = [a + min(max(share, 0.0), 1.0) * each for a, each in zip(start, way, strict=True)]
    return math.dist(point, nearest)


@row("motors move by raw steps", "move", watched=True)
def motors_move_by_raw_steps(bench: Bench) -> None:
    arm = bench.connect()
    bench.switch_on(arm)
    before, trust = bench.look().motors, arm.status.trust
    steps = [0] * len(before)
    steps[0], steps[1] = 40, -25
    arm.move_motors(*steps)
    made = bench.look().motors - before
    off = max(abs(a - b) for a, b in zip(made, steps, strict=True))
    check(off <= ON_THE_STEP, f"asked for {steps}, made {tuple(made)}")
    check(arm.status.trust is trust, "raw steps gave the position a meaning")


@row("the fingers open and close", "gripper", needs=(finger_motor,), watched=True)
def fingers_open_and_close(bench: Bench) -> None:
    arm = bench.ready()
    before = bench.look()
    for opening_mm in (12.0, 24.0):
        arm.gripper.open(opening_mm)
        check_arrived(bench, arm)
        off = abs(bench.look().opening_mm - opening_mm)
        check(off <= FINGERS_MM, f"the fingers are {off:.1f} mm from {opening_mm} mm")
    check(bench.look().off_mm(before) <= bench.step_mm(before.motors), "the tip moved with them")


@row("a grasp of nothing measures 0 mm", "gripper", needs=(finger_motor, grip_switch))
def a_grasp_of_nothing_measures_0_mm(bench: Bench) -> None:
    arm = bench.ready()
    arm.gripper.open(10.0)
    width_mm = arm.gripper.grasp()
    check(width_mm == 0.0, f"nothing between the fingers, and the grasp measured {width_mm:.1f} mm")
    check(bench.look().opening_mm <= FINGERS_MM, "the fingers did not close")
    arm.gripper.open(15.0)
    check_arrived(bench, arm)


ROWS = rows_of(globals())
