"""The two drawings of the arm, as widgets that repaint only the rows that changed."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise
from typing import TYPE_CHECKING

from rich.segment import Segment
from textual.geometry import Region
from textual.strip import Strip
from textual.widget import Widget

from armdrive.render.side_view import ArmScene

if TYPE_CHECKING:
    from kinematics import ArmModel, Joints

Draw = Callable[[ArmScene, int, int, bool], list[str]]


def scene_of(model: ArmModel, joints: Joints, opening_mm: float | None) -> ArmScene:
    """Return what is to be drawn of an arm in this posture, with the bounds of its base."""
    points = model.arm.points(joints)
    reach_mm = sum(math.dist(start, end) for start, end in pairwise(points[1:]))
    base = model.arm.limits[0]
    bounds = tuple(
        ((0.0, 0.0, 0.0), (reach_mm * math.cos(angle), reach_mm * math.sin(angle), 0.0))
        for angle in (base.low_rad, base.high_rad)
    )
    return ArmScene(points, opening_mm or 0.0, joints[0], reach_mm, range_lines=bounds)


class ArmView(Widget):
    """One view of the arm with its title in the corner, or a sentence when nothing is known."""

    def __init__(self, title: str, draw: Draw, *, braille: bool, id: str) -> None:  # noqa: A002
        super().__init__(id=id)
        self._title = title
        self._draw = draw
        self._braille = braille
        self._scene: ArmScene | None = None
        self._rows: list[str] = []

    @property
    def rows(self) -> tuple[str, ...]:
        """The picture, row by row."""
        return tuple(self._rows)

    def show(self, scene: ArmScene | None) -> None:
        """Draw another scene; None when the posture is not known."""
        if scene != self._scene or not self._rows:
            self._scene = scene
            self._redraw()

    def on_resize(self) -> None:
        """Draw again at the new size."""
        self._redraw()

    def render_line(self, y: int) -> Strip:
        """Return one row of the picture."""
        text = self._rows[y] if y < len(self._rows) else " " * self.size.width
        return Strip([Segment(text, self.rich_style)], self.size.width)

    def _redraw(self) -> None:
        before, self._rows = self._rows, self._picture()
        if len(before) != len(self._rows):
            self.refresh()
            return
        for y, (old, new) in enumerate(zip(before, self._rows, strict=True)):
            if old != new:
                self.refresh(Region(0, y, self.size.width, 1))

    def _picture(self) -> list[str]:
        width, height = self.size
        if self._scene is None:
            rows = [" " * width] * height
            if height > 1:
                rows[height // 2] = "posture not known: H"[:width].center(width)
        else:
            rows = self._draw(self._scene, width, height, self._braille)
        if rows:
            rows[0] = (self._title + rows[0][len(self._title) :])[:width]
        return rows
