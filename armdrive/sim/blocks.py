"""Blocks that the simulated arm can pick up: upright boxes, and how they rest on one another.

Lengths in mm, z up from the table. A block's footprint is a square along x and y, whichever way
the hand turns while it carries the block: rotation is left out of this world.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, fields, replace

from armdrive.errors import BadRequest

Point = tuple[float, float, float]
REST_MM = 2.0
"""A block this much inside another one's top is standing on it, only pressed."""
GRAZE_MM = 1.0
"""Overlaps up to this are a touch, and move nothing."""


@dataclass(frozen=True, slots=True)
class Block:
    """A box by the centre of its bottom; `width_mm` is what the fingers measure.

    Raises `BadRequest` for sizes and places that no block has.
    """

    name: str
    x_mm: float
    y_mm: float
    z_mm: float = 0.0
    width_mm: float = 25.0
    height_mm: float = 25.0

    def __post_init__(self) -> None:
        if not self.name or any(sign.isspace() for sign in self.name):
            raise BadRequest(f"a block needs a name without spaces, not {self.name!r}")
        for field in fields(self)[1:]:
            number = getattr(self, field.name)
            if isinstance(number, bool) or not isinstance(number, int | float):
                raise BadRequest(f"{field.name} of block {self.name!r} is no number: {number!r}")
            if not math.isfinite(number):
                raise BadRequest(f"{field.name} of block {self.name!r} must be finite")
            object.__setattr__(self, field.name, float(number))
        if self.width_mm <= 0.0 or self.height_mm <= 0.0:
            raise BadRequest(f"block {self.name!r} must be wider and higher than 0 mm")

    @property
    def top_mm(self) -> float:
        """Height of the top above the table."""
        return self.z_mm + self.height_mm

    @property
    def place(self) -> Point:
        """The centre of the bottom."""
        return self.x_mm, self.y_mm, self.z_mm

    def at(self, place: Point) -> Block:
        """Return this block with the centre of its bottom somewhere else."""
        x, y, z = place
        return replace(self, x_mm=x, y_mm=y, z_mm=z)

    def contains(self, point: Point, margin_mm: float = 0.0) -> bool:
        """Tell whether a point is inside the block grown by a margin on all sides."""
        box = self._box(margin_mm)
        return all(low <= at <= high for at, (low, high) in zip(point, box, strict=True))

    def entry(self, start: Point, end: Point, margin_mm: float = 0.0) -> float | None:
        """Return the share of a straight way at which it enters the block; None if it does not.

        The slab method: the way is inside a box while it is inside all three of its slabs.
        """
        first, last = 0.0, 1.0
        for a, b, (low, high) in zip(start, end, self._box(margin_mm), strict=True):
            if a == b:
                if not low <= a <= high:
                    return None
                continue
            near, far = sorted(((low - a) / (b - a), (high - a) / (b - a)))
            first, last = max(first, near), min(last, far)
        return first if first <= last else None

    def shares_ground(self, other: Block) -> bool:
        """Tell whether the footprints overlap by more than a touch."""
        reach = (self.width_mm + other.width_mm) / 2 - GRAZE_MM
        return abs(self.x_mm - other.x_mm) < reach and abs(self.y_mm - other.y_mm) < reach

    def hits(self, other: Block) -> bool:
        """Tell whether the boxes overlap by more than resting on one another explains."""
        depth = min(self.top_mm, other.top_mm) - max(self.z_mm, other.z_mm)
        return depth > REST_MM and self.shares_ground(other)

    def _box(self, margin: float) -> tuple[tuple[float, float], ...]:
        half = self.width_mm / 2 + margin
        return (
            (self.x_mm - half, self.x_mm + half),
            (self.y_mm - half, self.y_mm + half),
            (self.z_mm - margin, self.top_mm + margin),
        )


def settled(blocks: Mapping[str, Block], floating: Collection[str] = ()) -> dict[str, Block]:
    """Let every block fall onto what is under it; those named in `floating` are in the fingers.

    A block stays where it comes down, however little of it is supported: nothing topples.
    """
    resting: list[Block] = []
    for block in sorted(blocks.values(), key=lambda one: one.z_mm):
        if block.name not in floating:
            under = [b for b in resting if b.top_mm <= block.z_mm + REST_MM]
            tops = (b.top_mm for b in under if b.shares_ground(block))
            resting.append(block.at((block.x_mm, block.y_mm, max(tops, default=0.0))))
    fallen = {block.name: block for block in resting}
    return {name: fallen.get(name, block) for name, block in blocks.items()}


def riders(blocks: Mapping[str, Block], carrier: str) -> tuple[str, ...]:
    """Name the blocks that stand on a block, and on those, and so on."""
    found = [carrier]
    for block in sorted(blocks.values(), key=lambda one: one.z_mm):
        if block.name not in found and any(_stands_on(block, blocks[name]) for name in found):
            found.append(block.name)
    return tuple(found[1:])


def _stands_on(block: Block, under: Block) -> bool:
    return abs(block.z_mm - under.top_mm) <= REST_MM and block.shares_ground(under)
