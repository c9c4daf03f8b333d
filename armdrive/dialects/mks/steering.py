"""Motion of MKS drives by steering: each is given a new target again and again, in flight.

At a fixed period every motor that moves is told the speed that brings it, by the end of the period,
to where the motion should be then, and a target that it would not reach before the next order but
no later than announced if none came: as far ahead as it goes one way. So drives do not brake
between segments, and stop by themselves when their host dies. Speeds are whole rpm; what rounding
leaves over is in the next period's way, so nothing adds up.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Collection, Generator, Iterator, Mapping, Sequence
from dataclasses import dataclass

from armdrive.dialects.bus.segments import BusSegment
from armdrive.dialects.mks.arrival import Ending, MksArrival
from armdrive.dialects.mks.drive import COUNTS_S_PER_RPM, MksDrive, whole_rpm
from armdrive.dialects.mks.observer import laggard
from armdrive.dialects.mks.stops import ALL_MUTE_LOOKS, MUTE_LOOKS
from armdrive.tasks import (
    Alert,
    AlertKind,
    MoveAlong,
    MoveBy,
    Progress,
    Reply,
    RequestRejected,
    never,
)
from firmware_protocol.mks import (
    SPEED_MAX_RPM,
    Answered,
    ArmSynchronous,
    EncoderRead,
    Event,
    Failed,
    LimitStop,
    MoveAbsoluteAxis,
    ReadEncoder,
    ReadState,
    StoredForStart,
)
from kinematics.spaces import Motors

# The way of a motion that is steered: segments on a time of their own, looked at motor by motor.
#
# Counts, seconds since the motion began. Segments are straight and join; their end is as far as
# anything has been drawn.

KEEP_S = 1.0
"""What lies behind is remembered for so long: drives may be found to be there still."""
LOOK_S, FINE_S = 0.01, 0.001
"""How finely a place on the way is looked for, at first and at last."""


@dataclass(frozen=True, slots=True)
class Lead:
    """How a motor goes on: which way (0 where it stands), how far before it turns, until when."""

    way: int
    far: float
    until_s: float


def shares_of(speeds: Sequence[float]) -> list[float]:
    """Return each speed as a share of the fastest; 1 where nothing moves."""
    fastest = max(speeds)
    return [speed / fastest if fastest else 1.0 for speed in speeds]


class Track:
    """The segments that were drawn and not passed."""

    def __init__(self, start: Motors) -> None:
        self.end = start
        self.end_s = 0.0
        self._pieces: deque[BusSegment] = deque()

    def draw(self, segment: MoveBy) -> None:
        """Take in the next segment."""
        end, end_s = self.end + segment.steps, self.end_s + segment.duration_s
        self._pieces.append(BusSegment(self.end_s, end_s, self.end, end))
        self.end, self.end_s = end, end_s

    def pass_by(self, time_s: float) -> None:
        """Forget what lies far behind."""
        while len(self._pieces) > 1 and self._pieces[0].end_s <= time_s - KEEP_S:
            self._pieces.popleft()

    def at(self, motor: int, time_s: float) -> float:
        """Return where a motor shall be at a time."""
        for piece in self._pieces:
            if time_s < piece.end_s:
                return piece.at(motor, time_s)
        return float(self.end[motor])

    def nearest_s(self, counts: Sequence[int], early_s: float, late_s: float) -> float:
        """Return when between two times motors should be where they were found, or nearest to it.

        The earliest such time: what is driven twice is not left out.
        """
        for step_s in (LOOK_S, FINE_S):
            steps = max(math.ceil((late_s - early_s) / step_s), 1)
            times = [min(early_s + step * step_s, late_s) for step in range(steps + 1)]
            found_s = min(times, key=lambda time_s: self._off(counts, time_s))
            early_s, late_s = max(found_s - LOOK_S, early_s), min(found_s + LOOK_S, late_s)
        return found_s

    def span(self, motor: int, early_s: float, late_s: float) -> tuple[float, float]:
        """Return from where to where a motor goes between two times."""
        inner = [piece.end[motor] for piece in self._pieces if early_s < piece.end_s < late_s]
        places = (self.at(motor, early_s), self.at(motor, late_s), *inner)
        return min(places), max(places)

    def _off(self, counts: Sequence[int], time_s: float) -> float:
        return max(abs(self.at(motor, time_s) - count) for motor, count in enumerate(counts))

    def mean(self, motor: int, from_s: float, lead: Lead) -> float:
        """Return how fast a motor goes on a lead, at a mean."""
        way = abs(lead.far - self.at(motor, from_s))
        return way / (lead.until_s - from_s) if way else 0.0

    def lead(self, motor: int, from_s: float, until_s: float) -> Lead:
        """Return how a motor goes on from a time: no further than it goes one way."""
        way, far, far_s = 0, self.at(motor, from_s), from_s
        for piece in self._pieces:
            if piece.end_s <= from_s:
                continue
            if piece.start_s >= until_s:
                break
            turn = piece.end[motor] - piece.start[motor]
            if turn * way < 0:
                break
            if turn:
                way = 1 if turn > 0 else -1
                far_s = min(piece.end_s, until_s)
                far = piece.at(motor, far_s)
        return Lead(way, far, far_s)


@dataclass(slots=True)
class SteeredTrip:
    """One motion under way: where its segments come from, and how far it is."""

    segments: Iterator[MoveBy]
    ahead_s: float
    let_go: Callable[[], bool]
    track: Track
    held_back: Callable[[], bool] = never
    """Whether somebody has paused the arm."""
    time_s: float = 0.0
    """Where on the track the motors are now."""
    sent_s: float = 0.0
    """How far on it they have been sent."""
    steered_s: float = -math.inf
    due_s: float = -math.inf
    """When the drives are to be steered next."""
    polled_s: float = -math.inf
    polled_at_s: float = 0.0
    """Where on the track the motors were to be at that look."""
    weighed: bool = True
    """Whether it has been weighed what all drives told then."""
    beside: int = 0
    """At how many looks in a row they were beside their way."""
    guess_s: float = 0.0
    exhausted: bool = False
    held: bool = False
    """Whether nothing more is to be drawn for now."""

    @property
    def sent_all(self) -> bool:
        """Whether nothing is left to be steered."""
        return (self.exhausted or self.held) and self.time_s >= self.track.end_s

    def is_due(self, now_s: float, period_s: float) -> bool:
        """Tell whether it is time to steer, and then set the next one: late ones do not add up."""
        if now_s < self.due_s - 1e-9:
            return False
        self.due_s = max(self.due_s, now_s - period_s / 2.0) + period_s
        return True

    def go_on(self, now_s: float) -> None:
        """Let the time since the last steering pass, as far as the motors had been sent."""
        if math.isfinite(self.steered_s):
            self.time_s = min(self.time_s + now_s - self.steered_s, self.sent_s)
        self.steered_s = now_s
        self.track.pass_by(self.time_s)

    def look(self, now_s: float) -> None:
        """Take note that all drives are asked where they are."""
        self.polled_s, self.weighed = now_s, False
        since_s = now_s - self.steered_s if math.isfinite(self.steered_s) else 0.0
        self.polled_at_s = min(self.time_s + since_s, self.sent_s)

    def resume(self, time_s: float, now_s: float) -> None:
        """Go on from a time on the track that the motors are found to be at."""
        self.time_s = self.sent_s = time_s
        self.weighed, self.beside = True, 0
        self.steered_s = self.due_s = now_s

    def draw(self) -> bool:
        """Draw segments while there is room; tell whether the track had run out before."""
        dry = self.time_s >= self.track.end_s > 0.0 and not (self.exhausted or self.held)
        drew = False
        while not (self.exhausted or self.held) and self._has_room():
            segment = next(self.segments, None)
            if segment is None:
                self.exhausted = True
                break
            self.track.draw(segment)
            self.guess_s, drew = segment.duration_s, True
        return dry and drew

    def _has_room(self) -> bool:
        left_s = self.track.end_s - self.time_s
        return left_s <= 0.0 or left_s + self.guess_s <= self.ahead_s + 1e-6


# A bus that stands still for a moment while MKS drives are steered: they wait, and go on there.
#
# Nobody is heard then: another program has the adapter's cable or the processor, or ours had no
# time. Each drive ends where it was sent, which is announced. Nothing further is sent until
# somebody is heard. Then all are asked where they are, and the motion goes on from that place of
# its way: what was drawn for the time since is not made up for. A supply that failed looks the
# same, but what was asked meanwhile is never answered. Who pauses the arm meanwhile has it stand
# where it stands.

HELD_S = 0.06
"""A bus on which nobody has answered for so long, though somebody was asked, is held up."""


class MksBusOutage(MksArrival):
    """Notices that nobody is heard, and takes up a motion again."""

    @property
    def held_up(self) -> bool:
        """Whether nobody answers: a mute drive has been asked before others were heard last."""
        heard_s = self.answered_last_s
        asked = (drive.gap.since_s for drive in self.drives)
        return (
            self.now_s > min((at_s for at_s in asked if at_s >= heard_s), default=math.inf) + HELD_S
        )

    @property
    def soon_s(self) -> float:
        """When a drive is to be spoken to next for what it has said, or has not."""
        last_s = self.answered_last_s
        return min(self.denial_s, *(each.gap.urge_s(last_s) for each in self.drives))

    def urge(self) -> None:
        """Ask drives again that have not answered, while others did: whether they are there."""
        last_s = self.answered_last_s
        for drive in self.drives:
            if self.now_s >= drive.gap.urge_s(last_s):
                self.put(drive.node, ReadState())

    def catch_up(
        self, trip: SteeredTrip, quiet_s: float, owed: Mapping[int, int]
    ) -> Generator[float, Event | None, Reply | None]:
        """Find where the drives are after nobody was heard since a time, and go on from there.

        `owed` is as in `weigh_silence`. Return how the motion ends, where it cannot go on.
        """
        yield from self.weigh_silence(quiet_s, owed)
        if self.stop_asked:
            return None
        missing = yield from self.look_once(self.nodes)
        if set(missing) == set(self.nodes):
            trip.steered_s = self.now_s  # what was heard was said unasked: it is held up still
            return None
        end = (yield from self._found(trip, quiet_s, missing)) or (yield from self._stay(trip))
        if end is None and not self.stop_asked:
            self._go_on(trip)
        return end

    def _found(
        self, trip: SteeredTrip, quiet_s: float, missing: Collection[int]
    ) -> Generator[float, Event | None, Reply | None]:
        """Weigh where the drives were found; return how the motion ends, where one is astray."""
        if missing:
            missing = yield from self.look(missing)
        if self.stop_asked:
            return None
        if missing:
            return (yield from self.lose(quiet_s))
        early_s = max(trip.time_s - KEEP_S, 0.0)
        for motor, drive in enumerate(self.drives):
            low, high = trip.track.span(motor, early_s, trip.sent_s)
            count, margin = drive.seen or 0, self.settings.corridor_counts
            if self.began_anew(drive.node) or not low - margin <= count <= high + margin:
                return (yield from self.break_off(drive.node))
        return None

    def _stay(self, trip: SteeredTrip) -> Generator[float, Event | None, Reply | None]:
        """Stand at the last targets for as long as somebody has paused the arm meanwhile.

        It stands already: what was drawn and not sent is to wait as well. Return how the motion
        ends, where a drive that was there was turned.
        """
        while trip.held_back() and not (self.stop_asked or trip.let_go()):
            there = [node for node in self.nodes if self.is_near(node)]
            began_s = self.now_s
            yield from self.pause(began_s + self.settings.poll_s)
            missing = yield from self.look_once(self.nodes)
            if (end := (yield from self._found(trip, began_s, missing))) is not None:
                return end
            for node in there:
                if not self.is_near(node):
                    return (yield from self.break_off(node))
        return None

    def _go_on(self, trip: SteeredTrip) -> None:
        """Go on from where the drives were found."""
        early_s = max(trip.time_s - KEEP_S, 0.0)
        counts = [drive.seen or 0 for drive in self.drives]
        trip.resume(trip.track.nearest_s(counts, early_s, trip.sent_s), self.now_s)
        for drive, count in zip(self.drives, counts, strict=True):
            drive.anchor(count, self.now_s)
        self.underruns += 1


# Whether MKS drives that are steered are beside the way that was checked: one of them lags alone.
#
# The model of a drive that turns too slowly is drawn to where it is, and it keeps pace, so that it
# is not doubted; but the others go on by their own time, and the arm leaves its way by all that it
# lags. Drives that are late together are on their way, only later, and are well.

LOOKS = 2
"""At so many looks in a row the drives are beside their way, before one is blamed."""

SLOWEST = 10.0
"""A drive is weighed that should turn by this part of the corridor from look to look, or more."""


def is_on(
    track: Track, counts: Sequence[int], let_pass: Sequence[float], early_s: float, late_s: float
) -> bool:
    """Tell whether there is one time, from the late one back to the early one, that fits all."""
    time_s = late_s
    while time_s > early_s - LOOK_S:
        if _fits(track, counts, let_pass, max(time_s, early_s)):
            return True
        time_s -= LOOK_S
    return False


def _fits(track: Track, counts: Sequence[int], let_pass: Sequence[float], time_s: float) -> bool:
    return all(
        abs(track.at(motor, time_s) - count) <= most
        for motor, (count, most) in enumerate(zip(counts, let_pass, strict=True))
    )


class MksContourError(MksBusOutage):
    """Ends a motion in which one drive falls behind the others."""

    def beside(self, trip: SteeredTrip) -> Generator[float, Event | None, Reply | None]:
        """Weigh where all were at the last look, once all have told; return how it ends, if so."""
        if trip.weighed or any(drive.seen_s < trip.polled_s for drive in self.drives):
            return None
        trip.weighed = True
        counts = [drive.seen or 0 for drive in self.drives]
        corridor = self.settings.corridor_counts
        slow = laggard([each.pace for each in self.drives], corridor / SLOWEST)
        if slow is not None:
            place = trip.track.at(slow, trip.polled_at_s)
            if abs(place - counts[slow]) > corridor / 2.0:
                return (yield from self._lags(slow, place))
        let_pass = [corridor + drive.late_by(self.now_s) for drive in self.drives]
        late_s = min(trip.polled_at_s + self.settings.segment_s, trip.track.end_s)
        if is_on(trip.track, counts, let_pass, max(late_s - KEEP_S, 0.0), late_s):
            trip.beside = 0
            return None
        trip.beside += 1
        if trip.beside < LOOKS:
            return None
        motor = max(
            range(len(counts)),
            key=lambda motor: abs(trip.track.at(motor, late_s) - counts[motor]) / let_pass[motor],
        )
        return (yield from self._lags(motor, trip.track.at(motor, late_s)))

    def _lags(self, motor: int, place: float) -> Generator[float, Event | None, Reply]:
        drive = self.drives[motor]
        off = abs(round(place) - (drive.seen or 0))
        alert = yield from self.hindered(drive.node)
        words = (
            f"{drive} is {off} counts beside its way, which the others keep: it is overloaded, or "
            "its supply is too weak for its speed"
        )
        return (yield from self.break_off(drive.node, alert or Alert(AlertKind.ASTRAY, words)))


SLOW_RPM = LAST_RPM = 3
"""Slower than this, a drive is sent to the end of the period alone: it stands there."""
CREEP_RPM, FAR = 32, 2.0
"""Slower than this, or so many corridors behind, one is told to be there when it is announced."""
CATCH_UP, CATCH_UP_RPM = 1.25, 30
"""How much faster than planned a drive may be told to go that is behind."""
GAIN = 0.3
"""How far the model of a moving drive follows its encoder at each look."""
FRESH_S = 0.3
SHOWS_PERIODS = 1.5
"""A drive whose orders stay the same is given them anew after so long: who takes none says so."""


class MksMotion(MksContourError):
    """Drives segments by steering."""

    def drive_along(self, request: MoveAlong) -> Ending:
        """Steer the drives along segments, until all is driven or something ends it."""
        hindrance = yield from self.prepare()
        if hindrance is not None:
            return hindrance
        track = Track(Motors(drive.target for drive in self.drives))
        back = request.held_back
        trip = SteeredTrip(request.segments, request.ahead_s, request.let_go, track, back)
        self.ahead_s = max(request.ahead_s, self.settings.segment_s)
        for drive in self.drives:
            drive.heard_s = drive.answered_s = self.now_s
            drive.unanswered = 0
            drive.denials.forget()
        while not trip.sent_all:
            if self.stop_asked or request.let_go():
                return (yield from self.halted())
            if not self.held_up and trip.is_due(self.now_s, self.settings.segment_s):
                trip.go_on(self.now_s)
                trip.held = trip.held_back()
                self.underruns += trip.draw()
                if (refused := self._steer(trip)) is not None:
                    yield from self.halted()
                    return refused
            self._poll(trip)
            self.urge()
            wake_s = self._poll_s(trip)
            heard = yield wake_s if self.held_up else min(trip.due_s, wake_s, self.soon_s)
            end = (yield from self._weighed(trip, heard)) if heard is not None else None
            if end is None and not self.stop_asked:  # who was suspended has heard nobody, and stops
                end = (yield from self._denied()) or (yield from self._unheard())
            if end is not None:
                return end
        return (yield from self.arrive(self.settings.segment_s, request.let_go))

    def prepare(self) -> Generator[float, Event | None, RequestRejected | None]:
        """See to it that a motion can begin; return why it cannot, where it cannot."""
        if not self.on:
            return RequestRejected("its motors are disabled: call `enable()`", moved=False)
        if any(drive.seen_s < self.now_s - FRESH_S for drive in self.drives):
            missing = yield from self.look()
            if missing:
                return RequestRejected(self.absent_words(missing), moved=False)
        for drive in self.drives:
            drive.advance(self.now_s)
            if drive.moving or abs((drive.seen or 0) - drive.target) > self.reach:
                drive.rest_at(drive.seen or 0, self.now_s)
            drive.leap.begin(drive.seen, drive.seen_s)
            drive.gap.forget()  # whatever it missed while it stood, its count was read since
        return None

    @staticmethod
    def catching_up_hz(rate_hz: float) -> float:
        """Return the fastest rate that a drive is told where it is to turn this fast, but lags."""
        planned = rate_hz / COUNTS_S_PER_RPM
        return _catch_up_rpm(planned) * COUNTS_S_PER_RPM

    # -- steering -----------------------------------------------------------------------------

    def _steer(self, trip: SteeredTrip) -> RequestRejected | None:
        """Give every drive that moves its next order."""
        ahead_s = min(trip.time_s + trip.ahead_s, trip.track.end_s)
        trip.sent_s = ahead_s
        ending = trip.exhausted or trip.held
        last = ending and trip.time_s + self.settings.segment_s >= trip.track.end_s - 1e-9
        track, motors = trip.track, range(len(self.drives))
        leads = [track.lead(motor, trip.time_s, ahead_s) for motor in motors]
        shares = shares_of([track.mean(motor, trip.time_s, leads[motor]) for motor in motors])
        for motor, (drive, lead) in enumerate(zip(self.drives, leads, strict=True)):
            drive.advance(self.now_s)
            order = self._last_order(trip, motor) if last else self._order(trip, motor, lead)
            if order is None:
                continue
            target, rpm = order
            if last or rpm < CREEP_RPM or abs(drive.behind) > FAR * self.settings.corridor_counts:
                rpm = max(rpm, self.least_rpm(drive, target))
            if (refused := self.beyond(target, drive.node)) is not None:
                return refused
            if target != drive.target or (drive.moving and self._has_news(drive, rpm)):
                acc = drive.ramp_to(target, self.settings.acceleration, shares[motor])
                self.send(drive.node, target, rpm, acc)
                self.last_said = f"F5 to {self.targets}"
        if last:
            trip.time_s = trip.sent_s = trip.track.end_s
        return None

    def _has_news(self, drive: MksDrive, rpm: int) -> bool:
        """Tell whether a drive is told its speed: a new one, or to show that it obeys still."""
        shows_s = drive.ordered_s + SHOWS_PERIODS * self.settings.segment_s
        return rpm * COUNTS_S_PER_RPM != drive.told or self.now_s >= shows_s

    def _order(self, trip: SteeredTrip, motor: int, lead: Lead) -> tuple[int, int] | None:
        """Return a drive's next target and speed; None where it goes on as it is."""
        drive, period_s = self.drives[motor], self.settings.segment_s
        if not lead.way:
            return self._to_rest(drive, lead) if drive.moving else None
        until_s = min(trip.time_s + period_s, lead.until_s)
        there = trip.track.at(motor, until_s)
        needed = lead.way * (there - drive.position) / max(until_s - trip.time_s, period_s / 2.0)
        here = trip.track.at(motor, trip.time_s)
        planned = abs(there - here) / max(until_s - trip.time_s, 1e-6) / COUNTS_S_PER_RPM
        most = _catch_up_rpm(planned)
        if planned < SLOW_RPM:
            target = round(there)
            ahead = lead.way * (target - drive.position) > 0.5
            rpm = whole_rpm(math.ceil(needed / COUNTS_S_PER_RPM), most)
            return (target, rpm) if ahead else None
        rpm = whole_rpm(round(needed / COUNTS_S_PER_RPM), most)
        room = min(
            lead.way * (lead.far - drive.position),
            rpm * COUNTS_S_PER_RPM * max(trip.ahead_s - period_s / 2.0, period_s),
        )
        return (round(drive.position + lead.way * room), rpm) if room > 0.5 else None

    def _to_rest(self, drive: MksDrive, lead: Lead) -> tuple[int, int] | None:
        """Have a drive end where its motor stands for now, unless it has been sent there."""
        rest = round(lead.far)
        if drive.target == rest:
            return None
        return rest, whole_rpm(round(drive.told / COUNTS_S_PER_RPM), SPEED_MAX_RPM)

    def _last_order(self, trip: SteeredTrip, motor: int) -> tuple[int, int] | None:
        """Return the end of the motion, and the speed that has the drive there in time."""
        drive, track = self.drives[motor], trip.track
        end = track.end[motor]
        if not drive.moving and drive.target == end:
            return None
        left_s = max(track.end_s - trip.time_s, 1e-3)
        planned = abs(end - track.at(motor, trip.time_s)) / left_s / COUNTS_S_PER_RPM
        most = _catch_up_rpm(planned)
        needed = abs(end - drive.position) / left_s / COUNTS_S_PER_RPM
        return end, min(max(math.ceil(needed), LAST_RPM), most)

    # -- looking ------------------------------------------------------------------------------

    def _poll_s(self, trip: SteeredTrip) -> float:
        return trip.polled_s + self.settings.poll_s

    def _poll(self, trip: SteeredTrip) -> None:
        """Ask every drive where it is, which also feeds its watchdog."""
        if self.now_s < self._poll_s(trip):
            return
        trip.look(self.now_s)
        for node in self.nodes:
            self.put(node, ReadEncoder())
        if any(drive.seen is not None for drive in self.drives):
            self.tell(Progress(self.registers()))

    def _weighed(
        self, trip: SteeredTrip, heard: Event
    ) -> Generator[float, Event | None, Reply | None]:
        """Take in what was heard; return what the motion has come to, where it has come to one."""
        quiet_s, held_up = self.answered_last_s, self.held_up
        owed = {drive.node: drive.gap.owed for drive in self.drives} if held_up else {}
        self.heed(heard)
        match heard:
            case _ if held_up and self.answered_last_s > quiet_s:
                return (yield from self.catch_up(trip, quiet_s, owed))
            case Answered(node, _, EncoderRead(counts)):
                return (yield from self._seen(node, counts)) or (yield from self.beside(trip))
            case LimitStop(node, _):
                words = f"{self.drive(node)} has run into a limit switch, which stopped it"
                alert = Alert(AlertKind.ALARM_LOST, words)
                return (yield from self.break_off(node, alert))
            case Failed(_, MoveAbsoluteAxis()):
                pass  # an older target's end, or a denial, which is looked into a moment later
            case StoredForStart(node, motion):
                self.put(node, ArmSynchronous(on=False))
                self.put_motion(node, motion)  # type: ignore[arg-type]
            case _:
                self.weigh_unasked(heard)
        return None

    def _seen(self, node: int, counts: int) -> Generator[float, Event | None, Reply | None]:
        """Compare a drive with its model; who is off its way, and goes on no more, ends it all."""
        drive, doubt = self.drive(node), self.drive(node).doubt
        off = drive.off_by(counts, self.now_s)
        if (drive.leap.leapt or math.isfinite(drive.gap.doubted_s)) and self.began_anew(node):
            return (yield from self.break_off(node))
        if drive.leap.suspected:  # nothing is made of this look before there is another one
            self.put(node, ReadEncoder())
            return None
        astray = off > self.settings.corridor_counts
        if astray and doubt.is_too_soon(drive.questions.asked_s):
            return None
        let_pass = abs(drive.position - counts) - off + self.settings.corridor_counts
        if astray and not doubt.is_well(counts, drive.position, let_pass, self.reach):
            return (yield from self.break_off(node))
        if drive.moving:
            drive.believe(counts, GAIN)
        if astray:
            doubt.note(counts, drive.position, self.now_s)
        else:
            doubt.forget()
        return None

    def _denied(self) -> Generator[float, Event | None, Reply | None]:
        """End a motion in which a drive takes its orders no more."""
        denied = None if self.held_up else (yield from self.say_again())
        return None if denied is None else (yield from self.break_off(*denied))

    def _unheard(self) -> Generator[float, Event | None, Reply | None]:
        """End a motion in which a drive has been asked again and again, and was not heard."""
        unanswered = [drive.unanswered for drive in self.drives]
        most = MUTE_LOOKS if min(unanswered) <= 1 else ALL_MUTE_LOOKS
        if max(unanswered) <= most:
            return None
        return (yield from self.lose(self.now_s - most * self.settings.poll_s))


def _catch_up_rpm(planned: float) -> int:
    """Return the fastest speed that a drive is told where it lags, by the planned rpm."""
    return min(math.ceil(CATCH_UP * planned) + CATCH_UP_RPM, SPEED_MAX_RPM)
