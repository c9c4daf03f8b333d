"""What one drive was asked and told, and has not answered. Seconds.

An answer does not say which question it answers. So a reading is of some moment since the oldest
question that was open when it came, and whoever owes answers for long was perhaps not there.
"""

from __future__ import annotations

import math
from collections import Counter, deque

ANSWERED_S = 0.3
"""What has not been answered for so long is not answered any more."""
TICK_S = 0.01
"""Questions that follow each other sooner are one. One that is not answered, while another drive is
heard, is followed by others so soon: what tells lost frames from a drive that has no power."""
MISSED = 4
"""Whoever has missed so many more in a row, while another drive answered, may have been away: of
drives that are there, a bus that loses one frame in ten makes that of one look in 750."""
ALONE_S = 0.15
"""One that brakes and is silent for so long may have been away, though nobody else is heard."""
RETURN_S = 0.12
"""An answer that has not come so long after its drive was heard again will not come, where the
others are heard in time."""
LOOK_S = 0.05
"""A second look was asked for at least so long after the first was read."""
EPSILON_S = 1e-6
"""What rounding may take off a time."""
UNHEARD_S = 0.1
"""Questions that follow each other sooner are one that was left unanswered."""


class Ledger:
    """The questions to one drive that are open, and what it never answered.

    A drive that loses its supply for a tenth of a second counts from zero again, and obeys the next
    order from there. Where it counted near zero anyway its count shows nothing. But what it was
    told meanwhile it never answers, and a drive behind a busy computer or a slow adapter answers
    all of it, late.
    """

    def __init__(self) -> None:
        self.answers_orders = False
        """Whether it answers orders as well as questions: it may be set up so that it does not."""
        self.unheard_looks = 0
        """How often it was asked where it is since it was heard last."""
        self.heard_s = -math.inf
        """When it answered something last."""
        self.told_s = -math.inf
        """When something was said to it that it is to answer last."""
        self.open_s = math.inf
        """When it was told what it answers first; infinity where it has nothing to answer."""
        self.away_s = math.inf
        """Since when it was away; infinity where nothing speaks for it."""
        self.alone = False
        """Whether it brakes, so that others may have nothing to say meanwhile."""
        self._questions: deque[float] = deque()
        self.asked_s = -math.inf
        """When it was asked last where it is."""
        self._looked_s = -math.inf
        self._owed = self._owed_before = self._missed = 0
        self._ticked_s = -math.inf
        self._maybe_s = self._until_s = math.inf
        self._maybe_owed = 0

    # -- what happens -------------------------------------------------------------------------

    def asked(self, now_s: float) -> None:
        """Take note that it is asked where it is."""
        while self._questions and self._questions[0] < now_s - ANSWERED_S:
            self._questions.popleft()
        self._questions.append(now_s)
        self.asked_s = now_s
        if not self.unheard_looks or now_s >= self._looked_s + UNHEARD_S - EPSILON_S:
            self.unheard_looks, self._looked_s = self.unheard_looks + 1, now_s

    def told(self, now_s: float, others_s: float, *, owes: bool) -> None:
        """Take note that something is said to it, and when another drive answered last.

        What it `owes` an answer to has exactly one, whenever that comes.
        """
        self.told_s = now_s
        if math.isinf(self.open_s):
            self.open_s = self._ticked_s = now_s
            self._owed_before = self._owed
        elif now_s >= self._ticked_s + TICK_S - EPSILON_S:
            self._ticked_s = now_s
            self._missed += others_s > self.open_s
        self._owed += owes

    def placed(self) -> float:
        """Take note that it has told where it is; return from when on that may be so."""
        return self._questions.popleft() if self._questions else -math.inf

    def heard(self, now_s: float, *, settles: bool, asked: bool = True) -> None:
        """Take note that it says something; what `settles` is one of the answers that it owes.

        What it says without being `asked`, as that a motion has ended, shows that it is there, and
        not that it hears.
        """
        self._owed -= settles
        silent = self.alone and now_s >= self.open_s + ALONE_S
        if silent or self._missed >= MISSED:
            self.suspect(now_s + RETURN_S)
        if self.pending and self._owed <= self._maybe_owed:
            self._maybe_s = math.inf  # it has answered all: it was there
        self._missed, self.open_s = 0, math.inf
        if asked:
            self.heard_s, self.unheard_looks = now_s, 0

    def suspect(self, until_s: float) -> None:
        """Take it for having been away if it has not answered all that it owes until a moment."""
        if not self.pending:
            self._maybe_s, self._maybe_owed = self.open_s, self._owed_before
            self._until_s = until_s

    def conclude(self, now_s: float) -> None:
        """Take it for having been away, if it has not answered in time what it owes."""
        if self.pending and now_s >= self._until_s:
            self.away_s, self._maybe_s = min(self.away_s, self._maybe_s), math.inf

    def acquit(self) -> None:
        """Take it for having been there."""
        self.away_s = math.inf

    def forget(self) -> None:
        """Doubt it no more, and wait for nothing."""
        self.away_s = self.open_s = self._maybe_s = math.inf
        self._missed, self.unheard_looks, self.alone = 0, 0, False

    # -- what it comes to ---------------------------------------------------------------------

    def due_s(self, others_s: float) -> float:
        """Return when it is asked again, if another drive answered; infinity for not at all."""
        return self._ticked_s + TICK_S if others_s > self.open_s else math.inf

    @property
    def is_asked(self) -> bool:
        """Whether it has not told yet where it is."""
        return bool(self._questions)

    @property
    def pending(self) -> bool:
        """Whether it may have been away, and may answer yet what it was told meanwhile."""
        return math.isfinite(self._maybe_s)


