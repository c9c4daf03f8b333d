"""The dead-man: what a terminal's key repeats mean for an arm that may move only while held.

Few terminals report when a key is released. A first press is one bounded increment; a repeat of it
soon after means that the key is held, and each further repeat prolongs the hold a little. Nothing
here reads a clock or moves anything: key events and times come in, actions go out.

A link that stalls delivers its old repeats all at once, long after the key was let go. So what
follows a silence is gated for 30 ms before it counts: as many events in so short a time as no
keyboard sends are backlog. They are dropped, the jog ends, and the keys are disarmed.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, replace

REPEAT_WITHIN_S = 0.75
"""A repeat up to this long after the first press means held: the longest usual repeat delay."""

HOLD_SHORTEST_S = 0.12
HOLD_LONGEST_S = 0.25
HOLD_INTERVALS = 3.0
"""A hold ends this many repeat intervals after the last repeat, within the two bounds."""

GATE_S = 0.03
GATE_EVENTS = 7
"""This many events in less than `GATE_S` are backlog.

The fastest keyboards repeat every 15 ms, so three repeats fit into a gate. A computer that is busy
for 35 ms just before it adds three more.
"""

BURST_S = 0.008
BURST_EVENTS = 4
"""This many events in less than `BURST_S` are backlog: a stalled link delivers what it kept back
within a few milliseconds. A computer that was busy for 35 ms delivers three at once, and the next
one 10 ms later."""

WATCH_S = 2.0
"""A key that comes back within so long a silence may be the head of a backlog."""

ARM_AFTER_QUIET_S = 0.25
"""Arming waits for so long a silence of the keys, lest backlog arms the screen itself."""

BACKLOG_REASON = (
    "keys arrived faster than a keyboard sends them (old repeats of a stalled link, or pasted "
    "text) and were dropped"
)

_INTERVALS_TO_TRUST = 3
_INTERVALS_KEPT = 8


@dataclass(frozen=True, slots=True)
class Increment:
    """Move one increment in the direction of this key."""

    key: str


@dataclass(frozen=True, slots=True)
class HeldKey:
    """Jog in the direction of this key, until then and not longer."""

    key: str
    until_s: float


@dataclass(frozen=True, slots=True)
class Release:
    """End the jog of this key: it is held no more."""

    key: str


@dataclass(frozen=True, slots=True)
class Disarm:
    """The jog keys are dead until somebody arms them anew."""

    reason: str


Action = Increment | HeldKey | Release | Disarm


@dataclass(frozen=True, slots=True)
class _Gate:
    """Events that came after a silence, waiting to be told from backlog."""

    key: str
    opened_s: float
    last_s: float
    events: int
    repeat: bool
    mixed: bool = False

    @property
    def due_s(self) -> float:
        return self.opened_s + GATE_S

    def joined_by(self, key: str, now_s: float) -> _Gate:
        mixed = self.mixed or key != self.key
        return replace(self, last_s=now_s, events=self.events + 1, mixed=mixed)


class DeadMan:
    """Turns key events into bounded jog actions. Starts disarmed; times are in seconds."""

    def __init__(self) -> None:
        self._armed = False
        self._key = ""
        self._pressed_s = -math.inf
        self._until_s = -math.inf
        self._event_s = -math.inf
        self._watch_until_s = -math.inf
        self._gate: _Gate | None = None
        self._intervals: deque[float] = deque(maxlen=_INTERVALS_KEPT)

    @property
    def armed(self) -> bool:
        """Whether key presses have any effect."""
        return self._armed

    @property
    def held(self) -> str | None:
        """The key that is held at present."""
        return self._key if self._until_s > -math.inf else None

    @property
    def gated(self) -> bool:
        """Whether an event waits to be told from backlog."""
        return self._gate is not None

    def arm(self, now_s: float) -> bool:
        """Let keys have effect; refused while keys are still pouring in. Returns `armed`."""
        if not self._armed and now_s - self._event_s >= ARM_AFTER_QUIET_S:
            self._armed = True
            self._event_s = now_s
        return self._armed

    def press(self, key: str, now_s: float) -> tuple[Action, ...]:
        """Take a key event, first press or repeat alike; returns what to do, in order."""
        actions = self.tick(now_s)
        gap_s = now_s - self._event_s
        self._event_s = now_s
        if not self._armed:
            return actions
        if self._gate is not None:
            return actions + self._gather(self._gate.joined_by(key, now_s))
        if key == self.held:
            return (*actions, self._prolong(now_s, gap_s))
        return actions + self._begin(key, now_s, gap_s)

    def tick(self, now_s: float) -> tuple[Action, ...]:
        """Say what has fallen due by now; to be called at `next_s` and before every event."""
        actions: tuple[Action, ...] = ()
        if self._gate is not None and now_s >= self._gate.due_s:
            actions = self._open(self._gate, now_s)
        if self.held is not None and now_s >= self._until_s:
            self._watch_until_s = now_s + WATCH_S
            actions += self._let_go()
        return actions

    def next_s(self) -> float:
        """Return when `tick` has something to do; infinite while nothing is under way."""
        gate_s = math.inf if self._gate is None else self._gate.due_s
        return min(gate_s, math.inf if self.held is None else self._until_s)

    def key_up(self, key: str, now_s: float) -> tuple[Action, ...]:
        """Take the release of a key, where the terminal reports it; returns what to do."""
        actions = self.tick(now_s)
        gate = self._gate
        waits = gate is not None and gate.repeat and gate.key == key
        return actions + self._let_go() if waits or key == self.held else actions

    def release_all(self, now_s: float) -> tuple[Action, ...]:
        """End whatever is under way. Repeats still on their way count as possible backlog."""
        self._watch_until_s = now_s + WATCH_S
        return self._let_go()

    def disarm(self, reason: str) -> tuple[Action, ...]:
        """End whatever is under way, and let no key have effect until `arm`."""
        was_armed, self._armed = self._armed, False
        released = self._let_go()
        return (*released, Disarm(reason)) if was_armed else released

    def _begin(self, key: str, now_s: float, gap_s: float) -> tuple[Action, ...]:
        """Take an event while its key is not held and no gate is shut."""
        hasty = gap_s < GATE_S
        same = key == self._key
        repeat = same and not hasty and now_s - self._pressed_s <= REPEAT_WITHIN_S
        replaced = self._let_go()
        if hasty or (same and gap_s < WATCH_S) or now_s < self._watch_until_s:
            # The event just before belongs to the same burst unless it was part of a live hold.
            events = 2 if hasty and not replaced else 1
            self._gate = _Gate(key, now_s, now_s, events, repeat)
            return replaced
        return (*replaced, self._first(key, now_s))

    def _first(self, key: str, event_s: float) -> Increment:
        self._key = key
        self._pressed_s = event_s
        return Increment(key)

    def _gather(self, gate: _Gate) -> tuple[Action, ...]:
        burst = gate.events >= BURST_EVENTS and gate.last_s - gate.opened_s < BURST_S
        if burst or gate.events >= GATE_EVENTS:
            return self.disarm(BACKLOG_REASON)
        self._gate = gate
        return ()

    def _open(self, gate: _Gate, now_s: float) -> tuple[Action, ...]:
        """Let what waited take effect, if it is still fresh and one keyboard could send it."""
        self._let_go()
        alone = gate.events == 1
        until_s = gate.last_s + HOLD_LONGEST_S
        if gate.mixed or now_s >= until_s or not (gate.repeat or alone):
            self._watch_until_s = now_s + WATCH_S
            return ()
        if not gate.repeat:
            return (self._first(gate.key, gate.opened_s),)
        self._key = gate.key
        self._until_s = until_s
        return (HeldKey(gate.key, until_s),)

    def _prolong(self, now_s: float, gap_s: float) -> HeldKey:
        self._intervals.append(gap_s)
        self._until_s = now_s + self._patience_s()
        return HeldKey(self._key, self._until_s)

    def _patience_s(self) -> float:
        """Return how long to wait for the next repeat; jitter spoils a mean of very few."""
        if len(self._intervals) < _INTERVALS_TO_TRUST:
            return HOLD_LONGEST_S
        mean_s = sum(self._intervals) / len(self._intervals)
        return min(max(HOLD_INTERVALS * mean_s, HOLD_SHORTEST_S), HOLD_LONGEST_S)

    def _let_go(self) -> tuple[Action, ...]:
        """Forget key, hold and gate; give the release of what was held."""
        held = self.held
        self._key = ""
        self._pressed_s = self._until_s = -math.inf
        self._gate = None
        self._intervals.clear()
        return () if held is None else (Release(held),)
