"""What a simulated GRBL board knows, as plain numbers and texts, beside its saved world."""

from __future__ import annotations

from typing import TYPE_CHECKING

from armdrive.errors import StateFileError
from armdrive.sim.grbl_parser import STORED
from armdrive.sim.saved import MEND, Json, Saved
from firmware_protocol.grbl import State

if TYPE_CHECKING:
    from armdrive.sim.grbl_board import Board

_PORT_MOST = 255


def known_json(board: Board) -> dict[str, Json]:
    """Return what is in the EEPROM, the outputs, and whether the board is locked."""
    locked = board.state in (State.ALARM, State.SLEEP)
    settings: dict[str, Json] = {str(key): value for key, value in board.settings.values.items()}
    offsets: dict[str, Json] = {name: list(board.parser.stored[name]) for name in STORED}
    return {
        "axes": board.axes,
        "state": str(State.ALARM if locked else State.IDLE),
        "settings": settings,
        "offsets": offsets,
        "startup": list(board.startup),
        "note": board.note,
        "outputs": board.outputs.to_json(),
    }


def recall_known(board: Board, saved: Saved) -> None:
    """Have a board know what `known_json` wrote; raises `StateFileError`."""
    if saved.text("axes") != board.axes:
        raise StateFileError(f"the saved board has other axes than {board.axes}; {MEND}")
    state = saved.text("state")
    if state not in (State.ALARM, State.IDLE):
        raise StateFileError(f"no board is saved in the state {state!r}; {MEND}")
    settings = saved.table("settings")
    values = {key: settings.number(str(key)) for key in board.settings.values}
    settings.end()
    offsets = saved.table("offsets")
    stored = {name: _place(offsets, name, len(board.axes)) for name in STORED}
    offsets.end()
    startup = [_line(item) for item in saved.items("startup")]
    if len(startup) != len(board.startup):
        raise StateFileError(f"a board has {len(board.startup)} startup lines; {MEND}")
    note = saved.text("note")
    _recall_outputs(board, saved.table("outputs"))
    board.settings.values.update(values)
    board.drive.rack.limits = board.settings.limits()
    board.parser.stored = stored
    board.parser.restart(board.drive.units_of(board.drive.rack.goal))
    board.startup[:] = startup
    board.note = note
    board.state = State(state)


def _place(saved: Saved, name: str, axes: int) -> tuple[float, ...]:
    items = saved.items(name)
    wanted = [Saved({"at": item}, "offset").number("at") for item in items]
    if len(wanted) != axes:
        raise StateFileError(f"the saved {name} needs {axes} numbers; {MEND}")
    return tuple(wanted)


def _line(item: object) -> str:
    return Saved({"line": item}, "startup").text("line")


def _recall_outputs(board: Board, saved: Saved) -> None:
    outputs = board.outputs
    outputs.spindle, outputs.speed = saved.text("spindle"), saved.number("speed")
    outputs.flood, outputs.mist = saved.flag("flood"), saved.flag("mist")
    digital, analog = saved.table("digital"), saved.table("analog")
    ports = [str(port) for port in range(_PORT_MOST + 1)]
    outputs.digital = {int(p): digital.flag(p) for p in ports if p in digital.data}
    outputs.analog = {int(p): analog.number(p) for p in ports if p in analog.data}
    for table in (digital, analog, saved):
        table.end()
