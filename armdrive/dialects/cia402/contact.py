"""Finding the drives and setting them up; switching their current; clearing their faults."""

from __future__ import annotations

import math

from armdrive.dialects.bus.homing import end_earlier_motion
from armdrive.dialects.cia402.drives import FAULTS, HOLDING, Cia402Drive, Trouble
from armdrive.dialects.cia402.exchange import Cia402Exchange
from armdrive.dialects.cia402.objects import DRIVES
from armdrive.dialects.cia402.settings import CYCLIC, Cia402Settings
from armdrive.dialects.cia402.states import STOP_WRITE, hold, reset_faults, switch_off
from armdrive.dialects.cia402.transfers import ReadObjects, Script, wait
from armdrive.dialects.exchange import TRIES, Obstructed
from armdrive.tasks import Done, Reply, RequestRejected
from firmware_protocol import canopen
from firmware_protocol.canopen import DataType, NmtCommand, OperationMode, Place, Write

# A drive has stopped if it has not turned for this long: three periods of SYNC by default.
STILL_S = 0.03
# A heartbeat with our own number, at most this many of our timeouts old, is another master's.
RIVAL_TIMEOUTS = 1.5
# The last frames are sent this often: one may be lost.
LAST_FRAMES = 2

# The settings that drives get.

HOLDS_AFTER_STOP = Write(
    canopen.QUICK_STOP_OPTION, DataType.I16, canopen.QuickStopOption.QUICK_RAMP_AND_STAY
)
# A quick stop if the heartbeat is missing.
STOPS_UNWATCHED = Write(canopen.HEARTBEAT_REACTION, DataType.I16, 3)
UNIT_OBJECTS = (canopen.SPEED_UNIT, canopen.ENCODER_INCREMENTS, canopen.ENCODER_TURNS)
# What a drive needs to stop by itself when this program dies; EDS files of many drives lack one:
# 6007 those of all Trinamic modules (PyTrinamic, TMCM-1276 and others) and of Yiyou's EuServo, 1016
# that of Technosoft's iPOS.
WATCH_OBJECTS = (canopen.CONSUMER_HEARTBEAT, canopen.HEARTBEAT_REACTION)
# Makes a drive in fault brake before it lets its motor go.
BRAKE = Write(canopen.FAULT_REACTION_OPTION, DataType.I16, 2)
MILLISECONDS = -3
_PROFILE_OBJECTS = 0x6000


def safety(*, watches: bool) -> tuple[Write, ...]:
    """Return the settings that must read back as written, or nothing is switched on."""
    return (STOPS_UNWATCHED, HOLDS_AFTER_STOP) if watches else (HOLDS_AFTER_STOP,)


def required_settings(io: Cia402Exchange, drive: Cia402Drive) -> tuple[Write, ...]:
    """Return the settings that a drive needs, as far as its unit of ramps is known."""
    writes = [*canopen.drive_pdos(drive.node), *safety(watches=io.watches)]
    if drive.ramp_unit_hz_s:
        ramp = drive.ramp(io.limits.quick_hz_s)
        writes.append(Write(canopen.QUICK_STOP_DECELERATION, DataType.U32, ramp))
    if io.is_cyclic:
        cycle_ms = round(io.limits.cycle_s * 1000.0)
        writes.append(Write(canopen.PERIOD, DataType.U8, cycle_ms))
        writes.append(Write(canopen.PERIOD_POWER, DataType.I8, MILLISECONDS))
    return tuple(writes)


def optional_settings(io: Cia402Exchange, node: int) -> tuple[Write, ...]:
    """Return settings that improve a drive, but that some drives lack."""
    settings = io.settings
    writes = [
        Write(canopen.SYNC_ID, DataType.U32, canopen.cob_id(canopen.Service.SYNC)),
        BRAKE,
        Write(canopen.FOLLOWING_ERROR_WINDOW, DataType.U32, settings.following_window),
        Write(canopen.FOLLOWING_ERROR_TIMEOUT_MS, DataType.U16, settings.following_ms),
        Write(canopen.PRODUCER_HEARTBEAT_MS, DataType.U16, settings.drive_heartbeat_ms),
        *(
            canopen.switched_off(direction, number, node)
            for direction in canopen.Direction
            for number in (2, 3, 4)
        ),
    ]
    if not io.watches:
        writes.append(heartbeat_watch(settings, on=False))
    return tuple(writes)


