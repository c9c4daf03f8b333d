"""The tasks of an arm that stands, apart from referencing it. Nothing here moves the arm.

Connecting restores the recorded position. While the arm is idle, it is polled and its position is
saved. `enable`, `disable` and `reset` change its state, and a lost link is recovered. The settings
of the device are compared with the arm file, and its stored program and its outputs are written.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

from armdrive.abilities import OUTPUTS, Switching
from armdrive.errors import (
    ArmError,
    BadRequest,
    DeviceFault,
    LinkLost,
    NoAnswer,
    ProgramHalfWritten,
    Refused,
    SettingsDiffer,
    StateFileError,
    Stopped,
)
from armdrive.motion.context import (
    TRIES,
    MotionContext,
    be_remembered,
    weigh_difference,
    without_reset,
)
from armdrive.runtime.arm_state import RECONNECTED, Core, Message
from armdrive.runtime.states import Belief, Event, after
from armdrive.status import Current, Evidence, State, Trust
from armdrive.tasks import (
    ClearFault,
    DeviceProgram,
    DeviceSettings,
    Done,
    DropCurrent,
    Exchange,
    MendSetting,
    ReadProgram,
    ReadSettings,
    Registers,
    Reply,
    RequestRejected,
    SetOutputs,
    SleepUntil,
    SwitchOn,
    TaskBody,
    WriteRow,
)

# The settings of the device.


def compare_settings(wire: MotionContext) -> TaskBody[DeviceSettings]:
    """Compare the device's settings with the arm file; a difference keeps the arm from moving.

    A difference counts once it is read twice, because the line has no checksum.
    """
    core = wire.core
    reply, seen = (yield from _ask_settings(wire)), None
    for _ in range(TRIES):
        if not reply.differences or reply == seen:
            break
        seen, reply = reply, (yield from _ask_settings(wire))
    core.differences = reply.differences
    if reply.differences:
        core.notify(str(reply), SettingsDiffer(str(reply)))
    return reply


def compare_again(wire: MotionContext) -> TaskBody[None]:
    """Read the settings again if they kept the arm from moving: they may have been corrected."""
    if any(each.must for each in wire.core.differences):
        yield from compare_settings(wire)


def _ask_settings(wire: MotionContext) -> TaskBody[DeviceSettings]:
    reply = yield from wire.request(ReadSettings())
    if not isinstance(reply, DeviceSettings):
        words = f"the controller did not report its settings ({reply}): check the wire"
        raise wire.fault(DeviceFault(words))
    return reply


def mend_settings(wire: MotionContext, lines: tuple[str, ...]) -> TaskBody[DeviceSettings]:
    """Write the lines that the user has agreed to, one at a time, and compare again."""
    core = wire.core
    for line in lines:
        reply = yield from wire.request(MendSetting(line))
        if not isinstance(reply, Done):
            raise DeviceFault(f"the controller did not take `{line}`: {reply}")
    core.notify("")
    return (yield from compare_settings(wire))


# The stored program of a device. Nothing moves.
#
# The line has no checksum, and a row with a corrupted digit still looks valid. A program is
# therefore read until two readings agree, and written row by row, then read back.

Row = tuple[int, ...]
"""The words of one row; the first is its number."""

RowReport = Callable[[int], object]

READINGS = 5  # attempts until two readings in succession agree


def read_program(wire: MotionContext) -> TaskBody[tuple[Row, ...]]:
    """Return the program in the device's memory, after two equal readings. Raises `DeviceFault`."""
    seen: DeviceProgram | None = None
    trouble = "no two readings agree, so the line is noisy"
    for _ in range(READINGS):
        if wire.stopping:
            raise wire.stopped("reading the program was stopped")
        reply = yield from _asked(wire, ReadProgram())
        if isinstance(reply, DeviceProgram):
            if reply == seen:
                return reply.rows
            seen = reply
        else:
            trouble = str(reply)
    yield from wire.look()  # raises the right error if the arm does not answer at all
    raise DeviceFault(f"the program in the arm cannot be read: {trouble}. Try again")


def unreported(_: int) -> None:
    """Ignore a report about a written row."""


