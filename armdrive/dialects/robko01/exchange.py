"""Exchanges with a Robko 01: a message and its answer, and resynchronization after a lost answer.

The board drops frames that it cannot parse, and a frame with a corrupt length makes it swallow the
frames that follow. So after a lost answer the driver sends zeros, which complete whatever the
board is reading, and then a ping with unique bytes: its answer cannot be a late answer.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from armdrive.dialects.exchange import Script, ScriptIO
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


@dataclass(slots=True, eq=False)
class RobkoExchange:
    """Sends messages, awaits answers, and keeps the latest positions of the motors."""

    io: ScriptIO[HostEvent]
    host: Host
    power: MotorPower
    settings: RobkoSettings
    byte_s: float
    seen: Motors | None = None
    seen_s: float = -math.inf
    turning: bool = False
    """Whether any axis had a speed in the latest report."""
    stood: Motors | None = None
    """The motors' positions at their latest standstill."""
    _number: int = 0
    _met: bool = False
    _out_of_step: bool = True

    def give_up(self) -> None:
        """Stop waiting for the answer; the next message resynchronizes first."""
        self.host.forget()
        self.host.discard()
        self._out_of_step = True

    def feed(self) -> bytes:
        """Return the bytes of a ping that feeds the watchdog between two requests."""
        self.host.forget()
        self.power.feeding(self.io.now_s)
        return self.host.send(self._token())

    def ask(
        self, message: Message, *, tries: int = TRIES, text: str = "", may_break: bool = False
    ) -> Script[HostEvent, Answer | None]:
        """Send a message; return its answer, or None after a timeout.

        With `may_break`, a stop requested during the wait ends it at once.
        """
        asked = self.io.stop_asked  # a message sent while stopping is not broken off
        for _ in range(tries):
            if self._out_of_step and not (yield from self._get_into_step()):
                return None
            answer = yield from self._once(message, text, break_at_stop=may_break and not asked)
            if answer is not None:
                return answer
            if may_break and self.io.stop_asked and not asked:
                return None
            self.give_up()
        return None

    def _once(
        self, message: Message, text: str, *, break_at_stop: bool = False
    ) -> Script[HostEvent, Answer | None]:
        self.host.forget()
        data = self.host.send(message)
        self.io.write(data, text)
        event = yield from self.io.wait_for(
            self.io.now_s + self._patience_s(len(data)),
            # this very request: an equal one may have been sent before, and answered late
            lambda event: isinstance(event, Answered) and event.request is message,
            until_stop=break_at_stop,
        )
        if not isinstance(event, Answered):
            return None
        self.heed(event)
        return event.answer

    def _get_into_step(self) -> Script[HostEvent, bool]:
        """Ping until the board answers; the first time, allow for the board's start-up."""
        until_s = self.io.now_s + (0.0 if self._met else self.settings.boot_s)
        tries = 0
        while tries < TRIES or self.io.now_s < until_s:
            tries += 1
            self.io.write(FLUSH)
            if (yield from self._once(self._token(), "PING")) is not None:
                self._met, self._out_of_step = True, False
                return True
        return False

    def heed(self, event: Answered) -> None:
        """Update the watchdog and the positions from any answer."""
        if isinstance(event.request, Ping | Inputs | Position):
            self.power.fed()
        if isinstance(event.answer, Positions):
            self.seen = Motors(event.answer.axes.positions_steps)
            self.seen_s = self.io.now_s
            self.turning = any(event.answer.axes.speeds_steps_s)

    def look(self, text: str = "") -> Script[HostEvent, Motors | None]:
        """Return the motors' positions as reported, wrapped to 16 bits."""
        answer = yield from self.ask(Position(), text=text)
        return self.seen if isinstance(answer, Positions) else None

    def mask(self) -> Script[HostEvent, int | None]:
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
        wire_s = (len(FLUSH) + length + FRAME_MAX) * self.byte_s
        return wire_s + BOARD_S + self.settings.answer_margin_s
