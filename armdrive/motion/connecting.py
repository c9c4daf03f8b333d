"""Connecting an arm, its motor current and its errors, idle polling, and a link that came back.

Here is decided what a saved position is worth when an arm connects (`believe_record`), what an
arm may believe after a lost link (`recover`), and when a standing arm is polled and its position is
saved (`Idling`). Nothing here moves the arm.
"""

from __future__ import annotations

import math
from typing import Any

from armdrive.abilities import Switching
from armdrive.errors import (
    DeviceFault,
    NoAnswer,
    StateFileError,
)
from armdrive.motion.context import (
    FRESH_S,
    MotionContext,
    be_remembered,
    weigh_difference,
    without_reset,
)
from armdrive.motion.device import compare_again, compare_settings
from armdrive.runtime.arm_state import LOCKED, RECONNECTED, Core, Message
from armdrive.runtime.states import Belief, Event, after
from armdrive.status import Current, Evidence, State, Trust
from armdrive.storage.record import Record
from armdrive.tasks import (
    ClearFault,
    Done,
    DropCurrent,
    Registers,
    RequestRejected,
    SleepUntil,
    SwitchOn,
    TaskBody,
)

# Connecting, and the motor current.


def believe_record(core: Core, now_s: float) -> Record | None:
    """Take up the trust of the saved position; return its record, if there is one to compare.

    This comes before the engine first reads the link, so that whatever the device reports is
    evidence about that position.
    """
    try:
        record = core.memory.load(
            core.config.name, core.config.calibration, core.controller.abilities.motors
        )
    except StateFileError as error:
        core.learn(Evidence.RECORD_UNUSABLE, now_s, str(error))
        return None
    if record is None or record.trust == Trust.UNKNOWN.value:
        core.learn(Evidence.NO_RECORD, now_s)
        return None
    core.learn(Evidence.RECORD_MATCHES, now_s)
    if record.trust == Trust.SUSPECT.value:
        core.belief = Belief(Trust.SUSPECT, record.reason, now_s)
    if record.in_motion:
        core.learn(Evidence.ENDED_IN_MOTION, now_s)
    return record


def connect(context: MotionContext, record: Record | None) -> TaskBody[None]:
    """Find the controller and restore the position of a record. Moves nothing."""
    try:
        yield from _connect(context, record)
    except NoAnswer as error:  # an arm that is not connected cannot be reset
        raise NoAnswer(f"{without_reset(error)}, then connect again") from None


def _connect(context: MotionContext, record: Record | None) -> TaskBody[None]:
    core = context.core
    registers = yield from _meet(context)
    switched = core.controller.abilities.current is Switching.BOTH
    core.happen(Event.OPENED_SWITCHED if switched else Event.OPENED_HELD)
    _take_up_position(context, record, registers)
    if core.error.words:  # reported meanwhile: a notice, because connecting latches no error
        core.report(core.error.words, core.error.code)
        core.error = Message()
    core.memory.taken_up()  # only now: a failed connection leaves the record as it was
    if core.belief.trust is Trust.SUSPECT:
        core.remember()  # otherwise registers that match by chance later would be trusted again
    core.still_since_s = context.now_s


def _meet(context: MotionContext) -> TaskBody[Registers]:
    """Find the controller, compare its settings, and return registers that were read just now."""
    registers = yield from context.ask_registers()
    yield from compare_settings(context)
    if context.now_s > context.looked_s + FRESH_S:  # reading settings takes some boards seconds
        registers = yield from context.ask_registers()
    return registers


def _compared(context: MotionContext, registers: Registers, same: bool) -> Evidence | None:
    """Return the evidence against a saved position; `same`: the registers agree with it.

    Registers that were zero before prove nothing if opening the link may have reset the board.
    """
    opening_reset = context.core.controller.opening_reset
    if not registers.positions.largest and (opening_reset or not same):
        return Evidence.CONTROLLER_RESTARTED
    return None if same else Evidence.RECORD_DIFFERS


def _take_up_position(context: MotionContext, record: Record | None, registers: Registers) -> None:
    core = context.core
    core.position.found(registers)
    if record is None:
        return
    same = core.position.restore(record, registers.positions)
    against = _compared(context, registers, same)
    if against is not None and not record.in_motion:  # which also explains why they differ
        core.learn(against, context.now_s)


def disable(context: MotionContext) -> TaskBody[None]:
    """Switch the motor current off. The arm can sag, so its position becomes suspect."""
    core = context.core
    after(core.state, Event.DISABLE)
    # the record first: if the program dies now, the next one must not trust an arm that sagged
    core.learn(Evidence.CURRENT_DROPPED, context.now_s)  # whatever the answer will be
    yield from be_remembered(context)  # without a mark: a full disk must not keep the motors on
    core.happen(Event.DISABLE)
    reply = yield from context.request(DropCurrent())
    if not isinstance(reply, Done):
        why = f" ({reply})" if isinstance(reply, RequestRejected) else ""
        words = (
            f"the controller did not confirm that the motor current is off{why}: look at the arm"
        )
        raise context.fault(DeviceFault(words))
    core.readings.current = Current.OFF
    registers = yield from context.ask_registers()
    core.position.rebase(registers.positions)  # they may have been zeroed, which moves nothing
    core.readings.sense(registers)
    core.mark_still()
    yield from be_remembered(context)


