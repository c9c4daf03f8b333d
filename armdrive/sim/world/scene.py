"""What stands on the table and what the fingers do to it: grip, carry, put down, knock over.

Lengths in mm. The fingers are one point, the tip, with an opening. They are around a block when
the tip came into it while they were open wider than the block; anything else that comes into a
block pushes it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from armdrive.sim.world.table import (
    GRAZE_MM,
    Incident,
    IncidentKind,
    Point,
    Stand,
    TableBlock,
    riders,
)

TABLE_TOLERANCE_MM = 1.5
"""How far below the table the tip may be: rounding to steps and the table's own give."""
_ROUNDING_MM = 1e-6


class GripScene:
    """What one arm's fingers have to do with the blocks of its table, and which one they hold.

    Points and blocks are told and shown in the arm's base frame; within, all is in the table's.
    A block's footprint lies along the table's x and y, however the arm's base is turned.
    """

    def __init__(
        self,
        blocks: Iterable[TableBlock] = (),
        held: str | None = None,
        tip: Point = (0.0, 0.0, 0.0),
        opening_mm: float = 0.0,
        stand: Stand | None = None,
    ) -> None:
        self._stand = stand or Stand()
        self._table = self._stand.table
        self._held: str | None = None
        self._offset: Point = (0.0, 0.0, 0.0)
        self._carried: tuple[str, ...] = ()
        self._around: set[str] = set()
        self._touching: set[str] = set()
        self._tip = self._stand.on_table(tip)
        self._opening_mm = opening_mm
        with self._table.lock:
            self._table.join(self)
            for block in blocks:
                self._blocks[block.name] = block.at(self._stand.on_table(block.place))
            if held is not None:
                self._hold(held)
            self._settle()
            self.look()

    @property
    def blocks(self) -> Mapping[str, TableBlock]:
        """Every block by its name."""
        with self._table.lock:
            return self._stand.seen()

    @property
    def held(self) -> str | None:
        """The name of the block between the fingers, if they hold one."""
        return self._held

    @property
    def carried(self) -> tuple[str, ...]:
        """The blocks that go where the fingers go; none while another arm holds theirs."""
        return self._carried

    @property
    def contact_mm(self) -> float:
        """The opening at which the fingers touch something: a block's width, or each other."""
        if self._held is not None:
            return self._blocks[self._held].width_mm
        return max((self._blocks[name].width_mm for name in self._around), default=0.0)

    def put(self, block: TableBlock, tip: Point, opening_mm: float) -> TableBlock:
        """Set a block down where it says, or on what is there; return where it came to rest."""
        self._tip, self._opening_mm = self._stand.on_table(tip), opening_mm
        put = self._table.put(block.at(self._stand.on_table(block.place)))
        return put.at(self._stand.from_base(put.place))

    def take(self, name: str, tip: Point, opening_mm: float) -> TableBlock | None:
        """Take a block away, out of the fingers if need be."""
        self._tip, self._opening_mm = self._stand.on_table(tip), opening_mm
        taken = self._table.take(name)
        return taken and taken.at(self._stand.from_base(taken.place))

    # -- what the table tells -----------------------------------------------------------------

    def forget(self, name: str) -> None:
        """Know nothing more of a block: it was taken away."""
        if name == self._held:
            self._let_go()
        self._carried = tuple(each for each in self._carried if each != name)
        self._around.discard(name)
        self._touching.discard(name)

    def look(self) -> None:
        """Find out what the fingers are around after things have been moved by hand."""
        for name, block in self._blocks.items():
            if name not in self._carried and block.contains(self._tip, -GRAZE_MM):
                wide = self._opening_mm >= block.width_mm - _ROUNDING_MM
                (self._around if wide else self._touching).add(name)

    def take_over(self) -> None:
        """Carry the block that the fingers grip, and what stands on it."""
        if self._held is None:
            return
        place, tip = self._blocks[self._held].place, self._tip
        self._offset = (place[0] - tip[0], place[1] - tip[1], place[2] - tip[2])
        free = [on for on in riders(self._blocks, self._held) if self._table.carrier(on) is None]
        self._carried = (self._held, *free)

    # -- what the fingers do ------------------------------------------------------------------

    def follow(
        self, before: Point, after: Point, opening_mm: float, time_s: float
    ) -> list[Incident]:
        """Let the tip go straight from one point to another, and the fingers stand as given.

        `opening_mm` is where the fingers' motor has them, whatever is between them.
        """
        before, after = self._stand.on_table(before), self._stand.on_table(after)
        with self._table.lock:
            self._tip, self._opening_mm = after, opening_mm
            incidents = list(self._carry(after, time_s))
            if before != after:
                incidents += self._pass(before, after, opening_mm, time_s)
            self._grip(after, opening_mm)
        return incidents

    def _carry(self, tip: Point, time_s: float) -> Iterator[Incident]:
        """Move what is held, and push what it runs into."""
        if self._held is None or not self._carried:  # else another arm holds it as well
            return
        held = self._blocks[self._held]
        place = (tip[0] + self._offset[0], tip[1] + self._offset[1], tip[2] + self._offset[2])
        shift = (place[0] - held.x_mm, place[1] - held.y_mm, place[2] - held.z_mm)
        if shift == (0.0, 0.0, 0.0):
            return
        for name in self._carried:
            self._shift(name, shift)
        yield from self._pull(time_s)
        yield from self._strike(self._held, (shift[0], shift[1], 0.0), time_s)
        held = self._blocks[self._held]
        if held.z_mm >= -TABLE_TOLERANCE_MM:
            self._touching.discard(held.name)
        elif held.name not in self._touching:
            self._touching.add(held.name)
            sentence = f"block {held.name} was pressed {-held.z_mm:.1f} mm into the table"
            yield Incident(IncidentKind.TABLE, held.name, sentence, time_s)

    def _pull(self, time_s: float) -> Iterator[Incident]:
        """Draw what is carried out of fingers that have closed on it as well, and hold still."""
        for hand in self._table.others(self):
            if isinstance(hand, GripScene) and hand.held in self._carried and not hand.reaches():
                sentence = f"block {hand.held} was pulled out of another arm's fingers"
                yield Incident(IncidentKind.KNOCK, hand.held or "", sentence, time_s)
                hand.forget(hand.held or "")

    def reaches(self) -> bool:
        """Tell whether the tip is still within the block that the fingers hold."""
        return self._held is not None and self._blocks[self._held].contains(self._tip, GRAZE_MM)

    def _strike(self, held: str, push: Point, time_s: float) -> Iterator[Incident]:
        for name, block in list(self._blocks.items()):
            if name in self._carried:
                continue
            if not self._blocks[held].hits(block):
                self._touching.discard(name)
                continue
            self._shift(name, push)
            if name not in self._touching:
                self._touching.add(name)
                sentence = f"block {name} was hit by block {held}"
                yield Incident(IncidentKind.KNOCK, name, sentence, time_s)
        self._settle()

    def _pass(
        self, before: Point, after: Point, opening_mm: float, time_s: float
    ) -> Iterator[Incident]:
        """Take the tip into, through and out of blocks."""
        for name, block in list(self._blocks.items()):
            if name in self._carried:
                continue
            entered = block.entry(before, after, -GRAZE_MM)
            if entered is not None and name not in self._around:
                if opening_mm > block.width_mm - _ROUNDING_MM and name not in self._touching:
                    self._around.add(name)
                else:
                    yield from self._push(name, before, after, entered, time_s)
            if not self._blocks[name].contains(after, GRAZE_MM):
                self._around.discard(name)
                if name == self._held:  # another arm carries it, and has kept it
                    self._let_go()
                if self._held is None:
                    self._touching.discard(name)

    def _push(
        self, name: str, before: Point, after: Point, entered: float, time_s: float
    ) -> Iterator[Incident]:
        """Shove a block ahead of the tip, from where the tip came into it."""
        rest = 1.0 - entered
        self._shift(name, ((after[0] - before[0]) * rest, (after[1] - before[1]) * rest, 0.0))
        self._settle()
        if name not in self._touching:
            self._touching.add(name)
            sentence = f"block {name} was knocked by the fingers"
            yield Incident(IncidentKind.KNOCK, name, sentence, time_s)

    def _grip(self, tip: Point, opening_mm: float) -> None:
        """Close on a block that the fingers are around, or let go of the one they hold."""
        if self._held is not None:
            if opening_mm >= self._blocks[self._held].width_mm - _ROUNDING_MM:
                self._let_go()
            return
        pressed = [
            block
            for block in map(self._blocks.__getitem__, self._around)
            if block.width_mm - _ROUNDING_MM > opening_mm and block.contains(tip, GRAZE_MM)
        ]
        if pressed:
            nearest = min(pressed, key=lambda one: abs(tip[2] - one.z_mm - one.height_mm / 2))
            self._hold(nearest.name)

    def _hold(self, name: str) -> None:
        """Have a block in the fingers, where it is: as they close on it, or from a saved world."""
        self._held = name
        self._around.add(name)
        if self._table.carrier(name) is None:
            self.take_over()

    def _let_go(self) -> None:
        self._held, self._carried = None, ()
        self._table.released()

    @property
    def _blocks(self) -> dict[str, TableBlock]:
        return self._table.blocks

    def _shift(self, name: str, by: Point) -> None:
        """Move a block that no other arm carries."""
        if name not in self._carried and self._table.carrier(name) is not None:
            return
        block = self._blocks[name]
        self._blocks[name] = block.at((block.x_mm + by[0], block.y_mm + by[1], block.z_mm + by[2]))

    def _settle(self) -> None:
        self._table.settle()
