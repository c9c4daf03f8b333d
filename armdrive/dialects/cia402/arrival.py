"""How motions of CiA 402 drives begin and end: ready to go, there, stopped, or broken off."""

from __future__ import annotations

from collections.abc import Collection, Generator

from armdrive.dialects.cia402.current import Cia402Current
from armdrive.dialects.cia402.cycle import ENABLE, Script
from armdrive.dialects.cia402.drive import Cia402Drive
from armdrive.dialects.cia402.master import Heard
from armdrive.dialects.cia402.power import Hindrance
from armdrive.dialects.cia402.receive import away_words
from armdrive.dialects.cia402.sdo_queue import ObjectRead
from armdrive.tasks import Alert, AlertKind, Done, Halted, RequestRejected, Timeout
from firmware_protocol.canopen import STATUSWORD, OperationMode, Statusword

UNHEARD_TURNS = 5
"""Where all have told nothing for so many turns, they may not hear what they are told, either."""
FRESH_S = 0.3
"""What a drive said so long ago is still true of one that stands."""
MODE_TURNS = 50
"""So many turns a drive may take to be in another mode."""
SETTLE_S = 0.6
"""So long a drive may take to its target when that moves no more."""
EXACT_REACH = 1
"""A drive that is no farther from its target has heard of it for certain."""
REST_TURNS, EXACT = 8, 4
"""Being there for so many turns is standing there; one on the very target counts for several."""


Broken = Generator[float, Heard | None, Timeout | RequestRejected]


