"""Move CiA 402 drives: cyclic targets along a path, or bursts by profile position.

In cyclic position mode each drive gets a target with every SYNC. In profile position mode each gets
one set-point and follows a ramp of its own.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

from armdrive.dialects.bus.paths import PlannedPath, SegmentFeed
from armdrive.dialects.bus.phases import Phase, Signal
from armdrive.dialects.cia402.drives import TARGET_MAX, Cia402Drive, off_target_alert
from armdrive.dialects.cia402.exchange import ENABLE, Cia402Exchange, Script
from armdrive.dialects.cia402.leading import (
    REST_CYCLES,
    SETTLE_S,
    CycleStage,
    MotionRun,
    prepare,
)
from armdrive.dialects.cia402.settings import TOP_HZ
from armdrive.dialects.exchange import Obstructed
from armdrive.tasks import Alert, AlertKind, Done, Halted, MoveAlong, Reply, RequestRejected
from firmware_protocol import canopen
from firmware_protocol.canopen import OperationMode
from kinematics.spaces import Motors

# A paused motion keeps at least this share of its speed, or it would never reach the end of its
# last segment.
MIN_RATE = 0.1


class CyclicTrip:
    """One motion under way: the source of its segments, and its progress.

    Each cycle advances it by one period at most, however late the cycle is. When a jog is released,
    it slows down to a stand on its path. When the arm is paused, it slows down towards the end of
    its last segment. If it has already slowed down by then, or has to stand, it stops on the path
    instead and stays there until the pause ends: the segment's end would come later than announced.
    """

    def __init__(self, request: MoveAlong, path: PlannedPath, window_s: float) -> None:
        self.path = path
        self.window_s = window_s
        """The averaging window of targets, which lag by half of it."""
        self.time_s = 0.0
        self._feed = SegmentFeed(path, request.segments)
        self.eased = False
        """Whether the jog was released."""
        self._request = request
        self.stays = False
        """Whether the arm is paused and stands on the path until the pause ends."""
        self.late_cycles = 0
        """How many cycles came late, or slowed down for a silent drive."""
        self._rate = 1.0
        """The present share of the path's planned speed."""
        self._full_s = 0.0
        """How long slowing down from all of that speed takes."""
        self._held = False
        """Whether the arm was paused at the last cycle."""

    @property
    def underruns(self) -> int:
        """How often a cycle was late, or the path ended although more was to come."""
        return self._feed.underruns + self.late_cycles

    @property
    def over(self) -> bool:
        """Whether all targets have been sent."""
        if self.eased and self._rate <= 0.0:
            return True
        return self._driven and (self._feed.exhausted or self._held or self.eased)

    @property
    def complete(self) -> bool:
        """Whether all of the path has been sent, except what a pause holds back."""
        return self._driven and (self._feed.exhausted or (self._held and not self.eased))

    @property
    def _driven(self) -> bool:
        return self.time_s >= self.path.end_s + self.window_s

    def advance(self, period_s: float, ease_s: float, *, stand: bool) -> tuple[int, ...]:
        """Advance by a period; return the targets of the motors.

        Slowing down from the present speed takes `ease_s`.

        A trip that has to `stand` does not advance in this period, and halves its speed after it:
        meanwhile a drive that missed targets catches up.
        """
        if self._rate >= 1.0:  # once it slows down, its speed tells no more how long that takes
            self._full_s = max(ease_s, period_s)
        self.eased = self.eased or self._request.released()
        held, self._held = self._held, self._request.held_back()
        slowed = not held and self._rate < 1.0
        self.stays = self._held and (self.stays or stand or slowed)
        if not (self.eased or self._held):
            dry = self.time_s > self.path.end_s > 0.0
            self._feed.fetch(lambda: self._has_room(period_s), self.time_s, dry=dry)
        self._rate = self._rate / 2.0 if stand else self._next_rate(period_s)
        self.time_s += 0.0 if stand else self._rate * period_s
        self.path.discard_before(self.time_s, self.window_s)
        return tuple(map(round, self.path.averaged(self.time_s, self.window_s)))

    def _next_rate(self, period_s: float) -> float:
        """Return the rate of path time; during a pause it falls towards the path's end."""
        change, left_s = period_s / self._full_s, self.path.end_s - self.time_s
        if self.eased or self.stays:
            return max(self._rate - change, 0.0)
        # v^2 / (2 * slope) = left: the speed from which it stands just at the end of the segment
        if self._held and left_s > period_s:
            return max(min(self._rate, math.sqrt(2.0 * left_s / self._full_s)), MIN_RATE)
        return min(self._rate + change, 1.0)

    def _has_room(self, period_s: float) -> bool:
        return self.path.end_s - self.time_s <= period_s


