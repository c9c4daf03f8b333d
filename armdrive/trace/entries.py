"""The entries of a recording, one per event with its time, and the ring that keeps the latest."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from enum import StrEnum
from itertools import islice
from typing import NamedTuple, Self

from armdrive.status import Current, State, Trust
from kinematics.spaces import Motors
from kinematics.text import counted


class Topic(StrEnum):
    """The topics by which a person filters the log."""

    BYTES = "bytes"
    REQUESTS = "requests"
    CALLS = "calls"
    STATES = "states"
    ERRORS = "errors"


class EntryKind(StrEnum):
    """The kind of an event: its word in recordings (which never changes), topic and meaning."""

    topic: Topic
    meaning: str

    def __new__(cls, word: str, topic: Topic, meaning: str) -> Self:
        """Make a member whose value is its word."""
        kind = str.__new__(cls, word)
        kind._value_, kind.topic, kind.meaning = word, topic, meaning
        return kind

    SENT = "sent", Topic.BYTES, "bytes to the arm"
    RECEIVED = "received", Topic.BYTES, "bytes from the arm"
    CALL = "call", Topic.CALLS, "a call by a program or a person, with its arguments"
    RAISED = "raised", Topic.ERRORS, "the error that a call or a task raised"
    REQUEST = "request", Topic.REQUESTS, "a request that the driver began"
    REGISTERS = (
        "registers",
        Topic.REQUESTS,
        "the controller's position counts, in reply to a request",
    )
    REPLY = "reply", Topic.REQUESTS, "any other reply to a request"
    TIMEOUT = "timeout", Topic.ERRORS, "a request that got no reply in time"
    ALERT = "alert", Topic.ERRORS, "an unsolicited message of the device that ends trust or motion"
    WARNING = "warning", Topic.ERRORS, "bytes from the device that are no reply to any request"
    STATE = "state", Topic.STATES, "the new state of the arm"
    OFFSET = (
        "offset",
        Topic.STATES,
        "the reference offset, added to the controller's counts, in motor steps",
    )
    TRUST = "trust", Topic.STATES, "the position's new trust, and the reason"
    CURRENT = "current", Topic.STATES, "whether the motors have current"
    NOTICE = "notice", Topic.ERRORS, "the notice in the status"
    ERROR = "error", Topic.ERRORS, "the error in the status"
    STOP = "stop", Topic.CALLS, "a stop request"
    LOST = "lost", Topic.ERRORS, "the loss of the link"
    FAILED = "failed", Topic.ERRORS, "a failure of the engine itself"
    DROPPED = (
        "dropped",
        Topic.STATES,
        "the oldest entries are no longer in the recording, except for lasting settings",
    )


# The kinds that hold bytes; all others hold text.
TRAFFIC = frozenset((EntryKind.SENT, EntryKind.RECEIVED))


class TraceEntry(NamedTuple):
    """One event. `time_s` is on the arm's clock; `what` is bytes for traffic, otherwise text.

    A tuple rather than a dataclass, because a motion creates thousands of them.
    """

    time_s: float
    kind: EntryKind
    what: bytes | str


class EntryCondition(NamedTuple):
    """The condition of an arm whose changes are recorded.

    `offset` is the reference offset in motor steps; `belief` is the trust, its reason, and when it
    was formed. A tuple, because every request creates one.
    """

    offset: Motors
    state: State
    belief: tuple[Trust, str, float]
    current: Current
    notice: str
    error: str


# The bounded memory of a recorder: the start of the connection, and the last minutes.
#
# The oldest exchanges are dropped first, except those with a lasting effect (motors on, outputs,
# device settings): a replay needs them to bring its simulated device to where the rest begins.

LONGEST_S = 300.0  # older entries are dropped
MOST_BYTES = 4_000_000  # beyond this size the oldest entries are dropped
MOST_OPENING_BYTES = 250_000  # the start of the connection and the lasting settings together
ENTRY_BYTES = 130  # memory of an entry apart from its text: a tuple, a float, a string header

# Requests with a lasting effect that move no motor.
LASTING = ("SwitchOn", "DropCurrent", "SetOutputs", "SetGripper", "ClearFault", "FixSetting")
EXCHANGE = frozenset((EntryKind.REQUEST, *TRAFFIC))
# Entries that determine the position. They are rare, so keeping all of them costs little.
POSITION = frozenset((EntryKind.OFFSET, EntryKind.TRUST))


class EntryRing:
    """Entries in order of time. Not thread-safe: the owner holds the lock."""

    def __init__(
        self,
        *,
        longest_s: float = LONGEST_S,
        most_bytes: int = MOST_BYTES,
        most_opening_bytes: int = MOST_OPENING_BYTES,
    ) -> None:
        self.bytes = 0
        self.dropped = 0
        self.added = 0
        """Number of entries ever added, which is the number of the next one."""
        self._longest_s = longest_s
        self._most_bytes = most_bytes
        self._most_opening_bytes = most_opening_bytes
        self._opening: list[TraceEntry] = []
        self._lasting: list[TraceEntry] = []
        self._opening_bytes = 0
        self._open = True
        self._keeping = False
        self._entries: deque[TraceEntry] = deque()

    def seal(self) -> None:
        """End the part of the recording that covers the start of the connection."""
        self._open = False

    def add(self, entry: TraceEntry) -> None:
        """Add an entry, and drop the oldest ones if there are too many."""
        size = ENTRY_BYTES + len(entry.what)
        self.added += 1
        if self._open:
            self._opening.append(entry)
            self._opening_bytes += size
            self._open = self._opening_bytes < self._most_opening_bytes
            return
        self._entries.append(entry)
        self.bytes += size
        oldest_s = entry.time_s - self._longest_s
        while self.bytes > self._most_bytes or self._entries[0].time_s < oldest_s:
            self._drop()

    def entries(self) -> tuple[TraceEntry, ...]:
        """Return all entries, with `DROPPED` entries around the place where some were dropped."""
        if not self.dropped:
            return (*self._opening, *self._lasting, *self._entries)
        begun_s = self._opening[-1].time_s if self._opening else 0.0
        words = f"{counted(self.dropped, 'entry is', 'entries are')} missing here"
        first = TraceEntry(begun_s, EntryKind.DROPPED, words)
        ended_s = self._lasting[-1].time_s if self._lasting else begun_s
        last = TraceEntry(ended_s, EntryKind.DROPPED, "complete from here on")
        return (*self._opening, first, *self._lasting, last, *self._entries)

    def since(self, number: int, most: int, back: int) -> tuple[int, tuple[TraceEntry, ...]]:
        """Return at most `most` entries from `number` on, and the number of the first of them.

        The first number is higher than the requested one if older entries were dropped or lie more
        than `back` entries in the past. The cost grows with the number of new entries, not with the
        size of the ring.
        """
        begun, kept = len(self._opening), len(self._entries)
        first = max(number, self.added - back, 0)
        if first < begun:
            found = tuple(self._opening[first : first + most])
            whole = self.added - kept == begun  # otherwise the next call reports the missing ones
            return first, found + (self._from(begun, most - len(found)) if whole else ())
        first = max(first, self.added - kept)
        return first, self._from(first, most)

    def _from(self, number: int, most: int) -> tuple[TraceEntry, ...]:
        """Return entries after the opening, from a number that is still in the ring."""
        latest = islice(reversed(self._entries), max(self.added - number, 0))
        return tuple(latest)[::-1][:most]

    def _drop(self) -> None:
        entry = self._entries.popleft()
        size = ENTRY_BYTES + len(entry.what)
        self.bytes -= size
        if entry.kind is EntryKind.REQUEST:
            self._keeping = str(entry.what).startswith(LASTING)
        useful = entry.kind in POSITION or (self._keeping and entry.kind in EXCHANGE)
        if useful and self._opening_bytes + size <= self._most_opening_bytes:
            self._lasting.append(entry)
            self._opening_bytes += size
        else:
            self.dropped += 1


def counts_text(counts: tuple[int, ...]) -> str:
    """Return motor counts as an entry holds them."""
    return " ".join(map(str, counts))


# Takes a number, the most entries, and how far back to go at most: see `EntryRing.since`.
Since = Callable[[int, int, int], tuple[int, tuple[TraceEntry, ...]]]
