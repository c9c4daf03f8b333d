"""Exchanges with an Armdroid's board that move nothing: reading its state and clearing its input.

The board keeps a half-received command, and a line end does not clear it. `settle` clears it from
any state: the answer to `v` shows that everything sent before is done; `s` consumes any number that
was left; `d` alone, now without steps, resets the index of the arguments.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from typing import TypeAlias

from armdrive.dialects.armdroid.settings import ArmdroidSettings
from armdrive.dialects.exchange import ScriptIO
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
from firmware_protocol.armdroid.messages import encode_answer

Offsets: TypeAlias = tuple[int, ...]

TRIES = 3  # attempts to send a command that moves nothing
LONGEST_OFFSETS = len("offsets = " + ",".join(["-32768"] * 6) + "\r\n")
# The speed that consumes a left-over number. It ends in 5: appended to any digits, the board never
# reads a 0, by which it would divide.
EMPTYING_RPM = 25


class BoardExchange:
    """The known state of a board, and the exchanges that read or set it."""

    def __init__(
        self, io: ScriptIO[HostEvent], host: Host, settings: ArmdroidSettings, byte_s: float
    ) -> None:
        self._io = io
        self._host = host
        self._settings = settings
        self._byte_s = byte_s
        self._boot_s = settings.boot_s
        self._rpm: int | None = None
        self._kept = True
        self.met = False
        self.firmware = ""
        self.offsets: Offsets | None = None
        self.answer_bytes = 0

    @property
    def clean(self) -> bool:
        """Whether the board holds no half-received command and its offsets are known."""
        return self._host.clean and self.offsets is not None

    def give_up(self) -> None:
        """Stop waiting for the answer; the board may hold half of the command."""
        self._host.give_up()
        self._host.discard()

    def forget_session(self) -> None:
        """Discard everything known about the board."""
        self._rpm = self.offsets = None
        self._kept = True

    def taking_s(self, count: int) -> float:
        """Return how long `count` characters take to be sent and read by the board."""
        return count * (self._byte_s + self._settings.character_s)

    def exchange(
        self, command: Command, text: bytes = b""
    ) -> Generator[float, HostEvent | None, Completed | None]:
        """Send a command, as `text` if given; return its answer, or None after a timeout."""
        whole = self._host.send(command)
        sent = text or whole
        self._send(sent)
        event = yield from self._wait_for(len(sent), lambda event: isinstance(event, Completed))
        if not isinstance(event, Completed):
            self.give_up()
            return None
        self.met = True
        return event

    def settle(self) -> Generator[float, HostEvent | None, Offsets | None]:
        """Clear all left-over input from the board; return its offsets."""
        if not (yield from self._greet()):
            return None
        emptied = yield from self.exchange(SetSpeed(EMPTYING_RPM))
        if emptied is None or not isinstance(emptied.answer, SpeedReported):
            return None
        self._rpm = emptied.answer.rpm
        letter = Clear.letter.encode("ascii")  # no comma: after five others it would do harm
        return self._take((yield from self.exchange(Clear(), letter)))

    def look(self) -> Generator[float, HostEvent | None, Offsets | None]:
        """Return the offsets, and clear the numbers that a stray `D` could repeat."""
        if not self._host.clean:
            return (yield from self.settle())
        command = DropArguments() if self._kept else ReportOffsets()
        offsets = self._take((yield from self.exchange(command)))
        self._kept = self._kept and offsets is None
        return offsets

    def set_speed(self, rpm: int) -> Generator[float, HostEvent | None, bool]:
        """Set the speed if it differs; return False if the board does not accept it."""
        if self._rpm == rpm:
            return True
        if (yield from self.ensure(SetSpeed(rpm))) is None:
            return False
        self._rpm = rpm
        return True

    def has_speed(self, rpm: int) -> bool:
        """Return whether the board's last reported speed is this one."""
        return self._rpm == rpm

    def heard_speed(self, rpm: int) -> None:
        """Record a speed reported without a request: an `s` that the line doubled sets 0.

        At speed 0 the next motion would never end, and the board would not react until a reset.
        """
        self._rpm = rpm

    def ensure(self, command: Command) -> Generator[float, HostEvent | None, Completed | None]:
        """Send a repeatable command until the board confirms it; return None if it never does."""
        for _ in range(TRIES):
            if not self.clean and (yield from self.settle()) is None:
                return None
            done = yield from self.exchange(command)
            if done is not None and done.as_asked:
                return done
            if done is not None:  # the board did something else
                self._io.on_unsolicited(Stray(done.answer))
            self.give_up()  # an old number preceded the command, or its number or answer was lost
        return None

    def begin_drive(self, drive: DriveAll) -> bytes:
        """Return the characters of a motion without sending them."""
        self._kept = True
        return self._host.send(drive)

    def repeated(self, numbers: bytes) -> Generator[float, HostEvent | None, Offsets | None]:
        """Send a motion's numbers without its letter; return them as the board repeats them."""
        text = numbers + ReportArguments.letter.encode("ascii")
        self._send(text)
        event = yield from self._wait_for(len(text), _is_stray_arguments)
        if not isinstance(event, Stray) or not isinstance(event.answer, ArgumentsReported):
            return None
        return *event.answer.arguments, event.answer.accumulator

    def let_loose(self, rest: bytes, whole: str) -> None:
        """Send the rest of a motion's `whole` text, which starts it."""
        self._io.write(rest, whole)
        self.offsets = None

    def offsets_after(
        self, expected: Offsets, sent: int, longest_s: float
    ) -> Generator[float, HostEvent | None, Offsets | None]:
        """Wait for the end of a motion; return the latest offsets, as expected or not.

        Unexpected offsets may be an earlier answer that the line doubled, so they are returned
        only if the expected ones do not arrive while the motion may last.
        """
        came: Offsets | None = None
        until_s = self._deadline_s(sent, longest_s)
        while came != expected:
            event = yield from self._io.wait_for(until_s, _is_offsets)
            if event is None:
                self.give_up()
                return came
            came = _offsets(event)
        self.offsets = expected
        self.answer_bytes = len(encode_answer(OffsetsReported(expected)))
        if self._host.outstanding is not None:
            self.give_up()
        return came

    def _greet(self) -> Generator[float, HostEvent | None, bool]:
        """Ask for the version until the board answers, which takes a while after opening."""
        until_s = self._io.now_s + self._boot_s
        self._boot_s = 0.0
        while True:
            done = yield from self.exchange(Version())
            if done is not None and isinstance(done.answer, VersionReported):
                self.firmware = done.answer.firmware
                return True
            if self._io.now_s >= until_s:
                return False

    def _take(self, done: Completed | None) -> Offsets | None:
        self.offsets = None if done is None else _offsets(done)
        return self.offsets

    def _send(self, data: bytes) -> None:
        self._io.write(data, data.decode("ascii"))

    def _deadline_s(self, sent: int, longest_s: float = 0.0) -> float:
        wire_s = self.taking_s(sent) + LINE_BYTES * self._byte_s
        return self._io.now_s + wire_s + longest_s + self._settings.answer_margin_s

    def _wait_for(
        self, sent: int, wanted: Callable[[HostEvent], bool]
    ) -> Generator[float, HostEvent | None, HostEvent | None]:
        return (yield from self._io.wait_for(self._deadline_s(sent), wanted))


def _is_stray_arguments(event: HostEvent) -> bool:
    return isinstance(event, Stray) and isinstance(event.answer, ArgumentsReported)


def _is_offsets(event: HostEvent) -> bool:
    return _offsets(event) is not None


def _offsets(event: HostEvent) -> Offsets | None:
    answer = event.answer if isinstance(event, Completed | Stray) else None
    return answer.offsets if isinstance(answer, OffsetsReported) else None
