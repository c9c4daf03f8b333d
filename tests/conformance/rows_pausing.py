"""Behaviours of pausing, resuming and slowing, which change the time of a motion, not its path."""

from armdrive.arm import Arm
from armdrive.arm.connected import Handle
from armdrive.errors import ArmError, Stopped, WrongState
from armdrive.motion.execute import Moved
from armdrive.status import Trust
from kinematics import Motors

from .behaviour import IN_SIMULATION, cartesian, row, rows_of
from .bench import Bench
from .motions import (
    begin_joints,
    begin_sweep,
    check_refused,
    jog_first_joint,
    motors_at_end,
    shifted,
    sweep_plan,
    sweeping_jog,
)
from .observation import ON_THE_STEP, Observation, check, place
from .rows_jogging import hold_until_under_way
from .rows_moving import (
    PATIENCE_S,
    check_arrived,
    check_between,
    line_allowance_mm,
    off_line_mm,
)
from .rows_stopping import check_settled, check_within_bound

STANDS_S = 1.0
SLOW, TOLERANCE = 0.2, 1.1
"""A speed override, and the tolerance of a measured rate."""
RATE_S = 1.0
RESTARTED_S = 4.0
"""After this time a board has booted again, and the driver has polled it."""


def pause_within_bound(bench: Bench, arm: Arm) -> Observation:
    """Pause a moving arm, and check that it stands in time and stays."""
    status, seen = arm.status, bench.look()
    arm.pause()
    rest = bench.rest(seen)
    check_within_bound(bench, status, rest, "paused", silent=True)
    stood = bench.check_stands(STANDS_S, "paused")
    check(arm.status.paused, "the status does not say that it is paused")
    return stood


def pause_on_the_way(bench: Bench) -> tuple[Arm, Handle[Moved], Observation, Motors]:
    """Return an arm that is paused in a motion, with the handle, the start and the goal."""
    arm = bench.ready()
    start, goal = bench.look(), motors_at_end(arm)
    handle = begin_joints(arm)
    bench.wait_until_moving()
    stood = pause_within_bound(bench, arm)
    check(not handle.done, "a paused motion has ended")
    check(stood.motors not in (start.motors, goal), "it was not paused on its way")
    return arm, handle, start, goal


@row("a paused motion resumes along its path", "pause")
def a_paused_motion_resumes_along_its_path(bench: Bench) -> None:
    arm, handle, start, goal = pause_on_the_way(bench)
    here = bench.look().motors
    arm.resume()
    for seen in bench.watch(lambda: handle.done, PATIENCE_S):
        check_between(seen, here, goal)
    handle.wait()
    check_arrived(bench, arm)
    off = bench.look().off_steps(goal)
    check(off <= ON_THE_STEP, f"paused and resumed, it ended {off} steps from its goal")
    check(not arm.status.paused, "resumed, and called paused")
    check(start.motors != goal, "the motion went nowhere")


@row("a paused line stays a line", "pause", needs=(cartesian,))
def a_paused_line_stays_a_line(bench: Bench) -> None:
    arm = bench.ready()
    start = bench.look()
    goal = shifted(arm.pose, y_mm=40.0, z_mm=-20.0)
    handle = arm.move_l(goal, wait=False)
    bench.wait_until_moving()
    pause_within_bound(bench, arm)
    check(not handle.done, "a paused line has ended")
    arm.resume()
    seen = [each.tip for each in bench.watch(lambda: handle.done, PATIENCE_S)]
    moved = handle.wait()
    check_arrived(bench, arm)
    allowed = line_allowance_mm(bench.config, bench.step_mm(start.motors), moved.deviation_mm)
    worst = max(off_line_mm(each, start.tip, place(goal)) for each in seen)
    check(worst <= allowed, f"resumed, it left its line by {worst:.2f} mm, {allowed:.2f} announced")


@row("a stop ends a pause and its motion", "pause")
def a_stop_ends_a_pause(bench: Bench) -> None:
    arm, handle, *_ = pause_on_the_way(bench)
    arm.stop()
    check_refused(handle.wait, Stopped, "waiting for a motion that was paused and stopped")
    check(not arm.status.paused, "stopped, and still paused")
    arm.resume()
    bench.check_stands(STANDS_S, "resumed after a stop")
    check_settled(bench, arm)


@row("a paused motion does not resume after a power failure", "pause", transports=IN_SIMULATION)
def a_paused_motion_does_not_resume_after_a_power_failure(bench: Bench) -> None:
    """The arm sags, and its controller has forgotten the motion."""
    arm, handle, *_ = pause_on_the_way(bench)
    bench.fault("brown-out")
    bench.sleep(RESTARTED_S)
    before = bench.look()
    arm.resume()
    check_refused(handle.wait, ArmError, "a motion from a place where the arm is no longer")
    bench.sleep(STANDS_S)
    check(bench.look().motors == before.motors, "resumed, it moved after it had sagged")
    check(arm.status.trust is not Trust.REFERENCED, "its power failed, and it is referenced")


@row("a pause ends a jog and blocks new ones", "pause")
def a_pause_ends_a_jog(bench: Bench) -> None:
    arm = bench.ready()
    hold_until_under_way(bench, arm, sweeping_jog(arm), 0.5)
    arm.jogging.hold(sweeping_jog(arm), speed=0.5, for_s=1.0)
    pause_within_bound(bench, arm)
    before = bench.look()
    arm.jogging.hold(sweeping_jog(arm), speed=0.5, for_s=STANDS_S)
    bench.sleep(STANDS_S)
    check_refused(lambda: jog_first_joint(arm), WrongState, "a jog of a paused arm")
    arm.resume()
    bench.sleep(STANDS_S)
    check(bench.look().motors == before.motors, "a paused arm was jogged, or made up for a jog")
    check_settled(bench, arm)


def step_rate_hz(bench: Bench, for_s: float) -> float:
    """Return how many steps per second the first motor makes, over a time."""
    start = bench.look()
    bench.sleep(for_s)
    end = bench.look()
    return abs(end.motors[0] - start.motors[0]) / (end.time_s - start.time_s)


def check_slowed(slow: float, plan: tuple[Motors, Motors, float]) -> None:
    """Check a rate in steps/s against the override; some devices lose much time between bursts."""
    start, goal, asked_s = plan
    asked = abs(goal[0] - start[0]) / asked_s
    most = SLOW * asked * TOLERANCE + ON_THE_STEP / RATE_S
    check(
        0.0 < slow <= most,
        f"at {SLOW:.0%} of {asked:.0f} steps a second it made {slow:.0f} of them",
    )


@row("a speed override slows a motion under way", "speed")
def an_override_slows_a_motion_under_way(bench: Bench) -> None:
    arm = bench.ready()
    plan = sweep_plan(arm)
    begin_sweep(arm)
    bench.wait_until_moving()
    full = step_rate_hz(bench, RATE_S)
    arm.speed_override = SLOW
    bench.sleep(arm.status.silent_time_s + bench.noise_s)
    slow = step_rate_hz(bench, RATE_S)
    check_slowed(slow, plan)
    check(slow < full, f"slowed, it made {slow:.0f} steps a second, before that {full:.0f}")
    arm.stop()
    check_settled(bench, arm)


ROWS = rows_of(globals())
