"""What is known of one MKS drive: where it was seen, and where by its orders it is by now.

Counts of the encoder, seconds. The model turns as the drive does: towards its target, no faster
than told, by the ramp of its `acc`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from armdrive.dialects.mks.observer import (
    PACE,
    AskedReadings,
    DriveFollowingError,
    EncoderJump,
    Lag,
    Liveness,
    ObservedSpeeds,
    Rejections,
)
from firmware_protocol.mks import COUNTS_PER_TURN, acc_of, ramp_rpm_s

# The ramps of MKS drives, in counts a second squared, and shared so that all keep in step.

COUNTS_S_PER_RPM = COUNTS_PER_TURN / 60.0
"""Counts a second of one rpm."""
LEAST_SHARE = 0.1
"""A slow drive's ramp is at least this share of the steepest: it has corners to follow."""


def slope_of(acc: int) -> float:
    """Return a ramp in counts a second squared; infinity for 0, which has none."""
    return ramp_rpm_s(acc) * COUNTS_S_PER_RPM


def shared_acc(acc: int, share: float) -> int:
    """Return the ramp of a drive that goes at a share of the fastest one's speed.

    So all come to their speeds, and to rest, in the same time, and stay in proportion.
    """
    return acc_of(max(share, LEAST_SHARE) * ramp_rpm_s(acc)) if acc else 0


def whole_rpm(rpm: int, most: int) -> int:
    """Return a speed that a drive can be told: at least 1, and no more than so much."""
    return min(max(rpm, 1), most)


STEP_S = 0.005
"""The model goes on in steps of this length."""
SLOW = 2.0 * COUNTS_S_PER_RPM
"""A drive this slow stops at once."""
WAY_S = 0.1
"""A drive may be behind its model by what it runs in this time: loops and wires are late."""
PROMPT_S = 0.03
"""An answer that took longer is of another moment than now."""
ASKED_S = 0.05
"""Questions that follow each other sooner are one look."""
BRAKES_SURELY = 1.1
"""How much steeper than it just needs a drive brakes at its end."""
HEEDED_S = 0.003
"""An order takes so long to be heeded at most: a frame, those before it, a loop that is behind."""


