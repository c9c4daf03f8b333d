"""The settings, the stored program and the outputs of a device.

The settings are compared with the arm file and fixed, the program is read and written, and outputs
are switched. Nothing here moves the arm.
"""

from __future__ import annotations

from collections.abc import Sequence

from armdrive.errors import (
    ArmError,
    BadRequest,
    DeviceFault,
    NoAnswer,
    ProgramHalfWritten,
    Refused,
    SettingsDiffer,
    Stopped,
)
from armdrive.motion.context import TRIES, MotionContext
from armdrive.runtime.arm_state import Core
from armdrive.tasks import (
    DeviceProgram,
    DeviceSettings,
    Done,
    Exchange,
    FixSetting,
    ReadProgram,
    ReadSettings,
    Reply,
    RequestRejected,
    SetOutputs,
    TaskBody,
    WriteRow,
)
from kinematics.text import counted

# The settings of the device.


def compare_settings(context: MotionContext) -> TaskBody[DeviceSettings]:
    """Compare the device's settings with the arm file; a difference keeps the arm from moving.

    A difference counts once it is read twice, because the line has no checksum.
    """
    core = context.core
    reply, seen = (yield from _ask_settings(context)), None
    for _ in range(TRIES):
        if not reply.differences or reply == seen:
            break
        seen, reply = reply, (yield from _ask_settings(context))
    core.differences = reply.differences
    if reply.differences:
        core.report(str(reply), SettingsDiffer.code)
    else:
        core.withdraw(SettingsDiffer.code)
    return reply


def compare_again(context: MotionContext) -> TaskBody[None]:
    """Read the settings again if they forbade something: they may have been corrected."""
    if any(each.forbids for each in context.core.differences):
        yield from compare_settings(context)


def _ask_settings(context: MotionContext) -> TaskBody[DeviceSettings]:
    reply = yield from context.request(ReadSettings())
    if not isinstance(reply, DeviceSettings):
        words = f"the controller did not report its settings ({reply}): check the wire"
        raise context.fault(DeviceFault(words))
    return reply


def fix_settings(context: MotionContext, lines: tuple[str, ...]) -> TaskBody[DeviceSettings]:
    """Write the lines that the user has agreed to, one at a time, and compare again."""
    for line in lines:
        reply = yield from context.request(FixSetting(line))
        if not isinstance(reply, Done):
            raise DeviceFault(f"the controller did not take `{line}`: {reply}")
    return (yield from compare_settings(context))


# The stored program of a device. Nothing moves.
#
# The line has no checksum, and a row with a corrupted digit still looks valid. A program is
# therefore read until two readings agree, and written row by row, then read back.

# The words of one row; the first is its number.
Row = tuple[int, ...]

READINGS = 5  # attempts until two readings in succession agree


def read_program(context: MotionContext) -> TaskBody[tuple[Row, ...]]:
    """Return the program in the device's memory, after two equal readings. Raises `DeviceFault`."""
    seen: DeviceProgram | None = None
    trouble = "no two readings agree, so the line is noisy"
    for _ in range(READINGS):
        if context.stopping:
            raise context.stopped("reading the program was stopped")
        reply = yield from _asked(context, ReadProgram())
        if isinstance(reply, DeviceProgram):
            if reply == seen:
                return reply.rows
            seen = reply
        else:
            trouble = str(reply)
    yield from context.look()  # raises the right error if the arm does not answer at all
    raise DeviceFault(f"the program in the arm cannot be read: {trouble}. Try again")


