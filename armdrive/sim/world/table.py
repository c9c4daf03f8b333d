"""The table of a simulated world: its blocks, where each arm's base stands on it, and incidents.

Lengths are in mm, z up from the table. Several arms may stand on one table; each looks at it by a
scene of its own (scene.py). A block that two of them grip goes with the one that gripped it first.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from enum import Enum
from types import MappingProxyType
from typing import Protocol

from armdrive.errors import BadRequest
from armdrive.text.reading import number

# --- Blocks: upright boxes, and how they rest on one another -------------------------------------
#
# A block's footprint is a square along x and y, whichever way the hand turns while it carries the
# block: this world leaves rotation out.

Point = tuple[float, float, float]
REST_MM = 2.0
"""A block this much inside another one's top is standing on it, only pressed."""
GRAZE_MM = 1.0
"""Overlaps up to this are a touch, and move nothing."""


@dataclass(frozen=True, slots=True)
class TableBlock:
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
        for each in fields(self)[1:]:
            number = getattr(self, each.name)
            if isinstance(number, bool) or not isinstance(number, int | float):
                raise BadRequest(f"{each.name} of block {self.name!r} is no number: {number!r}")
            if not math.isfinite(number):
                raise BadRequest(f"{each.name} of block {self.name!r} must be finite")
            object.__setattr__(self, each.name, float(number))
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

    def at(self, place: Point) -> TableBlock:
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

    def shares_ground(self, other: TableBlock) -> bool:
        """Tell whether the footprints overlap by more than a touch."""
        reach = (self.width_mm + other.width_mm) / 2 - GRAZE_MM
        return abs(self.x_mm - other.x_mm) < reach and abs(self.y_mm - other.y_mm) < reach

    def hits(self, other: TableBlock) -> bool:
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


# --- A block in words: its name, place and size --------------------------------------------------

DROP_FROM_MM = 1000.0
"""A block comes down from above everything, onto what is there."""

USUAL_MM = 25.0
"""The side of a block of which no size is said."""

PARTS = "NAME X Y [WIDTH [HEIGHT]]"
"""What is said of a block, mm; the height is the width where it is left out."""


def block_of(words: Sequence[str]) -> TableBlock:
    """Return a block above the table, from three to five words. Raises `BadRequest`."""
    if not 3 <= len(words) <= 5:
        raise BadRequest(f"a block is given as {PARTS}, not as {' '.join(words)!r}")
    x_mm, y_mm, *sizes = (number(word) for word in words[1:])
    width_mm = sizes[0] if sizes else USUAL_MM
    height_mm = sizes[1] if len(sizes) > 1 else width_mm
    return TableBlock(words[0], x_mm, y_mm, DROP_FROM_MM, width_mm, height_mm)


def settled(
    blocks: Mapping[str, TableBlock], floating: Collection[str] = ()
) -> dict[str, TableBlock]:
    """Let every block fall onto what is under it; those named in `floating` are in the fingers.

    A block stays where it comes down, however little of it is supported: nothing topples.
    """
    resting: list[TableBlock] = []
    for block in sorted(blocks.values(), key=lambda one: one.z_mm):
        if block.name not in floating:
            under = [b for b in resting if b.top_mm <= block.z_mm + REST_MM]
            tops = (b.top_mm for b in under if b.shares_ground(block))
            resting.append(block.at((block.x_mm, block.y_mm, max(tops, default=0.0))))
    fallen = {block.name: block for block in resting}
    return {name: fallen.get(name, block) for name, block in blocks.items()}


def riders(blocks: Mapping[str, TableBlock], carrier: str) -> tuple[str, ...]:
    """Name the blocks that stand on a block, and on those, and so on."""
    found = [carrier]
    for block in sorted(blocks.values(), key=lambda one: one.z_mm):
        if block.name not in found and any(_stands_on(block, blocks[name]) for name in found):
            found.append(block.name)
    return tuple(found[1:])


def _stands_on(block: TableBlock, under: TableBlock) -> bool:
    return abs(block.z_mm - under.top_mm) <= REST_MM and block.shares_ground(under)


