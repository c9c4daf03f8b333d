"""Find an arm's CiA 402 drives, set them up, compare their settings, and switch their current.

None of it moves anything.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace
from typing import NoReturn

from armdrive.dialects.bus.drives import Obstructed
from armdrive.dialects.cia402.exchange import (
    STOP,
    TRIES,
    Cia402Exchange,
    DriveStates,
    ObjectTransfers,
    Results,
    Script,
    SdoResult,
)
from armdrive.dialects.cia402.settings import Cia402Settings
from armdrive.dialects.cia402.wire import (
    FAULTS,
    BusEvent,
    Cia402Drive,
    DriveGroup,
    HeartbeatProducer,
    astray_alert,
    setups,
)
from armdrive.dialects.exchange import ScriptIO
from armdrive.errors import Refused
from armdrive.tasks import DeviceSettings, Difference, Done, ProtocolWarning, Reply, RequestRejected
from firmware_protocol import canopen
from firmware_protocol.canopen import DataType, DriveState, NmtCommand, Place, Write

PROFILE_NUMBER = 402
EARLIER_MOTION_S = 1.0
"""How long drives that an earlier program left moving may go on. They stop when they miss its
heartbeat, after `heartbeat_ms` and a quick stop: 0.3 s by default."""
STILL_S = 0.03
"""A drive has stopped if it has not turned for this long: three periods of SYNC by default."""
RIVAL_TIMEOUTS = 1.5
"""A heartbeat with our own number, at most this many of our timeouts old, is another master's."""
FINAL_WRITES = 2
"""The last order of a program is sent twice, because it may be lost and its answer is not read."""

# The settings that drives get.

SAFETY = (
    Write(canopen.HEARTBEAT_REACTION, DataType.I16, 3),  # quick stop if the heartbeat is missing
    Write(canopen.QUICK_STOP_OPTION, DataType.I16, canopen.QuickStopOption.QUICK_RAMP_AND_STAY),
)
"""These must read back as written, or nothing is switched on."""
BRAKE = Write(canopen.FAULT_REACTION_OPTION, DataType.I16, 2)
"""Makes a drive in fault brake before it lets its motor go."""
MILLISECONDS = -3
_PROFILE_OBJECTS = 0x6000


def required_settings(node: int, quick_slope: float, cycle_ms: int | None) -> tuple[Write, ...]:
    """Return the settings that every drive needs. `quick_slope` is in increments/s².

    `cycle_ms` is None if no cyclic mode is used.
    """
    received, transmitted = setups(node)
    cyclic = (
        Write(canopen.PERIOD, DataType.U8, cycle_ms or 0),
        Write(canopen.PERIOD_POWER, DataType.I8, MILLISECONDS),
    )
    return (
        *received.writes,
        *transmitted.writes,
        *SAFETY,
        Write(canopen.QUICK_STOP_DECELERATION, DataType.U32, max(round(quick_slope), 1)),
        *(cyclic if cycle_ms else ()),
    )


def optional_settings(settings: Cia402Settings, node: int) -> tuple[Write, ...]:
    """Return settings that improve a drive, but that some drives lack."""
    return (
        BRAKE,
        Write(canopen.FOLLOWING_ERROR_WINDOW, DataType.U32, settings.following_window),
        Write(canopen.FOLLOWING_ERROR_TIMEOUT_MS, DataType.U16, settings.following_ms),
        Write(canopen.PRODUCER_HEARTBEAT_MS, DataType.U16, settings.drive_beat_ms),
        *(
            canopen.switched_off(direction, number, node)
            for direction in canopen.Direction
            for number in (2, 3, 4)
        ),
    )


def heartbeat_watch(settings: Cia402Settings, *, on: bool) -> Write:
    """Return the setting that makes a drive watch this program's heartbeat, or none."""
    wanted = canopen.HeartbeatWatch(settings.master_id, settings.heartbeat_ms * on)
    return Write(canopen.CONSUMER_HEARTBEAT, DataType.U32, wanted.value if on else 0)


