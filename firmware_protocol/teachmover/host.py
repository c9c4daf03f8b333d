"""The host's end of the TeachMover dialect: one command out, its answer in, no clock, no wire.

What the host waits for is one of four states:

    NOTHING    --send-->           STATUS
    STATUS     --0, 1 or 2-->      NOTHING     (the command is completed)
    STATUS     --1 to READ-->      REGISTERS   --register line-->  NOTHING
    STATUS     --1 to QDUMP-->     ROWS        --end_dump-->       NOTHING

Lines that do not belong change no state: they become `Stray` (readable, but nothing was asked)
or `Garbled` (unreadable, or not the answer that is awaited). Nothing that the arm sends raises.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from firmware_protocol.errors import LocalProtocolError, RemoteProtocolError
from firmware_protocol.lines import AnswerLines, Dropped
from firmware_protocol.teachmover.messages import (
    AFTER_DONE,
    ATTENTION,
    FORMS,
    Arm,
    Command,
    Due,
    ProgramRow,
    Registers,
    Reply,
    Status,
    attention_character,
)
from firmware_protocol.teachmover.wire import CR, NOISE, decode_reply, encode_command

MAX_ROWS = 64
"""More rows than these a dump cannot have: they fill the arm's 1 KB of memory."""


@dataclass(frozen=True, slots=True)
class Completed:
    """A command's answer, whole. `registers` belong to a READ and `rows` to a QDUMP that is done.

    Whether anything follows a status other than DONE is unverified: if it does, it is `Stray`.
    """

    command: Command
    status: Status
    registers: Registers | None = None
    rows: tuple[ProgramRow, ...] = ()


@dataclass(frozen=True, slots=True)
class Stray:
    """A readable line that nobody asked for, for example the late answer of a given-up command."""

    line: bytes


@dataclass(frozen=True, slots=True)
class Garbled:
    """Bytes that cannot be read, or that cannot be the answer which is awaited, and why."""

    data: bytes
    reason: str


Event: TypeAlias = Completed | Stray | Garbled


class Host:
    """The machine that speaks to the arm. Raises `LocalProtocolError` for its owner's mistakes.

    The codec has no clock: it is the owner who gives up on an answer, and who tells the end of a
    dump by the silence behind it, for no mark of the end is known.
    """

    def __init__(self, attention: str = ATTENTION) -> None:
        self._attention = attention_character(attention)
        self._lines = AnswerLines[Event](CR, self._interpret, padding=NOISE)
        self._awaits = Due.NOTHING
        self._command: Command | None = None
        self._rows: list[ProgramRow] = []
        self._dump_over = False

    @property
    def attention(self) -> str:
        """The character that commands start with now."""
        return self._attention

    @property
    def outstanding(self) -> Command | None:
        """The command whose answer is not complete yet."""
        return self._command

    @property
    def dumping(self) -> bool:
        """Whether the rows of a QDUMP are coming in, so that `end_dump` may be called."""
        return self._awaits is Due.ROWS

    @property
    def buffered(self) -> int:
        """How many received bytes are held."""
        return self._lines.buffered

    def send(self, command: Command) -> bytes:
        """Return the bytes that give a command to the arm.

        Raises `LocalProtocolError` while another is unanswered: whether the arm keeps what it
        receives during a motion is unknown. Bytes that were received before this call are never
        taken for this command's answer, nor is a line that had begun.
        """
        if self._command is not None:
            raise LocalProtocolError(
                f"{self._command.name} is unanswered: wait for its Completed, or give_up, "
                f"before sending {command.name}"
            )
        self._lines.keep_early()
        self._lines.mark_early()
        data = encode_command(command, self._attention)
        self._command, self._awaits = command, Due.STATUS
        return data

    def receive_data(self, data: bytes) -> None:
        """Take bytes from the arm, in any portions."""
        self._lines.feed(data)

    def next_event(self) -> Event | None:
        """Return what the bytes received so far say, one event at a time, then None."""
        event = self._lines.next_event()
        return self._end_of_dump() if event is None and self._dump_over else event

    def end_dump(self) -> None:
        """Say that the rows of a QDUMP are over; `Completed` comes from `next_event`.

        How an arm ends its dump is unverified: call this after a silence. Raises
        `LocalProtocolError` where no dump is coming in.
        """
        if self._awaits is not Due.ROWS:
            raise LocalProtocolError("no dump is coming in: send QDump and wait for its first row")
        self._dump_over = True

    def give_up(self) -> Command | None:
        """Forget the unanswered command, after a timeout, and return it.

        Its answer can still come, and nothing in the answer tells whose it is. While nothing new
        has been sent a late answer is a `Stray`; after the next `send` a late status line is
        taken for the answer to the new command. So wait until the line has been silent for
        longer than any motion lasts, call `discard`, and make the next command a `Read`: its
        register line gives a mix-up away. Whether a given-up `Arm` took effect is unknown.
        """
        command = self._command
        self._finish()
        return command

    def discard(self) -> None:
        """Forget all bytes received and all events not fetched; the next byte begins a line.

        Meant for after a silence. The unanswered command stays unanswered.
        """
        self._lines.discard()

    def _interpret(self, line: bytes | Dropped, early: bool) -> Event | None:
        if isinstance(line, Dropped):
            return Garbled(line.start, line.reason)
        if early:
            return Garbled(line, "the line began before the command was sent")
        try:
            reply = decode_reply(line)
        except RemoteProtocolError as error:
            return Garbled(line, str(error))
        if self._command is None:
            return Stray(line)
        form, wanted = FORMS[self._awaits]
        if not isinstance(reply, form):
            return Garbled(line, f"{wanted} was awaited after {self._command.name}")
        return self._accept(self._command, reply, line)

    def _accept(self, command: Command, reply: Reply, line: bytes) -> Event | None:
        match reply:
            case Status():
                return self._accept_status(command, reply)
            case Registers():
                return self._complete(Completed(command, Status.DONE, registers=reply))
            case ProgramRow() if len(self._rows) < MAX_ROWS:
                self._rows.append(reply)
                return None
        return Garbled(line, f"more than {MAX_ROWS} rows in one dump")

    def _accept_status(self, command: Command, status: Status) -> Event | None:
        following = AFTER_DONE.get(type(command))
        if status is Status.DONE and following is not None:
            self._awaits = following
            return None
        if status is Status.DONE and isinstance(command, Arm):
            self._attention = command.attention
        return self._complete(Completed(command, status))

    def _end_of_dump(self) -> Event | None:
        if self._command is None:
            return None
        if cut_off := self._lines.partial:
            self._lines.discard()
            return Garbled(cut_off, "the dump ended in the middle of a line")
        return self._complete(Completed(self._command, Status.DONE, rows=tuple(self._rows)))

    def _complete(self, event: Completed) -> Completed:
        self._finish()
        return event

    def _finish(self) -> None:
        self._awaits, self._command = Due.NOTHING, None
        self._rows.clear()
        self._dump_over = False
