"""Behaviours of pausing, resuming and slowing: when and how fast the arm goes, never where."""

from __future__ import annotations

from armdrive.arm import Arm
from armdrive.arm.connected import Handle
from armdrive.errors import ArmError, Stopped, WrongState
from armdrive.motion.execute import Moved
from armdrive.status import Trust
from kinematics import Motors

from .behaviour import IN_SIMULATION, Behaviour, cartesian
from .bench import Bench
from .going import (
    begin_joints,
    begin_sweep,
    beside,
    first_jog,
    jog_first,
    motors_at_end,
    refused,
    sweep_plan,
)
from .rows_faults import between
from .rows_jogging import hold_until_under_way
from .rows_moving import PATIENCE_S, arrived, line_allowance_mm, off_line_mm
from .rows_stopping import settled, under_way
from .seen import ON_THE_STEP, Seen, check

STANDS_S = 1.0
SLOW, DOUBT = 0.2, 1.1
"""An override, and how much faster than that motors may seem to be."""
RATE_S = 1.0
RESTARTED_S = 4.0
"""A board whose power failed is back after this long, and has been looked at."""


def pause_within_bound(bench: Bench, arm: Arm) -> Seen:
    """Pause an arm in motion; check that it stands in time, and stays."""
    status, seen = arm.status, bench.look()
    arm.pause()
    rest = bench.rest(seen)
    time_s = status.silent_time_s + bench.noise_s
    check(rest.after_s <= time_s, f"paused, it went on for {rest.after_s:.3f} s, not {time_s:.3f}")
    most_mm = status.silent_distance_mm + bench.step_mm(rest.end.motors)
    check(rest.way_mm <= most_mm, f"paused, it went on for {rest.way_mm:.1f} mm, not {most_mm:.1f}")
    stood = bench.stands(STANDS_S, "paused")
    check(arm.status.paused, "the status does not say that it is paused")
    return stood


def paused_on_its_way(bench: Bench) -> tuple[Arm, Handle[Moved], Seen, Motors]:
    """Return an arm that is paused in a motion, its handle, its start, and where it shall end."""
    arm = bench.ready()
    start, goal = bench.look(), motors_at_end(arm)
    handle = begin_joints(arm)
    under_way(bench)
    stood = pause_within_bound(bench, arm)
    check(not handle.done, "a paused motion has ended")
    check(stood.motors not in (start.motors, goal), "it was not paused on its way")
    return arm, handle, start, goal


def a_paused_motion_goes_on_along_its_way(bench: Bench) -> None:
    arm, handle, start, goal = paused_on_its_way(bench)
    here = bench.look().motors
    arm.resume()
    for seen in bench.watch(lambda: handle.done, PATIENCE_S):
        between(seen, here, goal)
    handle.wait()
    arrived(bench, arm)
    off = bench.look().off_steps(goal)
    check(off <= ON_THE_STEP, f"paused and resumed, it ended {off} steps from its goal")
    check(not arm.status.paused, "resumed, and called paused")
    check(start.motors != goal, "the motion went nowhere")


def a_paused_line_stays_a_line(bench: Bench) -> None:
    arm = bench.ready()
    start = bench.look()
    goal = beside(arm.pose, y_mm=40.0, z_mm=-20.0)
    handle = arm.move_l(goal, wait=False)
    under_way(bench)
    pause_within_bound(bench, arm)
    check(not handle.done, "a paused line has ended")
    arm.resume()
    seen = [each.tip for each in bench.watch(lambda: handle.done, PATIENCE_S)]
    moved = handle.wait()
    arrived(bench, arm)
    allowed = line_allowance_mm(bench.config, bench.step_mm(start.motors), moved.straying_mm)
    end = goal.x_mm, goal.y_mm, goal.z_mm
    worst = max(off_line_mm(each, start.tip, end) for each in seen)
    check(worst <= allowed, f"resumed, it left its line by {worst:.2f} mm, {allowed:.2f} announced")


def a_stop_ends_a_pause(bench: Bench) -> None:
    arm, handle, *_ = paused_on_its_way(bench)
    arm.stop()
    refused(handle.wait, Stopped, "waiting for a motion that was paused and stopped")
    check(not arm.status.paused, "stopped, and still paused")
    arm.resume()
    bench.stands(STANDS_S, "resumed after a stop")
    settled(bench, arm)


def nothing_goes_on_where_something_changed(bench: Bench) -> None:
    """The power fails: the arm sags, and its controller knows nothing of the motion."""
    arm, handle, *_ = paused_on_its_way(bench)
    bench.fault("brown-out")
    bench.sleep(RESTARTED_S)
    before = bench.look()
    arm.resume()
    refused(handle.wait, ArmError, "a motion from where the arm no longer is")
    bench.sleep(STANDS_S)
    check(bench.look().motors == before.motors, "resumed, it moved from where it had sagged to")
    check(arm.status.trust is not Trust.REFERENCED, "it is referenced, and its power failed")


def a_pause_ends_a_jog(bench: Bench) -> None:
    arm = bench.ready()
    hold_until_under_way(bench, arm, first_jog(arm), 0.5)
    arm.hold(first_jog(arm), speed=0.5, for_s=1.0)
    pause_within_bound(bench, arm)
    before = bench.look()
    arm.hold(first_jog(arm), speed=0.5, for_s=STANDS_S)
    bench.sleep(STANDS_S)
    refused(lambda: jog_first(arm), WrongState, "a jog of a paused arm")
    arm.resume()
    bench.sleep(STANDS_S)
    check(bench.look().motors == before.motors, "a jog was made of a paused arm, or made up for")
    settled(bench, arm)


def steps_made(bench: Bench, for_s: float) -> float:
    """Return how many steps a second the first motor makes for a while."""
    start = bench.look()
    bench.sleep(for_s)
    end = bench.look()
    return abs(end.motors[0] - start.motors[0]) / (end.time_s - start.time_s)


def slowed_enough(slow: float, plan: tuple[Motors, Motors, float]) -> None:
    """Check a rate against what was asked: some devices lose much time between bursts."""
    start, goal, asked_s = plan
    asked = abs(goal[0] - start[0]) / asked_s
    most = SLOW * asked * DOUBT + ON_THE_STEP / RATE_S
    check(
        0.0 < slow <= most,
        f"at {SLOW:.0%} of {asked:.0f} steps a second it made {slow:.0f} of them",
    )


def an_override_slows_a_motion_under_way(bench: Bench) -> None:
    arm = bench.ready()
    plan = sweep_plan(arm)
    begin_sweep(arm)
    under_way(bench)
    full = steps_made(bench, RATE_S)
    arm.speed_override = SLOW
    bench.sleep(arm.status.silent_time_s + bench.noise_s)
    slow = steps_made(bench, RATE_S)
    slowed_enough(slow, plan)
    check(slow < full, f"slowed, it made {slow:.0f} steps a second, before that {full:.0f}")
    arm.stop()
    settled(bench, arm)


ROWS = (
    Behaviour("a paused motion goes on along its way", "pause",
              a_paused_motion_goes_on_along_its_way),
    Behaviour("a paused line stays a line", "pause", a_paused_line_stays_a_line,
              needs=(cartesian,)),
    Behaviour("a stop ends a pause and its motion", "pause", a_stop_ends_a_pause),
    Behaviour("a paused motion does not go on where something changed", "pause",
              nothing_goes_on_where_something_changed, transports=IN_SIMULATION),
    Behaviour("a pause ends a jog, and no other begins", "pause", a_pause_ends_a_jog),
    Behaviour("an override slows a motion under way", "speed",
              an_override_slows_a_motion_under_way),
)  # fmt: skip
