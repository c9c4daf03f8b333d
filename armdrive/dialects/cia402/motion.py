"""Motion of CiA 402 drives: targets along a way, one burst after the other, or their own homing.

By cyclic position each drive gets a target with every SYNC. By profile position each gets one
set-point, to which it goes by a ramp of its own.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from armdrive.dialects.bus.group import Phase, Signal
from armdrive.dialects.bus.way import Way
from armdrive.dialects.cia402.exchange import (
    ENABLE,
    RESPONSE_S,
    Hindered,
    Script,
)
from armdrive.dialects.cia402.leading import REST_TURNS, SETTLE_S, MotionLead
from armdrive.dialects.cia402.settings import TOP_HZ, DriveLimits
from armdrive.dialects.cia402.wire import TARGET_MAX, Cia402Drive, beside
from armdrive.tasks import Alert, AlertKind, Done, Halted, MoveAlong, MoveBy, Reply
from firmware_protocol import canopen
from kinematics.spaces import Motors

LEAST_RATE = 0.1
"""A paused motion does not slow down further than to this share of its speed: it would never come
to the end of what was drawn."""


class CyclicTrip:
    """One motion under way: where its segments come from, and how far it is.

    It goes on by one period a turn at most, however late the turn is. Who lets go of it has it
    slow down on its way, in what `ease_s` says; who holds it back, towards the end of what was
    drawn, which is as little as can be. Where it is slowed down already by then, or has to wait
    before that end, it slows down to a stand on its way, and stays until it is held back no more:
    the end would come later than was announced.
    """

    def __init__(
        self, request: MoveAlong, way: Way, window_s: float, ease_s: Callable[[], float]
    ) -> None:
        self.way = way
        self.window_s = window_s
        """Over how long a target is averaged: it trails by half of that."""
        self.time_s = 0.0
        self.underruns = 0
        """How often there was nothing left to be driven although more was to come."""
        self.eased = False
        """Whether somebody has let go of it."""
        self._request = request
        self._segments: Iterator[MoveBy] = request.segments
        self._ease_s = ease_s
        self._rate, self._full_s = 1.0, 0.0
        self._exhausted = self._held = self._stays = False

    @property
    def over(self) -> bool:
        """Whether nothing is left to be sent."""
        if self.eased and self._rate <= 0.0:
            return True
        return self._driven and (self._exhausted or self._held or self.eased)

    @property
    def complete(self) -> bool:
        """Whether all of it has been sent, as far as it was not held back."""
        return self._driven and (self._exhausted or (self._held and not self.eased))

    @property
    def _driven(self) -> bool:
        return self.time_s >= self.way.end_s + self.window_s

    def go_on(self, period_s: float, *, wait: bool = False, stand: bool = False) -> tuple[int, ...]:
        """Let a period of it pass; return where the motors shall be then.

        A trip that has to `wait` for a drive slows down on its way, and goes on from there. One
        that has to `stand` goes no farther in this period, and at half its speed behind it: a drive
        that missed targets makes up for them meanwhile.
        """
        if self._rate >= 1.0:
            self._full_s = max(self._ease_s(), period_s)
        self.eased = self.eased or self._request.let_go()
        held, self._held = self._held, self._request.held_back()
        slowed = not held and self._rate < 1.0
        self._stays = self._held and (self._stays or wait or stand or slowed)
        if not self.eased:
            self._draw(period_s)
        self._rate = self._rate / 2.0 if stand else self._next_rate(period_s, wait)
        self.time_s += 0.0 if stand else self._rate * period_s
        self.way.pass_by(self.time_s, self.window_s)
        motors = range(len(self.way.end))
        return tuple(round(self.way.averaged(i, self.time_s, self.window_s)) for i in motors)

    def _next_rate(self, period_s: float, wait: bool) -> float:
        """Return how fast time passes on the way: slower before its end where it is held back."""
        change, left_s = period_s / self._full_s, self.way.end_s - self.time_s
        if self.eased or wait or self._stays:
            return max(self._rate - change, 0.0)
        if self._held and left_s > period_s:
            return max(min(self._rate, math.sqrt(2.0 * left_s / self._full_s)), LEAST_RATE)
        return min(self._rate + change, 1.0)

    def _draw(self, period_s: float) -> None:
        dry = self.time_s > self.way.end_s > 0.0
        while not (self._exhausted or self._held) and self._has_room(period_s):
            segment = next(self._segments, None)
            if segment is None:
                self._exhausted = True
                return
            self.way.draw(segment, self.time_s)
            self.underruns, dry = self.underruns + dry, False

    def _has_room(self, period_s: float) -> bool:
        return self.way.end_s - self.time_s <= period_s


HASTE = 0.75
"""After a late turn the next one follows after this share of a period at the earliest, so that the
drives can interpolate, and the period is caught up with in four turns."""
HELD_TURNS = 3
"""While a drive has told nothing for so many turns, all are slowed down, and stop in the end. Of
ten frames a bad bus loses one: it loses three in a row once in 1000 turns."""
LOST_TURNS = 5
"""A drive that has not been seen to turn for so many turns is sent no farther, though nothing was
heard of it. It is more than `HELD_TURNS`: a computer that holds everything back for 30 ms loses
nothing."""
PROGRESS_S = 0.05
"""How often positions are reported on the way: twenty times a second, as a screen shows them."""


@dataclass(slots=True, eq=False)
class CyclicMotion:
    """Drives segments by giving targets, one trip after the other."""

    MODE = canopen.OperationMode.CYCLIC_POSITION

    lead: MotionLead
    limits: DriveLimits
    underruns: int = 0
    """How often it was late, or had nothing to drive although more was to come."""
    hz: float = 0.0
    """How fast the busiest motor turns now."""
    shown_s: float = -math.inf
    began_s: float = -math.inf
    """When the latest trip began."""

    def drive(self, request: MoveAlong) -> Script[Reply]:
        """Give the drives targets along segments, until all is driven or something ends it."""
        yield from self.lead.prepare(self.MODE)
        way = Way(Motors(drive.shaft.goal for drive in self.lead.group.drives))
        window_s = self.lead.settings.smoothing_ms / 1000.0
        trip = CyclicTrip(request, way, window_s, self._ease_s)
        self.hz, self.shown_s, self.began_s = 0.0, self.lead.io.now_s, self.lead.io.now_s
        try:
            reply = yield from self.lead.carry_out(
                Phase.MOVING,
                lambda: self._give_targets(trip),
                lambda: self._judge(trip),
                self.MODE,
                REST_TURNS,
            )
        finally:
            self.underruns += trip.underruns
        return Halted() if isinstance(reply, Done) and not trip.complete else reply

    def _give_targets(self, trip: CyclicTrip) -> float:
        """Give every drive its next target; slow down while one of them is not heard."""
        lead, cycle_s = self.lead, self.limits.cycle_s
        drives, now_s = lead.group.drives, lead.io.now_s
        waits = any(drive.missed >= HELD_TURNS for drive in drives)
        self.underruns += waits + (now_s > lead.due_s + cycle_s)
        stands = any(self._misses_targets(drive) for drive in drives)
        targets = trip.go_on(cycle_s, wait=waits, stand=stands)
        if words := beyond_words(zip(drives, targets, strict=True)):
            lead.refused = f"{words}: home it near its zero"
            return now_s
        ways = zip(targets, drives, strict=True)
        self.hz = max(abs(target - drive.shaft.goal) for target, drive in ways) / cycle_s
        for drive, target in zip(drives, targets, strict=True):
            drive.shaft.order(target, self.limits.fastest_hz, math.inf, now_s)
            self.lead.exchange.command(drive, ENABLE, self.MODE, target)  # or one might run on
        self.lead.io.said = self.lead.group.targets
        return max(lead.due_s + cycle_s, now_s + HASTE * cycle_s)

    def _misses_targets(self, drive: Cia402Drive) -> bool:
        """Tell whether a drive seems to get no targets: it is short of them, and does not turn.

        It goes to the next one that it gets in a single leap: the less far it was sent, the shorter
        that is. One that stands for longer than it may take to settle is blocked, which is for the
        observer to find.
        """
        shaft, cycle_s = drive.shaft, self.limits.cycle_s
        if shaft.is_near or math.isinf(drive.still_s):
            return False
        since_s, now_s = max(drive.still_s, self.began_s), self.lead.io.now_s
        told = shaft.read_s - since_s > (HELD_TURNS - 0.5) * cycle_s
        lost = now_s - since_s > LOST_TURNS * cycle_s
        return (told or lost) and now_s - since_s < SETTLE_S

    def _judge(self, trip: CyclicTrip) -> Signal | None:
        """Return whether all targets have been given."""
        if self.lead.refused:
            return Signal.REFUSED
        if self.lead.io.now_s >= self.shown_s + PROGRESS_S:
            self.shown_s = self.lead.io.now_s
            self.lead.exchange.progress()
        return Signal.SENT if trip.over else None

    def _ease_s(self) -> float:
        """Return how long it takes to slow down from the present speed."""
        return self.lead.settings.ramp_s * min(self.hz / self.limits.fastest_hz, 1.0)


def beyond_words(targets: Iterable[tuple[Cia402Drive, int]]) -> str:
    """Say which target a drive cannot be given; empty where it can be given all."""
    for drive, target in targets:
        if abs(target) > TARGET_MAX:
            return f"{drive} would turn to {target} increments, beyond what can be commanded"
    return ""


@dataclass(slots=True, eq=False)
class SetPoint:
    """Where one drive is sent in a burst, how fast and by which ramp, and how far that has come."""

    goal: int
    speed: int
    slope: int
    host: canopen.SetPointHost = field(default_factory=canopen.SetPointHost)

    @property
    def writes(self) -> tuple[canopen.Write, ...]:
        """What a drive is told of it before."""
        unsigned = canopen.DataType.U32
        return (
            canopen.Write(canopen.PROFILE_SPEED, unsigned, self.speed),
            canopen.Write(canopen.PROFILE_ACCELERATION, unsigned, self.slope),
            canopen.Write(canopen.PROFILE_DECELERATION, unsigned, self.slope),
        )


@dataclass(slots=True, eq=False)
class ProfileMotion:
    """Drives one burst at a time, by one set-point for each drive, all begun by one SYNC.

    Every drive gets a speed and a ramp in proportion to its way, so that all keep in step and
    arrive together.
    """

    MODE = canopen.OperationMode.PROFILE_POSITION

    lead: MotionLead
    limits: DriveLimits
    points: Mapping[Cia402Drive, SetPoint] = field(default_factory=dict)
    under_way: Sequence[Cia402Drive] = ()
    given_up_s: float = math.inf

    def burst(self, steps: Motors, rate_hz: float, let_go: Callable[[], bool]) -> Script[Reply]:
        """Send a burst and wait for its end."""
        yield from self.lead.prepare(self.MODE)
        self.points = {
            drive: self._point(drive.shaft.goal + count, abs(count) / steps.largest, rate_hz)
            for drive, count in zip(self.lead.group.drives, steps, strict=True)
            if count
        }
        if not self.points:
            return Done()
        goals = [(drive, point.goal) for drive, point in self.points.items()]
        if words := beyond_words(goals):
            raise Hindered(words)
        ramps = {drive.node: point.writes for drive, point in self.points.items()}
        yield from self.lead.transfers.carry_out(ramps)
        if self.lead.io.stop_asked or let_go():
            return Halted()
        yield from self._hand_over()
        if self.lead.io.stop_asked:
            return Halted()
        for drive, point in self.points.items():
            drive.shaft.order(point.goal, point.speed, point.slope, self.lead.io.now_s)
        self.under_way = tuple(self.points)
        lasts_s = self.limits.lasts_s(steps.largest, rate_hz)
        self.given_up_s = self.lead.exchange.listened.s + 2.0 * lasts_s + SETTLE_S
        return (
            yield from self.lead.carry_out(Phase.MOVING, self._tell_goals, self._judge, self.MODE)
        )

    def _point(self, goal: int, share: float, rate_hz: float) -> SetPoint:
        speed, slope = share * min(rate_hz, TOP_HZ), share * self.limits.ramp_hz_s
        return SetPoint(goal, max(round(speed), 1), max(round(slope), 1))

    def _hand_over(self) -> Script[None]:
        """Wait until every drive has room for its set-point."""
        given_up_s = self.lead.exchange.listened.s + RESPONSE_S
        for point in self.points.values():
            point.host.begin()
        self._hear()
        while any(point.host.phase is not canopen.Phase.ASKING for point in self.points.values()):
            if self.lead.exchange.listened.s >= given_up_s:
                raise Hindered("drives have no room for a set-point: reset them")
            yield from self.lead.exchange.turn()
            self._hear()

    def _tell_goals(self) -> float:
        """Have the drives go to their set-points."""
        for drive in self.lead.group.drives:
            point = self.points.get(drive)
            word = ENABLE if point is None else point.host.controlword
            self.lead.exchange.command(drive, word, self.MODE, drive.shaft.goal)
        self.lead.io.said = self.lead.group.targets
        return self.lead.cycle_ends_s

    def _judge(self) -> Signal | None:
        """Return whether all say that they have reached their set-points."""
        reached = self._hear()
        self.under_way = [drive for drive in self.under_way if drive not in reached]
        self.lead.exchange.progress()
        if not self.under_way:
            return Signal.SENT
        if self.lead.exchange.listened.s <= self.given_up_s:
            return None
        for drive in self.under_way:
            if not drive.shaft.is_near:
                return self.lead.blame(beside(drive))
        words = f"{self.under_way[0]} does not say that it has reached its target"
        return self.lead.blame(Alert(AlertKind.ASTRAY, words))

    def _hear(self) -> set[Cia402Drive]:
        """Feed what drives said last; return those that say that they have arrived."""
        return {
            drive
            for drive, point in self.points.items()
            if drive.word is not None and drive.missed <= 1
            for event in point.host.hear(drive.word)
            if isinstance(event, canopen.Reached)
        }


# The drives' own homing, in the arm file's groups: each searches for its switch.
#
# The drive itself counts from its home offset where it has found that. Nothing here sets a zero.

GO = canopen.Controlword.of(canopen.Command.ENABLE_OPERATION, canopen.ControlBit.NEW_SET_POINT)
BEYOND = 1.1
"""A search ends after this share of a motor's whole range: there is no switch on its way."""
SHOWN_TURNS = 10
"""A drive that was homed before may show "home found" for so many turns of the next homing; after
that it counts as found again. Simulated drives clear it in two turns."""
PROGRESS_TURNS = 5
"""How often positions are reported while drives home: as `PROGRESS_S` at 100 turns a second."""


