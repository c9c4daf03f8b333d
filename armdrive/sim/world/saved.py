"""A world as plain numbers and texts, so that simulated arms can outlive a process."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum
from types import MappingProxyType
from typing import Any, TypeAlias, TypeVar

from armdrive.errors import BadRequest, StateFileError
from armdrive.sim.world import World
from armdrive.sim.world.body import ArmBody
from armdrive.sim.world.table import Incident, IncidentKind, TableBlock

# --- Strict reading: whatever does not fit is a `StateFileError` ---------------------------------

Json: TypeAlias = "bool | int | float | str | list[Json] | dict[str, Json] | None"
V = TypeVar("V")
STEPS_MOST = 10_000_000
"""Far more steps from zero than a motor of such an arm ever makes."""


class Saved:
    """A table of a saved state. Every key must be read; `end` refuses the rest."""

    def __init__(self, data: object, where: str) -> None:
        if not isinstance(data, Mapping):
            raise StateFileError(f"the saved {where} is no table; {MEND}")
        self._data: dict[object, object] = dict(data)
        self._where = where

    @property
    def data(self) -> Mapping[object, object]:
        """The entries that have not been read yet."""
        return MappingProxyType(self._data)

    def number(self, key: str) -> float:
        """Return a finite number."""
        value = self._take(key)
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise self._wrong(key, value, "a number")
        if not math.isfinite(value):
            raise self._wrong(key, value, "a finite number")
        return float(value)

    def whole(self, key: str, low: int, high: int) -> int:
        """Return a whole number within bounds."""
        value = self._take(key)
        if type(value) is not int or not low <= value <= high:
            raise self._wrong(key, value, f"a whole number from {low} to {high}")
        return value

    def wholes(self, key: str, count: int, low: int, high: int) -> tuple[int, ...]:
        """Return `count` whole numbers within bounds."""
        return self._each(
            key, count, "whole numbers", lambda saved, name: saved.whole(name, low, high)
        )

    def numbers(self, key: str, count: int) -> tuple[float, ...]:
        """Return `count` finite numbers."""
        return self._each(key, count, "numbers", Saved.number)

    def flag(self, key: str) -> bool:
        """Return true or false."""
        return self._typed(key, bool, "true or false")

    def text(self, key: str) -> str:
        """Return a text."""
        return self._typed(key, str, "a text")

    def text_or_none(self, key: str) -> str | None:
        """Return a text, or None if the entry is null."""
        if self._data.get(key, "") is None:
            del self._data[key]
            return None
        return self.text(key)

    def items(self, key: str) -> list[object]:
        """Return a list of anything."""
        return self._typed(key, list, "a list")

    def table(self, key: str) -> Saved:
        """Return a nested table."""
        return Saved(self._take(key), f"{self._where}.{key}")

    def has(self, key: str) -> bool:
        """Return whether an unread entry has this name."""
        return key in self._data

    def end(self) -> None:
        """Refuse entries that were never read."""
        if self._data:
            raise StateFileError(
                f"the saved {self._where} has an unknown entry {min(self._data, key=str)!r}; {MEND}"
            )

    def _take(self, key: str) -> object:
        if key not in self._data:
            raise StateFileError(f"the saved {self._where} lacks {key!r}; {MEND}")
        return self._data.pop(key)

    def _typed(self, key: str, kind: type[V], wanted: str) -> V:
        value = self._take(key)
        if not isinstance(value, kind):
            raise self._wrong(key, value, wanted)
        return value

    def _each(
        self, key: str, count: int, what: str, take: Callable[[Saved, str], V]
    ) -> tuple[V, ...]:
        values = self.items(key)
        if len(values) != count:
            raise self._wrong(key, values, f"{count} {what}")
        return tuple(take(Saved({key: value}, self._where), key) for value in values)

    def _wrong(self, key: str, value: object, wanted: str) -> StateFileError:
        return StateFileError(
            f"{key!r} of the saved {self._where} must be {wanted}, not {value!r:.60}; {MEND}"
        )


# --- Forms: how one value is written and read again, so that a table tells both -------------------


def _same(value: Any) -> Json:
    saved: Json = value
    return saved


@dataclass(frozen=True, slots=True)
class Form:
    """How a value is read from a saved state, and how it is written there."""

    read: Callable[[Saved, str], Any]
    write: Callable[[Any], Json] = _same


FLAG, TEXT, NUMBER = Form(Saved.flag), Form(Saved.text), Form(Saved.number)


def whole(low: int, high: int) -> Form:
    """Return the form of a whole number within bounds."""
    return Form(lambda saved, key: saved.whole(key, low, high))


BYTE = whole(0, 255)


def choice(kinds: type[Enum], what: str) -> Form:
    """Return the form of an enum member, written as its value."""

    def read(saved: Saved, key: str) -> Enum:
        text = saved.text(key)
        for kind in kinds:
            if kind.value == text:
                return kind
        raise StateFileError(f"{what} {text!r}; {MEND}")

    return Form(read, lambda kind: str(kind.value))


def write(one: object, forms: Mapping[str, Form]) -> dict[str, Json]:
    """Return the named attributes of an object, in the form in which they are saved."""
    return {name: form.write(getattr(one, name)) for name, form in forms.items()}


def read(saved: Saved, forms: Mapping[str, Form]) -> dict[str, Any]:
    """Return what `write` wrote. Raises `StateFileError`."""
    return {name: form.read(saved, name) for name, form in forms.items()}


MEND = "begin with a fresh simulated arm (--fresh)"
"""The advice given for a saved state that cannot be used."""

FORMAT = 1
_BLOCK = {
    "name": TEXT,
    **dict.fromkeys(("x_mm", "y_mm", "z_mm", "width_mm", "height_mm"), NUMBER),
}
_INCIDENT = {
    "kind": choice(IncidentKind, "no incident is of the kind"),
    "what": TEXT,
    "sentence": TEXT,
    "time_s": NUMBER,
}


def world_to_json(world: World) -> dict[str, Json]:
    """Return everything needed to recreate a world."""
    has_gripper = world.body.transmission.has_gripper
    return {
        "format": FORMAT,
        "arm": world.body.key,
        "motors": list(world.motors),
        "energised": world.energised,
        **({"play_taken": list(world.play.ahead)} if world.play.any else {}),
        **({} if has_gripper else {"fingers_mm": world.fingers_mm}),
        "blocks": [block_to_json(block) for block in world.scene.blocks.values()],
        "held": world.scene.held,
        "incidents": [incident_to_json(incident) for incident in world.incidents],
    }


def world_from_json(data: object, body: ArmBody | None = None) -> World:
    """Recreate a world.

    Raises `StateFileError` if the data do not fit this arm or contradict themselves.
    """
    saved = Saved(data, "world")
    saved.whole("format", FORMAT, FORMAT)
    world = World(body)
    key = saved.text("arm")
    if key != world.body.key:
        raise StateFileError(f"the saved world is of a {key}, not of a {world.body.key}; {MEND}")
    count = len(world.body.transmission.motors)
    world = World(body, saved.wholes("motors", count, -STEPS_MOST, STEPS_MOST))
    world.energised = saved.flag("energised")
    if saved.has("play_taken"):
        taken = saved.wholes("play_taken", count, 0, STEPS_MOST)
        world.play.stand(taken)
    if not world.body.transmission.has_gripper:
        world.move_fingers(saved.number("fingers_mm"))
    blocks = [_block(item) for item in saved.items("blocks")]
    if len({block.name for block in blocks}) < len(blocks):
        raise StateFileError(f"two blocks of the saved world have the same name; {MEND}")
    held = saved.text_or_none("held")
    if held is not None and held not in {block.name for block in blocks}:
        raise StateFileError(f"the saved world holds {held!r}, which is no block of it; {MEND}")
    world.restore_blocks(blocks, held)
    world.incidents = [_incident(item) for item in saved.items("incidents")]
    saved.end()
    return world


def block_to_json(block: TableBlock) -> dict[str, Json]:
    """Return a block's name, position and size."""
    return write(block, _BLOCK)


def incident_to_json(incident: Incident) -> dict[str, Json]:
    """Return an incident as plain data."""
    return write(incident, _INCIDENT)


def _block(data: object) -> TableBlock:
    saved = Saved(data, "block")
    try:
        block = TableBlock(**read(saved, _BLOCK))
    except BadRequest as error:
        raise StateFileError(f"{error}; {MEND}") from None
    saved.end()
    return block


def _incident(data: object) -> Incident:
    saved = Saved(data, "incident")
    incident = Incident(**read(saved, _INCIDENT))
    saved.end()
    return incident