def enable(context: MotionContext) -> TaskBody[None]:
    """Switch the motor current on, if the device can, and allow motion. Moves nothing."""
    core = context.core
    after(core.state, Event.ENABLE)
    able = core.controller.abilities.current
    if able is Switching.BOTH or (able is Switching.DROPS and core.readings.current is Current.OFF):
        reply = yield from context.request(SwitchOn())
        if not isinstance(reply, Done):
            words = f"the controller did not switch the motors on: {reply}"
            raise context.fault(DeviceFault(words))
        context.require_no_fault()  # the arm may have sagged before the device answered
        core.withdraw(LOCKED)  # switching on has unlocked the device
        if able is Switching.BOTH:
            core.readings.current = Current.HELD
    yield from compare_again(context)
    core.happen(Event.ENABLE)


def reset(context: MotionContext) -> TaskBody[None]:
    """Leave error-stop: wait for a quiet line, then read the position. Moves nothing.

    If the device may have switched its motors off, the arm is disabled afterwards. If it reports
    something new meanwhile, the arm stays in error-stop.
    """
    core = context.core
    yield from context.quiet()  # an answer that is still on its way belongs to an earlier request
    reply = yield from context.request(ClearFault())
    if not isinstance(reply, Done):
        raise DeviceFault(f"the controller stays in its fault: {reply}")
    if not context.stopping:
        core.error = Message()
        core.withdraw()
    yield from compare_again(context)
    registers = yield from context.ask_registers()
    if context.stopping:
        raise context.stopped("a stop came during the reset: call `reset()` again")
    if core.error.words:  # reported after the device had cleared its fault
        raise DeviceFault(core.error.words)
    weigh_difference(context, core.position.compare(registers))
    switched = core.controller.abilities.current is Switching.BOTH
    off = switched and core.readings.current is not Current.HELD
    core.happen(Event.RESET_SWITCHED if off else Event.RESET)
    core.stops.found()
    core.still_since_s = context.now_s


# Idle work: what the engine does while no task is running.

INPUTS_POLL_S = 0.05  # poll interval while a call waits for an input


class Idling:
    """Tells the engine what to do while no task is running."""

    def __init__(self, context: MotionContext) -> None:
        self._context = context
        self._polled_s = 0.0

    def due(self, now_s: float) -> tuple[float, TaskBody[Any] | None]:
        """Return when to call again, and a task to run now, if any."""
        core = self._context.core
        core.report_write_errors()
        if core.state is State.STOPPING:  # no task is running, so the arm is at rest
            core.settle()
        if core.state not in (State.STANDBY, State.HOMING):
            return math.inf, None
        if now_s >= core.memory.due_s(core.still_since_s):
            core.mark_still()
            core.still_since_s = now_s  # if writing fails, try again later
        mark_s = core.memory.due_s(core.still_since_s)
        every_s = core.config.motion.idle_poll_s
        if core.readings.awaiting:
            every_s = min(every_s or INPUTS_POLL_S, INPUTS_POLL_S)
        if every_s == 0.0:
            return mark_s, None
        poll_s = max(self._polled_s, core.still_since_s) + every_s
        if now_s < poll_s:
            return min(poll_s, mark_s), None
        self._polled_s = now_s
        return now_s + every_s, self._context.look()


# Recovering a lost link. Moves nothing, and trusts little.
#
# The arm ends in error-stop, or disabled if it was disabled before. A latched error stays latched.
# The position is restored at best, because the arm may have been moved by hand meanwhile.

MEANWHILE = ". Meanwhile "
BACK = "the connection was lost and is back{elsewhere}: look at the arm, then call `reset()`"


def recover(context: MotionContext, lost_s: float, lost_link: str) -> TaskBody[None]:
    """Find the controller on a new link after the loss of the old one. Moves nothing.

    `lost_link` describes the old link; the error names the new one if it differs.
    """
    core = context.core
    stands_s = lost_s + core.stops.sent_s(core.controller)
    while context.now_s < stands_s and not context.stopping:  # the device finishes what it was sent
        yield SleepUntil(stands_s)
    core.withdraw()
    registers = yield from _meet(context)
    core.stops.found()
    was = core.before_loss
    if was is not State.DISABLED or core.readings.current is not Current.OFF:
        core.readings.current = Current.UNKNOWN
    _weigh(context, registers)
    core.readings.outputs = None
    core.happen(Event.OPENED_SWITCHED if was is State.DISABLED else Event.OPENED_HELD)
    link = context.engine.link.description
    _latch(core, was, BACK.format(elsewhere="" if link == lost_link else f", now {link}"))
    core.mark_still()
    core.still_since_s = context.now_s


def _weigh(context: MotionContext, registers: Registers) -> None:
    """Compare the registers with the position at the loss of the link."""
    core = context.core
    if core.belief.trust is Trust.UNKNOWN:
        core.position.found(registers)
        return
    core.readings.sense(registers)
    same = core.position.restore(core.record(in_motion=False), registers.positions)
    against = _compared(context, registers, same)
    core.learn(against or Evidence.LINK_BACK, context.now_s)


def _latch(core: Core, was: State, back: str) -> None:
    latched = core.latched
    if latched.words and latched.code != RECONNECTED:
        earlier = latched.words.partition(MEANWHILE)[0]  # of repeated losses, only the latest
        core.fault(f"{without_reset(earlier)}{MEANWHILE}{back}", latched.code)
    elif was is State.DISABLED:
        core.error = Message()
    else:
        core.fault(back, RECONNECTED)
