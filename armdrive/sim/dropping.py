"""Reads which block somebody puts on the table of a simulated arm: its name, place and size."""

from __future__ import annotations

from collections.abc import Sequence

from armdrive.errors import BadRequest
from armdrive.sim.blocks import Block
from armdrive.sim.fault_request import number

DROP_FROM_MM = 1000.0
"""A block comes down from above everything, onto what is there."""

USUAL_MM = 25.0
"""The side of a block of which no size is said."""

PARTS = "NAME X Y [WIDTH [HEIGHT]]"
"""What is said of a block, mm; the height is the width where it is left out."""


def block_of(words: Sequence[str]) -> Block:
    """Return a block above the table, from three to five words. Raises `BadRequest`."""
    if not 3 <= len(words) <= 5:
        raise BadRequest(f"a block is given as {PARTS}, not as {' '.join(words)!r}")
    x_mm, y_mm, *sizes = (number(word) for word in words[1:])
    width_mm = sizes[0] if sizes else USUAL_MM
    height_mm = sizes[1] if len(sizes) > 1 else width_mm
    return Block(words[0], x_mm, y_mm, DROP_FROM_MM, width_mm, height_mm)
