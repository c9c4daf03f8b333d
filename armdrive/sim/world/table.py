"""The table of a simulated world: blocks, the arms around it, gripping, and incidents.

Lengths are in mm, z up from the table. Several arms may stand at one table, each with a `GripScene`
of its own. An arm that has closed on a block that another carries takes it over when that lets go.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from enum import Enum

from armdrive.errors import BadRequest
from armdrive.text.numbers import number
from kinematics.text import mm_text, tenths

# --- Blocks: upright boxes, and how they rest on one another -------------------------------------
# A block's footprint stays parallel to x and y, even while a turning hand carries it: this world
# leaves rotation out.

Point = tuple[float, float, float]
# A block overlapping the top of another by up to this much rests on it, pressed down.
REST_MM = 2.0
# Overlaps up to this count as touching and move nothing.
GRAZE_MM = 1.0


@dataclass(frozen=True, slots=True)
class TableBlock:
    """A box located by the centre of its bottom; `width_mm` is what the fingers measure.

    Raises `BadRequest` for impossible sizes and positions.
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
            real = isinstance(number, int | float) and not isinstance(number, bool)
            if not (real and math.isfinite(number)):
                raise BadRequest(f"{each.name} of block {self.name!r} is no number: {number!r}")
        if self.width_mm <= 0.0 or self.height_mm <= 0.0:
            raise BadRequest(f"block {self.name!r} must be wider and higher than 0 mm")

    @property
    def top_mm(self) -> float:
        """The height of the top above the table."""
        return self.z_mm + self.height_mm

    @property
    def place(self) -> Point:
        """The centre of the bottom."""
        return self.x_mm, self.y_mm, self.z_mm

    @property
    def place_words(self) -> str:
        """The same for people."""
        x, y = tenths(self.x_mm), tenths(self.y_mm)
        return f"x {x}, y {y}, z {mm_text(self.z_mm)}"

    def at(self, place: Point) -> TableBlock:
        """Return this block at another position."""
        x, y, z = place
        return replace(self, x_mm=x, y_mm=y, z_mm=z)

    def contains(self, point: Point, margin_mm: float = 0.0) -> bool:
        """Return whether a point is inside the block grown by a margin on all sides."""
        box = self._box(margin_mm)
        return all(low <= at <= high for at, (low, high) in zip(point, box, strict=True))

    def entry(self, start: Point, end: Point, margin_mm: float = 0.0) -> float | None:
        """Return the fraction of a straight path at which it enters the block; None if it does not.

        The slab method: the path is inside a box while it is inside all three of its slabs.
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
        """Return whether the footprints overlap by more than a touch."""
        reach = (self.width_mm + other.width_mm) / 2 - GRAZE_MM
        return abs(self.x_mm - other.x_mm) < reach and abs(self.y_mm - other.y_mm) < reach

    def hits(self, other: TableBlock) -> bool:
        """Return whether the boxes overlap by more than resting on one another explains."""
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

# New blocks are dropped from above everything else.
DROP_FROM_MM = 1000.0

# The side of a block given without a size.
USUAL_MM = 25.0

# A block's numbers in mm; without a height it is as high as wide.
PARTS = "NAME X Y [WIDTH [HEIGHT]]"


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
    """Let every block fall onto what is under it; those in `floating` are held by fingers.

    A block stays where it lands, however little of it is supported: nothing topples.
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
    """Return the names of the blocks that stand on a block, directly or indirectly."""
    found = [carrier]
    for block in sorted(blocks.values(), key=lambda one: one.z_mm):
        if block.name not in found and any(_stands_on(block, blocks[name]) for name in found):
            found.append(block.name)
    return tuple(found[1:])


def _stands_on(block: TableBlock, under: TableBlock) -> bool:
    return abs(block.z_mm - under.top_mm) <= REST_MM and block.shares_ground(under)


class Table:
    """Blocks by name, and the hands above them. Hold `lock` while using any of it."""

    def __init__(self) -> None:
        self.lock = threading.RLock()
        self.blocks: dict[str, TableBlock] = {}
        self.hands: list[GripScene] = []

    def put(self, block: TableBlock) -> TableBlock:
        """Put a block down, or move the one of that name; return where it came to rest."""
        with self.lock:
            if block.name in self.blocks:
                self.take(block.name)
            self.blocks[block.name] = block
            self.settle()
            for hand in self.hands:
                hand.look()
            return self.blocks[block.name]

    def take(self, name: str) -> TableBlock:
        """Take a block away, even out of the fingers. Raises `BadRequest` if none has that name."""
        with self.lock:
            if name not in self.blocks:
                there = ", ".join(self.blocks) or "none"
                raise BadRequest(f"there is no block {name!r}; there are: {there}")
            for hand in self.hands:
                hand.forget(name)
            taken = self.blocks.pop(name)
            self.settle()
            return taken

    def shift(self, name: str, by: Point) -> None:
        """Move a block."""
        block = self.blocks[name]
        self.blocks[name] = block.at((block.x_mm + by[0], block.y_mm + by[1], block.z_mm + by[2]))

    def carried(self) -> set[str]:
        """Return the names of the blocks that any hand carries."""
        return {name for hand in self.hands for name in hand.carried}

    def settle(self) -> None:
        """Let every block that is not carried fall onto what is under it."""
        self.blocks = settled(self.blocks, self.carried())


