"""Finding the CiA 402 drives of an arm and setting them up. Nothing moves."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from armdrive.dialects.cia402.cycle import STOP
from armdrive.dialects.cia402.drive import Cia402Drive
from armdrive.dialects.cia402.master import setups
from armdrive.dialects.cia402.power import Cia402States, Hindrance
from armdrive.dialects.cia402.receive import SERIAL_NUMBER
from armdrive.dialects.cia402.sdo_queue import TRIES, ObjectRead, SdoQueue, refusal_words
from armdrive.dialects.cia402.settings import Cia402Settings
from armdrive.tasks import ProtocolWarning, RequestRejected
from firmware_protocol.canopen import (
    CONSUMER_HEARTBEAT,
    CONTROLWORD,
    DEVICE_TYPE,
    FAULT_REACTION_OPTION,
    FOLLOWING_ERROR_TIMEOUT_MS,
    FOLLOWING_ERROR_WINDOW,
    HEARTBEAT_REACTION,
    NOT_VALID,
    POSITION,
    PRODUCER_HEARTBEAT_MS,
    QUICK_STOP_DECELERATION,
    QUICK_STOP_OPTION,
    STATUSWORD,
    SUPPORTED_MODES,
    DataType,
    HeartbeatWatch,
    Nmt,
    NmtCommand,
    OperationMode,
    Place,
    QuickStopOption,
    Service,
    Statusword,
    Write,
    cob_id,
    supported_modes,
)

PROFILE_NUMBER = 402
CALM_S = 1.0
"""A motion that a program before this one left behind is waited for so long."""
LOOK_S = 0.03
"""A drive that is where it was so long ago stands."""
BEAT_LATE = 1.5
"""Another master is heard within so many of our own beats."""


class Cia402Contact(Cia402States):
    """The way to drives that hear, and tell where they are."""

    quick_slope = math.inf
    """The ramp of a quick stop, in increments a second squared."""

    def choose(self, modes: frozenset[OperationMode]) -> None:
        """Choose the ways of moving by what all drives can do."""

    # -- contact ------------------------------------------------------------------------------

    def contact(self) -> Hindrance:
        """Find every drive, set it up and have it tell where it is; return what hinders that."""
        self.shared.clear()
        hindrance = yield from self._recognise()
        if hindrance is None:
            hindrance = yield from self._calm_down()
        if hindrance is None and (shared := self.shared_words()):
            hindrance = RequestRejected(shared, moved=False)
        if hindrance is None:
            hindrance = yield from self._set_up()
        if hindrance is None:
            hindrance = yield from self._start()
        if hindrance is not None:
            return hindrance
        for drive in self.drives:
            drive.rest()
            drive.fresh = not self.configured
        self.contacted = self.configured = True
        return None

    def _recognise(self, *, again: bool = True) -> Hindrance:
        """Ask every drive what it is."""
        began_s = self.now_s
        self.last_said = "SDO 1000"
        lanes = yield from self.everywhere(
            ObjectRead(SERIAL_NUMBER),
            ObjectRead(DEVICE_TYPE),
            ObjectRead(SUPPORTED_MODES),
            ObjectRead(PRODUCER_HEARTBEAT_MS),
        )
        if (missing := self.missing(lanes, began_s)) is not None:
            if isinstance(missing, RequestRejected):
                if again and (yield from self.awoken(lanes)):
                    return (yield from self._recognise(again=False))
                if shared := self.shared_words():  # it may have the number of another
                    return RequestRejected(f"{missing.reason}. And {shared}", moved=False)
            return missing
        if self.rival_s > self.now_s - BEAT_LATE * self.settings.heartbeat_ms / 1000.0:
            return RequestRejected(
                f"another program beats as node {self.settings.master_id} on this bus and may "
                "command these drives: end it first",
                moved=False,
            )
        for lane in lanes.values():
            if DEVICE_TYPE in lane.refused:
                remedy = ". So it is no CANopen device: check the ids of the arm file"
                return RequestRejected(refusal_words(lane, DEVICE_TYPE, remedy), moved=False)
            profile = lane.values.get(DEVICE_TYPE, 0) & 0xFFFF
            if profile != PROFILE_NUMBER:
                return RequestRejected(
                    f"{lane.drive} says that it is a device of profile {profile}, not a drive of "
                    f"CiA {PROFILE_NUMBER}: check the ids of the arm file (`armdrive doctor "
                    "--can`)",
                    moved=False,
                )
            beat_ms = lane.values.get(PRODUCER_HEARTBEAT_MS, self.settings.drive_beat_ms)
            if self.configured and beat_ms != self.settings.drive_beat_ms:
                lane.drive.booted = True  # it has forgotten what it was told
        self._learn_modes(lanes)
        return None

    def _learn_modes(self, lanes: Mapping[int, SdoQueue]) -> None:
        words = [lane.values[SUPPORTED_MODES] for lane in lanes.values() if _tells_modes(lane)]
        modes = [supported_modes(word & 0xFFFF_FFFF) for word in words]
        self.choose(frozenset.intersection(*modes) if modes else frozenset())

    def _calm_down(self) -> Hindrance:
        """Wait for the end of what an earlier program left in motion, then end it.

        One look shows no motion. A drive is refused only if it goes on turning after it was told
        to stop: a program that was suspended meanwhile has seen too little to refuse it.
        """
        began_s, told_s = self.now_s, math.inf
        before: dict[int, int] | None = None
        while True:
            lanes = yield from self.everywhere(ObjectRead(POSITION), ObjectRead(STATUSWORD))
            if (missing := self.missing(lanes, began_s)) is not None:
                return missing
            if before is not None:
                turning = self._turning(lanes, before)
                if not turning:
                    return None
                if self.now_s > told_s + CALM_S:
                    return RequestRejected(
                        f"{turning[0]} turns, and does not come to rest", moved=False
                    )
                if self.now_s > began_s + CALM_S and math.isinf(told_s):
                    write = Write(CONTROLWORD, DataType.U16, STOP.value)
                    yield from self.transfer({drive.node: (write,) for drive in turning})
                    told_s = self.now_s
            before = {node: lane.values.get(POSITION, 0) for node, lane in lanes.items()}
            yield from self.wait(self.now_s + LOOK_S)

    def _turning(
        self, lanes: Mapping[int, SdoQueue], before: Mapping[int, int]
    ) -> list[Cia402Drive]:
        """Return the drives that hold their motors and turn; an arm may sag, that is seen later."""
        return [
            lane.drive
            for node, lane in lanes.items()
            if _holds(lane)
            and abs(lane.values.get(POSITION, 0) - before.get(node, 0)) > lane.drive.tremble
        ]

    def _set_up(self) -> Hindrance:
        """Write what the drives are to be like; they do not take part in PDOs meanwhile."""
        began_s = self.now_s
        self.last_said = "SDO set-up"
        cyclic = self.resting_mode is OperationMode.CYCLIC_POSITION
        cycle_ms = round(self.cycle_s * 1000.0) if cyclic else None
        jobs = {drive.node: needed(drive.node, self.quick_slope, cycle_ms) for drive in self.drives}
        lanes: Mapping[int, SdoQueue] = {}
        for _ in range(TRIES):  # the order may have been lost
            self._order(NmtCommand.PRE_OPERATIONAL, self.drives)
            lanes = yield from self.transfer(jobs)
            if (missing := self.missing(lanes, began_s)) is not None:
                return missing
            if not any(lane.refused for lane in lanes.values()):
                break
        if (refused := refused_of(lanes)) is not None:
            return refused
        return (yield from self._set_wishes())

    def _set_wishes(self) -> Hindrance:
        """Write what the drives are better with, and read back what safety stands on."""
        began_s = self.now_s
        wishes = {drive.node: wished(self.settings, drive.node) for drive in self.drives}
        lanes = yield from self.transfer(wishes, lenient=True)
        if (missing := self.missing(lanes, began_s)) is not None:
            return missing
        for lane in lanes.values():
            for place in lane.refused:
                if place.index >= _PROFILE_OBJECTS and not self.configured:
                    self.tell(ProtocolWarning(refusal_words(lane, place)))
        told = yield from self.everywhere(
            ObjectRead(HEARTBEAT_REACTION), ObjectRead(QUICK_STOP_OPTION)
        )
        if (missing := self.missing(told, began_s)) is not None:
            return missing
        for job in _of_safety(self.drives[0].node, self.quick_slope):
            for lane in told.values():
                if lane.values.get(job.place) != job.value:
                    return RequestRejected(
                        f"{lane.drive} does not keep {job.value} in object {job.place}, with "
                        "which it would stop and hold when this program dies",
                        moved=False,
                    )
        return None

    def _start(self) -> Hindrance:
        """Let the drives take part in PDOs, and have each tell where it is."""
        began_s = self.now_s
        missing: tuple[Cia402Drive, ...] = self.drives
        for _ in range(TRIES):
            self._order(NmtCommand.START, missing)
            yield from self.wait(self.now_s + self.cycle_s)
            missing = yield from self.look()
            if not missing:
                return None
        if len(missing) == len(self.drives):
            return self.silence(began_s)
        return RequestRejected(
            f"{missing[0]} answers, but sends no PDO upon SYNC: something else may have set it up",
            moved=False,
        )

    def _order(self, command: NmtCommand, drives: Sequence[Cia402Drive]) -> None:
        for drive in drives:
            self.say(self.bus.order(Nmt(command, drive.node)))


_PROFILE_OBJECTS = 0x6000
PROFILE_DOES = '. With strategy = "profile" it is not needed'
NEEDED = ". Nothing is driven without it: newer firmware of the drive may have it"


def _of_safety(node: int, quick_slope: float) -> tuple[Write, ...]:
    """Return what has to be as it was written, or nothing may be switched on."""
    places = (HEARTBEAT_REACTION, QUICK_STOP_OPTION)
    writes = needed(node, quick_slope, None)
    return tuple(write for write in writes if write.place in places)


def refused_of(lanes: Mapping[int, SdoQueue]) -> RequestRejected | None:
    """Say which object a drive refused, and why; None where none did."""
    for lane in lanes.values():
        for place in lane.refused:
            cyclic = place in (PERIOD, PERIOD_UNIT)
            remedy = PROFILE_DOES if cyclic else NEEDED
            return RequestRejected(refusal_words(lane, place, remedy), moved=False)
    return None


def _tells_modes(lane: SdoQueue) -> bool:
    return SUPPORTED_MODES in lane.values


def _holds(lane: SdoQueue) -> bool:
    word = lane.values.get(STATUSWORD)
    state = None if word is None else Statusword(word & 0xFFFF).state
    return state is not None and state.holds


# How CiA 402 drives are set up when contact is made with them: the objects that are written.

QUICK_STOP = 3
"""Of object 6007: a drive that misses the heartbeat makes a quick stop."""
BRAKE = 2
"""Of object 605E: a drive in fault brakes before it lets its motor go."""
PERIOD, PERIOD_UNIT = Place(0x60C2, 1), Place(0x60C2, 2)
MILLISECONDS = -3
BUSY_AT_MOST = 0.7
"""How much of a bus's time the cyclic frames may take."""
FRAME_BITS, SYNC_BITS = 123, 56
"""Of a PDO of seven bytes and of a SYNC, with stuffing and the space behind."""
_OTHERS = (
    (0x1401, Service.RPDO2),
    (0x1402, Service.RPDO3),
    (0x1403, Service.RPDO4),
    (0x1801, Service.TPDO2),
    (0x1802, Service.TPDO3),
    (0x1803, Service.TPDO4),
)


