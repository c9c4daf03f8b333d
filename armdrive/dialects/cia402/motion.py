"""Motions of all drives, cycle by cycle: cyclic targets along a path, bursts by profile position.

One rule covers whatever happens in a motion that should not: all drives stop, hold where they
stand, and the reply says which drive was in trouble, and what to do.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

from armdrive.dialects.bus.drives import midway, unstopped_words
from armdrive.dialects.bus.paths import PlannedPath, SegmentFeed
from armdrive.dialects.cia402.drives import HOLDING, TARGET_MAX, Cia402Drive, Trouble
from armdrive.dialects.cia402.exchange import LOST_CYCLES, Cia402Exchange
from armdrive.dialects.cia402.settings import TOP_HZ
from armdrive.dialects.cia402.states import ENABLE, hold, stands_for_s, stop
from armdrive.dialects.cia402.transfers import Script
from armdrive.dialects.controller import FRESH_POSITION_S, MOTORS_OFF
from armdrive.dialects.exchange import Obstructed
from armdrive.tasks import (
    Alert,
    Done,
    Halted,
    MoveAlong,
    Reply,
    RequestRejected,
    Timeout,
    never,
)
from firmware_protocol import canopen
from firmware_protocol.canopen import OperationMode, SetPointPhase
from kinematics.spaces import Motors

CYCLIC, PROFILE = OperationMode.CYCLIC_POSITION, OperationMode.PROFILE_POSITION

# A drive that stands off its target for this long is blocked. A position loop needs less to settle.
SETTLE_S = 0.6
# A motion has arrived when this many positions in a row were at the targets: every one of them
# follows a repetition of the last target, so that no lost frame passes for an arrival.
REST_CYCLES = 5
# How often positions are reported: twenty times a second, as a screen shows them.
PROGRESS_S = 0.05


class Blamed(NamedTuple):
    """A drive, what is wrong with it, and the alert about that."""

    trouble: Trouble
    drive: Cia402Drive
    alert: Alert


def blame(trouble: Trouble, drive: Cia402Drive) -> Blamed:
    """Blame a drive, with where it is now."""
    return Blamed(trouble, drive, trouble.alert(drive))


# How a motion ended: as it should, stopped, with a drive in trouble, or with missing drives.
Outcome: TypeAlias = Done | Halted | Blamed | RequestRejected | Timeout


def prepare(io: Cia402Exchange, mode: OperationMode) -> Script[None]:
    """Prepare a motion in a mode. Raises `Obstructed` if it cannot begin."""
    if not io.on:
        raise Obstructed(MOTORS_OFF)
    if any(drive.read_s < io.now_s - FRESH_POSITION_S for drive in io.drives):
        yield from io.look()
    for drive in io.drives:
        if (trouble := drive.trouble(on=True, moving=False)) is not None:
            io.report_troubles()
            raise Obstructed(trouble.alert(drive).text)
    yield from hold(io, mode)


def lead(
    io: Cia402Exchange,
    mode: OperationMode | None,
    send: Callable[[], None],
    ended: Callable[[], Outcome | None],
    released: Callable[[], bool] = never,
) -> Script[Reply]:
    """Lead all drives through a motion: `send` the commands of each cycle, until it has `ended`.

    `mode` is the mode of all drives; None if they are in several. A jog that is `released` while a
    drive stands off its target is stopped, or the drive would jump there when it comes free.
    """
    for drive in io.drives:
        drive.watch()
    outcome = yield from _cycles(io, mode, send, ended, released)
    if isinstance(outcome, Done):
        io.progress()
        return outcome
    unstopped = yield from _stand(io)
    restarted = [drive for drive in io.drives if drive.booted]
    if restarted and isinstance(outcome, Timeout | RequestRejected):  # that is why it was silent
        outcome = blame(Trouble.RESTARTED, restarted[0])
    if not isinstance(outcome, Blamed):
        return _joined(outcome, unstopped)
    trouble, drive, alert = outcome
    if trouble in (Trouble.IN_FAULT, Trouble.STOPPED):  # its error explains that
        yield from io.explain(drive)
        alert = trouble.alert(drive)
    io.alarm(alert, drive)
    return _joined(RequestRejected(alert.text), unstopped)


def _joined(reply: Reply, unstopped: Timeout | RequestRejected | None) -> Reply:
    """Return why a motion ended, and why not all drives stand; if all are silent, only that."""
    if not isinstance(reply, RequestRejected) or not isinstance(unstopped, RequestRejected):
        return unstopped or reply
    reasons = dict.fromkeys((reply.reason, unstopped.reason))
    return RequestRejected(". And ".join(reasons), silent=reply.silent or unstopped.silent)


def _cycles(
    io: Cia402Exchange,
    mode: OperationMode | None,
    send: Callable[[], None],
    ended: Callable[[], Outcome | None],
    released: Callable[[], bool],
) -> Script[Outcome]:
    shown_s = io.now_s
    while not io.stop_asked:
        if io.may_have_stopped:
            if released():
                break
            if (missing := (yield from io.check_states())) is not None:
                return midway(missing)
        else:
            send()
            yield from io.cycle()
        if io.stop_asked:
            break
        for drive in io.drives:
            if (trouble := drive.trouble(on=True, moving=True)) is not None:
                return blame(trouble, drive)
            if mode is not None and drive.mode != mode:
                return blame(Trouble.OTHER_MODE, drive)
            if mode is not None and drive.stuck_s >= SETTLE_S:
                return blame(Trouble.OFF_TARGET, drive)
        if released() and any(stands_short(io, drive) for drive in io.drives):
            break
        if (outcome := ended()) is not None:
            return outcome
        if io.now_s >= shown_s + PROGRESS_S:
            shown_s = io.now_s
            io.progress()
    return Halted()


def stands_short(io: Cia402Exchange, drive: Cia402Drive) -> bool:
    """Return whether a drive stands off its target, or may do so because it is not heard."""
    return drive.missed > LOST_CYCLES or drive.stuck_s >= stands_for_s(io)


def _stand(io: Cia402Exchange) -> Script[Timeout | RequestRejected | None]:
    """Stop all drives and hold those that stand; return which ones may not, or do not answer."""
    left = yield from stop(io)
    standing = [
        drive
        for drive in io.drives
        # one that sends no reports would show no state on the way out of its quick stop
        if drive not in left and drive.state in HOLDING and drive.missed <= LOST_CYCLES
    ]
    unstopped: Timeout | RequestRejected | None = None
    try:
        if standing:
            yield from hold(io, io.resting_mode, standing)
    except Obstructed as obstructed:
        unstopped = RequestRejected(str(obstructed))
    for drive in io.drives:
        drive.order(drive.count)
    io.progress()
    mute = [drive for drive in left if drive.missed > LOST_CYCLES]
    if mute:
        return midway(io.absence(mute))
    if left:
        return RequestRejected(unstopped_words(left[0]))
    return unstopped


# Cyclic targets.


class CyclicTrip:
    """One motion under way: the source of its segments, and its progress along the path.

    Each cycle advances it by one period at most, however late the cycle is. It slows down to a
    stand on its path when a jog is released or the arm is paused, and goes on after a pause.
    """

    def __init__(self, request: MoveAlong, start: Motors, window_s: float) -> None:
        self._path = PlannedPath(start)
        self._feed = SegmentFeed(self._path, request.segments)
        self._request, self._window_s = request, window_s
        self._time_s, self._rate, self._slope = 0.0, 1.0, 1.0
        self._released = False

    @property
    def underruns(self) -> int:
        """How often the path ended although more was to come."""
        return self._feed.underruns

    @property
    def complete(self) -> bool:
        """Whether all of the path has been sent."""
        return self._feed.exhausted and self._time_s >= self._path.end_s + self._window_s

    @property
    def over(self) -> bool:
        """Whether all targets have been sent."""
        return self.complete or (self._released and self._rate <= 0.0)

    def advance(self, period_s: float, ease_s: float, *, wait: bool) -> tuple[int, ...]:
        """Advance by a period; return the targets of the motors.

        Slowing down from the present speed takes `ease_s`. A trip that has to `wait` stands, and
        goes on from there: meanwhile a drive that missed targets catches up.
        """
        self._released = self._released or self._request.released()
        slows = self._released or self._request.held_back()
        if self._rate >= 1.0:  # once it slows down, its speed no longer shows how long that takes
            self._slope = 1.0 / max(ease_s, period_s)
        if wait:
            self._rate = 0.0
        elif slows:
            self._rate = max(self._rate - self._slope * period_s, 0.0)
        else:
            self._rate = min(self._rate + self._slope * period_s, 1.0)
        if not wait:
            self._fetch(period_s)
            self._time_s += self._rate * period_s
        self._path.discard_before(self._time_s, self._window_s)
        return tuple(map(round, self._path.averaged(self._time_s, self._window_s)))

    def _fetch(self, period_s: float) -> None:
        """Draw segments at the last moment, and none for a jog that was released."""
        if self._released or self._rate <= 0.0:
            return
        dry = self._time_s > self._path.end_s > 0.0
        self._feed.fetch(lambda: self._path.end_s - self._time_s <= period_s, self._time_s, dry=dry)


def stream(io: Cia402Exchange, request: MoveAlong) -> Script[Reply]:
    """Send targets along segments in each cycle, until the end or until something stops it."""
    yield from prepare(io, CYCLIC)
    cycle_s, start = io.limits.cycle_s, Motors(drive.goal for drive in io.drives)
    trip = CyclicTrip(request, start, io.settings.smoothing_ms / 1000.0)
    rate_hz, beyond, outages = 0.0, "", io.outages

    def send() -> None:
        nonlocal rate_hz, beyond, outages
        # the sooner the targets stop, the shorter is a drive's jump to the next one
        wait = any(stands_short(io, drive) for drive in io.drives) or io.outages != outages
        outages = io.outages
        io.underruns += wait or io.is_late
        targets = trip.advance(cycle_s, io.limits.ramp_s(rate_hz), wait=wait)
        goals = dict(zip(io.drives, targets, strict=True))
        if beyond := beyond_words(goals):
            return
        rate_hz = max(abs(goal - drive.goal) for drive, goal in goals.items()) / cycle_s
        for drive, goal in goals.items():
            drive.order(goal)
            io.command(drive, ENABLE, CYCLIC, goal)
        io.last_command = "TARGETS"

    def ended() -> Outcome | None:
        if beyond:
            return RequestRejected(f"{beyond}: home it near its zero")
        if trip.over and all(drive.near >= REST_CYCLES for drive in io.drives):
            return Done()
        return None

    try:
        reply = yield from lead(io, CYCLIC, send, ended, request.released)
    finally:  # also if the request is abandoned
        io.underruns += trip.underruns
    return Halted() if isinstance(reply, Done) and not trip.complete else reply


def beyond_words(goals: Mapping[Cia402Drive, int]) -> str:
    """Return which target is out of range; empty if none is."""
    for drive, goal in goals.items():
        if abs(goal) > TARGET_MAX:
            return f"{drive} would turn to {goal} increments, beyond what can be commanded"
    return ""


# Bursts by profile position.


@dataclass(frozen=True, slots=True)
class BurstPart:
    """One drive's part in a burst: its target, and its speed and ramp in the drive's unit."""

    goal: int
    speed: int
    slope: int

    @property
    def writes(self) -> tuple[canopen.Write, ...]:
        """The objects that the drive needs before its target.

        By their EDS files, Technosoft's iPOS has no 6084 and brakes as it accelerates, and
        Trinamic's TMCM-1617 has a constant: that one comes last, and may be refused.
        """
        places = (
            (canopen.PROFILE_SPEED, self.speed),
            (canopen.PROFILE_ACCELERATION, self.slope),
            (canopen.PROFILE_DECELERATION, self.slope),
        )
        return tuple(canopen.Write(place, canopen.DataType.U32, value) for place, value in places)


def burst(
    io: Cia402Exchange, steps: Motors, rate_hz: float, released: Callable[[], bool]
) -> Script[Reply]:
    """Send a burst and wait for its end: one target for each drive, all started by one SYNC.

    Each drive's speed and ramp are in proportion to its distance, so that all stay in step and
    arrive together.
    """
    yield from prepare(io, PROFILE)
    parts = {}
    for drive, count in zip(io.drives, steps, strict=True):
        if count:
            share = abs(count) / steps.largest
            speed = drive.speed(share * min(rate_hz, TOP_HZ))
            slope = drive.ramp(share * io.limits.ramp_hz_s)
            parts[drive] = BurstPart(drive.goal + count, speed, slope)
    if words := beyond_words({drive: part.goal for drive, part in parts.items()}):
        raise Obstructed(words)
    if not parts:
        return Done()
    longest_s = 2.0 * io.limits.lasts_s(steps.largest, rate_hz) + SETTLE_S
    return (yield from drive_parts(io, parts, longest_s, released))


def drive_parts(
    io: Cia402Exchange,
    parts: Mapping[Cia402Drive, BurstPart],
    longest_s: float = math.inf,
    released: Callable[[], bool] = never,
    watch: Callable[[], Outcome | None] = lambda: None,
    mode: OperationMode | None = PROFILE,
) -> Script[Reply]:
    """Drive some motors to their goals by profile position, unless `watch` ends that sooner."""
    for result in (yield from io.obtain({drive: part.writes for drive, part in parts.items()})):
        for place, words in result.refused.items():
            if place != canopen.PROFILE_DECELERATION or not result.lacks(place):
                raise Obstructed(words)
    if released():
        return Halted()
    for drive, part in parts.items():
        drive.offer(part.goal)
    ends_s = io.listened.s + longest_s

    def send() -> None:
        begun = any(drive.handshake.taken for drive in parts)
        ready = all(drive.handshake.phase is not SetPointPhase.WAITING for drive in parts)
        for drive in io.drives:
            word = drive.handshake.controlword if ready or begun else ENABLE
            io.command(drive, word, PROFILE, drive.goal)
        io.last_command = "TARGETS"

    def ended() -> Outcome | None:
        left = [drive for drive in parts if drive.near < REST_CYCLES or not drive.handshake.taken]
        if not left:
            return Done()
        return blame(Trouble.OFF_TARGET, left[0]) if io.listened.s > ends_s else watch()

    return (yield from lead(io, mode, send, ended, released))