@dataclass(frozen=True, slots=True)
class Stand:
    """Where an arm's base stands on a table: in mm, and turned about the vertical, in rad."""

    table: Table = field(default_factory=Table)
    x_mm: float = 0.0
    y_mm: float = 0.0
    turned_rad: float = 0.0

    def on_table(self, point: Point) -> Point:
        """Convert a point from the arm's base frame to the table's."""
        cos, sin = math.cos(self.turned_rad), math.sin(self.turned_rad)
        x, y, z = point
        return self.x_mm + cos * x - sin * y, self.y_mm + sin * x + cos * y, z

    def from_base(self, point: Point) -> Point:
        """Convert a point from the table's frame to the arm's base frame."""
        cos, sin = math.cos(self.turned_rad), math.sin(self.turned_rad)
        x, y, z = point[0] - self.x_mm, point[1] - self.y_mm, point[2]
        return cos * x + sin * y, cos * y - sin * x, z

    def seen(self) -> Mapping[str, TableBlock]:
        """Return the blocks in the arm's base frame."""
        placed = self.table.blocks.items()
        return {name: block.at(self.from_base(block.place)) for name, block in placed}


# --- Incidents: what goes wrong around an arm, unknown to any controller --------------------------


class IncidentKind(Enum):
    """What can go wrong in the world of the arm."""

    TABLE = "table touched"
    KNOCK = "block knocked"
    STOP = "mechanical stop"


@dataclass(frozen=True, slots=True)
class Incident:
    """An incident: what it happened to, when (s, on the device's clock), and a sentence."""

    kind: IncidentKind
    what: str
    sentence: str
    time_s: float


# --- The fingers of one arm: grip, carry, put down, knock over -----------------------------------
# The fingers are one point, the tip, with an opening. They surround a block if the tip entered it
# while they were open wider than the block. Anything else that runs into a block pushes it.

# How far below the table the tip may be: rounding to steps, and give in the table.
TABLE_TOLERANCE_MM = 1.5
_ROUNDING_MM = 1e-6  # tolerance for floating-point rounding