def period_ms(settings: Cia402Settings, drives: int, bit_rate: int) -> int:
    """Return the period of SYNC: the arm file's, or a longer one that the bus can carry."""
    bits = 2 * drives * FRAME_BITS + SYNC_BITS
    return max(settings.period_ms, math.ceil(1000.0 * bits / bit_rate / BUSY_AT_MOST))


def needed(node: int, quick_slope: float, cycle_ms: int | None) -> tuple[Write, ...]:
    """Return what no drive can do without. `quick_slope` is in increments a second squared.

    `cycle_ms` is None where no cyclic mode is used.
    """
    received, transmitted = setups(node)
    cyclic = (
        Write(PERIOD, DataType.U8, cycle_ms or 0),
        Write(PERIOD_UNIT, DataType.I8, MILLISECONDS),
    )
    return (
        *received.writes,
        *transmitted.writes,
        Write(HEARTBEAT_REACTION, DataType.I16, QUICK_STOP),
        Write(QUICK_STOP_OPTION, DataType.I16, QuickStopOption.QUICK_RAMP_AND_STAY),
        Write(QUICK_STOP_DECELERATION, DataType.U32, max(round(quick_slope), 1)),
        *(cyclic if cycle_ms else ()),
    )


def wished(settings: Cia402Settings, node: int) -> tuple[Write, ...]:
    """Return what a drive is better with: some do not have all of it."""
    silenced = (
        Write(Place(index, 1), DataType.U32, cob_id(service, node) | NOT_VALID)
        for index, service in _OTHERS
    )
    return (
        Write(FAULT_REACTION_OPTION, DataType.I16, BRAKE),
        Write(FOLLOWING_ERROR_WINDOW, DataType.U32, settings.following_window),
        Write(FOLLOWING_ERROR_TIMEOUT_MS, DataType.U16, settings.following_ms),
        Write(PRODUCER_HEARTBEAT_MS, DataType.U16, settings.drive_beat_ms),
        *silenced,
    )


def watch(settings: Cia402Settings, *, on: bool) -> Write:
    """Return what has a drive mind this program's heartbeat, or nobody's."""
    wanted = HeartbeatWatch(settings.master_id, settings.heartbeat_ms * on)
    return Write(CONSUMER_HEARTBEAT, DataType.U32, wanted.value if on else 0)
