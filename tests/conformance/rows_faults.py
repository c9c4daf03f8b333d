"""Behaviours under faults, over UDP too, and the law that holds for every fault at every moment.

Nothing moves that was not commanded. The call ends in time, with what was asked for or with a
typed error. The arm is not referenced where it does not stand. Once the fault is over, a reset (or
connecting again) and a reference make the arm work as before, and they move nothing.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import partial
from itertools import pairwise

from armdrive.arm import Arm
from armdrive.errors import ArmError
from armdrive.status import State, Trust
from kinematics import Motors

from .behaviour import IN_SIMULATION, Behaviour
from .bench import Bench
from .expected_errors import MOVING, STANDING, STRIKES_S, Moment, expected_error
from .faults import FAULTS, Fault
from .going import begin_joints, joints_from, motors_at_end
from .rows_connecting import connect_moves_nothing
from .rows_jogging import a_held_jog_expires_by_itself
from .rows_moving import a_joint_motion_arrives, arrived
from .rows_reconnecting import a_wire_that_is_back_moves_nothing
from .rows_stopping import a_joint_motion_stops_within_its_bound
from .seen import ON_THE_STEP, Seen, check

ENDS_S = 15.0
"""A motion of about a second that is disturbed has ended, well or not, after this long."""
IDLE_S = 3.0
"""A standing arm has been looked at by then, more than once."""
LOOK_S = 0.1
STATUSES = 4
"""The bound of a motion is announced at its beginning; so many looks take it in."""
NOTICED_S = 0.6
"""A single drive that is missing is noticed within this time; the others stop then."""
ENDED = (State.ERROR_STOP, State.DISCONNECTED)


def survives_in_motion(bench: Bench, fault: Fault) -> None:
    """Hold the law for a fault that comes while the arm moves."""
    for moment_s in bench.moments_s:
        bench.begin_anew()
        arm = _ready(bench)
        sagged = _disturbed(bench, arm, fault, moment_s)
        bench.heal()
        _aftermath(bench, arm, fault, sagged=sagged, reconnects=True)


def survives_while_idle(bench: Bench, fault: Fault) -> None:
    """Hold the law for a fault that comes while the arm stands."""
    arm = _ready(bench)
    before = bench.look()
    cause(bench, fault)
    sagged = False
    for _ in range(round(IDLE_S / LOOK_S)):
        bench.sleep(LOOK_S)
        seen = bench.look()
        sagged = sagged or not (seen.energised and seen.powered)
        check(sagged or seen.motors == before.motors, "a standing arm moved")
    reports_as_expected(bench, arm, fault, STANDING)
    bench.heal()
    _aftermath(bench, arm, fault, sagged=sagged)


def cause(bench: Bench, fault: Fault, after_s: float = 0.0) -> None:
    """Have a fault come, now or later."""
    when = f" @{after_s:g}" if after_s else ""
    for words in fault.words:
        bench.fault(words + when)


def _ready(bench: Bench) -> Arm:
    """Return an arm that is referenced, with registers that are not zero."""
    if bench.turned_by_hand():
        return bench.ready()
    arm = bench.ready()
    arm.move_j(**joints_from(arm, 3.0, -2.0))
    return arm


def _disturbed(bench: Bench, arm: Arm, fault: Fault, moment_s: float) -> bool:
    """Move, and be disturbed; tell whether the motors were without current at any time."""
    start = bench.look()
    cause(bench, fault, moment_s)
    goal = motors_at_end(arm)
    handle = begin_joints(arm)
    seen, silent_s = [], 0.0
    for each in bench.watch(lambda: handle.done, ENDS_S):
        seen.append(each)
        if len(seen) < STATUSES:
            silent_s = max(silent_s, arm.status.silent_time_s)
    error = _only_typed(handle.wait)
    rest = bench.rest(longest_s=ENDS_S)
    seen.append(rest.end)
    if moment_s == STRIKES_S and reports_as_expected(bench, arm, fault, MOVING, error):
        last_s = max(b.time_s for a, b in pairwise(seen) if a.motors != b.motors)
        on_s, most_s = last_s - start.time_s - moment_s, silent_s + NOTICED_S + bench.noise_s
        check(on_s <= most_s, f"it moved on for {on_s:.2f} s after the fault, not {most_s:.2f}")
    sagged = not all(each.energised for each in seen)
    if not (fault.strays(bench) or sagged):
        check(
            rest.after_s <= silent_s + bench.noise_s,
            f"the call had ended, and the arm moved on for {rest.after_s:.2f} s",
        )
        for each in seen:
            between(each, start.motors, goal)
    return sagged


def between(seen: Seen, start: Motors, goal: Motors) -> None:
    for here, a, b in zip(seen.motors, start, goal, strict=True):
        inside = min(a, b) - ON_THE_STEP <= here <= max(a, b) + ON_THE_STEP
        check(inside, f"a motor was at {here}, and was commanded from {a} to {b}")


def _only_typed(call: Callable[[], object]) -> str:
    """Let a call succeed, or fail with an error that says what is wrong; return its words."""
    try:
        call()
    except ArmError as error:
        check(bool(str(error)), f"{type(error).__name__} says nothing")
        return str(error)
    return ""


def reports_as_expected(
    bench: Bench, arm: Arm, fault: Fault, moment: Moment, error: str | None = None
) -> bool:
    """Check what is said of a fault, if the table of expected errors has a row for it.

    `error` are the words of the call that the fault ended. Real ports have words of their own.
    """
    expected = expected_error(bench.names, fault.name, moment)
    if expected is None or bench.real_time:
        return False
    status = arm.status
    for words in (status.error, *([] if error is None else [error])):
        check(re.search(expected.words, words) is not None, f"expected {expected.words}: {words}")
        check("garbled" not in words, f"a fault is taken for a garbled message: {words}")
    check(status.state in ENDED, f"{status.state} after: {fault.name}")
    check(status.error_code == expected.code, f"{status.error_code}, not {expected.code}")
    check(status.trust is expected.trust, f"{status.trust}, not {expected.trust}")
    check("refused a valid motion" not in status.trust_reason, status.trust_reason)
    return True


def _aftermath(
    bench: Bench, arm: Arm, fault: Fault, *, sagged: bool, reconnects: bool = False
) -> None:
    """Look at the arm that is left behind, bring it back, and have it work."""
    before = bench.look()
    bench.sleep(IDLE_S)
    if not (sagged or fault.strays(bench)):
        check(bench.look().motors == before.motors, "the arm moved by itself after the fault")
    if fault.evident:
        bench.honest(arm)
    arm = brought_back(bench, arm, reconnects=reconnects)
    bench.refer(arm)
    try:
        works(bench, arm)
    except ArmError:
        if not fault.strays(bench):
            raise
        # what was left in the device's ear has spoiled the first line: once more, then it is gone
        arm = brought_back(bench, arm)
        bench.refer(arm)
        works(bench, arm)


def works(bench: Bench, arm: Arm) -> None:
    arm.move_j(**joints_from(arm, -2.0, 1.0))
    arrived(bench, arm)


def brought_back(bench: Bench, arm: Arm, *, reconnects: bool = False) -> Arm:
    """Reset, or connect again where the wire broke; neither moves anything.

    The same program `reconnects`, or another one connects.
    """
    before = bench.look()
    if arm.status.state is State.DISCONNECTED and reconnects:
        arm.reconnect()
        check(arm.status.trust is not Trust.REFERENCED, "a position was trusted without asking")
        arm.reset()
    elif arm.status.state is State.DISCONNECTED:
        arm = bench.connect()
        check(arm.status.trust is not Trust.REFERENCED, "a position was trusted without asking")
    elif arm.status.state is State.ERROR_STOP:
        trust = arm.status.trust
        arm.reset()
        check(arm.status.state is not State.ERROR_STOP, "the reset left it in error-stop")
        trusted = arm.status.trust is Trust.REFERENCED and trust is not Trust.REFERENCED
        check(not trusted, f"the reset turned {trust} into a reference")
    bench.switch_on(arm)
    bench.sleep(0.5)
    check(bench.look().motors == before.motors, "bringing the arm back moved it")
    return arm


def replugged_under_another_name(bench: Bench) -> None:
    arm = bench.ready()
    arm.move_j(**joints_from(arm))
    bench.fault("unplug")
    bench.sleep(1.5)
    check(arm.status.state is State.DISCONNECTED, f"the cable is out: {arm.status.state}")
    bench.replug_elsewhere()
    arm = bench.connect()
    check(arm.status.trust is not Trust.REFERENCED, "a position was trusted without asking")
    bench.refer(arm)
    arm.move_j(**joints_from(arm, -10.0, 5.0))
    arrived(bench, arm)


DATAGRAMS = tuple(fault for fault in FAULTS if fault.name.startswith("a message "))
"""What a network does to a datagram, as faults of the simulator."""


def _udp(name: str, run: Callable[[Bench], None]) -> Behaviour:
    return Behaviour(f"over UDP, {name}", "UDP", run, transports=("udp",))


OVER_UDP = (
    _udp("connecting, idling and leaving move nothing", connect_moves_nothing),
    _udp("a joint motion arrives", a_joint_motion_arrives),
    _udp("a joint motion stops within its bound", a_joint_motion_stops_within_its_bound),
    _udp("a held jog expires by itself", a_held_jog_expires_by_itself),
    _udp("a port that was closed and is back moves nothing", a_wire_that_is_back_moves_nothing),
    *(_udp(each.name, partial(survives_in_motion, fault=each)) for each in DATAGRAMS),
)

ROWS = (
    *(
        Behaviour(f"{fault.name}, in motion", "fault", partial(survives_in_motion, fault=fault),
                  needs=fault.needs, transports=IN_SIMULATION)
        for fault in FAULTS
    ),
    *(
        Behaviour(f"{fault.name}, standing", "fault", partial(survives_while_idle, fault=fault),
                  needs=fault.needs, transports=IN_SIMULATION)
        for fault in FAULTS
        if fault.idle
    ),
    Behaviour("plugged in again under another name", "fault", replugged_under_another_name,
              transports=("memory", "pty")),
    *OVER_UDP,
)  # fmt: skip
