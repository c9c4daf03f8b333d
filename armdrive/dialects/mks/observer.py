"""Of what moment the answer of an MKS drive is, and how fast the drive has been told to go lately.

An answer does not say which question it answers. It may be that to the oldest one still open, so a
reading is taken to be of any moment from then on.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field

from firmware_protocol.mks import (
    COUNTS_PER_TURN,
    Code,
    Event,
    Failed,
    MoveAbsoluteAxis,
    Outcome,
    Started,
    Status,
    Stray,
    Superseded,
)

LOST_S = 0.3
"""What has not been answered for so long is not answered any more."""


@dataclass(slots=True)
class AskedReadings:
    """When one drive was asked where it is, and where by its orders it was then; not yet answered.

    Counts, seconds.
    """

    asked_s: float = -math.inf
    """When what was read last was asked for, at the earliest."""
    asked_at: float = 0.0
    """Where it was then by its orders."""
    last_s: float = -math.inf
    """When it was asked last."""
    _open: deque[tuple[float, float]] = field(default_factory=lambda: deque(maxlen=16))

    def ask(self, place: float, now_s: float) -> None:
        """Take note that it is asked."""
        while self._open and self._open[0][0] < now_s - LOST_S:
            self._open.popleft()
        self._open.append((now_s, place))
        self.last_s = now_s

    def answered(self) -> None:
        """Take note that it has told where it is."""
        if self._open:
            self.asked_s, self.asked_at = self._open.popleft()

    def place_anew(self, place: float) -> None:
        """Have it be elsewhere than its orders said, in all that is unanswered as well."""
        self.asked_at = place
        self._open = deque(((asked_s, place) for asked_s, _ in self._open), maxlen=16)


@dataclass(slots=True)
class ObservedSpeeds:
    """How fast one drive went, by its orders, until it was given each of the last ones."""

    _until: deque[tuple[float, float]] = field(default_factory=lambda: deque(maxlen=32))

    def change(self, before: float, now_s: float) -> None:
        """Take note of the speed, in counts a second, that ends now."""
        self._until.append((now_s, before))

    def forget(self) -> None:
        """Take note that it stands."""
        self._until.clear()

    def fastest_since(self, since_s: float) -> float:
        """Return the highest that has ended since; 0 where none has."""
        return max((speed for until_s, speed in self._until if until_s > since_s), default=0.0)


# Questions to MKS drives that were given up: what answers them yet is late, and no oddity.
#
# A busy computer hears an answer after it has asked again, and then two answers come.

LATEST_S = 5.0
"""An answer that comes later than this was not lost on its way."""


@dataclass(slots=True)
class LateReplies:
    """When each question was given up, by the drive and the code of its answer. Seconds."""

    _since_s: dict[tuple[int, int], deque[float]] = field(default_factory=dict)

    def give_up(self, node: int, code: int, now_s: float) -> None:
        """Take note that an answer is not waited for any more."""
        self._since_s.setdefault((node, code), deque(maxlen=16)).append(now_s)

    def takes(self, node: int, code: int, now_s: float) -> bool:
        """Tell whether an answer too many is a late one, which it is then no longer."""
        given_up = self._since_s.get((node, code))
        while given_up:
            if now_s <= given_up.popleft() + LATEST_S:
                return True
        return False


# Whether an MKS drive takes its orders no more: it says that one failed, and not that one began.
#
# A drive in flight says that the order has failed which a newer one replaces, and the same of one
# that it refuses; no bit tells which. But right beside the first it says that the newer one began.

BESIDE_S = 0.01
"""What a drive says of an order that it takes comes within so long, before or behind that."""
DENIALS = 2
"""A drive is looked into at so many in a row: of one, the word that it began may have been lost."""


@dataclass(slots=True)
class Rejections:
    """What one drive has said of its orders since it took one. Seconds."""

    refused: int = 0
    """How many targets in a row it said that it failed."""
    due_s: float = math.inf
    """When that is a denial which it has said last; infinity where it takes its orders."""
    _count: int = 0
    _began_s: float = -math.inf

    def heard(self, heard: Event, now_s: float) -> None:
        """Take note of what it says."""
        match heard:
            case Started() | Stray(_, Status(Code.ABSOLUTE_AXIS, Outcome.STARTED)):
                self.refused = self._count = 0
                self.due_s, self._began_s = math.inf, now_s
            case Failed(_, MoveAbsoluteAxis()):
                self.refused += 1
                self._doubt(now_s)
            case Superseded():
                self._doubt(now_s)

    def _doubt(self, now_s: float) -> None:
        if now_s > self._began_s + BESIDE_S:
            self.due_s = min(self.due_s, now_s + BESIDE_S)

    def confirm(self) -> bool:
        """Take what is due for a denial; tell whether there were enough to look into the drive."""
        self.due_s, self._count = math.inf, self._count + 1
        if self._count < DENIALS:
            return False
        self._count = 0
        return True

    def forget(self) -> None:
        """Doubt it no more, whatever it said of orders that are over."""
        self.due_s, self._count = math.inf, 0


# Whether an MKS drive that is seen off its way cannot go on, or was only late and is coming.
#
# Orders come late on a busy computer, or to a bus that stands still for a moment: then a drive
# that is well is as far behind as one that is blocked. It is given time, and looked at again; only
# who has neither come nearer by then nor kept pace is blamed.
#
# Who keeps pace may be far behind its model without danger, since two others look at what that
# would hide: whether all are on the way that was checked, only later (`MksContourError`), and
# whether a count has leapt, as that of a drive does which begins anew (`EncoderJump`). Before
# those, such a drive was tried in simulations to go 54,000 counts beyond its target, and one at
# 60 % of its speed to be 65,000 beside its way, and neither was told. A smaller `FOLLOWED` would
# blame drives whose orders are late.

AGAIN_S = 0.05
"""A second look was asked for at least so long after the first one was heard."""
PACE = 0.5
"""A drive keeps pace that turns by this share of what it should, at least."""
FOLLOWED = 3.0
"""One that keeps pace is waited for if it is off by no more than so many times what is let pass."""


@dataclass(slots=True)
class DriveFollowingError:
    """The look at which one drive was off its way, since it was seen on it. Counts, seconds."""

    heard_s: float = math.inf
    """When that was heard; infinity where nothing is doubted."""
    _count: int = 0
    _apart: float = 0.0

    def forget(self) -> None:
        """Doubt it no more."""
        self.heard_s = math.inf

    def is_too_soon(self, asked_s: float) -> bool:
        """Tell whether a look that was asked for then proves nothing beside the first one.

        A first look that was read late, after a wake, say, is followed by one asked for since.
        """
        return math.isfinite(self.heard_s) and asked_s < self.heard_s + AGAIN_S

    def is_well(self, count: int, place: float, let_pass: float, least: int) -> bool:
        """Tell whether it goes on as it should since the look before, or there was none.

        It has come nearer to where it should be, by its own turning; or it keeps pace with that,
        and is not farther behind than orders that were late account for. `let_pass` is how far off
        nobody doubts it, `least` how far it must have turned for it to count.
        """
        if math.isinf(self.heard_s):
            return True
        way = math.copysign(1.0, self._apart)
        turned, apart = way * (count - self._count), abs(place - count)
        ran = way * (place - self._count - self._apart)
        nearer = apart < abs(self._apart) - least
        paced = turned >= PACE * ran and apart <= FOLLOWED * let_pass
        return turned > least and (nearer or paced)

    def note(self, count: int, place: float, now_s: float) -> None:
        """Take note of where it was found, and where it should have been."""
        self.heard_s, self._count, self._apart = now_s, count, place - count


# Whether one MKS drive was gone for a moment while the others were there: it may have begun anew.
#
# A drive that loses its supply for a tenth of a second counts from zero again, and obeys the next
# target from there. Where it counted near zero anyway its count shows nothing. But what it was
# told meanwhile it never answers, and a drive behind a busy computer or a slow adapter answers all
# of it, late.

TICK_S = 0.01
"""Questions that follow each other sooner are one. One that is not answered, while another drive is
heard, is followed by others so soon: what tells lost frames from a drive that has no power."""
MISSED = 3
"""Whoever has missed so many more in a row, while another drive answered, may have been gone."""
ALONE_S = 0.15
"""One that brakes and is silent for so long may have been gone, though nobody else is heard."""
LATE_S = 0.12
"""An answer that has not come so long after its drive was heard again will not come."""


@dataclass(slots=True)
class Liveness:
    """What one drive has left unanswered. Seconds."""

    obedient: bool = False
    """Whether it answers orders as well: its mode of replies may be that it does not."""
    missed: int = 0
    doubted_s: float = math.inf
    """Since when it may have been gone; infinity where nothing speaks for it."""
    outstanding: int = 0
    """How many orders and questions more than answers there have been."""
    since_s: float = math.inf
    """When it was told what it answers first; infinity where it has nothing to answer."""
    alone: bool = False
    """Whether it brakes, so that others may have nothing to say meanwhile."""
    _before: int = 0
    _last_s: float = -math.inf
    _maybe_s: float = math.inf
    _maybe_owed: int = 0
    _back_s: float = math.inf

    def urge_s(self, others_s: float) -> float:
        """Return when it is asked again, if another one answered then; infinity for not at all."""
        return self._last_s + TICK_S if others_s > self.since_s else math.inf

    @property
    def pending(self) -> bool:
        """Whether it may have been gone, and may answer yet what it was told meanwhile."""
        return math.isfinite(self._maybe_s)

    @property
    def gone_s(self) -> float:
        """Since when it was gone, if it was; infinity where nothing speaks for it."""
        return min(self.doubted_s, self._maybe_s)

    @property
    def owed(self) -> int:
        """How many answers were outstanding when it was heard last."""
        return self._before if math.isfinite(self.since_s) else self.outstanding

    def asked(self, now_s: float, others_s: float, *, counts: bool) -> None:
        """Take note that it is told something, and when another drive answered last.

        What `counts` has one answer, whenever it comes.
        """
        if self.pending and now_s >= self._back_s + LATE_S:
            self.doubted_s, self._maybe_s = min(self.doubted_s, self._maybe_s), math.inf
        if math.isinf(self.since_s):
            self.since_s = self._last_s = now_s
            self._before = self.outstanding
        elif now_s >= self._last_s + TICK_S:
            self._last_s = now_s
            self.missed += others_s > self.since_s
        self.outstanding += counts

    def heard(self, now_s: float, *, counts: bool) -> None:
        """Take note that it says something; what `counts` is the answer to something that did."""
        self.outstanding -= counts
        silent = self.alone and now_s >= self.since_s + ALONE_S
        if (silent or self.missed >= MISSED) and not self.pending:
            self._maybe_s, self._maybe_owed, self._back_s = self.since_s, self._before, now_s
        if self.pending and self.outstanding <= self._maybe_owed:
            self._maybe_s = math.inf  # it has answered all: it was there
        self.missed, self.since_s = 0, math.inf

    def forget(self) -> None:
        """Doubt it no more, and wait for nothing."""
        self.doubted_s = self.since_s = self._maybe_s = math.inf
        self.missed, self.alone = 0, False


# Whether the count of an MKS drive has leapt: no shaft turns so far, or that way, between looks.
#
# A drive whose firmware begins anew within some hundredths of a second answers everything, and
# goes on to its targets from a new zero: beyond them by as much as it had counted. Nothing that it
# tells later shows that, and it keeps pace. A drive that is late, or blocked, stands or turns on;
# it never turns back. So orders and answers may be as late as they like.

MARGIN = COUNTS_PER_TURN // 32
"""Counts by which a loaded shaft may give, without its loop losing it."""
LEAP_LATE_S = 0.3
"""A drive may still obey what it was told so long ago."""


@dataclass(slots=True)
class EncoderJump:
    """The last look at one drive that fitted those before it. Counts, seconds."""

    leapt: bool = False
    """Whether two looks in a row do not fit: one alone may be an answer that was late."""
    suspected: bool = False
    """Whether the last look did not fit: the drive is to be asked again."""
    _count: int | None = None
    _asked_s: float = -math.inf
    _told: tuple[float, float] = (0.0, 0.0)
    _up: ObservedSpeeds = field(default_factory=ObservedSpeeds)
    _down: ObservedSpeeds = field(default_factory=ObservedSpeeds)

    @property
    def since_s(self) -> float:
        """When the last look that fitted was asked for: it leapt since then, if it did."""
        return self._asked_s

    def begin(self, count: int | None, asked_s: float) -> None:
        """Take a drive for standing at a count, and look at it from then on."""
        self._count, self._asked_s = count, asked_s
        self.leapt = self.suspected = False
        self._told = 0.0, 0.0
        self._up.forget()
        self._down.forget()

    def order(self, up: float, down: float, now_s: float) -> None:
        """Take note of an order, and how fast it lets the drive go each way, in counts a second."""
        self._up.change(self._told[0], now_s)
        self._down.change(self._told[1], now_s)
        self._told = up, down

    def weigh(self, count: int, asked_s: float, place: float, now_s: float) -> None:
        """Weigh a look that was asked for then, at a drive that should be at a place by now."""
        if self._count is None or self._fits(count, place, now_s):
            self._count, self._asked_s, self.suspected = count, asked_s, False
        else:
            self.leapt, self.suspected = self.suspected or self.leapt, True

    def _fits(self, count: int, place: float, now_s: float) -> bool:
        before, late_s = self._count or 0, self._asked_s - LEAP_LATE_S
        for_s, left = now_s - self._asked_s, place - before
        up = max(self._told[0], self._up.fastest_since(late_s)) * for_s
        down = max(self._told[1], self._down.fastest_since(late_s)) * for_s
        return min(left, -down) - MARGIN <= count - before <= max(left, up) + MARGIN


# Whether an MKS drive turns as fast as it is told: how far it came, and how far its orders went.
#
# A drive that is too weak for its speed is told a higher one to make up for what it lags, so that
# it stays near its way and gets to its target late. What it turned of what it should have shows
# that, for as long as it lasts. Orders and answers that are late by some hundredths of a second
# show in all drives, and go by.

PACE_LOOKS = 5
"""A drive that is too slow is so at so many looks in a row: half a second."""
PACE_LOOK_S = 0.08
"""Looks that follow each other sooner are one."""
SLACK = 0.75
"""A drive that turns by less than this share of what another one turns is too slow."""


@dataclass(slots=True)
class Lag:
    """How far one drive turned from look to look, and how far it should have. Counts, seconds."""

    _looks: deque[tuple[float, float]] = field(default_factory=lambda: deque(maxlen=PACE_LOOKS))

    _since_s: float = -math.inf

    def note(self, turned: float, ran: float, now_s: float) -> None:
        """Take note of what it turned since the last look, and of what it should have."""
        turned, ran = turned if ran > 0.0 else -turned, abs(ran)
        if self._looks and now_s < self._since_s + PACE_LOOK_S:
            before = self._looks.pop()
            turned, ran = turned + before[0], ran + before[1]
        else:
            self._since_s = now_s
        self._looks.append((turned, ran))

    def forget(self) -> None:
        """Begin anew."""
        self._looks.clear()

    def shares(self, least: float) -> list[float]:
        """Return what it turned at each look of what it should have; none if that is too little."""
        if len(self._looks) < PACE_LOOKS or any(ran < least for _, ran in self._looks):
            return []
        return [turned / ran for turned, ran in self._looks]


def laggard(paces: Sequence[Lag], least: float) -> int | None:
    """Return the index of one that lags behind another one at every look; None for no such one.

    `least` is what it should have turned from look to look. One that moves alone lags behind
    nobody: it is on its way, only late.
    """
    shares = {i: found for i, each in enumerate(paces) if (found := each.shares(least))}
    if len(shares) < 2:
        return None
    slowest = min(shares, key=lambda index: max(shares[index]))
    best = min(max(sum(found) / PACE_LOOKS for found in shares.values()), 1.0)
    return slowest if max(shares[slowest]) < SLACK * best else None
