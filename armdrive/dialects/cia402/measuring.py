"""Measure in which units a CiA 402 drive counts speeds and ramps, by slow turns of its motor.

CiA 402 leaves both to the maker, and only newer drives tell theirs (60A9). Increments/s is common
(Novanta's drives, object 606B; ABB's FEPL-02 manual), Roboteq has rpm, and ramps in tenths of
rpm/s (CANBus Networking Manual, 0x6081 and 0x6083), and Technosoft's iPOS 65536ths of increments in
a period of its loop (roboticslab-uc3m/yarp-devices, TechnosoftIpos). Taken for increments/s, a
speed in rpm would be hundreds of times too fast.

A speed is written as a number of units. Each measurement begins with the number 1, which grows
fourfold until the motor turns fast enough to be timed: whatever the unit is, no motor turns fast.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from armdrive.dialects.bus.observer import PROMPT_REPLY_S
from armdrive.dialects.bus.phases import Phase, Signal
from armdrive.dialects.cia402.drives import Cia402Drive
from armdrive.dialects.cia402.exchange import Cia402Exchange, Script
from armdrive.dialects.cia402.leading import CycleStage, MotionRun, prepare
from armdrive.dialects.cia402.motion import BurstPart, write_parts
from armdrive.dialects.exchange import TRIES, Obstructed
from armdrive.tasks import Done, MeasuredUnits, Reply, RequestRejected
from firmware_protocol import canopen

GROWTH = 4
"""The next number is this many times as great, if the motor turned too slowly."""
LARGEST_NUMBER = GROWTH**10
"""With this number even an iPOS turns at 16,000 increments/s."""
TRY_INCREMENTS = 64
"""The distance of a first try: eight times as far as a drive may rest off its target."""
TURNED_INCREMENTS = 16
"""A motor that has come this far has turned; a shorter distance may be its trembling."""
TRY_S = 0.6
"""How long a try may take."""
SLOW_HZ = 150.0
"""About how fast a motor turns while its speed is timed: a turn a minute at 10,000 increments."""
TIMED_S = 1.0
"""About how long the turn takes whose speed is measured."""
STEEP_RAMP = 100_000
"""The number of the ramps while a speed is measured: a slow motor reaches it at once."""
RAMP_INCREMENTS = 240
"""The distance on which a ramp is timed."""
FAST_HZ = 20_000.0
"""A speed that no ramp that can be timed reaches on that distance."""
CRUISE, RISE = (0.2, 0.8), (0.06, 0.45)
"""The shares of a distance on which a motor keeps its speed, and on which it gains speed."""
LEAST_READINGS = 4
"""A slope needs at least this many readings: with two, a late one would count as a speed."""
REST_S = 0.05
"""A motor at its goal that has not turned for this long stands: the next turn begins from rest."""
NEAR = 0.05
"""A measured unit this close to a usual one is taken for that."""
DECIMALS = (1.0, 0.1, 0.01, 0.001)


@dataclass(frozen=True, slots=True)
class Track:
    """Where a motor was in one turn: times in seconds, and increments from its start.

    If a reading was `late`, it is of some moment long before it came, so the turn tells no speed.
    """

    readings: tuple[tuple[float, int], ...]
    late: bool

    @property
    def distance(self) -> int:
        """How far it came."""
        return self.readings[-1][1] if self.readings else 0

    def within(self, shares: tuple[float, float], distance: int) -> tuple[tuple[float, int], ...]:
        """Return the readings between two shares of a distance; none if they are too few."""
        low, high = (share * distance for share in shares)
        found = tuple(each for each in self.readings if low <= each[1] <= high)
        return found if len(found) >= LEAST_READINGS else ()

    @property
    def rough_hz(self) -> float:
        """About how fast it turned, or slower than that if it arrived between two readings."""
        moved = [each for each in self.readings if each[1] > 0]
        rest_s = max((s for s, at in self.readings if at <= 0), default=moved[0][0])
        end_s, end = next(each for each in moved if each[1] >= self.distance)
        return end / max(end_s - rest_s, 1e-3)


def slope(points: Iterable[tuple[float, float]]) -> float:
    """Return the slope of the line through points, by least squares."""
    xs, ys = zip(*points, strict=True)
    x0, y0 = math.fsum(xs) / len(xs), math.fsum(ys) / len(ys)
    over = math.fsum((x - x0) * (y - y0) for x, y in zip(xs, ys, strict=True))
    return over / math.fsum((x - x0) ** 2 for x in xs)


def named_unit(hz: float, turn: float) -> tuple[float, str]:
    """Return the usual unit of speed that a measured one is, with its name; else itself.

    `turn` are the increments of a turn of the motor, 0 if they are unknown.
    """
    for one, name in ((1.0, "increments/s"), (turn / 60.0, "rpm"), (turn, "turns/s")):
        for decimal in DECIMALS:
            if one and abs(hz / (one * decimal) - 1.0) <= NEAR:
                return float(f"{one * decimal:.7g}"), f"{decimal:g} {name}"
    return float(f"{hz:.3g}"), f"{hz:.3g} increments/s"


def _failed(words: str) -> Obstructed:
    """Return that a measurement failed, after the motor may have turned."""
    return Obstructed(RequestRejected(words))


class UnitMeasurement:
    """Times slow turns of one motor; the other drives hold meanwhile."""

    def __init__(self, io: Cia402Exchange) -> None:
        self._io = io

    def measure(self, drive: Cia402Drive, steps: int) -> Script[Reply]:
        """Measure the units of a drive, whose motor turns by at most `steps` and back."""
        yield from prepare(self._io, self._io.group.resting_mode)
        yield from self._io.states.take_mode((drive,), canopen.OperationMode.PROFILE_POSITION)
        start = drive.shaft.count
        try:
            speed, ramp = yield from self._timed(drive, start, steps)
        except Obstructed:
            yield from self._hold(drive)
            raise
        yield from self._hold(drive)
        (speed_hz, named), (ramp_hz, ramp_named) = (
            named_unit(each, drive.turn) for each in (speed, ramp)
        )
        reported_hz = drive.reported_unit_hz
        return MeasuredUnits(
            speed_hz,
            ramp_hz,
            bool(reported_hz)
            and all(abs(each / reported_hz - 1.0) <= NEAR for each in (speed, ramp)),
            f"one unit of speed is {named}, one of ramps {ramp_named} a second "
            f"(measured: {speed:.4g} increments/s and {ramp:.4g} increments/s²)",
        )

    def _hold(self, drive: Cia402Drive) -> Script[None]:
        """Make a drive hold where it is, like the others."""
        drive.rest()
        yield from self._io.states.take_mode((drive,), self._io.group.resting_mode)
        yield from self._io.states.hold_here((drive,))

    def _timed(self, drive: Cia402Drive, start: int, steps: int) -> Script[tuple[float, float]]:
        """Return the unit of speed in increments/s, and that of ramps in increments/s²."""
        speed_hz = yield from self._speed_hz(drive, start, steps)
        back = BurstPart(start, max(round(SLOW_HZ / speed_hz), 1), STEEP_RAMP)
        yield from self._turn(drive, back, self._patience_s(steps))
        fast = max(round(FAST_HZ / speed_hz), 1)
        ramp_hz_s = yield from self._ramp_hz_s(drive, back, steps, fast)
        yield from self._turn(drive, back, self._patience_s(steps))
        return speed_hz, ramp_hz_s

    def _speed_hz(self, drive: Cia402Drive, start: int, steps: int) -> Script[float]:
        """Measure the speed of the number 1: roughly by short tries, then by one longer turn."""
        number, goal = 1, start + min(TRY_INCREMENTS, steps)
        while True:
            tried = yield from self._turn(drive, BurstPart(goal, number, STEEP_RAMP), TRY_S)
            if tried.distance >= min(TURNED_INCREMENTS, steps):
                break
            if number >= LARGEST_NUMBER:
                raise _failed(
                    f"{drive} does not turn whatever speed it gets: look at its supply, its "
                    "current and its brake"
                )
            number *= GROWTH
        rough_hz = tried.rough_hz / number
        yield from self._turn(
            drive,
            BurstPart(start, number, STEEP_RAMP),
            self._patience_s(TRY_INCREMENTS, tried.rough_hz),
        )
        number = max(round(SLOW_HZ / rough_hz), 1)
        distance = min(max(round(number * rough_hz * TIMED_S), TRY_INCREMENTS), steps)
        away, back = (BurstPart(goal, number, STEEP_RAMP) for goal in (start + distance, start))
        patience_s = self._patience_s(distance, number * rough_hz)
        track = yield from self._prompt_turn(drive, away, back, patience_s)
        if not (cruise := track.within(CRUISE, distance)):
            raise _failed(
                f"{drive} turns too fast to be timed with the number 1 in object 6081: write "
                "cia402.speed_units as its manual says"
            )
        return slope(cruise) / number

    def _ramp_hz_s(
        self, drive: Cia402Drive, back: BurstPart, steps: int, fast: int
    ) -> Script[float]:
        """Measure the ramp at which the motor leaves its start; `back` leads there again.

        `fast` is the number of a speed that it does not reach.
        """
        number, distance = 1, min(RAMP_INCREMENTS, steps)
        while True:
            away = BurstPart(back.goal + distance, fast, number)
            track = yield from self._prompt_turn(drive, away, back, TRY_S)
            # on a part of the distance, a few rounded counts would tell the ramp only roughly
            slow = track.distance < RISE[1] * distance and number < LARGEST_NUMBER
            rise = track.within(RISE, distance)
            # s = a / 2 * t^2, whenever it began: the root of the distance grows evenly
            if rise and not slow:
                root = slope((s, math.sqrt(at)) for s, at in rise)
                return 2.0 * root**2 / number
            yield from self._turn(drive, back, self._patience_s(distance))
            if slow:
                number *= GROWTH
            elif distance < steps:
                distance = steps
            else:
                raise _failed(
                    f"{drive} does not gain speed as a ramp of increments/s² does: if its manual "
                    "states ramps (6083, 6085) as times, it cannot be driven; else write "
                    "cia402.ramp_units as it says"
                )

    @staticmethod
    def _patience_s(distance: int, rate_hz: float = SLOW_HZ) -> float:
        """Return how long a turn at about this speed may take."""
        return TRY_S + 2.0 * distance / rate_hz

    def _prompt_turn(
        self, drive: Cia402Drive, away: BurstPart, back: BurstPart, for_s: float
    ) -> Script[Track]:
        """Turn a motor away; if readings were late, back and away again. Its last turn was prompt.

        A speed that was timed on a busy computer would be wrong, and the arm too fast for ever.
        """
        for _ in range(TRIES):
            track = yield from self._turn(drive, away, for_s)
            if not track.late:
                return track
            yield from self._turn(drive, back, self._patience_s(abs(away.goal - back.goal)))
        raise _failed(
            f"the answers of {drive} come too late to time its motor, or get lost: close other "
            "programs on this computer, and check the bus (`armdrive doctor --can`)"
        )

    def _turn(self, drive: Cia402Drive, part: BurstPart, for_s: float) -> Script[Track]:
        """Turn a motor to a goal, for at most a time; return where it was.

        Raises `Obstructed` if something stops it.
        """
        io = self._io
        yield from write_parts(io, {drive: part})
        yield from io.states.offer({drive: part.goal})
        run = MotionRun(io, None)
        turn = Turn(run, drive, for_s)
        reply = yield from run.carry_out(Phase.HOMING, turn)
        if not isinstance(reply, Done):
            raise Obstructed(reply)
        return Track(tuple(turn.readings), turn.late)


class Turn(CycleStage):
    """The stage of one turn of a motor: reads where it is in each cycle."""

    def __init__(self, run: MotionRun, drive: Cia402Drive, for_s: float) -> None:
        super().__init__(run)
        self._drive, self._begin, self._goal = drive, drive.shaft.count, drive.set_point
        self._until_s = run.io.listened.s + for_s
        self.readings: list[tuple[float, int]] = []
        """Times, and increments from its start."""
        self.late = False
        """Whether a reading was of some moment long before it came."""

    def send(self) -> float:
        """Send the drive its set-point."""
        self.io.send_point(self._drive)
        return self.run.cycle_ends_s

    def judge(self) -> Signal | None:
        """Return whether the motor stands at its goal, or its time is over."""
        drive, shaft = self._drive, self._drive.shaft
        direction = 1 if self._goal >= self._begin else -1
        sampled_s = shaft.asked_s  # at the SYNC
        if not self.readings or sampled_s > self.readings[-1][0]:
            self.readings.append((sampled_s, direction * (drive.shaft.count - self._begin)))
            self.late |= shaft.read_s > sampled_s + PROMPT_REPLY_S
        near = abs(drive.shaft.count - self._goal) <= shaft.bounds.tremble
        # it may never have left its goal; but it takes its next set-point only after this one
        taken = drive.handshake.taken
        there = near and taken and drive.stands(self.run.began_s, REST_S)
        return Signal.ARRIVED if there or self.io.listened.s > self._until_s else None
