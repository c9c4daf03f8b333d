"""Lead CiA 402 drives through a motion: whether it can begin, what ends it, how the drives stop.

`bus/phases.py` has the table of phases. A `MotionRun` is one motion. Here are the stages that all
motions share and the actions between them. Each kind of motion adds one stage of its own (`motion`,
`measuring`).

A stop is the quick stop of every drive. When all stand, they leave it again and hold.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import cache
from itertools import cycle

from armdrive.dialects.bus.drives import LATE_OUTAGES, SLOW_BUS, not_heard_words
from armdrive.dialects.bus.intervals import DriveFinding
from armdrive.dialects.bus.phases import (
    Act,
    Acts,
    Braking,
    Phase,
    Signal,
    Stage,
    Stages,
    run_phases,
)
from armdrive.dialects.cia402.drives import Cia402Drive, off_target_alert
from armdrive.dialects.cia402.exchange import (
    ENABLE,
    STOP,
    STOP_WRITE,
    Cia402Exchange,
    Job,
    Script,
)
from armdrive.dialects.controller import FRESH_POSITION_S
from armdrive.dialects.exchange import Obstructed
from armdrive.tasks import (
    Alert,
    AlertKind,
    Done,
    Halted,
    Reply,
    RequestRejected,
    Timeout,
    never,
)
from firmware_protocol.canopen import POSITION, STATUSWORD, DriveState, OperationMode

# How long a drive may take to its last target. Its following error is gone within
# `following_ms`, 50 ms by default; the rest is for drives that settle slowly (a guess).
SETTLE_S = 0.6
# A drive has arrived after this many readings near its target. It may have missed its last target,
# but not eight repeats of it.
REST_CYCLES = 8
# A drive stands when its reports show that it has not turned for this many cycles, after a stop
# for fewer: with one, a lost or late answer would look like a stand-still.
STAND_CYCLES, STOP_CYCLES = 3, 2
# By how much less the first and the last of these reports may be apart, as some come late.
JITTER_CYCLES = 0.5
# When a drive off its target has not been seen to turn for this many cycles, all stand, even if it
# reported nothing. A computer that holds everything back for 30 ms loses nothing.
LOST_CYCLES = 4
# How often positions are reported in motion: twenty times a second, as a screen shows them.
PROGRESS_S = 0.05
# How much longer than twice its ramp a drive may take to stop: lost orders are repeated for that
# time before it is reported (a guess).
BRAKING_S = 1.0
# States that need the stop, including its own: it cancels an order that waits for a SYNC.
NEEDS_STOP = (None, DriveState.ENABLED, DriveState.QUICK_STOP)


def prepare(io: Cia402Exchange, mode: OperationMode) -> Script[None]:
    """Prepare a motion. Raises `Obstructed` if it cannot begin."""
    group = io.group
    if not group.on:
        raise Obstructed("its motors are disabled: call `enable()`")
    if any(drive.shaft.read_s < io.now_s - FRESH_POSITION_S for drive in io.drives):
        yield from io.require_positions()
    for drive in io.drives:
        if (alert := group.trouble(drive)) is not None:
            group.report(drive)
            raise Obstructed(alert.text)
    yield from io.states.leave_quick_stop(io.drives)
    for drive in group.off_target:
        drive.rest()
    yield from io.states.take_mode(io.drives, mode)
    for drive in io.drives:
        drive.watch()


class MotionRun:
    """One motion, cycle by cycle: its stages share it, and its actions change it.

    `mode` is the mode of all drives. It is None while they are in several, as in homing: then no
    position is compared with the orders. `released` tells whether the motion is a jog that was
    released. A motion ends early because of `trouble` (its `culprit` is asked why), because drives
    are `missing`, or for a `reason` that concerns none of them in particular.
    """

    def __init__(
        self,
        io: Cia402Exchange,
        mode: OperationMode | None,
        released: Callable[[], bool] = never,
    ) -> None:
        self.io, self.mode, self.released = io, mode, released
        self.trouble: Alert | None = None
        self.culprit: Cia402Drive | None = None
        self.missing: tuple[Cia402Drive, ...] = ()
        self.reason: RequestRejected | None = None
        self.began_s = self.due_s = io.now_s
        """When the motion began; and when the present cycle ends."""
        self.cycling = False
        """Whether a cycle has begun that has not been judged."""
        self._shown_s = io.now_s
        """When the positions were reported last."""
        self._late_outages = 0
        """How many outages came since a cycle ended in time, although all drives had reported since
        the outage before."""
        self._outage_s = -math.inf
        """When the last outage began."""
        self._braking = Cia402Braking(self, ())
        """The stage of its stop; of no drives before that."""
        self._reply: Reply = Done()

    def carry_out(self, phase: Phase, stage: Stage, rest_cycles: int = 0) -> Script[Reply]:
        """Lead the drives through the motion, which begins in a phase with a stage of its own.

        It ends when all drives have stood at their targets for `rest_cycles` readings, or soon
        after it was released.
        """
        mode = self.mode or self.io.group.resting_mode
        stages: Stages = {
            phase: lambda: stage,
            Phase.OUTAGE: lambda: Outage(self),
            # the same after an outage: one after the other would begin its looks again
            Phase.ARRIVING: cache(lambda: Arriving(self, mode, rest_cycles)),
            Phase.STOPPING: lambda: self._braking,
        }
        acts: Acts = {
            Act.STOP: self._brake,
            Act.EXPLAIN: self._brake,
            Act.RESUME: self._ask_states,
            Act.HOLD: self._hold,
        }
        yield from run_phases(self.io, phase, stages, acts)
        return self._reply

    # -- cycles -------------------------------------------------------------------------------

    def begin_cycle(self, until_s: float) -> float:
        """Make the drives act on their commands; return when the cycle ends."""
        self.io.sync()
        self.due_s, self.cycling = until_s, True
        return until_s

    @property
    def cycle_ends_s(self) -> float:
        """When a cycle ends that begins now."""
        return self.io.now_s + self.io.cycle_s

    @property
    def cycle_is_over(self) -> bool:
        """Whether a cycle has ended that has not been judged."""
        return self.cycling and self.io.now_s >= self.due_s

    def show_progress(self) -> None:
        """Report the positions, unless that was done just now."""
        if self.io.now_s >= self._shown_s + PROGRESS_S:
            self._shown_s = self.io.now_s
            self.io.progress()

    def interrupt(self) -> None:
        """End the present cycle without judging it."""
        self.due_s, self.cycling = self.io.now_s, False

    def signal(self) -> Signal | None:
        """Return what ends any phase: a drive in trouble, or one that reports nothing."""
        for drive in self.io.drives:
            if drive.obeys:  # as nearly always: this is asked after every frame
                continue
            if (alert := self.io.group.trouble(drive, moving=True)) is not None:
                return self.blame(alert, drive)
        if not self.missing and self.cycle_is_over:
            self.missing = self.io.mute(self.io.drives)
        return Signal.TROUBLE if self.missing else None

    def compare(self) -> Signal | None:
        """Compare the drives' reports of a cycle with their orders; return what that changes."""
        if self.mode is None:
            return None
        if self._may_have_stopped:
            return self._outage()
        self._late_outages = 0
        for drive in self.io.drives:
            if drive.has_just_reported and drive.mode != self.mode:
                words = f"another program has brought {drive} to mode {drive.mode}"
                return self.blame(Alert(AlertKind.OFF_PATH, words))
            if (alert := _departed(drive)) is not None:
                return self.blame(alert)
        if self.released() and any(map(self.stands_short, self.io.drives)):
            return Signal.STOP  # or it would jump to its target when it comes free
        return None

    def stands_short(self, drive: Cia402Drive) -> bool:
        """Return whether a drive stands short of its target: it is blocked, or receives no targets.

        It jumps to its target when it comes free, or to the next one that it receives.
        """
        if drive.shaft.is_near:
            return False
        # either its reports show that it stands, or none came for long enough that it may
        since_s = max(drive.shaft.still_s, self.began_s)
        lost = self.io.now_s - since_s > LOST_CYCLES * self.io.cycle_s
        return lost or self.seen_to_stand(drive, self.began_s, STAND_CYCLES)

    def seen_to_stand(self, drive: Cia402Drive, since_s: float, cycles: int) -> bool:
        """Return whether its reports since a moment show that a drive stood for some cycles.

        With short cycles and a wide window, a drive that brakes stays within its tremble for some
        of them: it stands once it has stayed there for longer than the end of its ramp takes.
        """
        reports_s = (cycles - JITTER_CYCLES) * self.io.cycle_s
        ends_s = self.io.limits.ramp_end_s(drive.shaft.bounds.tremble)
        return drive.stands(since_s, max(reports_s, ends_s))

    def blame(self, alert: Alert, culprit: Cia402Drive | None = None) -> Signal:
        """Record what is wrong, and the drive to ask why."""
        self.trouble, self.culprit = alert, culprit
        return Signal.TROUBLE

    def _outage(self) -> Signal:
        """Return that there is an outage; TROUBLE if the bus is too slow for this arm.

        Then reports come after each outage, but always late. If none come, drives are mute in time.
        """
        self._late_outages += self.io.group.have_reported(self._outage_s)
        self._outage_s = self.io.now_s
        if self._late_outages < LATE_OUTAGES:
            return Signal.OUTAGE
        self.reason = RequestRejected(SLOW_BUS, silent=True)
        return Signal.TROUBLE

    @property
    def _may_have_stopped(self) -> bool:
        """Whether drives may have missed this program's heartbeat and stopped by themselves.

        With the default settings that is so once a drive has not reported for 0.125 s, before it is
        mute by `MUTE_CYCLES`.

        Such a drive would take its next target as an order to continue, and jump to where the
        others, or the targets, are by now.
        """
        now_s, drives, settings = self.io.now_s, self.io.drives, self.io.settings
        return now_s - self.io.beats.sent_s >= settings.heartbeat_wait_s or any(
            now_s - drive.shaft.read_s >= settings.report_age_s for drive in drives
        )

    # -- actions ------------------------------------------------------------------------------

    def _brake(self) -> None:
        """Stop the drives; the stage of stopping sends the quick stop."""
        self.interrupt()
        self._braking = Cia402Braking(self, self.io.drives)

    def _ask_states(self) -> Script[None]:
        """Read every drive's state before any SYNC on which it may act, unless a stop comes first.

        The stop needs no answers, and a drive that waits for them runs on along what it was sent.
        """
        transfers = self.io.transfers
        jobs = transfers.of_each(STATUSWORD)
        asked = transfers.transfer(jobs, tries=2, given_up=lambda: self.io.stop_asked)
        results = (yield from asked).values()
        if not self.io.stop_asked:
            self.missing = tuple(each.drive for each in results if STATUSWORD not in each.values)
        self.interrupt()

    def _hold(self) -> Script[None]:
        """Make each drive hold where it stands, and reply why the motion ended."""
        braking, unstopped = self._braking, None
        # a drive that sends no PDOs would show no state on the way out of its quick stop
        reporting = [drive for drive in braking.standing if drive not in self.missing]
        standing = [drive for drive in reporting if drive.operates]
        try:
            yield from self.io.states.leave_quick_stop(standing)
        except Obstructed as obstructed:
            unstopped = obstructed.reply
        for drive in self.io.drives:
            drive.rest()
        self.io.progress()
        unstopped = braking.unstopped() or unstopped
        reason = yield from self._why_ended(unstopped)
        self._reply = _joined(reason, unstopped) or Halted()
        if not all(drive.operates for drive in self.io.drives):
            self.io.group.contacted = False  # the next request sets them up again

    def _why_ended(self, unstopped: Reply | None) -> Script[RequestRejected | None]:
        """Return why the motion ended early, and report the trouble; None if it was stopped."""
        if self.trouble is not None:
            alert = yield from self._explain(self.trouble)
            return RequestRejected(alert.text)
        if not self.missing:
            return self.reason
        words = not_heard_words(", ".join(map(str, self.missing)))
        if isinstance(unstopped, RequestRejected) and unstopped.silent:
            words = unstopped.reason  # they were still silent as the others braked
        away = next(filter(None, (drive.away_words for drive in self.missing)), "")
        return RequestRejected(away or words, silent=True)

    def _explain(self, alert: Alert) -> Script[Alert]:
        """Find out what is wrong with a drive, report it, and return it."""
        drive = self.culprit
        if drive is not None and not drive.booted:
            yield from self.io.transfers.explain(drive)
            alert = self.io.group.trouble(drive, moving=True) or alert
        self.io.group.alarm(drive, alert)
        return alert


