"""The way of a motion that is steered: segments on a time of their own, looked at motor by motor.

Counts, seconds since the motion began. Segments are straight and join; their end is as far as
anything has been drawn.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from armdrive.controllers.piece import Piece
from armdrive.controllers.requests import MoveBy, never
from kinematics.spaces import Motors

KEEP_S = 1.0
"""What lies behind is remembered for so long: drives may be found to be there still."""
LOOK_S, FINE_S = 0.01, 0.001
"""How finely a place on the way is looked for, at first and at last."""


@dataclass(frozen=True, slots=True)
class Lead:
    """How a motor goes on: which way (0 where it stands), how far before it turns, until when."""

    way: int
    far: float
    until_s: float


def shares_of(speeds: Sequence[float]) -> list[float]:
    """Return each speed as a share of the fastest; 1 where nothing moves."""
    fastest = max(speeds)
    return [speed / fastest if fastest else 1.0 for speed in speeds]


class Track:
    """The segments that were drawn and not passed."""

    def __init__(self, start: Motors) -> None:
        self.end = start
        self.end_s = 0.0
        self._pieces: deque[Piece] = deque()

    def draw(self, segment: MoveBy) -> None:
        """Take in the next segment."""
        end, end_s = self.end + segment.steps, self.end_s + segment.duration_s
        self._pieces.append(Piece(self.end_s, end_s, self.end, end))
        self.end, self.end_s = end, end_s

    def pass_by(self, time_s: float) -> None:
        """Forget what lies far behind."""
        while len(self._pieces) > 1 and self._pieces[0].end_s <= time_s - KEEP_S:
            self._pieces.popleft()

    def at(self, motor: int, time_s: float) -> float:
        """Return where a motor shall be at a time."""
        for piece in self._pieces:
            if time_s < piece.end_s:
                return piece.at(motor, time_s)
        return float(self.end[motor])

    def nearest_s(self, counts: Sequence[int], early_s: float, late_s: float) -> float:
        """Return when between two times motors should be where they were found, or nearest to it.

        The earliest such time: what is driven twice is not left out.
        """
        for step_s in (LOOK_S, FINE_S):
            steps = max(math.ceil((late_s - early_s) / step_s), 1)
            times = [min(early_s + step * step_s, late_s) for step in range(steps + 1)]
            found_s = min(times, key=lambda time_s: self._off(counts, time_s))
            early_s, late_s = max(found_s - LOOK_S, early_s), min(found_s + LOOK_S, late_s)
        return found_s

    def span(self, motor: int, early_s: float, late_s: float) -> tuple[float, float]:
        """Return from where to where a motor goes between two times."""
        inner = [piece.end[motor] for piece in self._pieces if early_s < piece.end_s < late_s]
        places = (self.at(motor, early_s), self.at(motor, late_s), *inner)
        return min(places), max(places)

    def _off(self, counts: Sequence[int], time_s: float) -> float:
        return max(abs(self.at(motor, time_s) - count) for motor, count in enumerate(counts))

    def mean(self, motor: int, from_s: float, lead: Lead) -> float:
        """Return how fast a motor goes on a lead, at a mean."""
        way = abs(lead.far - self.at(motor, from_s))
        return way / (lead.until_s - from_s) if way else 0.0

    def lead(self, motor: int, from_s: float, until_s: float) -> Lead:
        """Return how a motor goes on from a time: no further than it goes one way."""
        way, far, far_s = 0, self.at(motor, from_s), from_s
        for piece in self._pieces:
            if piece.end_s <= from_s:
                continue
            if piece.start_s >= until_s:
                break
            turn = piece.end[motor] - piece.start[motor]
            if turn * way < 0:
                break
            if turn:
                way = 1 if turn > 0 else -1
                far_s = min(piece.end_s, until_s)
                far = piece.at(motor, far_s)
        return Lead(way, far, far_s)


@dataclass(slots=True)
class Trip:
    """One motion under way: where its segments come from, and how far it is."""

    segments: Iterator[MoveBy]
    ahead_s: float
    let_go: Callable[[], bool]
    track: Track
    held_back: Callable[[], bool] = never
    """Whether somebody has paused the arm."""
    time_s: float = 0.0
    """Where on the track the motors are now."""
    sent_s: float = 0.0
    """How far on it they have been sent."""
    steered_s: float = -math.inf
    due_s: float = -math.inf
    """When the drives are to be steered next."""
    polled_s: float = -math.inf
    polled_at_s: float = 0.0
    """Where on the track the motors were to be at that look."""
    weighed: bool = True
    """Whether it has been weighed what all drives told then."""
    beside: int = 0
    """At how many looks in a row they were beside their way."""
    guess_s: float = 0.0
    exhausted: bool = False
    held: bool = False
    """Whether nothing more is to be drawn for now."""

    @property
    def sent_all(self) -> bool:
        """Whether nothing is left to be steered."""
        return (self.exhausted or self.held) and self.time_s >= self.track.end_s

    def is_due(self, now_s: float, period_s: float) -> bool:
        """Tell whether it is time to steer, and then set the next one: late ones do not add up."""
        if now_s < self.due_s - 1e-9:
            return False
        self.due_s = max(self.due_s, now_s - period_s / 2.0) + period_s
        return True

    def go_on(self, now_s: float) -> None:
        """Let the time since the last steering pass, as far as the motors had been sent."""
        if math.isfinite(self.steered_s):
            self.time_s = min(self.time_s + now_s - self.steered_s, self.sent_s)
        self.steered_s = now_s
        self.track.pass_by(self.time_s)

    def look(self, now_s: float) -> None:
        """Take note that all drives are asked where they are."""
        self.polled_s, self.weighed = now_s, False
        since_s = now_s - self.steered_s if math.isfinite(self.steered_s) else 0.0
        self.polled_at_s = min(self.time_s + since_s, self.sent_s)

    def resume(self, time_s: float, now_s: float) -> None:
        """Go on from a time on the track that the motors are found to be at."""
        self.time_s = self.sent_s = time_s
        self.weighed, self.beside = True, 0
        self.steered_s = self.due_s = now_s

    def draw(self) -> bool:
        """Draw segments while there is room; tell whether the track had run out before."""
        dry = self.time_s >= self.track.end_s > 0.0 and not (self.exhausted or self.held)
        drew = False
        while not (self.exhausted or self.held) and self._has_room():
            segment = next(self.segments, None)
            if segment is None:
                self.exhausted = True
                break
            self.track.draw(segment)
            self.guess_s, drew = segment.duration_s, True
        return dry and drew

    def _has_room(self) -> bool:
        left_s = self.track.end_s - self.time_s
        return left_s <= 0.0 or left_s + self.guess_s <= self.ahead_s + 1e-6
