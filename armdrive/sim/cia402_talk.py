"""What a simulated CiA 402 drive hears: NMT, SYNC, PDOs, SDO, and its master's heartbeat."""

from __future__ import annotations

import math

from armdrive.sim.cia402_errors import PDO_TOO_SHORT, over, say
from armdrive.sim.cia402_node import Node
from armdrive.sim.cia402_objects import refusal, watched, written
from armdrive.sim.cia402_pdos import AT_CHANGE, Pdo
from armdrive.sim.cia402_reacting import react
from armdrive.sim.cia402_status import LIVE, read
from firmware_protocol.canopen import (
    AbortCode,
    DriveState,
    NmtCommand,
    ReadAsked,
    Service,
    WriteAsked,
    cob_id,
)
from firmware_protocol.errors import BadField, RemoteProtocolError
from firmware_protocol.frames import Frame

NMT, SYNC = cob_id(Service.NMT), cob_id(Service.SYNC)
_SDO, _HEARTBEAT = 0x600, 0x700
_HEARTBEATS = range(0x701, 0x780)


def listens_to(node: Node, can_id: int) -> bool:
    """Tell whether a drive takes a frame of an id from the bus."""
    if not (node.powered and node.plugged):
        return False
    if can_id in (NMT, SYNC, _SDO + node.number) or can_id in node.pdos.received:
        return True
    return can_id in _HEARTBEATS


def minds_shaft(node: Node, can_id: int) -> bool:
    """Tell whether what a frame asks for depends on where the shaft is at this very moment."""
    return can_id in (SYNC, _SDO + node.number)


def hear(node: Node, frame: Frame, now_s: float) -> None:
    """Take a frame that it listens to."""
    if frame.extended or frame.remote or node.booting:
        return
    if frame.can_id == SYNC:
        _beat(node, now_s)
    elif frame.can_id in node.pdos.received:
        _take_pdo(node, node.pdos.received[frame.can_id], frame.data, now_s)
    elif frame.can_id == _SDO + node.number:
        _serve(node, frame, now_s)
    elif frame.can_id == NMT:
        _order(node, frame, now_s)
    else:
        _heartbeat(node, frame.can_id - _HEARTBEAT, now_s)


def tell_changes(node: Node, now_s: float) -> None:
    """Send the PDOs that go by themselves, where something has changed or their time has come."""
    if not node.nmt.takes("pdo"):
        return
    for pdo in node.pdos.transmitted:
        if not pdo.synchronous:
            data = _packed(node, pdo, now_s)
            if pdo.free_s <= now_s and (data != pdo.data or pdo.due_s <= now_s):
                _send(node, pdo, data, now_s)
            elif data != pdo.data:
                pdo.due_s = min(pdo.due_s, pdo.free_s)


# SYNC and PDOs.


def _beat(node: Node, now_s: float) -> None:
    """Tell how it stands at this moment, and only then do what was handed over before it."""
    if not node.nmt.takes("pdo"):
        return
    for pdo in node.pdos.transmitted:
        if pdo.synchronous:
            _send_in_turn(node, pdo, now_s)
    for pdo in node.pdos.received.values():
        if pdo.synchronous and pdo.data:
            data, pdo.data = pdo.data, b""
            _act(node, pdo, data, now_s)


def _send_in_turn(node: Node, pdo: Pdo, now_s: float) -> None:
    data = _packed(node, pdo, now_s)
    pdo.beats += 1
    if pdo.transmission == AT_CHANGE and data == pdo.data:
        return
    if pdo.beats >= pdo.transmission:
        pdo.beats = 0
        _send(node, pdo, data, now_s)


def _packed(node: Node, pdo: Pdo, now_s: float) -> bytes:
    return pdo.pack([read(node, place, now_s) for place in pdo.places])


def _send(node: Node, pdo: Pdo, data: bytes, now_s: float) -> None:
    node.say((Frame(pdo.can_id, data),))
    pdo.data = data
    pdo.free_s = now_s + pdo.inhibit_s
    if not pdo.synchronous:
        pdo.due_s = max(now_s + pdo.event_s, pdo.free_s) if pdo.event_s else math.inf


def _take_pdo(node: Node, pdo: Pdo, data: bytes, now_s: float) -> None:
    if not node.nmt.takes("pdo"):
        return
    if len(data) < pdo.size:
        say(node, PDO_TOO_SHORT)
    elif pdo.synchronous:
        pdo.data = data
    else:
        _act(node, pdo, data, now_s)


def _act(node: Node, pdo: Pdo, data: bytes, now_s: float) -> None:
    """Take over what a PDO has brought; a value that an object may not have is left out."""
    taken = []
    for place, value in zip(pdo.places, pdo.unpack(data), strict=True):
        if refusal(node, place, value) is None:
            node.keep(place, value)
            taken.append(place)
    written(node, taken, now_s)


# SDO.


def _serve(node: Node, frame: Frame, now_s: float) -> None:
    if not node.nmt.takes("sdo"):
        return
    said = [node.sdo.receive_frame(frame)]
    while (event := node.sdo.next_event()) is not None:
        if isinstance(event, ReadAsked):
            said.append(_tell(node, event, now_s))
        elif isinstance(event, WriteAsked):
            said.append(_take(node, event, now_s))
    node.say(said)


def _tell(node: Node, ask: ReadAsked, now_s: float) -> Frame | None:
    if ask.place in LIVE:
        node.keep(ask.place, LIVE[ask.place](node, now_s))
    return node.stored().answer(node.sdo, ask)


def _take(node: Node, ask: WriteAsked, now_s: float) -> Frame | None:
    entry = node.dictionary.find(ask.place)
    try:
        value = None if entry is None else entry.type.unpack(ask.data, exact=ask.exact)
    except (BadField, RemoteProtocolError):
        value = None  # the store says what is wrong with it
    refused: AbortCode | None = None
    if entry is not None and entry.access.writable and value is not None:
        refused = refusal(node, ask.place, value)
    refused = refused or node.write(ask.place, ask.data, exact=ask.exact)
    if refused is not None:
        return node.sdo.refuse(ask, refused)
    accepted = node.sdo.accept(ask)
    written(node, (ask.place,), now_s)
    return accepted


# NMT and heartbeats.


def _order(node: Node, frame: Frame, now_s: float) -> None:
    order = node.nmt.receive_frame(frame)
    if order is NmtCommand.START:
        node.pdos.rebuild()
    elif order is NmtCommand.STOP:
        react(node, now_s)
    elif order is NmtCommand.RESET_NODE:
        node.restart(now_s)
    elif order is NmtCommand.RESET_COMMUNICATION:
        react(node, now_s)
        node.renew_talk(node.number, now_s)


def _heartbeat(node: Node, sender: int, now_s: float) -> None:
    watch = watched(node)
    if watch is None or watch.node != sender:
        return
    node.silent_s = now_s + watch.silence_ms / 1000
    if node.forsaken:
        node.forsaken = False
        if node.state not in (DriveState.FAULT, DriveState.FAULT_REACTION):
            over(node)