# After a late cycle the next one takes at least this share of a period, so that the drives can
# interpolate. The delay is caught up in four cycles.
MIN_CYCLE_SHARE = 0.75


def stream(io: Cia402Exchange, request: MoveAlong) -> Script[Reply]:
    """Send targets along segments in each cycle, until the end or until something stops it."""
    yield from prepare(io, OperationMode.CYCLIC_POSITION)
    path = PlannedPath(Motors(drive.shaft.goal for drive in io.drives))
    trip = CyclicTrip(request, path, io.settings.smoothing_ms / 1000.0)
    run = MotionRun(io, OperationMode.CYCLIC_POSITION, lambda: trip.eased or request.released())
    try:
        reply = yield from run.carry_out(Phase.MOVING, CyclicTargets(run, trip), REST_CYCLES)
    finally:  # also if the request is abandoned
        io.underruns += trip.underruns
    return Halted() if isinstance(reply, Done) and not trip.complete else reply


class CyclicTargets(CycleStage):
    """The moving stage: every drive gets a target in each cycle."""

    def __init__(self, run: MotionRun, trip: CyclicTrip) -> None:
        super().__init__(run)
        self._trip = trip
        self._hz = 0.0
        """The present speed of the busiest motor."""

    def send(self) -> float:
        """Send every drive its next target; stand while one of them misses its own."""
        io, run, cycle_s, now_s = self.io, self.run, self.io.cycle_s, self.io.now_s
        # the sooner the targets stop, the shorter a drive's jump to the next one
        stands = any(map(run.stands_short, io.drives))
        self._trip.late_cycles += stands or now_s > run.due_s + cycle_s
        targets = self._trip.advance(cycle_s, io.limits.ramp_s(self._hz), stand=stands)
        if words := beyond_words(zip(io.drives, targets, strict=True)):
            run.reason = RequestRejected(f"{words}: home it near its zero")
            return now_s
        steps = (
            abs(target - drive.shaft.goal) for target, drive in zip(targets, io.drives, strict=True)
        )
        self._hz = max(steps) / cycle_s
        for drive, target in zip(io.drives, targets, strict=True):
            drive.order(target, io.limits.fastest_hz, math.inf, now_s)
            # else a drive might run on
            io.command(drive, ENABLE, OperationMode.CYCLIC_POSITION, target)
        io.last_command = io.group.targets
        return max(run.due_s + cycle_s, now_s + MIN_CYCLE_SHARE * cycle_s)

    def judge(self) -> Signal | None:
        """Return whether all targets have been sent."""
        if self.run.reason is not None:
            return Signal.OUT_OF_RANGE
        return self._blocked() or (Signal.ALL_SENT if self._trip.over else None)

    def _blocked(self) -> Signal | None:
        """Return TROUBLE if a drive stands short of its target for longer than it may settle.

        Its shaft is blocked, and would spring to the target when it comes free. One that has turned
        meanwhile is not: on a slow bus, each reading is of the time before the last target. What
        counts is the time between two readings, which passes for a drive however late they come.
        """
        for drive in self.io.drives:
            since_s = max(drive.off_s, drive.shaft.still_s)
            if drive.shaft.asked_s > since_s + SETTLE_S:
                return self.run.blame(off_target_alert(drive))
        return None


def beyond_words(targets: Iterable[tuple[Cia402Drive, int]]) -> str:
    """Return which target is out of range; empty if none is."""
    for drive, target in targets:
        if abs(target) > TARGET_MAX:
            return f"{drive} would turn to {target} increments, beyond what can be commanded"
    return ""


