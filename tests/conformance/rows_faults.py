"""Behaviours under faults, and the law that holds for every fault at every moment.

Nothing moves without a command. The call ends in time, with its result or with a typed error. The
arm is not referenced where it does not stand. Once the fault is over, a reset (or a new connection)
and a reference make the arm work as before; they move nothing.
"""

import re
from collections.abc import Callable
from functools import partial
from itertools import pairwise

from armdrive.arm import Arm
from armdrive.errors import ArmError
from armdrive.status import State, Trust
from tests.scenarios.happenings import HAPPENINGS, Effect, Happening

from .behaviour import IN_SIMULATION, Behaviour, bytes_on_wire
from .bench import Bench
from .faults import MOVING, RULES, STANDING, STRIKES_S, Moment, expected_error, misdirects
from .motions import begin_joints, joints_from, motors_at_end
from .observation import check
from .rows_moving import check_between, check_moves

ENDS_S = 15.0
"""A disturbed motion of about a second has ended within this time, with or without success."""
IDLE_S = 3.0
"""The driver polls a standing arm more than once within this time, and the latest message of all
faults (2.5 s) has arrived: whatever it makes the arm do has begun."""
LOOK_S = 0.1
STATUSES = 4
"""How many looks at the start of a motion read its announced bound."""
NOTICED_S = 0.6
"""The driver notices a missing drive within this time, and stops the others."""
ENDED = (State.ERROR_STOP, State.DISCONNECTED)


def survives(bench: Bench, fault: Happening) -> None:
    """Check the law for a fault that strikes a standing arm, and a moving one, each time anew."""
    for moment_s in bench.fault_moments_s:
        if moment_s is STANDING and not fault.idle:
            continue
        bench.start_afresh()
        arm = _ready(bench)
        if moment_s is STANDING:
            sagged = _stand_under(bench, arm, fault)
        else:
            sagged = _move_under(bench, arm, fault, moment_s)
        bench.heal()
        _check_recovery(bench, arm, fault, sagged=sagged, reconnects=moment_s is not STANDING)


def _stand_under(bench: Bench, arm: Arm, fault: Happening) -> bool:
    """Let an arm stand under a fault; return whether the motors lost their current."""
    before = bench.look()
    inject(bench, fault)
    sagged = False
    for _ in range(round(IDLE_S / LOOK_S)):
        bench.sleep(LOOK_S)
        seen = bench.look()
        sagged = sagged or not (seen.energised and seen.powered)
        check(sagged or seen.motors == before.motors, "a standing arm moved")
    reports_as_expected(bench, arm, fault, STANDING)
    return sagged


def inject(bench: Bench, fault: Happening, after_s: float = 0.0) -> None:
    """Inject a fault, now or later."""
    when = f" @{after_s:g}" if after_s else ""
    for words in fault.words:
        bench.fault(words + when)


def _ready(bench: Bench) -> Arm:
    """Return a referenced arm whose registers are not zero, so that a reset shows.

    It stands in the direction of the motions that follow, which so do not pass zero.
    """
    by_hand = bench.turn_by_hand()
    arm = bench.ready()
    if not by_hand:
        arm.move_j(**joints_from(arm, 3.0, -2.0))
    return arm


def _move_under(bench: Bench, arm: Arm, fault: Happening, moment_s: float) -> bool:
    """Move the arm under a fault; return whether the motors lost their current at any time."""
    start = bench.look()
    inject(bench, fault, moment_s)
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
    if not (misdirects(fault, bench) or sagged):
        check(
            rest.after_s <= silent_s + bench.noise_s,
            f"the call had ended, and the arm moved on for {rest.after_s:.2f} s",
        )
        for each in seen:
            check_between(each, start.motors, goal)
    return sagged


def _only_typed(call: Callable[[], object]) -> str:
    """Make a call that may raise a typed error with words; return these words."""
    try:
        call()
    except ArmError as error:
        check(bool(str(error)), f"{type(error).__name__} says nothing")
        return str(error)
    return ""


