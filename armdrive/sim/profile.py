"""Where one axis stands at any moment while it speeds up, runs and slows down, without ticking.

Steps, seconds, steps a second. A profile is a row of pieces of constant acceleration; beyond its
last piece the axis stands, unless that piece never ends.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

_ROUNDING = 1e-9


@dataclass(frozen=True, slots=True)
class Piece:
    """A stretch of constant acceleration, which may last for ever."""

    start_s: float
    position: float
    speed: float
    acceleration: float
    duration_s: float

    @property
    def end_s(self) -> float:
        """When it ends."""
        return self.start_s + self.duration_s

    def at(self, now_s: float) -> float:
        """Return the position at a moment within it, or at its nearer end."""
        time = min(max(now_s - self.start_s, 0.0), self.duration_s)
        return self.position + time * (self.speed + self.acceleration * time / 2)

    def speed_at(self, now_s: float) -> float:
        """Return the speed at a moment within it."""
        return self.speed + self.acceleration * (now_s - self.start_s)

    def crossings(self, made: int) -> Iterator[tuple[float, int]]:
        """Yield when each whole step is made, halfway to it, and in which direction.

        `made` is the step that the axis stands at when the piece begins.
        """
        turn_s = -self.speed / self.acceleration if self.acceleration else -1.0
        legs = [(0.0, self.duration_s)]
        if 0.0 < turn_s < self.duration_s:
            legs = [(0.0, turn_s), (turn_s, self.duration_s)]
        for first_s, last_s in legs:
            there = self._end_of(last_s)
            way = 1 if there > made else -1
            while (there - made) * way >= 0.5:
                yield self.start_s + self._time_of(made + way / 2, first_s, last_s), way
                made += way

    def _end_of(self, last_s: float) -> float:
        if not math.isinf(last_s):
            return self.at(self.start_s + last_s)
        return math.copysign(math.inf, self.speed) if self.speed else self.position

    def _time_of(self, position: float, first_s: float, last_s: float) -> float:
        """Solve for the moment of a position that is passed between two moments of one way."""
        away = position - self.position
        if not self.acceleration:
            return min(max(away / self.speed, first_s), last_s)
        root = math.sqrt(max(self.speed**2 + 2 * self.acceleration * away, 0.0))
        times = ((root - self.speed) / self.acceleration, (-root - self.speed) / self.acceleration)
        time = min(times, key=lambda one: max(first_s - one, one - last_s))
        return min(max(time, first_s), last_s)


class Profile:
    """Pieces one after the other, and where the axis ends."""

    def __init__(self, pieces: Sequence[Piece], end: float) -> None:
        self.pieces = tuple(piece for piece in pieces if piece.duration_s > 0.0)
        self.end = end
        self.end_s = self.pieces[-1].end_s if self.pieces else -math.inf

    def at(self, now_s: float) -> float:
        """Return the position at a moment."""
        piece = self._piece(now_s)
        return self.end if piece is None else piece.at(now_s)

    def speed_at(self, now_s: float) -> float:
        """Return the speed at a moment; what has ended stands."""
        piece = self._piece(now_s)
        return 0.0 if piece is None else piece.speed_at(now_s)

    def crossings(self) -> Iterator[tuple[float, int]]:
        """Yield when each whole step is made, and in which direction.

        However the ends of the pieces are rounded, the steps lead to the end.
        """
        made = nearest(self.pieces[0].position) if self.pieces else nearest(self.end)
        for piece in self.pieces:
            for at_s, way in piece.crossings(made):
                yield at_s, way
                made += way
        while made != nearest(self.end):
            way = 1 if self.end > made else -1
            yield self.end_s, way
            made += way

    def _piece(self, now_s: float) -> Piece | None:
        if now_s >= self.end_s:  # most axes stand most of the time
            return None
        for piece in self.pieces:
            if now_s < piece.end_s:
                return piece
        return None


def standing(position: float) -> Profile:
    """Return the profile of an axis that does not move."""
    return Profile((), position)


def to_speed(
    position: float, speed: float, wanted: float, acceleration: float, now_s: float
) -> Profile:
    """Ramp from one speed to another and keep it for ever, or stand where that is zero."""
    ramp_s = abs(wanted - speed) / acceleration
    slope = math.copysign(acceleration, wanted - speed)
    ramp = Piece(now_s, position, speed, slope, ramp_s)
    end = position + ramp_s * (speed + wanted) / 2
    if not wanted:
        return Profile((ramp,), end)
    return Profile((ramp, Piece(now_s + ramp_s, end, wanted, 0.0, math.inf)), end)


def to_goal(
    position: float,
    speed: float,
    goal: float,
    rate: float,
    acceleration: float,
    now_s: float,
    braking: float | None = None,
) -> Profile:
    """Go to a goal and stand: a trapezoid, from whatever speed there is.

    What already runs away from the goal, or too fast to stop before it, stops first and turns.
    `braking` is how fast it slows down, where that is not as fast as it speeds up.
    """
    braking = acceleration if braking is None else braking
    brake = speed * abs(speed) / (2 * braking)
    if (goal - position - brake) * speed < -_ROUNDING * abs(speed):
        stop = to_speed(position, speed, 0.0, braking, now_s)
        back = to_goal(stop.end, 0.0, goal, rate, acceleration, stop.end_s, braking)
        return Profile((*stop.pieces, *back.pieces), goal)
    way = math.copysign(1.0, goal - position)
    far, first = abs(goal - position), abs(speed)
    both = 2 * acceleration * braking / (acceleration + braking)
    peak = min(rate, math.sqrt(both * (far + first**2 / (2 * acceleration))))
    slope = acceleration if peak >= first else -braking
    run = max(far - (peak**2 - first**2) / (2 * slope) - peak**2 / (2 * braking), 0.0)
    shape = (
        (first, slope, (peak - first) / slope),
        (peak, 0.0, run / peak if peak else 0.0),
        (peak, -braking, peak / braking),
    )
    pieces: list[Piece] = []
    for begins, slope, duration_s in shape:
        piece = Piece(now_s, position, way * begins, way * slope, duration_s)
        pieces.append(piece)
        now_s, position = piece.end_s, piece.at(piece.end_s)
    return Profile(pieces, goal)


def nearest(position: float) -> int:
    """Round to the whole step that a motor stands at."""
    return math.floor(position + 0.5)
