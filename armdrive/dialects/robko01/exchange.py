"""One exchange with a Robko 01, and how to get back into step with one that fell silent.

The board drops what it does not understand, and a frame with a spoilt length makes it swallow the
next ones. So behind a lost answer zeros end whatever it is reading, and a ping with bytes of its
own comes back as the first answer that is certain to be no late one.
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

TRIES = 3
"""How often something that may be said twice is said."""
BOARD_S = 0.02
"""How long a board may think about an answer; 3 ms were seen."""
UNMET = 9
"""So many tokens are used in turn before the first answer: 1 to 9, which no dialect takes for a
letter, a line end or a real-time command."""
FEEDS = 3.0
"""A watchdog is fed so many times in the time that it grants."""


class MotorPower:
    """Whether the motors have current, and the firmware's watchdog, which may take it from them.

    `watchdog_s` is how long the firmware goes on without hearing anything; 0 where it has none.
    """

    def __init__(self, io: ScriptIO[HostEvent], watchdog_s: float) -> None:
        self._io = io
        self._watchdog_s = watchdog_s
        self._feeding_s = -math.inf
        self.on = False
        self.fed_s = -math.inf
        """When the board answered last to what feeds its watchdog."""

    @property
    def starved(self) -> bool:
        """Whether the watchdog has run out, and the motors are off without a word of it."""
        runs_out_s = self.fed_s + self._watchdog_s
        return bool(self._watchdog_s) and self.on and self._io.now_s > runs_out_s

    @property
    def due_s(self) -> float:
        """When to feed the watchdog next; infinity where nothing has to be fed."""
        if not self._watchdog_s or not self.on or self.starved:
            return math.inf
        return max(self.fed_s, self._feeding_s) + self._watchdog_s / FEEDS

    def feeding(self, now_s: float) -> None:
        """Note that the watchdog is sent something now."""
        self._feeding_s = now_s

    def fed(self) -> None:
        """Note that the watchdog counts from now."""
        self.fed_s = max(self.fed_s, self._io.now_s)

    def lost(self, kind: AlertKind, words: str) -> None:
        """Tell that the motors were switched off, or the board restarted, which leaves them off."""
        self.on = False
        self._io.tell(Alert(kind, words))


class RobkoExchange:
    """Asks and hears; knows where the motors were seen last, and where they stood."""

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
        """Whether any axis had a speed at the last look."""
        self.stood: Motors | None = None
        """Where the motors were when they stood last."""

    def give_up(self) -> None:
        """Give up on the unanswered request; what comes next begins by getting into step."""
        self._host.forget()
        self._host.discard()
        self._out_of_step = True

    def forget(self) -> None:
        """Wait no longer for the answer to a ping that feeds the watchdog."""
        self._host.forget()

    def feed(self) -> bytes:
        """Return what feeds the watchdog between two requests."""
        self._host.forget()
        self._power.feeding(self._io.now_s)
        return self._host.send(self._token())

    def ask(
        self, message: Message, *, tries: int = TRIES, text: str = "", may_break: bool = False
    ) -> Generator[float, HostEvent | None, Answer | None]:
        """Return the answer to a message, or None where none came.

        With `may_break` a stop that is asked for meanwhile ends the waiting at once.
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
        self._io.say(data, text)
        heard = yield from self._io.hear(
            self._io.now_s + self._patience_s(len(data)),
            lambda one: isinstance(one, Answered) and one.request is message,
            until_stop=break_at_stop,
        )
        if not isinstance(heard, Answered):
            return None
        self.heed(heard)
        return heard.answer

    def _get_into_step(self) -> Generator[float, HostEvent | None, bool]:
        """Ping until the board answers; the first time as long as it may take to start."""
        until_s = self._io.now_s + (0.0 if self._met else self._settings.boot_s)
        tries = 0
        while tries < TRIES or self._io.now_s < until_s:
            tries += 1
            self._io.say(FLUSH)
            if (yield from self._once(self._token(), "PING")) is not None:
                self._met, self._out_of_step = True, False
                return True
        return False

    def heed(self, heard: Answered) -> None:
        """Note what an answer shows, whoever asked for it."""
        if isinstance(heard.request, Ping | Inputs | Position):
            self._power.fed()
        if isinstance(heard.answer, Positions):
            self.seen = Motors(heard.answer.axes.positions_steps)
            self.seen_s = self._io.now_s
            self.turning = any(heard.answer.axes.speeds_steps_s)

    def look(self, text: str = "") -> Generator[float, HostEvent | None, Motors | None]:
        """Return where the motors are, as reported: wrapped to 16 bits."""
        answer = yield from self.ask(Position(), text=text)
        return self.seen if isinstance(answer, Positions) else None

    def mask(self) -> Generator[float, HostEvent | None, int | None]:
        """Return which axes the board calls moving, one bit each."""
        answer = yield from self.ask(IsMoving())
        return answer.value if isinstance(answer, Moving) else None

    def _token(self) -> Ping:
        """Return a ping with bytes that no ping before it had for a long time.

        Until the board is known to be a Robko's, with bytes that mean nothing in other dialects
        either: a 10, say, would end a line that was left half sent to a GRBL board.
        """
        self._number = (self._number + 1) % (1 << 16) if self._met else self._number % UNMET + 1
        return Ping(self._number.to_bytes(2, "big"))

    def _patience_s(self, length: int) -> float:
        wire_s = (len(FLUSH) + length + FRAME_MAX) * self._byte_s
        return wire_s + BOARD_S + self._settings.answer_margin_s
