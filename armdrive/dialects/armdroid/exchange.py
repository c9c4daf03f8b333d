"""Exchanges with an Armdroid's board that move nothing: reading its state and clearing its input.

The board keeps a half-received command, and a line end does not clear it. `settle` clears it from
any state: the answer to `v` shows that everything sent before is done; `s` consumes any number that
was left; `d` alone, now without steps, resets the index of the arguments.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

from armdrive.dialects.armdroid.settings import ArmdroidSettings
from armdrive.dialects.exchange import TRIES, Script, ScriptIO
from firmware_protocol.armdroid import (
    LINE_BYTES,
    ArgumentsReported,
    Clear,
    Command,
    Completed,
    DriveAll,
    DropArguments,
    Host,
    OffsetsReported,
    ReportArguments,
    ReportOffsets,
    SetSpeed,
    SpeedReported,
    Stray,
    Version,
    VersionReported,
)
from firmware_protocol.armdroid.endpoints import Event as HostEvent

Offsets: TypeAlias = tuple[int, ...]

# The speed that consumes a left-over number. It ends in 5: appended to any digits, the board never
# reads a 0, by which it would divide.
EMPTYING_RPM = 25


@dataclass(slots=True, eq=False)
class BoardExchange:
    """The known state of a board, and the exchanges that read or set it."""

    io: ScriptIO[HostEvent]
    host: Host
    settings: ArmdroidSettings
    byte_s: float
    rpm: int | None = None
    """The board's speed as it last reported it, asked or not: an `s` that the line doubled sets 0.

    At speed 0 the next motion would never end, and the board would not react until a reset.
    """
    firmware: str = ""
    """As the board has reported it; empty until it has answered in this session."""
    offsets: Offsets | None = None
    """The motors' positions; None while they turn, or if the last answer was lost."""
    was_deaf: bool = True
    """Whether the first command of the session was lost, as it is while a board starts."""
    _kept: bool = True
    """Whether the board may hold numbers that a stray `D` would repeat as a motion."""
    _started: bool = False

    @property
    def clean(self) -> bool:
        """Whether the board holds no half-received command and its offsets are known."""
        return self.host.clean and self.offsets is not None

    def give_up(self) -> None:
        """Stop waiting for the answer; the board may hold half of the command."""
        self.host.give_up()
        self.host.discard()

    def forget_session(self) -> None:
        """Discard everything known about the board."""
        self.rpm = self.offsets = None
        self._kept = True

    def taking_s(self, count: int) -> float:
        """Return how long `count` characters take to be sent and read by the board."""
        return count * (self.byte_s + self.settings.character_s)

    def exchange(self, command: Command, text: bytes = b"") -> Script[HostEvent, Completed | None]:
        """Send a command, as `text` if given; return its answer, or None after a timeout."""
        whole = self.host.send(command)
        sent = text or whole
        self._send(sent)
        event = yield from self._wait_for(len(sent), lambda event: isinstance(event, Completed))
        if not isinstance(event, Completed):
            self.give_up()
            return None
        return event

    def settle(self) -> Script[HostEvent, Offsets | None]:
        """Clear all left-over input from the board; return its offsets."""
        if not (yield from self._greet()):
            return None
        emptied = yield from self.exchange(SetSpeed(EMPTYING_RPM))
        if emptied is None or not isinstance(emptied.answer, SpeedReported):
            return None
        self.rpm = emptied.answer.rpm
        letter = Clear.letter.encode("ascii")  # no comma: after five others it would do harm
        return self._take((yield from self.exchange(Clear(), letter)))

    def look(self) -> Script[HostEvent, Offsets | None]:
        """Return the offsets, and clear the numbers that a stray `D` could repeat."""
        if not self.host.clean:
            return (yield from self.settle())
        command = DropArguments() if self._kept else ReportOffsets()
        offsets = self._take((yield from self.exchange(command)))
        self._kept = offsets is None
        return offsets

    def set_speed(self, rpm: int) -> Script[HostEvent, bool]:
        """Set the speed if it differs; return False if the board does not accept it."""
        if self.rpm == rpm:
            return True
        if (yield from self.ensure(SetSpeed(rpm))) is None:
            return False
        self.rpm = rpm
        return True

    def ensure(self, command: Command) -> Script[HostEvent, Completed | None]:
        """Send a repeatable command until the board confirms it; return None if it never does."""
        for _ in range(TRIES):
            if not self.clean and (yield from self.settle()) is None:
                return None
            done = yield from self.exchange(command)
            if done is not None and done.as_asked:
                return done
            if done is not None:  # the board did something else
                self.io.on_unsolicited(Stray(done.answer))
            self.give_up()  # an old number preceded the command, or its number or answer was lost
        return None

    def begin_drive(self, drive: DriveAll) -> bytes:
        """Return the characters of a motion without sending them."""
        self._kept = True
        return self.host.send(drive)

    def repeated(self, numbers: bytes) -> Script[HostEvent, Offsets | None]:
        """Send a motion's numbers without its letter; return them as the board repeats them."""
        text = numbers + ReportArguments.letter.encode("ascii")
        self._send(text)
        # the codec calls it stray, because no command of its own asked for it
        event = yield from self._wait_for(len(text), _is_stray_arguments)
        if not isinstance(event, Stray) or not isinstance(event.answer, ArgumentsReported):
            return None
        return *event.answer.arguments, event.answer.accumulator

    def let_loose(self, letter: bytes, whole: str) -> None:
        """Send the letter of a motion, which starts it; `whole` is the motion's text."""
        self.io.write(letter, whole)
        self.offsets = None

    def offsets_after(
        self, expected: Offsets, longest_s: float
    ) -> Script[HostEvent, Offsets | None]:
        """Wait for the end of a motion; return the latest offsets, as expected or not.

        Unexpected offsets may be an earlier answer that the line doubled, so they are returned
        only if the expected ones do not arrive while the motion may last.
        """
        came: Offsets | None = None
        until_s = self._deadline_s(1, longest_s)
        while came != expected:
            event = yield from self.io.wait_for(until_s, _is_offsets)
            if event is None:
                self.give_up()
                return came
            came = _offsets(event)
        self.offsets = expected
        return came

    def _greet(self) -> Script[HostEvent, bool]:
        """Ask for the version until the board answers, which takes a while after opening."""
        until_s = self.io.now_s + (0.0 if self._started else self.settings.boot_s)
        first, self._started = not self._started, True
        while True:
            done = yield from self.exchange(Version())
            if done is not None and isinstance(done.answer, VersionReported):
                self.was_deaf &= not first
                self.firmware = done.answer.firmware
                return True
            first = False
            if self.io.now_s >= until_s:
                return False

    def _take(self, done: Completed | None) -> Offsets | None:
        self.offsets = _offsets(done)
        return self.offsets

    def _send(self, data: bytes) -> None:
        self.io.write(data, data.decode("ascii"))

    def _deadline_s(self, sent: int, longest_s: float = 0.0) -> float:
        wire_s = self.taking_s(sent) + LINE_BYTES * self.byte_s
        return self.io.now_s + wire_s + longest_s + self.settings.answer_margin_s

    def _wait_for(
        self, sent: int, wanted: Callable[[HostEvent], bool]
    ) -> Script[HostEvent, HostEvent | None]:
        return (yield from self.io.wait_for(self._deadline_s(sent), wanted))


def _is_stray_arguments(event: HostEvent) -> bool:
    return isinstance(event, Stray) and isinstance(event.answer, ArgumentsReported)


def _is_offsets(event: HostEvent) -> bool:
    return _offsets(event) is not None


def _offsets(event: HostEvent | None) -> Offsets | None:
    answer = event.answer if isinstance(event, Completed | Stray) else None
    return answer.offsets if isinstance(answer, OffsetsReported) else None