def heartbeat_watch(settings: Cia402Settings, *, on: bool) -> Write:
    """Return the setting that makes a drive watch this program's heartbeat, or none."""
    wanted = canopen.HeartbeatWatch(settings.master_id, settings.heartbeat_timeout_ms * on)
    return Write(canopen.CONSUMER_HEARTBEAT, DataType.U32, wanted.value if on else 0)


def _remedy(place: Place) -> str:
    if place in (canopen.PERIOD, canopen.PERIOD_POWER):
        return '. With strategy = "profile" it is not needed'
    return ". It is required; newer firmware of the drive may have it"


def connect(io: Cia402Exchange) -> Script[None]:
    """Find every drive, and set it up. Raises `Obstructed`. Nothing turns and no current changes.

    An earlier program may have left the drives in motion: they are waited for, then stopped.
    """
    io.transfers.shared.clear()
    yield from _recognise(io)
    yield from _end_earlier_motion(io)
    if io.transfers.shared:
        raise Obstructed(io.shared_words)
    yield from _set_up(io)
    yield from _start(io)
    for drive in io.drives:
        drive.order(drive.count)
        drive.fresh = not io.configured
    io.contacted = io.configured = True


def _recognise(io: Cia402Exchange) -> Script[None]:
    """Require that every node is a drive, and choose how they are driven."""
    io.last_command, settings = "SDO 1000", io.settings
    results = yield from _find(
        io,
        canopen.SERIAL_NUMBER,
        canopen.DEVICE_TYPE,
        canopen.SUPPORTED_MODES,
        canopen.PRODUCER_HEARTBEAT_MS,
        *(() if io.configured else (*WATCH_OBJECTS, *UNIT_OBJECTS)),
    )
    if io.rival_s > io.now_s - RIVAL_TIMEOUTS * settings.heartbeat_timeout_ms / 1000.0:
        raise Obstructed(
            f"another program sends heartbeats as node {settings.master_id} on this bus and may "
            "command these drives: end it first"
        )
    for result in results:
        _require_drive(result)
        if not io.configured:
            _adopt_units(settings, result)
        elif result.values.get(canopen.PRODUCER_HEARTBEAT_MS) not in (
            None,
            settings.drive_heartbeat_ms,
        ):
            result.drive.booted = True  # it has lost its settings
    if not io.configured:
        _choose_mode(io, results)


def _find(io: Cia402Exchange, *places: Place) -> Script[list[ReadObjects]]:
    """Read objects of every drive; wake drives that were stopped, and ask again.

    A stopped node does not answer, and sends nothing but its heartbeat.
    """
    jobs = dict.fromkeys(io.drives, places)
    results = yield from io.transfers.transfer(jobs)
    mute = [result.drive for result in results if result.mute]
    if 0 < len(mute) < len(results):  # if all are silent, that is told without another wait
        io.send_nmt(NmtCommand.PRE_OPERATIONAL, mute)
        results = yield from io.transfers.transfer(jobs)
        mute = [result.drive for result in results if result.mute]
    if mute:
        absence = io.absence(mute)
        raise Obstructed(io.shared_words or absence)  # the missing one may be one of the two
    return results


def _require_drive(result: ReadObjects) -> None:
    """Raise `Obstructed` unless a node is a drive of CiA 402."""
    if canopen.DEVICE_TYPE in result.refused:
        remedy = ". So it is not a CANopen device: check the ids of the arm file"
        raise Obstructed(result.refused[canopen.DEVICE_TYPE] + remedy)
    profile = result.values.get(canopen.DEVICE_TYPE, 0) & 0xFFFF
    if profile != DRIVES:
        raise Obstructed(
            f"{result.drive} reports device profile {profile}, not a drive of CiA {DRIVES}: check "
            "the ids of the arm file (`armdrive doctor --can`)"
        )


