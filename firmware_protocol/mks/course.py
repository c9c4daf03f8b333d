"""The course of the motions of one code on one drive: which of them a reply is about.

A reply names a drive and a code and nothing else. So:

    STARTED     is said of the oldest that is unanswered
    STORED      too; what is stored is under way from the synchronous start on
    DONE,       end the one that is under way; where none is, the oldest that is unanswered,
    LIMIT_STOP  whose STARTED was lost then
    FAILED      is said of the one that was superseded, where there is one; else of the oldest
                that is unanswered, else of the one under way

What gives way to a new target (F5 alone) or to a stop is superseded. By a public transcription of
the manual the drive says FAILED of it, beside the STARTED of the new one, in an order that is not
documented: so a FAILED while a new one is unanswered is taken for the old one. Where that is
wrong, the new one stays unanswered. Duplicated, lost and reordered replies never raise, and may
be taken for another motion's: the position is the better witness.
"""

from __future__ import annotations

from collections import deque
from typing import TypeAlias

from firmware_protocol.mks.actions import Motion, Stop
from firmware_protocol.mks.events import (
    Done,
    Failed,
    LimitStop,
    Started,
    StoredForStart,
    Superseded,
)
from firmware_protocol.mks.values import Code, Outcome

Heard: TypeAlias = Started | Done | LimitStop | StoredForStart | Superseded | Failed

UNANSWERED_MAX = 8
"""How many motions of a code wait for their first reply; of more, the oldest is forgotten."""


class Course:
    """The motions of one code that a drive was sent, and how far they came."""

    def __init__(self, node: int, code: Code) -> None:
        self._node = node
        self._retargets = code is Code.ABSOLUTE_AXIS
        self._unanswered: deque[Motion] = deque(maxlen=UNANSWERED_MAX)
        self._under_way: Motion | None = None
        self._superseded: Motion | None = None
        self._stored: Motion | None = None
        self._begun_unsaid = False

    @property
    def unanswered(self) -> tuple[Motion, ...]:
        """What was sent and not answered, the oldest first."""
        return tuple(self._unanswered)

    @property
    def under_way(self) -> Motion | None:
        """What the drive said it does."""
        return self._under_way

    @property
    def stored(self) -> Motion | None:
        """What waits for the synchronous start."""
        return self._stored

    def send(self, motion: Motion) -> None:
        """Take note of what is sent."""
        self._unanswered.append(motion)

    def go(self) -> None:
        """Take note of the synchronous start, which no drive answers."""
        if self._stored is not None:
            self._begin(self._stored)
            self._stored, self._begun_unsaid = None, True

    def forget(self, motion: Motion) -> None:
        """Wait no longer for the first reply to a motion."""
        if motion in self._unanswered:
            self._unanswered.remove(motion)

    def settle(self) -> None:
        """Take it as known that nothing is under way."""
        self._under_way = self._superseded = None

    def hear(self, outcome: Outcome) -> Heard | None:
        """Return what a reply says, or None where nobody awaits it."""
        match outcome:
            case Outcome.STARTED:
                return self._started()
            case Outcome.STORED:
                return self._to_store()
            case Outcome.FAILED:
                return self._failed()
            case Outcome.DONE:
                ended = self._ended()
                return None if ended is None else Done(self._node, ended)
            case Outcome.LIMIT_STOP:
                ended = self._ended()
                return None if ended is None else LimitStop(self._node, ended)

    def _begin(self, motion: Motion) -> None:
        if self._gives_way_to(motion):
            self._superseded = self._under_way
        self._under_way, self._begun_unsaid = motion, False

    def _gives_way_to(self, motion: Motion) -> bool:
        return self._under_way is not None and (self._retargets or isinstance(motion, Stop))

    def _started(self) -> Started | None:
        if self._unanswered:
            self._begin(self._unanswered.popleft())
        elif not self._begun_unsaid:
            return None
        self._begun_unsaid = False
        return None if self._under_way is None else Started(self._node, self._under_way)

    def _to_store(self) -> StoredForStart | None:
        if not self._unanswered:
            return None
        self._stored = self._unanswered.popleft()
        return StoredForStart(self._node, self._stored)

    def _ended(self) -> Motion | None:
        motion = self._under_way
        if motion is None and self._unanswered:
            motion = self._unanswered.popleft()
        self.settle()
        return motion

    def _failed(self) -> Superseded | Failed | None:
        if self._superseded is None and self._unanswered:
            if not self._gives_way_to(self._unanswered[0]):
                return Failed(self._node, self._unanswered.popleft())
            self._superseded, self._under_way = self._under_way, None
        if self._superseded is not None:
            motion, self._superseded = self._superseded, None
            return Superseded(self._node, motion)
        ended = self._ended()
        return None if ended is None else Failed(self._node, ended)
