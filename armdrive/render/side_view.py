"""Drawings of an arm from the side and from above, with the same scale on both axes.

From the side, r points right and z up, in the arm's vertical plane. From above, the viewer is
behind the base: x points up the screen and y left, so that turning the base to the left turns the
drawing to the left.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

from armdrive.render.canvas import Canvas

Point = tuple[float, float, float]
Flat = tuple[float, float]

_ROOM = 1.04  # a little air around the reach
_BELOW_TABLE_MM = 25.0
_BACK_OF_TOP_VIEW = 0.3  # share of the reach that stays visible behind the base
_PALM = 0.6  # share of the hand before the fingers part
_BASE_HALF_WIDTH_MM = 60.0
_SPARSE = 3


@dataclass(frozen=True, slots=True)
class DrawnBox:
    """A block on the table: its centre in x and y, its underside in z, all in mm."""

    name: str
    x_mm: float
    y_mm: float
    z_mm: float
    width_mm: float
    height_mm: float


@dataclass(frozen=True, slots=True)
class ArmScene:
    """The contents of a drawing, in mm in the table's frame.

    `points` run from the foot of the base through shoulder, elbow and wrist to the finger tips.
    `base_rad` is the direction of the side view. `reach_mm` is the greatest distance of the tips
    from the shoulder axis; it fixes the scale, which is therefore the same in every posture.
    `range_lines` are drawn dotted: limits of the base joint, a guard, a path.
    """

    points: tuple[Point, ...]
    opening_mm: float
    base_rad: float
    reach_mm: float
    blocks: tuple[DrawnBox, ...] = ()
    goal: Point | None = None
    range_lines: tuple[tuple[Point, Point], ...] = ()


@dataclass(frozen=True, slots=True)
class _Frame:
    """Maps mm, with v up, to dots on a canvas, with y down."""

    canvas: Canvas
    left_mm: float
    top_mm: float
    dots_per_mm: float

    def dots(self, point: Flat) -> Flat:
        u, v = point
        return (
            (u - self.left_mm) * self.dots_per_mm,
            (self.top_mm - v) * self.dots_per_mm / self.canvas.dot_aspect,
        )

    def line(self, start: Flat, end: Flat, *, every: int = 1, stroke: str = "") -> None:
        self.canvas.line(*self.dots(start), *self.dots(end), every=every, stroke=stroke)

    def path(self, points: Sequence[Flat]) -> None:
        for start, end in pairwise(points):
            self.line(start, end)

    def text(self, point: Flat, text: str) -> None:
        x, y = self.dots(point)
        per_cell = (2, 4) if self.canvas.braille else (1, 1)
        self.canvas.text(round(x) // per_cell[0], round(y) // per_cell[1], text)


def side_view(scene: ArmScene, width: int, height: int, braille: bool) -> list[str]:
    """Draw r against z in the arm's own plane, on `width` by `height` character cells."""
    cos_base, sin_base = math.cos(scene.base_rad), math.sin(scene.base_rad)

    def flatten(point: Point) -> Flat:
        return point[0] * cos_base + point[1] * sin_base, point[2]

    half = scene.reach_mm * _ROOM
    axis_mm = scene.points[1][2] if len(scene.points) > 1 else 0.0
    canvas = Canvas(width, height, braille=braille)
    frame = _fit(canvas, -half, half, -_BELOW_TABLE_MM, half + axis_mm)
    frame.line((-10 * half, 0.0), (10 * half, 0.0), stroke="_")
    _arc(frame, (0.0, axis_mm), scene.reach_mm, math.pi)
    for block in scene.blocks:
        centre = flatten((block.x_mm, block.y_mm, block.z_mm))
        _box(frame, centre, block.width_mm, block.height_mm, block.name)
    _arm(frame, scene, flatten)
    return frame.canvas.rows()


def top_view(scene: ArmScene, width: int, height: int, braille: bool) -> list[str]:
    """Draw the table from above, x up and y to the left, on `width` by `height` cells."""

    def flatten(point: Point) -> Flat:
        return -point[1], point[0]

    half = scene.reach_mm * _ROOM
    back = half * _BACK_OF_TOP_VIEW
    if any(point[0] < -back for point in scene.points):
        back = half
    frame = _fit(Canvas(width, height, braille=braille), -half, half, -back, half)
    _arc(frame, (0.0, 0.0), scene.reach_mm, 2 * math.pi)
    foot = _BASE_HALF_WIDTH_MM
    frame.path(((-foot, -foot), (foot, -foot), (foot, foot), (-foot, foot), (-foot, -foot)))
    for block in scene.blocks:
        underside = (-block.y_mm, block.x_mm - block.width_mm / 2)
        _box(frame, underside, block.width_mm, block.width_mm, block.name)
    _arm(frame, scene, flatten)
    return frame.canvas.rows()


