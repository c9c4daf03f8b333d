"""The way that the tip has just gone: the latest points of it, a bounded number, in pieces."""

from __future__ import annotations

import math
from collections import deque

from armdrive.draw.inks import Ink, Layer, Stroke
from kinematics.geometry import Point

PIECE = 16
"""Points in one layer. Full layers stay as they are, so that they need not be drawn again."""

MOST_PIECES, FORGOTTEN_AT_ONCE = 24, 6
"""How many are kept. The oldest go together, since all that stay are then drawn anew."""

LEAP = 0.35
"""A tip that is this share of the reach away from one look to the next was not driven there.

At its fastest an arm sweeps its whole reach in about a second; looks are a twentieth apart.
"""

_SPACING = 0.008
"""Points nearer to one another than this share of the reach would fall on the same dots."""


class Trail:
    """Where the tip has been, oldest first; it begins anew where the position was lost."""

    def __init__(self, reach_mm: float) -> None:
        self._leap_mm = LEAP * reach_mm
        self._spacing_mm = _SPACING * reach_mm
        self._full: deque[Layer] = deque()
        self._points: list[Point] = []

    def add(self, tip: Point | None) -> None:
        """Note where the tip is now; None while nobody knows."""
        gone_mm = math.dist(self._points[-1], tip) if tip is not None and self._points else 0.0
        if tip is None or gone_mm > self._leap_mm:
            self._close()
            self._points = []
        if tip is None or (self._points and gone_mm < self._spacing_mm):
            return
        self._points.append(tip)
        if len(self._points) == PIECE:
            self._close()
            self._points = [tip]  # the next piece goes on from here

    def clear(self) -> None:
        """Forget the way; it goes on from where the tip is."""
        self._full.clear()
        self._points = self._points[-1:]

    @property
    def full(self) -> tuple[Layer, ...]:
        """The older pieces: the very same layers each time, until they are forgotten."""
        return tuple(self._full)

    @property
    def latest(self) -> Layer:
        """The piece that grows."""
        if len(self._points) < 2:
            return Layer()
        return Layer((Stroke(Ink.DRIVEN, tuple(self._points)),))

    @property
    def points(self) -> tuple[Point, ...]:
        """All points that are remembered, oldest first; where pieces meet, twice."""
        strokes = (*(stroke for layer in self._full for stroke in layer.strokes),)
        return (*(point for stroke in strokes for point in stroke.points), *self._points)

    def _close(self) -> None:
        if len(self._points) > 1:
            self._full.append(Layer((Stroke(Ink.DRIVEN, tuple(self._points)),)))
        if len(self._full) > MOST_PIECES:
            for _ in range(FORGOTTEN_AT_ONCE):
                self._full.popleft()