class GripScene:
    """How one arm's fingers act on the blocks of its table, and which block they hold.

    Points and blocks are passed in and out in the arm's base frame; internally, everything is in
    the table's frame. A block's footprint lies along the table's x and y, however the arm's base is
    turned.
    """

    def __init__(
        self,
        blocks: Iterable[TableBlock],
        held: str | None,
        tip: Point,
        opening_mm: float,
        stand: Stand | None = None,
    ) -> None:
        self._stand = stand or Stand()
        self._table = self._stand.table
        self.held: str | None = None
        """The name of the block that the fingers hold and carry."""
        self._offset: Point = (0.0, 0.0, 0.0)
        """From the tip to the held block."""
        self._around: set[str] = set()
        """The blocks between the open fingers: closing grips one of them."""
        self._touching: set[str] = set()
        """The blocks whose contact has been reported: a contact is one incident, however long."""
        self._tip = self._stand.on_table(tip)
        self._opening_mm = opening_mm
        with self._table.lock:
            self._table.hands.append(self)
            for block in blocks:
                self._blocks[block.name] = block.at(self._stand.on_table(block.place))
            if held is not None:
                self._hold(held)
            self._table.settle()
            self.look()

    @property
    def blocks(self) -> Mapping[str, TableBlock]:
        """All blocks by name."""
        with self._table.lock:
            return self._stand.seen()

    @property
    def carried(self) -> tuple[str, ...]:
        """The block that the fingers hold, and what stands on it."""
        return () if self.held is None else (self.held, *riders(self._blocks, self.held))

    @property
    def contact_mm(self) -> float:
        """The opening at which the fingers touch a block or each other."""
        if self.held is not None:
            return self._blocks[self.held].width_mm
        return max((self._blocks[name].width_mm for name in self._around), default=0.0)

    def put(self, block: TableBlock) -> TableBlock:
        """Put a block down, or move the one of that name; return where it came to rest."""
        put = self._table.put(block.at(self._stand.on_table(block.place)))
        return put.at(self._stand.from_base(put.place))

    def take(self, name: str) -> TableBlock:
        """Take a block away, even out of the fingers."""
        taken = self._table.take(name)
        return taken.at(self._stand.from_base(taken.place))

    def forget(self, name: str) -> None:
        """Forget a block that was taken away."""
        self.held = None if name == self.held else self.held
        self._around.discard(name)
        self._touching.discard(name)

    def look(self) -> None:
        """Find out what the fingers surround after things have been moved by hand."""
        for name, block in self._blocks.items():
            if name != self.held and block.contains(self._tip, -GRAZE_MM):
                wide = self._opening_mm >= block.width_mm - _ROUNDING_MM
                (self._around if wide else self._touching).add(name)

    # -- what the fingers do ------------------------------------------------------------------

    def follow(
        self, before: Point, after: Point, opening_mm: float, time_s: float
    ) -> list[Incident]:
        """Move the tip straight from one point to another, with the fingers at an opening.

        `opening_mm` is where the fingers' motor is, whatever is between them.
        """
        before, after = self._stand.on_table(before), self._stand.on_table(after)
        with self._table.lock:
            self._tip, self._opening_mm = after, opening_mm
            if not self._blocks:
                return []
            incidents = []
            if before != after:
                incidents = [*self._carry(time_s), *self._pass(before, time_s)]
            self.grip()
        return incidents

    def _carry(self, time_s: float) -> Iterator[Incident]:
        """Move the held block along, push those in its way, and let the others fall."""
        if self.held is None:
            return
        held, carried = self._blocks[self.held], self.carried
        shift = (
            self._tip[0] + self._offset[0] - held.x_mm,
            self._tip[1] + self._offset[1] - held.y_mm,
            self._tip[2] + self._offset[2] - held.z_mm,
        )
        for name in carried:
            self._table.shift(name, shift)
        held = self._blocks[self.held]
        for name, block in list(self._blocks.items()):
            if name not in carried and held.hits(block):
                yield from self._knock(name, shift, f"was hit by block {held.name}", time_s)
            elif name not in carried:
                self._touching.discard(name)
        self._table.settle()
        if held.z_mm >= -TABLE_TOLERANCE_MM:
            self._touching.discard(held.name)
        elif held.name not in self._touching:
            self._touching.add(held.name)
            sentence = f"block {held.name} was pressed {-held.z_mm:.1f} mm into the table"
            yield Incident(IncidentKind.TABLE, held.name, sentence, time_s)

    def _pass(self, before: Point, time_s: float) -> Iterator[Incident]:
        """Move the tip into, through and out of blocks."""
        carried = self.carried
        for name, block in list(self._blocks.items()):
            if name in carried:
                continue
            entered = block.entry(before, self._tip, -GRAZE_MM)
            if entered is not None and name not in self._around:
                if self._opening_mm > block.width_mm - _ROUNDING_MM and name not in self._touching:
                    self._around.add(name)
                else:
                    rest = 1.0 - entered
                    way = [(b - a) * rest for a, b in zip(before, self._tip, strict=True)]
                    push = (way[0], way[1], 0.0)
                    yield from self._knock(name, push, "was knocked by the fingers", time_s)
                    self._table.settle()
            if not self._blocks[name].contains(self._tip, GRAZE_MM):
                self._around.discard(name)
                if self.held is None:
                    self._touching.discard(name)

    def _knock(self, name: str, push: Point, how: str, time_s: float) -> Iterator[Incident]:
        """Push a block aside, and report it once for each contact."""
        self._table.shift(name, (push[0], push[1], 0.0))
        if name not in self._touching:
            self._touching.add(name)
            yield Incident(IncidentKind.KNOCK, name, f"block {name} {how}", time_s)

    def grip(self) -> None:
        """Close on a block that the fingers surround, or let go of the one they hold."""
        if self.held is not None:
            if self._opening_mm >= self._blocks[self.held].width_mm - _ROUNDING_MM:
                self.held = None
                for hand in self._table.hands:
                    hand.grip()
                self._table.settle()
            return
        others = self._table.carried()
        pressed = [
            block
            for block in map(self._blocks.__getitem__, self._around - others)
            if block.width_mm - _ROUNDING_MM > self._opening_mm
            and block.contains(self._tip, GRAZE_MM)
        ]
        if pressed:
            height = self._tip[2]
            self._hold(
                min(pressed, key=lambda one: abs(height - one.z_mm - one.height_mm / 2)).name
            )

    def _hold(self, name: str) -> None:
        """Hold a block where it is."""
        self.held = name
        place, tip = self._blocks[name].place, self._tip
        self._offset = (place[0] - tip[0], place[1] - tip[1], place[2] - tip[2])

    @property
    def _blocks(self) -> dict[str, TableBlock]:
        return self._table.blocks
