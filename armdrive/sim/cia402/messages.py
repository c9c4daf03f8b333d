"""What a simulated CiA 402 drive hears and says: NMT, SYNC, PDOs, SDO, heartbeats."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import cache
from types import MappingProxyType

from armdrive.sim.cia402.motion import arrived, watch_switch
from armdrive.sim.cia402.node import Cia402Node, Homing
from armdrive.sim.cia402.objects import AT_CHANGE, DIGITAL_INPUTS, POSITION_DEMAND, VELOCITY, SimPdo
from armdrive.sim.cia402.states import (
    LIMIT_REACHED,
    PDO_TOO_SHORT,
    TOO_FAR_BEHIND,
    command,
    fault,
    forsake,
    over,
    react,
    report,
    say,
    watch_end,
)
from armdrive.sim.cia402.writes import refusal, watched, written
from firmware_protocol.canopen import (
    FOLLOWING_ERROR,
    FOLLOWING_ERROR_TIMEOUT_MS,
    FOLLOWING_ERROR_WINDOW,
    MODE_SHOWN,
    POSITION,
    STATUSWORD,
    AbortCode,
    Command,
    DriveState,
    NmtCommand,
    OperationMode,
    Place,
    ReadAsked,
    Service,
    StatusBit,
    Statusword,
    WriteAsked,
    cob_id,
)
from firmware_protocol.errors import BadField, RemoteProtocolError
from firmware_protocol.frames import Frame

# --- The drive's view of itself: statusword and readings -----------------------------------------

_OF_MODE = StatusBit.REACHED | StatusBit.ACKNOWLEDGED
_OF_MODE_MASK = int(_OF_MODE)
_UPPER_SWITCH = 1
"""The bit of 60FD that is the upper limit switch."""
_WRAP = 1 << 32


def status(node: Cia402Node, now_s: float) -> Statusword:
    """Return its statusword."""
    word = node.machine.statusword(_common(node))
    bits = _TOLD.get(node.mode, _told_of_none)(node, word.bits & _OF_MODE, now_s)
    if not node.enabled:
        bits = StatusBit(0) if node.point.moving(now_s) else StatusBit.REACHED
    return Statusword(word.value & ~_OF_MODE_MASK | int(bits))


def read(node: Cia402Node, place: Place, now_s: float) -> int:
    """Return what an object that is a number is now."""
    told = LIVE.get(place)
    return node.number_of(place, 0) if told is None else told(node, now_s)


def behind(node: Cia402Node, now_s: float) -> int:
    """Return how far the shaft is from where it was told to be; 0 where nothing holds it."""
    return node.point.demand(now_s) - node.shaft if node.holding else 0


def _common(node: Cia402Node) -> StatusBit:
    return _common_of(node.astray, node.limited, node.forsaken)


@cache
def _common_of(astray: bool, limited: bool, forsaken: bool) -> StatusBit:
    bits = StatusBit.VOLTAGE
    bits |= StatusBit.FOLLOWING_ERROR if astray else StatusBit(0)
    bits |= StatusBit.LIMITED if limited else StatusBit(0)
    return bits | StatusBit.WARNING if forsaken else bits


def _told_of_profile(node: Cia402Node, bits: StatusBit, now_s: float) -> StatusBit:  # noqa: ARG001
    return bits & ~StatusBit.REACHED if node.withheld else bits


def _told_of_cycle(node: Cia402Node, bits: StatusBit, now_s: float) -> StatusBit:  # noqa: ARG001
    """Return bit 12 while it follows its targets; bit 10 says nothing then."""
    halted = node.machine.points.halted
    return StatusBit(0) if halted else StatusBit.ACKNOWLEDGED


def _told_of_homing(node: Cia402Node, bits: StatusBit, now_s: float) -> StatusBit:  # noqa: ARG001
    if node.homing is Homing.FAILED:
        return StatusBit.FOLLOWING_ERROR | StatusBit.REACHED
    stands = not node.point.moving(now_s) and arrived(node)
    if node.homing.searches or not stands or node.withheld:
        return StatusBit(0)
    home = node.homing is Homing.DONE
    return StatusBit.REACHED | (StatusBit.ACKNOWLEDGED if home else StatusBit(0))


def _told_of_none(node: Cia402Node, bits: StatusBit, now_s: float) -> StatusBit:  # noqa: ARG001
    return StatusBit(0) if node.point.moving(now_s) else StatusBit.REACHED


_TOLD: Mapping[int, Callable[[Cia402Node, StatusBit, float], StatusBit]] = MappingProxyType(
    {
        OperationMode.PROFILE_POSITION: _told_of_profile,
        OperationMode.CYCLIC_POSITION: _told_of_cycle,
        OperationMode.HOMING: _told_of_homing,
    }
)
LIVE: Mapping[Place, Callable[[Cia402Node, float], int]] = MappingProxyType(
    {
        STATUSWORD: lambda node, now_s: status(node, now_s).value,
        MODE_SHOWN: lambda node, _: node.mode,
        POSITION: lambda node, _: _wrapped(node.counts),
        POSITION_DEMAND: lambda node, now_s: _wrapped(node.point.demand(now_s) - node.zero),
        VELOCITY: lambda node, now_s: round(node.point.rate(now_s)),
        FOLLOWING_ERROR: lambda node, now_s: _wrapped(behind(node, now_s)),
        DIGITAL_INPUTS: lambda node, _: node.switch.pressed << _UPPER_SWITCH,
    }
)
"""What is measured when it is asked for."""


def _wrapped(count: int) -> int:
    """Return a count as 32 bits hold it."""
    return (count + _WRAP // 2) % _WRAP - _WRAP // 2


NMT, SYNC = cob_id(Service.NMT), cob_id(Service.SYNC)
_SDO, _HEARTBEAT = 0x600, 0x700
_HEARTBEATS = range(0x701, 0x780)


def listens_to(node: Cia402Node, can_id: int) -> bool:
    """Tell whether a drive takes a frame of an id from the bus."""
    if not (node.powered and node.plugged):
        return False
    if can_id in (NMT, SYNC, _SDO + node.number) or can_id in node.pdos.received:
        return True
    return can_id in _HEARTBEATS


def minds_shaft(node: Cia402Node, can_id: int) -> bool:
    """Tell whether what a frame asks for depends on where the shaft is at this very moment."""
    return can_id in (SYNC, _SDO + node.number)


def hear(node: Cia402Node, frame: Frame, now_s: float) -> None:
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


def tell_changes(node: Cia402Node, now_s: float) -> None:
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


# --- SYNC and PDOs -------------------------------------------------------------------------------


def _beat(node: Cia402Node, now_s: float) -> None:
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


def _send_in_turn(node: Cia402Node, pdo: SimPdo, now_s: float) -> None:
    data = _packed(node, pdo, now_s)
    pdo.beats += 1
    if pdo.transmission == AT_CHANGE and data == pdo.data:
        return
    if pdo.beats >= pdo.transmission:
        pdo.beats = 0
        _send(node, pdo, data, now_s)


def _packed(node: Cia402Node, pdo: SimPdo, now_s: float) -> bytes:
    return pdo.pack([read(node, place, now_s) for place in pdo.places])


def _send(node: Cia402Node, pdo: SimPdo, data: bytes, now_s: float) -> None:
    node.say((Frame(pdo.can_id, data),))
    pdo.data = data
    pdo.free_s = now_s + pdo.inhibit_s
    if not pdo.synchronous:
        pdo.due_s = max(now_s + pdo.event_s, pdo.free_s) if pdo.event_s else math.inf


def _take_pdo(node: Cia402Node, pdo: SimPdo, data: bytes, now_s: float) -> None:
    if not node.nmt.takes("pdo"):
        return
    if len(data) < pdo.size:
        say(node, PDO_TOO_SHORT)
    elif pdo.synchronous:
        pdo.data = data
    else:
        _act(node, pdo, data, now_s)


def _act(node: Cia402Node, pdo: SimPdo, data: bytes, now_s: float) -> None:
    """Take over what a PDO has brought; a value that an object may not have is left out."""
    taken = []
    for place, value in zip(pdo.places, pdo.unpack(data), strict=True):
        if refusal(node, place, value) is None:
            node.keep(place, value)
            taken.append(place)
    written(node, taken, now_s)


# --- SDO -----------------------------------------------------------------------------------------


def _serve(node: Cia402Node, frame: Frame, now_s: float) -> None:
    if not node.nmt.takes("sdo"):
        return
    said = [node.sdo.receive_frame(frame)]
    while (event := node.sdo.next_event()) is not None:
        if isinstance(event, ReadAsked):
            said.append(_tell(node, event, now_s))
        elif isinstance(event, WriteAsked):
            said.append(_take(node, event, now_s))
    node.say(said)


def _tell(node: Cia402Node, ask: ReadAsked, now_s: float) -> Frame | None:
    if ask.place in LIVE:
        node.keep(ask.place, LIVE[ask.place](node, now_s))
    return node.stored().answer(node.sdo, ask)


def _take(node: Cia402Node, ask: WriteAsked, now_s: float) -> Frame | None:
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


# --- NMT and heartbeats --------------------------------------------------------------------------


def _order(node: Cia402Node, frame: Frame, now_s: float) -> None:
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


def _heartbeat(node: Cia402Node, sender: int, now_s: float) -> None:
    watch = watched(node)
    if watch is None or watch.node != sender:
        return
    node.silent_s = now_s + watch.silence_ms / 1000
    if node.forsaken:
        node.forsaken = False
        if node.state not in (DriveState.FAULT, DriveState.FAULT_REACTION):
            over(node)


# --- What the drive does by itself, and when -----------------------------------------------------

_UNWATCHED = 0xFFFF_FFFF
_OBEYING = (DriveState.ENABLED, DriveState.QUICK_STOP)


def due_s(node: Cia402Node) -> float:
    """Tell when it next does something by itself, apart from looking at its shaft."""
    if not node.powered:
        return math.inf
    if node.booting:
        return min(node.boots_s, _motion_s(node))
    due = min(node.beat_s, node.silent_s, _motion_s(node))
    if not node.nmt.takes("pdo"):
        return due
    return min((due, *(pdo.due_s for pdo in node.pdos.transmitted)))


def live(node: Cia402Node, now_s: float) -> None:
    """Do whatever is due by now."""
    if not node.powered:
        return
    if node.booting and node.boots_s <= now_s:
        node.boots_s = -math.inf
        node.say((node.nmt.booted(),))
        for code in sorted(node.ailing):
            fault(node, code, now_s)
    _watch_beats(node, now_s)
    _watch_shaft(node, now_s)
    _watch_switch(node, now_s)
    watch_end(node, now_s)
    tell_changes(node, now_s)


def _motion_s(node: Cia402Node) -> float:
    end_s = node.point.end_s if node.ends and not node.waits else math.inf
    return min(end_s, node.switch_s, node.astray_s + _patience_s(node))


def _patience_s(node: Cia402Node) -> float:
    return node.number_of(FOLLOWING_ERROR_TIMEOUT_MS, 0) / 1000


def _watch_beats(node: Cia402Node, now_s: float) -> None:
    if node.beat_s <= now_s:
        node.beat_on(node.beat_s)
        node.say((node.nmt.heartbeat.frame,))
    if node.silent_s <= now_s:
        node.silent_s = math.inf
        forsake(node, now_s)


def _watch_shaft(node: Cia402Node, now_s: float) -> None:
    """Fail where the shaft has been too far from where it was told to be, for too long."""
    window = node.number_of(FOLLOWING_ERROR_WINDOW, _UNWATCHED)
    watches = node.holding and node.state in _OBEYING and window != _UNWATCHED
    if not watches or abs(behind(node, now_s)) <= window:
        node.astray_s = math.inf
        return
    node.astray_s = min(node.astray_s, now_s)
    if now_s >= node.astray_s + _patience_s(node):
        node.astray_s, node.astray = math.inf, True
        fault(node, TOO_FAR_BEHIND, now_s)


def _watch_switch(node: Cia402Node, now_s: float) -> None:
    if node.switch_s <= now_s:
        node.switch_s = math.inf
    if node.homing.searches:
        watch_switch(node)
    elif _runs_into_limit(node, now_s):
        report(node, LIMIT_REACHED)
        command(node, Command.QUICK_STOP, now_s)


def _runs_into_limit(node: Cia402Node, now_s: float) -> bool:
    minds = node.quirks.limits and node.enabled and node.switch.pressed
    return minds and node.point.rate(now_s) * node.switch.way > 0
