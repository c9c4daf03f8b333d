"""Measure in which units a CiA 402 drive counts speeds and ramps, by slow turns of its motor.

CiA 402 leaves both to the maker, and only newer drives tell theirs (60A9). Increments/s is common
(Novanta's drives, object 606B; ABB's FEPL-02 manual), Roboteq has rpm, and ramps in tenths of
rpm/s (CANBus Networking Manual, 0x6081 and 0x6083), and Technosoft's iPOS 65536ths of increments in
a period of its loop (roboticslab-uc3m/yarp-devices, TechnosoftIpos). Taken for increments/s, a
speed in rpm would be hundreds of times too fast.

Both are written as numbers of units, and measured alike: the motor turns away and back, first with
the number 1, which grows fourfold until a turn is fast enough to be timed. So whatever the unit is,
no motor turns fast.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from statistics import linear_regression
from typing import TypeAlias

from armdrive.dialects.bus.observer import PROMPT_REPLY_S
from armdrive.dialects.bus.phases import Phase, Signal
from armdrive.dialects.cia402.drives import Cia402Drive
from armdrive.dialects.cia402.exchange import Cia402Exchange, Script
from armdrive.dialects.cia402.leading import CycleStage, MotionRun, prepare
from armdrive.dialects.cia402.motion import BurstPart, write_parts
from armdrive.dialects.exchange import TRIES, Obstructed
from armdrive.tasks import Done, MeasuredUnits, Reply, RequestRejected
from firmware_protocol import canopen

# The next number is this many times as great, if the motor turned too slowly.
GROWTH = 4
# With this number even an iPOS turns at 16,000 increments/s.
LARGEST_NUMBER = GROWTH**10
# The distance of the first turns, thirty times as far as a drive may rest off its target, and how
# long each may take.
FIRST_INCREMENTS, TRY_S = 240, 0.6
# The number of the ramps while a speed is measured: a slow motor reaches it at once.
STEEP_RAMP = 100_000
# A speed that no ramp that can be timed reaches on that distance.
FAST_HZ = 20_000.0
# The shares of a distance on which a motor keeps its speed, and on which it gains speed.
CRUISE, RISE = (0.2, 0.8), (0.06, 0.45)
# No slower motor counts as timed.
SLOWEST_HZ = CRUISE[1] * FIRST_INCREMENTS / TRY_S
# A slope needs at least this many readings: with two, a late one would count as a speed.
LEAST_READINGS = 4
# A motor at its goal that has not turned for this long stands: the next turn begins from rest.
REST_S = 0.05
# A measured unit this close to a usual one is taken for that.
NEAR = 0.05
DECIMALS = (1.0, 0.1, 0.01, 0.001)

# A time in seconds, and increments from the start of a turn.
Reading: TypeAlias = tuple[float, int]


def _slope(points: Iterable[tuple[float, float]]) -> float:
    """Return the slope of the line through points, by least squares."""
    return linear_regression(*zip(*points, strict=True)).slope


def named_unit(hz: float, turn: float) -> tuple[float, str]:
    """Return the usual unit of speed that a measured one is, with its name; else itself.

    `turn` are the increments of a turn of the motor, 0 if they are unknown.
    """
    for one, name in ((1.0, "increments/s"), (turn / 60.0, "rpm"), (turn, "turns/s")):
        for decimal in DECIMALS:
            if one and abs(hz / (one * decimal) - 1.0) <= NEAR:
                return float(f"{one * decimal:.7g}"), f"{decimal:g} {name}"
    return float(f"{hz:.3g}"), f"{hz:.3g} increments/s"


@dataclass(frozen=True, slots=True)
class Quantity:
    """A speed or a ramp: how a turn with a number of its units is ordered, and told from readings.

    Only the readings on these `shares` of the distance count. `unreached` says what is wrong if no
    number makes the motor turn fast enough, `untimed` if it is too fast even with the number 1.
    """

    part: Callable[[int, int], BurstPart]
    """Takes the goal and the number."""
    shares: tuple[float, float]
    value: Callable[[Sequence[Reading]], float]
    unreached: str
    untimed: str


def _ramp(readings: Sequence[Reading]) -> float:
    """Return the ramp of a motor that left its start at rest, whenever that was.

    s = a / 2 * t^2, so the root of the distance grows evenly.
    """
    return 2.0 * _slope((s, math.sqrt(at)) for s, at in readings) ** 2


def measure_units(io: Cia402Exchange, drive: Cia402Drive, steps: int) -> Script[Reply]:
    """Measure the units of a drive, whose motor turns by at most `steps` and back.

    The other drives hold meanwhile.
    """
    yield from prepare(io, io.group.resting_mode)
    yield from io.states.take_mode((drive,), canopen.OperationMode.PROFILE_POSITION)
    try:
        speed = yield from _speed_hz(io, drive, steps)
        ramp = yield from _ramp_hz_s(io, drive, steps, speed)
    except Obstructed:
        yield from _hold(io, drive)
        raise
    yield from _hold(io, drive)
    (speed_hz, named), (ramp_hz, ramp_named) = (
        named_unit(each, drive.turn) for each in (speed, ramp)
    )
    reported_hz = drive.reported_unit_hz
    return MeasuredUnits(
        speed_hz,
        ramp_hz,
        bool(reported_hz) and all(abs(each / reported_hz - 1.0) <= NEAR for each in (speed, ramp)),
        f"one unit of speed is {named}, one of ramps {ramp_named} a second "
        f"(measured: {speed:.4g} increments/s and {ramp:.4g} increments/s²)",
    )


def _hold(io: Cia402Exchange, drive: Cia402Drive) -> Script[None]:
    """Make a drive hold where it is, like the others."""
    drive.rest()
    yield from io.states.take_mode((drive,), io.group.resting_mode)
    yield from io.states.hold_here((drive,))


def _speed_hz(io: Cia402Exchange, drive: Cia402Drive, steps: int) -> Script[float]:
    """Return the unit of speed in increments/s."""
    speed = Quantity(
        lambda goal, number: BurstPart(goal, number, STEEP_RAMP),
        CRUISE,
        _slope,
        f"{drive} does not turn whatever speed it gets: look at its supply, its current and "
        "its brake",
        f"{drive} turns too fast to be timed with the number 1 in object 6081: write "
        "cia402.speed_units as its manual says",
    )
    return (yield from _unit(io, drive, speed, steps))


def _ramp_hz_s(
    io: Cia402Exchange, drive: Cia402Drive, steps: int, speed_hz: float
) -> Script[float]:
    """Return the unit of ramps in increments/s², for a drive with this unit of speed."""
    fast, slow = (max(round(hz / speed_hz), 1) for hz in (FAST_HZ, SLOWEST_HZ))
    failed = (
        f"{drive} does not gain speed as a ramp of increments/s² does: if its manual states "
        "ramps (6083, 6085) as times, it cannot be driven; else write cia402.ramp_units as it "
        "says"
    )
    ramp = Quantity(lambda goal, number: BurstPart(goal, fast, number), RISE, _ramp, failed, failed)
    return (yield from _unit(io, drive, ramp, steps, slow))


def _unit(
    io: Cia402Exchange, drive: Cia402Drive, quantity: Quantity, steps: int, back: int = 0
) -> Script[float]:
    """Return a unit, by turns with greater and greater numbers of it.

    The motor turns back with the number `back` as its speed, by default with that of the way.
    """
    start, number, distance = drive.shaft.count, 1, min(FIRST_INCREMENTS, steps)
    while True:
        away = quantity.part(start + distance, number)
        home = BurstPart(start, back or number, STEEP_RAMP)
        readings = yield from _prompt_turn(io, drive, away, home)
        low, high = (share * distance for share in quantity.shares)
        timed = [each for each in readings if low <= each[1] <= high]
        if readings[-1][1] < high:  # its time was over before
            number *= GROWTH
            if number > LARGEST_NUMBER:
                raise Obstructed(RequestRejected(quantity.unreached))
        elif len(timed) >= LEAST_READINGS:
            return quantity.value(timed) / number
        elif distance < steps:
            distance = steps
        else:
            raise Obstructed(RequestRejected(quantity.untimed))


def _prompt_turn(
    io: Cia402Exchange, drive: Cia402Drive, away: BurstPart, home: BurstPart
) -> Script[list[Reading]]:
    """Turn a motor away and back; return where it was on the way, if no reading was late.

    A speed that was timed on a busy computer would be wrong, and the arm too fast for ever.
    """
    distance = away.goal - home.goal
    for _ in range(TRIES):
        turn = yield from _turn(io, drive, away, TRY_S * max(distance / FIRST_INCREMENTS, 1.0))
        yield from _turn(io, drive, home, TRY_S + 2.0 * distance / SLOWEST_HZ)
        if not turn.late:
            return turn.readings
    raise Obstructed(
        RequestRejected(
            f"the answers of {drive} come too late to time its motor, or get lost: close other "
            "programs on this computer, and check the bus (`armdrive doctor --can`)"
        )
    )


def _turn(io: Cia402Exchange, drive: Cia402Drive, part: BurstPart, for_s: float) -> Script[Turn]:
    """Turn a motor to a goal, for at most a time.

    Raises `Obstructed` if something stops it.
    """
    yield from write_parts(io, {drive: part})
    yield from io.states.offer({drive: part.goal})
    run = MotionRun(io, None)
    turn = Turn(run, drive, for_s)
    reply = yield from run.carry_out(Phase.HOMING, turn)
    if not isinstance(reply, Done):
        raise Obstructed(reply)
    return turn


class Turn(CycleStage):
    """The stage of one turn of a motor: reads where it is in each cycle."""

    def __init__(self, run: MotionRun, drive: Cia402Drive, for_s: float) -> None:
        super().__init__(run)
        self._drive, self._begin, self._goal = drive, drive.shaft.count, drive.set_point
        self._until_s = run.io.listened.s + for_s
        self.readings: list[Reading] = []
        self.late = False
        """Whether a reading was of some moment long before it came."""

    def send(self) -> float:
        """Send the drive its set-point."""
        self.io.send_point(self._drive)
        return self.run.cycle_ends_s

    def judge(self) -> Signal | None:
        """Return whether the motor stands at its goal, or its time is over."""
        drive, shaft = self._drive, self._drive.shaft
        sampled_s = shaft.asked_s  # at the SYNC
        if not self.readings or sampled_s > self.readings[-1][0]:
            self.readings.append((sampled_s, drive.shaft.count - self._begin))
            self.late |= shaft.read_s > sampled_s + PROMPT_REPLY_S
        near = abs(drive.shaft.count - self._goal) <= shaft.bounds.tremble
        # it may never have left its goal; but it takes its next set-point only after this one
        taken = drive.handshake.taken
        there = near and taken and drive.stands(self.run.began_s, REST_S)
        return Signal.ARRIVED if there or self.io.listened.s > self._until_s else None
