"""One simulated CiA 402 drive: the table of its objects, its frames and its power."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Container, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from types import MappingProxyType

from armdrive.errors import BadRequest
from armdrive.sim.bus.node import NodeMotor, NodePort
from armdrive.sim.cia402.motion import METHODS, Cia402Motion, Homing
from armdrive.sim.cia402.objects import DriveObjects
from armdrive.sim.cia402.quirks import Cia402Quirks
from armdrive.sim.cia402.states import PDO_TOO_SHORT, Cia402States
from armdrive.sim.world.saved import Json
from armdrive.text.toml import setting
from firmware_protocol import canopen
from firmware_protocol.canopen import (
    AbortCode,
    NmtCommand,
    NodeState,
    OperationMode,
    Place,
    Value,
)
from firmware_protocol.canopen.pdo import PDO_PARAMETERS, DevicePdos
from firmware_protocol.frames import Frame

NMT, SYNC = canopen.cob_id(canopen.Service.NMT), canopen.cob_id(canopen.Service.SYNC)
_SDO, _HEARTBEAT = 0x600, 0x700
_HEARTBEATS = range(0x701, 0x780)
_ROUNDING = 1e-6
# When the boot-up message comes after power or a reset, and after one of the communication.
BOOT_S, RESET_S = 0.5, 0.02


class Cia402Node:
    """A drive on one motor; `number` is its node id."""

    def __init__(
        self,
        motor: NodeMotor,
        number: int,
        dictionary: canopen.Dictionary,
        modes: Collection[OperationMode],
        quirks: Cia402Quirks,
    ) -> None:
        self.motor = motor
        self.port = NodePort()
        self._modes, self._quirks = modes, quirks
        self.objects = DriveObjects(dictionary, number, serial=motor.index + 1)
        self.motion = Cia402Motion(motor, self.objects, quirks)
        self.states = Cia402States(motor, self.motion, self.objects, self.say_emcy)
        self.pdos = DevicePdos(
            dictionary, self.objects.number_of, self.reader, self._act, self.port.say
        )
        self._forget_talk()
        self.nmt.booted()  # its boot-up message was sent long ago

    @property
    def number(self) -> int:
        """Its node id."""
        return self.objects.node

    # Frames.

    def listens(self, can_id: int) -> bool:
        """Return whether it takes frames with an id from the bus."""
        if not (self.port.powered and self.port.plugged):
            return False
        return can_id in self._ids or can_id in self.pdos.received or can_id in _HEARTBEATS

    def receive(self, frame: Frame, now_s: float) -> None:
        """Take a frame that it listens for, and report what changes."""
        if frame.can_id in (SYNC, self._sdo_id):  # depends on where the shaft is just now
            self.motor.look(now_s)
            self.live(now_s)
        if not (frame.extended or frame.remote or self.port.booting):
            self._take(frame, now_s)

    def _take(self, frame: Frame, now_s: float) -> None:
        if frame.can_id == SYNC:
            if self._by_pdo:
                self.pdos.sync(now_s)
        elif frame.can_id in self.pdos.received:
            if self._by_pdo and not self.pdos.take(frame, now_s):
                self.say_emcy(PDO_TOO_SHORT)
        elif frame.can_id == self._sdo_id:
            if self.nmt.communicates:
                self._now_s = now_s
                self.port.say(self.sdo.receive_frame(frame))
        elif frame.can_id == NMT:
            self._order(frame, now_s)
        elif (watch := self._watched) is not None and frame.can_id == _HEARTBEAT + watch.node:
            self.silent_s = now_s + watch.silence_ms / 1000
            self.states.regain_master()

    def say_emcy(self, code: int) -> None:
        """Send an EMCY with an error code."""
        if self.nmt.communicates:
            register = self.objects.number_of(canopen.ERROR_REGISTER, 0)
            self.port.say(canopen.Emergency(self.number, code, register).frame)

    @property
    def _by_pdo(self) -> bool:
        """Whether it exchanges PDOs. They are set up when the node is started; see `_refusal`."""
        return self.nmt.state is NodeState.OPERATIONAL

    def _order(self, frame: Frame, now_s: float) -> None:
        order = self.nmt.receive_frame(frame)
        if order is NmtCommand.START:
            self.pdos.rebuild()
        elif order is NmtCommand.STOP:
            self.states.react(now_s)
        elif order is NmtCommand.RESET_NODE:
            self.restart(now_s)
        elif order is NmtCommand.RESET_COMMUNICATION:
            self._renew_talk(self.number, now_s)

    def _tell(self, place: Place) -> bytes | AbortCode:
        """Return an object's bytes for a client, or why not."""
        if place in READINGS:
            self.objects.keep(place, self.read(place, self._now_s))
        return self.objects.store.read(place)

    def _write(self, place: Place, data: bytes, exact: bool) -> AbortCode | None:
        """Write a client's bytes; return why not, if that is refused."""
        refused = self.objects.store.write(place, data, exact, refusal=self._refusal)
        if refused is None:
            self._written((place,), self._now_s)
        return refused

    # Objects.

    def read(self, place: Place, now_s: float) -> int:
        """Return the present value of a number object."""
        return self.reader(place)(now_s)

    def reader(self, place: Place) -> Callable[[float], int]:
        """Return the function that reads a number object."""
        reading = READINGS.get(place)
        if reading is None:
            return lambda _: self.objects.number_of(place, 0)
        return partial(reading, self)

    def _act(self, values: Sequence[tuple[Place, int]], now_s: float) -> None:
        """Adopt the values of a PDO; a value that an object may not have is skipped."""
        taken = [(place, value) for place, value in values if self._refusal(place, value) is None]
        for place, value in taken:
            self.objects.keep(place, value)
        self._written([place for place, _ in taken], now_s)

    def _refusal(self, place: Place, value: Value) -> AbortCode | None:
        """Return why an object may not have a value of its type; None if it may."""
        row = OBJECTS.get(place)
        if row is not None and row.allows is not None:
            return None if value in row.allows else AbortCode.VALUE
        if place == canopen.MODE:
            has = value in (OperationMode.NONE, *self._modes)
            return None if has else AbortCode.VALUE
        if place.index not in PDO_PARAMETERS:
            return None
        if self.nmt.state is NodeState.OPERATIONAL:
            return AbortCode.DEVICE_STATE
        return self.pdos.refusal(place, int(value))

    def _written(self, written: Collection[Place], now_s: float) -> None:
        """Act on objects that were written together."""
        followed = self.states.follows
        for act in _acts_of(tuple(written)):
            act(self, now_s)
        if self.states.follows and (canopen.TARGET_POSITION in written or not followed):
            self.motion.follow(now_s)

    # Time.

    @property
    def busy(self) -> bool:
        """Whether its motor is moving."""
        return self.motor.moving

    def due_s(self) -> float:
        """Return when it next acts by itself, apart from controlling its shaft."""
        if not self.port.powered:
            return math.inf
        if self.port.booting:
            return min(self.port.boots_s, self.states.due_s)
        return min(self.beat_s, self.silent_s, self.states.due_s)

    def live(self, now_s: float) -> None:
        """Do what is due by now."""
        if not self.port.powered:
            return
        if self.port.booting and self.port.boots_s <= now_s:
            self.port.boots_s = -math.inf
            self.port.say(self.nmt.booted())
            for code in sorted(self.states.active_errors):
                self.states.fault(code, now_s)
        if self.beat_s <= now_s:
            self.beat_on(self.beat_s)
            self.port.say(self.nmt.heartbeat.frame)
        if self.silent_s <= now_s:
            self.silent_s = math.inf
            self.states.lose_master(now_s)
            if not self.objects.number_of(canopen.ERROR_BEHAVIOUR, 0):
                self.nmt.failed()
        self.states.live(now_s)

    def beat_on(self, now_s: float) -> None:
        """Schedule the next heartbeat. All drives with one period send together: fewer wake-ups."""
        period_s = self.objects.number_of(canopen.PRODUCER_HEARTBEAT_MS, 0) / 1000
        beats = math.floor(now_s / period_s + _ROUNDING) + 1 if period_s else 0
        self.beat_s = beats * period_s if period_s else math.inf

    def watch(self) -> None:
        """Watch for the master's heartbeat again, from the next one on."""
        self.silent_s, self.states.master_lost = math.inf, False

    @property
    def _watched(self) -> canopen.HeartbeatWatch | None:
        """The node that it watches, and the timeout."""
        return _watch_of(self.objects.number_of(canopen.CONSUMER_HEARTBEAT, 0))

    # Power.

    def forget(self, now_s: float) -> None:
        """Release the shaft, and forget what is lost without power."""
        self.motor.release(now_s)
        self._renew(self.number)

    def begin(self, now_s: float) -> None:
        """Start after power has returned; the boot-up message follows later."""
        self.port.boots_s = now_s + BOOT_S
        if not self._quirks.keeps_position:
            self.motor.count_from(0)

    def restart(self, now_s: float) -> None:
        """Restart, as after a loss of power."""
        self.forget(now_s)
        self.begin(now_s)

    def _renew(self, number: int) -> None:
        """Reset everything except its identity."""
        self.port.boots_s = -math.inf
        self.objects.renew(number)
        self.motion.forget()
        self.states.forget()
        self._forget_talk()

    def _renew_talk(self, number: int, now_s: float) -> None:
        """Restart the communication, perhaps with another id; the motor keeps its current."""
        self.states.react(now_s)
        self.states.master_lost = False
        self.objects.renew_communication(number)
        self._forget_talk()
        self.port.boots_s = now_s + RESET_S

    def _forget_talk(self) -> None:
        self.nmt = canopen.NmtNode(self.number)
        self.sdo = canopen.SdoServer(self.number, self._tell, self._write)
        self._now_s = 0.0
        self._sdo_id: int = _SDO + self.number
        self._ids = frozenset((NMT, SYNC, self._sdo_id))
        self.beat_s = math.inf
        """When its next heartbeat is due."""
        self.silent_s = math.inf
        """When the master's heartbeat counts as missing; infinity before its first one."""

    # What a person changes and sees.

    def set_id(self, node: int, now_s: float) -> int:
        """Change the id, as its switches do; return the old one. Raises `BadRequest`."""
        if not 1 <= node <= canopen.NODE_MAX:
            raise BadRequest(f"node ids are 1 to {canopen.NODE_MAX}, not {node}")
        before = self.number
        self._renew_talk(node, now_s)
        return before

    def set_mode(self, mode: int, now_s: float) -> int:
        """Change the mode, as the maker's program does; return the old one. Raises `BadRequest`."""
        modes = [*OperationMode]
        if mode not in modes:
            raise BadRequest(f"modes are {', '.join(str(int(each)) for each in modes)}, not {mode}")
        before = self.states.mode
        self.objects.keep(canopen.MODE, mode)
        self.states.set_mode(mode, now_s)
        return before

    def seen(self, error: int, now_s: float) -> dict[str, Json]:
        """Return the data it would report, given its shaft's distance from the set-point."""
        watch = self._watched
        return {
            "id": self.number,
            "powered": self.port.powered,
            "nmt": self.nmt.state.name.lower(),
            "state": self.states.state.name.lower(),
            "mode": self.states.mode,
            "statusword": f"{self.read(canopen.STATUSWORD, now_s):04X}",
            "error_code": f"{self.objects.number_of(canopen.ERROR_CODE, 0):04X}",
            "rate": round(self.motor.point.rate(now_s), 2),
            "error_counts": error,
            "homed": self.motion.homing is Homing.DONE,
            "watch_s": 0.0 if watch is None else watch.silence_ms / 1000,
            "watch_stops": self.states.watch_stops,
        }

    def known(self) -> SavedCia402Drive:
        """Return its state, and the objects that differ from their defaults."""
        state, machine = self.states.state, self.states.machine
        state = canopen.DriveState.FAULT if state is canopen.DriveState.FAULT_REACTION else state
        leaves = state is canopen.DriveState.QUICK_STOP and not machine.quick_stop.stays
        booting = self.nmt.state is NodeState.BOOTING
        talks = NodeState.PRE_OPERATIONAL if booting else self.nmt.state
        return SavedCia402Drive(
            powered=self.port.powered,
            id=self.number,
            nmt=talks.name.lower(),
            state=(canopen.DriveState.DISABLED if leaves else state).name.lower(),
            homed=self.motion.homing is Homing.DONE,
            active_errors=tuple(sorted(self.states.active_errors)),
            objects=self.objects.changed(READINGS),
        )

    def recall(self, saved: SavedCia402Drive) -> None:
        """Restore what `known` returned, once its power is known. Raises `StateFileError`."""
        self.states.active_errors = set(saved.active_errors)
        self._renew(saved.id)
        self.objects.recall(saved.objects)
        self.states.mode = self.objects.number_of(canopen.MODE, 0)
        self.states.set_quick_stop()
        talks = _TALKS[saved.nmt]
        self.nmt.booted()
        if talks in _ORDERS:
            self.nmt.receive_frame(canopen.Nmt(_ORDERS[talks], saved.id).frame)
        self.pdos.rebuild()
        self.beat_on(0.0)
        self._recall_state(_STATES[saved.state])
        self.motion.homing = Homing.DONE if saved.homed else Homing.NONE

    def _recall_state(self, state: canopen.DriveState) -> None:
        """Restore the saved state; nothing sags, since the saved arm has sagged already."""
        self.states.machine.state = state
        self.motor.recall(self.port.powered and self.states.state.holds)


