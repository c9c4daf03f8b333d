"""How CiA 402 drives are led through a motion: whether it can begin, what ends it, how they stop.

What follows on what is the table of `bus/group.py`. Here are the stages that all motions share, and
what is done between them; `motion.py` has a stage of their own for each kind.

A stop is every drive's own quick stop; when all stand they are taken back from there, and hold.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

from armdrive.dialects.bus.group import Act, Phase, Signal, Stages, lead
from armdrive.dialects.bus.observer import Finding
from armdrive.dialects.cia402.exchange import (
    ENABLE,
    STOP,
    Cia402Exchange,
    DriveStates,
    Hindered,
    ObjectTransfers,
    Script,
)
from armdrive.dialects.cia402.settings import Cia402Settings
from armdrive.dialects.cia402.wire import Cia402Drive, DriveGroup, Heard, HeartbeatProducer, beside
from armdrive.dialects.exchange import ScriptIO
from armdrive.tasks import Alert, AlertKind, Done, Halted, Reply, RequestRejected, Timeout
from firmware_protocol.canopen import STATUSWORD, DriveState, OperationMode, Statusword

UNHEARD_TURNS = 5
"""If no drive has told anything for so many turns, none may hear its targets either. A busy
computer is late by fewer: SYNC every 10 ms came 58 ms late at worst
(docs/background/measurements.md)."""
FRESH_S = 0.3
"""A position of a standing drive that is no older than this need not be asked for again."""
SETTLE_S = 0.6
"""How long a drive may take to its last target. Its following error is gone within
`following_ms`, 50 ms as delivered; the rest is for drives that settle slowly (a guess)."""
EXACT_REACH = 1
"""A drive this close to its target, in increments, has received that target."""
REST_TURNS, EXACT = 8, 4
"""A drive has arrived after so many readings near its target. It may have missed its last target,
but not eight repeats of it. A reading within `EXACT_REACH` counts for four."""
STAND_TURNS = 3
"""A drive has stopped when it has not turned for so many turns: with one, a lost or late answer
would look like a stand-still."""
BRAKING_S = 1.0
"""How much longer than twice its ramp a drive may take to stop: lost orders are repeated for so
long before it is reported (a guess)."""
TO_BE_STOPPED = (None, DriveState.ENABLED, DriveState.QUICK_STOP)
"""One that has stopped by itself, too: what it was told before, and waits for a SYNC, is void."""


@dataclass(slots=True, eq=False)
class Turns:
    """A stage that goes on turn by turn.

    At the beginning of a turn `say` tells the drives something, and returns until when the turn
    lasts; at its end `judge` returns what has become of the stage. `mode` is that of the motion;
    None where drives are in several.
    """

    lead: MotionLead
    mode: OperationMode | None
    say: Callable[[], float]
    judge: Callable[[], Signal | None]

    def speak(self, now_s: float) -> float:
        """Begin the next turn where one is over."""
        lead = self.lead
        return lead.turn(self.say()) if now_s >= lead.due_s else lead.due_s

    def signal(self, now_s: float) -> Signal | None:  # noqa: ARG002
        """Return what has become of it."""
        signal = self.lead.signal(self.mode)
        return self.judge() if signal is None and self.lead.turn_is_over else signal


@dataclass(slots=True, eq=False)
class MotionLead:
    """Leads the drives of one arm through one motion after the other, turn by turn.

    What ends a motion is its `trouble`, with the `culprit` that is asked why; or drives that are
    `missing`; or what is `refused` of it.
    """

    io: ScriptIO[Heard]
    exchange: Cia402Exchange
    transfers: ObjectTransfers
    group: DriveGroup
    states: DriveStates
    beats: HeartbeatProducer
    settings: Cia402Settings
    due_s: float = math.inf
    """When the present turn is over."""
    trouble: Alert | None = None
    culprit: Cia402Drive | None = None
    missing: tuple[Cia402Drive, ...] = ()
    refused: str = ""
    reply: Reply = field(default_factory=Done)
    turned: bool = False
    """Whether a turn was begun that has not been judged."""

    def prepare(self, mode: OperationMode) -> Script[None]:
        """See to it that a motion can begin; raises `Hindered` where it cannot."""
        group = self.group
        if not group.on:
            raise Hindered("its motors are disabled: call `enable()`")
        if any(drive.shaft.read_s < self.io.now_s - FRESH_S for drive in group.drives):
            yield from self.exchange.look()
        for drive in group.drives:
            if (alert := group.trouble(drive)) is not None:
                group.report(drive)
                raise Hindered(alert.text)
        yield from self.states.take_back(group.drives)
        for drive in group.astray:
            drive.rest()
        yield from self.states.take_mode(group.drives, mode)
        for drive in group.drives:
            drive.watch()

    def carry_out(
        self,
        phase: Phase,
        say: Callable[[], float],
        judge: Callable[[], Signal | None],
        mode: OperationMode | None,
        turns: int = 0,
    ) -> Script[Reply]:
        """Lead the drives through a motion whose own stage says and judges something (`Turns`).

        It ends when all stand in their places for so many turns.
        """
        self.trouble, self.culprit, self.missing, self.refused = None, None, (), ""
        self.reply = Done()
        self.interrupt()
        moving, braking = Turns(self, mode, say, judge), Braking(self)
        arriving = Arriving(self, mode or self.group.resting_mode, turns)
        there = Turns(self, mode, arriving.say, arriving.judge)
        stages: Stages = {
            phase: lambda: moving,
            Phase.RETURNING: lambda: Returning(self, self.cycle_ends_s),
            Phase.ARRIVING: lambda: there,
            Phase.STOPPING: braking.begin,
        }
        acts = {
            # the stage of stopping says the stop
            **dict.fromkeys((Act.STOP, Act.STOP_DEAD, Act.EXPLAIN), lambda: None),
            Act.TAKE_UP: self._ask_states,
            Act.HOLD: lambda: self._hold(braking),
        }
        yield from lead(self.io, phase, stages, acts)
        return self.reply

    # -- turns --------------------------------------------------------------------------------

    def turn(self, until_s: float) -> float:
        """Have the drives do what they were told; return when the turn is over."""
        self.exchange.sync()
        self.due_s, self.turned = until_s, True
        return until_s

    @property
    def cycle_ends_s(self) -> float:
        """When a turn is over that begins now."""
        return self.io.now_s + self.exchange.cycle_s

    @property
    def turn_is_over(self) -> bool:
        """Whether a turn has ended that is to be judged."""
        return self.turned and self.io.now_s >= self.due_s

    def interrupt(self) -> None:
        """End the present turn, and judge nothing by it."""
        self.due_s, self.turned = self.io.now_s, False

    def signal(self, mode: OperationMode | None) -> Signal | None:
        """Return what ends the phase that a motion is in, as far as all motions share that.

        Drives that are not in its mode end a motion. None where they are in several, and search for
        their switches: then nobody knows where they should be.
        """
        if self.io.stop_asked:
            return Signal.STOP
        for drive in self.group.drives:
            if (alert := self.group.trouble(drive, moving=True)) is not None:
                return self.blame(alert, drive)
        if self.missing:
            return Signal.TROUBLE
        if not self.turn_is_over:
            return None
        if mode is not None:
            if self._may_have_stopped:
                return Signal.BACK
            for drive in self.group.drives:
                if drive.missed <= 1 and drive.mode != mode:
                    words = f"{drive} was brought to mode {drive.mode} by somebody else"
                    return self.blame(Alert(AlertKind.ASTRAY, words))
                if (alert := _departed(drive)) is not None:
                    return self.blame(alert)
        self.missing = self.exchange.mute(self.group.drives)
        return Signal.TROUBLE if self.missing else None

    def blame(self, alert: Alert, culprit: Cia402Drive | None = None) -> Signal:
        """Take note of what is wrong, and of a drive that is asked why."""
        self.trouble, self.culprit = alert, culprit
        return Signal.TROUBLE

    @property
    def _may_have_stopped(self) -> bool:
        """Whether drives may have missed this program's heartbeat, and stopped by themselves.

        Whatever they are told then, they take for an order to go on from there: with a leap to
        where the others, or the targets, are by now.
        """
        now_s, drives = self.io.now_s, self.group.drives
        most_s = (self.settings.heartbeat_ms - self.settings.beat_ms / 2.0) / 1000.0
        if now_s - self.beats.said_s >= most_s:
            return True
        since_s = now_s - most_s + self.beats.period_s  # the last beat may be as old as that
        return all(drive.missed > UNHEARD_TURNS for drive in drives) or any(
            drive.shaft.read_s <= since_s for drive in drives
        )

    # -- between phases -----------------------------------------------------------------------

    def _ask_states(self) -> Script[None]:
        """Ask each drive what it is, before a SYNC is said on which it may act."""
        jobs = self.transfers.of_each(STATUSWORD)
        results = (yield from self.transfers.transfer(jobs, tries=2)).values()
        for result in results:
            if (word := result.values.get(STATUSWORD)) is not None:
                result.drive.show(Statusword(word))
        self.missing = tuple(each.drive for each in results if STATUSWORD not in each.values)
        self.interrupt()

    def _hold(self, braking: Braking) -> Script[None]:
        """Have each drive hold where it stands; say why the motion ended."""
        unstopped: Reply | None = None
        try:
            yield from self.states.take_back(braking.stopped)
        except Hindered as hindered:
            unstopped = hindered.reply
        for drive in self.group.drives:
            drive.rest()
        unstopped = braking.unstopped() or unstopped
        self.reply = unstopped or Halted()
        if self.trouble is not None:
            yield from self._explain(self.trouble)
        elif self.missing and not isinstance(unstopped, Timeout):
            self.reply = self._lost(unstopped)
        elif self.refused:
            self.reply = RequestRejected(self.refused)

    def _explain(self, alert: Alert) -> Script[None]:
        """Find out what is wrong with a drive, and tell it."""
        drive = self.culprit
        if drive is not None and not drive.booted and not drive.error:
            yield from self.transfers.explain(drive)
            alert = self.group.trouble(drive, moving=True) or alert
        self.group.alarm(drive, alert)
        if not isinstance(self.reply, Timeout):
            self.reply = RequestRejected(alert.text)

    def _lost(self, unstopped: Reply | None) -> RequestRejected:
        """Return why a motion ended in which drives fell silent; the others were stopped."""
        named = ", ".join(map(str, self.missing))
        words = f"{named} said nothing for a while: look at the bus's wiring and its load"
        if isinstance(unstopped, RequestRejected) and unstopped.silent and unstopped.reason:
            words = unstopped.reason
        away = next(filter(None, (drive.away_words for drive in self.missing)), "")
        return RequestRejected(away or words, silent=True)


@dataclass(slots=True, eq=False)
class Returning:
    """Drives may have stopped by themselves: what they said meanwhile is heard first.

    An order that lay in this computer may have had them go on again: it shows for one turn that
    they had stopped. One that they have, and that waits for a SYNC, would do the same: so none is
    said before it is known what they are.
    """

    lead: MotionLead
    until_s: float

    def speak(self, now_s: float) -> float:  # noqa: ARG002
        """Say nothing for a turn."""
        return self.until_s

    def signal(self, now_s: float) -> Signal | None:
        """Return whether a drive is in trouble, or nobody is as far as is known."""
        self.lead.turned = False
        return self.lead.signal(None) or (Signal.FOUND if now_s >= self.until_s else None)


class Arriving:
    """Every drive is told its place again and again, until it stands there.

    A drive that is late has told nothing against itself: it is waited for, and its motion ends
    where it is mute. Only one that is read off its place is blamed, once its time is over; that is
    listened time.
    """

    def __init__(self, lead: MotionLead, mode: OperationMode, turns: int) -> None:
        self._lead, self._mode, self._turns = lead, mode, turns
        self._given_up_s = math.inf
        self._there = dict.fromkeys(lead.group.drives, 0)
        self._read_s: dict[Cia402Drive, float] = {}

    def say(self) -> float:
        """Tell every drive its place."""
        lead = self._lead
        if not self._read_s:
            self._given_up_s = lead.exchange.listened.s + SETTLE_S
            self._read_s = {drive: drive.shaft.read_s for drive in lead.group.drives}
        for drive in lead.group.drives:
            lead.exchange.command(drive, ENABLE, self._mode, drive.shaft.goal)
        return lead.cycle_ends_s

    def judge(self) -> Signal | None:
        """Return whether all stand in their places."""
        lead, drives = self._lead, self._lead.group.drives
        for drive, before_s in self._read_s.items():
            if drive.shaft.read_s <= before_s:
                continue
            self._read_s[drive] = drive.shaft.read_s
            if drive.shaft.is_near:
                exact = abs(drive.seen - drive.shaft.goal) <= EXACT_REACH
                self._there[drive] += EXACT if exact else 1
            elif lead.exchange.listened.s > self._given_up_s:
                return lead.blame(beside(drive))
            else:
                self._there[drive] = 0
        if lead.group.astray or min(self._there.values()) < self._turns:
            return None
        for drive in drives:
            drive.shaft.rest_at(drive.shaft.goal, lead.io.now_s)
        lead.exchange.progress()
        return Signal.THERE


class Braking:
    """Every drive is told to stop, again and again, until all stand and hold."""

    def __init__(self, lead: MotionLead) -> None:
        self._lead = lead
        self._left: tuple[Cia402Drive, ...] = ()
        self._mute: tuple[Cia402Drive, ...] = ()
        self._began_s = self._given_up_s = math.inf

    def begin(self) -> Braking:
        """Begin to stop them, at once."""
        ramp_s = self._lead.settings.quick_stop_s
        self._began_s = self._lead.io.now_s
        self._given_up_s = self._lead.exchange.listened.s + 2.0 * ramp_s + BRAKING_S
        self._left = self._lead.group.drives
        self._lead.interrupt()
        return self

    @property
    def stopped(self) -> tuple[Cia402Drive, ...]:
        """Those that stand."""
        return tuple(drive for drive in self._lead.group.drives if drive not in self._left)

    def speak(self, now_s: float) -> float:
        """Tell those to stop that do not stand."""
        lead = self._lead
        if now_s < lead.due_s:
            return lead.due_s
        for drive in self._left:
            if drive.state in TO_BE_STOPPED:
                lead.exchange.command(drive, STOP, lead.states.mode_of(drive))
        lead.io.said = "QUICK STOP"
        return lead.turn(lead.cycle_ends_s)

    def signal(self, now_s: float) -> Signal | None:  # noqa: ARG002
        """Return whether all stand, or why that will not be known."""
        lead = self._lead
        if not lead.turn_is_over:
            return None
        lead.exchange.progress()
        self._left = tuple(drive for drive in self._left if not self._stands(drive))
        self._mute = lead.exchange.mute(self._left)
        if not self._left:
            return Signal.STAND
        over = lead.exchange.listened.s >= self._given_up_s
        return Signal.LOST if over or len(self._mute) == len(self._left) else None

    def _stands(self, drive: Cia402Drive) -> bool:
        if drive.booted:
            return True  # it has lost its current, and will not say so
        if drive.shaft.read_s < self._began_s or drive.state in (None, DriveState.ENABLED):
            return False
        if not drive.holds:
            return True  # nothing can be done about how it turns
        return drive.stands(self._began_s, (STAND_TURNS - 1) * self._lead.exchange.cycle_s * 0.9)

    def unstopped(self) -> Timeout | RequestRejected | None:
        """Return why it is not known that all stand; None where it is."""
        if self._mute and len(self._mute) == len(self._left):
            return self._lead.exchange.absence(self._mute, moved=True)
        for drive in self._left:
            return RequestRejected(f"{drive} was told to stop, and does not come to rest")
        return None


def _departed(drive: Cia402Drive) -> Alert | None:
    """Say that a drive left the way of its orders; None where its last reading agrees with them."""
    verdict = drive.shaft.verdict
    if verdict is None or not verdict.finding.ends:
        return None
    if verdict.finding is Finding.RESTARTED:
        words = f"{drive} counts from zero: it was reset, or lost its power for a moment"
        return Alert(AlertKind.RESTARTED, words)
    return beside(drive)
