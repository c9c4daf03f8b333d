"""The path planned for all motors: straight segments that join, on a time axis of their own."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from armdrive.tasks import MoveBy
from kinematics.spaces import Motors


@dataclass(frozen=True, slots=True)
class Segment:
    """One straight part of a path: when and where it begins and ends."""

    start_s: float
    end_s: float
    start: Motors
    end: Motors

    def at(self, motor: int, time_s: float) -> float:
        """Return a motor's place at a time, or at the nearer end of the segment."""
        if time_s >= self.end_s:
            return float(self.end[motor])
        share = max(time_s - self.start_s, 0.0) / (self.end_s - self.start_s)
        return self.start[motor] + share * (self.end[motor] - self.start[motor])


class PlannedPath:
    """The segments that are known and not yet passed. `end` is the end of the last one."""

    def __init__(self, start: Motors) -> None:
        self.end = start
        self.end_s = 0.0
        self._segments: deque[Segment] = deque()

    def append(self, move: MoveBy, from_s: float = 0.0) -> None:
        """Append a segment, which begins at `from_s` if the path has ended before."""
        start_s = max(self.end_s, from_s)
        end, end_s = self.end + move.steps, start_s + max(move.duration_s, 1e-6)
        self._segments.append(Segment(start_s, end_s, self.end, end))
        self.end, self.end_s = end, end_s

    def discard_before(self, time_s: float, kept_s: float) -> None:
        """Discard segments that ended more than `kept_s` before a time."""
        while len(self._segments) > 1 and self._segments[0].end_s <= time_s - kept_s:
            self._segments.popleft()

    def at(self, motor: int, time_s: float) -> float:
        """Return a motor's place at a time."""
        for segment in self._segments:
            if time_s < segment.end_s:
                return segment.at(motor, time_s)
        return float(self.end[motor])

    def places(self, time_s: float) -> tuple[float, ...]:
        """Return where all motors are at a time."""
        return tuple(self.at(motor, time_s) for motor in range(len(self.end)))

    def turns(self, motor: int, from_s: float, until_s: float) -> list[float]:
        """Return a motor's places at the ends of segments between two times, and at the later."""
        ends = [each.end[motor] for each in self._segments if from_s < each.end_s < until_s]
        return [*map(float, ends), self.at(motor, until_s)]

    def fastest(self, motor: int, from_s: float, until_s: float) -> float:
        """Return the greatest speed of a motor between two times, in either direction."""
        return max(
            (
                abs(each.end[motor] - each.start[motor]) / (each.end_s - each.start_s)
                for each in self._segments
                if each.end_s > from_s and each.start_s < until_s
            ),
            default=0.0,
        )

    def averaged(self, time_s: float, window_s: float) -> list[float]:
        """Return every motor's mean place during the window that ends at a time.

        The same window for all motors keeps straight lines straight and turns jumps in speed into
        ramps.
        """
        motors = range(len(self.end))
        if not window_s:
            return list(self.places(time_s))
        totals, at_s = [0.0] * len(self.end), time_s - window_s
        for segment in self._segments:
            if segment.start_s >= time_s:
                break
            if segment.end_s <= at_s:
                continue
            begin_s, end_s = max(segment.start_s, at_s), min(segment.end_s, time_s)
            for motor in motors:
                # it stood still before the segment, and turns evenly during it
                totals[motor] += (begin_s - at_s) * segment.start[motor]
                ends = segment.at(motor, begin_s) + segment.at(motor, end_s)
                totals[motor] += (end_s - begin_s) * ends / 2.0
            at_s = end_s
        if at_s < time_s:
            for motor in motors:
                totals[motor] += (time_s - at_s) * self.at(motor, time_s)
        return [total / window_s for total in totals]


class SegmentFeed:
    """Fetches a motion's segments and appends them to its path."""

    def __init__(self, path: PlannedPath, segments: Iterator[MoveBy]) -> None:
        self._path, self._segments = path, segments
        self.exhausted = False
        """Whether the last segment has been fetched."""
        self.underruns = 0
        """How often the path ended although more segments were to come."""
        self.latest_s = 0.0
        """The duration of the latest segment."""

    def fetch(self, has_room: Callable[[], bool], from_s: float, *, dry: bool) -> None:
        """Fetch segments while there is room; a path that ran `dry` continues at `from_s`."""
        while not self.exhausted and has_room():
            segment = next(self._segments, None)
            if segment is None:
                self.exhausted = True
                return
            self._path.append(segment, from_s)
            self.latest_s = segment.duration_s
            self.underruns, dry = self.underruns + dry, False