def write_program(
    wire: MotionContext, rows: Sequence[Row], *, leave_others: bool, report: RowReport = unreported
) -> TaskBody[int]:
    """Write rows into the device's memory; return the number of rows written.

    Rows that are already there are skipped; `report` is called with the number of each written row.
    Raises `Refused` if the memory has rows with other numbers, which cannot be deleted from here,
    unless `leave_others`; and `ProgramHalfWritten` if writing ends early or the memory differs
    afterwards.
    """
    before = yield from read_program(wire)
    others = tuple(row[0] for row in before if row[0] not in {row[0] for row in rows})
    if others and not leave_others:
        raise Refused(
            f"the arm's memory also has {named_rows(others)}, which would stay and run with the "
            "new program: clear them at the pendant, or allow them to stay"
        )
    missing = [row for row in rows if row not in before]
    written: list[int] = []
    try:
        for row in missing:
            yield from _write_row(wire, row)
            written.append(row[0])
            report(row[0])
        after = yield from read_program(wire)
    except ArmError as error:
        raise _half(error, written, missing) from error
    _compare(rows, before, after, written)
    return len(missing)


def _write_row(wire: MotionContext, row: Row) -> TaskBody[None]:
    """Write one row, repeating disturbed exchanges: writing a row twice changes nothing."""
    trouble: Reply | NoAnswer | None = None
    for _ in range(TRIES):
        if wire.stopping:
            raise wire.stopped("writing the program was stopped")
        trouble = yield from _asked(wire, WriteRow(row))
        if isinstance(trouble, Done):
            return
    if isinstance(trouble, NoAnswer):
        yield from wire.look()
        raise trouble
    raise DeviceFault(f"the arm refuses row {row[0]}: its memory is full, or the line is noisy")


def _asked(wire: MotionContext, request: ReadProgram | WriteRow) -> TaskBody[Reply | NoAnswer]:
    """Ask once; after a disturbance, wait for a quiet line and return the error."""
    try:
        reply: Reply = yield Exchange(request)
    except NoAnswer as error:
        yield from wire.quiet()
        return error
    if isinstance(reply, RequestRejected):
        yield from wire.quiet()
    return reply


def _compare(
    rows: Sequence[Row], before: Sequence[Row], after: Sequence[Row], written: list[int]
) -> None:
    """Raise unless the memory holds its previous rows and the written ones."""
    wanted = {row[0]: row for row in (*before, *rows)}
    found = {row[0]: row for row in after}
    wrong = tuple(n for n in sorted(wanted | found) if wanted.get(n) != found.get(n))
    if wrong:
        good = tuple(number for number in written if number not in wrong)
        raise ProgramHalfWritten(
            f"the arm's memory differs from what was written: {named_rows(wrong)}. Write again",
            written=good,
            doubtful=wrong,
        )


def _half(error: ArmError, written: list[int], missing: Sequence[Row]) -> ArmError:
    """Return the error of an incomplete write, which lists the rows that are in the arm."""
    under_way = tuple(row[0] for row in missing[len(written) : len(written) + 1])
    rest = tuple(row[0] for row in missing[len(written) + 1 :])
    is_in = f"{named_rows(written)} in the arm" if written else "nothing new in the arm"
    doubt = f", {named_rows(under_way)} perhaps" if under_way else ""
    old = f"; {named_rows(rest)} as before" if rest else ""
    remedy = (
        "plug in, connect again and write again" if isinstance(error, LinkLost) else "write again"
    )
    words = (
        f"the program was not written completely: {is_in}{doubt}{old}. To complete it, {remedy}. "
        f"The cause: {error}"
    )
    if isinstance(error, Stopped):
        return Stopped(words)
    return ProgramHalfWritten(words, written=tuple(written), doubtful=under_way)


def named_rows(numbers: Sequence[int]) -> str:
    """Name rows: `row 3`, or `rows 1 to 4`."""
    if len(numbers) == 1:
        return f"row {numbers[0]}"
    first, last = numbers[0], numbers[-1]
    if list(numbers) == list(range(first, last + 1)):
        return f"rows {first} to {last}"
    return f"rows {', '.join(map(str, numbers))}"


# Outputs.

MOST_OUTPUTS = (1 << OUTPUTS) - 1


def set_outputs(wire: MotionContext, bits: int) -> TaskBody[None]:
    """Write the output bits."""
    if isinstance(bits, bool) or not isinstance(bits, int) or not 0 <= bits <= MOST_OUTPUTS:
        raise BadRequest(f"outputs are a whole number from 0 to {MOST_OUTPUTS}, not {bits!r}")
    reply = yield from wire.request(SetOutputs(bits))
    if not isinstance(reply, Done):
        raise DeviceFault(f"the controller did not take the output bits {bits}: look at the arm")
    wire.core.readings.outputs = bits


# Connecting, and the motor current.