# --- What is saved of a drive ---------------------------------------------------------------------

_ORDERS = {NodeState.OPERATIONAL: NmtCommand.START, NodeState.STOPPED: NmtCommand.STOP}
_STATES = {
    state.name.lower(): state
    for state in canopen.DriveState
    if state not in (canopen.DriveState.NOT_READY, canopen.DriveState.FAULT_REACTION)
}
_TALKS = {state.name.lower(): state for state in (NodeState.PRE_OPERATIONAL, *_ORDERS)}


@dataclass(frozen=True, slots=True)
class SavedCia402Drive:
    """What is saved of a drive; `objects` are those that differ from the EDS, as bytes."""

    powered: bool
    homed: bool
    active_errors: tuple[int, ...]
    objects: Mapping[str, str]
    id: int = setting(low=1, high=canopen.NODE_MAX)
    nmt: str = setting(words=tuple(_TALKS))
    state: str = setting(words=tuple(_STATES))


# --- The objects that do more than store a number ------------------------------------------------
#
# The EDS gives each object's type and access. A row adds the values that it may have, what a write
# causes, and what a read measures.

# The bit of the limit switch in 60FD: the negative one is bit 0, the positive one bit 1.
_LIMIT_BITS = MappingProxyType({-1: 0, 1: 1})
_WRAP = 1 << 32
_ABOVE_ZERO = range(1, 1 << 32)


