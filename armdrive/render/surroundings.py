"""The surroundings of an arm as lines in space: table, base, guards, and the tip's trail."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator
from itertools import product

from armdrive.render.camera import Dome
from armdrive.render.inks import Ink, Layer, Letters, Stroke
from kinematics.geometry import ArmGeometry, Point
from kinematics.guards.guards import Guards
from kinematics.guards.shapes import Box

GRID_MM = 100.0  # size of the squares on the table
_FOOT = 0.13  # radius of a base of unknown size, as a share of the reach

_CORNERS = 36
_NAME_LENGTH = 10


def surroundings(arm: ArmGeometry, guards: Guards, dome: Dome) -> Layer:
    """Return everything that does not move: table with axes, base column, boxes and radii."""
    return _table(dome) + _turn(arm, dome) + _base(guards, dome) + _radii(guards) + _boxes(guards)


def _table(dome: Dome) -> Layer:
    """Return the squares of the table within the arm's reach, and the letters of its axes."""
    count = math.floor(dome.reach_mm / GRID_MM)
    lines = []
    for index in range(-count, count + 1):
        at = index * GRID_MM
        half = math.sqrt(max(dome.reach_mm**2 - at**2, 0.0))
        lines.append(((at, -half, 0.0), (at, half, 0.0)))
        lines.append(((-half, at, 0.0), (half, at, 0.0)))
    strokes = tuple(Stroke(Ink.TABLE, line) for line in lines)
    letters = (
        Letters(Ink.TABLE, (dome.reach_mm, 0.0, 0.0), "X"),
        Letters(Ink.TABLE, (0.0, dome.reach_mm, 0.0), "Y"),
    )
    return Layer(strokes, letters)


def _turn(arm: ArmGeometry, dome: Dome) -> Layer:
    """Return the limits of the base joint as lines, if it cannot make a full turn."""
    base = arm.limits[0]
    if base.high_rad - base.low_rad >= math.tau:
        return Layer()
    x, y, _ = dome.centre
    bounds = tuple(
        Stroke(
            Ink.REACH,
            (
                (x, y, 0.0),
                (x + dome.reach_mm * math.cos(angle), y + dome.reach_mm * math.sin(angle), 0.0),
            ),
        )
        for angle in (base.low_rad, base.high_rad)
    )
    return Layer(bounds)


def _base(guards: Guards, dome: Dome) -> Layer:
    """Return the base column from the guards, or else a circle on the table."""
    x, y, _ = dome.centre
    if guards.base_radius_mm is None:
        return Layer((Stroke(Ink.BASE, _ring(x, y, dome.reach_mm * _FOOT, 0.0)),))
    radius, top = guards.base_radius_mm, guards.base_top_mm
    rings = tuple(Stroke(Ink.BASE, _ring(x, y, radius, z)) for z in (0.0, top))
    posts = tuple(
        Stroke(Ink.BASE, ((px, py, 0.0), (px, py, top)))
        for px, py, _ in _ring(x, y, radius, 0.0)[: -1 : _CORNERS // 4]
    )
    return Layer((*rings, *posts))


def _radii(guards: Guards) -> Layer:
    """Return the circles on the table that limit the radius of the tip."""
    radii = (guards.inner_radius_mm, guards.outer_radius_mm)
    return Layer(
        tuple(Stroke(Ink.GUARD, _ring(0.0, 0.0, one, 0.0)) for one in radii if one is not None)
    )


def _boxes(guards: Guards) -> Layer:
    """Return the edges of the keep-out boxes, each with its shortened name on top."""
    strokes = tuple(Stroke(Ink.GUARD, edge) for box in guards.boxes for edge in _edges(box))
    letters = tuple(
        Letters(Ink.GUARD, _above(box), box.name[:_NAME_LENGTH]) for box in guards.boxes
    )
    return Layer(strokes, letters)


def _edges(box: Box) -> Iterator[tuple[Point, Point]]:
    """Yield the twelve edges: pairs of corners that differ in one coordinate."""
    corners: list[Point] = [
        (x, y, z) for x, y, z in product(*zip(box.min_mm, box.max_mm, strict=True))
    ]
    for index, one in enumerate(corners):
        for other in corners[index + 1 :]:
            if sum(a != b for a, b in zip(one, other, strict=True)) == 1:
                yield one, other


def _above(box: Box) -> Point:
    (x0, y0, _), (x1, y1, z1) = box.min_mm, box.max_mm
    return (x0 + x1) / 2.0, (y0 + y1) / 2.0, z1


def _ring(x: float, y: float, radius: float, z: float) -> tuple[Point, ...]:
    """Return a closed circle around a vertical axis."""
    angles = (math.tau * corner / _CORNERS for corner in range(_CORNERS + 1))
    return tuple((x + radius * math.cos(a), y + radius * math.sin(a), z) for a in angles)


# --- The trail: a limited number of the tip's latest points, in pieces ---------------------------

PIECE = 16  # points in a layer; a full layer never changes, so it need not be drawn again
MOST_PIECES, FORGOTTEN_AT_ONCE = 24, 6
"""The number of full layers. Removing one redraws the others, so several go at a time."""

LEAP = 0.35
"""If the tip moves by this share of the reach between two updates, the position was changed.

The fastest arm sweeps its whole reach in about a second, and updates are 0.05 s apart.
"""

_SPACING = 0.008  # share of the reach; closer points would fall on the same dots


class Trail:
    """The recent path of the tip, oldest point first; it is interrupted if the position is lost."""

    def __init__(self, reach_mm: float) -> None:
        self._leap_mm = LEAP * reach_mm
        self._spacing_mm = _SPACING * reach_mm
        self._full: deque[Layer] = deque()
        self._points: list[Point] = []

    def add(self, tip: Point | None) -> None:
        """Add the position of the tip now, or None while it is unknown."""
        gone_mm = math.dist(self._points[-1], tip) if tip is not None and self._points else 0.0
        if tip is None or gone_mm > self._leap_mm:
            self._close()
            self._points = []
        if tip is None or (self._points and gone_mm < self._spacing_mm):
            return
        self._points.append(tip)
        if len(self._points) == PIECE:
            self._close()
            self._points = [tip]  # the next piece continues from here

    def clear(self) -> None:
        """Forget the trail, except for the current position."""
        self._full.clear()
        self._points = self._points[-1:]

    @property
    def full(self) -> tuple[Layer, ...]:
        """The full pieces: the identical layer objects each time, until they are forgotten."""
        return tuple(self._full)

    @property
    def latest(self) -> Layer:
        """The piece that still grows."""
        if len(self._points) < 2:
            return Layer()
        return Layer((Stroke(Ink.DRIVEN, tuple(self._points)),))

    @property
    def points(self) -> tuple[Point, ...]:
        """All remembered points, oldest first; points shared by two pieces appear twice."""
        strokes = (*(stroke for layer in self._full for stroke in layer.strokes),)
        return (*(point for stroke in strokes for point in stroke.points), *self._points)

    def _close(self) -> None:
        if len(self._points) > 1:
            self._full.append(Layer((Stroke(Ink.DRIVEN, tuple(self._points)),)))
        if len(self._full) > MOST_PIECES:
            for _ in range(FORGOTTEN_AT_ONCE):
                self._full.popleft()