@dataclass(slots=True)
class MksDrive:
    """One drive: its id, the motor's name, and its state by its answers and by its orders."""

    node: int
    name: str
    acc: int = 0
    """Its ramp, by the drive's own measure."""
    seen: int | None = None
    """The encoder's count when it was read last."""
    seen_s: float = -math.inf
    heard_s: float = -math.inf
    answered_s: float = -math.inf
    """When it answered something last; it tells the end of a motion unasked."""
    position: float = 0.0
    speed: float = 0.0
    target: int = 0
    least: int = 0
    most: int = 0
    """From where to where it was sent since it stood last."""
    told: float = 0.0
    """The speed that it was told, in counts a second."""
    ordered_s: float = -math.inf
    """When it was sent anywhere last."""
    at_s: float = 0.0
    moving: bool = False
    """Whether it has been sent somewhere, and was not seen to stand since."""
    fresh: bool = False
    """Whether it stands as it was found, and was sent nowhere since."""
    doubt: DriveFollowingError = field(default_factory=DriveFollowingError)
    """Whether it was seen off its way."""
    unanswered: int = 0
    """How often it was looked at, by asking where it is, since it was heard last."""
    counted_s: float = -math.inf
    """When it was looked at last."""
    denials: Rejections = field(default_factory=Rejections)
    """Whether it takes its orders."""
    stopped_at: float = 0.0
    """Where it was by its orders when it was told to stop."""
    stopped_off: float = 0.0
    """How far off that it may have been."""
    questions: AskedReadings = field(default_factory=AskedReadings)
    speeds: ObservedSpeeds = field(default_factory=ObservedSpeeds)
    met: tuple[float, float] = (0.0, 0.0)
    """Where it was at the last look, and where by its orders."""
    gap: Liveness = field(default_factory=Liveness)
    """Whether it was gone for a moment."""
    behind: float = 0.0
    """How far ahead of it its model was when it was heard last: of a late answer, too far."""
    leap: EncoderJump = field(default_factory=EncoderJump)
    """Whether it was seen where no shaft can have turned to."""
    pace: Lag = field(default_factory=Lag)

    def __str__(self) -> str:
        return f"drive {self.node} ({self.name})"

    def rest_at(self, count: int, now_s: float) -> None:
        """Take it for standing at a count."""
        self.position, self.speed, self.target, self.told = float(count), 0.0, count, 0.0
        self.least = self.most = count
        self.gap.forget()
        self.speeds.forget()
        self.at_s, self.moving, self.fresh = now_s, False, False
        self._place_anew()

    def _place_anew(self) -> None:
        self.doubt.forget()
        self.pace.forget()
        self.questions.place_anew(self.position)
        self.behind = 0.0
        self.met = (self.position, self.position)

    @property
    def slope(self) -> float:
        """Its ramp, in counts a second squared."""
        return slope_of(self.acc)

    def send_to(self, target: int, rpm: int, acc: int, now_s: float) -> None:
        """Take in an order."""
        self.advance(now_s)
        self.speeds.change(self.fastest, now_s)
        self.acc, self.fresh, self.ordered_s = acc, False, now_s
        self.target, self.told, self.moving = target, rpm * COUNTS_S_PER_RPM, True
        up, down = (self.told if way * (target - self.position) > 0.0 else 0.0 for way in (1, -1))
        self.leap.order(max(up, self.speed), max(down, -self.speed), now_s)
        self.least, self.most = min(self.least, target), max(self.most, target)

    def ramp_to(self, target: int, acc: int, share: float) -> int:
        """Return the ramp by which it goes to a target: its share, or what it needs to end there.

        A gentler one than that by which it came to its speed would have it run past its end, or
        than it brakes by: its model may be there a moment earlier.
        """
        shared = shared_acc(acc, share)
        if self.moving and target == self.target:
            shared = max(shared, min(self.acc, acc))
        left = abs(target - self.position) - abs(self.speed) * HEEDED_S
        brakes = BRAKES_SURELY * self.speed**2 / (2.0 * max(left, 1.0))
        if not acc or brakes <= slope_of(shared):
            return shared
        needed = acc_of(brakes / COUNTS_S_PER_RPM)
        return min(needed + (slope_of(needed) < brakes), acc)

    def advance(self, now_s: float) -> None:
        """Let the model go on until now."""
        while self.at_s < now_s:
            if self.position == self.target and not self.speed:
                self.at_s = now_s
                return
            step_s = min(STEP_S, now_s - self.at_s)
            self._go(step_s)
            self.at_s = max(self.at_s + step_s, math.nextafter(self.at_s, math.inf))

    def _go(self, step_s: float) -> None:
        left, slope = self.target - self.position, self.slope
        fastest = self.told if math.isinf(slope) else math.sqrt(2.0 * slope * abs(left))
        wanted = math.copysign(min(self.told, fastest), left)
        most = slope * step_s
        speed = self.speed + min(max(wanted - self.speed, -most), most)
        way = (self.speed + speed) / 2.0 * step_s if math.isfinite(most) else speed * step_s
        self.speed = speed
        arrives = abs(way) >= abs(left) and way * left >= 0.0
        if arrives and abs(speed) <= max(2.0 * most, SLOW):
            self.position, self.speed = float(self.target), 0.0
        else:
            self.position += way

    def see(self, count: int, now_s: float) -> None:
        """Take note of where it is by its encoder."""
        self.advance(now_s)
        self.seen, self.seen_s = count, now_s
        self.leap.weigh(count, self.questions.asked_s, self.position, now_s)
        self.behind = self.position - count

    def rpm_within(self, target: int, time_s: float) -> int:
        """Return the least speed that has it at a target within a time, from where it was seen.

        Its orders may have been lost: then its model is there already, and would let it creep.
        """
        way = target - self.position
        left = abs(way) + max(math.copysign(1.0, way) * self.behind, 0.0)
        return math.ceil(left / time_s / COUNTS_S_PER_RPM)

    def ask(self, now_s: float) -> None:
        """Take note that it is asked where it is: its answer is of some moment from now on."""
        self.advance(now_s)
        if not self.unanswered or now_s >= self.counted_s + ASKED_S:
            self.unanswered, self.counted_s = self.unanswered + 1, now_s
        self.questions.ask(self.position, now_s)

    def stop(self, corridor: float, now_s: float) -> None:
        """Take note that it is told to stop: it rests between here and where it was sent."""
        self.advance(now_s)
        self.stopped_at = self.position
        self.stopped_off = corridor + self.late_by(now_s)

    def rests_off(self, count: int) -> bool:
        """Tell whether it came to rest where no stop of it could: it counts anew, say."""
        low, high = sorted((self.stopped_at, float(self.target)))
        beside = max(low - count, count - high, 0.0)
        return bool(self.told) and beside > self.stopped_off

    def off_by(self, count: int, now_s: float) -> float:
        """Return how far a count that was heard is off the model, beyond what is only late."""
        self.advance(now_s)
        late = self.late_by(min(self.questions.asked_s, now_s))
        low, high = sorted((self.questions.asked_at, self.position))
        return max(low - count - late, count - high - late, 0.0)

    def late_by(self, asked_s: float) -> float:
        """Return what it runs in the time that it may be late, by its orders of that time."""
        ordered = self.told if self.moving else 0.0
        lately = self.speeds.fastest_since(asked_s - WAY_S)
        return max(abs(self.speed), ordered, lately) * WAY_S

    def found_near(self, there: int, reach: int) -> int:
        """Return where it stands: where it was left, if it was found within reach of that."""
        if self.fresh and abs(self.target - there) <= reach:
            self.rest_at(there, self.at_s)
            self.fresh = True
        return self.target

    def count(self, reach: int) -> int:
        """Return its count as a register: that of its target where it stands within reach of it."""
        seen = self.target if self.seen is None else self.seen
        return seen if self.moving or abs(seen - self.target) > reach else self.target

    def passes(self, count: int, margin: int) -> bool:
        """Tell whether its way led by a count."""
        return self.least - margin <= count <= self.most + margin

    @property
    def fastest(self) -> float:
        """No faster than this does it run, in counts a second, by its orders."""
        return max(abs(self.speed), self.told)

    def anchor(self, count: int, now_s: float) -> None:
        """Have the model be where the drive was found, on its way to where it was sent."""
        left = self.target - count
        self.position, self.at_s = float(count), now_s
        self.speed = math.copysign(self.told, left) if left and self.moving else 0.0
        self._place_anew()

    def believe(self, count: int, gain: float) -> None:
        """Draw the model towards what was read, if that is of now, and of a drive that turns.

        The model would wait for one that is blocked, which would so never be found.
        """
        turned, ran = count - self.met[0], self.position - self.met[1]
        self.pace.note(turned, ran, self.at_s)
        prompt = self.at_s <= self.questions.last_s + PROMPT_S
        if prompt and turned * ran >= PACE * ran * ran:
            self.position += gain * (count - self.position)
        self.met = (count, self.position)