class Cia402Ending(Cia402Current):
    """Sees to it that drives can go, and that they got where they were sent."""

    def prepare(self, mode: OperationMode) -> Hindrance:
        """See to it that a motion can begin; return why it cannot, where it cannot."""
        if not self.on:
            return RequestRejected("its motors are disabled: call `enable()`", moved=False)
        known = all(drive.told_s >= self.now_s - FRESH_S for drive in self.drives)
        if not known and (missing := (yield from self.look())):
            return self.absence(missing, self.now_s)
        for drive in self.drives:
            if (alert := self.trouble(drive)) is not None:
                self.report(drive)
                return RequestRejected(alert.text, moved=False)
        if (hindrance := (yield from self.resume(self.drives))) is not None:
            return hindrance
        for drive in self.drives:
            drive.error = ""
            if not drive.near(self.settings.rest_window):
                drive.rest()
        return (yield from self.take_mode(self.drives, mode))

    def take_mode(self, drives: Collection[Cia402Drive], mode: OperationMode) -> Hindrance:
        """Have drives that are enabled be in a mode; each holds where it is."""
        for _ in range(MODE_TURNS):
            left = [drive for drive in drives if drive.mode != mode]
            if not left:
                return None
            for drive in left:
                self.command(drive, ENABLE, mode, drive.place)
            yield from self.turn()
        return RequestRejected(
            f"{left[0]} does not take mode {int(mode)} ({_words(mode)}), it shows {left[0].mode}: "
            "something else may command it",
            moved=False,
        )

    def arrive(self, mode: OperationMode) -> Script:
        """Wait until every drive stands where it was sent."""
        until_s, there = self.now_s + SETTLE_S, 0
        while there < REST_TURNS:
            if self.stop_asked:
                return (yield from self.halted())
            for drive in self.drives:
                self.command(drive, ENABLE, mode, drive.place)
            until_s += yield from self.timed(self.turn())
            if (ended := (yield from self.weighed(mode))) is not None:
                return ended
            off = [each for each in self.drives if not each.near(self.settings.rest_window)]
            fresh = all(drive.missed == 0 for drive in self.drives)
            if off:
                there = 0
            elif fresh:  # a turn in which one told nothing speaks neither for it nor against it
                there += self._weight()
            if self.now_s > until_s:
                return (yield from self.broken_off(self.beside(off[0] if off else None)))
        self.progress()
        return Done()

    def _weight(self) -> int:
        """Return what a turn counts: more where every drive is on its very target.

        One that is a little beside it may not have heard of it yet.
        """
        exact = all(drive.near(EXACT_REACH) for drive in self.drives)
        return EXACT if exact else 1

    def beside(self, drive: Cia402Drive | None) -> Alert:
        """Say that a drive is not where it was sent."""
        if drive is None:
            return Alert(AlertKind.ASTRAY, "a drive tells its position too seldom")
        return Alert(
            AlertKind.ASTRAY,
            f"{drive} is at {drive.seen}, not at {drive.place} increments: it is blocked, "
            "overloaded, or was turned by force",
        )

    def weighed(self, mode: OperationMode) -> Hindrance:
        """Look at what the drives said in a motion; return what it has come to, where to an end."""
        if self._was_away and (missing := (yield from self._look_anew())):
            return (yield from self.lost(missing))
        for drive in self.drives:
            if (alert := self.trouble(drive, moving=True)) is not None:
                return (yield from self.broken_off(alert, drive))
            if drive.missed <= 1 and drive.mode != mode:
                words = f"{drive} was brought to mode {drive.mode} by somebody else"
                return (yield from self.broken_off(Alert(AlertKind.ASTRAY, words)))
        if mute := self.mute(self.drives):
            return (yield from self.lost(mute))
        return None

    @property
    def _was_away(self) -> bool:
        """Whether drives may have missed this program's heartbeat, and stopped by themselves.

        Whatever they are told then, they take for an order to go on from there: with a leap to
        where the others, or the targets, are by now.
        """
        most_s = (self.settings.heartbeat_ms - self.settings.beat_ms / 2.0) / 1000.0
        if self.now_s - self.beats.said_s >= most_s:
            return True
        unheard = [drive for drive in self.drives if drive.missed > UNHEARD_TURNS]
        since_s = self.now_s - most_s + self.beats.period_s  # the last beat may be as old as that
        return len(unheard) == len(self.drives) or any(each.told_s <= since_s for each in unheard)

    def _look_anew(self) -> Generator[float, Heard | None, Collection[Cia402Drive]]:
        """Hear what drives said meanwhile, then ask each what it is, until one is in trouble.

        An order that lay in this computer may have had them go on again: it shows for one turn that
        they had stopped. One that they have, and that waits for a SYNC, would do the same: so none
        is said before it is known what they are.
        """
        yield from self.wait(self.now_s + self.cycle_s, self._is_troubled)
        if self._is_troubled():
            return ()
        asked = {drive.node: (ObjectRead(STATUSWORD),) for drive in self.drives}
        lanes = yield from self.transfer(asked, tries=2)
        for lane in lanes.values():
            if STATUSWORD in lane.values:
                lane.drive.word = Statusword(lane.values[STATUSWORD])
        return tuple(lane.drive for lane in lanes.values() if STATUSWORD not in lane.values)

    def _is_troubled(self) -> bool:
        return any(self.trouble(drive, moving=True) for drive in self.drives)

    # -- ends ---------------------------------------------------------------------------------

    def halted(self) -> Script:
        """End a motion that somebody stopped."""
        return (yield from self.halt()) or Halted()

    def broken_off(self, alert: Alert, drive: Cia402Drive | None = None) -> Broken:
        """End a motion that cannot go on: stop every drive first, then say why."""
        unstopped = yield from self.halt()
        if drive is not None and not drive.booted and not drive.error:
            yield from self.explain(drive)
            alert = self.trouble(drive, moving=True) or alert
        if drive is not None:
            drive.reported = True
        self.tell(alert)
        if alert.kind in (AlertKind.RESTARTED, AlertKind.SWITCHED_OFF):
            self.on = False
        return unstopped if isinstance(unstopped, Timeout) else RequestRejected(alert.text)

    def lost(self, mute: Collection[Cia402Drive]) -> Broken:
        """End a motion in which drives fell silent; the others are stopped."""
        unstopped = yield from self.halt()
        if isinstance(unstopped, Timeout):
            return unstopped
        if away := next(filter(None, map(away_words, mute)), ""):
            return RequestRejected(away, silent=True)
        named = ", ".join(map(str, mute))
        words = f"{named} said nothing for a while: look at the bus's wiring and its load"
        silent = isinstance(unstopped, RequestRejected) and unstopped.silent
        return RequestRejected(unstopped.reason if silent and unstopped else words, silent=True)


def _words(mode: OperationMode) -> str:
    return mode.name.lower().replace("_", " ")