def _adopt_units(settings: Cia402Settings, result: ReadObjects) -> None:
    """Take a drive's units from the arm file, or from itself; else they stay unknown.

    Nanotec's CL4-E tells rpm when it is new (its EDS file), and maxon's EPOS4 has rpm and its
    decimal fractions only. Of drives without 60A9 nothing can be assumed (`measuring`).
    """
    drive, values = result.drive, result.values
    turns = max(values.get(canopen.ENCODER_TURNS, 1), 1)
    drive.turn = values.get(canopen.ENCODER_INCREMENTS, 0) / turns or settings.encoder_increments
    word = values.get(canopen.SPEED_UNIT, 0)
    drive.reported_unit_hz = canopen.speed_unit_hz(word, drive.turn) or 0.0
    speed_hz, ramp_hz_s = (
        units[drive.motor] if units else 0.0
        for units in (settings.speed_units, settings.ramp_units)
    )
    drive.speed_unit_hz = speed_hz or drive.reported_unit_hz
    drive.ramp_unit_hz_s = ramp_hz_s or drive.speed_unit_hz


def _choose_mode(io: Cia402Exchange, results: list[ReadObjects]) -> None:
    """Choose cyclic targets if all drives have that mode and the arm file allows it; else bursts.

    Bursts end by themselves. So drives that do not stop without this program's heartbeat get them
    too: when targets stop, some makers' drives go on (STOBER, ID 442454.02).
    """
    lacking = [
        (result.drive, place)
        for result in results
        for place in WATCH_OBJECTS
        if result.lacks(place)
    ]
    io.watches = not lacking
    for drive, place in lacking[:1]:
        io.warn(
            f"{drive} has no object {place}, so it would not stop without this program: the arm "
            "moves in bursts, which end by themselves"
        )
    words = (result.values.get(canopen.SUPPORTED_MODES, 0) for result in results)
    cyclic = all(OperationMode.CYCLIC_POSITION in canopen.supported_modes(word) for word in words)
    io.is_cyclic = cyclic and io.watches and io.settings.strategy == CYCLIC


def _end_earlier_motion(io: Cia402Exchange) -> Script[None]:
    """Wait until all drives stand, and stop those that do not."""
    both = dict.fromkeys(io.drives, (canopen.POSITION, canopen.STATUSWORD))
    yield from io.obtain(both)

    def turning() -> Script[list[Cia402Drive]]:
        """Return the drives that have turned since the last look. A sagging arm is found later."""
        before = {drive: drive.count for drive in io.drives}
        yield from wait(io, STILL_S)
        yield from io.obtain(both)
        return [
            drive
            for drive, count in before.items()
            if drive.holds and abs(drive.count - count) > drive.tremble
        ]

    def stop(drives: list[Cia402Drive]) -> Script[None]:
        yield from io.transfers.transfer(dict.fromkeys(drives, (STOP_WRITE,)))

    yield from end_earlier_motion(io, turning, stop)


def _set_up(io: Cia402Exchange) -> Script[None]:
    """Write the settings of every drive while it takes no part in PDOs, and verify them."""
    io.last_command = "SDO set-up"
    required = {drive: required_settings(io, drive) for drive in io.drives}
    for _ in range(TRIES):  # the order PRE_OPERATIONAL may have been lost
        io.send_nmt(NmtCommand.PRE_OPERATIONAL, io.drives)
        results = yield from io.obtain(required)
        refused = [each for result in results for each in result.refused.items()]
        if not refused:
            break
    for place, words in refused:
        raise Obstructed(words + _remedy(place))
    optional = {drive: optional_settings(io, drive.node) for drive in io.drives}
    for result in (yield from io.obtain(optional, lenient=True)):
        for place, words in result.refused.items():
            if place.index >= _PROFILE_OBJECTS and not io.configured:
                io.warn(words)
    yield from _verify(io, safety(watches=io.watches))


def _verify(io: Cia402Exchange, writes: tuple[Write, ...]) -> Script[None]:
    """Read back objects on which safety depends. Raises `Obstructed`."""
    places = tuple(write.place for write in writes)
    for result in (yield from io.obtain(dict.fromkeys(io.drives, places))):
        for write in writes:
            if result.values.get(write.place) != write.value:
                raise Obstructed(
                    f"{result.drive} does not keep {write.value} in object {write.place}, without "
                    "which it would not stop and hold when this program dies"
                )


