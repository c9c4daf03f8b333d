"""The table: the blocks on it, in its own coordinates, and where each arm's base stands on it.

Lengths in mm, z up from the table. Several arms may stand on one table; each looks at it by a
scene of its own (scene.py). A block that two of them grip goes with the one that gripped it first.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Protocol

from armdrive.sim.blocks import Block, Point, settled


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
        self.blocks: dict[str, Block] = {}
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

    def put(self, block: Block) -> Block:
        """Set a block down, on what is there; return where it came to rest."""
        with self.lock:
            self.take(block.name)
            self.blocks[block.name] = block
            self.settle()
            self._look()
            return self.blocks[block.name]

    def take(self, name: str) -> Block | None:
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

    def seen(self) -> Mapping[str, Block]:
        """Return the blocks as the arm's base frame has them."""
        blocks = self.table.blocks
        if self.plain:
            return MappingProxyType(blocks)
        placed = {name: block.at(self.from_base(block.place)) for name, block in blocks.items()}
        return MappingProxyType(placed)
