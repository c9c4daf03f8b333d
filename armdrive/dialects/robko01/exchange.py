"""Exchanges with a Robko 01: a message and its answer, and resynchronization after a lost answer.

The board drops frames that it cannot parse, and a frame with a corrupt length makes it swallow the
frames that follow. So after a lost answer the driver sends zeros, which complete whatever the
board is reading, and then a ping with unique bytes: its answer cannot be a late answer.
"""

from __future__ import annotations

import math
from collections.abc import Generator

from armdrive.dialects.exchange import ScriptIO
from armdrive.dialects.robko01.settings import RobkoSettings
from armdrive.tasks import Alert, AlertKind
from firmware_protocol.robko01 import (
    FLUSH,
    FRAME_MAX,
    Answer,
    Answered,
    Host,
    Inputs,
    IsMoving,
    Moving,
    Ping,
    Position,
    Positions,
)
from firmware_protocol.robko01 import Event as HostEvent
from firmware_protocol.robko01 import Request as Message
from kinematics.spaces import Motors

TRIES = 3  # attempts to send a message that is safe to repeat
BOARD_S = 0.02  # longest processing time of the board; 3 ms were measured
# Until the first answer, pings carry the bytes 1 to 9: no dialect takes these for a letter, a line
# end or a real-time command.
FIRST_TOKENS = 9
FEEDS_PER_TIMEOUT = 3.0


class MotorPower:
    """Tracks whether the motors have current, and the firmware's watchdog, which can cut it.

    `watchdog_s` is the watchdog's timeout; 0 means that the firmware has no watchdog.
    """

    def __init__(self, io: ScriptIO[HostEvent], watchdog_s: float) -> None:
        self._io = io
        self._watchdog_s = watchdog_s
        self._feeding_s = -math.inf
        self.on = False
        self.fed_s = -math.inf
        """Time of the board's latest answer to a message that feeds its watchdog."""

    @property
    def starved(self) -> bool:
        """Whether the watchdog has expired and switched the motors off without reporting it."""
        runs_out_s = self.fed_s + self._watchdog_s
        return bool(self._watchdog_s) and self.on and self._io.now_s > runs_out_s

    @property
    def due_s(self) -> float:
        """When to feed the watchdog next; infinity if there is none to feed."""
        if not self._watchdog_s or not self.on or self.starved:
            return math.inf
        return max(self.fed_s, self._feeding_s) + self._watchdog_s / FEEDS_PER_TIMEOUT

    def feeding(self, now_s: float) -> None:
        """Record that a message that feeds the watchdog is being sent now."""
        self._feeding_s = now_s

    def fed(self) -> None:
        """Record that the board has answered, so that its watchdog counts from now."""
        self.fed_s = max(self.fed_s, self._io.now_s)

    def lost(self, kind: AlertKind, words: str) -> None:
        """Raise an alert that the motors are off, because of the watchdog or a restart."""
        self.on = False
        self._io.notify(Alert(kind, words))


class RobkoExchange:
    """Sends messages, awaits answers, and keeps the latest positions of the motors."""

    def __init__(
        self,
        io: ScriptIO[HostEvent],
        host: Host,
        power: MotorPower,
        settings: RobkoSettings,
        byte_s: float,
    ) -> None:
        self._io = io
        self._host = host
        self._power = power
        self._settings = settings
        self._byte_s = byte_s
        self._number = 0
        self._met = False
        self._out_of_step = True
        self.seen: Motors | None = None
        self.seen_s = -math.inf
        self.turning = False
        """Whether any axis had a speed in the latest report."""
        self.stood: Motors | None = None
        """The motors' positions at their latest standstill."""

    def give_up(self) -> None:
        """Stop waiting for the answer; the next message resynchronizes first."""
        self._host.forget()
        self._host.discard()
        self._out_of_step = True

    def forget(self) -> None:
        """Stop waiting for the answer to a ping that feeds the watchdog."""
        self._host.forget()

    def feed(self) -> bytes:
        """Return the bytes of a ping that feeds the watchdog between two requests."""
        self._host.forget()
        self._power.feeding(self._io.now_s)
        return self._host.send(self._token())

    def ask(
        self, message: Message, *, tries: int = TRIES, text: str = "", may_break: bool = False
    ) -> Generator[float, HostEvent | None, Answer | None]:
        """Send a message; return its answer, or None after a timeout.

        With `may_break`, a stop requested during the wait ends it at once.
        """
        asked = self._io.stop_asked
        for _ in range(tries):
            if self._out_of_step and not (yield from self._get_into_step()):
                return None
            answer = yield from self._once(message, text, break_at_stop=may_break and not asked)
            if answer is not None:
                return answer
            if may_break and self._io.stop_asked and not asked:
                return None
            self.give_up()
        return None

    def _once(
        self, message: Message, text: str, *, break_at_stop: bool = False
    ) -> Generator[float, HostEvent | None, Answer | None]:
        self._host.forget()
        data = self._host.send(message)
        self._io.write(data, text)
        event = yield from self._io.wait_for(
            self._io.now_s + self._patience_s(len(data)),
            lambda event: isinstance(event, Answered) and event.request is message,
            until_stop=break_at_stop,
        )
        if not isinstance(event, Answered):
            return None
        self.heed(event)
        return event.answer

    def _get_into_step(self) -> Generator[float, HostEvent | None, bool]:
        """Ping until the board answers; the first time, allow for the board's start-up."""
        until_s = self._io.now_s + (0.0 if self._met else self._settings.boot_s)
        tries = 0
        while tries < TRIES or self._io.now_s < until_s:
            tries += 1
            self._io.write(FLUSH)
            if (yield from self._once(self._token(), "PING")) is not None:
                self._met, self._out_of_step = True, False
                return True
        return False

    def heed(self, event: Answered) -> None:
        """Update the watchdog and the positions from any answer."""
        if isinstance(event.request, Ping | Inputs | Position):
            self._power.fed()
        if isinstance(event.answer, Positions):
            self.seen = Motors(event.answer.axes.positions_steps)
            self.seen_s = self._io.now_s
            self.turning = any(event.answer.axes.speeds_steps_s)

    def look(self, text: str = "") -> Generator[float, HostEvent | None, Motors | None]:
        """Return the motors' positions as reported, wrapped to 16 bits."""
        answer = yield from self.ask(Position(), text=text)
        return self.seen if isinstance(answer, Positions) else None

    def mask(self) -> Generator[float, HostEvent | None, int | None]:
        """Return the axes that the board reports as moving, one bit each."""
        answer = yield from self.ask(IsMoving())
        return answer.value if isinstance(answer, Moving) else None

    def _token(self) -> Ping:
        """Return a ping whose bytes no recent ping had.

        Until the first answer the device may be another board, so the bytes must be harmless in
        every dialect: a 10, for example, would end a half-sent line on a GRBL board.
        """
        self._number = (
            (self._number + 1) % (1 << 16) if self._met else self._number % FIRST_TOKENS + 1
        )
        return Ping(self._number.to_bytes(2, "big"))

    def _patience_s(self, length: int) -> float:
        wire_s = (len(FLUSH) + length + FRAME_MAX) * self._byte_s
        return wire_s + BOARD_S + self._settings.answer_margin_s