@dataclass(frozen=True, slots=True)
class ObjectRow:
    """An object's allowed values, what a write does, and what a read returns."""

    allows: Container[Value] | None = None
    does: Callable[[Cia402Node, float], None] | None = None
    tells: Callable[[Cia402Node, float], int] | None = None


def _wrapped(count: int) -> int:
    """Return a count, wrapped to 32 bits."""
    return (count + _WRAP // 2) % _WRAP - _WRAP // 2


# fmt: off
# Objects that arrive together act in this order: the mode before the controlword.
OBJECTS: Mapping[Place, ObjectRow] = MappingProxyType({
    canopen.QUICK_STOP_OPTION: ObjectRow(
        frozenset(canopen.QuickStopOption), lambda node, _: node.states.set_quick_stop()),
    canopen.PRODUCER_HEARTBEAT_MS: ObjectRow(does=Cia402Node.beat_on),
    canopen.CONSUMER_HEARTBEAT: ObjectRow(
        range(canopen.NODE_MAX + 1 << 16), lambda node, _: node.watch()),
    canopen.MODE: ObjectRow(does=lambda node, now_s: node.states.set_mode(
        node.objects.number_of(canopen.MODE, 0), now_s)),
    canopen.CONTROLWORD: ObjectRow(does=lambda node, now_s: node.states.control(now_s)),
    canopen.HEARTBEAT_REACTION: ObjectRow(range(4)),
    canopen.FAULT_REACTION_OPTION: ObjectRow(range(5)),
    canopen.PROFILE_ACCELERATION: ObjectRow(_ABOVE_ZERO),
    canopen.PROFILE_DECELERATION: ObjectRow(_ABOVE_ZERO),
    canopen.QUICK_STOP_DECELERATION: ObjectRow(_ABOVE_ZERO),
    canopen.HOMING_METHOD: ObjectRow(METHODS),
    canopen.PERIOD: ObjectRow(range(1, 256)),
    canopen.PERIOD_POWER: ObjectRow(range(-4, 1)),
    canopen.ERROR_COUNT: ObjectRow(range(1)),
    canopen.STATUSWORD: ObjectRow(tells=lambda node, now_s: node.states.statusword(
        now_s, withheld=node.port.withheld).value),
    canopen.MODE_SHOWN: ObjectRow(tells=lambda node, _: node.states.mode),
    canopen.POSITION: ObjectRow(tells=lambda node, _: _wrapped(node.motor.counts)),
    canopen.FOLLOWING_ERROR: ObjectRow(
        tells=lambda node, now_s: _wrapped(node.motion.behind(now_s))),
    canopen.POSITION_DEMAND: ObjectRow(tells=lambda node, now_s: _wrapped(
        node.motor.point.at(now_s) - node.motor.zero)),
    canopen.VELOCITY: ObjectRow(tells=lambda node, now_s: round(node.motor.point.rate(now_s))),
    canopen.DIGITAL_INPUTS: ObjectRow(
        tells=lambda node, _: node.motor.switch.pressed << _LIMIT_BITS[node.motor.switch.way]),
})
# fmt: on
READINGS: Mapping[Place, Callable[[Cia402Node, float], int]] = MappingProxyType(
    {place: row.tells for place, row in OBJECTS.items() if row.tells is not None}
)


@lru_cache(maxsize=512)
def _acts_of(written: tuple[Place, ...]) -> tuple[Callable[[Cia402Node, float], None], ...]:
    """Return the actions of objects; cached, since every PDO brings the same ones."""
    return tuple(row.does for place, row in OBJECTS.items() if place in written and row.does)


@lru_cache(maxsize=64)
def _watch_of(value: int) -> canopen.HeartbeatWatch | None:
    """Return what an object says; cached, since every drive asks at every heartbeat."""
    return canopen.HeartbeatWatch.of(value)
