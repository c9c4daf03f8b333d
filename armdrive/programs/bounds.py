"""Whether a number is in the bounds of what takes it.

Constants are looked at before a program runs, everything else when it has been computed.
"""

from __future__ import annotations

from collections.abc import Sequence

from armdrive.programs.values import said
from armdrive.programs.vocabulary import Slot


def slot_of(slots: Sequence[Slot], index: int) -> Slot | None:
    """Return the slot of the value at an index; None where there are too many values."""
    if index < len(slots):
        return slots[index]
    return slots[-1] if slots and slots[-1].many else None


def fewest(slots: Sequence[Slot]) -> int:
    """Return how many values there have to be."""
    return sum(not slot.optional for slot in slots)


def out_of_bounds(slot: Slot, value: float) -> str | None:
    """Return why a slot does not take a number, None where it does."""
    shown = said(value)
    if slot.whole and value != int(value):
        return f"{slot.title} has to be a whole number, not {shown}"
    if slot.not_zero and value == 0.0:
        return f"{slot.title} counts from 1, 0 is none"
    if slot.above is not None and value <= slot.above:
        return f"{slot.title} has to be above {said(slot.above)}, not {shown}"
    if slot.least is not None and value < slot.least:
        return f"{slot.title} is at least {said(slot.least)}, not {shown}"
    if slot.most is not None and value > slot.most:
        return f"{slot.title} is at most {said(slot.most)}, not {shown}{_meant(slot, value)}"
    return None


def _meant(slot: Slot, value: float) -> str:
    return f"; was {said(value)}% meant?" if slot.most == 1.0 and 1.0 < value <= 100.0 else ""
