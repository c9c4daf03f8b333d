"""What a recording is made of: one entry for each thing that happened, with its time."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from enum import StrEnum
from itertools import islice
from types import MappingProxyType
from typing import NamedTuple

from armdrive.status import Current, State, Trust
from kinematics.spaces import Motors


class EntryKind(StrEnum):
    """What happened."""

    SENT = "sent"
    HEARD = "heard"
    CALL = "call"
    RAISED = "raised"
    REQUEST = "request"
    REGISTERS = "registers"
    REPLY = "reply"
    SILENCE = "silence"
    ALERT = "alert"
    ODDITY = "oddity"
    STATE = "state"
    OFFSET = "offset"
    TRUST = "trust"
    CURRENT = "current"
    NOTICE = "notice"
    ERROR = "error"
    STOP = "stop"
    LOST = "lost"
    FAILED = "failed"
    GAP = "gap"


class Topic(StrEnum):
    """What a line is about: people choose by it what they want to see."""

    BYTES = "bytes"
    REQUESTS = "requests"
    INTENTS = "intents"
    STATES = "states"
    ERRORS = "errors"


TOPICS: Mapping[EntryKind, Topic] = MappingProxyType(
    {
        EntryKind.SENT: Topic.BYTES,
        EntryKind.HEARD: Topic.BYTES,
        EntryKind.CALL: Topic.INTENTS,
        EntryKind.RAISED: Topic.ERRORS,
        EntryKind.REQUEST: Topic.REQUESTS,
        EntryKind.REGISTERS: Topic.REQUESTS,
        EntryKind.REPLY: Topic.REQUESTS,
        EntryKind.SILENCE: Topic.ERRORS,
        EntryKind.ALERT: Topic.ERRORS,
        EntryKind.ODDITY: Topic.ERRORS,
        EntryKind.STATE: Topic.STATES,
        EntryKind.OFFSET: Topic.STATES,
        EntryKind.TRUST: Topic.STATES,
        EntryKind.CURRENT: Topic.STATES,
        EntryKind.NOTICE: Topic.ERRORS,
        EntryKind.ERROR: Topic.ERRORS,
        EntryKind.STOP: Topic.INTENTS,
        EntryKind.LOST: Topic.ERRORS,
        EntryKind.FAILED: Topic.ERRORS,
        EntryKind.GAP: Topic.STATES,
    }
)
"""The topic of each kind of entry."""


TITLES: Mapping[EntryKind, str] = MappingProxyType(
    {
        EntryKind.SENT: "bytes to the arm",
        EntryKind.HEARD: "bytes from the arm",
        EntryKind.CALL: "a call of a program or a person, with its arguments",
        EntryKind.RAISED: "what a call or a task raised",
        EntryKind.REQUEST: "a request that the driver began",
        EntryKind.REGISTERS: "the controller's counts, in answer to a request",
        EntryKind.REPLY: "any other answer to a request",
        EntryKind.SILENCE: "no answer, and none was waited for any longer",
        EntryKind.ALERT: "what the device said unasked, and what it means",
        EntryKind.ODDITY: "something on the wire that answers nothing",
        EntryKind.STATE: "the state machine's new state",
        EntryKind.OFFSET: "what is added to the controller's counts, in motor steps",
        EntryKind.TRUST: "the position's new trust, and why",
        EntryKind.CURRENT: "whether the motors are held",
        EntryKind.NOTICE: "the status's notice",
        EntryKind.ERROR: "the status's error",
        EntryKind.STOP: "a stop was asked for",
        EntryKind.LOST: "the wire was lost",
        EntryKind.FAILED: "the engine itself failed",
        EntryKind.GAP: "what came next is no longer in the recording, apart from lasting settings",
    }
)
"""Every kind, and what it stands for: the docs are checked against this table."""

WIRE = frozenset((EntryKind.SENT, EntryKind.HEARD))
"""The kinds that hold bytes; all others hold text."""


class TraceEntry(NamedTuple):
    """One thing that happened. `time_s` is on the arm's clock; `what` is bytes on the wire.

    A tuple, since thousands of them are made beside motions.
    """

    time_s: float
    kind: EntryKind
    what: bytes | str


class EntryCondition(NamedTuple):
    """What is known of an arm at one moment, as far as a change of it is noted.

    `offset` is what is added to the controller's counts, `belief` the trust, its reason and when it
    was formed. A tuple, since one is made at every request.
    """

    offset: Motors
    state: State
    belief: tuple[Trust, str, float]
    current: Current
    notice: str
    error: str


# The bounded memory of a recorder: how the connection began, and the last minutes.
#
# When the oldest exchanges go, those that set something for good (motors on, outputs, settings of
# the device) are kept, so that a simulated twin can still be brought to where the rest begins.

LONGEST_S = 300.0
"""What is older than this goes."""
MOST_BYTES = 4_000_000
"""What is more than this goes, the oldest first."""
MOST_OPENING_BYTES = 250_000
"""A connection's beginning, together with the settings that last, is no longer than this."""
ENTRY_BYTES = 130
"""What an entry takes beside its text: a tuple, a float, the head of a string."""

LASTING = ("SwitchOn", "DropCurrent", "SetOutputs", "SetGripper", "ClearFault", "MendSetting")
"""Requests whose effect outlives them, and moves no motor."""
EXCHANGE = frozenset((EntryKind.REQUEST, *WIRE))
POSITION = frozenset((EntryKind.OFFSET, EntryKind.TRUST))
"""What tells where the arm is, and comes seldom."""


class EntryRing:
    """Entries in the order of their time. Not for several threads: its owner has the lock."""

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
        """How many entries there ever were: the number of the next one."""
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
        """Say that the connection's beginning is over."""
        self._open = False

    def add(self, entry: TraceEntry) -> None:
        """Remember an entry, and forget the oldest where there are too many."""
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
        """Return all that is remembered, with a `GAP` where something went before what remains."""
        if not self.dropped:
            return (*self._opening, *self._lasting, *self._entries)
        begun_s = self._opening[-1].time_s if self._opening else 0.0
        words = f"{self.dropped} entries have gone"
        first = TraceEntry(begun_s, EntryKind.GAP, words)
        ended_s = self._lasting[-1].time_s if self._lasting else begun_s
        last = TraceEntry(ended_s, EntryKind.GAP, "from here on nothing is missing")
        return (*self._opening, first, *self._lasting, last, *self._entries)

    def since(self, number: int, most: int, back: int) -> tuple[int, tuple[TraceEntry, ...]]:
        """Return at most so many entries from a number on, and the number of the first of them.

        That number is higher than the one asked for where what was asked for has gone, or lies
        further `back` than so many entries. What it takes grows with what has come since, and not
        with what is remembered.
        """
        begun, kept = len(self._opening), len(self._entries)
        first = max(number, self.added - back, 0)
        if first < begun:
            found = tuple(self._opening[first : first + most])
            whole = self.added - kept == begun  # else the next look tells what is missing
            return first, found + (self._from(begun, most - len(found)) if whole else ())
        first = max(first, self.added - kept)
        return first, self._from(first, most)

    def _from(self, number: int, most: int) -> tuple[TraceEntry, ...]:
        """Return entries behind the beginning, from a number on that is still remembered."""
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
