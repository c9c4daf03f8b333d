"""One exchange with a Robko 01, and how to get back into step with one that fell silent.

The board drops what it does not understand, and a frame with a spoilt length makes it swallow the
next ones. So behind a lost answer zeros end whatever it is reading, and a ping with bytes of its
own comes back as the first answer that is certain to be no late one.
"""

from __future__ import annotations

import math
from collections.abc import Generator

from armdrive.abilities import Abilities
from armdrive.dialects.exchange import BITS_A_BYTE, Scripted
from armdrive.dialects.robko01.settings import RobkoSettings
from armdrive.tasks import Request
from firmware_protocol.robko01 import (
    FLUSH,
    FRAME_MAX,
    Answer,
    Answered,
    Host,
    Inputs,
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


class RobkoExchange(Scripted[HostEvent]):
    """Asks and hears; knows when the watchdog was fed last and where the motors were seen."""

    def __init__(self, abilities: Abilities, settings: RobkoSettings, baud: int) -> None:
        self._host = Host(counts_check=settings.counts_check)
        super().__init__(abilities, self._host)
        self._settings = settings
        self._byte_s = BITS_A_BYTE / baud
        self._number = 0
        self._met = False
        self._out_of_step = True
        self._on = False
        self._fed_s = -math.inf
        self._seen: Motors | None = None
        self._seen_s = -math.inf
        self._turning = False

    def give_up(self) -> None:
        """Give up on the unanswered request; what comes next begins by getting into step."""
        self._host.forget()
        self._host.discard()
        self._out_of_step = True

    def begin(self, request: Request, now_s: float) -> None:
        """Take up a request; a ping that feeds the watchdog is no longer waited for."""
        if not self.busy:
            self._host.forget()
        super().begin(request, now_s)

    def _ask(
        self, message: Message, *, tries: int = TRIES, text: str = "", may_break: bool = False
    ) -> Generator[float, HostEvent | None, Answer | None]:
        """Return the answer to a message, or None where none came.

        With `may_break` a stop that is asked for meanwhile ends the waiting at once.
        """
        asked = self.stop_asked
        for _ in range(tries):
            if self._out_of_step and not (yield from self._get_into_step()):
                return None
            answer = yield from self._once(message, text, break_at_stop=may_break and not asked)
            if answer is not None:
                return answer
            if may_break and self.stop_asked and not asked:
                return None
            self.give_up()
        return None

    def _once(
        self, message: Message, text: str, *, break_at_stop: bool = False
    ) -> Generator[float, HostEvent | None, Answer | None]:
        self._host.forget()
        data = self._host.send(message)
        self.say(data, text)
        until_s = self.now_s + self._patience_s(len(data))
        while not (break_at_stop and self.stop_asked):
            heard = yield until_s
            if isinstance(heard, Answered) and heard.request is message:
                self._heed(heard)
                return heard.answer
            if heard is not None:
                self.unasked(heard)
            elif self.now_s >= until_s:  # all that has come is read by now
                break
        return None

    def _get_into_step(self) -> Generator[float, HostEvent | None, bool]:
        """Ping until the board answers; the first time as long as it may take to start."""
        until_s = self.now_s + (0.0 if self._met else self._settings.boot_s)
        tries = 0
        while tries < TRIES or self.now_s < until_s:
            tries += 1
            self.say(FLUSH)
            if (yield from self._once(self._token(), "PING")) is not None:
                self._met, self._out_of_step = True, False
                return True
        return False

    def _heed(self, heard: Answered) -> None:
        """Note what an answer shows, whoever asked for it."""
        if isinstance(heard.request, Ping | Inputs | Position):
            self._fed_s = self.now_s
        if isinstance(heard.answer, Positions):
            self._seen = Motors(heard.answer.axes.positions_steps)
            self._seen_s = self.now_s
            self._turning = any(heard.answer.axes.speeds_steps_s)

    def _look(self, text: str = "") -> Generator[float, HostEvent | None, Motors | None]:
        """Return where the motors are, as reported: wrapped to 16 bits."""
        answer = yield from self._ask(Position(), text=text)
        return self._seen if isinstance(answer, Positions) else None

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
