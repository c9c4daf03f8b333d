"""The position of each axis at any time while it speeds up, runs and slows down, without ticking.

Units: steps, seconds, steps per second. A profile is a list of pieces of constant acceleration;
after its last piece the axis stands, unless that piece never ends.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple, TypeAlias

_ROUNDING = 1e-9  # tolerance for floating-point rounding


class ProfilePiece(NamedTuple):
    """A stretch of constant acceleration, possibly endless.

    A tuple, because every target of a streamed motion makes some.
    """

    start_s: float
    position: float
    speed: float
    acceleration: float
    duration_s: float

    @property
    def end_s(self) -> float:
        """When the piece ends."""
        return self.start_s + self.duration_s

    def at(self, now_s: float) -> float:
        """Return the position at a time within the piece, or at its nearer end."""
        time = min(max(now_s - self.start_s, 0.0), self.duration_s)
        return self.position + time * (self.speed + self.acceleration * time / 2)

    def speed_at(self, now_s: float) -> float:
        """Return the speed at a time within the piece."""
        return self.speed + self.acceleration * (now_s - self.start_s)


class AxisProfile:
    """A sequence of pieces, and where the axis ends."""

    def __init__(self, pieces: Sequence[ProfilePiece], end: float) -> None:
        self.pieces = tuple(piece for piece in pieces if piece.duration_s > 0.0)
        self.end = end
        self.end_s = self.pieces[-1].end_s if self.pieces else -math.inf

    def at(self, now_s: float) -> float:
        """Return the position at a time."""
        piece = self.piece(now_s)
        return self.end if piece is None else piece.at(now_s)

    def speed_at(self, now_s: float) -> float:
        """Return the speed at a time; 0 after the end."""
        piece = self.piece(now_s)
        return 0.0 if piece is None else piece.speed_at(now_s)

    def piece(self, now_s: float) -> ProfilePiece | None:
        """Return the piece at a time; None after the end."""
        if now_s >= self.end_s:  # most axes stand most of the time
            return None
        for piece in self.pieces:
            if now_s < piece.end_s:
                return piece
        return None


def standing(position: float) -> AxisProfile:
    """Return the profile of an axis that does not move."""
    return AxisProfile((), position)


def to_speed(
    position: float, speed: float, wanted: float, acceleration: float, now_s: float
) -> AxisProfile:
    """Ramp from one speed to another and keep it for ever; stand if it is zero."""
    ramp_s = abs(wanted - speed) / acceleration
    slope = math.copysign(acceleration, wanted - speed)
    ramp = ProfilePiece(now_s, position, speed, slope, ramp_s)
    end = position + ramp_s * (speed + wanted) / 2
    if not wanted:
        return AxisProfile((ramp,), end)
    return AxisProfile((ramp, ProfilePiece(now_s + ramp_s, end, wanted, 0.0, math.inf)), end)


def to_goal(
    position: float,
    speed: float,
    goal: float,
    rate: float,
    acceleration: float,
    now_s: float,
    braking: float,
) -> AxisProfile:
    """Go to a goal and stand: a trapezoid, from any initial speed.

    An axis that moves away from the goal, or too fast to stop before it, first stops and then turns
    back. `braking` is the deceleration.
    """
    brake = speed * abs(speed) / (2 * braking)
    if (goal - position - brake) * speed < -_ROUNDING * abs(speed):
        stop = to_speed(position, speed, 0.0, braking, now_s)
        back = to_goal(stop.end, 0.0, goal, rate, acceleration, stop.end_s, braking)
        return AxisProfile((*stop.pieces, *back.pieces), goal)
    way = math.copysign(1.0, goal - position)
    far, first = abs(goal - position), abs(speed)
    pieces: list[ProfilePiece] = []
    for begins, slope, duration_s in trapezoid(first, rate, 0.0, far, acceleration, braking):
        piece = ProfilePiece(now_s, position, way * begins, way * slope, duration_s)
        pieces.append(piece)
        now_s, position = piece.end_s, piece.at(piece.end_s)
    return AxisProfile(pieces, goal)


# Speed, acceleration and duration of a part of a path.
Part: TypeAlias = tuple[float, float, float]


def trapezoid(
    enter: float, nominal: float, leave: float, far: float, gain: float, brake: float
) -> Iterator[Part]:
    """Yield the parts of a path of length `far`, from one speed to the nominal one and to another.

    `gain` and `brake` are the acceleration and the deceleration. If the entry speed is too high to
    brake within `far`, the path only brakes, and is longer.
    """
    both = 2 * gain * brake / (gain + brake)
    peak = math.sqrt(both * (far + enter**2 / (2 * gain) + leave**2 / (2 * brake)))
    middle = max(min(nominal, peak), leave)
    out = (middle**2 - leave**2) / (2 * brake)
    if enter > middle and (enter**2 - middle**2) / (2 * brake) + out > far:
        middle, out = leave, 0.0
    slope = gain if middle >= enter else -brake
    used = (middle**2 - enter**2) / (2 * slope) + out
    yield enter, slope, (middle - enter) / slope
    if middle:
        yield middle, 0.0, max(far - used, 0.0) / middle
    yield middle, -brake, (middle - leave) / brake


def nearest(position: float) -> int:
    """Round to the whole step at which a motor stands."""
    return math.floor(position + 0.5)