class Hand(Protocol):
    """What a table knows of the fingers of one arm above it."""

    @property
    def held(self) -> str | None:
        """The block that they grip."""

    @property
    def carried(self) -> tuple[str, ...]:
        """The blocks that go where they go: the one that they hold, and what stands on it."""

    def forget(self, name: str) -> None:
        """Know nothing more of a block: it was taken away."""

    def look(self) -> None:
        """Find out what the fingers are around, after things have been moved by hand."""

    def take_over(self) -> None:
        """Carry the block that they grip, since nobody else does any more."""


class Table:
    """Blocks by their names, and the hands above them. Hold `lock` while touching any of it."""

    def __init__(self) -> None:
        self.lock = threading.RLock()
        self.blocks: dict[str, TableBlock] = {}
        self._hands: list[Hand] = []

    def join(self, hand: Hand) -> None:
        """Have a hand above the table."""
        self._hands.append(hand)

    def others(self, hand: Hand) -> Iterator[Hand]:
        """Yield the other hands."""
        return (each for each in self._hands if each is not hand)

    def carrier(self, name: str) -> Hand | None:
        """Return the hand that a block goes with, if it is off the table."""
        return next((hand for hand in self._hands if name in hand.carried), None)

    def put(self, block: TableBlock) -> TableBlock:
        """Set a block down, on what is there; return where it came to rest."""
        with self.lock:
            self.take(block.name)
            self.blocks[block.name] = block
            self.settle()
            self._look()
            return self.blocks[block.name]

    def take(self, name: str) -> TableBlock | None:
        """Take a block away, out of the fingers if need be; None where there is none."""
        with self.lock:
            for hand in self._hands:
                hand.forget(name)
            taken = self.blocks.pop(name, None)
            self.settle()
            self._look()
            return taken

    def released(self) -> None:
        """Have another hand carry what one has let go of, and let fall what nobody holds."""
        for hand in self._hands:
            if hand.held is not None and self.carrier(hand.held) is None:
                hand.take_over()
        self.settle()

    def settle(self) -> None:
        """Let every block that nobody carries fall onto what is under it."""
        floating = [name for hand in self._hands for name in hand.carried]
        self.blocks = settled(self.blocks, floating)

    def _look(self) -> None:
        for hand in self._hands:
            hand.look()


@dataclass(frozen=True, slots=True)
class Stand:
    """Where an arm's base stands on a table: in mm, and turned about the vertical, in rad."""

    table: Table = field(default_factory=Table)
    x_mm: float = 0.0
    y_mm: float = 0.0
    turned_rad: float = 0.0

    @property
    def plain(self) -> bool:
        """Whether the arm's own coordinates are the table's."""
        return (self.x_mm, self.y_mm, self.turned_rad) == (0.0, 0.0, 0.0)

    def on_table(self, point: Point) -> Point:
        """Return where a point of the arm's base frame is on the table."""
        if self.plain:
            return point
        cos, sin = math.cos(self.turned_rad), math.sin(self.turned_rad)
        x, y, z = point
        return self.x_mm + cos * x - sin * y, self.y_mm + sin * x + cos * y, z

    def from_base(self, point: Point) -> Point:
        """Return where the arm's base frame has a point of the table."""
        if self.plain:
            return point
        cos, sin = math.cos(self.turned_rad), math.sin(self.turned_rad)
        x, y, z = point[0] - self.x_mm, point[1] - self.y_mm, point[2]
        return cos * x + sin * y, cos * y - sin * x, z

    def seen(self) -> Mapping[str, TableBlock]:
        """Return the blocks as the arm's base frame has them."""
        blocks = self.table.blocks
        if self.plain:
            return MappingProxyType(blocks)
        placed = {name: block.at(self.from_base(block.place)) for name, block in blocks.items()}
        return MappingProxyType(placed)


# --- Incidents: what goes wrong around an arm, and no controller hears of ------------------------


class IncidentKind(Enum):
    """What can go wrong in the world of the arm."""

    TABLE = "table touched"
    KNOCK = "block knocked"
    STOP = "mechanical stop"


@dataclass(frozen=True, slots=True)
class Incident:
    """Something went wrong: with what, when (s, on the device's clock), and a sentence."""

    kind: IncidentKind
    what: str
    sentence: str
    time_s: float