def _remedy(place: Place) -> str:
    if place in (canopen.PERIOD, canopen.PERIOD_POWER):
        return '. With strategy = "profile" it is not needed'
    return ". It is required; newer firmware of the drive may have it"


@dataclass(slots=True, eq=False)
class Cia402Contact:
    """Finds every drive, sets it up, reads its position, switches its current and clears faults.

    `quick_slope` is the deceleration of a quick stop.
    """

    io: ScriptIO[BusEvent]
    exchange: Cia402Exchange
    transfers: ObjectTransfers
    group: DriveGroup
    states: DriveStates
    beats: HeartbeatProducer
    settings: Cia402Settings
    quick_slope: float

    def connect(self) -> Script[None]:
        """Make contact with every drive. Raises `Obstructed` if that fails."""
        self.group.shared.clear()
        yield from self._recognise()
        yield from self._end_earlier_motion()
        if self.group.shared:
            raise Obstructed(self.group.shared_words)
        yield from self._write_required()
        yield from self._write_optional()
        yield from self.transfers.verify(SAFETY, "with which it would stop and hold")
        yield from self._start()
        for drive in self.group.drives:
            drive.rest()
            drive.shaft.fresh = not self.group.configured
        self.group.contacted = self.group.configured = True

    def _recognise(self) -> Script[None]:
        """Identify every drive."""
        self.io.last_command = "SDO 1000"
        results = yield from self._find(
            canopen.SERIAL_NUMBER,
            canopen.DEVICE_TYPE,
            canopen.SUPPORTED_MODES,
            canopen.PRODUCER_HEARTBEAT_MS,
        )
        if (
            self.group.rival_s
            > self.io.now_s - RIVAL_TIMEOUTS * self.settings.heartbeat_ms / 1000.0
        ):
            raise Obstructed(
                f"another program sends heartbeats as node {self.settings.master_id} on this bus "
                "and may command these drives: end it first"
            )
        for result in results.values():
            if canopen.DEVICE_TYPE in result.refused:
                remedy = ". So it is not a CANopen device: check the ids of the arm file"
                raise Obstructed(result.refused[canopen.DEVICE_TYPE] + remedy)
            profile = result.values.get(canopen.DEVICE_TYPE, 0) & 0xFFFF
            if profile != PROFILE_NUMBER:
                raise Obstructed(
                    f"{result.drive} reports device profile {profile}, not a drive of CiA "
                    f"{PROFILE_NUMBER}: check the ids of the arm file (`armdrive doctor --can`)"
                )
            beat_ms = self.settings.drive_beat_ms
            found_ms = result.values.get(canopen.PRODUCER_HEARTBEAT_MS, beat_ms)
            if self.group.configured and found_ms != beat_ms:
                result.drive.booted = True  # it has lost its settings
        words = [result.values.get(canopen.SUPPORTED_MODES) for result in results.values()]
        modes = [canopen.supported_modes(word & 0xFFFF_FFFF) for word in words if word is not None]
        self.group.choose_mode(frozenset.intersection(*modes) if modes else frozenset())

    def _find(self, *places: Place) -> Script[Results]:
        """Read objects of every drive; wake drives that were stopped, and ask again.

        A stopped node does not answer, and sends nothing but its heartbeat.
        """
        jobs = self.transfers.of_each(*places)
        results = yield from self.transfers.transfer(jobs)
        mute = [result.drive for result in results.values() if result.mute]
        if 0 < len(mute) < len(results):
            self.exchange.order(NmtCommand.PRE_OPERATIONAL, mute)
            one = {drive.node: (canopen.DEVICE_TYPE,) for drive in mute}
            woken = yield from self.transfers.transfer(one, tries=1)
            if not all(result.mute for result in woken.values()):
                results = yield from self.transfers.transfer(jobs)
                mute = [result.drive for result in results.values() if result.mute]
        if not mute:
            return results
        reply = self.exchange.absence(mute)
        if isinstance(reply, RequestRejected) and self.group.shared:  # it may be one of the two
            reply = replace(reply, reason=f"{reply.reason}. And {self.group.shared_words}")
        raise Obstructed(reply)

    def _end_earlier_motion(self) -> Script[None]:
        """Wait for the end of a motion that an earlier program left running, then stop it.

        A single reading shows no motion. A drive is refused only if it keeps turning after a stop.
        """
        listened = self.io.listened
        began_s, stopped_s = listened.s, math.inf
        both = self.transfers.of_each(canopen.POSITION, canopen.STATUSWORD)
        before = yield from self.transfers.obtain(both)
        while True:
            yield from self.exchange.wait(self.io.now_s + STILL_S)
            results = yield from self.transfers.obtain(both)
            turning = [node for node in results if _turns(results[node], before[node])]
            if not turning:
                return
            if listened.s > stopped_s + EARLIER_MOTION_S:
                drive = self.group.by_node[turning[0]]
                raise Obstructed(f"{drive} turns, and did not come to rest after a stop")
            if listened.s > began_s + EARLIER_MOTION_S and math.isinf(stopped_s):
                stop = (Write(canopen.CONTROLWORD, DataType.U16, STOP.value),)
                yield from self.transfers.transfer(dict.fromkeys(turning, stop))
                stopped_s = listened.s
            before = results

    def _write_required(self) -> Script[None]:
        """Write the settings that every drive needs, while it takes no part in PDOs."""
        self.io.last_command = "SDO set-up"
        cyclic = self.group.resting_mode is canopen.OperationMode.CYCLIC_POSITION
        cycle_ms = round(self.exchange.cycle_s * 1000.0) if cyclic else None
        jobs = {
            node: required_settings(node, self.quick_slope, cycle_ms) for node in self.group.by_node
        }
        for _ in range(TRIES):  # the order PRE_OPERATIONAL may have been lost
            self.exchange.order(NmtCommand.PRE_OPERATIONAL, self.group.drives)
            results = yield from self.transfers.obtain(jobs)
            refused = [each for result in results.values() for each in result.refused.items()]
            if not refused:
                return
        for place, words in refused:
            raise Obstructed(words + _remedy(place))

    def _write_optional(self) -> Script[None]:
        """Write the optional settings; warn once of those that a drive lacks."""
        jobs = {node: optional_settings(self.settings, node) for node in self.group.by_node}
        results = yield from self.transfers.obtain(jobs, lenient=True)
        for result in results.values():
            for place, words in result.refused.items():
                if place.index >= _PROFILE_OBJECTS and not self.group.configured:
                    self.io.notify(ProtocolWarning(words))

    def _start(self) -> Script[None]:
        """Let the drives take part in PDOs, and read every position."""
        missing = self.group.drives
        for _ in range(TRIES):
            self.exchange.order(NmtCommand.START, missing)
            yield from self.exchange.wait(self.io.now_s + self.exchange.cycle_s)
            missing = yield from self.exchange.poll()
            if not missing:
                return
        if len(missing) == len(self.group.drives):
            raise Obstructed(self.exchange.silence())
        raise Obstructed(
            f"{missing[0]} answers, but sends no PDO upon SYNC: another program may have set it up"
        )

    # -- current and faults -------------------------------------------------------------------
    #
    # Drives that hold also watch this program's heartbeat.

    def read(self) -> Script[Reply]:
        """Read every position, and report a drive that has moved although it should hold."""
        yield from self.exchange.look()
        for drive in self.group.astray if self.group.on else ():
            self.io.notify(astray_alert(drive))
            drive.rest()
        return self.group.registers()

    def switch_on(self) -> Script[Reply]:
        """Make every drive hold its motor where it is and watch this program's heartbeat."""
        self.group.on = False
        yield from self.exchange.look()
        for drive in self.group.drives:
            if drive.state in FAULTS:
                yield from self._refuse(drive)
        self.beats.begin(self.io.now_s)
        yield from self._watch(on=True)
        yield from self.exchange.look()  # a hand may have turned a shaft meanwhile
        for drive in (yield from self.states.bring(self.group.drives, DriveState.ENABLED)):
            yield from self._refuse(drive)
        yield from self.states.hold_here(self.group.drives)
        yield from self._adopt_positions()
        self.group.on = True
        return Done()

    def _refuse(self, drive: Cia402Drive) -> Script[NoReturn]:
        """Raise `Obstructed` with the reason why a drive is not switched on."""
        yield from self.transfers.explain(drive)
        if drive.state in FAULTS:
            raise Obstructed(f"{drive.fault_words}; `reset()` clears that")
        state = "in no state" if drive.word is None else f"at {drive.word}"
        raise Obstructed(
            f"{drive} does not switch its motor on, it stays {state}: check the motors' supply "
            "and the drive's own enable input"
        )

    def switch_off(self) -> Script[Reply]:
        """Switch every drive's motor off."""
        self.group.on = False
        reply: Reply = Done()
        try:
            yield from self._watch(on=False)
        except Obstructed as obstructed:
            reply = obstructed.reply
        left = yield from self.states.bring(self.group.drives, DriveState.DISABLED)
        off = [drive for drive in left if drive.state not in FAULTS]
        if any(drive.missed > 1 for drive in off):
            raise Obstructed(self.exchange.absence(off))
        for drive in off:
            raise Obstructed(RequestRejected(f"{drive} does not switch its motor off"))
        self.beats.end()
        return reply

    def clear(self) -> Script[Reply]:
        """Reset faults and leave quick stops. Currents stay as they are, and nothing moves."""
        yield from self.exchange.look()
        for drive in self.group.drives:
            self.group.report(drive)  # faults that were not reported yet
        faulty = [drive for drive in self.group.drives if drive.state in FAULTS]
        for drive in (yield from self.states.reset_faults(faulty)):
            yield from self.transfers.explain(drive)
            words = (
                f"{drive.fault_words}, and does not leave it: clear the cause, then call `reset()`"
            )
            raise Obstructed(words)
        yield from self.states.leave_quick_stop(self.group.drives)
        yield from self._adopt_positions()
        held = all(drive.state is DriveState.ENABLED for drive in self.group.drives)
        self.group.on = self.beats.on and held
        return Done()

    def farewell(self) -> bytes:
        """Return frames that end the heartbeat watch: the drives then hold without an alarm."""
        if not self.beats.on:
            return b""
        self.beats.end()
        return self.transfers.unanswered_writes(
            heartbeat_watch(self.settings, on=False), FINAL_WRITES
        )

    def _adopt_positions(self) -> Script[None]:
        """Adopt every drive's position as its target, and forget its past faults."""
        yield from self.exchange.look()
        for drive in self.group.astray:
            drive.rest()
        for drive in self.group.drives:
            drive.recover()

    def _watch(self, *, on: bool) -> Script[None]:
        """Make the drives watch this program's heartbeat, or not, and verify that."""
        write = heartbeat_watch(self.settings, on=on)
        self.io.last_command = "SDO 1016"
        yield from self.transfers.carry_out(self.transfers.of_each(write), _remedy)
        yield from self.transfers.verify((write,), "without which it would not stop")


