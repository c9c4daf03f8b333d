"""What a simulated TeachMover's controller knows, as plain numbers, beside its saved world."""

from __future__ import annotations

from typing import TYPE_CHECKING

from armdrive.errors import StateFileError
from armdrive.sim.saved import MEND, Json, Saved
from firmware_protocol.errors import ProtocolError
from firmware_protocol.teachmover import Key, ProgramRow

if TYPE_CHECKING:
    from armdrive.sim.teachmover_box import ControllerBox

_WORD = (1 << 16) - 1
_BYTE = 255
_ROW_WORDS = 8


def known_json(box: ControllerBox) -> dict[str, Json]:
    """Return the key pressed last, the outputs and the program."""
    return {
        "key": int(box.last_key),
        "outputs": box.outputs,
        "memory": [list(box.memory[number].words) for number in sorted(box.memory)],
    }


def recall_known(box: ControllerBox, saved: Saved) -> None:
    """Have a box know what `known_json` wrote; raises `StateFileError`."""
    key = Key(saved.whole("key", 0, max(Key)))
    outputs = saved.whole("outputs", 0, _BYTE)
    rows = [_row(item) for item in saved.items("memory")]
    box.last_key, box.outputs = key, outputs
    box.memory.update((row.number, row) for row in rows)


def _row(words: object) -> ProgramRow:
    row = Saved({"words": words}, "program").wholes("words", _ROW_WORDS, 0, _WORD)
    try:
        return ProgramRow.from_words(row)
    except ProtocolError as error:
        raise StateFileError(f"a saved program row cannot be read: {error}; {MEND}") from None