def connect(wire: MotionContext) -> TaskBody[None]:
    """Find the controller and restore the recorded position. Moves nothing."""
    try:
        yield from _connect(wire)
    except NoAnswer as error:  # an arm that is not connected cannot be reset
        raise NoAnswer(f"{without_reset(error)}, then connect again") from None


def _connect(wire: MotionContext) -> TaskBody[None]:
    core = wire.core
    registers = yield from wire.ask_registers()
    switched = core.controller.abilities.current is Switching.BOTH
    core.happen(Event.OPENED_SWITCHED if switched else Event.OPENED_HELD)
    _take_up_record(wire, registers)
    _apply_early_evidence(wire)
    yield from compare_settings(wire)
    core.memory.taken_up()  # only now: a failed connection leaves the record as it was
    if core.belief.trust is Trust.SUSPECT:
        core.remember()  # otherwise registers that match by chance later would be trusted again
    core.still_since_s = wire.now_s


def _take_up_record(wire: MotionContext, registers: Registers) -> None:
    core = wire.core
    core.position.found(registers)
    try:
        record = core.memory.load(
            core.config.name, core.config.calibration, len(registers.positions)
        )
    except StateFileError as error:
        core.learn(Evidence.RECORD_UNUSABLE, wire.now_s, str(error))
        return
    if record is None or record.trust == Trust.UNKNOWN.value:
        core.learn(Evidence.NO_RECORD, wire.now_s)
    else:
        same = core.position.restore(record, registers.positions)
        core.learn(Evidence.RECORD_MATCHES, wire.now_s)
        if record.trust == Trust.SUSPECT.value:
            core.belief = Belief(Trust.SUSPECT, record.reason, wire.now_s)
        if record.in_motion:  # this also explains why the registers differ
            core.learn(Evidence.ENDED_IN_MOTION, wire.now_s)
        elif not same:
            core.learn(Evidence.RECORD_DIFFERS, wire.now_s)


def _apply_early_evidence(wire: MotionContext) -> None:
    """Apply an alert that arrived before the record was read."""
    core = wire.core
    if core.early_evidence is not None:
        evidence, words = core.early_evidence
        core.learn(evidence, wire.now_s, words)
        core.error = Message()  # connecting latches no error
        core.notify(f"{evidence.value} ({words})", evidence)


def disable(wire: MotionContext) -> TaskBody[None]:
    """Switch the motor current off. The arm can sag, so its position becomes suspect."""
    core = wire.core
    after(core.state, Event.DISABLE)
    # the record first: if the program dies now, the next one must not trust an arm that sagged
    core.learn(Evidence.CURRENT_DROPPED, wire.now_s)  # whatever the answer will be
    yield from be_remembered(wire)  # without a mark: a full disk must not keep the motors on
    core.happen(Event.DISABLE)
    core.readings.current = Current.UNKNOWN
    reply = yield from wire.request(DropCurrent())
    if not isinstance(reply, Done):
        words = "the controller did not confirm that the motor current is off: look at the arm"
        raise wire.fault(DeviceFault(words))
    core.readings.current = Current.OFF
    registers = yield from wire.ask_registers()
    core.position.rebase(registers.positions)  # they may have been zeroed, which moves nothing
    core.readings.sense(registers)
    core.mark_still()
    yield from be_remembered(wire)


def enable(wire: MotionContext) -> TaskBody[None]:
    """Switch the motor current on, if the device can, and allow motion. Moves nothing."""
    core = wire.core
    after(core.state, Event.ENABLE)
    able = core.controller.abilities.current
    if able is Switching.BOTH or (able is Switching.DROPS and core.readings.current is Current.OFF):
        reply = yield from wire.request(SwitchOn())
        if not isinstance(reply, Done):
            words = f"the controller did not switch the motors on: {reply}"
            raise wire.fault(DeviceFault(words))
        wire.require_no_fault()  # the arm may have sagged before the device answered
        if able is Switching.BOTH:
            core.readings.current = Current.HELD
    yield from compare_again(wire)
    core.happen(Event.ENABLE)