def _turns(now: SdoResult, before: SdoResult) -> bool:
    """Return whether a drive holds its motor and turns; a sagging arm is found later."""
    state = canopen.Statusword(now.values.get(canopen.STATUSWORD, 0) & 0xFFFF).state
    way = now.values.get(canopen.POSITION, 0) - before.values.get(canopen.POSITION, 0)
    return state is not None and state.holds and abs(way) > now.drive.tremble


# Comparing the drives' settings with the arm file, and correcting them line by line.
#
# A line is a drive's node number, an object, its type and its value: `3: 608F:01 u32 10000`.

_LINE = re.compile(
    r"\s*(\d{1,3})\s*:\s*([0-9A-Fa-f]{4}):([0-9A-Fa-f]{2})\s+([iu])(8|16|32)\s+(-?\d{1,10})\s*"
)
_COMMUNICATION = range(0x1000, 0x2000)
_MOVING = (0x6040, 0x6060, 0x607A)
"""Objects that would move a motor, or let it go."""


def wanted(settings: Cia402Settings) -> tuple[tuple[Write, str, bool], ...]:
    """Return the required objects, their names, and whether every motion needs them."""
    u8, u32, turns = DataType.U8, DataType.U32, settings.encoder_increments
    rows = (
        (Write(Place(0x607E), u8, 0), "polarity", True),
        (Write(Place(0x6091, 1), u32, 1), "gear ratio, motor turns", True),
        (Write(Place(0x6091, 2), u32, 1), "gear ratio, shaft turns", True),
        (
            Write(canopen.FOLLOWING_ERROR_WINDOW, u32, settings.following_window),
            "following error window",
            False,
        ),
        (BRAKE, "fault reaction", False),
    )
    if not turns:
        return rows
    return (
        *rows,
        (Write(Place(0x608F, 1), u32, turns), "encoder increments", True),
        (Write(Place(0x608F, 2), u32, 1), "encoder increments, turns", True),
        (Write(Place(0x6092, 1), u32, turns), "feed constant", True),
        (Write(Place(0x6092, 2), u32, 1), "feed constant, turns", True),
    )


