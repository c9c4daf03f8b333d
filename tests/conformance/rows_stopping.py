"""Behaviours of stopping, the emergency stop, and switching the motors off."""

from collections.abc import Callable

from armdrive.abilities import HELD
from armdrive.arm import Arm
from armdrive.arm.connected import Handle
from armdrive.errors import ArmError, NotReferenced, Stopped, WrongState
from armdrive.motion.execute import Moved
from armdrive.status import Current, State, Status, Trust

from .behaviour import ALSO_UDP, cartesian, row, rows_of, switches_current
from .bench import Bench
from .motions import begin_sweep, check_refused, jog_first_joint, planned_motions, shifted
from .observation import Standstill, check
from .rows_moving import check_arrived, check_moves

SETTLES_S = 10.0


def sweeping(bench: Bench, speed: float = 1.0, **options: object) -> tuple[Arm, Handle[Moved]]:
    """Return an arm on the bench in the middle of a motion, and the handle of that motion."""
    arm = bench.ready(**options)
    handle = begin_sweep(arm, speed=speed)
    bench.wait_until_moving()
    return arm, handle


def check_within_bound(
    bench: Bench, status: Status, rest: Standstill, what: str, *, silent: bool = False
) -> None:
    """Check how the arm came to rest against the bounds that the status had announced.

    `silent`: the bounds of a silent program hold, else those of a stop.
    """
    if not bench.punctual:
        return
    bound_s, bound_mm = (
        (status.silent_time_s, status.silent_distance_mm)
        if silent
        else (status.stop_time_s, status.stop_distance_mm)
    )
    time_s = bound_s + bench.noise_s
    check(rest.after_s <= time_s, f"{what}: it went on for {rest.after_s:.3f} s, not {time_s:.3f}")
    most_mm = bound_mm + bench.step_mm(rest.end.motors)
    check(rest.way_mm <= most_mm, f"{what}: it went on for {rest.way_mm:.1f} mm, not {most_mm:.1f}")


def check_settled(bench: Bench, arm: Arm) -> None:
    """Check that a stopped arm knows where it is."""
    bench.wait_until(lambda: arm.status.state is State.STANDBY, SETTLES_S)
    check_arrived(bench, arm)


def _stopped(bench: Bench, begin: Callable[[Arm], object]) -> None:
    arm = bench.ready()
    base = arm.model.arm.joint_names[0]
    for count, after_s in enumerate(bench.stops_after_s):
        if count:  # back to where there is room for another motion
            arm.move_j(**{f"{base}_deg": 0.0})
        begin(arm)
        bench.wait_until_moving()
        bench.sleep(after_s)
        status, seen = arm.status, bench.look()
        check(status.state is State.MOVING, f"in {status.state} in mid-motion")
        arm.request_stop()
        check_within_bound(bench, status, bench.rest(seen), f"stopped after {after_s} s")
        check_settled(bench, arm)


@row("a joint motion stops within its bound", "stop", transports=ALSO_UDP)
def a_joint_motion_stops_within_its_bound(bench: Bench) -> None:
    _stopped(bench, begin_sweep)


@row("a line stops within its bound", "stop", needs=(cartesian,))
def a_line_stops_within_its_bound(bench: Bench) -> None:
    _stopped(bench, lambda arm: arm.move_l(shifted(arm.pose, y_mm=110.0), wait=False))


@row("a stop ends the motion and the call that waits for it", "stop", watched=True)
def a_stop_ends_the_waiting_call(bench: Bench) -> None:
    arm, handle = sweeping(bench)
    arm.stop()
    check(handle.done, "stop() returned, and the motion went on")
    check_refused(handle.wait, Stopped, "waiting for a stopped motion")
    bench.check_stands(0.5, "after stop()")
    arm.stop()
    check_moves(bench, arm)


@row("an emergency stop latches, and leaving it moves nothing", "stop", watched=True, smoke=True)
def an_emergency_stop_latches(bench: Bench) -> None:
    arm, _ = sweeping(bench)
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
    if not bench.simulated:  # a real arm may have to be referenced by a person now
        return
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
    check_moves(bench, arm)


@row(
    "disabling releases the motors, and the position becomes suspect",
    "power",
    needs=(switches_current,),
)
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
    check_moves(bench, arm)
    check(bench.look().energised, "moved, and the motors are not held")


ROWS = rows_of(globals())
