"""Comparing a device's settings with the arm file's, and writing what a person has agreed to."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from armdrive.errors import (
    ArmError,
    DeviceFault,
    LinkLost,
    NoAnswer,
    ProgramHalfWritten,
    Refused,
    SettingsDiffer,
    Stopped,
)
from armdrive.motion.context import TRIES, MotionContext
from armdrive.tasks import (
    DeviceProgram,
    DeviceSettings,
    Done,
    Exchange,
    MendSetting,
    ReadProgram,
    ReadSettings,
    Reply,
    RequestRejected,
    TaskBody,
    WriteRow,
)


def compare_settings(wire: MotionContext) -> TaskBody[DeviceSettings]:
    """Read the device's settings; what differs from the arm file keeps the arm from moving.

    A difference is believed when it is read twice: the line has no check bytes.
    """
    core = wire.core
    reply, seen = (yield from _ask_settings(wire)), None
    for _ in range(TRIES):
        if not reply.differences or reply == seen:
            break
        seen, reply = reply, (yield from _ask_settings(wire))
    core.differences = reply.differences
    if reply.differences:
        core.diagnostics.notify(str(reply), SettingsDiffer(str(reply)))
    return reply


def compare_again(wire: MotionContext) -> TaskBody[None]:
    """Read settings once more that kept the arm from moving: somebody may have mended them."""
    if any(each.must for each in wire.core.differences):
        yield from compare_settings(wire)


def _ask_settings(wire: MotionContext) -> TaskBody[DeviceSettings]:
    reply = yield from wire.request(ReadSettings())
    if not isinstance(reply, DeviceSettings):
        words = f"the controller did not tell its settings ({reply}): look at the wire"
        raise wire.fault(DeviceFault(words))
    return reply


def mend_settings(wire: MotionContext, lines: tuple[str, ...]) -> TaskBody[DeviceSettings]:
    """Write the lines that a person has agreed to, one at a time, and compare again."""
    core = wire.core
    for line in lines:
        reply = yield from wire.request(MendSetting(line))
        if not isinstance(reply, Done):
            raise DeviceFault(f"the controller did not take `{line}`: {reply}")
    core.diagnostics.notice = ""
    return (yield from compare_settings(wire))


# A device's own program: read until two readings agree, and written row by row. Nothing moves.
#
# The line has no check bytes: a digit that was turned on it makes another row, which looks as
# good.
# So a program is believed when it was read twice alike, and written when it reads as it should.

Row = tuple[int, ...]
"""The device's words of one row; the first is its number."""

RowTold = Callable[[int], object]

READINGS = 5
"""So often a program is read at most until two readings in succession agree."""


def read_program(wire: MotionContext) -> TaskBody[tuple[Row, ...]]:
    """Return the program in the device's memory, read twice alike. Raises `DeviceFault`."""
    seen: DeviceProgram | None = None
    trouble = "no two readings of it agree: a disturbed line"
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
    yield from wire.look()  # an arm that is not there at all says so here
    raise DeviceFault(f"the program in the arm cannot be read: {trouble}. Try again")


def unheard(_: int) -> None:
    """Nobody wants to hear which rows are in the arm."""


def write_program(
    wire: MotionContext, rows: Sequence[Row], *, leave_others: bool, told: RowTold = unheard
) -> TaskBody[int]:
    """Bring rows into the device's memory; return how many of them had to be written.

    Rows that are there already are left; `told` hears the number of each other one as it is in.
    Raises `Refused` where the memory has rows of other numbers, which nothing sent from here can
    take away, unless `leave_others`; and `ProgramHalfWritten` where it ends before the end, or
    reads otherwise afterwards.
    """
    before = yield from read_program(wire)
    others = tuple(row[0] for row in before if row[0] not in {row[0] for row in rows})
    if others and not leave_others:
        raise Refused(
            f"the arm's memory has {named_rows(others)} besides, which would stay, and run with "
            "the new program: clear them at the pendant, or say that they are to stay"
        )
    missing = [row for row in rows if row not in before]
    written: list[int] = []
    for row in missing:
        try:
            yield from _write_row(wire, row)
        except ArmError as error:
            raise _half(error, written, missing) from error
        written.append(row[0])
        told(row[0])
    try:
        after = yield from read_program(wire)
    except ArmError as error:
        raise _half(error, written, missing) from error
    _compare(rows, before, after, written)
    return len(missing)


def _write_row(wire: MotionContext, row: Row) -> TaskBody[None]:
    """Write one row, again where an exchange was disturbed: twice the same changes nothing."""
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
    raise DeviceFault(f"the arm does not take row {row[0]}: its memory is full, or the line bad")


def _asked(wire: MotionContext, request: ReadProgram | WriteRow) -> TaskBody[Reply | NoAnswer]:
    """Ask once; what disturbed it is returned, when the line has fallen silent behind it."""
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
    """Raise where the memory is not what it was, with the rows written into it."""
    wanted = {row[0]: row for row in (*before, *rows)}
    found = {row[0]: row for row in after}
    wrong = tuple(n for n in sorted(wanted | found) if wanted.get(n) != found.get(n))
    if wrong:
        good = tuple(number for number in written if number not in wrong)
        raise ProgramHalfWritten(
            f"the arm's memory reads otherwise than was written: {named_rows(wrong)}. Write again",
            written=good,
            doubtful=wrong,
        )


def _half(error: ArmError, written: list[int], missing: Sequence[Row]) -> ArmError:
    """Return the error that says which rows are in the arm."""
    under_way = tuple(row[0] for row in missing[len(written) : len(written) + 1])
    rest = tuple(row[0] for row in missing[len(written) + 1 :])
    is_in = f"{named_rows(written)} in the arm" if written else "nothing new in the arm"
    doubt = f", {named_rows(under_way)} perhaps" if under_way else ""
    old = f"; {named_rows(rest)} as before" if rest else ""
    mend = (
        "plug in, connect again and write again" if isinstance(error, LinkLost) else "write again"
    )
    words = (
        f"the program was not written to its end: {is_in}{doubt}{old}. To mend it, {mend}. "
        f"What happened: {error}"
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
