"""A motion of a Robko 01: sent once, watched until its motors have arrived or a stop has ended it.

The driver moves by operation 7, which goes to absolute positions. The firmware ignores the speed
of operation 6. Operation 7 obeys its speed, but makes it the axis's top speed for all motions to
come (`Robko01.cpp`, `SUPER.cpp` and AccelStepper; measured in an AVR simulator). Hence:

- An axis that stays where it is must not get a speed: the firmware would make one step there and
  one back. It must not keep a top speed of 0 either: operation 6 of any other program would then
  leave the axis hanging until the board is reset. An axis whose top speed is 0 may get a speed
  without a step. So each motion is two requests: one to the present position with speed 0, which
  moves nothing, and one to the goal that gives every axis a speed.
- A request to a position can be repeated when its answer was lost.
- Positions in requests have 16 bits, and are not wrapped. The board counts further, and reports
  its count wrapped. From such a count, a request to the reported position would turn the motor for
  65536 steps; so the first request of a session is checked before the next, and no motion leads
  past the 16 bits.

That the board says nothing moves means little: it may say so for 10 ms after it has accepted a
motion. A motion has ended when the positions are its target's.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import dataclass
from typing import TypeAlias

from armdrive.dialects.exchange import ScriptIO
from armdrive.dialects.robko01.exchange import MotorPower, RobkoExchange
from armdrive.dialects.robko01.settings import Pacing
from armdrive.dialects.speed_table import PaceMeter
from armdrive.tasks import (
    Alert,
    AlertKind,
    Done,
    Halted,
    Progress,
    ProtocolWarning,
    Registers,
    Reply,
    RequestRejected,
)
from firmware_protocol.robko01 import (
    AXES,
    AXIS_NAMES,
    WORD_MAX,
    WORD_MIN,
    Acknowledged,
    Axes,
    Busy,
    MoveAbsolute,
    MoveSpeed,
    Status,
    Stop,
    wrap,
)
from firmware_protocol.robko01 import Event as HostEvent
from kinematics.spaces import Motors

# A motion of a Robko 01 under way: what is left of it, and whether positions belong to it.


@dataclass(slots=True)
class RobkoPath:
    """A motion under way: where from, where to, and how long it should take."""

    start: Motors
    steps: Motors
    expected_s: float
    began_s: float

    def left(self, seen: Motors) -> Motors:
        """Return the steps still to be made."""
        return Motors(
            map(wrap, (a + b - at for a, b, at in zip(self.start, self.steps, seen, strict=True)))
        )

    def holds(self, seen: Motors) -> bool:
        """Tell whether every motor is between its start and its target."""
        made = (wrap(at - a) for a, at in zip(self.start, seen, strict=True))
        return all(min(0, b) <= m <= max(0, b) for m, b in zip(made, self.steps, strict=True))


Script: TypeAlias = Generator[float, HostEvent | None, Reply]

FRESH_S = 0.3
"""A look at the motors this long ago still tells where a motion starts from."""
POLL_S, SLOW_POLL_S = 0.01, 0.1
"""How often the motors are looked at: when they may arrive, and on the way there."""
MAY_ARRIVE = 0.7
"""From this share of the expected time on, a motion may have ended."""
STILL_LOOKS, STILL_S = 3, 0.03
"""Motors stand when so many looks, spread over this time, have found them still."""
PROMPT_S = 0.1
"""A look that is later than this does not tell when the motors arrived."""
BUSY_S = 2.0
"""How long to wait for a board that is busy. No axis turns so slowly that it makes no step
meanwhile: one that stands for so long, and is called moving, hangs."""
CHECK_S = 0.02
"""How long to wait before looking whether a request to the present position moves anything: each
axis of an AVR board has its turn twice."""
SAME_LOOKS = 5
"""How often to look for two positions in a row that are alike before a motion."""
RESTING_STEPS_S = 5000
"""The speed for axes that rest: the top speed that the AVR firmware begins with."""
STANDSTILL = Axes((0,) * AXES)
SENDS = 2
OVERSHOOT_STEPS = 3
"""How far a stop can take an axis beyond its target. It gives up the target, and the firmware then
reckons a step more than the axis needs, from a speed that its coarse ramp may exceed by a step."""
PATIENCE, PATIENCE_S = 4.0, 2.0
"""A motion that takes this many times longer than expected, and then some, is given up."""


class RobkoStart:
    """Finds out whether a motion may begin, and from where."""

    def __init__(self, io: ScriptIO[HostEvent], exchange: RobkoExchange, power: MotorPower) -> None:
        self._io = io
        self._exchange = exchange
        self._power = power
        self._counts_checked = False

    def prepare(
        self, let_go: Callable[[], bool]
    ) -> Generator[float, HostEvent | None, Motors | Reply]:
        """Set every top speed to 0 where the motors stand; return that place, or why not.

        A busy board is waited for, and an axis that hangs is freed once.
        """
        began_s = self._io.now_s
        until_s, first, freed = began_s + BUSY_S, None, False
        while not self._io.stop_asked and not let_go():
            start = yield from self._standing()
            if start is None:
                return self._io.silence(began_s)
            answer = yield from self._exchange.ask(MoveAbsolute(Axes(tuple(start))), may_break=True)
            if isinstance(answer, Busy):
                first = start if first is None else first
                if self._io.now_s >= until_s and (freed or start != first):
                    return RequestRejected("it is still moving", moved=False)
                if self._io.now_s >= until_s:
                    freed = yield from self._free(answer.moving)
                yield from self._io.pause(self._io.now_s + POLL_S)
            elif isinstance(answer, Acknowledged):
                refused = answer.status is not Status.OK
                return self.disabled() if refused else (yield from self._check_counts(start))
            elif not self._io.stop_asked:
                return self._io.silence(began_s)
        return Halted()

    def _standing(self) -> Generator[float, HostEvent | None, Motors | None]:
        """Return where the motors stand: a wrong place would make a wrong target.

        An answer may be a late one, so it has to agree with another, or with where the last
        motion ended.
        """
        last = self._exchange.stood
        seen = self._exchange.seen
        if seen is None or self._io.now_s > self._exchange.seen_s + FRESH_S:
            seen = yield from self._exchange.look()
        for _ in range(SAME_LOOKS):
            if seen is None or seen == last:
                break
            last, seen = seen, (yield from self._exchange.look())
        self._exchange.stood = seen
        return seen

    def _free(self, moving: int) -> Generator[float, HostEvent | None, bool]:
        """End what makes a standing axis count as moving: all speeds 0, which moves nothing."""
        yield from self._exchange.ask(MoveSpeed(STANDSTILL))
        names = ", ".join(name for axis, name in enumerate(AXIS_NAMES) if moving >> axis & 1)
        self._io.tell(
            ProtocolWarning(
                f"freed axes that another program's speed of 0 had left hanging: {names}"
            )
        )
        return True

    def _check_counts(self, start: Motors) -> Generator[float, HostEvent | None, Motors | Reply]:
        """Return the start, once it is known that the board counts in 16 bits so far.

        With a top speed of 0, an axis that has counted further makes one step, and no more.
        """
        if self._counts_checked:
            return start
        began_s = self._io.now_s
        yield from self._io.pause(began_s + CHECK_S)
        seen, moving = (yield from self._exchange.look()), (yield from self._exchange.mask())
        if seen is None or moving is None:
            return self._io.silence(began_s)
        if moving or seen != start:
            yield from self._exchange.ask(MoveSpeed(STANDSTILL))
            return RequestRejected(
                "an axis has counted past 32767 steps, from where the board cannot move it by "
                "position: reset the board, then home the arm"
            )
        self._counts_checked = True
        return start

    def disabled(self) -> Reply:
        """Refuse a motion whose motors the board calls disabled; tell of it where that is news."""
        words = "its motors are disabled: call `enable()`"
        if self._power.on:
            told = "the controller has switched its motors off: it was reset, or its watchdog did"
            self._power.lost(AlertKind.SWITCHED_OFF, told)
        return RequestRejected(words, moved=False)


class RobkoWatch:
    """Watches a motion under way until it has ended, and ends it where a stop is asked for."""

    def __init__(
        self,
        io: ScriptIO[HostEvent],
        exchange: RobkoExchange,
        power: MotorPower,
        meter: PaceMeter,
    ) -> None:
        self._io = io
        self._exchange = exchange
        self._power = power
        self._meter = meter

    def until_ended(self, way: RobkoPath) -> Script:
        """Look at the motors until they have arrived."""
        still = astray = 0
        last: Motors | None = None
        going_s = due_s = way.began_s
        given_up_s = way.began_s + PATIENCE * self._meter.doubt * way.expected_s + PATIENCE_S
        while True:
            asked_s = self._io.now_s
            seen = yield from self._exchange.look()
            if seen is None:
                return self._io.silence(way.began_s)
            if not way.left(seen).largest:
                self._exchange.stood = seen
                return Done(self._measure(way, going_s, due_s))
            if asked_s >= given_up_s:  # only a look from then on tells: this program may be late
                break
            if not way.holds(seen):  # believed when it is seen twice: an answer may be a late one
                astray += 1
                if astray > 1:
                    return (yield from self._astray(way, seen))
                due_s = self._io.now_s + POLL_S
                yield from self._io.pause(due_s)
                continue
            astray, going_s = 0, asked_s
            self._io.tell(Progress(Registers(seen)))
            if self._io.now_s > way.began_s + way.expected_s and seen == last:
                still = still + 1 if (yield from self._exchange.mask()) == 0 else 0
            if still >= STILL_LOOKS:
                left = tuple(way.left(seen))
                return RequestRejected(f"the motion has ended {left} steps short of its target")
            last = seen
            due_s = self._next_look_s(way, asked_s)
            if not self._io.stop_asked:  # one that came during the look would not end this pause
                yield from self._io.pause(due_s)
            if self._io.stop_asked:
                return (yield from self.halt(way))
        yield from self.halt(way)
        return RequestRejected(
            f"the motion had not ended after {self._io.now_s - way.began_s:.1f} s"
        )

    def _measure(self, way: RobkoPath, going_s: float, due_s: float) -> bool:
        """Learn how fast the arm is, and tell whether a motion can have lasted so long.

        The look that found the motors arrived was due at `due_s`. If it was repeated, or this
        program was late, that does not tell when they arrived: only that they were still going at
        the look before.
        """
        prompt = self._io.now_s <= due_s + PROMPT_S
        until_s = self._io.now_s if prompt else going_s
        return self._meter.learn(way.expected_s, until_s - way.began_s) and prompt

    def _next_look_s(self, way: RobkoPath, asked_s: float) -> float:
        may_arrive_s = way.began_s + MAY_ARRIVE * way.expected_s
        return max(asked_s + POLL_S, min(asked_s + SLOW_POLL_S, may_arrive_s))

    def halt(self, way: RobkoPath) -> Script:
        """Have the motors ramp down, and wait until they stand."""
        began_s = self._io.now_s
        if (yield from self._exchange.ask(Stop(), text="STOP")) is None:
            return self._io.silence(began_s)
        looks, since_s, overdue = 0, self._io.now_s, 0
        last: Motors | None = None
        given_up_s = began_s + PATIENCE * self._meter.doubt * way.expected_s + PATIENCE_S
        while looks < STILL_LOOKS or self._io.now_s < since_s + STILL_S:
            asked_s = self._io.now_s
            seen, mask = (yield from self._exchange.look()), (yield from self._exchange.mask())
            if seen is None or mask is None:
                return self._io.silence(began_s)
            self._io.tell(Progress(Registers(seen)))
            if (
                mask or self._exchange.turning or seen != last
            ):  # the mask has gaps when an axis runs by speed
                looks, since_s, last = 0, self._io.now_s, seen
                overdue += asked_s > given_up_s  # once, this program may have been late
                if overdue > 1:
                    return RequestRejected("the motors were told to stop, and do not come to rest")
            looks += 1
            yield from self._io.pause(asked_s + POLL_S)
        self._exchange.stood = last
        arrived = last is not None and not way.left(last).largest
        return Done() if arrived else Halted(beyond=OVERSHOOT_STEPS)

    def _astray(self, way: RobkoPath, seen: Motors) -> Script:
        """End a motion that leads elsewhere, and say what positions mean to which it leads."""
        if not seen.largest:
            words = "the controller was reset or lost its power in mid-motion"
            self._power.lost(AlertKind.RESTARTED, words)
            return RequestRejected(words)
        yield from self.halt(way)
        words = f"the controller reports {tuple(seen)}, which is not on the way that was sent"
        self._io.tell(Alert(AlertKind.ASTRAY, words))
        return RequestRejected(words)


class RobkoMotion:
    """Makes motions: prepares each, sends it, and watches it to its end."""

    def __init__(
        self,
        io: ScriptIO[HostEvent],
        exchange: RobkoExchange,
        pacing: Pacing,
        start: RobkoStart,
        watch: RobkoWatch,
    ) -> None:
        self._io = io
        self._exchange = exchange
        self._pacing = pacing
        self._start = start
        self._watch = watch

    def move(self, steps: Motors, rate_hz: float, let_go: Callable[[], bool]) -> Script:
        """Send a motion and wait for its end; once more where nothing of it was seen.

        Not where a jog was let go of before its motors were set going.
        """
        began_s = self._io.now_s
        start = yield from self._start.prepare(let_go)
        if not isinstance(start, Motors):
            return start
        target = start + steps
        if not all(WORD_MIN <= each <= WORD_MAX for each in target):
            return _out_of_range(target)
        speeds = self._pacing.speeds(tuple(steps), rate_hz)
        text = f"MOVE {' '.join(map(str, steps))} at {max(speeds)}"
        message = MoveAbsolute(
            Axes(tuple(target), tuple(speed or RESTING_STEPS_S for speed in speeds))
        )
        way = RobkoPath(start, steps, self._pacing.lasts_s(steps.largest, rate_hz), self._io.now_s)
        for _ in range(SENDS):
            if self._io.stop_asked or let_go():
                return Halted()
            way.began_s = self._io.now_s
            answer = yield from self._exchange.ask(message, tries=1, text=text, may_break=True)
            if isinstance(answer, Acknowledged) and answer.status is not Status.OK:
                return self._start.disabled()
            if self._io.stop_asked:
                return (yield from self._watch.halt(way))
            if answer is not None:
                return (yield from self._paced(way, rate_hz))
            seen, moving = (yield from self._exchange.look()), (yield from self._exchange.mask())
            if seen is None or moving is None:
                return self._io.silence(began_s)
            if moving or seen != start:
                return (yield from self._paced(way, rate_hz))
        return self._io.silence(began_s)

    def _paced(self, way: RobkoPath, rate_hz: float) -> Script:
        """Watch a motion, and let it last as long as its rate says.

        The first step comes at once, so slow bursts would follow one another a step too soon.
        """
        reply = yield from self._watch.until_ended(way)
        if isinstance(reply, Done):
            lasts_s = way.steps.largest / self._pacing.usable_hz(rate_hz)
            yield from self._io.pause(way.began_s + lasts_s)
        return reply


def _out_of_range(target: Motors) -> RequestRejected:
    far = next(axis for axis, each in enumerate(target) if not WORD_MIN <= each <= WORD_MAX)
    return RequestRejected(
        f"this would take the {AXIS_NAMES[far]} to {target[far]}, and the board moves no axis past "
        f"{WORD_MIN} or {WORD_MAX}: reset the board, then home the arm",
        moved=False,
    )
