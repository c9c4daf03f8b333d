"""The host's end of the GRBL dialect: lines out, answers matched to them, no clock, no I/O.

The state is the unanswered line, and whether the host waits for a banner:

    ready      --send-->             waiting for an answer: no line may be sent
    waiting    --ok, error-->        ready
    any        --soft reset sent-->  resetting: no line may be sent
    any        --banner-->           ready; the line that was unanswered is lost

One line at a time is half as fast as filling the board's receive ring, but four times as fast as
the driver's segments, and an answer can only be that line's. Real-time commands may be sent at any
time. No input from the board raises.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TypeAlias

from firmware_protocol.errors import LocalProtocolError, RemoteProtocolError
from firmware_protocol.events import Stray, Unreadable
from firmware_protocol.fields import message
from firmware_protocol.grbl.answers import (
    PADDING,
    Alarm,
    Banner,
    Error,
    HostMessage,
    Info,
    Ok,
    Remark,
    StatusReport,
    Version,
    WordedError,
    decode_answer,
)
from firmware_protocol.grbl.codes import alarm_code, error_code
from firmware_protocol.grbl.commands import Command, Realtime
from firmware_protocol.grbl.dialect import GRBL, Dialect, Variant
from firmware_protocol.lines import LineHost

# The host's events.


@message()
class Acknowledged:
    """The board accepted a line. A motion is then planned, but not finished."""

    command: Command


@message()
class Refused:
    """The board refused a line, without effect. `code` is None if the answer was in words."""

    command: Command
    code: int | None
    meaning: str
    remedy: str


@message()
class AlarmRaised:
    """The board is locked. `position_kept` is false if steps may have been lost."""

    code: int
    meaning: str
    remedy: str
    position_kept: bool


@message()
class Restarted:
    """The board has restarted: its position is suspect, and an unanswered line gets no answer.

    It may have been executed.
    """

    banner: Banner


Event: TypeAlias = (
    Acknowledged | Refused | AlarmRaised | Restarted | StatusReport | Stray | Unreadable | Info
)


# Longer lines are dropped and reported.
LINE_BYTES_MAX = 512
_LINE_ENDS = b"\r\n"
_IN_WORDS = "the firmware answered in words"


class Host(LineHost[Event]):
    """The host's end. Raises `LocalProtocolError` for mistakes of its owner."""

    def __init__(self, dialect: Dialect = GRBL) -> None:
        self.dialect = dialect
        super().__init__(_LINE_ENDS, padding=PADDING, max_length=LINE_BYTES_MAX)
        self._outstanding: Command | None = None
        self._resetting = False

    @property
    def outstanding(self) -> Command | None:
        """The unanswered line."""
        return self._outstanding

    def send(self, command: Command) -> bytes:
        """Return the bytes of a line.

        Raises `LocalProtocolError` if the line is too long for the board, while another one is
        unanswered, and between a soft reset and its banner. Answers received before this call do
        not count.
        """
        text, most = command.text, self.dialect.max_line
        if len(text) > most:
            raise LocalProtocolError(
                f"'{text}' has {len(text)} characters, the board takes {most}: name fewer axes, or "
                "digits"
            )
        if self._resetting:
            raise LocalProtocolError(
                f"'{text}' cannot be sent now: a soft reset was sent and its banner has not come"
            )
        if self._outstanding is not None:
            raise LocalProtocolError(
                f"'{self._outstanding.text}' is unanswered: wait, or forget it"
            )
        self._keep_early()
        self._mark_early()
        self._outstanding = command
        return text.encode("ascii") + b"\n"

    def send_realtime(self, command: Realtime) -> bytes:
        """Return a real-time command's byte; legal at any time.

        After `SOFT_RESET` no line can be sent until its banner has come, or `forget_outstanding`.
        """
        if not isinstance(command, Realtime):
            raise LocalProtocolError(f"{command!r} is no real-time command")
        self._resetting |= command is Realtime.SOFT_RESET
        return bytes((command,))

    def forget_outstanding(self) -> None:
        """Forget the unanswered line, and an awaited banner.

        For use after a timeout. A late answer is `Stray` until the next `send`, and counts as the
        answer to that line afterwards: reset the board, or be sure that it is silent.
        """
        self._outstanding = None
        self._resetting = False
        self._mark_early(early=False)

    def _interpret(self, line: bytes) -> Event:
        return self._event(decode_answer(line), early=False)

    def _interpret_early(self, line: bytes) -> Event:
        return self._event(decode_answer(line), early=True)

    def _event(self, answer: HostMessage, *, early: bool) -> Event:
        match answer:
            case Ok() | Error() | WordedError():
                return Stray(answer) if early else self._answered(answer)
            case Banner():
                return self._restarted(answer)
            case StatusReport():
                self._check_axes(answer)
            case Alarm():
                row = alarm_code(answer.code, self.dialect.variant)
                return AlarmRaised(row.code, row.meaning, row.remedy, row.position_kept)
        self._learn(answer)
        return answer

    def _answered(self, answer: Ok | Error | WordedError) -> Event:
        command, self._outstanding = self._outstanding, None
        if command is None:
            return Stray(answer)
        match answer:
            case Ok():
                return Acknowledged(command)
            case Error():
                row = error_code(answer.code, self.dialect.variant)
                return Refused(command, row.code, row.meaning, row.remedy)
        return Refused(command, None, answer.text, _IN_WORDS)

    def _restarted(self, banner: Banner) -> Restarted:
        if banner.variant is not Variant.GRBL:  # grblHAL may say Grbl too: keep what is known
            self.dialect = replace(self.dialect, variant=banner.variant)
        self.forget_outstanding()
        return Restarted(banner)

    def _check_axes(self, report: StatusReport) -> None:
        """Raise `RemoteProtocolError` if a report has another number of axes.

        The line is damaged, or the board has other axes than assumed.
        """
        count, axes = len(report.machine_position or self.dialect.axes), len(self.dialect.axes)
        if count != axes:
            raise RemoteProtocolError(f"coordinates: {count}, but the board has {axes} axes")

    def _learn(self, answer: object) -> None:
        """Learn the firmware from the answers to `$I`."""
        if answer == Remark("[FIRMWARE:grblHAL]"):
            self.dialect = replace(self.dialect, variant=Variant.GRBLHAL)
        elif isinstance(answer, Version) and "FluidNC" in answer.version:
            self.dialect = replace(self.dialect, variant=Variant.FLUIDNC)