class CycleStage(ABC):
    """A stage that advances one SYNC cycle at a time."""

    def __init__(self, run: MotionRun) -> None:
        self.run, self.io = run, run.io

    @abstractmethod
    def send(self) -> float:
        """Begin a cycle with commands to the drives; return when it ends."""

    @abstractmethod
    def judge(self) -> Signal | None:
        """Return what has changed in the cycle that has ended."""

    def step(self, now_s: float) -> float:
        """Begin the next cycle when one has ended."""
        return self.run.begin_cycle(self.send()) if now_s >= self.run.due_s else self.run.due_s

    def signal(self, now_s: float) -> Signal | None:  # noqa: ARG002
        """Return what has changed."""
        run = self.run
        signal = run.signal()
        if signal is None and run.cycle_is_over:
            run.show_progress()
            signal = run.compare() or self.judge()
        return signal


class Outage:
    """Drives may have stopped by themselves: read what they sent meanwhile for one cycle.

    A target that waited in this computer may have set them moving again, so their stop shows for
    one cycle only. A target that waits for a SYNC would do the same, so no SYNC is sent before the
    states of all drives are known.

    A jog that was released does not resume, it is stopped: one outage after the other would have it
    slow down by one cycle at a time.
    """

    def __init__(self, run: MotionRun) -> None:
        self._run, self._until_s = run, run.cycle_ends_s
        run.interrupt()

    def step(self, now_s: float) -> float:  # noqa: ARG002
        """Send nothing for a cycle."""
        return self._until_s

    def signal(self, now_s: float) -> Signal | None:
        """Return whether a drive is in trouble; STOP or LOCATED if none is known to be."""
        if (trouble := self._run.signal()) is not None:
            return trouble
        if self._run.released():
            return Signal.STOP
        return Signal.LOCATED if now_s >= self._until_s else None