def reset(wire: MotionContext) -> TaskBody[None]:
    """Leave error-stop: wait for a quiet line, then read the position. Moves nothing.

    If the device may have switched its motors off, the arm is disabled afterwards. If it reports
    something new meanwhile, the arm stays in error-stop.
    """
    core = wire.core
    yield from wire.quiet()  # an answer that is still on its way belongs to an earlier request
    reply = yield from wire.request(ClearFault())
    if not isinstance(reply, Done):
        raise DeviceFault(f"the controller stays in its fault: {reply}")
    if not wire.stopping:
        core.error = core.notice = Message()
    registers = yield from wire.ask_registers()
    if wire.stopping:
        raise wire.stopped("a stop came during the reset: call `reset()` again")
    if core.error.words:  # reported after the device had cleared its fault
        raise DeviceFault(core.error.words)
    weigh_difference(wire, core.position.compare(registers))
    yield from compare_again(wire)
    switched = core.controller.abilities.current is Switching.BOTH
    off = switched and core.readings.current is not Current.HELD
    core.happen(Event.RESET_SWITCHED if off else Event.RESET)
    core.still_since_s = wire.now_s


# Idle work: what the engine does while no task is running.

INPUTS_POLL_S = 0.05  # poll interval while a call waits for an input

STILL_S = 2.0
"""After this long at rest, remove the motion mark. Short stops do not write to the disk twice."""


class Idling:
    """Tells the engine what to do while no task is running."""

    def __init__(self, wire: MotionContext) -> None:
        self._wire = wire
        self._polled_s = 0.0

    def due(self, now_s: float) -> tuple[float, TaskBody[Any] | None]:
        """Return when to call again, and a task to run now, if any."""
        core = self._wire.core
        if core.state is State.STOPPING:  # no task is running, so the arm is at rest
            core.settle()
        if core.state not in (State.STANDBY, State.HOMING):
            return math.inf, None
        core.report_write_errors()
        if core.memory.owing and now_s >= core.still_since_s + STILL_S:
            core.mark_still()
            core.still_since_s = now_s  # if writing fails, try again later
        mark_s = core.still_since_s + STILL_S if core.memory.owing else math.inf
        every_s = core.config.motion.idle_poll_s
        if core.readings.awaiting:
            every_s = min(every_s or INPUTS_POLL_S, INPUTS_POLL_S)
        if every_s == 0.0:
            return mark_s, None
        poll_s = max(self._polled_s, core.still_since_s) + every_s
        if now_s < poll_s:
            return min(poll_s, mark_s), None
        self._polled_s = now_s
        return now_s + every_s, self._wire.look()


# Recovering a lost link. Moves nothing, and trusts little.
#
# The arm ends in error-stop, or disabled if it was disabled before. A latched error stays latched.
# The position is restored at best, because the arm may have been moved by hand meanwhile.

MEANWHILE = ". Meanwhile "
BACK = "the connection was lost and is back{elsewhere}: look at the arm, then call `reset()`"


def recover(wire: MotionContext, lost_s: float, lost_link: str) -> TaskBody[None]:
    """Find the controller on a new link after the loss of the old one. Moves nothing.

    `lost_link` describes the old link; the error names the new one if it differs.
    """
    core = wire.core
    stands_s = lost_s + core.stop_bound().silent_time_s
    while wire.now_s < stands_s and not wire.stopping:  # the device finishes what it was sent
        yield SleepUntil(stands_s)
    registers = yield from wire.ask_registers()
    core.stops.cut_off_s = 0.0
    was = core.before_loss
    if was is not State.DISABLED or core.readings.current is not Current.OFF:
        core.readings.current = Current.UNKNOWN
    _weigh(core, registers, wire.now_s)
    core.readings.outputs = None
    core.notify("")
    yield from compare_settings(wire)
    core.happen(Event.OPENED_SWITCHED if was is State.DISABLED else Event.OPENED_HELD)
    link = wire.engine.link.description
    _latch(core, was, BACK.format(elsewhere="" if link == lost_link else f", now {link}"))
    core.mark_still()
    core.still_since_s = wire.now_s


def _weigh(core: Core, registers: Registers, now_s: float) -> None:
    """Compare the registers with the position at the loss of the link."""
    if core.belief.trust is Trust.UNKNOWN:
        core.position.found(registers)
        return
    core.readings.sense(registers)
    same = core.position.restore(core.record(in_motion=False), registers.positions)
    if not same:
        core.learn(Evidence.RECORD_DIFFERS, now_s)
    else:
        core.learn(Evidence.LINK_BACK, now_s)


def _latch(core: Core, was: State, back: str) -> None:
    latched = core.latched
    if latched.words and latched.code != RECONNECTED:
        earlier = latched.words.partition(MEANWHILE)[0]  # of repeated losses, only the latest
        core.fault(f"{earlier}{MEANWHILE}{back}", latched.code)
    elif was is State.DISABLED:
        core.error = Message()
    else:
        core.fault(back, RECONNECTED)