def reports_as_expected(
    bench: Bench, arm: Arm, fault: Happening, moment: Moment, error: str | None = None
) -> bool:
    """Check the error that is reported, if the table of expected errors has a row for the fault.

    Return whether it has. `error` has the words of the call that the fault ended. Real ports have
    words of their own, which are not checked.
    """
    expected = expected_error(bench.names, fault.name, moment)
    if expected is None or bench.real_time:
        return False
    status = arm.status
    for words in (status.error, *([] if error is None else [error])):
        check(re.search(expected.words, words) is not None, f"expected {expected.words}: {words}")
        check("garbled" not in words, f"a fault is taken for a garbled message: {words}")
    check(status.state in ENDED, f"{status.state} after: {fault.name}")
    code = status.error_code
    check(re.fullmatch(expected.code, code) is not None, f"{code}, not {expected.code}")
    check(status.trust is expected.trust, f"{status.trust}, not {expected.trust}")
    check("refused a valid motion" not in status.trust_reason, status.trust_reason)
    return True


def _check_recovery(
    bench: Bench, arm: Arm, fault: Happening, *, sagged: bool, reconnects: bool = False
) -> None:
    """Check the arm after the fault, bring it back, and check that it moves."""
    before = bench.look()
    bench.sleep(IDLE_S)
    if not (sagged or misdirects(fault, bench)):
        check(bench.look().motors == before.motors, "the arm moved by itself after the fault")
    if fault.effect is not Effect.SLIPS:  # a stepper gives no evidence of that
        bench.check_trust(arm)
    arm = bring_back(bench, arm, reconnects=reconnects)
    bench.reference(arm)
    try:
        check_moves(bench, arm)
    except ArmError:
        if not misdirects(fault, bench):
            raise
        # a damaged line in the device's buffer may spoil the first motion after a fault
        arm = bring_back(bench, arm)
        bench.reference(arm)
        check_moves(bench, arm)


def bring_back(bench: Bench, arm: Arm, *, reconnects: bool = False) -> Arm:
    """Reset the arm, or connect again after a lost wire; check that neither moves anything.

    `reconnects`: the same program reconnects, else another one connects.
    """
    before = bench.look()
    if arm.status.state is State.DISCONNECTED and reconnects:
        arm.reconnect()
        check(
            arm.status.trust is not Trust.REFERENCED,
            "a position was trusted without a confirmation",
        )
        arm.reset()
    elif arm.status.state is State.DISCONNECTED:
        arm = bench.connect()
        check(
            arm.status.trust is not Trust.REFERENCED,
            "a position was trusted without a confirmation",
        )
    elif arm.status.state is State.ERROR_STOP:
        trust = arm.status.trust
        arm.reset()
        check(arm.status.state is not State.ERROR_STOP, "the reset left it in error-stop")
        trusted = arm.status.trust is Trust.REFERENCED and trust is not Trust.REFERENCED
        check(not trusted, f"the reset turned {trust} into a reference")
    bench.switch_on(arm)
    bench.sleep(0.5)
    moved = bench.look().off_steps(before.motors)
    check(moved <= bench.settles_steps, f"bringing the arm back moved it by {moved} steps")
    return arm


def replugged_under_another_name(bench: Bench) -> None:
    arm = bench.ready()
    check_moves(bench, arm)
    bench.fault("unplug")
    bench.sleep(1.5)
    check(arm.status.state is State.DISCONNECTED, f"the cable is out: {arm.status.state}")
    bench.replug_elsewhere()
    arm = bench.connect()
    check(arm.status.trust is not Trust.REFERENCED, "a position was trusted without a confirmation")
    bench.reference(arm)
    check_moves(bench, arm)


DATAGRAMS = "a message "
"""What the faults begin with that a network can cause."""

ROWS = (
    *(
        Behaviour(
            fault.name,
            "fault",
            partial(survives, fault=fault),
            needs=(*RULES[fault.needs], *([bytes_on_wire] if fault.of_bytes else [])),
            transports=(*IN_SIMULATION, *(["udp"] if fault.name.startswith(DATAGRAMS) else [])),
            fault=fault,
        )
        for fault in HAPPENINGS
    ),
    Behaviour(
        "the cable is back under another port name",
        "fault",
        replugged_under_another_name,
        transports=("memory", "pty"),
    ),
)
