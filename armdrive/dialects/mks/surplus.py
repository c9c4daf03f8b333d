"""Replies beyond the questions: late ones, and those of a second drive with the same id.

A reply names its sender and the kind of its question, not the question. So the replies of each kind
are counted against the questions. A surplus one may be the late reply to a question that was asked
again; more are of a second drive: every drive is shipped with id 1.
"""

from __future__ import annotations

from collections import Counter, deque

from armdrive.dialects.bus.drives import SURPLUS_LIMIT


class SurplusAnswers:
    """Counts by which number each drive's replies exceed the questions, by drive and code.

    Both are counted for as long as they come, so late replies do not count as surplus.
    """

    def __init__(self) -> None:
        self._surplus: Counter[tuple[int, int]] = Counter()

    def asked(self, node: int, code: int) -> None:
        """Record a question that has one reply."""
        self._surplus[node, code] -= 1

    def answered(self, node: int, code: int) -> None:
        """Record a reply, expected or not."""
        self._surplus[node, code] += 1

    def clear(self) -> None:
        """Start counting from zero."""
        self._surplus.clear()

    @property
    def shared(self) -> tuple[int, ...]:
        """The ids that more than one drive has replied to."""
        over = {node for (node, _), more in self._surplus.items() if more >= SURPLUS_LIMIT}
        return tuple(sorted(over))

    def owed_by(self, node: int, code: int) -> int:
        """Return how many questions to a drive were not answered."""
        return max(-self._surplus[node, code], 0)

    @property
    def owed(self) -> bool:
        """Whether a question is still open."""
        return any(more < 0 for more in self._surplus.values())


LATE_REPLY_MAX_S = 5.0
"""A reply to a question that was given up longer ago than this is not explained by lateness."""


class LateReplies:
    """When each question was given up, by drive and reply code. Seconds.

    A busy computer asks again before it has read the first reply, and then receives two.
    """

    def __init__(self) -> None:
        self._given_up_s: dict[tuple[int, int], deque[float]] = {}

    def give_up(self, node: int, code: int, now_s: float) -> None:
        """Record that a reply is no longer waited for."""
        self._given_up_s.setdefault((node, code), deque(maxlen=16)).append(now_s)

    def takes(self, node: int, code: int, now_s: float) -> bool:
        """Return whether a late reply explains this surplus one; each explains only one."""
        given_up = self._given_up_s.get((node, code))
        while given_up:
            if now_s <= given_up.popleft() + LATE_REPLY_MAX_S:
                return True
        return False
