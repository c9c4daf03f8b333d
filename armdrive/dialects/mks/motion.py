"""Lead MKS drives through one motion: what is sent and checked in each of its phases.

    MksMotion   begins a motion: along segments (steered), or to targets already sent (a burst)
    MotionRun   one motion: what its stages share, and the actions between them
    Moving      sends targets (`steering`) and polls; judges what the observer and the path say
    Arriving    asks until every drive stands at its last target: at the end, and after an outage
    MksBraking  the stage of stopping (`stops`)

`bus.phases` has the table that leads from one stage to the next by the signals that they return.

The "done" of a drive may never come. So a drive has arrived when it stands and its encoder is at
its target. A drive that stands elsewhere has lost its last order, which is repeated, or is blocked.

If no drive replies for a moment (another program blocks the adapter or the processor, or this one
was suspended), no target is sent: each drive ends at its last one, which was announced. Only when
all are seen to stand there does the motion continue. Until then nothing tells which orders a drive
has received, and when; but a drive that stands at its last target is where it should be.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TypeAlias

from armdrive.dialects.bus.drives import (
    NONE_HEARD,
    SLOW_BUS,
    midway,
    not_heard_words,
)
from armdrive.dialects.bus.intervals import MAX_DELAY_S, DriveFinding
from armdrive.dialects.bus.phases import Act, Phase, Signal, Stage, run_phases
from armdrive.dialects.bus.questions import REPLY_TIMEOUT_S
from armdrive.dialects.controller import FRESH_POSITION_S, MOTORS_OFF
from armdrive.dialects.exchange import TRIES, Obstructed
from armdrive.dialects.mks.contact import MksInquiry
from armdrive.dialects.mks.drive import MksDrive
from armdrive.dialects.mks.exchange import MksExchange, MksScript, Script
from armdrive.dialects.mks.observer import Verdict
from armdrive.dialects.mks.paths import KEPT_S
from armdrive.dialects.mks.steering import Steering, Trip
from armdrive.dialects.mks.stops import STOP_POLL_S, MksStops
from armdrive.tasks import (
    Alert,
    AlertKind,
    Done,
    Halted,
    MoveAlong,
    Progress,
    Reply,
    RequestRejected,
    Timeout,
    never,
)
from firmware_protocol.mks import MotorState, ReadEncoder, ReadState

# A drive that stands short of its target at this many looks needs its order again.
SHORT_LOOKS = 3
# How much later than expected a motion may end.
PATIENCE_S = 1.0

Action: TypeAlias = MksScript[None]


class MksMotion:
    """Moves the drives of one arm."""

    def __init__(self, io: MksExchange, stops: MksStops, inquiry: MksInquiry) -> None:
        self._io, self._stops, self._inquiry = io, stops, inquiry
        self.underruns = 0
        """How often drives stood still although more of their motion was to come."""

    def prepare(self, *, held: bool) -> MksScript[None]:
        """Prepare a motion. Raises `Obstructed` if it cannot begin."""
        io = self._io
        if not held:
            raise Obstructed(MOTORS_OFF)
        for drive in io.drives:
            if drive.two_zeros:
                raise Obstructed(drive.two_zeros)
        if any(drive.read_s < io.now_s - FRESH_POSITION_S for drive in io.drives):
            yield from io.require_positions()
        for drive in io.drives:
            drive.stand(io.now_s)
        io.observer.watch()

    def along(self, request: MoveAlong) -> Script:
        """Steer the drives along segments, until the end or until something stops them."""
        io = self._io
        period_s = io.settings.segment_s
        steering = Steering(io, Trip(request, io.drives, period_s))
        run = MotionRun(io, self._stops, self._inquiry, period_s, steering, request.released)
        try:
            return (yield from run.carry_out(Phase.MOVING))
        finally:
            self.underruns += steering.trip.underruns

    def arrive(self, expected_s: float) -> Script:
        """Wait until drives that have targets stand there."""
        run = MotionRun(self._io, self._stops, self._inquiry, expected_s)
        return (yield from run.carry_out(Phase.ARRIVING))


class MotionRun:
    """One motion: its stages share it, and its actions change it. A burst is not steered."""

    def __init__(
        self,
        io: MksExchange,
        stops: MksStops,
        inquiry: MksInquiry,
        expected_s: float,
        steering: Steering | None = None,
        released: Callable[[], bool] = never,
    ) -> None:
        self.io, self.stops, self.inquiry = io, stops, inquiry
        self.released, self.steering = released, steering
        self.trip = None if steering is None else steering.trip
        self.expected_s = expected_s
        """How long the drives take to their targets once all orders have been sent."""
        self.refused: RequestRejected | None = None
        """Why a target cannot be commanded."""
        self.trouble: Verdict | Alert | None = None
        """What is wrong and ends the motion."""
        self.short: set[MksDrive] = set()
        """The drives that need their order again."""
        self.braking = stops.brake(())
        """The stage of its latest stop; of no drives before the first one."""
        self._reply: Reply = Done()
        self._silent: list[MksDrive] = []
        """The drives that were silent when the trouble was found."""
        self._judged = False
        """Whether it was stopped, so that only the places where the drives rest show a fault."""

    def carry_out(self, phase: Phase) -> Script:
        """Run the motion to its end."""
        stages: dict[Phase, Callable[[], Stage]] = {
            Phase.OUTAGE: lambda: Arriving(self),
            Phase.ARRIVING: lambda: Arriving(self),
            Phase.STOPPING: lambda: self.braking,
        }
        # While an action runs, no stop is noticed or repeated. So one that may wait long for
        # replies comes when all stand, and the others are short.
        acts: dict[Act, Callable[[], Action | None]] = {
            Act.STOP: self._stop,
            Act.EXPLAIN: self._explain,
            Act.REPEAT: self._repeat,
            Act.HOLD: self._hold,
        }
        if self.steering is not None:
            steering = self.steering
            stages[Phase.MOVING] = lambda: Moving(self, steering)
            acts[Act.RESUME] = lambda: self._resume(steering.trip)
        yield from run_phases(self.io, phase, stages, acts, self.released)
        unstopped = self.braking.unstopped()
        # after trouble, its own words say more than those about the stop
        if isinstance(unstopped, Timeout) or (unstopped and self._judged):
            return unstopped
        return self._reply

    def reported(self) -> Verdict | Alert | None:
        """Return what a drive has reported that ends the motion; None if none has."""
        for drive in self.io.drives:
            if drive.unfit:
                return _blocked(drive)
        for drive in self.io.drives:
            if drive.at_limit:
                words = f"{drive} has run into a limit switch, which stopped it"
                return Alert(AlertKind.ALARM_LOST, words)
        return None

    def blame(self, trouble: Verdict | Alert | None) -> bool:
        """Record what is wrong; return whether anything is."""
        self.trouble = trouble
        return trouble is not None

    # -- actions ------------------------------------------------------------------------------

    def _stop(self) -> None:
        """Stop the drives, and judge where they come to rest: no other check does."""
        self._reply = self.refused or Halted()
        self._judged = True
        hard = self.io.stop_hard
        self.braking = self.stops.brake(self.io.under_way, hard=hard, judged=True)

    def _explain(self) -> Action:
        """Stop the drives; if the one with the trouble replies, ask it why at once.

        A silent one may reply again while all brake: then it is judged where it comes to rest.
        """
        io, silence = self.io, self._silence is not None
        self._silent = [each for each in io.drives if each.frame_s < io.now_s - MAX_DELAY_S]
        self.braking = self.stops.brake(io.under_way, judged=self._judged or silence)
        if not silence:
            yield from self._report(self.trouble)

    def _hold(self) -> Action:
        """Have each drive hold where it stands; then look for drives that fell silent."""
        yield from self.stops.hold(self.braking, judged=self._judged)
        if (silence := self._silence) is not None:
            yield from self._report((yield from self._find_silent(silence)))

    @property
    def _silence(self) -> Verdict | None:
        """The trouble, if it is that drives do not reply, or reply late."""
        trouble, silent = self.trouble, (DriveFinding.MUTE, DriveFinding.SILENT, DriveFinding.LATE)
        return trouble if isinstance(trouble, Verdict) and trouble.finding in silent else None

    def _report(self, trouble: Verdict | Alert | None) -> Action:
        """Find out why a drive is off its path, and report what is wrong."""
        if isinstance(trouble, Verdict):
            trouble = yield from self.inquiry.explain(trouble)
        if trouble is not None:
            self.io.notify(trouble)
            self._reply = RequestRejected(trouble.text)

    def _find_silent(self, verdict: Verdict) -> MksScript[Verdict | None]:
        """Look for drives that fell silent; return what is wrong with one that is back.

        The others are stopped, and the reply names the missing drives.
        """
        io = self.io
        since_s = min(each.ledger.sent_s for each in io.drives)
        missing = yield from io.look()
        if len(missing) < len(io.drives):
            # By then the replies that are only late have come, and the bus is back for all. And
            # only a second reading proves that a drive is out of reach.
            yield from io.pause(io.now_s + REPLY_TIMEOUT_S)
            missing = yield from io.look(missing or io.drives, tries=2)
        elsewhere = [each for each in self._silent if each.is_elsewhere]
        if elsewhere and not missing:
            return Verdict.on_reading(elsewhere[0])
        left = self.braking.left
        self.braking.left = [drive for drive in left if drive not in missing]
        if missing:
            self._reply = midway(io.absence(missing, since_s))
        else:
            words = not_heard_words(", ".join(map(str, self._silent)) or "a drive")
            if verdict.finding is DriveFinding.LATE:
                words = SLOW_BUS
            elif verdict.finding is DriveFinding.SILENT or len(self._silent) == len(io.drives):
                words = NONE_HEARD
            self._reply = RequestRejected(words, silent=True)
        return None

    def _repeat(self) -> None:
        """Repeat the order of drives that rejected it or stand short of it.

        A drive that rejects it is asked why at once. Motors can be coupled: if one of a wrist's two
        motors stands, the other turns a joint that should not move.
        """
        for drive in self.io.drives:
            if self.io.now_s >= drive.rejected_s:
                drive.rejected_s = math.inf
                self.inquiry.ask_fitness(drive)
                self.io.repeat(drive)
            elif drive in self.short:
                self.io.repeat(drive)
        self.short.clear()

    def _resume(self, trip: Trip) -> None:
        """Continue from where the drives stand; a part driven twice is better than one left out."""
        io = self.io
        early_s = max(trip.time_s - KEPT_S, 0.0)
        counts = [drive.count for drive in io.drives]
        trip.resume(trip.path.nearest_s(counts, early_s, trip.sent_s), io.now_s)


class Moving:
    """The drives are steered and observed."""

    def __init__(self, run: MotionRun, steering: Steering) -> None:
        self._run, self._io = run, run.io
        self._steering, self._trip = steering, steering.trip
        self._polled_s = -math.inf
        """When every drive was asked for its position last, which also feeds its watchdog."""
        self._polled_at_s = 0.0
        """The path time of that moment."""
        self._compared = True

    def signal(self, now_s: float) -> Signal | None:
        """Return what has changed."""
        run, observer = self._run, self._io.observer
        if self._steering.refused is not None:
            run.refused = self._steering.refused
            return Signal.OUT_OF_RANGE
        if self._trip.sent_all:
            return Signal.ALL_SENT
        if run.blame(run.reported()):
            return Signal.TROUBLE
        if observer.returned or observer.in_outage(now_s):
            return Signal.OUTAGE
        if run.blame(observer.judge() or self._off_path(now_s)):
            return Signal.TROUBLE
        if now_s >= observer.rejected_s:
            return Signal.REJECTED
        return None

    def step(self, now_s: float) -> float:
        """Send the next orders and ask for positions."""
        io, trip = self._io, self._trip
        if now_s >= trip.due_s - 1e-9:
            self._steering.steer()
        if now_s >= self._polled_s + io.settings.poll_s:
            self._polled_s, self._polled_at_s, self._compared = now_s, trip.at_s(now_s), False
            for drive in io.drives:
                io.put(drive, ReadEncoder())
            if any(drive.is_located for drive in io.drives):
                io.notify(Progress(io.registers()))
        for drive in io.observer.to_retry(now_s):
            self._retry(drive)
        for drive in io.observer.to_reread:
            io.put(drive, ReadEncoder())
        return min(trip.due_s, self._polled_s + io.settings.poll_s, io.observer.due_s)

    def _retry(self, drive: MksDrive) -> None:
        """Repeat the order of a drive that is silent while others reply: it may have been lost.

        A question about its state shows whether the drive is there. A drive that stays silent may
        have restarted, and is asked for its position instead.
        """
        if drive.may_have_restarted(self._io.now_s):
            self._io.put(drive, ReadEncoder())
        elif drive.moving and drive.ledger.answers_orders:
            self._io.repeat(drive)
        self._io.put(drive, ReadState())

    def _off_path(self, now_s: float) -> Verdict | None:
        """Compare all positions of the last look with the path, once every drive has answered."""
        drives = self._io.drives
        if self._compared or any(drive.read_s < self._polled_s for drive in drives):
            return None
        self._compared = True
        period_s = self._io.settings.segment_s
        return self._trip.contour.compare(self._polled_at_s, period_s, now_s)


class Arriving:
    """The drives complete their orders: no more will follow, or not before all stand.

    After an outage the motion resumes once all stand. If the arm is paused by then, they are polled
    until it resumes: segments that are known but not sent wait as well.
    """

    def __init__(self, run: MotionRun) -> None:
        self._run, self._io = run, run.io
        self._due_s = run.io.now_s
        self._given_up_s = 0.0
        self._short: dict[MksDrive, int] = {}
        self._restart()

    def _restart(self) -> None:
        """Give the drives their time from now on; looks during an outage do not count."""
        patience_s = 2.0 * self._run.expected_s + self._run.stops.ramp_s + PATIENCE_S
        self._given_up_s = self._io.listened.s + patience_s
        self._short.clear()
        self._io.observer.returned = False

    def signal(self, now_s: float) -> Signal | None:
        """Return what has changed."""
        run, io = self._run, self._io
        if run.blame(run.reported()):
            return Signal.TROUBLE
        if io.observer.returned:
            self._restart()
        if run.blame(self._stuck(now_s) or io.observer.silence()):
            return Signal.TROUBLE
        if now_s >= io.observer.rejected_s:
            return Signal.REJECTED
        if run.short:
            return Signal.SHORT
        if io.under_way:
            return None
        if run.trip is None or run.trip.sent_all:
            return Signal.ARRIVED
        displaced = next((each for each in io.drives if not each.is_near), None)
        if displaced is not None and run.blame(_blocked(displaced)):
            return Signal.TROUBLE
        return None if run.trip.held_back() else Signal.LOCATED

    def step(self, now_s: float) -> float:
        """Ask the drives that are under way, and another one; in a pause all.

        In a pause and during an outage they are asked less often: else the replies that an adapter
        has held back would be too many for the codec when they come at once.
        """
        io = self._io
        if now_s >= self._due_s:
            left = io.under_way
            often = left and not io.observer.in_outage(now_s)
            self._due_s = now_s + (STOP_POLL_S if often else io.settings.poll_s)
            for drive in (*left, *io.witness(left)) if left else io.drives:
                io.put(drive, ReadEncoder())
            for drive in left:
                drive.state = None
                io.put(drive, ReadState())
            io.notify(Progress(io.registers()))
        return min(self._due_s, io.observer.rejected_s)

    def _stuck(self, now_s: float) -> Verdict | None:
        """Judge the answers to the last look; return what is wrong with a drive that is stuck.

        A drive that is merely behind is not blamed: its last order may be late or lost.
        """
        for drive in self._io.under_way:
            if drive.is_elsewhere:
                return Verdict.on_reading(drive)
            # only a look after its last order, and each once
            counts = drive.asked_s >= drive.course.ordered_s and not drive.absence.suspected
            if counts and drive.state is MotorState.STOPPED:
                self._stands(drive, now_s)
            drive.state = None
            if self._short.get(drive, 0) >= SHORT_LOOKS * TRIES:
                return _blocked(drive)
        over = self._io.listened.s >= self._given_up_s
        late = self._io.under_way if over else ()
        return _blocked(late[0]) if late else None

    def _stands(self, drive: MksDrive, now_s: float) -> None:
        if drive.is_near:
            drive.rest_at(drive.goal, now_s)
            return
        looks = self._short[drive] = self._short.get(drive, 0) + 1
        if looks % SHORT_LOOKS == 0 and drive.is_on_path:  # its order may have been lost
            self._run.short.add(drive)


def _blocked(drive: MksDrive) -> Verdict:
    return Verdict(drive, DriveFinding.BLOCKED, drive.count, drive.course.place)