SHARED = 2
"""So many more answers than questions are those of two drives; one may be a frame sent twice."""


class SurplusAnswers:
    """Counts how many more answers each drive gave to a question than it was asked, by its code.

    All are counted, asked and heard, so that answers that come late are none too many.
    """

    def __init__(self) -> None:
        self._surplus: Counter[tuple[int, int]] = Counter()

    def asked(self, node: int, code: int) -> None:
        """Take note of a question that has one answer."""
        self._surplus[node, code] -= 1

    def answered(self, node: int, code: int) -> None:
        """Take note of an answer, whoever waits for it."""
        self._surplus[node, code] += 1

    def clear(self) -> None:
        """Begin to count."""
        self._surplus.clear()

    @property
    def shared(self) -> tuple[int, ...]:
        """The ids to which more than one drive has answered."""
        return tuple(sorted({node for (node, _), more in self._surplus.items() if more >= SHARED}))

    @property
    def owed(self) -> bool:
        """Whether a question is unanswered."""
        return any(more < 0 for more in self._surplus.values())


LATEST_S = 5.0
"""An answer that comes later than this was not lost on its way."""


class LateReplies:
    """When each question was given up, by the drive and the code of its answer. Seconds.

    A busy computer hears an answer after it has asked again, and then two answers come.
    """

    def __init__(self) -> None:
        self._since_s: dict[tuple[int, int], deque[float]] = {}

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


BESIDE_S = 0.01
"""What a drive says of an order that it takes comes within so long, before or behind that."""
DENIALS = 2
"""A drive is looked into at so many in a row: of one, the word that it began may have been lost."""


class Rejections:
    """What one drive has said of its orders since it took one. Seconds.

    A drive in flight says that the order has failed which a newer one replaces, and the same of one
    that it refuses; no bit tells which. But right beside the first it says that the newer one
    began.
    """

    def __init__(self) -> None:
        self.due_s = math.inf
        """When that is a denial which it has said last; infinity where it takes its orders."""
        self._count = 0
        self._began_s = -math.inf

    def taken(self, now_s: float) -> None:
        """Take note that an order has begun."""
        self._count = 0
        self.due_s, self._began_s = math.inf, now_s

    def refused(self, now_s: float) -> None:
        """Take note that an order has failed: this one, or the one that it replaced."""
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
