"""A simulated arm on CiA 402 drives on one bus: how they are saved, and turn the arm."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import ClassVar, TypeVar

from armdrive.errors import BadRequest, StateFileError
from armdrive.sim.bus.drives import DrivesBox
from armdrive.sim.cia402.messages import (
    LIVE,
    due_s,
    hear,
    listens_to,
    live,
    minds_shaft,
    status,
    tell_changes,
)
from armdrive.sim.cia402.motion import set_mode
from armdrive.sim.cia402.node import Cia402Node, Homing
from armdrive.sim.cia402.states import fault, react, say
from armdrive.sim.cia402.writes import watched
from armdrive.sim.world.saved import MEND, Json, Saved
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
    OperationMode,
    Place,
    QuickStopOption,
)
from firmware_protocol.errors import ProtocolError
from firmware_protocol.frames import Frame

# --- The drives as plain data --------------------------------------------------------------------

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


def known_json(nodes: Sequence[Cia402Node]) -> dict[str, Json]:
    """Return what each drive is, and what its objects hold that they do not at first."""
    return {"drives": [_known(node) for node in nodes]}


def seen_json(node: Cia402Node, error: int, now_s: float) -> dict[str, Json]:
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


def recall_known(nodes: Sequence[Cia402Node], saved: Saved, *, powered: bool) -> None:
    """Know again what `known_json` wrote. Raises `StateFileError`."""
    drives = saved.items("drives")
    if len(drives) != len(nodes):
        raise StateFileError(
            f"{len(drives)} drives are saved of an arm that has {len(nodes)}; {MEND}"
        )
    for node, item in zip(nodes, drives, strict=True):
        _recall(node, Saved(item, f"drive {node.index + 1}"), powered=powered)


def _known(node: Cia402Node) -> dict[str, Json]:
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


def _changed(node: Cia402Node) -> dict[str, Json]:
    """Return the objects that are not as they are at first, as they are on the bus."""
    changed: dict[str, Json] = {}
    store = node.stored()
    for entry in node.dictionary:
        value = store.value(entry.place)
        if entry.place not in LIVE and value is not None and value != entry.initial(node.number):
            changed[f"{entry.place.index:04X}:{entry.place.sub:02X}"] = entry.type.pack(value).hex()
    return changed


def _recall(node: Cia402Node, saved: Saved, *, powered: bool) -> None:
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


def _recall_objects(node: Cia402Node, saved: Saved) -> None:
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


def _recall_talk(node: Cia402Node, state: NodeState) -> None:
    node.nmt.booted()
    if state in _ORDERS:
        node.nmt.receive_frame(Nmt(_ORDERS[state], node.number).frame)
    node.pdos.rebuild()
    node.beat_on(node.drive.rack.now_s)


def _recall_state(node: Cia402Node, state: DriveState) -> None:
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


class SimCia402(DrivesBox[Cia402Node]):
    """The drives, the arm, and the person beside them. Input bit n is the switch of drive n."""

    title: ClassVar[str] = "arm on CiA 402 drives"

    @property
    def busy(self) -> bool:
        """Whether a motion is under way or a frame on its way."""
        return self.moving or self._outbox.next_s < math.inf

    def set_drive_id(self, drive: int, node: int) -> int:
        """Give a drive a node id, another one's perhaps; return the old. Raises `BadRequest`.

        As by its switches: its communication begins anew with it.
        """
        one = self._node(drive)
        if not 1 <= node <= NODE_MAX:
            raise BadRequest(f"node ids are 1 to {NODE_MAX}, not {node}")
        before = one.number
        react(one, self.now_s)
        one.renew_talk(node, self.now_s)
        self._collect()
        return before

    def set_drive_mode(self, drive: int, mode: int) -> int:
        """Give a drive a mode, as by its maker's program; return the old. Raises `BadRequest`."""
        one, modes = self._node(drive), [*OperationMode]
        if mode not in modes:
            raise BadRequest(f"modes are {', '.join(str(int(each)) for each in modes)}, not {mode}")
        before = one.mode
        one.keep(MODE, mode)
        set_mode(one, mode, self.now_s)
        self._collect()
        return before

    def withhold_done(self, drive: int, withheld: bool) -> None:
        """Have a drive not say that a target is reached, or say it again."""
        self._node(drive).withheld = withheld

    def ail_drive(self, drive: int, code: int) -> None:
        """Have something be wrong with a drive: it fails, until it is mended and reset."""
        node = self._node(drive)
        if node.powered:
            node.ailing.add(code)
            fault(node, code, self.now_s)
            self._collect()

    def mend_drive(self, drive: int, code: int) -> None:
        """Have what was wrong with a drive be right again; its fault is to be reset yet."""
        node = self._node(drive)
        node.ailing.discard(code)
        if not node.ailing:
            node.machine.mend()

    def warn_drive(self, drive: int, code: int) -> None:
        """Have a drive say an EMCY that changes nothing."""
        say(self._node(drive), code)
        self._collect()

    # The box.

    def _found(self) -> None:
        for node in self.nodes:
            node.nmt.booted()  # it has said so long ago

    def _listens(self, node: Cia402Node, frame: Frame) -> bool:
        return listens_to(node, frame.can_id)

    def _bring(self, node: Cia402Node, frame: Frame) -> None:
        if minds_shaft(node, frame.can_id):
            self._shafts.look(self.now_s)
            live(node, self.now_s)
        hear(node, frame, self.now_s)
        tell_changes(node, self.now_s)

    def happen(self) -> None:
        """Let the drives do what is due, and send what is ready."""
        if min(self._nodes_due_s, self._look_s) <= self.now_s:
            super().happen()
        else:  # a frame is ready, and no drive has anything to do
            self.said += self._outbox.take(self.now_s)

    def _next_of(self, node: Cia402Node) -> float:
        return due_s(node)

    def _live_through(self, node: Cia402Node) -> None:
        live(node, self.now_s)

    def _seen(self, node: Cia402Node, error: int) -> dict[str, Json]:
        return seen_json(node, error, self.now_s)

    def known(self) -> dict[str, Json]:
        """Return what the drives know."""
        return known_json(self.nodes)

    def recall_known(self, saved: Saved) -> None:
        """Know what `known` wrote; raises `StateFileError`."""
        recall_known(self.nodes, saved, powered=self.powered)
