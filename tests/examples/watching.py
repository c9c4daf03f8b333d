"""Watches a simulated arm's world while it moves: the way of the tip, and what becomes of blocks.

Nothing of the driver is asked: what is seen here is physical.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import pairwise

from armdrive.sim.world import World
from armdrive.sim.world.table import Point, TableBlock
from kinematics import Joints

FINE_RAD = 0.01
"""Between two looks at the world, points of the way are no further apart in any joint."""

MARK_MM = 10.0
"""What is drawn this near to where the pen began is no stroke: it stood on the reference mark."""


@dataclass
class Watch:
    """What was seen of one world: the tip's way in mm, and how the blocks stood between moves.

    An arrangement is looked at whenever the fingers hold nothing, and kept where it is another one.
    """

    world: World
    trail: list[Point] = field(default_factory=list)
    arrangements: list[Mapping[str, TableBlock]] = field(default_factory=list)

    def __post_init__(self) -> None:
        """Hear of every motion that the scene is told."""
        self._joints = self.world.joints
        self._follow = self.world.scene.follow
        self.world.scene.follow = self._watched

    def strokes(self, below_mm: float) -> list[list[Point]]:
        """Return the parts of the way with a pen's point on the paper, or nearly so."""
        found: list[list[Point]] = []
        lifted = True
        for point in self.trail:
            if point[2] <= below_mm:
                if lifted:
                    found.append([])
                found[-1].append(point)
            lifted = point[2] > below_mm
        mark = self.trail[0]
        return [each for each in found if math.dist(each[0][:2], mark[:2]) > MARK_MM]

    def _watched(self, before: Point, after: Point, opening_mm: float, time_s: float):
        self.trail += self._way(self._joints, self.world.joints)
        self._joints = self.world.joints
        incidents = self._follow(before, after, opening_mm, time_s)
        scene = self.world.scene
        if scene.held is None and (blocks := dict(scene.blocks)) != self._arranged:
            self.arrangements.append(blocks)
        return incidents

    @property
    def _arranged(self) -> Mapping[str, TableBlock] | None:
        return self.arrangements[-1] if self.arrangements else None

    def _way(self, start: Joints, end: Joints) -> Iterator[Point]:
        """Yield the points of a way on which all motors turn in proportion."""
        furthest_rad = max(abs(b - a) for a, b in zip(start, end, strict=True))
        if furthest_rad == 0.0:
            return
        parts = math.ceil(furthest_rad / FINE_RAD)
        for part in range(1, parts + 1):
            angles = [a + (b - a) * part / parts for a, b in zip(start, end, strict=True)]
            pose = self.world.body.arm.fk(Joints(tuple(angles), start.names))
            yield pose.x_mm, pose.y_mm, pose.z_mm


def beside_mm(point: Point, corners: list[Point]) -> float:
    """Return how far a point is, seen from above, from a line through corners."""
    return min(_from_side(point, start, end) for start, end in pairwise(corners))


def _from_side(point: Point, start: Point, end: Point) -> float:
    (x, y), (to_x, to_y) = start[:2], (end[0] - start[0], end[1] - start[1])
    square = to_x**2 + to_y**2
    share = ((point[0] - x) * to_x + (point[1] - y) * to_y) / square if square else 0.0
    share = min(max(share, 0.0), 1.0)
    return math.dist(point[:2], (x + share * to_x, y + share * to_y))
