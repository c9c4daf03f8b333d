"""A simulated TeachMover as plain numbers and texts: its world, and what its controller knows."""

from __future__ import annotations

from armdrive.errors import StateFileError
from armdrive.sim.body import ArmBody
from armdrive.sim.saved import MEND, Json, Saved
from armdrive.sim.teachmover import BAUD, SimTeachMover
from armdrive.sim.world_file import world_from_json, world_to_json
from firmware_protocol.errors import ProtocolError
from firmware_protocol.teachmover import Key, ProgramRow

_WORD = (1 << 16) - 1
_REGISTER = 1 << 15
_BYTE = 255
_ROW_WORDS = 8


def device_to_json(device: SimTeachMover) -> dict[str, Json]:
    """Return everything that a standing device needs to be made again.

    A motion under way is not saved: the arm stands where the motion had brought it.
    """
    return {
        "world": world_to_json(device.world),
        "powered": device.powered,
        "registers": list(device.registers),
        "key": int(device.last_key),
        "inputs": device.inputs_set,
        "outputs": device.outputs,
        "memory": [list(device.memory[number].words) for number in sorted(device.memory)],
    }


def device_from_json(
    data: object,
    body: ArmBody | None = None,
    *,
    speed_error: float = 0.0,
    baud: int = BAUD,
    grip_bit: int = 0,
) -> SimTeachMover:
    """Make a device again; raises `StateFileError` for what no such device has saved."""
    saved = Saved(data, "simulated TeachMover")
    world = world_from_json(saved.table("world").data, body)
    device = SimTeachMover(world, speed_error=speed_error, baud=baud, grip_bit=grip_bit)
    counts = saved.wholes("registers", len(world.motors), -_REGISTER, _REGISTER - 1)
    key = Key(saved.whole("key", 0, max(Key)))
    inputs, outputs = saved.whole("inputs", 0, _BYTE), saved.whole("outputs", 0, _BYTE)
    rows = [_row(item) for item in saved.items("memory")]
    device.powered = saved.flag("powered")
    saved.end()
    device.restore(counts, key, inputs, outputs, rows)
    return device


def _row(words: object) -> ProgramRow:
    row = Saved({"words": words}, "program").wholes("words", _ROW_WORDS, 0, _WORD)
    try:
        return ProgramRow.from_words(row)
    except ProtocolError as error:
        raise StateFileError(f"a saved program row cannot be read: {error}; {MEND}") from None