def _start(io: Cia402Exchange) -> Script[None]:
    """Let the drives take part in PDOs, and read every position."""
    io.last_command = "SYNC"
    since_s, missing = io.now_s, list(io.drives)
    for _ in range(TRIES):
        io.send_nmt(NmtCommand.START, missing)
        yield from wait(io, io.limits.cycle_s)
        for _ in range(TRIES):
            yield from io.cycle()
            missing = [drive for drive in io.drives if drive.reported_s <= since_s]
            if not missing:
                return
    if len(missing) == len(io.drives):
        raise Obstructed(io.silence(io.began_s))
    raise Obstructed(
        f"{missing[0]} answers, but sends no PDO upon SYNC: another program may have set it up"
    )


# Currents and faults. Drives that hold also watch this program's heartbeat.


def read(io: Cia402Exchange) -> Script[Reply]:
    """Read every position, and report a drive that has moved although it should hold."""
    yield from io.look()
    for drive in io.drives:
        if io.on and not drive.is_near:
            io.notify(Trouble.OFF_TARGET.alert(drive))
            drive.order(drive.count)
    return io.registers()


def enable(io: Cia402Exchange) -> Script[Reply]:
    """Make every drive hold its motor where it is and watch this program's heartbeat."""
    io.on = False
    yield from io.look()
    for drive in io.drives:
        if drive.state in FAULTS:
            yield from io.explain(drive)
            raise Obstructed(Trouble.LOCKED.alert(drive).text)
    io.beats.begin(io.now_s)
    yield from _watch(io, on=True)
    yield from io.look()  # a hand may have turned a shaft meanwhile
    yield from hold(io, io.resting_mode)
    _forget_troubles(io)
    io.on = True
    return Done()


def disable(io: Cia402Exchange) -> Script[Reply]:
    """Switch every drive's motor off, even if not every drive ends its watch."""
    io.on = False
    reply: Reply = Done()
    try:
        yield from _watch(io, on=False)
    except Obstructed as obstructed:
        reply = obstructed.reply
    since_s = io.now_s
    left = yield from switch_off(io)
    if mute := [drive for drive in left if drive.reported_s < since_s]:
        raise Obstructed(io.absence(mute))
    for drive in left:
        raise Obstructed(RequestRejected(f"{drive} does not switch its motor off"))
    io.beats.end()
    return reply


def reset(io: Cia402Exchange) -> Script[Reply]:
    """Reset faults and leave quick stops. Currents stay as they are, and nothing moves."""
    yield from io.look()
    io.report_troubles()
    for drive in (yield from reset_faults(io)):
        yield from io.explain(drive)
        raise Obstructed(
            f"{Trouble.IN_FAULT.alert(drive).text}, and does not leave it: clear the cause, then "
            "call `reset()`"
        )
    held = [drive for drive in io.drives if drive.state in HOLDING]
    if held:
        yield from hold(io, io.resting_mode, held)
    _forget_troubles(io)
    io.on = len(held) == len(io.drives) and io.beats.due_s < math.inf
    return Done()


def shutdown_frames(io: Cia402Exchange) -> bytes:
    """Return frames that end the heartbeat watch: the drives then hold without an alarm."""
    if math.isinf(io.beats.due_s):
        return b""
    io.beats.end()
    if not io.watches:
        return b""
    write, frames = heartbeat_watch(io.settings, on=False), b""
    for _ in range(LAST_FRAMES):
        for drive in io.drives:
            frames += io.host.abandon(drive.node)
            frames += io.host.download(drive.node, write.place, write.data)
    return frames


def _forget_troubles(io: Cia402Exchange) -> None:
    for drive in io.drives:
        drive.booted = drive.alerted = drive.missed_heartbeat = False
        drive.error, drive.fell = "", None


def _watch(io: Cia402Exchange, *, on: bool) -> Script[None]:
    """Make the drives watch this program's heartbeat, or not, and verify that.

    A drive whose reaction is not set might let its motor go, so it watches nothing.
    """
    if not io.watches:
        return
    write = heartbeat_watch(io.settings, on=on)
    io.last_command = "SDO 1016"
    yield from io.put(dict.fromkeys(io.drives, (write,)))
    yield from _verify(io, (write,))