# What of an MKS drive's count speaks for its having begun anew, and the words for that.


def counts_anew(drive: MksDrive, reach: int, now_s: float) -> bool:
    """Tell whether a drive's count speaks for its having begun anew, at zero.

    It leapt to where it can have run from zero; or zero is not on its way; or it stands, and counts
    from zero within the turn that it is in; or it was gone for a moment, and has counted no more
    since than it may have run from zero.
    """
    seen = drive.seen or 0
    if drive.leap.leapt and abs(seen) <= reach + _ran_since(drive, drive.leap.since_s, now_s):
        return True
    if abs(seen) <= reach and not drive.passes(0, reach):
        return True
    if not drive.moving and _counts_within_its_turn(drive.target, seen, reach):
        return True
    gone_s = drive.gap.gone_s
    return drive.moving and gone_s < now_s and abs(seen) <= reach + _ran_since(drive, gone_s, now_s)


def _ran_since(drive: MksDrive, since_s: float, now_s: float) -> float:
    """Return how far a drive may have run since then, as fast as any of its orders let it."""
    return (now_s - since_s) * max(drive.fastest, drive.speeds.fastest_since(since_s))


def _counts_within_its_turn(target: int, seen: int, reach: int) -> bool:
    """Tell whether whole turns are missing of where one stands: its encoder knows the angle."""
    turns = round((target - seen) / COUNTS_PER_TURN)
    near = abs(target - seen - turns * COUNTS_PER_TURN) <= reach
    return bool(turns) and near and -reach <= seen < COUNTS_PER_TURN + reach


def anew_words(drive: MksDrive) -> str:
    """Say that a drive began anew, and how surely that is known."""
    if math.isinf(drive.gap.gone_s):
        return f"{drive} was reset or lost its power: it counts from zero again"
    return (
        f"{drive} was gone for a moment in motion, and counts {drive.seen}: it was reset or lost "
        "its power, most likely, and counts from zero again. Look at its supply and its plug"
    )