def compare(transfers: ObjectTransfers, settings: Cia402Settings) -> Script[Reply]:
    """Compare the objects that the arm depends on, as far as a drive has them."""
    rows = wanted(settings)
    places = (write.place for write, _, _ in rows)
    results = yield from transfers.obtain(transfers.of_each(*places))
    differences = tuple(
        Difference(
            f"{name} ({write.place}) of {result.drive}",
            str(found),
            str(write.value),
            mending_line(result.drive.node, write),
            must,
        )
        for write, name, must in rows
        for result in results.values()
        if (found := result.values.get(write.place)) not in (None, write.value)
    )
    return DeviceSettings(differences)


def mend(transfers: ObjectTransfers, line: str) -> Script[Reply]:
    """Write one object."""
    node, write = parsed_line(line)
    if node not in transfers.group.by_node:
        raise Refused(f"`{line}`: no drive of this arm has the node number {node}")
    transfers.io.last_command = line
    yield from transfers.carry_out({node: (write,)})
    return Done()


def mending_line(node: int, write: Write) -> str:
    """Return the line that writes an object."""
    kind = f"{'i' if write.type.signed else 'u'}{write.type.bits}"
    return f"{node}: {write.place} {kind} {write.value}"


def parsed_line(line: str) -> tuple[int, Write]:
    """Parse such a line. Raises `Refused` if it writes no setting, or could move a motor."""
    found = _LINE.fullmatch(line)
    if found is None:
        raise Refused(f"`{line}` is not a drive setting: write one like `3: 608F:01 u32 10000`")
    place = Place(int(found[2], 16), int(found[3], 16))
    if place.index in _COMMUNICATION or place.index in _MOVING:
        raise Refused(f"`{line}` writes nothing that may be changed this way")
    kind = DataType[f"{found[4].upper()}{found[5]}"]
    entry = canopen.STANDARD.find(place)
    try:
        write = Write(place, entry.type if entry is not None else kind, int(found[6]))
        write.data  # noqa: B018 - raises where the value does not fit
    except ValueError as error:
        raise Refused(f"`{line}` is not a drive setting: {error}") from None
    return int(found[1]), write
