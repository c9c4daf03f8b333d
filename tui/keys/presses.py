"""Which key presses count: rules against overtaken, stale, pasted, repeated and accidental presses.

Times are in s, on any one clock. None of this knows a screen.

| rule | question | asked by |
|---|---|---|
| `Freshness.overtaken` | was it typed before a stop that has acted? | the app, for each key |
| `Freshness.stale` | did it wait while the program did not run? | the app, for keys and mouse |
| `Freshness.pasted` | did it come faster than a person types? | the app, for each key |
| `Confirmation` | is it a second press, or one that is held? | whatever moves the arm |

Jog keys have one rule more, the dead-man switch in `armdrive.motion.dead_man`.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from textual import events

from armdrive.errors import BadRequest
from armdrive.motion.dead_man import GATE_S, REPEAT_WITHIN_S

# After this long without any key the next one is fresh. A key that is held repeats sooner.
SILENCE_S = 0.3

# A program that did not run for this long was suspended: it polls twenty times as often.
SUSPENDED_S = 1.0

# One that did not run for this long, on a busy computer, may have kept jog keys waiting: a held jog
# has ended by itself meanwhile (`HOLD_LONGEST_S`), and must not begin again from old repeats.
STARVED_S = 0.3


class Freshness:
    """Distinguishes keys that a person has just pressed from keys that waited or were pasted.

    A suspended program reads nothing, but its keyboard goes on: what was typed arrives at once when
    the program goes on, or in pieces from a link that buffered it. Pasted text arrives at once too,
    and not every terminal marks it. So after either, input is stale until there was a silence.
    """

    def __init__(self) -> None:
        self.suspended_s = SUSPENDED_S
        self.starved_s = STARVED_S
        self.person_s = GATE_S
        """No person presses two keys so soon one after the other."""
        self.why = ""
        """Why input is stale."""
        self._acted_s = -math.inf
        self._looked_s = math.inf
        self._worked_s = 0.0
        self._reported = False
        self._stale_s = -math.inf
        self._key, self._came_s, self._held = "", -math.inf, False

    def acted(self, came_s: float) -> None:
        """Note a stop key that has acted in the thread that reads the keys."""
        self._acted_s = came_s

    def overtaken(self, key: events.Key) -> bool:
        """Return whether a key was typed before a stop that has acted."""
        return key.time < self._acted_s

    def suspended(self) -> None:
        """Note that the system reports a suspension; safe in a signal handler."""
        self._reported = True

    def begin(self) -> None:
        """Detect suspensions from now on: a slow start is not a suspension."""
        self._looked_s, self._reported = math.inf, False

    def look(self, now_s: float, worked_s: float, *, jogs: bool) -> str:
        """Note that the program runs; return "suspended" or "starved" if it did not.

        `worked_s` is the processor time of the calling thread: time spent working is no absence.
        Where keys jog, a shorter absence matters.
        """
        absent_s = (now_s - self._looked_s) - (worked_s - self._worked_s)
        self._looked_s, self._worked_s = now_s, worked_s
        reported, self._reported = self._reported, False
        suspended = reported or absent_s > self.suspended_s
        if not suspended and not (jogs and absent_s > self.starved_s):
            return ""
        what = "suspended" if suspended else "kept waiting"
        self.expire(now_s, f"this program was {what} for {max(absent_s, 0.0):.1f} s")
        return "suspended" if suspended else "starved"

    def expire(self, now_s: float, why: str) -> None:
        """Treat whatever comes from now on as stale, until there is a silence."""
        self._stale_s, self.why = now_s, why

    def stale(self, came_s: float, *, of_keyboard: bool = True) -> bool:
        """Return whether input of this time may have waited; then the next key may have, too.

        A mouse that moves is never silent for long: its events are stale as long as keys are.
        """
        if came_s - self._stale_s >= SILENCE_S:
            return False
        if of_keyboard:
            self._stale_s = max(self._stale_s, came_s)
        return True

    def pasted(self, key: str, came_s: float) -> bool:
        """Take a key; return whether it came sooner after another one than a person presses it.

        The repeats of a held key may, and the next key after them.
        """
        gap_s = came_s - self._came_s
        together = gap_s < self.person_s and not self._held
        self._held = key == self._key and not together and gap_s <= REPEAT_WITHIN_S
        self._key, self._came_s = key, came_s
        return together


# A key that is held repeats, after a delay that differs from keyboard to keyboard, and most
# terminals report no release. So what returns as soon as a held key does is the same press, and a
# press counts once a pause follows it: two presses confirm, a single one does what moves the arm
# only a little, or was asked for by a question. Pasted text never pauses for so long.

# The pause after the last press: a key that is held repeats sooner.
QUIET_S = 0.3

# A first press that is older has been forgotten.
ASKED_FOR_S = 10.0

STILL_HELD = "a key that is held is pressed once: let go, and press it again after a moment"


class Confirmation:
    """Something that is done once its key was pressed once or twice, with a pause after a press.

    Another key starts over. A key that was refused may still be held: until it pauses, none of its
    presses counts.
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
        key = self._label(self._row) if self._row else "the same key"
        return f"{key} AGAIN {self.effect}; any other key cancels" if self.effect else ""

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
            raise BadRequest(STILL_HELD)
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
