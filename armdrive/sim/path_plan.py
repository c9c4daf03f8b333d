"""The speed along queued lines: planned backwards from the stand-still at the end, then forwards.

Every plan is a row of stretches of constant acceleration, exact in time. Units and seconds.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from armdrive.sim.path_line import Line, PathLimits, corner_speed
from armdrive.sim.profile import Piece

Part: TypeAlias = tuple[float, float, float]
"""Speed, acceleration and duration of a part of a line."""


@dataclass(frozen=True, slots=True)
class Stretch:
    """A piece of the way along one line of the queue; `last` where the line ends with it."""

    number: int
    piece: Piece
    last: bool


def planned(
    lines: Sequence[Line],
    along: float,
    speed: float,
    now_s: float,
    limits: PathLimits,
    scale: tuple[float, float],
) -> list[Stretch]:
    """Plan from a length along the first line, at a speed, to the end of the last one."""
    entries = _entries(lines, limits, scale)
    stretches: list[Stretch] = []
    for number, one in enumerate(lines):
        first = along if number == 0 else 0.0
        far = one.length - first
        room = 2 * one.acceleration * far
        leave = min(entries[number + 1], math.sqrt(speed**2 + room))
        leave = max(leave, math.sqrt(max(speed**2 - room, 0.0)))
        shape = _shape(speed, one.nominal(scale), leave, one.acceleration, far)
        now_s = _lay(stretches, number, first, _floored(shape, one.least), now_s)
        speed = leave
    return stretches


def braked(lines: Sequence[Line], along: float, speed: float, now_s: float) -> list[Stretch]:
    """Slow down to a stand-still along the way, as soon as the lines' accelerations allow."""
    stretches: list[Stretch] = []
    for number, one in enumerate(lines):
        first = along if number == 0 else 0.0
        slope = one.acceleration
        square = speed**2 - 2 * slope * (one.length - first)
        leave = math.sqrt(max(square, 0.0))
        ramp = (speed, -slope, (speed - leave) / slope)
        shape = _floored([ramp], one.least)
        now_s = _lay(stretches, number, first, shape, now_s, last=square >= 0.0)
        if square <= 0.0:
            break
        speed = leave
    return stretches


def _entries(lines: Sequence[Line], limits: PathLimits, scale: tuple[float, float]) -> list[float]:
    """Return the greatest speeds at which the lines may begin, the end after the last at 0."""
    corners = [
        min(corner_speed(a, b, limits), a.nominal(scale), b.nominal(scale))
        for a, b in itertools.pairwise(lines)
    ]
    entries = [math.inf, *corners, 0.0]
    for number in range(len(lines) - 1, 0, -1):
        one = lines[number]
        room = 2 * one.acceleration * one.length
        entries[number] = min(entries[number], math.sqrt(entries[number + 1] ** 2 + room))
    return entries


def _shape(enter: float, nominal: float, leave: float, slope: float, far: float) -> Iterator[Part]:
    """Yield speed, acceleration and duration of each part: towards the nominal speed, on, out."""
    peak = math.sqrt(slope * far + (enter**2 + leave**2) / 2)
    middle = max(min(nominal, peak), leave)
    used = (abs(middle**2 - enter**2) + middle**2 - leave**2) / (2 * slope)
    if enter > middle and used > far:
        middle = leave  # too fast, and no room to do anything but slow down
        used = (enter**2 - leave**2) / (2 * slope)
    yield enter, math.copysign(slope, middle - enter), abs(middle - enter) / slope
    if middle:
        yield middle, 0.0, max(far - used, 0.0) / middle
    yield middle, -slope, (middle - leave) / slope


def _floored(shape: Iterable[Part], least: float) -> Iterator[Part]:
    """Yield the same ways, with no speed below the least: what is slower takes less time."""
    for speed, slope, duration_s in shape:
        end = speed + slope * duration_s
        below_s = duration_s if max(speed, end) <= least else 0.0
        if slope and min(speed, end) < least < max(speed, end):
            below_s = (least - min(speed, end)) / abs(slope)
        if not below_s or not least:
            yield speed, slope, duration_s
            continue
        slower = min(speed, end), min(max(speed, end), least)
        crawl = least, 0.0, below_s * sum(slower) / 2.0 / least
        rest = max(speed, least), slope, duration_s - below_s
        yield from (crawl, rest) if slope > 0.0 else (rest, crawl)


def _lay(
    stretches: list[Stretch],
    number: int,
    along: float,
    shape: Iterable[Part],
    now_s: float,
    *,
    last: bool = True,
) -> float:
    """Append the parts of a line that last any time; return when it ends."""
    pieces: list[Piece] = []
    for speed, slope, duration_s in shape:
        pieces.append(Piece(now_s, along, speed, slope, duration_s))
        now_s, along = pieces[-1].end_s, pieces[-1].at(pieces[-1].end_s)
    kept = [piece for piece in pieces if piece.duration_s > 0.0] or pieces[-1:]
    stretches += [
        Stretch(number, piece, last and index == len(kept) - 1) for index, piece in enumerate(kept)
    ]
    return now_s