def write_program(
    context: MotionContext, rows: Sequence[Row], *, leave_others: bool
) -> TaskBody[int]:
    """Write rows into the device's memory; return the number of rows written.

    Rows that are already there are skipped. Raises `Refused` if the memory has rows with other
    numbers, which cannot be deleted from here, unless `leave_others`; and `ProgramHalfWritten` if
    writing ends early or the memory differs afterwards.
    """
    before = yield from read_program(context)
    others = tuple(row[0] for row in before if row[0] not in {row[0] for row in rows})
    if others and not leave_others:
        raise Refused(
            f"the arm's memory also has {named_rows(others)}, which would stay and run with the "
            "new program: clear them at the pendant, or allow them to stay"
        )
    missing = [row for row in rows if row not in before]
    written = 0
    try:
        for row in missing:
            yield from _write_row(context, row)
            written += 1
        after = yield from read_program(context)
    except ArmError as error:
        raise _half(error, written, len(missing)) from error
    _compare(rows, before, after)
    return len(missing)


def _write_row(context: MotionContext, row: Row) -> TaskBody[None]:
    """Write one row, repeating disturbed exchanges: writing a row twice changes nothing."""
    trouble: Reply | NoAnswer | None = None
    for _ in range(TRIES):
        if context.stopping:
            raise context.stopped("writing the program was stopped")
        trouble = yield from _asked(context, WriteRow(row))
        if isinstance(trouble, Done):
            return
    if isinstance(trouble, NoAnswer):
        yield from context.look()
        raise trouble
    raise DeviceFault(f"the arm refuses row {row[0]}: its memory is full, or the line is noisy")


def _asked(context: MotionContext, request: ReadProgram | WriteRow) -> TaskBody[Reply | NoAnswer]:
    """Ask once; after a disturbance, wait for a quiet line and return the error."""
    try:
        reply: Reply = yield Exchange(request)
    except NoAnswer as error:
        yield from context.quiet()
        return error
    if isinstance(reply, RequestRejected):
        yield from context.quiet()
    return reply


def _compare(rows: Sequence[Row], before: Sequence[Row], after: Sequence[Row]) -> None:
    """Raise unless the memory holds its previous rows and the written ones."""
    wanted = {row[0]: row for row in (*before, *rows)}
    found = {row[0]: row for row in after}
    wrong = tuple(n for n in sorted(wanted | found) if wanted.get(n) != found.get(n))
    if wrong:
        raise ProgramHalfWritten(
            f"the arm's memory differs from what was written: {named_rows(wrong)}. Write again"
        )


def _half(error: ArmError, written: int, missing: int) -> ArmError:
    """Return the error of an incomplete write."""
    words = f"only {written} of {counted(missing, 'row')} were written: write again"
    kind = Stopped if isinstance(error, Stopped) else ProgramHalfWritten
    return kind(f"{words}. The cause: {error}")


def named_rows(numbers: Sequence[int]) -> str:
    """Name rows: `row 3`, or `rows 1 to 4`."""
    if len(numbers) == 1:
        return f"row {numbers[0]}"
    first, last = numbers[0], numbers[-1]
    if list(numbers) == list(range(first, last + 1)):
        return f"rows {first} to {last}"
    return f"rows {', '.join(map(str, numbers))}"


# Inputs and outputs.


def require_inputs(core: Core) -> int:
    """Return the number of an arm's inputs. Raises `Refused` if there are none."""
    inputs = core.controller.abilities.inputs
    return _required(core, inputs, "inputs to read or to wait for")


def require_outputs(core: Core) -> int:
    """Return the number of an arm's outputs. Raises `Refused` if there are none."""
    return _required(core, core.controller.abilities.outputs, "outputs to switch")


def _required(core: Core, count: int, what: str) -> int:
    if not count:
        raise Refused(f"the controller of the {core.config.title} has no {what}")
    return count


def set_outputs(context: MotionContext, bits: int) -> TaskBody[None]:
    """Write the output bits."""
    highest = (1 << require_outputs(context.core)) - 1
    if isinstance(bits, bool) or not isinstance(bits, int) or not 0 <= bits <= highest:
        raise BadRequest(f"outputs are a whole number from 0 to {highest}, not {bits!r}")
    reply = yield from context.request(SetOutputs(bits))
    if not isinstance(reply, Done):
        raise DeviceFault(f"the controller did not take the output bits {bits}: look at the arm")
    context.core.readings.outputs = bits
