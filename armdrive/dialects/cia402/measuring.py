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

from armdrive.dialects.cia402.drives import Cia402Drive
from armdrive.dialects.cia402.exchange import Cia402Exchange
from armdrive.dialects.cia402.motion import BurstPart, drive_parts, prepare
from armdrive.dialects.cia402.transfers import Script
from armdrive.dialects.exchange import TRIES, Obstructed
from armdrive.tasks import Done, MeasuredUnits, Reply, RequestRejected
from firmware_protocol.canopen import OperationMode

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
# A position that comes this long after its SYNC was late.
PROMPT_S = 0.03
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

    away: Callable[[int, int], BurstPart]
    """The turn to a goal with a number of the unit."""
    back: Callable[[int, int], BurstPart]
    shares: tuple[float, float]
    value: Callable[[Sequence[Reading]], float]
    unreached: str
    untimed: str


def _acceleration(readings: Sequence[Reading]) -> float:
    """Return the ramp of a motor that left its start at rest, whenever that was.

    s = a / 2 * t^2, so the root of the distance grows evenly.
    """
    return 2.0 * _slope((s, math.sqrt(at)) for s, at in readings) ** 2


def measure_units(io: Cia402Exchange, drive: Cia402Drive, steps: int) -> Script[Reply]:
    """Measure the units of a drive, whose motor turns by at most `steps` and back.

    The other drives hold meanwhile.
    """
    yield from prepare(io, OperationMode.PROFILE_POSITION)
    speed = yield from _unit(io, drive, _speed(drive), steps)
    ramp = yield from _unit(io, drive, _ramp(drive, speed), steps)
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


def _speed(drive: Cia402Drive) -> Quantity:
    return Quantity(
        lambda goal, number: BurstPart(goal, number, STEEP_RAMP),
        lambda start, number: BurstPart(start, number, STEEP_RAMP),
        CRUISE,
        _slope,
        f"{drive} does not turn whatever speed it gets: look at its supply, its current and "
        "its brake",
        f"{drive} turns too fast to be timed with the number 1 in object 6081: write "
        "cia402.speed_units as its manual says",
    )


def _ramp(drive: Cia402Drive, speed_hz: float) -> Quantity:
    """Return the ramp of a drive with this unit of speed."""
    fast, slow = (max(round(hz / speed_hz), 1) for hz in (FAST_HZ, SLOWEST_HZ))
    failed = (
        f"{drive} does not gain speed as a ramp of increments/s² does: if its manual states "
        "ramps (6083, 6085) as times, it cannot be driven; else write cia402.ramp_units as it "
        "says"
    )
    return Quantity(
        lambda goal, number: BurstPart(goal, fast, number),
        lambda start, _number: BurstPart(start, slow, STEEP_RAMP),
        RISE,
        _acceleration,
        failed,
        failed,
    )


def _unit(io: Cia402Exchange, drive: Cia402Drive, quantity: Quantity, steps: int) -> Script[float]:
    """Return a unit, by turns with greater and greater numbers of it."""
    start, number, distance = drive.count, 1, min(FIRST_INCREMENTS, steps)
    while True:
        away, back = quantity.away(start + distance, number), quantity.back(start, number)
        readings = yield from _prompt_turn(io, drive, away, back)
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
        away_s = TRY_S * max(distance / FIRST_INCREMENTS, 1.0)
        readings, prompt = yield from _turn(io, drive, away, away_s)
        yield from _turn(io, drive, home, TRY_S + 2.0 * distance / SLOWEST_HZ)
        if prompt:
            return readings
    raise Obstructed(
        RequestRejected(
            f"the answers of {drive} come too late to time its motor, or get lost: close other "
            "programs on this computer, and check the bus (`armdrive doctor --can`)"
        )
    )


def _turn(
    io: Cia402Exchange, drive: Cia402Drive, part: BurstPart, for_s: float
) -> Script[tuple[list[Reading], bool]]:
    """Turn a motor to a goal, for at most a time; return where it was, and whether none was late.

    Raises `Obstructed` if something stops it.
    """
    start, ends_s, readings, prompt = drive.count, io.listened.s + for_s, [(0.0, 0)], True

    def watch() -> Done | None:
        nonlocal prompt
        synced_s = io.now_s - io.synced_s
        prompt = prompt and drive.missed <= 1 and synced_s <= io.limits.cycle_s + PROMPT_S
        if drive.missed == 0:
            readings.append((io.synced_s, drive.count - start))
        return Done() if io.listened.s > ends_s else None

    reply = yield from drive_parts(io, {drive: part}, watch=watch, mode=None)
    if not isinstance(reply, Done):
        raise Obstructed(reply)
    return readings[1:], prompt
