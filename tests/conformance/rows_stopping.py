"""Behaviours of stopping, the emergency stop, and switching the motors off."""

from __future__ import annotations

from collections.abc import Callable

from armdrive.abilities import HELD
from armdrive.arm import Arm
from armdrive.errors import ArmError, NotReferenced, Stopped, WrongState
from armdrive.status import Current, State, Status, Trust

from .behaviour import Behaviour, cartesian, switches_current
from .bench import Bench
from .motions import (
    begin_sweep,
    check_refused,
    jog_first_joint,
    joints_from,
    planned_motions,
    shifted,
)
from .observation import ON_THE_STEP, Standstill, check
from .rows_moving import check_arrived

PATIENCE_S = 60.0
MOVES_S = 10.0


def wait_until_moving(bench: Bench) -> None:
    """Wait until the physical arm moves."""
    start = bench.look().motors
    for _ in bench.watch(lambda: bench.look().motors != start, MOVES_S):
        pass


def check_within_bound(bench: Bench, status: Status, rest: Standstill, what: str) -> None:
    """Check how the arm came to rest against the bounds that the status had announced."""
    if not bench.punctual:
        return
    time_s = status.stop_time_s + bench.noise_s
    check(rest.after_s <= time_s, f"{what}: it went on for {rest.after_s:.3f} s, not {time_s:.3f}")
    most_mm = status.stop_distance_mm + bench.step_mm(rest.end.motors)
    check(rest.way_mm <= most_mm, f"{what}: it went on for {rest.way_mm:.1f} mm, not {most_mm:.1f}")


def check_settled(bench: Bench, arm: Arm) -> None:
    """Check that a stopped arm knows where it is."""
    for _ in bench.watch(lambda: arm.status.state is State.STANDBY, MOVES_S):
        pass
    check_arrived(bench, arm)


def _stopped(bench: Bench, begin: Callable[[Arm], object]) -> None:
    arm = bench.ready()
    for after_s in bench.stops_after_s:
        begin(arm)
        wait_until_moving(bench)
        bench.sleep(after_s)
        status, seen = arm.status, bench.look()
        check(status.state is State.MOVING, f"in {status.state} in mid-motion")
        arm.request_stop()
        check_within_bound(bench, status, bench.rest(seen), f"stopped after {after_s} s")
        check_settled(bench, arm)
        arm.move_j(**{f"{name}_deg": 0.0 for name in arm.model.arm.joint_names[:1]})


def a_joint_motion_stops_within_its_bound(bench: Bench) -> None:
    _stopped(bench, begin_sweep)


def a_line_stops_within_its_bound(bench: Bench) -> None:
    _stopped(bench, lambda arm: arm.move_l(shifted(arm.pose, y_mm=110.0), wait=False))


def a_stop_ends_the_waiting_call(bench: Bench) -> None:
    arm = bench.ready()
    handle = begin_sweep(arm)
    wait_until_moving(bench)
    arm.stop()
    check(handle.done, "stop() returned, and the motion went on")
    check_refused(handle.wait, Stopped, "waiting for a stopped motion")
    bench.check_stands(0.5, "after stop()")
    arm.stop()
    arm.move_j(**joints_from(arm, -10.0, 5.0))
    check_arrived(bench, arm)


def an_emergency_stop_latches(bench: Bench) -> None:
    arm = bench.ready()
    begin_sweep(arm)
    wait_until_moving(bench)
    status, seen = arm.status, bench.look()
    arm.estop()
    check_within_bound(bench, status, bench.rest(seen), "emergency stop")
    check(arm.status.state is State.ERROR_STOP, f"in {arm.status.state}")
    calls = planned_motions(arm) | {
        "jog_j": lambda: jog_first_joint(arm),
        "enable": arm.enable,
        "home": lambda: arm.home(operator=lambda request: True),
    }
    if arm.status.trust is Trust.REFERENCED:
        for name, call in calls.items():
            check_refused(call, ArmError, f"{name} after an emergency stop")
    check_refused(calls["jog_j"], WrongState, "jog_j after an emergency stop")
    bench.check_stands(0.5, "after the emergency stop")


def leaving_an_emergency_stop_moves_nothing(bench: Bench) -> None:
    arm = bench.ready()
    begin_sweep(arm)
    wait_until_moving(bench)
    arm.estop()
    bench.rest()
    before = bench.look()
    arm.reset()
    bench.sleep(2.5)
    after = bench.look()
    if after.energised:
        check(after.motors == before.motors, "leaving the emergency stop moved the arm")
    check(arm.status.error == "", f"reset, and still: {arm.status.error}")
    bench.check_trust(arm)
    if not bench.real_time:  # a busy computer may make the position suspect
        held = bench.row.torque.estop.startswith(HELD)
        kept = arm.status.trust is Trust.REFERENCED
        check(kept is held, f"{arm.status.trust}, although the arm {bench.row.torque.estop}")
    bench.reference(arm)
    arm.move_j(**joints_from(arm, -10.0, 5.0))
    check_arrived(bench, arm)


def disabling_releases_the_motors(bench: Bench) -> None:
    arm = bench.ready()
    arm.disable()
    bench.sleep(0.3)
    status, seen = arm.status, bench.look()
    check(not seen.energised, "disabled, and the motors are held")
    check(status.current is Current.OFF, f"disabled, and the current is {status.current}")
    check(status.state is State.DISABLED, f"disabled, and in {status.state}")
    check(status.trust is Trust.SUSPECT, f"an arm that can sag is {status.trust}")
    check_refused(lambda: jog_first_joint(arm), WrongState, "a jog of a disabled arm")
    bench.check_stands(0.5, "disabled")
    arm.enable()
    check(arm.status.state is State.STANDBY, f"enabled, and in {arm.status.state}")
    check_refused(
        planned_motions(arm)["move_j"], NotReferenced, "a motion of an arm that may have sagged"
    )
    check(bench.look().motors == seen.motors, "enabling moved the arm")
    bench.reference(arm)
    arm.move_j(**joints_from(arm, 10.0, 5.0))
    off = bench.look().off_steps(arm.status.acknowledged)
    check(off <= ON_THE_STEP, f"enabled and referenced, and {off} steps off")
    check(bench.look().energised, "moved, and the motors are not held")


ROWS = (
    Behaviour("a joint motion stops within its bound", "stop",
              a_joint_motion_stops_within_its_bound),
    Behaviour("a line stops within its bound", "stop", a_line_stops_within_its_bound,
              needs=(cartesian,)),
    Behaviour("a stop ends the motion and the call that waits for it", "stop",
              a_stop_ends_the_waiting_call, watched=True),
    Behaviour("an emergency stop latches", "stop", an_emergency_stop_latches, watched=True,
              smoke=True),
    Behaviour("leaving an emergency stop moves nothing", "stop",
              leaving_an_emergency_stop_moves_nothing),
    Behaviour("disabling releases the motors, and the position becomes suspect", "power",
              disabling_releases_the_motors, needs=(switches_current,)),
)  # fmt: skip
