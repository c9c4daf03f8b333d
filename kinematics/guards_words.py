"""What each broken guard says to a person: a table of sentences. Lengths in mm."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING

from kinematics.guards_found import Reading
from kinematics.guards_links import AGAINST_ITSELF, BASE_COLUMN, BOX

if TYPE_CHECKING:
    from kinematics.guards import GuardedArm, Guards


def sentence_of(reading: Reading, guarded: GuardedArm) -> str:
    """Return the sentence of a guard that this reading breaks."""
    kind = BOX if reading.guard.startswith(BOX) else reading.guard
    return _SENTENCES[kind](reading, guarded.guards)


def _table(reading: Reading, _: Guards) -> str:
    point = reading.quantity.removesuffix(" z")
    return f"the {point} would be {-reading.value_mm:.1f} mm below the table"


def _inner(reading: Reading, guards: Guards) -> str:
    return (
        f"the tip would be {reading.value_mm:.1f} mm from the base axis, inside the arm's body: "
        f"below z {guards.inner_height_mm:.0f} mm it must keep {reading.bound_mm:.0f} mm away"
    )


def _outer(reading: Reading, _: Guards) -> str:
    return (
        f"the tip would be {reading.value_mm:.1f} mm from the base axis, "
        f"beyond the guard at {reading.bound_mm:.0f} mm"
    )


def _hand(reading: Reading, _: Guards) -> str:
    return (
        f"the hand would hit the base: it points backwards with the wrist {reading.value_mm:.1f} "
        f"mm from the base axis, where {reading.bound_mm:.0f} mm are needed"
    )


def _box(reading: Reading, _: Guards) -> str:
    name = reading.guard.removeprefix(BOX)
    return f"the {reading.quantity} would be {-reading.value_mm:.1f} mm inside the box {name!r}"


def _base(reading: Reading, guards: Guards) -> str:
    return (
        f"the {reading.quantity} would be {-reading.value_mm:.1f} mm inside the base column "
        f"(radius {guards.base_radius_mm or 0.0:g} mm, up to z {guards.base_top_mm:g} mm)"
    )


def _itself(reading: Reading, _: Guards) -> str:
    one, other = reading.quantity.split(" against ")
    return f"the {one} would be {-reading.value_mm:.1f} mm inside {other}"


_SENTENCES: Mapping[str, Callable[[Reading, Guards], str]] = MappingProxyType(
    {
        "table": _table,
        "inner radius": _inner,
        "outer radius": _outer,
        "hand against base": _hand,
        BOX: _box,
        BASE_COLUMN: _base,
        AGAINST_ITSELF: _itself,
    }
)