class Arriving(CycleStage):
    """Every drive gets its final target again and again, until it stands there.

    A late drive is not to blame: the motion waits for it, and ends if it is mute. Only a drive that
    is read off its target is blamed, if it was read there long enough before.
    """

    def __init__(self, run: MotionRun, mode: OperationMode, rest_cycles: int) -> None:
        super().__init__(run)
        self._mode, self._rest_cycles, self._began_s = mode, rest_cycles, run.io.now_s

    def send(self) -> float:
        """Send every drive its target."""
        for drive in self.io.drives:
            self.io.command(drive, ENABLE, self._mode, drive.shaft.goal)
        return self.run.cycle_ends_s

    def judge(self) -> Signal | None:
        """Return whether all drives stand at their targets."""
        for drive in self.io.drives:
            if drive.shaft.asked_s > max(drive.off_s, self._began_s) + SETTLE_S:
                return self.run.blame(off_target_alert(drive))
        if self.io.group.off_target or any(d.near < self._rest_cycles for d in self.io.drives):
            return None
        for drive in self.io.drives:
            drive.shaft.rest_at(drive.shaft.goal, self.io.now_s)
        self.io.progress()
        return Signal.ARRIVED


class Cia402Braking(Braking[Cia402Drive]):
    """How CiA 402 drives are stopped, and seen to stand and hold.

    A drive that has left the bus's operation exchanges no PDOs: because another program ordered
    that, or because it missed a heartbeat (CiA 301, object 1029). It is stopped and read by SDO.
    """

    def __init__(self, run: MotionRun, drives: Sequence[Cia402Drive]) -> None:
        patience_s = 2.0 * run.io.settings.quick_stop_s + BRAKING_S
        super().__init__(drives, run.io.listened, patience_s)
        self._run, self._io, self._began_s = run, run.io, run.io.now_s
        self._by_sdo: dict[Cia402Drive, Iterator[Job]] = {
            drive: cycle((STOP_WRITE, STATUSWORD, POSITION)) for drive in drives
        }
        """The next request to each drive that exchanges no PDOs."""
        self._asked_until_s = dict.fromkeys(drives, -math.inf)

    def step(self, now_s: float) -> float:
        """Send the stop to drives that do not stand."""
        run, io = self._run, self._io
        if now_s < run.due_s:
            return run.due_s
        for drive in self.left:
            # by SDO too if it sends no reports: it may have left operation unheard
            if not drive.operates or drive.missed >= LOST_CYCLES:
                self._ask(drive)
            if drive.operates and drive.state in NEEDS_STOP:
                io.command(drive, STOP, io.states.mode_of(drive))
        io.last_command = "QUICK STOP"
        return run.begin_cycle(run.cycle_ends_s)

    def _ask(self, drive: Cia402Drive) -> None:
        """Send a drive its next request if the last one is answered, or its time is over."""
        io = self._io
        answer = io.group.inbox.answers.pop(drive.node, None)
        if answer is not None or io.now_s >= self._asked_until_s[drive]:
            io.transfers.ask(drive.node, next(self._by_sdo[drive]))
            self._asked_until_s[drive] = io.answered_s(last=False)

    def signal(self, now_s: float) -> Signal | None:
        """Return at the end of a cycle whether all drives stand."""
        if not self._run.cycle_is_over:
            return None
        self._run.show_progress()
        return super().signal(now_s)

    def stands(self, drive: Cia402Drive) -> bool:
        """Return whether a drive has been seen to stand."""
        if drive.booted:
            return True  # it has lost its current, and will not report that
        if drive.shaft.read_s < self._began_s or drive.state in (None, DriveState.ENABLED):
            return False
        if not drive.holds:
            return True  # nothing can be done about how it turns
        return self._run.seen_to_stand(drive, self._began_s, STOP_CYCLES)

    def is_mute(self, drive: Cia402Drive) -> bool:
        """Return whether a drive has missed too many SYNCs."""
        return bool(self._io.mute((drive,)))

    def absence(self, mute: Sequence[Cia402Drive]) -> Timeout | RequestRejected:
        """Return the reply that names missing drives."""
        return self._io.absence(mute)


def _joined(reason: RequestRejected | None, unstopped: Reply | None) -> Reply | None:
    """Return why a motion ended, and why not all drives hold; if all are silent, only that."""
    if reason is None or isinstance(unstopped, Timeout):
        return unstopped
    if isinstance(unstopped, RequestRejected) and unstopped.reason not in reason.reason:
        return replace(reason, reason=f"{reason.reason}. And {unstopped.reason}")
    return reason


def _departed(drive: Cia402Drive) -> Alert | None:
    """Return that a drive has left its path; None if its last reading agrees with its orders."""
    finding = drive.shaft.finding
    if not finding.ends:
        return None
    if finding is DriveFinding.RESTARTED:
        words = f"{drive} counts from zero: it was reset, or lost its power for a moment"
        return Alert(AlertKind.RESTARTED, words)
    return off_target_alert(drive)
