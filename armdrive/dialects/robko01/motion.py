"""A motion of a Robko 01: sent once, then watched until the motors arrive or a stop ends it.

The driver uses operation 7, which moves to absolute positions. Operation 6 (relative) ignores its
speed. Operation 7 obeys its speed, but the speed stays the axis's top speed for all later motions
(`Robko01.cpp`, `SUPER.cpp` and AccelStepper; measured in an AVR simulator). Hence:

- An axis that does not move must not get a speed, because the firmware would make one step forward
  and one back. Its top speed must not stay 0 either: operation 6, sent by any other program, would
  then leave the axis hanging until the board is reset. An axis whose top speed is 0 can take a
  speed without a step. So each motion is two requests: one to the present position with speed 0,
  which moves nothing, and one to the target that gives every axis a speed.
- A request to a position can be repeated after its answer was lost.
- Positions in requests have 16 bits and do not wrap. The board's counter is wider, but the board
  reports it wrapped to 16 bits. Once the counter has left the 16 bits, a request to the reported
  position would turn the motor by 65536 steps. So the first request of a session is checked before
  the second is sent, and no motion leaves the 16 bits.

The board's "nothing moves" proves little: the board may report it for 10 ms after accepting a
motion. A motion has ended when the positions equal its target.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from armdrive.dialects.controller import MOTORS_OFF
from armdrive.dialects.exchange import Script, ScriptIO
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
from firmware_protocol.fields import INT16_MAX, INT16_MIN, wrapped16
from firmware_protocol.robko01 import (
    AXES,
    AXIS_NAMES,
    Acknowledged,
    Axes,
    Busy,
    MoveAbsolute,
    MoveSpeed,
    Status,
    Stop,
)
from firmware_protocol.robko01 import Event as HostEvent
from kinematics.spaces import Motors


@dataclass(frozen=True, slots=True)
class RobkoPath:
    """A motion under way: its start, its steps, and its expected duration."""

    start: Motors
    steps: Motors
    expected_s: float
    began_s: float

    def left(self, seen: Motors) -> Motors:
        """Return the remaining steps."""
        return Motors(map(wrapped16, self.start + self.steps - seen))

    def holds(self, seen: Motors) -> bool:
        """Return whether every motor is between its start and its target."""
        made = (wrapped16(at - a) for a, at in zip(self.start, seen, strict=True))
        return all(min(0, b) <= m <= max(0, b) for m, b in zip(made, self.steps, strict=True))


POLL_S, SLOW_POLL_S = 0.01, 0.1  # polling intervals close to the expected arrival, and before it
MAY_ARRIVE = 0.7  # fraction of the expected duration after which the motors may have arrived
STILL_LOOKS = 4  # standstill: this many equal readings, each `POLL_S` after the one before it
PROMPT_S = 0.1  # a reading later than this does not show when the motors arrived
# How long to wait for a busy board. The slowest axis makes a step in this time: an axis that the
# board reports as moving for this long without a step hangs.
BUSY_S = 2.0
# How long to wait before checking whether a request to the present position moves anything: in
# this time an AVR board serves each axis twice.
CHECK_S = 0.02
SAME_LOOKS = 6  # attempts to read the same position twice in a row before a motion
RESTING_STEPS_S = 5000  # speed for axes that do not move: the AVR firmware's initial top speed
STANDSTILL = Axes((0,) * AXES)
SENDS = 2
# How far a stop can take an axis beyond its target. The stop abandons the target; the firmware
# then ramps down from the speed that it planned for its next step. The worst of all motions and
# moments in the library's arithmetic: four steps, stopped after the third, go on to the eighth.
OVERSHOOT_STEPS = 4
PATIENCE, PATIENCE_S = 4.0, 2.0  # a motion's timeout: a multiple of the expected time, plus 2 s


@dataclass(slots=True, eq=False)
class RobkoMotion:
    """Prepares each motion, sends it, and watches it until it ends."""

    io: ScriptIO[HostEvent]
    exchange: RobkoExchange
    power: MotorPower
    pacing: Pacing
    meter: PaceMeter
    _counts_checked: bool = False

    def move(
        self, steps: Motors, rate_hz: float, released: Callable[[], bool]
    ) -> Script[HostEvent, Reply]:
        """Send a motion and wait for its end; send it again if the motors have not moved.

        A jog whose key is released before the motion is sent does not move.
        """
        began_s = self.io.now_s
        start = yield from self._prepare(released)
        if not isinstance(start, Motors):
            return start
        target = start + steps
        if not all(INT16_MIN <= each <= INT16_MAX for each in target):
            return _out_of_range(target)
        speeds = self.pacing.speeds(tuple(steps), rate_hz)
        text = f"MOVE {' '.join(map(str, steps))} at {max(speeds)}"
        message = MoveAbsolute(
            Axes(tuple(target), tuple(speed or RESTING_STEPS_S for speed in speeds))
        )
        lasts_s = self.pacing.lasts_s(steps.largest, rate_hz)
        self.exchange.stood = None
        for _ in range(SENDS):
            if self.io.stop_asked or released():
                return Halted()
            way = RobkoPath(start, steps, lasts_s, self.io.now_s)
            # one try: whether it may be repeated depends on whether the motors have moved
            answer = yield from self.exchange.ask_once(message, text)
            if isinstance(answer, Acknowledged) and answer.status is not Status.OK:
                return self._disabled()
            if self.io.stop_asked:  # received or not, the motors may be moving
                return (yield from self._halt(way))
            if answer is not None:
                return (yield from self._paced(way, rate_hz))
            if (yield from self.exchange.look()) != start:  # their first step comes at once
                return (yield from self._paced(way, rate_hz))
        return self.io.silence(began_s)

    def _paced(self, way: RobkoPath, rate_hz: float) -> Script[HostEvent, Reply]:
        """Watch a motion, and wait until the time that its rate implies has passed.

        The motors make their first step at once, so without the wait a slow burst would follow its
        predecessor one step interval too soon.
        """
        reply = yield from self._until_ended(way)
        if isinstance(reply, Done):
            lasts_s = way.steps.largest / self.pacing.usable_hz(rate_hz)
            yield from self.io.pause(way.began_s + lasts_s)
        return reply

    # -- before a motion ----------------------------------------------------------------------

    def _prepare(self, released: Callable[[], bool]) -> Script[HostEvent, Motors | Reply]:
        """Set every top speed to 0 at the present position; return it, or the reason to refuse.

        The driver waits for a busy board, and frees a hanging axis once.
        """
        until_s, first, freed = self.io.now_s + BUSY_S, None, False
        while not self.io.stop_asked and not released():
            start = yield from self._standing()
            rest = MoveAbsolute(Axes(tuple(start)))
            answer = yield from self.exchange.ask(rest, until_stop=True)
            if isinstance(answer, Busy):
                first = start if first is None else first
                if self.io.now_s >= until_s:
                    if freed or start != first:
                        return RequestRejected("it is still moving", moved=False)
                    yield from self._free(answer.moving)
                    freed = True
                yield from self.io.pause(self.io.now_s + POLL_S)
            elif isinstance(answer, Acknowledged):
                refused = answer.status is not Status.OK
                return self._disabled() if refused else (yield from self._check_counts(start))
        return Halted()

    def _standing(self) -> Script[HostEvent, Motors]:
        """Return the position at rest; a wrong one would lead to a wrong target.

        A reading may be a late answer, so it must agree with a second reading or with the end of
        the previous motion.
        """
        for _ in range(SAME_LOOKS):
            seen = yield from self.exchange.look()
            if seen == self.exchange.stood:
                break
            self.exchange.stood = seen
        return seen

    def _free(self, moving: int) -> Script[HostEvent, None]:
        """Free axes that hang as "moving" by setting all speeds to 0, which moves nothing.

        Another program leaves them so, and so does a motion of our own that was disturbed between
        the speed of 0 and the move (campaign, robko01 781000077).
        """
        yield from self.exchange.ask(MoveSpeed(STANDSTILL))
        names = ", ".join(name for axis, name in enumerate(AXIS_NAMES) if moving >> axis & 1)
        self.io.notify(ProtocolWarning(f"freed axes that a speed of 0 had left hanging: {names}"))

    def _check_counts(self, start: Motors) -> Script[HostEvent, Motors | Reply]:
        """Return the start after checking that the board's counters are within 16 bits.

        With a top speed of 0, an axis whose counter is beyond 16 bits makes one step and no more.
        """
        if self._counts_checked:
            return start
        yield from self.io.pause(self.io.now_s + CHECK_S)
        seen, moving = (yield from self.exchange.look()), (yield from self.exchange.mask())
        if moving or seen != start:
            yield from self.exchange.ask(MoveSpeed(STANDSTILL))
            return RequestRejected(
                "an axis has counted past 32767 steps, from where the board cannot move it by "
                "position: reset the board, then home the arm"
            )
        self._counts_checked = True
        return start

    def _disabled(self) -> Reply:
        """Refuse a motion while the motors are disabled; alert if the driver had enabled them."""
        if self.power.on:
            why = "the controller has switched its motors off: it was reset, or its watchdog did"
            self.power.lost(AlertKind.SWITCHED_OFF, why)
        return RequestRejected(MOTORS_OFF, moved=False)

    # -- watching a motion ---------------------------------------------------------------------

    def _until_ended(self, way: RobkoPath) -> Script[HostEvent, Reply]:
        """Poll the positions until the motors have arrived."""
        still = off_path = 0
        last: Motors | None = None
        going_s = due_s = way.began_s
        given_up_s = way.began_s + PATIENCE * self.meter.doubt * way.expected_s + PATIENCE_S
        while True:
            asked_s = self.io.now_s
            seen = yield from self.exchange.look()
            if not way.left(seen).largest:
                self.exchange.stood = seen
                self._measure(way, going_s, due_s)
                return Done()
            if asked_s >= given_up_s:  # needs a reading requested after the timeout
                break
            if not way.holds(seen):  # counts once it is read twice: an answer may be a late one
                off_path += 1
                if off_path > 1:
                    return (yield from self._end_off_path(way, seen))
                continue
            off_path, going_s = 0, asked_s
            self.io.notify(Progress(Registers(seen)))
            if self.io.now_s > way.began_s + way.expected_s and seen == last:
                still = still + 1 if (yield from self.exchange.mask()) == 0 else 0
            if still >= STILL_LOOKS:
                left = tuple(way.left(seen))
                return RequestRejected(f"the motion has ended {left} steps short of its target")
            last = seen
            due_s = self._next_look_s(way, asked_s)
            if not self.io.stop_asked:  # a stop requested before this pause would not end it
                yield from self.io.pause(due_s)
            if self.io.stop_asked:
                return (yield from self._halt(way))
        yield from self._halt(way)
        return RequestRejected(
            f"the motion had not ended after {self.io.now_s - way.began_s:.1f} s"
        )

    def _measure(self, way: RobkoPath, going_s: float, due_s: float) -> None:
        """Learn the arm's speed.

        The reading that found the motors at their target was due at `due_s`. If the reading was
        repeated or this program was late, its time is not the time of arrival; the motors are then
        only known to have been moving at the previous reading.
        """
        prompt = self.io.now_s <= due_s + PROMPT_S
        until_s = self.io.now_s if prompt else going_s
        self.meter.learn(way.expected_s, until_s - way.began_s)

    def _next_look_s(self, way: RobkoPath, asked_s: float) -> float:
        may_arrive_s = way.began_s + MAY_ARRIVE * way.expected_s
        return max(asked_s + POLL_S, min(asked_s + SLOW_POLL_S, may_arrive_s))

    def _halt(self, way: RobkoPath) -> Script[HostEvent, Reply]:
        """Ramp the motors down and wait for standstill."""
        began_s = self.io.now_s
        yield from self.exchange.ask(Stop(), "STOP")
        looks = overdue = 0
        last: Motors | None = None
        given_up_s = began_s + PATIENCE * self.meter.doubt * way.expected_s + PATIENCE_S
        while looks < STILL_LOOKS:
            asked_s = self.io.now_s
            seen, mask = (yield from self.exchange.look()), (yield from self.exchange.mask())
            # the mask has gaps when an axis runs by speed
            if mask or self.exchange.turning or seen != last:
                looks, last = 0, seen
                overdue += asked_s > given_up_s  # a single late reading may be this program's fault
                if overdue > 1:
                    return RequestRejected("the motors were told to stop, and do not come to rest")
            looks += 1
            yield from self.io.pause(asked_s + POLL_S)
        return Halted(beyond=OVERSHOOT_STEPS)

    def _end_off_path(self, way: RobkoPath, seen: Motors) -> Script[HostEvent, Reply]:
        """End a motion that has left its path, and report the likely cause."""
        if not seen.largest:
            words = "the controller was reset or lost its power in mid-motion"
            self.power.lost(AlertKind.RESTARTED, words)
            return RequestRejected(words)
        yield from self._halt(way)
        words = f"the controller reports {tuple(seen)}, which is not on the way that was sent"
        self.io.notify(Alert(AlertKind.OFF_PATH, words))
        return RequestRejected(words)


def _out_of_range(target: Motors) -> RequestRejected:
    far = next(axis for axis, each in enumerate(target) if not INT16_MIN <= each <= INT16_MAX)
    return RequestRejected(
        f"this would take the {AXIS_NAMES[far]} to {target[far]}, and the board moves no axis past "
        f"{INT16_MIN} or {INT16_MAX}: reset the board, then home the arm",
        moved=False,
    )
