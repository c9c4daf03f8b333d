"""A motion of a Robko 01: sent once, watched until its motors have arrived or a stop has ended it.

That the board says nothing moves means little: it may say so for 10 ms after it has accepted a
motion. A motion has ended when the positions are its target's.
"""

from __future__ import annotations

from abc import ABC
from collections.abc import Callable, Generator
from typing import TypeAlias

from armdrive.abilities import Abilities
from armdrive.controllers.requests import (
    Alert,
    AlertKind,
    Denied,
    Done,
    Halted,
    Progress,
    Registers,
    Reply,
)
from armdrive.controllers.robko01_exchange import RobkoExchange
from armdrive.controllers.robko01_pacing import PaceMeter, Pacing
from armdrive.controllers.robko01_settings import RobkoSettings
from armdrive.controllers.robko01_way import Way
from firmware_protocol.robko01 import (
    Acknowledged,
    Axes,
    Busy,
    IsMoving,
    MoveRelative,
    Moving,
    Status,
    Stop,
)
from firmware_protocol.robko01 import Event as HostEvent
from kinematics.spaces import Motors

Script: TypeAlias = Generator[float, HostEvent | None, Reply]

FRESH_S = 0.3
"""A look at the motors this long ago still tells where a motion starts from."""
POLL_S, SLOW_POLL_S = 0.01, 0.1
"""How often the motors are looked at: when they may arrive, and on the way there."""
MAY_ARRIVE = 0.7
"""From this share of the expected time on, a motion may have ended."""
STILL_LOOKS, STILL_S = 3, 0.03
"""Motors stand when so many looks, spread over this time, have found them still."""
LOST_S = 0.1
"""How far apart the two looks are that decide whether a motion was lost."""
BUSY_S = 2.0
"""How long a board is waited for that has still something else to finish."""
SENDS = 2
PATIENCE, PATIENCE_S = 4.0, 2.0
"""A motion that takes this many times longer than expected, and then some, is given up."""


