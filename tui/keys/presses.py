"""Which key presses count: rules against overtaken, stale, pasted, repeated and accidental presses.

Times are in s, on any one clock. None of this knows a screen.

| rule | question | asked by |
|---|---|---|
| `UrgentKeys` | was it typed before a stop that has acted? | the driver's thread and the app |
| `BurstDetector` | did it come together with others, as in a paste? | the app, for each key |
| `SuspensionDetector` | for how long did the program not run? | the app, at each poll and key |
| `StaleInput` | did it come before the first pause after that? | the app, for keys and mouse |
| `Confirmation` | is it a second press, or one that is held? | keys that need one or two presses |

Jog keys have one rule more, the dead-man switch in `armdrive.motion.dead_man`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from textual import events
from textual.message import Message

from armdrive.errors import BadRequest
from armdrive.motion.dead_man import REPEAT_WITHIN_S

# Urgent keys act in the thread that reads them, however busy the app is: those that stop the arm.
# The app takes such a key afterwards as any other, and does the rest of what it means. Keys that
# were typed before it and are still on their way would restart what was just stopped: they are
# dropped.


class UrgentKeys:
    """When the last key that acts at once was read. Shared by two threads."""

    def __init__(self) -> None:
        self._acted_s = -math.inf

    def read(self, message: Message, urgent: Mapping[str, Callable[[], object]]) -> None:
        """Act on a key that was just read, if it is urgent."""
        if isinstance(message, events.Key) and (act := urgent.get(message.key)) is not None:
            self._acted_s = message.time
            act()

    def overtook(self, key: events.Key) -> bool:
        """Return whether a key that the app takes now was typed before one that has acted."""
        return key.time < self._acted_s


# A suspended program reads nothing, but its keyboard goes on: all that was typed arrives at once
# when the program goes on, or in pieces from a link that buffered it as well. So input is stale
# from the moment of waking until there was a silence.

# After this long without any key the next one is fresh. A key that is held repeats sooner.
SILENCE_S = 0.3


class SuspensionDetector:
    """Measures for how long the program did nothing, and notes when the system reports it."""

    def __init__(self) -> None:
        self._looked_s = math.inf
        self._busy_s = 0.0
        self._reported = False

    def report(self) -> None:
        """Note that the system reports a suspension; safe in a signal handler."""
        self._reported = True

    def look(self, now_s: float, busy_s: float) -> tuple[float, bool]:
        """Return how long the program was absent since the last look, and whether reported.

        `busy_s` is the processor time of the calling thread: time spent working is no absence.
        """
        absent_s = (now_s - self._looked_s) - (busy_s - self._busy_s)
        self._looked_s, self._busy_s = now_s, busy_s
        reported, self._reported = self._reported, False
        return max(absent_s, 0.0), reported


class StaleInput:
    """Distinguishes input that may have waited from fresh input."""

    def __init__(self) -> None:
        self._stale_s = -math.inf

    def begin(self, now_s: float) -> None:
        """Treat whatever comes from now on as stale, until there is a silence."""
        self._stale_s = now_s

    def is_stale(self, came_s: float, *, of_keyboard: bool = True) -> bool:
        """Return whether input of this time may have waited; then the next key may have, too.

        A mouse that moves is never silent for long: its events are stale as long as keys are.
        """
        if came_s - self._stale_s >= SILENCE_S:
            return False
        if of_keyboard:
            self._stale_s = max(self._stale_s, came_s)
        return True


# Not every terminal marks pasted text, and a link that stalled delivers what it kept all at once.
# No person presses two keys so soon one after the other. So a key waits before it acts, as long as
# the dead-man lets the jog keys wait (`GATE_S`), and if another one follows sooner, neither does. A
# key that is held may repeat as fast.

BURST = "keys came as fast as pasted text"


class BurstDetector:
    """Tells keys that came together, from a paste or a link, from those that a person pressed."""

    def __init__(self) -> None:
        self._key = ""
        self._came_s = -math.inf
        self._held = False

    def came_together(self, key: str, came_s: float, person_s: float) -> bool:
        """Take a key; return whether it came sooner than `person_s` after another one.

        The repeats of a held key may, and the next key after them.
        """
        gap_s = came_s - self._came_s
        together = gap_s < person_s and not self._held
        self._held = key == self._key and not together and gap_s <= REPEAT_WITHIN_S
        self._key, self._came_s = key, came_s
        return together


# A key that is held repeats, after a delay that differs from keyboard to keyboard, and most
# terminals report no release. So what returns as soon as a held key does is the same press, and a
# press counts once a pause follows it: two presses confirm, a single one does what moves the arm
# only a little.

# The pause after the last press: a key that is held repeats sooner.
QUIET_S = 0.3

# A first press that is older has been forgotten: pressing the key now asks for the first
# time.
ASKED_FOR_S = 10.0

STILL_HELD = "a key that is held is pressed once: let go, and press it again after a moment"


class Confirmation:
    """Something that is done once its key was pressed twice, with a pause after either press.

    What moves only a little is done after one press and the pause. Another key starts over. A key
    that was refused may still be held: until it pauses, none of its presses counts.
    """

    def __init__(self, clock: Callable[[], float], label: Callable[[str], str] = str) -> None:
        """`label` returns what is printed on the key of a row of the table of keys."""
        self.taken = 0
        """The number of presses so far, whether they counted or not."""
        self._clock = clock
        self._label = label
        self._row = ""
        self._effect = ""
        self._act: Callable[[], object] = lambda: None
        self._needed = 2
        self._count = 0
        self._held = False
        self._pressed_s = -math.inf
        self._refused_s = -math.inf

    @property
    def effect(self) -> str:
        """The effect of a second press of the same key, in words; empty if none is awaited."""
        waits = 0 < self._count < self._needed
        return self._effect if waits and self._clock() - self._pressed_s <= ASKED_FOR_S else ""

    @property
    def again(self) -> str:
        """The sentence that asks for the second press; empty if none is waited for."""
        if not (effect := self.effect):
            return ""
        key = self._label(self._row) if self._row else "the same key"
        return f"{key} AGAIN {effect}; any other key cancels"

    def press(
        self, effect: str, act: Callable[[], object], *, row: str = "", needed: int = 2
    ) -> None:
        """Take a press of the key of a row, which does this once it was pressed 1 or 2 times.

        Raises `BadRequest` for what may be no second press, but the first one of a key still held.
        """
        self.taken += 1
        now_s = self._clock()
        if now_s - self._refused_s < REPEAT_WITHIN_S:
            self._refused_s = now_s
            return
        gap_s = now_s - self._pressed_s
        self._pressed_s = now_s
        if effect == self._effect and gap_s < REPEAT_WITHIN_S:
            self._held = True
            if self._count < needed:
                raise BadRequest(STILL_HELD)
            return
        if effect != self._effect or gap_s > ASKED_FOR_S:
            self._count = 0
        self._effect, self._act, self._row, self._needed = effect, act, row, needed
        self._count, self._held = self._count + 1, False

    def refuse(self) -> None:
        """Take a press that there is nothing to confirm with, and everything before it back."""
        self.forget()
        self.taken += 1
        self._refused_s = self._clock()

    def forget(self, effect: str = "") -> None:
        """Take everything back; with an effect, only what would have that."""
        if not effect or effect == self._effect:
            self._effect, self._count, self._refused_s = "", 0, -math.inf

    def due(self) -> Callable[[], object] | None:
        """Return, once, what enough presses have confirmed; the last must not have been held."""
        if self._count < self._needed or self._clock() - self._pressed_s < QUIET_S:
            return None
        self._count = 0  # what is pressed of the same key next may be the press that has acted
        return None if self._held else self._act
