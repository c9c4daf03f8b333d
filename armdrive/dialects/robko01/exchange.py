"""Exchanges with a Robko 01: a message and its answer, and resynchronization after a lost answer.

The board drops frames that it cannot parse, and a frame with a corrupt length makes it swallow the
frames that follow. So after a lost answer the driver sends zeros, which complete whatever the
board is reading, and then a ping with unique bytes: its answer cannot be a late answer.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeVar

from armdrive.dialects.exchange import TRIES, Obstructed, Script, ScriptIO
from armdrive.dialects.robko01.settings import RobkoSettings
from armdrive.tasks import Alert, AlertKind, Halted
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

AnswerT = TypeVar("AnswerT", bound=Answer)

BOARD_S = 0.02  # longest processing time of the board; 3 ms were measured
# Until the first answer, pings carry the bytes 1 to 9: no dialect takes these for a letter, a line
# end or a real-time command.
FIRST_TOKENS = 9
FEEDS_PER_TIMEOUT = 3.0  # so that a lost ping does not let the arm sag


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

    def feeding(self) -> None:
        """Record that a message that feeds the watchdog is being sent now."""
        self._feeding_s = self._io.now_s

    def fed(self) -> None:
        """Record that the board has answered, so that its watchdog counts from now."""
        self.fed_s = self._io.now_s

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
    turning: bool = False
    """Whether any axis had a speed in the latest report."""
    stood: Motors | None = None
    """Where the motors stand; None once a motion is sent, until they have arrived."""
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
        self.power.feeding()
        return self.host.send(self._token())

    def ask(
        self, message: Message, text: str = "", *, until_stop: bool = False
    ) -> Script[HostEvent, Answer]:
        """Send a message that is safe to repeat; return its answer.

        Raises `Obstructed` if the board does not answer and, with `until_stop`, if a stop is
        requested meanwhile; so that is for messages that move nothing.
        """
        began_s = self.io.now_s
        for _ in range(TRIES):
            yield from self._get_into_step()
            answer = yield from self._once(message, text, until_stop=until_stop)
            if answer is not None:
                return answer
            if until_stop and self.io.stop_asked:
                raise Obstructed(Halted())
            self.give_up()
        raise Obstructed(self.io.silence(began_s))

    def ask_once(self, message: Message, text: str) -> Script[HostEvent, Answer | None]:
        """Send a message once; return its answer, or None after a timeout or a stop request."""
        yield from self._get_into_step()
        answer = yield from self._once(message, text, until_stop=True)
        if answer is None and not self.io.stop_asked:
            self.give_up()
        return answer

    def _once(
        self, message: Message, text: str, *, until_stop: bool = False
    ) -> Script[HostEvent, Answer | None]:
        self.host.forget()
        data = self.host.send(message)
        self.io.write(data, text)
        event = yield from self.io.wait_for(
            self.io.now_s + self._patience_s(len(data)),
            lambda event: isinstance(event, Answered),
            until_stop=until_stop,
        )
        if not isinstance(event, Answered):
            return None
        self.heed(event)
        return event.answer

    def _get_into_step(self) -> Script[HostEvent, None]:
        """After a lost answer, ping until the board answers; at first, allow for its start-up.

        Raises `Obstructed` if it does not answer.
        """
        began_s, tries = self.io.now_s, 0
        until_s = began_s + (0.0 if self._met else self.settings.boot_s)
        while self._out_of_step:
            if tries >= TRIES and self.io.now_s >= until_s:
                raise Obstructed(self.io.silence(began_s))
            tries += 1
            self.io.write(FLUSH)
            if (yield from self._once(self._token(), "PING")) is not None:
                self._met, self._out_of_step = True, False

    def heed(self, event: Answered) -> None:
        """Update the watchdog and the positions from any answer."""
        if isinstance(event.request, Ping | Inputs | Position):
            self.power.fed()
        if isinstance(event.answer, Positions):
            self.seen = Motors(event.answer.axes.positions_steps)
            self.turning = any(event.answer.axes.speeds_steps_s)

    def reading(
        self, message: Message, kind: type[AnswerT], text: str = ""
    ) -> Script[HostEvent, AnswerT]:
        """Return the board's answer to a question. Raises `Obstructed` if it is of another kind."""
        began_s = self.io.now_s
        answer = yield from self.ask(message, text)
        if not isinstance(answer, kind):
            raise Obstructed(self.io.silence(began_s))
        return answer

    def look(self, text: str = "") -> Script[HostEvent, Motors]:
        """Return the motors' positions as reported, wrapped to 16 bits."""
        answer = yield from self.reading(Position(), Positions, text)
        return Motors(answer.axes.positions_steps)

    def mask(self) -> Script[HostEvent, int]:
        """Return the axes that the board reports as moving, one bit each."""
        answer = yield from self.reading(IsMoving(), Moving)
        return answer.value

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
