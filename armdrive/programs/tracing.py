"""Keeps the way of a simulated arm's tip, for the picture of a rehearsed script.

It is the physical way, whichever call makes the arm move: lines, arcs, routes and jogs alike.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, cast

if TYPE_CHECKING:
    from armdrive.arm import Arm
    from armdrive.sim.incidents import Incident
    from armdrive.sim.scene import Scene
    from kinematics.geometry import Point

NEAREST_MM = 1.0
"""Points of the path are no nearer to one another."""


class TracedScene:
    """The scene of an arm's world, which is told every motion of the tip; all else is its own."""

    def __init__(self, arm: Arm, scene: Scene, path: list[Point]) -> None:
        self._arm = arm
        self._scene = scene
        self._path = path

    def follow(
        self, before: Point, after: Point, opening_mm: float, time_s: float
    ) -> list[Incident]:
        """Keep where the tip goes, once the arm knows where it stands."""
        if self._arm.core.position_known:
            for point in (before, after):
                if not self._path or math.dist(self._path[-1], point) >= NEAREST_MM:
                    self._path.append(point)
        return self._scene.follow(before, after, opening_mm, time_s)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._scene, name)


def trace(arm: Arm, path: list[Point]) -> None:
    """Have a twin's tip leave its points in a path, in mm in the arm's base frame."""
    if arm.twin is not None:
        world = arm.twin.world
        world.scene = cast("Scene", TracedScene(arm, world.scene, path))
