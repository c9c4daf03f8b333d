"""Move MKS drives: along segments, by new targets in motion, or in bursts.

Along segments (firmware from 1.0.5 on), every moving motor gets a new order in each period: the
speed that brings it, by the end of the period, to where the path is then, and a target as far ahead
as the motor turns in one direction. The target is too far to reach before the next order, but
within the announced time if no order follows. So drives do not brake between segments, and stop by
themselves if their host dies. Speeds are whole rpm; the rounding error is part of the next period's
distance, so it does not add up.

In a burst each drive gets one order, with a speed in proportion to its distance. Firmware from
1.0.8 on could store orders (4A) until one frame starts them all (4B). That gains 3 ms and was never
seen to work.

One rule ends a motion that goes wrong: all drives stop, each holds where it stands, and the one
with the trouble is asked why. While a drive owes replies, or was read where it should not be, no
drive gets a new target, so that all come to rest at one point of the path.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Sequence
from itertools import pairwise

from armdrive.dialects.bus.drives import midway, unstopped_words
from armdrive.dialects.bus.paths import PlannedPath, SegmentFeed
from armdrive.dialects.controller import FRESH_POSITION_S, MOTORS_OFF
from armdrive.dialects.exchange import Obstructed
from armdrive.dialects.mks.contact import Trouble, TroubleKind, ask_fitness, explain
from armdrive.dialects.mks.drive import LATE_REPLY_S, MksDrive
from armdrive.dialects.mks.exchange import MksExchange, MksScript, Script
from armdrive.dialects.mks.stops import (
    STOP_POLL_S,
    halt,
    pushing_words,
    ramp_to,
    relieve,
    shared_acc,
)
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
from firmware_protocol.mks import (
    COUNTS_S_PER_RPM,
    SPEED_MAX_RPM,
    TARGET_MAX,
    MoveAbsoluteAxis,
    slope_of,
)
from kinematics.paths.profiles import Profile, trapezoid
from kinematics.spaces import Motors

# A drive may still follow orders up to this old. Unless the computer is overloaded, orders and
# polls are at most this late.
MAX_DELAY_S = 0.1
# How much faster than planned a drive that is behind may turn: its joint may be planned at its
# limit, coupled motors may add twice as much, and 1 rpm is the rounding error of a slow drive.
CATCH_UP, CATCH_UP_RPM = 1.1, 1
# Below this speed, a drive's target is only the end of the period, where it stands.
SLOW_RPM = 3
# The drives of a joint may still be making up for what they were behind this long ago.
CATCH_UP_S = 0.3
# How long a drive that stands short of its target is waited for before it gets its order again: the
# order may have been lost.
SHORT_S = 0.1
# How much later than expected a motion may end.
PATIENCE_S = 1.0
# The last drive of a burst starts at most this much after the first.
START_S = 0.003

# How much of the past of a path is kept: no reading is older.
LONGEST_LOOK_S = 2.0

# Where a motor may be that obeys its orders late, from a moment on: lowest and highest count.
Expected = Callable[[int, float], tuple[float, float]]


class Trip:
    """One steered motion: its path, how far it is, and where its drives should have been."""

    def __init__(self, io: MksExchange, request: MoveAlong) -> None:
        self._io, self._request = io, request
        self._path = PlannedPath(Motors(drive.target for drive in io.drives))
        self._feed = SegmentFeed(self._path, request.segments)
        self._time_s = 0.0  # the path time at which the drives should be
        self._horizon_s = 0.0  # that to which their targets lead: without new ones they stand there
        self._at_s = self.due_s = io.now_s
        self._past = deque([(io.now_s, self._path.places(0.0))])
        self._next = self._path.places(0.0)
        self._over_s = math.inf  # since when the path is over
        self.complete = False
        """Whether the path is over and the drives should be at its end."""

    @property
    def underruns(self) -> int:
        """How often drives stood still although more of their motion was to come."""
        return self._feed.underruns

    def advance(self) -> None:
        """Advance to the present, and note where the path is."""
        now_s = self._io.now_s
        self._time_s = min(self._time_s + now_s - self._at_s, self._horizon_s)
        self._at_s = now_s
        self._past.append((now_s, self._path.places(self._time_s)))
        while self._past[0][0] < now_s - LONGEST_LOOK_S:
            self._past.popleft()

    def expected(self, motor: int, from_s: float) -> tuple[float, float]:
        """Return where a motor may have been since a moment: lowest and highest count."""
        counts = [self._next[motor]]
        for at_s, places in reversed(self._past):
            counts.append(places[motor])
            if at_s < from_s:
                break
        return min(counts), max(counts)

    def steer(self) -> RequestRejected | None:
        """Send the orders of the next period; return why a drive cannot take its own."""
        io, period_s = self._io, self._io.settings.segment_s
        self.due_s = io.now_s + period_s
        if any(drive.questions.owes or drive.doubts for drive in io.drives):
            return None
        held = self._request.held_back()
        if not held:
            self._fetch()
        end_s = self._path.end_s
        self._next = self._path.places(self._time_s + period_s)
        speeds = self._speeds(period_s)
        self._horizon_s = self._reachable_s(speeds)
        ends = (self._feed.exhausted or held) and self._horizon_s == end_s
        over = ends and self._time_s >= end_s - period_s
        self._over_s = min(self._over_s, io.now_s) if over else math.inf
        late = io.now_s > self._over_s + CATCH_UP_S
        self.complete = over and (late or all(each.place == each.target for each in io.drives))
        self._path.discard_before(self._time_s, CATCH_UP_S)
        fastest = max(speeds) or 1.0
        for motor, drive in enumerate(io.drives):
            target, rpm = self._next_order(motor, drive, ends=ends)
            if abs(target) > TARGET_MAX:
                return beyond(drive, target)
            if target != drive.target or (drive.order and drive.place != target):
                acc = ramp_to(drive, target, io.settings.acceleration, speeds[motor] / fastest)
                io.send(drive, MoveAbsoluteAxis(target, rpm, acc))
        return None

    def _fetch(self) -> None:
        """Fetch the segments that fit, each as late as possible."""
        most_s = self._request.ahead_s + 1e-6

        def has_room() -> bool:
            left_s = self._path.end_s - self._time_s
            return left_s <= 0.0 or left_s + self._feed.latest_s <= most_s

        self._feed.fetch(has_room, self._time_s, dry=self._time_s >= self._path.end_s > 0.0)

    def _speeds(self, period_s: float) -> list[float]:
        """Return the speed of each drive in the next period, or its present one if it brakes."""
        here = self._path.places(self._time_s)
        speeds = []
        for drive, start, end in zip(self._io.drives, here, self._next, strict=True):
            drive.reckon(self._io.now_s)
            speeds.append(max(abs(end - start) / period_s, abs(drive.speed)))
        return speeds

    def _reachable_s(self, speeds: Sequence[float]) -> float:
        """Return the path time that drives reach within the announced time if no order follows.

        While they accelerate, that is less far than the path leads in this time.
        """
        ahead_s, period_s = self._request.ahead_s, self._io.settings.segment_s
        until_s = min(self._path.end_s, self._time_s + ahead_s)
        busiest = speeds.index(max(speeds))
        here = self._path.places(self._time_s)[busiest]
        most = max(speeds[busiest], COUNTS_S_PER_RPM) * ahead_s
        while until_s > self._time_s + period_s:
            if abs(self._path.places(until_s)[busiest] - here) <= most:
                break
            until_s -= period_s / 2.0
        return until_s

    def _next_order(self, motor: int, drive: MksDrive, *, ends: bool) -> tuple[int, int]:
        """Return a drive's target, and the rpm that bring it to its place at the period's end."""
        period_s, there = self._io.settings.segment_s, self._next[motor]
        until_s = self._time_s + period_s
        usual = self._path.fastest(motor, self._time_s - CATCH_UP_S, until_s) / COUNTS_S_PER_RPM
        planned = self._path.fastest(motor, self._time_s, until_s) / COUNTS_S_PER_RPM
        target = self._run_end(motor)
        if not ends and planned < SLOW_RPM:
            target = there
        way = math.copysign(1.0, (target - there) or (there - drive.place))
        needed = way * (there - drive.place) / period_s  # negative if the drive is ahead
        rpm = min(max(round(needed / COUNTS_S_PER_RPM), 1), catch_up_rpm(usual))
        left, ahead_s = way * (target - drive.place), self._request.ahead_s
        if ends:
            rpm = max(rpm, SLOW_RPM, math.ceil(left / ahead_s / COUNTS_S_PER_RPM))
            return round(target), rpm
        # the others may be faster later, but not without an order
        reached = drive.place + way * min(left, rpm * COUNTS_S_PER_RPM * ahead_s)
        return round(reached), rpm

    def _run_end(self, motor: int) -> float:
        """Return how far the motor turns in one direction from the next period on."""
        end = first = self._next[motor]
        next_s = self._time_s + self._io.settings.segment_s
        for place in self._path.turns(motor, next_s, max(self._horizon_s, next_s)):
            if (place - end) * (end - first) < 0.0:
                break
            end = place
        return end


def prepare(io: MksExchange) -> MksScript[None]:
    """Prepare a motion. Raises `Obstructed` if it cannot begin."""
    if not io.on:
        raise Obstructed(MOTORS_OFF)
    for drive in io.drives:
        if drive.two_zeros:
            raise Obstructed(drive.two_zeros)
    if any(drive.read_s < io.now_s - FRESH_POSITION_S for drive in io.drives):
        yield from io.require_positions()
    for drive in io.drives:
        drive.stand(io.now_s)
        drive.begin()


def along(io: MksExchange, request: MoveAlong) -> Script:
    """Steer the drives along segments, until the end or until something stops them."""
    yield from prepare(io)
    trip = Trip(io, request)
    try:
        while True:
            trip.advance()
            patience_s = MAX_DELAY_S if request.held_back() else LATE_REPLY_S
            ended = yield from _interrupted(io, trip.expected, request.released, patience_s)
            if ended is not None:
                return ended
            if io.now_s >= trip.due_s and (refused := trip.steer()) is not None:
                halted = yield from _halted(io, trip.expected)
                return refused if isinstance(halted, Halted) else halted
            if trip.complete:
                return (yield from _arrive(io, trip.expected, 0.0, request.released))
            yield from io.hear(min(trip.due_s, _poll(io, io.settings.poll_s)))
    finally:
        io.underruns += trip.underruns


def burst(io: MksExchange, steps: Motors, rate_hz: float, released: Callable[[], bool]) -> Script:
    """Send a burst and wait for its end."""
    yield from prepare(io)
    starts = [drive.target for drive in io.drives]
    orders: dict[MksDrive, MoveAbsoluteAxis] = {}
    for drive, count, rpm in zip(io.drives, steps, speeds_rpm(steps, rate_hz), strict=True):
        if not count:
            continue
        if abs(target := drive.target + count) > TARGET_MAX:
            return beyond(drive, target)
        acc = shared_acc(io.settings.acceleration, abs(count) / steps.largest)
        orders[drive] = MoveAbsoluteAxis(target, rpm, acc)
    if io.stop_asked or released():
        return Halted()
    for drive, order in orders.items():
        io.send(drive, order)
    ends = [start + count for start, count in zip(starts, steps, strict=True)]

    def expected(motor: int, _from_s: float) -> tuple[float, float]:
        return min(starts[motor], ends[motor]), max(starts[motor], ends[motor])

    lasts_s = max(each.duration_s for each in trapezoids(io.settings.acceleration, steps, rate_hz))
    return (yield from _arrive(io, expected, lasts_s, never))


# -- the end of a motion --------------------------------------------------------------------------


def _poll(io: MksExchange, period_s: float) -> float:
    """Ask for positions, at once for one that was doubted; return when the next is due."""
    doubted = [drive for drive in io.drives if drive.doubts]
    before_s = max(drive.questions.asked_s for drive in io.drives)
    due_s = io.poll(io.drives, period_s)
    if doubted:
        due_s = min(due_s, io.poll(doubted, STOP_POLL_S))
    if max(drive.questions.asked_s for drive in io.drives) > before_s:
        io.notify(Progress(io.registers()))
    return due_s


def _arrive(
    io: MksExchange, expected: Expected, lasts_s: float, released: Callable[[], bool]
) -> Script:
    """Wait until all drives stand at their targets. "Done" may never come.

    A drive that stands short of its target has lost its order, which is repeated, or is
    blocked.
    """
    left = {drive: io.now_s for drive in io.drives if drive.moving}  # when it got its order
    end_s = io.listened.s + lasts_s + PATIENCE_S
    while left:
        if (ended := (yield from _interrupted(io, expected, released))) is not None:
            return ended
        for drive in tuple(left):
            sure = not (drive.questions.owes or drive.doubts)  # else it may have restarted
            short = sure and drive.stands(left[drive], SHORT_S) and not drive.is_near
            if sure and drive.is_near and drive.stands(-math.inf, STOP_POLL_S / 2.0):
                drive.stand(io.now_s)
                del left[drive]
            elif io.listened.s > end_s:
                trouble = Trouble(drive, TroubleKind.OFF_PATH, drive.target)
                return (yield from _failed(io, trouble))
            elif short and drive.order is not None:
                left[drive] = io.now_s
                io.send(drive, drive.order)
        if left:
            yield from io.hear(_poll(io, STOP_POLL_S))
    return Done()


def _interrupted(
    io: MksExchange,
    expected: Expected,
    released: Callable[[], bool],
    patience_s: float = LATE_REPLY_S,
) -> MksScript[Reply | None]:
    """End the motion if a stop was requested or something is wrong; return the reply."""
    if io.stop_asked or released():
        return (yield from _halted(io, expected))
    trouble = _trouble(io, expected, patience_s)
    return None if trouble is None else (yield from _failed(io, trouble))


def _trouble(io: MksExchange, expected: Expected, patience_s: float) -> Trouble | None:
    """Return what is wrong with a drive; None if nothing is known to be."""
    for motor, drive in enumerate(io.drives):
        if drive.at_limit:
            return Trouble(drive, TroubleKind.LIMIT)
        if drive.unfit:
            return Trouble(drive, TroubleKind.UNFIT)
        if io.now_s >= drive.rejected_s:
            drive.rejected_s = math.inf
            ask_fitness(io, drive)
        if drive.asked_s > -math.inf:
            late_s = MAX_DELAY_S + drive.questions.slow_s
            low, high = expected(motor, drive.asked_s - late_s)
            corridor = io.settings.following_error_counts
            if drive.judge(low - corridor, high + corridor):
                place = min(max(drive.count, low), high)
                return Trouble(drive, TroubleKind.OFF_PATH, round(place))
    silent = [drive for drive in io.drives if drive.questions.lost(io.listened.s, patience_s)]
    return Trouble(silent[0], TroubleKind.SILENT) if silent else None


def _halted(io: MksExchange, expected: Expected) -> Script:
    """Stop the drives; report one that comes to rest where its orders cannot have led it."""
    began_s = io.now_s
    moving = [drive for drive in io.drives if drive.moving]
    targets = {drive: drive.target for drive in io.drives}
    left = yield from halt(io, moving, hard=io.stop_hard)
    if left:
        return (yield from unheard(io, left, began_s))
    for motor, drive in enumerate(io.drives):
        low, high = expected(motor, began_s - MAX_DELAY_S)
        low, high = min(low, targets[drive]), max(high, targets[drive])
        place = min(max(drive.count, low), high)
        if abs(drive.count - place) > io.settings.following_error_counts:
            trouble = Trouble(drive, TroubleKind.OFF_PATH, round(place))
            io.notify((yield from explain(io, trouble)))
        drive.stand(io.now_s, stopped=drive in moving)
    for drive, off in (yield from relieve(io, moving)).items():
        io.notify(Alert(AlertKind.OFF_PATH, pushing_words(drive, off)))
    return Halted()


def _failed(io: MksExchange, trouble: Trouble) -> Script:
    """Stop the drives, have each hold where it stands, and find out what is wrong."""
    began_s = io.now_s
    moving = [drive for drive in io.drives if drive.moving]
    left = yield from halt(io, moving, hard=io.stop_hard)
    reply: Reply
    if left or trouble.kind is TroubleKind.SILENT:
        reply = yield from unheard(io, left, began_s, [trouble.drive])
    else:
        alert = yield from explain(io, trouble)
        io.notify(alert)
        reply = RequestRejected(alert.text)
    for drive in moving:
        drive.stand(io.now_s, stopped=True)
    yield from relieve(io, [drive for drive in moving if drive not in left])
    return reply


def unheard(
    io: MksExchange, turning: Sequence[MksDrive], since_s: float, lost: Sequence[MksDrive] = ()
) -> MksScript[Timeout | RequestRejected]:
    """Return the reply about drives that are silent or still turning, or that were `lost`."""
    silent = [drive for drive in io.drives if drive.questions.owes]
    if missing := (yield from io.look()):
        return midway(io.absence(missing, since_s))
    if turning and not silent:
        return RequestRejected(unstopped_words(turning[0]))
    named = silent or lost
    who = str(named[0]) if len(named) == 1 else "the drives"
    return RequestRejected(
        f"{who} did not answer for a while in motion: reset, or lost its power, or the bus "
        "lost frames. Check supply and plugs, and the bus's load and adapter",
        silent=True,
    )


def beyond(drive: MksDrive, target: int) -> RequestRejected:
    """Return that a drive cannot take a target."""
    return RequestRejected(
        f"{drive} would turn to {target} counts, beyond the 512 turns that can be commanded: bring "
        "it near its zero and switch its supply off and on, which makes that place the zero",
        moved=False,
    )


def catch_up_rpm(planned: float) -> int:
    """Return the greatest speed of a drive that lags, from its planned rpm."""
    return min(math.ceil(CATCH_UP * planned) + CATCH_UP_RPM, SPEED_MAX_RPM)


def catch_up_travel(time_s: float, rate_hz: float, corridor: float) -> tuple[float, float]:
    """Return how much of its planned motion a drive makes in a time, and the counts on top.

    A drive that lags turns faster, but makes up for no more than it may lag: whichever is less.
    """
    extra_hz = (CATCH_UP - 1.0) * rate_hz + CATCH_UP_RPM * COUNTS_S_PER_RPM
    faster = time_s, extra_hz * time_s
    made_up = time_s + MAX_DELAY_S, corridor
    return min(faster, made_up, key=lambda travel: travel[0] * rate_hz + travel[1])


# -- bursts ---------------------------------------------------------------------------------------


def speeds_rpm(steps: Motors, rate_hz: float) -> tuple[int, ...]:
    """Return whole speeds in proportion to the distances, the greatest at most `rate_hz`.

    They are rounded up, so that no drive takes longer than the busiest.
    """
    largest = max(steps.largest, 1)
    busiest = min(max(math.floor(rate_hz / COUNTS_S_PER_RPM + 1e-9), 1), SPEED_MAX_RPM)
    return tuple(max(1, math.ceil(busiest * abs(count) / largest - 1e-9)) for count in steps)


def trapezoids(acc: int, steps: Motors, rate_hz: float) -> list[Profile]:
    """Return how the drives turn in a burst."""
    largest = max(steps.largest, 1)
    return [
        trapezoid(
            abs(count), rpm * COUNTS_S_PER_RPM, slope_of(shared_acc(acc, abs(count) / largest))
        )
        for count, rpm in zip(steps, speeds_rpm(steps, rate_hz), strict=True)
    ]


def deviations_of(acc: int, steps: Motors, rate_hz: float) -> tuple[float, ...]:
    """Bound each drive's deviation from the straight path in a burst: rpm, ramps, starts.

    Each drive follows its own trapezoid, and the busiest one defines the straight path. The two
    are compared at the corners of both, since their difference bends one way in between.
    """
    largest = steps.largest
    if not largest:
        return (0.0,) * len(steps)
    each = trapezoids(acc, steps, rate_hz)
    busiest = next(one for one in each if one.distance == largest)
    return tuple(
        _deviation(one, busiest) + START_S * max(phase.speed for phase in one.phases) + 1.0
        if one.distance
        else 0.0
        for one in each
    )


def _deviation(one: Profile, other: Profile) -> float:
    """Return the greatest distance of a motion from its share of another one."""
    share = one.distance / other.distance
    times = sorted({0.0, *one.ends_s, *other.ends_s})
    looks = [*times, *((a + b) / 2.0 for a, b in pairwise(times))]
    return max(abs(one.at(time_s)[0] - share * other.at(time_s)[0]) for time_s in looks)