@dataclass(slots=True, eq=False)
class Cia402Homing:
    """Has drives home themselves, one group after the other.

    `left` are the drives that search yet, and whether each has shown to be at home ever since.
    """

    MODE = canopen.OperationMode.HOMING

    lead: MotionLead
    limits: DriveLimits
    left: dict[Cia402Drive, bool] = field(default_factory=dict)
    start: dict[Cia402Drive, int] = field(default_factory=dict)
    turns: int = 0
    given_up_s: float = math.inf

    def home(self, groups: tuple[tuple[int, ...], ...]) -> Script[Reply]:
        """Home group after group; all drives, one after the other, where none is named."""
        yield from self.lead.prepare(self.lead.group.resting_mode)
        drives = self.lead.group.drives
        for group in groups or tuple((motor,) for motor in range(len(drives))):
            reply = yield from self._home_group([drives[motor] for motor in group])
            if not isinstance(reply, Done):
                return reply
        return Done()

    def _home_group(self, group: Sequence[Cia402Drive]) -> Script[Reply]:
        yield from self.lead.transfers.carry_out({drive.node: self._jobs(drive) for drive in group})
        yield from self.lead.states.take_mode(group, self.MODE)
        self.lead.io.said = "HOME"
        self.start = {drive: drive.seen for drive in group}
        self.left = {drive: drive.word is None or _at_home(drive) for drive in group}
        self.turns, self.given_up_s = 0, self.lead.exchange.listened.s + self.lead.settings.homing_s
        reply = yield from self.lead.carry_out(Phase.HOMING, self._search, self._judge, None)
        if isinstance(reply, Done):
            for drive in group:
                drive.rest()
            yield from self.lead.states.take_mode(group, self.lead.group.resting_mode)
        return reply

    def _jobs(self, drive: Cia402Drive) -> tuple[canopen.Write, ...]:
        """Return what tells a drive how to search, as far as the arm file says so."""
        methods, jobs = self.lead.settings.homing_methods, []
        if methods:
            method = methods[self.lead.group.drives.index(drive)]
            jobs.append(canopen.Write(canopen.HOMING_METHOD, canopen.DataType.I8, method))
        places = (canopen.HOMING_SPEED, canopen.HOMING_CREEP)
        for place, speed in zip(places, self.lead.settings.homing_speeds, strict=True):
            if speed:
                jobs.append(canopen.Write(place, canopen.DataType.U32, speed))
        return tuple(jobs)

    def _search(self) -> float:
        """Have the drives of the group search; the others are in their resting mode."""
        for drive in self.start:
            self.lead.exchange.command(drive, GO, self.MODE, drive.seen)
        self.turns += 1
        return self.lead.cycle_ends_s

    def _judge(self) -> Signal | None:
        """Return whether all are home."""
        lead = self.lead
        if self.turns % PROGRESS_TURNS == 0:
            self.lead.exchange.progress()
        lead.refused = self._looked_at()
        if not lead.refused and self.lead.exchange.listened.s > self.given_up_s:
            lead.refused = f"{next(iter(self.left))} found no switch"
        if lead.refused:
            return Signal.TROUBLE
        return None if self.left else Signal.THERE

    def _looked_at(self) -> str:
        """Forget drives that are home, and say what went wrong.

        One that showed to be at home before it began has to show that it is not, first.
        """
        for drive, shown in tuple(self.left.items()):
            if drive.missed > 1 or drive.word is None:
                continue
            if drive.word.has(canopen.StatusBit.FOLLOWING_ERROR):
                return f"{drive} did not find its switch or stop"
            if not _at_home(drive):
                self.left[drive] = False
                whole = self.limits.ranges[self.lead.group.drives.index(drive)]
                if abs(drive.seen - self.start[drive]) > BEYOND * whole + 1:
                    return f"{drive} found no switch within its joints' limits"
            elif self.turns > 1 and (not shown or self.turns > SHOWN_TURNS):
                del self.left[drive]
        return ""


def _at_home(drive: Cia402Drive) -> bool:
    word = drive.word
    return (
        word is not None
        and word.has(canopen.StatusBit.ACKNOWLEDGED)
        and word.has(canopen.StatusBit.REACHED)
    )
