"""Leads MKS drives through one motion: what is said and looked at in each of its phases.

"Done" may never come. A drive has arrived when it stands and its encoder is at its target; one that
stands elsewhere has lost its last order, which is said again, or cannot go on.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TypeAlias

from armdrive.dialects.bus.group import Act, Phase, Signal, Stage, lead
from armdrive.dialects.bus.ledger import ANSWERED_S
from armdrive.dialects.bus.observer import HELD_UP_S, LATE_S, Finding, ObservedDrive, Verdict
from armdrive.dialects.bus.way import KEPT_S
from armdrive.dialects.mks.inquiry import MksInquiry
from armdrive.dialects.mks.steering import Steering, Trip, way_from_here
from armdrive.dialects.mks.stops import STOP_POLL_S, Braking, MksStops
from armdrive.dialects.mks.wire import TRIES, Asking, Hindrance, MksWire, Script
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
)
from firmware_protocol.mks import MotorState, ReadEncoder, ReadState

FRESH_S = 0.3
"""Where a drive stands was read no longer ago than this before it is moved."""
DRAIN_S = 0.03
"""What was kept on the bus has come so long after its first frame, at least."""
SHORT_LOOKS = 3
"""A drive that stands short of its target at so many looks will not go on by itself."""
PATIENCE_S = 1.0
"""So much later than it should a motion may end."""

Doing: TypeAlias = Asking[None]


class MksMotion:
    """Leads the drives of one arm."""

    def __init__(self, wire: MksWire, stops: MksStops, inquiry: MksInquiry) -> None:
        self._wire, self._stops, self._inquiry = wire, stops, inquiry
        self.underruns = 0
        """How often drives stood still although more of their motion was to come."""

    def prepare(self, *, held: bool) -> Hindrance:
        """See to it that a motion can begin; return why it cannot, where it cannot."""
        wire = self._wire
        if not held:
            return RequestRejected("its motors are disabled: call `enable()`", moved=False)
        if any(drive.read_s < wire.now_s - FRESH_S for drive in wire.drives):
            missing = yield from wire.look()
            if missing:
                return RequestRejected(wire.absent_words(missing), moved=False)
        for drive in wire.drives:
            drive.course.advance(wire.now_s)
            if drive.moving or not drive.is_near:
                drive.rest_at(drive.count or 0, wire.now_s)
        wire.observer.watch()
        wire.at_limit.clear()
        return None

    def along(self, request: MoveAlong) -> Script:
        """Steer the drives along segments, until all is driven or something ends it."""
        wire = self._wire
        trip = Trip(request, way_from_here(wire), wire.settings.segment_s)
        leading = Leading(
            wire, self._stops, self._inquiry, request.let_go, wire.settings.segment_s, trip
        )
        try:
            return (yield from leading.carry_out(Phase.MOVING))
        finally:
            self.underruns += trip.underruns

    def arrive(self, expected_s: float, let_go: Callable[[], bool]) -> Script:
        """Wait until drives that were sent somewhere stand there."""
        leading = Leading(self._wire, self._stops, self._inquiry, let_go, expected_s)
        return (yield from leading.carry_out(Phase.ARRIVING))


class Leading:
    """One motion: its stages share it, and its acts change it. A burst has no trip."""

    def __init__(
        self,
        wire: MksWire,
        stops: MksStops,
        inquiry: MksInquiry,
        let_go: Callable[[], bool],
        expected_s: float,
        trip: Trip | None = None,
    ) -> None:
        self.wire, self.stops, self.inquiry = wire, stops, inquiry
        self.let_go, self.trip = let_go, trip
        self.expected_s = expected_s
        """How long it takes drives to their goals once all is sent."""
        self.steering = Steering(wire)
        self.trouble: Verdict | Alert | None = None
        """What is wrong, and ends it."""
        self.short: set[int] = set()
        """Whose order is to be said again."""
        self.braking = Braking(wire, stops, ())
        self._reply: Reply = Done()
        self._judged = False

    def carry_out(self, phase: Phase) -> Script:
        """Lead it to its end."""
        stages: dict[Phase, Callable[[], Stage]] = {
            Phase.HELD_UP: lambda: HeldUp(self),
            Phase.RETURNING: lambda: Returning(self),
            Phase.ARRIVING: lambda: Arriving(self),
            Phase.STOPPING: lambda: self.braking,
        }
        acts: dict[Act, Callable[[], Doing | None]] = {
            Act.STOP: self._stop,
            Act.EXPLAIN: self._explain,
            Act.REPEAT: self._repeat,
            Act.HOLD: lambda: self.stops.hold(self.braking),
        }
        if self.trip is not None:
            trip = self.trip
            stages[Phase.MOVING] = lambda: Moving(self, trip)
            stages[Phase.WAITING] = lambda: Waiting(self, trip)
            acts[Act.TAKE_UP] = lambda: self._take_up(trip)
        yield from lead(self.wire, phase, stages, acts)
        unstopped = self.stops.unstopped(self.braking)
        if isinstance(unstopped, Timeout) or (unstopped and self._judged):
            return unstopped
        return self._reply

    @property
    def stop_asked(self) -> bool:
        """Whether somebody wants it ended."""
        return self.wire.stop_asked or self.let_go()

    def blame(self, trouble: Verdict | Alert | None) -> bool:
        """Take note of what is wrong; tell whether anything is."""
        self.trouble = trouble
        return trouble is not None

    # -- acts ---------------------------------------------------------------------------------

    def _stop(self) -> None:
        """Stop the drives; where they rest is judged, since nobody else looks for that."""
        self._reply = self.steering.refused or Halted()
        self._judged = True
        hard = self.wire.stop_hard
        self.braking = self.stops.brake(self.wire.under_way, hard=hard, judged=True)

    def _explain(self) -> Doing:
        """Stop the drives, then find out what is wrong with one, and say it."""
        trouble = self.trouble
        self.braking = self.stops.brake(self.wire.under_way, judged=self._judged)
        if isinstance(trouble, Verdict) and trouble.finding in (Finding.MUTE, Finding.SILENT):
            trouble = yield from self._unheard(trouble)
        if isinstance(trouble, Verdict):
            trouble = yield from self.inquiry.explain(trouble)
        if trouble is not None:
            self.wire.tell(trouble)
            self._reply = RequestRejected(trouble.text)

    def _unheard(self, verdict: Verdict) -> Asking[Verdict | None]:
        """Look for drives that fell silent; return what is wrong with one that is back.

        The others are stopped, and it is said who is missing.
        """
        wire = self.wire
        silent = [each for each in wire.drives if each.said_s < wire.now_s - LATE_S]
        since_s = min(each.ledger.told_s for each in wire.drives)
        missing = yield from wire.look()
        until_s = wire.now_s + ANSWERED_S
        while not missing and wire.observer.pending and wire.now_s < until_s:
            yield from wire.pause(wire.now_s + DRAIN_S)
        if not missing:
            missing = yield from wire.look()  # of one that is out of reach a second time
        astray = [each for each in silent if each.is_elsewhere and each.node not in missing]
        if astray and not missing:
            return astray[0].verdict
        self.braking.left -= set(missing)
        if set(missing) == set(wire.nodes):
            self._reply = wire.silence(since_s)
        elif missing:
            self._reply = RequestRejected(wire.absent_words(missing), silent=True)
        else:
            named = ", ".join(map(str, silent)) or "a drive"
            what = f"{named} did not answer for a while"
            if verdict.finding is Finding.SILENT:
                what = "no drive was heard for a while"
            words = f"{what}: look at the bus's wiring and its load"
            self._reply = RequestRejected(words, silent=True)
        return None

    def _repeat(self) -> Doing:
        """Give drives that deny it, or stand short of it, their order again.

        One that denies it again is looked into: motors can be coupled, and where one of a wrist's
        two stands, the other turns a joint that nobody meant to turn.
        """
        for drive in self.wire.drives:
            if self.wire.now_s >= drive.rejections.due_s:
                if drive.rejections.confirm():
                    self.trouble = yield from self.inquiry.hindered(drive.node)
                else:
                    self.wire.repeat(drive)
            elif drive.node in self.short:
                self.wire.repeat(drive)
        self.short.clear()

    def _take_up(self, trip: Trip) -> None:
        """Go on from where the drives were found; what is driven twice is not left out."""
        wire = self.wire
        early_s = max(trip.time_s - KEPT_S, 0.0)
        counts = [drive.count or 0 for drive in wire.drives]
        trip.resume(trip.way.nearest_s(counts, early_s, trip.sent_s), wire.now_s)
        for drive in wire.drives:
            drive.anchor(wire.now_s)


class Looks:
    """Every drive is asked where it is at intervals, which also feeds its watchdog."""

    def __init__(self, wire: MksWire, at_s: float = -math.inf) -> None:
        self._wire = wire
        self.at_s = at_s
        """When all were asked last."""

    @property
    def due_s(self) -> float:
        """When they are asked next."""
        return self.at_s + self._wire.settings.poll_s

    def look(self, now_s: float) -> bool:
        """Ask them if it is time to; tell whether they were asked."""
        if now_s < self.due_s:
            return False
        self.at_s = now_s
        ask_all(self._wire)
        return True


class Moving:
    """The drives are steered, and looked at."""

    def __init__(self, leading: Leading, trip: Trip) -> None:
        self._leading, self._wire, self._trip = leading, leading.wire, trip
        self._looks = Looks(leading.wire)
        self._looked_at_s = 0.0
        self._compared = True

    def signal(self, now_s: float) -> Signal | None:
        """Return what has become of it."""
        leading, observer = self._leading, self._wire.observer
        if leading.stop_asked:
            return Signal.STOP
        if leading.steering.refused is not None:
            return Signal.REFUSED
        if leading.trouble is not None:
            return Signal.TROUBLE
        if math.isfinite(observer.returned_s):
            return Signal.BACK
        if observer.unheard_s(now_s) > HELD_UP_S:
            return Signal.HELD_UP
        if leading.blame(self._limit() or observer.judge() or self._beside(now_s)):
            return Signal.TROUBLE
        if now_s >= observer.denied_s:
            return Signal.DENIED
        return Signal.SENT if self._trip.sent_all else None

    def speak(self, now_s: float) -> float:
        """Give the next orders, and ask every drive where it is, which also feeds its watchdog."""
        wire, trip = self._wire, self._trip
        if now_s >= trip.due_s - 1e-9:
            self._leading.steering.steer(trip)
        if self._looks.look(now_s):
            self._looked_at_s, self._compared = trip.at_s(now_s), False
        for node in wire.observer.wants(now_s):
            self._say_again(wire.drive(node))
        for node in wire.observer.doubted:
            wire.put(node, ReadEncoder())
        return min(trip.due_s, self._looks.due_s, wire.observer.due_s)

    def _say_again(self, drive: ObservedDrive) -> None:
        """Say its order again to a drive that has not answered, though others have.

        The order may have been lost; and what it does is asked, which tells whether it is there.
        """
        if drive.moving and drive.ledger.answers_orders:
            self._wire.repeat(drive)
        self._wire.put(drive.node, ReadState())

    def _limit(self) -> Alert | None:
        if not self._wire.at_limit:
            return None
        drive = self._wire.drive(min(self._wire.at_limit))
        words = f"{drive} has run into a limit switch, which stopped it"
        return Alert(AlertKind.ALARM_LOST, words)

    def _beside(self, now_s: float) -> Verdict | None:
        """Weigh where all were at the last look, once all have told."""
        drives = self._wire.drives
        if self._compared or any(drive.read_s < self._looks.at_s for drive in drives):
            return None
        self._compared = True
        way, period_s = self._trip.way, self._wire.settings.segment_s
        return self._wire.observer.compare(way, self._looked_at_s, period_s, now_s)


class HeldUp:
    """Nobody is heard. Each drive ends where it was sent, which is announced, and is asked on.

    Another program has the adapter's cable or the processor, or ours had no time.
    """

    def __init__(self, leading: Leading) -> None:
        self._leading, self._wire = leading, leading.wire
        self._looks = Looks(leading.wire, leading.wire.now_s)

    def signal(self, now_s: float) -> Signal | None:
        """Return what has become of it."""
        observer = self._wire.observer
        if self._leading.stop_asked:
            return Signal.STOP
        if math.isfinite(observer.returned_s):
            return Signal.BACK
        if self._leading.blame(observer.unheard()):
            return Signal.TROUBLE
        return None if observer.unheard_s(now_s) else Signal.HEARD

    def speak(self, now_s: float) -> float:
        """Ask every drive where it is."""
        self._looks.look(now_s)
        return self._looks.due_s


class Returning:
    """Somebody is heard again: what is owed is waited for, then all are asked where they are.

    Late answers would be taken for those of now, and who never answers had no power.
    """

    def __init__(self, leading: Leading) -> None:
        self._leading, self._wire = leading, leading.wire
        self._began_s = self._asked_s = self._due_s = math.inf
        self._begin()

    def _begin(self) -> None:
        self._began_s = self._wire.now_s
        self._asked_s = self._due_s = math.inf
        self._wire.observer.returned_s = math.inf

    def signal(self, now_s: float) -> Signal | None:  # noqa: ARG002
        """Return what has become of it."""
        leading, wire = self._leading, self._wire
        if leading.stop_asked:
            return Signal.STOP
        if math.isfinite(wire.observer.returned_s):  # it was held up once more
            self._begin()
        if leading.blame(wire.observer.unheard()):
            return Signal.TROUBLE
        read = all(drive.read_s >= self._asked_s for drive in wire.drives)
        if not read or wire.observer.doubtful:
            return None
        if leading.blame(found_astray(leading)):
            return Signal.TROUBLE
        if leading.trip is None or leading.trip.sent_all:
            return Signal.SENT
        return Signal.PAUSED if leading.trip.held_back() else Signal.FOUND

    def speak(self, now_s: float) -> float:
        """Wait for what is owed; then ask every drive where it is, until each has told."""
        wire = self._wire
        if math.isinf(self._asked_s):
            drained_s, until_s = self._began_s + DRAIN_S, self._began_s + ANSWERED_S
            if now_s < drained_s or (wire.observer.pending and now_s < until_s):
                return drained_s if now_s < drained_s else min(now_s + DRAIN_S, until_s)
            self._asked_s = self._due_s = now_s
        if now_s >= self._due_s:
            self._due_s = now_s + wire.settings.answer_s
            ask_all(wire)  # those that have told bear witness that the bus is not held up again
        for node in wire.observer.doubted:
            wire.put(node, ReadEncoder())
        return self._due_s


class Waiting:
    """Somebody has paused the arm meanwhile: the drives stand where they were sent.

    What was drawn and not sent waits as well.
    """

    def __init__(self, leading: Leading, trip: Trip) -> None:
        self._leading, self._wire, self._trip = leading, leading.wire, trip
        self._looks = Looks(leading.wire)
        self._there = {drive.node for drive in leading.wire.drives if drive.is_near}

    def signal(self, now_s: float) -> Signal | None:  # noqa: ARG002
        """Return what has become of it."""
        leading, wire = self._leading, self._wire
        if leading.stop_asked:
            return Signal.STOP
        if leading.blame(found_astray(leading) or wire.observer.unheard() or self._turned()):
            return Signal.TROUBLE
        return None if self._trip.held_back() else Signal.RESUMED

    def speak(self, now_s: float) -> float:
        """Ask every drive where it is."""
        self._looks.look(now_s)
        for node in self._wire.observer.doubted:
            self._wire.put(node, ReadEncoder())
        return self._looks.due_s

    def _turned(self) -> Verdict | None:
        for drive in self._wire.drives:
            if drive.node in self._there and not drive.is_near:
                return _blocked(drive)
            if drive.is_near:
                self._there.add(drive.node)
        return None


class Arriving:
    """All has been sent: the drives do what is left of it."""

    def __init__(self, leading: Leading) -> None:
        self._leading, self._wire = leading, leading.wire
        self._due_s = self._looked_s = self._called_s = leading.wire.now_s
        ramp_s = leading.stops.ramp_s
        self._given_up_s = self._due_s + 2.0 * leading.expected_s + ramp_s + PATIENCE_S
        self._short: dict[int, int] = {}

    def signal(self, now_s: float) -> Signal | None:
        """Return what has become of it."""
        if now_s > self._called_s + LATE_S:  # this program was away, and has read nothing
            self._given_up_s += now_s - self._called_s
        self._called_s = now_s
        leading, observer = self._leading, self._wire.observer
        if leading.stop_asked and self._wire.under_way:
            return Signal.STOP
        if leading.trouble is not None:
            return Signal.TROUBLE
        if math.isfinite(observer.returned_s):
            return Signal.BACK
        if leading.blame(self._astray(now_s) or observer.unheard()):
            return Signal.TROUBLE
        if now_s >= observer.denied_s:
            return Signal.DENIED
        if not self._wire.under_way:
            return Signal.THERE
        return Signal.SHORT if leading.short else None

    def speak(self, now_s: float) -> float:
        """Look at those that are under way; one alone has another one for its witness."""
        wire = self._wire
        if now_s < self._due_s:
            return min(self._due_s, wire.observer.denied_s)
        self._due_s, self._looked_s = now_s + STOP_POLL_S, now_s
        left = wire.under_way
        witness = tuple(node for node in wire.nodes if node not in left)[: len(left) == 1]
        for node in (*left, *witness):
            wire.put(node, ReadEncoder())
        for node in left:
            wire.states.pop(node, None)
            wire.put(node, ReadState())
        wire.tell(Progress(wire.registers()))
        return min(self._due_s, wire.observer.denied_s)

    def _astray(self, now_s: float) -> Verdict | None:
        """Weigh what each told at the last look; return what is wrong with one that is not coming.

        Who is behind is not blamed here: its last order may have come late, or was lost.
        """
        for node in self._wire.under_way:
            drive = self._wire.drive(node)
            if drive.is_elsewhere:
                return drive.verdict
            if drive.read_s < self._looked_s or drive.ledger.pending:
                continue
            if self._wire.states.pop(node, None) is MotorState.STOPPED:
                self._stands(drive, now_s)
            if self._short.get(node, 0) >= SHORT_LOOKS * TRIES:
                return _blocked(drive)
        late = self._wire.under_way if now_s >= self._given_up_s else ()
        return _blocked(self._wire.drive(late[0])) if late else None

    def _stands(self, drive: ObservedDrive, now_s: float) -> None:
        if drive.is_near:
            self._wire.host.settle(drive.node)
            drive.rest_at(drive.goal, now_s)
            return
        looks = self._short[drive.node] = self._short.get(drive.node, 0) + 1
        if looks % SHORT_LOOKS == 0 and drive.on_its_way:  # its order may have been lost
            self._leading.short.add(drive.node)


def ask_all(wire: MksWire) -> None:
    """Ask every drive where it is, and show where all were."""
    for node in wire.nodes:
        wire.put(node, ReadEncoder())
    if any(drive.count is not None for drive in wire.drives):
        wire.tell(Progress(wire.registers()))


def found_astray(leading: Leading) -> Verdict | None:
    """Return what is wrong with a drive that was found off all that was sent; None for none."""
    trip = leading.trip
    for motor, drive in enumerate(leading.wire.drives):
        if drive.is_elsewhere:
            return drive.verdict
        if trip is None:
            continue
        early_s = max(trip.time_s - KEPT_S, 0.0)
        spans = (trip.way.span(motor, early_s, trip.sent_s), drive.sent_lately(leading.wire.now_s))
        far = min(span.beyond(drive.count or 0) for span in spans)
        if far > drive.bounds.corridor:
            return _blocked(drive)
    return None


def _blocked(drive: ObservedDrive) -> Verdict:
    return Verdict(drive.node, Finding.BLOCKED, drive.count or 0, drive.course.place)
