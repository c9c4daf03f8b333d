"""The questions about a drive's position, and when a reading was sampled. Seconds.

A reply does not name the question it answers. So a position was sampled at some moment since the
oldest open question was sent.
"""

from __future__ import annotations

import math
from collections import deque

# A question that is still open after this long counts as lost. The slowest reply observed on an
# overloaded computer took 0.18 s.
REPLY_TIMEOUT_S = 0.3
# The median of this many tells how long a drive takes to reply; a late one does not change it.
RECENT_REPLIES = 15
# A reply that is later than this many times the median is missed: on a link that delays every
# message by a random time, the slowest takes twice as long as the mean.
USUAL_WAITS = 2.0
# How much longer the last reply is waited for: a frame may wait that long in the computer or the
# adapter (see `transports/can_link.py`).
LAST_TRY_S = 0.25
# A drive that misses this many polls in a row while another one replies is mute, and may have lost
# its power. On a bus that loses one frame in ten, a sound drive does that once in 750 polls.
MUTE_POLLS = 4
# Tolerance for rounded times.
EPSILON_S = 1e-6
# Questions kept for a drive that never replies: older ones are overdue in any case.
MOST_QUESTIONS = 256


class Questions:
    """The open questions about the position of one drive."""

    def __init__(self) -> None:
        self.timeout_s = REPLY_TIMEOUT_S
        """A question that is still open after this long counts as lost. After a longer outage, the
        replies to later questions may be as late as that."""
        self.asked_s = -math.inf
        """When its position was asked for last."""
        self._questions: deque[float] = deque(maxlen=MOST_QUESTIONS)
        self._waits_s: deque[float] = deque(maxlen=RECENT_REPLIES)
        """How long it took for its latest replies whose question is certain."""

    def asked(self, now_s: float) -> None:
        """Record a question about its position."""
        self._questions.append(now_s)
        self.asked_s = now_s

    def located(self, now_s: float) -> float:
        """Record a position reply; return the earliest moment at which it can be sampled."""
        overdue_s = now_s - self.timeout_s
        while self._questions and self._questions[0] < overdue_s:
            self._questions.popleft()
        if not self._questions:
            return overdue_s
        asked_s = self._questions.popleft()
        if not self._questions:  # else it may be the reply to any of them
            self._waits_s.append(now_s - asked_s)
        return asked_s

    def forget(self) -> None:
        """Take later replies to come in the usual time again."""
        self.timeout_s = REPLY_TIMEOUT_S

    @property
    def longest_wait_s(self) -> float:
        """How long its replies take at most, by how long they usually take; 0 if none came yet."""
        waits_s = sorted(self._waits_s)
        return USUAL_WAITS * waits_s[len(waits_s) // 2] if waits_s else 0.0
