"""The dead-man switch: turns a terminal's key repeats into hold-to-jog actions.

Most terminals report no key release. A first press is one bounded increment; a repeat soon after it
means that the key is held, and each further repeat extends the hold a little. This code reads no
clock and moves nothing: key events and times come in, actions go out.

A stalled link delivers old repeats all at once, long after the key was released, and pasted text
comes all at once too. Every event that begins something therefore waits for 30 ms before it counts.
Other keys in that time are no person's: they are dropped. More events in that time than a keyboard
can send are a backlog: they are dropped, the jog ends, and the keys are disarmed.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, replace

REPEAT_WITHIN_S = 0.75  # the longest usual repeat delay: a repeat within it means held

# A hold ends three repeat intervals after the latest repeat, within these two bounds.
HOLD_SHORTEST_S = 0.12
HOLD_LONGEST_S = 0.25
HOLD_INTERVALS = 3.0

# Wait before an event begins something: no person presses another key sooner or notices the wait,
# and a paste never pauses for so long.
GATE_S = 0.03
# This many events in less than `GATE_S` are a backlog.
#
# The fastest keyboards repeat every 15 ms, so three repeats fit into that time. A computer that was
# busy for 35 ms just before adds three more.
GATE_EVENTS = 7

BURST_S = 0.008
# This many events in less than `BURST_S` are a backlog.
#
# A stalled link delivers its backlog within a few milliseconds. A computer that was busy for 35 ms
# delivers three events at once, and the next one 10 ms later.
BURST_EVENTS = 4

ARM_AFTER_QUIET_S = 0.25  # arming needs this long without keys, so that no backlog can arm

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
    """Jog in the direction of this key until `until_s`."""

    key: str
    until_s: float


@dataclass(frozen=True, slots=True)
class Release:
    """End the jog of this key: it has been released."""

    key: str


@dataclass(frozen=True, slots=True)
class Disarm:
    """Ignore the jog keys until they are armed again."""

    reason: str


Action = Increment | HeldKey | Release | Disarm


@dataclass(frozen=True, slots=True)
class _Gate:
    """Events that begin something, and may turn out to be a backlog."""

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
        self._gate: _Gate | None = None
        self._intervals: deque[float] = deque(maxlen=_INTERVALS_KEPT)

    @property
    def armed(self) -> bool:
        """Whether key presses have any effect."""
        return self._armed

    @property
    def held(self) -> str | None:
        """The key that is being held, if any."""
        return self._key if self._until_s > -math.inf else None

    def arm(self, now_s: float) -> bool:
        """Arm the keys, unless keys are still arriving; return `armed`."""
        if not self._armed and now_s - self._event_s >= ARM_AFTER_QUIET_S:
            self._armed = True
            self._event_s = now_s
        return self._armed

    def press(self, key: str, now_s: float) -> tuple[Action, ...]:
        """Take a key event, a first press or a repeat; return the actions in order."""
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
        """Return the actions that are due; call at `next_s` and before every event."""
        actions: tuple[Action, ...] = ()
        if self._gate is not None and now_s >= self._gate.due_s:
            actions = self._open(self._gate, now_s)
        if self.held is not None and now_s >= self._until_s:
            actions += self._let_go()
        return actions

    def next_s(self) -> float:
        """Return when to call `tick`; infinite if nothing is pending."""
        gate_s = math.inf if self._gate is None else self._gate.due_s
        return min(gate_s, math.inf if self.held is None else self._until_s)

    def key_up(self, key: str, now_s: float) -> tuple[Action, ...]:
        """Take the release of a key, if the terminal reports it; return the actions."""
        actions = self.tick(now_s)
        gate = self._gate
        waits = gate is not None and gate.repeat and gate.key == key
        return actions + self._let_go() if waits or key == self.held else actions

    def release_all(self) -> tuple[Action, ...]:
        """End any hold."""
        return self._let_go()

    def disarm(self, reason: str) -> tuple[Action, ...]:
        """End any hold, and ignore keys until `arm`."""
        was_armed, self._armed = self._armed, False
        released = self._let_go()
        return (*released, Disarm(reason)) if was_armed else released

    def _begin(self, key: str, now_s: float, gap_s: float) -> tuple[Action, ...]:
        """Let an event of a key that is not held wait, while no other event is waiting."""
        hasty = gap_s < GATE_S
        repeat = key == self._key and not hasty and now_s - self._pressed_s <= REPEAT_WITHIN_S
        replaced = self._let_go()
        # The event just before belongs to the same burst unless it was part of a live hold.
        events = 2 if hasty and not replaced else 1
        self._gate = _Gate(key, now_s, now_s, events, repeat)
        return replaced

    def _gather(self, gate: _Gate) -> tuple[Action, ...]:
        burst = gate.events >= BURST_EVENTS and gate.last_s - gate.opened_s < BURST_S
        if burst or gate.events >= GATE_EVENTS:
            return self.disarm(BACKLOG_REASON)
        self._gate = gate
        return ()

    def _open(self, gate: _Gate, now_s: float) -> tuple[Action, ...]:
        """Act on the waiting events, if they are fresh and a keyboard could have sent them."""
        self._let_go()
        alone = gate.events == 1
        until_s = gate.last_s + HOLD_LONGEST_S
        if gate.mixed or now_s >= until_s or not (gate.repeat or alone):
            return ()
        self._key = gate.key
        if not gate.repeat:
            self._pressed_s = gate.opened_s
            return (Increment(gate.key),)
        self._until_s = until_s
        return (HeldKey(gate.key, until_s),)

    def _prolong(self, now_s: float, gap_s: float) -> HeldKey:
        self._intervals.append(gap_s)
        self._until_s = now_s + self._patience_s()
        return HeldKey(self._key, self._until_s)

    def _patience_s(self) -> float:
        """Return how long to wait for the next repeat; a mean needs a few intervals."""
        if len(self._intervals) < _INTERVALS_TO_TRUST:
            return HOLD_LONGEST_S
        interval_s = sum(self._intervals) / len(self._intervals)
        return min(max(HOLD_INTERVALS * interval_s, HOLD_SHORTEST_S), HOLD_LONGEST_S)

    def _let_go(self) -> tuple[Action, ...]:
        """Clear key, hold and waiting events; return the release of the held key."""
        held = self.held
        self._key = ""
        self._pressed_s = self._until_s = -math.inf
        self._gate = None
        self._intervals.clear()
        return () if held is None else (Release(held),)