@dataclass(frozen=True, slots=True)
class BurstPart:
    """One drive's part in a burst: its target, and its speed and ramp in the drive's unit."""

    goal: int
    speed: int
    slope: int

    @property
    def writes(self) -> tuple[canopen.Write, ...]:
        """The objects that the drive needs before its set-point."""
        unsigned = canopen.DataType.U32
        return (
            canopen.Write(canopen.PROFILE_SPEED, unsigned, self.speed),
            canopen.Write(canopen.PROFILE_ACCELERATION, unsigned, self.slope),
            canopen.Write(canopen.PROFILE_DECELERATION, unsigned, self.slope),
        )


def write_parts(io: Cia402Exchange, parts: Mapping[Cia402Drive, BurstPart]) -> Script[None]:
    """Write drives their speeds and ramps."""
    # by their EDS files, Technosoft's iPOS has no 6084 and brakes as it accelerates, and
    # Trinamic's TMCM-1617 has a constant
    jobs = {drive.node: part.writes for drive, part in parts.items()}
    yield from io.transfers.carry_out(jobs, optional=(canopen.PROFILE_DECELERATION,))


def burst(
    io: Cia402Exchange, steps: Motors, rate_hz: float, released: Callable[[], bool]
) -> Script[Reply]:
    """Send a burst and wait for its end: one set-point for each drive, all started by one SYNC.

    Each drive's speed and ramp are in proportion to its distance, so that all stay in step and
    arrive together.
    """
    yield from prepare(io, OperationMode.PROFILE_POSITION)
    parts = {}
    for drive, count in zip(io.drives, steps, strict=True):
        if count:
            share = abs(count) / steps.largest
            speed = drive.speed(share * min(rate_hz, TOP_HZ))
            slope = drive.ramp(share * io.limits.ramp_hz_s)
            parts[drive] = BurstPart(drive.shaft.goal + count, speed, slope)
    if not parts:
        return Done()
    goals = {drive: part.goal for drive, part in parts.items()}
    if words := beyond_words(goals.items()):
        raise Obstructed(words)
    yield from write_parts(io, parts)
    if io.stop_asked or released():
        return Halted()
    yield from io.states.offer(goals)
    if io.stop_asked:  # the last chance: the next SYNC starts them
        return Halted()
    for drive, part in parts.items():
        speed_hz, slope_hz_s = part.speed * drive.speed_unit_hz, part.slope * drive.ramp_unit_hz_s
        drive.order(part.goal, speed_hz, slope_hz_s, io.now_s)
    run = MotionRun(io, OperationMode.PROFILE_POSITION, released)
    lasts_s = io.limits.lasts_s(steps.largest, rate_hz)
    return (yield from run.carry_out(Phase.MOVING, Burst(run, list(parts), lasts_s)))


class Burst(CycleStage):
    """The moving stage: drives are on the way to their set-points, for about `lasts_s`."""

    def __init__(self, run: MotionRun, drives: Sequence[Cia402Drive], lasts_s: float) -> None:
        super().__init__(run)
        self._drives = drives
        self._given_up_s = self.io.listened.s + 2.0 * lasts_s + SETTLE_S

    def send(self) -> float:
        """Send the drives their set-points."""
        for drive in self.io.drives:
            if drive in self._drives:
                self.io.send_point(drive)
            else:
                goal = drive.shaft.goal
                self.io.command(drive, ENABLE, OperationMode.PROFILE_POSITION, goal)
        self.io.last_command = self.io.group.targets
        return self.run.cycle_ends_s

    def judge(self) -> Signal | None:
        """Return whether all drives report that they have reached their set-points."""
        under_way = [drive for drive in self._drives if not drive.handshake.over]
        if not under_way:
            return Signal.ALL_SENT
        if self.io.listened.s <= self._given_up_s:
            return None
        for drive in under_way:
            if not drive.shaft.is_near:
                return self.run.blame(off_target_alert(drive))
        words = f"{under_way[0]} does not report that it has reached its target"
        return self.run.blame(Alert(AlertKind.OFF_PATH, words))
