"""The host's end of the TeachMover dialect: commands out, answers in. No clock, no I/O.

The host sends one command at a time, and waits in one of four states:

    NOTHING    --send-->           STATUS
    STATUS     --0, 1 or 2-->      NOTHING     (the command is completed)
    STATUS     --1 to READ-->      REGISTERS   --register line-->  NOTHING
    STATUS     --1 to QDUMP-->     ROWS        --end_dump-->       NOTHING

Unexpected lines do not change the state: they become `Stray` (readable, but no command is open) or
`Unreadable` (unreadable, or not the expected answer). No input from the arm raises.
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum, auto
from types import MappingProxyType
from typing import TypeAlias

from firmware_protocol.errors import LocalProtocolError
from firmware_protocol.events import Stray, Unreadable
from firmware_protocol.fields import message
from firmware_protocol.lines import LineHost
from firmware_protocol.teachmover.messages import (
    CR,
    NOISE,
    Command,
    ProgramRow,
    QDump,
    Read,
    Registers,
    Reply,
    Status,
    decode_reply,
    encode_command,
)


class Due(Enum):
    """What the host waits for."""

    NOTHING = auto()
    STATUS = auto()
    REGISTERS = auto()
    ROWS = auto()


# What follows the status line DONE, for the commands where something does.
AFTER_DONE: Mapping[type[Command], Due] = MappingProxyType({Read: Due.REGISTERS, QDump: Due.ROWS})

# The form of what is due, and what it is called.
FORMS: Mapping[Due, tuple[type[Reply], str]] = MappingProxyType(
    {
        Due.STATUS: (Status, "a status line"),
        Due.REGISTERS: (Registers, "a register line"),
        Due.ROWS: (ProgramRow, "a program row"),
    }
)

# The most rows in a dump: they fill the arm's 1 KB of memory.
MAX_ROWS = 64


@message()
class Completed:
    """A command's complete answer: with `registers` for READ, with `rows` for QDUMP.

    It is unverified whether anything follows a status other than DONE; if so, it is `Stray`.
    """

    command: Command
    status: Status
    registers: Registers | None = None
    rows: tuple[ProgramRow, ...] = ()


Event: TypeAlias = Completed | Stray | Unreadable


class Host(LineHost[Event]):
    """The host's protocol machine. Raises `LocalProtocolError` if misused.

    There is no clock: the caller decides when to give up on an answer, and when a dump has ended.
    No end mark is known, so the caller waits for a quiet line. Commands start with `ATTENTION`: no
    driver sends `Arm`, which would change that.
    """

    def __init__(self) -> None:
        super().__init__(CR, padding=NOISE)
        self._awaits = Due.NOTHING
        self._command: Command | None = None
        self._rows: list[ProgramRow] = []

    @property
    def outstanding(self) -> Command | None:
        """The command without a complete answer."""
        return self._command

    @property
    def dumping(self) -> bool:
        """Whether the rows of a QDUMP are arriving, so that `end_dump` may be called."""
        return self._awaits is Due.ROWS

    def send(self, command: Command) -> bytes:
        """Return a command's bytes.

        Raises `LocalProtocolError` while another is unanswered, because it is unknown whether the
        arm keeps input received during a motion. Lines that began before this call are never taken
        for this command's answer.
        """
        if self._command is not None:
            raise LocalProtocolError(
                f"{self._command.name} is unanswered: wait for its Completed, or give_up, "
                f"before sending {command.name}"
            )
        self._keep_early()
        self._mark_early()
        data = encode_command(command)
        self._command, self._awaits = command, Due.STATUS
        return data

    def end_dump(self) -> list[Event]:
        """End a dump; return its last events: those that wait, an unfinished row, `Completed`.

        How an arm ends a dump is unverified: call this once the line is quiet. Raises
        `LocalProtocolError` if no dump is arriving.
        """
        if self._awaits is not Due.ROWS or self._command is None:
            raise LocalProtocolError("no dump is coming in: send QDump and wait for its first row")
        last: list[Event] = []
        while (event := self.next_event()) is not None:
            last.append(event)
        if cut_off := self._partial:
            self._lines.discard()
            last.append(Unreadable(cut_off, "the dump ended in the middle of a line"))
        rows = tuple(self._rows)
        return [*last, self._complete(Completed(self._command, Status.DONE, rows=rows))]

    def give_up(self) -> None:
        """Stop waiting for the unanswered command, after a timeout.

        Its answer may still come, and nothing in it names the command. Before the next `send` a
        late answer is a `Stray`; after it, a late status line is taken for the answer to the new
        command. So wait until the line has been quiet for longer than any motion lasts, call
        `discard`, and send `Read` next: its register line reveals a mix-up.
        """
        self._awaits, self._command = Due.NOTHING, None
        self._rows.clear()

    def _interpret(self, line: bytes) -> Event | None:
        reply = decode_reply(line)
        if self._command is None:
            return Stray(reply)
        form, wanted = FORMS[self._awaits]
        if not isinstance(reply, form):
            return Unreadable(line, f"{wanted} was awaited after {self._command.name}")
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
        return Unreadable(line, f"more than {MAX_ROWS} rows in one dump")

    def _accept_status(self, command: Command, status: Status) -> Event | None:
        following = AFTER_DONE.get(type(command))
        if status is Status.DONE and following is not None:
            self._awaits = following
            return None
        return self._complete(Completed(command, status))

    def _complete(self, event: Completed) -> Completed:
        self.give_up()
        return event
