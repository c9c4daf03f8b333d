"""The drives of a simulated arm as plain data: what is to be seen of them, and what is kept."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TypeVar

from armdrive.errors import StateFileError
from armdrive.sim.cia402_habits import Homing
from armdrive.sim.cia402_node import Node
from armdrive.sim.cia402_objects import watched
from armdrive.sim.cia402_status import LIVE, status
from armdrive.sim.saved import MEND, Json, Saved
from firmware_protocol.canopen import (
    ERROR_CODE,
    MODE,
    NODE_MAX,
    QUICK_STOP_OPTION,
    Command,
    Controlword,
    DriveState,
    Happening,
    Nmt,
    NmtCommand,
    NodeState,
    Place,
    QuickStopOption,
)
from firmware_protocol.errors import ProtocolError

S = TypeVar("S")

_SHUT_DOWN, _ON = Command.SHUT_DOWN, Command.SWITCH_ON
_ENABLE, _STOP = Command.ENABLE_OPERATION, Command.QUICK_STOP
_WAYS: dict[DriveState, tuple[Command, ...]] = {
    DriveState.DISABLED: (),
    DriveState.READY: (_SHUT_DOWN,),
    DriveState.SWITCHED_ON: (_SHUT_DOWN, _ON),
    DriveState.ENABLED: (_SHUT_DOWN, _ENABLE),
    DriveState.QUICK_STOP: (_SHUT_DOWN, _ENABLE, _STOP),
    DriveState.FAULT: (),
}
"""How a drive comes to the state in which it was saved."""
_ORDERS = {
    NodeState.OPERATIONAL: NmtCommand.START,
    NodeState.STOPPED: NmtCommand.STOP,
}
_STATES = {state.name.lower(): state for state in _WAYS}
_TALKS = {state.name.lower(): state for state in (NodeState.PRE_OPERATIONAL, *_ORDERS)}


def known_json(nodes: Sequence[Node]) -> dict[str, Json]:
    """Return what each drive is, and what its objects hold that they do not at first."""
    return {"drives": [_known(node) for node in nodes]}


def seen_json(node: Node, error: int, now_s: float) -> dict[str, Json]:
    """Return what a drive would tell of itself, and how far its shaft is from its set-point."""
    watch = watched(node)
    return {
        "id": node.number,
        "powered": node.powered,
        "nmt": node.nmt.state.name.lower(),
        "state": node.state.name.lower(),
        "mode": node.mode,
        "statusword": f"{status(node, now_s).value:04X}",
        "error_code": f"{node.number_of(ERROR_CODE, 0):04X}",
        "rate": round(node.point.rate(now_s), 2),
        "error_counts": error,
        "homed": node.homing is Homing.DONE,
        "watch_s": 0.0 if watch is None else watch.silence_ms / 1000,
        "watch_stops": node.watch_stops,
    }


def recall_known(nodes: Sequence[Node], saved: Saved, *, powered: bool) -> None:
    """Know again what `known_json` wrote. Raises `StateFileError`."""
    drives = saved.items("drives")
    if len(drives) != len(nodes):
        raise StateFileError(
            f"{len(drives)} drives are saved of an arm that has {len(nodes)}; {MEND}"
        )
    for node, item in zip(nodes, drives, strict=True):
        _recall(node, Saved(item, f"drive {node.index + 1}"), powered=powered)


def _known(node: Node) -> dict[str, Json]:
    state = DriveState.FAULT if node.state is DriveState.FAULT_REACTION else node.state
    leaves = state is DriveState.QUICK_STOP and not node.machine.quick_stop.stays
    booting = node.nmt.state is NodeState.BOOTING
    talks = NodeState.PRE_OPERATIONAL if booting else node.nmt.state
    return {
        "id": node.number,
        "powered": node.powered,
        "nmt": talks.name.lower(),
        "state": (DriveState.DISABLED if leaves else state).name.lower(),
        "homed": node.homing is Homing.DONE,
        "ailing": [*sorted(node.ailing)],
        "objects": _changed(node),
    }


def _changed(node: Node) -> dict[str, Json]:
    """Return the objects that are not as they are at first, as they are on the bus."""
    changed: dict[str, Json] = {}
    store = node.stored()
    for entry in node.dictionary:
        value = store.value(entry.place)
        if entry.place not in LIVE and value is not None and value != entry.initial(node.number):
            changed[f"{entry.place.index:04X}:{entry.place.sub:02X}"] = entry.type.pack(value).hex()
    return changed


def _recall(node: Node, saved: Saved, *, powered: bool) -> None:
    node.number = saved.whole("id", 1, NODE_MAX)
    node.powered = saved.flag("powered") and powered
    homed = saved.flag("homed")
    node.ailing = {code for code in saved.items("ailing") if isinstance(code, int)}
    node.renew()
    _recall_objects(node, saved.table("objects"))
    _recall_talk(node, _of(_TALKS, saved.text("nmt")))
    _recall_state(node, _of(_STATES, saved.text("state")))
    node.homing = Homing.DONE if homed else Homing.NONE
    saved.end()


def _recall_objects(node: Node, saved: Saved) -> None:
    for key in [*saved.data]:
        text = saved.text(str(key))
        try:
            index, sub = (int(part, 16) for part in str(key).split(":"))
            entry = node.dictionary.find(Place(index, sub))
            value = None if entry is None else entry.type.unpack(bytes.fromhex(text))
        except (ProtocolError, ValueError):
            value = None
        if value is None:
            raise StateFileError(f"a saved drive's object {key} cannot be {text!r:.60}; {MEND}")
        node.store.set(Place(index, sub), value)
    node.mode = node.number_of(MODE, 0)
    node.machine.quick_stop = QuickStopOption(node.number_of(QUICK_STOP_OPTION, 2))


def _recall_talk(node: Node, state: NodeState) -> None:
    node.nmt.booted()
    if state in _ORDERS:
        node.nmt.receive_frame(Nmt(_ORDERS[state], node.number).frame)
    node.pdos.rebuild()
    node.beat_on(node.drive.rack.now_s)


def _recall_state(node: Node, state: DriveState) -> None:
    """Be as a saved drive was; nothing comes down for it, as that has been saved too."""
    if state is DriveState.FAULT:
        node.machine.happen(Happening.FAULT)
        node.machine.happen(Happening.REACTED)
        if not node.ailing:
            node.machine.mend()
    for command in _WAYS[state]:
        node.machine.control(Controlword.of(command))
    node.drive.holding[node.index] = node.powered and node.state.holds
    node.drive.world.energised = all(node.drive.holding)
    node.goal = node.counts


def _of(names: Mapping[str, S], text: str) -> S:
    if text not in names:
        raise StateFileError(f"a saved drive cannot be {text!r:.60}; {MEND}")
    return names[text]