def _fit(canvas: Canvas, left: float, right: float, bottom: float, top: float) -> _Frame:
    """Fit the whole range in the middle of the canvas, with the same scale on both axes."""
    wide = canvas.width_dots
    high = canvas.height_dots * canvas.dot_aspect
    scale = max(min((wide - 1) / (right - left), (high - canvas.dot_aspect) / (top - bottom)), 0.0)
    if scale == 0.0:
        return _Frame(canvas, left, top, 0.0)
    spare_u = (wide - 1) / scale - (right - left)
    return _Frame(canvas, left - spare_u / 2, top, scale)


def _arc(frame: _Frame, centre: Flat, radius_mm: float, turn_rad: float) -> None:
    """Draw a dotted arc counter-clockwise, starting at the right."""
    count = max(1, round(radius_mm * turn_rad * frame.dots_per_mm / _SPARSE))
    for step in range(count + 1):
        angle = turn_rad * step / count
        u = centre[0] + radius_mm * math.cos(angle)
        v = centre[1] + radius_mm * math.sin(angle)
        frame.canvas.dot(*frame.dots((u, v)), mark=".")


def _box(frame: _Frame, underside: Flat, width: float, height: float, name: str) -> None:
    u, v = underside
    for share in (0.0, 0.5, 1.0):  # looks filled at any size, with few lines
        level = v + height * share
        frame.line((u - width / 2, level), (u + width / 2, level), stroke="#")
    for side in (-width / 2, width / 2):
        frame.line((u + side, v), (u + side, v + height), stroke="#")
    frame.text((u, v + height / 2), name[:1])


def _arm(frame: _Frame, scene: ArmScene, flatten: Callable[[Point], Flat]) -> None:
    for line in scene.range_lines:
        frame.line(flatten(line[0]), flatten(line[1]), every=_SPARSE, stroke=".")
    if scene.goal is not None:
        frame.text(flatten(scene.goal), "X")
    flat = [flatten(point) for point in scene.points]
    for start, end in pairwise(flat[:-1]):
        _thick(frame, start, end)
    if len(flat) > 1:
        _hand(frame, flat[-2], flat[-1], scene.opening_mm)
    for point in flat[1:-1]:
        _joint(frame, point)


def _thick(frame: _Frame, start: Flat, end: Flat) -> None:
    """Draw a link two dots wide in braille; in ASCII one stroke is wide enough."""
    frame.line(start, end)
    if frame.canvas.braille and frame.dots_per_mm > 0:
        dot = 1.0 / frame.dots_per_mm
        steep = abs(end[1] - start[1]) > abs(end[0] - start[0])
        shift = (dot, 0.0) if steep else (0.0, dot)
        frame.line(_moved(start, shift), _moved(end, shift))


def _hand(frame: _Frame, wrist: Flat, tip: Flat, opening_mm: float) -> None:
    """Draw the palm and two fingers `opening_mm` apart."""
    du, dv = tip[0] - wrist[0], tip[1] - wrist[1]
    length = math.hypot(du, dv)
    palm = (wrist[0] + _PALM * du, wrist[1] + _PALM * dv)
    frame.line(wrist, palm)
    if length < 1e-9:  # the hand points at the viewer: only the opening is visible
        across = (opening_mm / 2, 0.0)
    else:
        across = (-dv / length * opening_mm / 2, du / length * opening_mm / 2)
    back = (-across[0], -across[1])
    frame.line(_moved(palm, back), _moved(palm, across))
    for side in (across, back):
        frame.line(_moved(palm, side), _moved(tip, side))


def _joint(frame: _Frame, point: Flat) -> None:
    x, y = frame.dots(point)
    if not frame.canvas.braille:
        frame.canvas.dot(x, y, "o")
        return
    for dx, dy in ((0, 0), (-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (1, 1), (-1, 1), (1, -1)):
        frame.canvas.dot(x + dx, y + dy)


def _moved(point: Flat, by: Flat) -> Flat:
    return point[0] + by[0], point[1] + by[1]