class RobkoMotion(RobkoExchange, ABC):
    """Moves, and knows how fast the arm is."""

    def __init__(self, abilities: Abilities, settings: RobkoSettings, baud: int) -> None:
        super().__init__(abilities, settings, baud)
        self._pacing = Pacing(settings.known)
        self._meter = PaceMeter(settings.speed_doubt)

    def _move(self, steps: Motors, rate_hz: float, let_go: Callable[[], bool]) -> Script:
        """Send a motion and wait for its end; once more where it was certainly lost.

        Not where a jog was let go of before its motors were set going.
        """
        began_s = self.now_s
        start = self._seen
        if start is None or self.now_s > self._seen_s + FRESH_S:
            start = yield from self._look()
        if start is None:
            return self.silence(began_s)
        speeds = self._pacing.speeds(tuple(steps), rate_hz)
        message = MoveRelative(Axes(tuple(steps), speeds))
        expected_s = self._pacing.lasts_s(steps.largest, rate_hz)
        for _ in range(SENDS):
            if self.stop_asked or let_go():
                return Halted()
            way = Way(start, steps, expected_s, self.now_s)
            refusal = yield from self._send_move(message, way, let_go)
            if refusal is not None:
                return refusal
            if self.stop_asked:
                return (yield from self._halt(way))
            if not self._out_of_step:
                return (yield from self._watch(way))
            lost = yield from self._was_lost(way)
            if lost is None:
                return self.silence(began_s)
            if not lost:
                return (yield from self._watch(way))
        return self.silence(began_s)

    def _send_move(
        self, message: MoveRelative, way: Way, let_go: Callable[[], bool]
    ) -> Generator[float, HostEvent | None, Reply | None]:
        """Send it, again while the board is busy; return why not, or None where it was sent."""
        text = f"MOVE {' '.join(map(str, way.steps))} at {max(message.axes.speeds_steps_s)}"
        until_s = self.now_s + BUSY_S
        while True:
            way.began_s = self.now_s
            answer = yield from self._ask(message, tries=1, text=text, may_break=True)
            if isinstance(answer, Busy) and self.now_s < until_s and not self.stop_asked:
                yield from self.pause(self.now_s + POLL_S)
                if let_go():
                    return Halted()
                continue
            if isinstance(answer, Busy) and not self.stop_asked:
                return Denied("it is still moving", moved=False)
            refused = isinstance(answer, Acknowledged) and answer.status is not Status.OK
            return self._disabled() if refused else None

    def _disabled(self) -> Reply:
        words = "its motors are disabled: call `enable()`"
        if self._on:
            self._on = False
            told = "the controller has switched its motors off: it was reset, or its watchdog did"
            self.tell(Alert(AlertKind.SWITCHED_OFF, told))
        return Denied(words, moved=False)

    def _was_lost(self, way: Way) -> Generator[float, HostEvent | None, bool | None]:
        """Tell whether nothing of a motion is to be seen; None where nothing can be seen at all."""
        for look in range(2):
            if look:
                yield from self.pause(self.now_s + LOST_S)
            seen = yield from self._look()
            moving = yield from self._mask()
            if seen is None or moving is None:
                return None
            if moving or seen != way.start:
                return False
        return True

    def _mask(self) -> Generator[float, HostEvent | None, int | None]:
        answer = yield from self._ask(IsMoving())
        return answer.value if isinstance(answer, Moving) else None

    def _watch(self, way: Way) -> Script:
        """Look at the motors until they have arrived."""
        still = astray = 0
        last: Motors | None = None
        going_s = way.began_s
        given_up_s = way.began_s + PATIENCE * self._meter.doubt * way.expected_s + PATIENCE_S
        while self.now_s < given_up_s:
            asked_s = self.now_s
            seen = yield from self._look()
            if seen is None:
                return self.silence(way.began_s)
            if not way.left(seen).largest:
                return Done(self._measure(way, going_s, asked_s))
            if not way.holds(seen):  # believed when it is seen twice: an answer may be a late one
                astray += 1
                if astray > 1:
                    return (yield from self._astray(way, seen))
                yield from self.pause(self.now_s + POLL_S)
                continue
            astray, going_s = 0, self.now_s
            self.tell(Progress(Registers(seen)))
            if self.now_s > way.began_s + way.expected_s and seen == last:
                still = still + 1 if (yield from self._mask()) == 0 else 0
            if still >= STILL_LOOKS:
                left = tuple(way.left(seen))
                return Denied(f"the motion has ended {left} steps short of its target")
            last = seen
            if not self.stop_asked:  # one that came during the look would not end this pause
                yield from self.pause(self._next_look_s(way, asked_s))
            if self.stop_asked:
                return (yield from self._halt(way))
        yield from self._halt(way)
        return Denied(f"the motion had not ended after {self.now_s - way.began_s:.1f} s")

    def _measure(self, way: Way, going_s: float, asked_s: float) -> bool:
        """Learn how fast the arm is, and tell whether a motion can have lasted so long.

        After a look that was repeated, or that a suspended program heard late, nobody knows when
        the motors arrived: only that they were still going at the look before.
        """
        prompt = self.now_s <= asked_s + LOST_S
        until_s = self.now_s if prompt else going_s
        return self._meter.learn(way.expected_s, until_s - way.began_s) and prompt

    def _next_look_s(self, way: Way, asked_s: float) -> float:
        may_arrive_s = way.began_s + MAY_ARRIVE * way.expected_s
        return max(asked_s + POLL_S, min(asked_s + SLOW_POLL_S, may_arrive_s))

    def _halt(self, way: Way) -> Script:
        """Have the motors ramp down, and wait until they stand."""
        began_s = self.now_s
        if (yield from self._ask(Stop(), text="STOP")) is None:
            return self.silence(began_s)
        looks, since_s = 0, self.now_s
        last: Motors | None = None
        given_up_s = began_s + PATIENCE * self._meter.doubt * way.expected_s + PATIENCE_S
        while looks < STILL_LOOKS or self.now_s < since_s + STILL_S:
            asked_s = self.now_s
            if asked_s > given_up_s:
                return Denied("the motors were told to stop, and do not come to rest")
            seen, mask = (yield from self._look()), (yield from self._mask())
            if seen is None or mask is None:
                return self.silence(began_s)
            self.tell(Progress(Registers(seen)))
            if mask or seen != last:
                looks, since_s, last = 0, self.now_s, seen
            looks += 1
            yield from self.pause(asked_s + POLL_S)
        arrived = last is not None and not way.left(last).largest
        return Done() if arrived else Halted()

    def _astray(self, way: Way, seen: Motors) -> Script:
        """End a motion that leads elsewhere, and say what positions mean to which it leads."""
        if not seen.largest:
            words = "the controller was reset or lost its power in mid-motion"
            self.restarted(words)
            return Denied(words)
        yield from self._halt(way)
        words = f"the controller reports {tuple(seen)}, which is not on the way that was sent"
        self.tell(Alert(AlertKind.ASTRAY, words))
        return Denied(words)

    def restarted(self, words: str) -> None:
        """Tell that the board has begun anew, which leaves its motors off."""
        self._on = False
        self.tell(Alert(AlertKind.RESTARTED, words))
