"""What is known of the drives on a bus, by what each was told and asked, and what it told.

A reading is not a point in time: it is a count, and the span of time that it may be of, since an
answer does not say which question it answers. An order is no fact: it may be obeyed late, or never.
From both follows the interval in which a healthy shaft can be. A verdict says whether a reading
lies in it, or for how long none came.

    verdict     when                                                            then
    fits        in reach, and where its orders have it, give or take            -
                what it follows late
    doubted     out of reach once                                               asked at once, and
                                                                                used for nothing
    behind      in reach, not where its orders have it; comes nearer, or        watched
                turns half as far as they go
    blocked     the same, and does not                                          ends the motion
    restarted   out of reach twice, or back from an absence with answers        ends the motion
                owed; and it counts what it can have run from zero
    elsewhere   out of reach twice, and not that                                ends the motion
    off way     no one time fits the places of all, at two looks                ends the motion
    weak        turned less than three quarters of what another one did,        ends the motion
                at five looks, and is half a corridor beside its way
    mute        left four looks unanswered, another one did not                 ends the motion
    silent      all have left ten unanswered                                    ends the motion

The intervals, for a reading that was read at r and asked for at q or later:

    reach       from the last reading that was in it: as far as any order in force lets a drive
                turn since; also where its orders have had it of late (a blocked shaft that comes
                free springs there), and the give of a loaded shaft
    following   from where to where its orders had it between q - late_s and r, and a corridor
    from zero   what any order in force lets it turn since the moment that it may have restarted
    rest        behind a stop: between where its orders had it and its goal, and a corridor

An order is in force from when it is sent until ANSWERED_S after its successor was sent. What no
interval expresses are the rules of `ledger` (absence, late replies, rejections) and `weak` here.

Pure: no clock, no wire. Counts, seconds.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import Enum

from armdrive.dialects.bus.ledger import ANSWERED_S, LOOK_S, Ledger, Rejections
from armdrive.dialects.bus.way import Course, Interval, Way
from kinematics.spaces import Motors

LATE_S = 0.1
"""What a drive was told so long ago it may still follow: orders and looks come at most so late on a
computer that is not overloaded (docs/background/measurements.md)."""
PROGRESSES = 0.5
"""A drive that is behind progresses if it turns at least this share of what its orders do."""
DRAWN = 0.3
"""How much of what a reading is beside it a course is drawn towards it: half in two looks."""
PROMPT_S = 0.03
"""An answer takes no longer on a computer that is not busy (docs/background/measurements.md)."""
LOOKS = 2
"""At so many looks in a row the drives are beside their way, before one is blamed."""
WEAK_LOOKS = 5
"""A drive that is too slow is so at so many looks in a row."""
WEAK = 0.75
"""A drive that turns by less than this share of what another one turns is too slow."""
WEIGHED = 0.1
"""... where it should turn by this share of the corridor from look to look, or more."""
APART_S = 0.08
"""... and looks that follow each other sooner are one: orders and answers that are late by some
hundredths of a second show in all drives, and go by."""
HELD_UP_S = 0.06
"""A bus on which nobody has answered for so long, though somebody was asked, is held up: an answer
takes no longer than `answer_s` (0.05 as delivered), which the adapter may double."""
MUTE_LOOKS = 4
"""A drive that answers none of so many looks is mute, where another one answers: one frame in ten
lost makes that of one look in 750."""
SILENT_LOOKS = 10
"""So many are given to drives that all are silent: then it is the computer that is late, mostly."""


@dataclass(frozen=True, slots=True)
class Bounds:
    """How far from its orders a healthy drive may be.

    At rest it is within `rest` of its place. In motion it may be a `corridor` beside what it may
    still follow: what it was told up to `late_s` ago. A loaded shaft may give by `give` without its
    loop losing it. `turn` is one turn of an encoder that keeps its angle, 0 for none.
    """

    rest: int
    corridor: float
    give: float
    turn: int = 0
    late_s: float = LATE_S


class Finding(Enum):
    """What a verdict is: see the table above."""

    FITS = "fits"
    DOUBTED = "doubted"
    BEHIND = "behind"
    BLOCKED = "blocked"
    RESTARTED = "restarted"
    ELSEWHERE = "elsewhere"
    OFF_WAY = "off way"
    WEAK = "weak"
    MUTE = "mute"
    SILENT = "silent"

    @property
    def ends(self) -> bool:
        """Whether a motion ends by it."""
        return self not in (Finding.FITS, Finding.DOUBTED, Finding.BEHIND)


@dataclass(frozen=True, slots=True)
class Verdict:
    """What was concluded of a drive: where it was read, where it could be, and by how much not."""

    node: int
    finding: Finding
    count: int
    place: float
    off: float = 0.0


@dataclass(slots=True)
class _Look:
    """Where a drive was read, and where its orders had it then."""

    count: float
    place: float
    read_s: float


class ObservedDrive:
    """One drive: what it told, what its orders make of it, and what is concluded of both."""

    def __init__(self, node: int, name: str, bounds: Bounds) -> None:
        self.node, self.name, self.bounds = node, name, bounds
        self.course = Course()
        self.ledger = Ledger()
        self.rejections = Rejections()
        self.count: int | None = None
        """Where it was read last."""
        self.read_s = -math.inf
        self.asked_s = -math.inf
        """No reading is of an earlier moment than the last one."""
        self.said_s = -math.inf
        """When anything was heard of it last, asked or not."""
        self.moving = False
        """Whether it has been sent somewhere, and was not seen to stand since."""
        self.fresh = False
        """Whether it stands as it was found, and was sent nowhere since."""
        self.lag = 0.0
        """By how much its orders were ahead of it when it was read last."""
        self.verdict: Verdict | None = None
        self.sent = Interval(0.0, 0.0)
        """From where to where it was sent since it stood last."""
        self._fit: tuple[float, float] | None = None
        self._outside = 0
        self._doubt: _Look | None = None
        self._met: _Look | None = None
        self._shares: deque[tuple[float, float]] = deque(maxlen=WEAK_LOOKS)
        self._share_s = -math.inf
        self._rest = Interval(-math.inf, math.inf)

    def __str__(self) -> str:
        return f"drive {self.node} ({self.name})"

    # -- what happens to it -------------------------------------------------------------------

    @property
    def goal(self) -> int:
        """Where it was sent last, or stands."""
        return round(self.course.goal)

    def order(self, goal: int, speed: float, slope: float, now_s: float) -> None:
        """Take in an order: how fast, and by which ramp."""
        self.course.order(goal, speed, slope, now_s)
        self.moving, self.fresh = True, False
        self.sent = Interval(min(self.sent.low, goal), max(self.sent.high, goal))

    def stop(self, now_s: float) -> None:
        """Take note that it is told to stop: it rests between here and its goal."""
        self.course.advance(now_s)
        ends = sorted((self.course.place, self.course.goal))
        self._rest = Interval(*ends).widened(self.bounds.corridor + self._late(now_s))

    def rest_at(self, count: int, now_s: float) -> None:
        """Take it for standing at a count."""
        self.course.rest_at(count, now_s)
        self.moving = self.fresh = False
        self.sent, self._rest = Interval(count, count), Interval(-math.inf, math.inf)
        self.ledger.forget()
        self._begin_anew(now_s)

    def anchor(self, now_s: float) -> None:
        """Take it for being where it was read, on its way to where it was sent."""
        place, left = float(self.count or 0), self.course.goal - (self.count or 0)
        speed = math.copysign(self.course.told, left) if left and self.moving else 0.0
        self.course.put(place, speed if math.isfinite(speed) else 0.0, now_s)
        self._begin_anew(now_s)

    def watch(self) -> None:
        """Judge it by what is read from the last reading on: a motion begins."""
        self._fit = None if self.count is None else (float(self.count), self.asked_s)
        self._outside, self.verdict = 0, None
        self.ledger.forget()  # whatever it missed while it stood, it was read since
        self.rejections.forget()

    def _begin_anew(self, now_s: float) -> None:
        self._doubt, self.lag = None, 0.0
        self._shares.clear()
        self._met = _Look(self.course.place, self.course.place, now_s)

    # -- what is read of it -------------------------------------------------------------------

    def read(self, count: int, now_s: float) -> None:
        """Take note of where it is, and conclude what that means."""
        course = self.course
        course.advance(now_s)
        self.asked_s = max(self.ledger.placed(), now_s - ANSWERED_S)
        self.count, self.read_s = count, now_s
        self.ledger.conclude(now_s)
        if self._fit is None or count in self._reach(now_s):
            self._fit, self._outside = (float(count), self.asked_s), 0
            self.lag = course.place - count
        else:
            self._outside += 1
        finding, off = self._weigh(now_s)
        self.verdict = Verdict(self.node, finding, count, course.place, off)
        if self.moving and finding in (Finding.FITS, Finding.BEHIND):
            self._draw(count, now_s)

    def _weigh(self, now_s: float) -> tuple[Finding, float]:
        count = self.count or 0
        if self._outside >= LOOKS:
            since_s = self._fit[1] if self._fit else now_s
            anew = self.counts_from_zero(since_s, now_s)
            return (Finding.RESTARTED if anew else Finding.ELSEWHERE), 0.0
        if math.isfinite(self.ledger.away_s):
            if self.counts_from_zero(self.ledger.away_s, now_s):
                return Finding.RESTARTED, 0.0
            self.ledger.acquit()  # its count denies it
        if self._outside:
            return Finding.DOUBTED, 0.0
        off = self._following(now_s).beyond(count)
        if not off:
            self._doubt = None
            return Finding.FITS, 0.0
        before = self._doubt
        if before is not None and self.asked_s < before.read_s + LOOK_S:
            return Finding.BEHIND, off  # two looks in one prove nothing
        if before is not None and not self._progresses(before):
            return Finding.BLOCKED, off
        self._doubt = _Look(count, self.course.place, now_s)
        return Finding.BEHIND, off

    def _progresses(self, before: _Look) -> bool:
        """Tell whether it has come nearer by its own turning, or turns half as far as it should."""
        count, place = self.count or 0, self.course.place
        way = math.copysign(1.0, before.place - before.count)
        turned, ran = way * (count - before.count), way * (place - before.place)
        nearer = abs(place - count) < abs(before.place - before.count) - self.bounds.rest
        return turned > self.bounds.rest and (nearer or turned >= PROGRESSES * ran)

    def _draw(self, count: int, now_s: float) -> None:
        """Draw its course towards what was read of it.

        A shaft that does not turn draws nothing: its orders would wait for it, and never find that
        it is blocked. A reading draws that came right behind the last question: an older one is of
        another moment.
        """
        course, met = self.course, self._met or _Look(count, self.course.place, now_s)
        turned, ran = count - met.count, course.place - met.place
        self._note_share(turned, ran, now_s)
        prompt = now_s <= self.ledger.asked_s + PROMPT_S
        if prompt and turned * ran >= PROGRESSES * ran * ran:
            span = course.hull(self.ledger.asked_s, now_s)
            course.draw(DRAWN * (min(count - span.low, 0.0) + max(count - span.high, 0.0)))
        self._met = _Look(count, course.place, now_s)

    def _note_share(self, turned: float, ran: float, now_s: float) -> None:
        turned, ran = turned if ran > 0.0 else -turned, abs(ran)
        if self._shares and now_s < self._share_s + APART_S:
            before = self._shares.pop()
            turned, ran = turned + before[0], ran + before[1]
        else:
            self._share_s = now_s
        self._shares.append((turned, ran))

    def shares(self) -> list[float]:
        """Return what it turned at each look of what it should have; none where that is little."""
        least = WEIGHED * self.bounds.corridor
        if len(self._shares) < WEAK_LOOKS or any(ran < least for _, ran in self._shares):
            return []
        return [turned / ran for turned, ran in self._shares]

    # -- where it can be ----------------------------------------------------------------------

    def _reach(self, now_s: float) -> Interval:
        """Return where a shaft can be that was in reach at the last reading."""
        count, since_s = self._fit or (float(self.count or 0), now_s)
        hull = self.course.hull(self.asked_s - self.bounds.late_s, now_s)
        orders = self.course.in_force(since_s, ANSWERED_S)
        up = max((order.up for order in orders), default=0.0)
        down = max((order.down for order in orders), default=0.0)
        goals = [order.goal for order in orders] or [self.course.goal]
        brakes = self.course.brakes
        high = count + min(_ran(up, now_s - since_s), max(max(goals) - count + brakes, 0.0))
        low = count - min(_ran(down, now_s - since_s), max(count - min(goals) + brakes, 0.0))
        found = Interval(min(low, hull.low, count), max(high, hull.high, count))
        return found.widened(self.bounds.give)

    def _following(self, now_s: float) -> Interval:
        """Return where its orders have it, if it follows them no later than it may."""
        hull = self.course.hull(self.asked_s - self.bounds.late_s, now_s)
        return hull.widened(self.bounds.corridor)

    def _late(self, now_s: float) -> float:
        """Return what it turns in the time by which it may be late."""
        return _ran(self._fastest(now_s), self.bounds.late_s)

    def _fastest(self, since_s: float) -> float:
        orders = self.course.in_force(since_s, ANSWERED_S)
        return max((max(each.up, each.down) for each in orders), default=0.0)

    def margin(self, now_s: float) -> float:
        """Return how far it may be beside a way that all go together."""
        return self.bounds.corridor + self._late(now_s - self.bounds.late_s)

    def counts_from_zero(self, since_s: float, now_s: float) -> bool:
        """Tell whether it counts what it can have run from zero since then, or turns are missing.

        An encoder may know its angle within a turn, and count from there.
        """
        count, rest = self.count or 0, self.bounds.rest
        if abs(count) <= rest + _ran(self._fastest(since_s), now_s - since_s):
            return True
        if self.moving or not self.bounds.turn:
            return False
        turns = round((self.goal - count) / self.bounds.turn)
        near = abs(self.goal - count - turns * self.bounds.turn) <= rest
        return bool(turns) and near and -rest <= count < self.bounds.turn + rest

    @property
    def is_elsewhere(self) -> bool:
        """Whether it counts what no shaft can have turned to: it was read out of reach twice."""
        found = None if self.verdict is None else self.verdict.finding
        return found in (Finding.RESTARTED, Finding.ELSEWHERE)

    @property
    def has_restarted(self) -> bool:
        """Whether it counts from zero again."""
        return self.verdict is not None and self.verdict.finding is Finding.RESTARTED

    @property
    def rests_astray(self) -> bool:
        """Whether it came to rest where no stop of it could: it was turned, say."""
        return bool(self.course.told) and (self.count or 0) not in self._rest

    @property
    def is_near(self) -> bool:
        """Whether it was read where it was sent."""
        return self.count is not None and abs(self.count - self.goal) <= self.bounds.rest

    def sent_lately(self, now_s: float) -> Interval:
        """Return from where to where any order may lead it that it has not obeyed yet."""
        goals = [order.goal for order in self.course.in_force(now_s, ANSWERED_S)]
        return Interval(min(goals, default=self.goal), max(goals, default=self.goal))

    @property
    def on_its_way(self) -> bool:
        """Whether its way led by where it was read."""
        return (self.count or 0) in self.sent.widened(self.bounds.corridor)

    # -- its register -------------------------------------------------------------------------

    @property
    def register(self) -> int:
        """Its count: that of its goal where it stands within reach of it, since it trembles."""
        if self.count is None or (not self.moving and self.is_near):
            return self.goal
        return self.count

    def found_near(self, there: int, now_s: float) -> int:
        """Return where it stands: where it was left, if it was found within reach of that."""
        if self.fresh and abs(self.goal - there) <= self.bounds.rest:
            self.rest_at(there, now_s)
            self.fresh = True
        return self.goal


class Observer:
    """The drives of one arm, and what is concluded of them together."""

    def __init__(self, drives: Sequence[ObservedDrive]) -> None:
        self.drives = tuple(drives)
        self.returned_s = math.inf
        """When somebody was heard again after nobody had been for a while; infinity for never."""
        self._by_node = {drive.node: drive for drive in self.drives}
        self._beside = 0

    def __getitem__(self, node: int) -> ObservedDrive:
        return self._by_node[node]

    def __contains__(self, node: int | None) -> bool:
        return node in self._by_node

    def watch(self) -> None:
        """Judge all by what is read from now on: a motion begins."""
        self._beside, self.returned_s = 0, math.inf
        for drive in self.drives:
            drive.watch()

    @property
    def heard_s(self) -> float:
        """When any drive answered something last."""
        return max(drive.ledger.heard_s for drive in self.drives)

    def told(self, node: int, now_s: float, *, owes: bool) -> None:
        """Take note that something is said to a drive that it is to answer."""
        others = (each.ledger.heard_s for each in self.drives if each.node != node)
        self[node].ledger.told(now_s, max(others, default=0.0), owes=owes)

    def heard(self, node: int, now_s: float, *, settles: bool, asked: bool = True) -> None:
        """Take note that a drive says something, as in `Ledger.heard`.

        Where nobody was heard for a while, each of them may have been away: a supply that fails
        looks like a bus that is held up, but what is told meanwhile is never answered.
        """
        braking = any(drive.ledger.alone for drive in self.drives)
        if asked and self.unheard_s(now_s) > HELD_UP_S and not braking:
            self.returned_s = now_s
            for drive in self.drives:
                drive.ledger.suspect(now_s + ANSWERED_S)
                drive.ledger.unheard_looks = 0  # nobody was heard: that is no drive's fault
        self[node].ledger.heard(now_s, settles=settles, asked=asked)

    @property
    def pending(self) -> bool:
        """Whether one that may have been away may answer yet what it was told meanwhile."""
        return any(drive.ledger.pending for drive in self.drives)

    def unheard_s(self, now_s: float) -> float:
        """Return for how long nobody has answered although somebody was asked since; 0 for not."""
        heard_s = self.heard_s
        opened = (drive.ledger.open_s for drive in self.drives)
        return max(now_s - min((at_s for at_s in opened if at_s >= heard_s), default=math.inf), 0.0)

    @property
    def doubtful(self) -> tuple[ObservedDrive, ...]:
        """Return those whose last reading is used for nothing."""
        return tuple(
            each
            for each in self.drives
            if each.verdict is not None and each.verdict.finding is Finding.DOUBTED
        )

    @property
    def doubted(self) -> tuple[int, ...]:
        """The ids of those, as far as they are to be asked again."""
        return tuple(each.node for each in self.doubtful if not each.ledger.is_asked)

    @property
    def due_s(self) -> float:
        """When a drive is to be spoken to next for what it has said, or has not."""
        heard_s = self.heard_s
        asked_s = min(each.ledger.due_s(heard_s) for each in self.drives)
        return min(asked_s, self.denied_s)

    @property
    def denied_s(self) -> float:
        """When a drive denies what it was told; infinity where none does."""
        return min(each.rejections.due_s for each in self.drives)

    def wants(self, now_s: float) -> tuple[int, ...]:
        """Return who is to be asked again: whoever has not answered, while others did."""
        heard_s = self.heard_s
        return tuple(each.node for each in self.drives if now_s >= each.ledger.due_s(heard_s))

    # -- what is concluded --------------------------------------------------------------------

    def judge(self) -> Verdict | None:
        """Return what ends a motion by what one drive told, or did not."""
        for drive in self.drives:
            if drive.verdict is not None and drive.verdict.finding.ends:
                return drive.verdict
        return self.unheard()

    def unheard(self) -> Verdict | None:
        """Return what ends a motion in which drives are asked again and again, and not heard."""
        drive = max(self.drives, key=lambda each: each.ledger.unheard_looks)
        others = self.heard_s > drive.ledger.open_s
        if drive.ledger.unheard_looks <= (MUTE_LOOKS if others else SILENT_LOOKS):
            return None
        finding = Finding.MUTE if others else Finding.SILENT
        return Verdict(drive.node, finding, drive.count or 0, drive.course.place)

    def compare(self, way: Way, asked_at_s: float, period_s: float, now_s: float) -> Verdict | None:
        """Weigh where all were at one look beside the way that they go together.

        `asked_at_s` is when on the way that should have been. Drives that are late together are on
        their way, only later; one that lags alone leads the arm off it.
        """
        counts = [drive.count or 0 for drive in self.drives]
        slow = self._weak()
        if slow is not None:
            off = abs(way.at(slow, asked_at_s) - counts[slow])
            if off > self.drives[slow].bounds.corridor / 2.0:
                return self._beside_way(slow, way.at(slow, asked_at_s), Finding.WEAK)
        margins = [drive.margin(now_s) for drive in self.drives]
        late_s = min(asked_at_s + period_s, way.end_s)
        if way.passes(counts, margins, max(late_s - 1.0, 0.0), late_s):
            self._beside = 0
            return None
        self._beside += 1
        if self._beside < LOOKS:
            return None
        worst = max(
            range(len(counts)),
            key=lambda motor: abs(way.at(motor, late_s) - counts[motor]) / margins[motor],
        )
        return self._beside_way(worst, way.at(worst, late_s), Finding.OFF_WAY)

    def _beside_way(self, motor: int, place: float, finding: Finding) -> Verdict:
        drive, count = self.drives[motor], self.drives[motor].count or 0
        return Verdict(drive.node, finding, count, place, abs(round(place) - count))

    def _weak(self) -> int | None:
        """Return the index of a drive that turns less than another one at every look.

        One that moves alone lags behind nobody: it is on its way, only late.
        """
        found = {i: shares for i, each in enumerate(self.drives) if (shares := each.shares())}
        if len(found) < 2:
            return None
        slowest = min(found, key=lambda motor: max(found[motor]))
        best = min(max(sum(shares) / WEAK_LOOKS for shares in found.values()), 1.0)
        return slowest if max(found[slowest]) < WEAK * best else None


def unwrapped(
    drives: Iterable[ObservedDrive], registers: Motors, near: Motors, now_s: float
) -> Motors:
    """Take drives that were found to tremble about where they were left for being there still.

    A closed loop holds within some counts. What is expected of a drive is its own count from then
    on. Nothing wraps: an arm does not turn so far.
    """
    return Motors(
        drive.found_near(there, now_s) if count == drive.goal else count
        for drive, count, there in zip(drives, registers, near, strict=True)
    )


def _ran(speed: float, for_s: float) -> float:
    """Return how far a speed leads in a time; an infinite one in no time leads anywhere."""
    return speed * for_s if math.isfinite(speed) else math.inf
