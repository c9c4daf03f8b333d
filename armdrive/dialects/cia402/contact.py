"""Find an arm's CiA 402 drives, set them up, switch their current, and clear their faults.

None of it moves anything.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NoReturn

from armdrive.dialects.bus.phases import end_earlier_motion
from armdrive.dialects.cia402.drives import (
    FAULTS,
    Cia402Drive,
    off_target_alert,
)
from armdrive.dialects.cia402.exchange import (
    STOP_WRITE,
    Cia402Exchange,
    Results,
    Script,
    SdoResult,
)
from armdrive.dialects.cia402.objects import DRIVES
from armdrive.dialects.cia402.settings import Cia402Settings
from armdrive.dialects.exchange import TRIES, Obstructed
from armdrive.tasks import Done, ProtocolWarning, Reply, RequestRejected
from firmware_protocol import canopen
from firmware_protocol.canopen import DataType, DriveState, NmtCommand, Place, Write

# A drive has stopped if it has not turned for this long: three periods of SYNC by default.
STILL_S = 0.03
# A heartbeat with our own number, at most this many of our timeouts old, is another master's.
RIVAL_TIMEOUTS = 1.5

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


def required_settings(
    node: int, quick_slope: int | None, cycle_ms: int | None, *, watches: bool = True
) -> tuple[Write, ...]:
    """Return the settings that every drive needs. `quick_slope` is in the drive's unit, if known.

    `cycle_ms` is None if no cyclic mode is used. Drives that `watches` is false for react to no
    missing heartbeat.
    """
    received, transmitted = canopen.drive_pdos(node)
    ramps = () if quick_slope is None else (quick_slope,)
    cyclic = (
        Write(canopen.PERIOD, DataType.U8, cycle_ms or 0),
        Write(canopen.PERIOD_POWER, DataType.I8, MILLISECONDS),
    )
    return (
        *received.writes,
        *transmitted.writes,
        *safety(watches=watches),
        *(Write(canopen.QUICK_STOP_DECELERATION, DataType.U32, each) for each in ramps),
        *(cyclic if cycle_ms else ()),
    )


def optional_settings(settings: Cia402Settings, node: int) -> tuple[Write, ...]:
    """Return settings that improve a drive, but that some drives lack."""
    return (
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
    )


def heartbeat_watch(settings: Cia402Settings, *, on: bool) -> Write:
    """Return the setting that makes a drive watch this program's heartbeat, or none."""
    wanted = canopen.HeartbeatWatch(settings.master_id, settings.heartbeat_timeout_ms * on)
    return Write(canopen.CONSUMER_HEARTBEAT, DataType.U32, wanted.value if on else 0)


def _remedy(place: Place) -> str:
    if place in (canopen.PERIOD, canopen.PERIOD_POWER):
        return '. With strategy = "profile" it is not needed'
    return ". It is required; newer firmware of the drive may have it"


class Cia402Contact:
    """Finds every drive, sets it up, reads its position, switches its current and clears faults."""

    def __init__(self, io: Cia402Exchange) -> None:
        self.io, self.group = io, io.group
        self.states, self.transfers = io.states, io.transfers

    def connect(self) -> Script[None]:
        """Make contact with every drive. Raises `Obstructed` if that fails."""
        inbox = self.group.inbox
        inbox.shared.clear()
        yield from self._recognise()
        yield from self._end_earlier_motion()
        if inbox.shared:
            raise Obstructed(inbox.shared_words)
        yield from self._write_required()
        yield from self._write_optional()
        settings = safety(watches=self.group.watches)
        yield from self.transfers.verify(settings, "with which it would stop and hold")
        yield from self._start()
        for drive in self.io.drives:
            drive.rest()
            drive.shaft.fresh = not self.group.configured
        self.group.contacted = self.group.configured = True

    def _recognise(self) -> Script[None]:
        """Identify every drive, and choose the mode in which they are driven."""
        self.io.last_command = "SDO 1000"
        known = self.group.configured
        results = yield from self._find(
            canopen.SERIAL_NUMBER,
            canopen.DEVICE_TYPE,
            canopen.SUPPORTED_MODES,
            canopen.PRODUCER_HEARTBEAT_MS,
            *(() if known else (*WATCH_OBJECTS, *UNIT_OBJECTS)),
        )
        self._require_no_rival()
        for result in results.values():
            self._require_drive(result)
        if known:
            period_ms = self.io.settings.drive_heartbeat_ms
            for result in results.values():
                found_ms = result.values.get(canopen.PRODUCER_HEARTBEAT_MS, period_ms)
                result.drive.booted |= found_ms != period_ms  # it has lost its settings
        else:
            self.group.watches = not self._unwatching(results)
            for result in results.values():
                self._adopt_units(result)
        words = [result.values.get(canopen.SUPPORTED_MODES) for result in results.values()]
        modes = [canopen.supported_modes(word & 0xFFFF_FFFF) for word in words if word is not None]
        self.group.choose_mode(frozenset.intersection(*modes) if modes else frozenset())

    def _require_no_rival(self) -> None:
        """Raise `Obstructed` if another program sends heartbeats with this program's number."""
        settings = self.io.settings
        rival_s = RIVAL_TIMEOUTS * settings.heartbeat_timeout_ms / 1000.0
        if self.group.rival_s > self.io.now_s - rival_s:
            raise Obstructed(
                f"another program sends heartbeats as node {settings.master_id} on this bus and "
                "may command these drives: end it first"
            )

    @staticmethod
    def _require_drive(result: SdoResult) -> None:
        """Raise `Obstructed` unless a node is a drive of CiA 402."""
        if canopen.DEVICE_TYPE in result.refused:
            remedy = ". So it is not a CANopen device: check the ids of the arm file"
            raise Obstructed(result.refused[canopen.DEVICE_TYPE] + remedy)
        profile = result.values.get(canopen.DEVICE_TYPE, 0) & 0xFFFF
        if profile != DRIVES:
            raise Obstructed(
                f"{result.drive} reports device profile {profile}, not a drive of CiA "
                f"{DRIVES}: check the ids of the arm file (`armdrive doctor --can`)"
            )

    def _adopt_units(self, result: SdoResult) -> None:
        """Take a drive's units from the arm file, or from itself; else they stay unknown.

        Nanotec's CL4-E tells rpm when it is new (its EDS file), and maxon's EPOS4 has rpm and its
        decimal fractions only. Of drives without 60A9 nothing can be assumed (`measuring`).
        """
        drive, settings = result.drive, self.io.settings
        increments = result.values.get(canopen.ENCODER_INCREMENTS, 0)
        turns = result.values.get(canopen.ENCODER_TURNS, 1)
        drive.turn = increments / max(turns, 1) or settings.encoder_increments
        word = result.values.get(canopen.SPEED_UNIT, 0) & 0xFFFF_FFFF
        drive.reported_unit_hz = canopen.speed_unit_hz(word, drive.turn) or 0.0
        speed_hz, ramp_hz_s = (
            units[drive.motor] if units else 0.0
            for units in (settings.speed_units, settings.ramp_units)
        )
        drive.speed_unit_hz = speed_hz or drive.reported_unit_hz
        drive.ramp_unit_hz_s = ramp_hz_s or drive.speed_unit_hz

    def _unwatching(self, results: Results) -> bool:
        """Return whether a drive cannot stop by itself when this program dies, and warn of it."""
        lacking = [
            (result.drive, place)
            for result in results.values()
            for place in WATCH_OBJECTS
            if place in result.lacking
        ]
        for drive, place in lacking[:1]:
            self.io.notify(
                ProtocolWarning(
                    f"{drive} has no object {place}, so it would not stop without this program: "
                    "the arm moves in bursts, which end by themselves"
                )
            )
        return bool(lacking)

    def _find(self, *places: Place) -> Script[Results]:
        """Read objects of every drive; wake drives that were stopped, and ask again.

        A stopped node does not answer, and sends nothing but its heartbeat.
        """
        jobs = self.transfers.of_each(*places)
        results = yield from self.transfers.transfer(jobs)
        mute = [result.drive for result in results.values() if result.mute]
        if 0 < len(mute) < len(results):
            self.io.send_nmt(NmtCommand.PRE_OPERATIONAL, mute)
            one = {drive.node: (canopen.DEVICE_TYPE,) for drive in mute}
            woken = yield from self.transfers.transfer(one, tries=1)
            if not all(result.mute for result in woken.values()):
                results = yield from self.transfers.transfer(jobs)
                mute = [result.drive for result in results.values() if result.mute]
        if not mute:
            return results
        reply, inbox = self.io.absence(mute), self.group.inbox
        if isinstance(reply, RequestRejected) and inbox.shared:  # it may be one of the two
            reply = replace(reply, reason=f"{reply.reason}. And {inbox.shared_words}")
        raise Obstructed(reply)

    def _end_earlier_motion(self) -> Script[None]:
        """Wait until all drives stand, and stop those that do not."""
        both = self.transfers.of_each(canopen.POSITION, canopen.STATUSWORD)
        yield from self.transfers.obtain(both)

        def turning() -> Script[list[Cia402Drive]]:
            """Return the drives that have turned since the last look, and hold their motors.

            A sagging arm is found later.
            """
            before = {drive: drive.shaft.count for drive in self.io.drives}
            yield from self.io.wait(self.io.now_s + STILL_S)
            yield from self.transfers.obtain(both)
            return [
                drive
                for drive, count in before.items()
                if drive.holds and abs(drive.shaft.count - count) > drive.shaft.bounds.tremble
            ]

        yield from end_earlier_motion(self.io, turning, self._quick_stop)

    def _quick_stop(self, drives: list[Cia402Drive]) -> Script[None]:
        """Stop drives that take no part in PDOs yet."""
        yield from self.transfers.transfer({drive.node: (STOP_WRITE,) for drive in drives})

    def _write_required(self) -> Script[None]:
        """Write the settings that every drive needs, while it takes no part in PDOs."""
        self.io.last_command = "SDO set-up"
        cyclic = self.group.resting_mode is canopen.OperationMode.CYCLIC_POSITION
        cycle_ms = round(self.io.cycle_s * 1000.0) if cyclic else None
        jobs = {
            node: required_settings(
                node,
                drive.ramp(self.io.limits.quick_hz_s) if drive.ramp_unit_hz_s else None,
                cycle_ms,
                watches=self.group.watches,
            )
            for node, drive in self.group.by_node.items()
        }
        for _ in range(TRIES):  # the order PRE_OPERATIONAL may have been lost
            self.io.send_nmt(NmtCommand.PRE_OPERATIONAL, self.io.drives)
            results = yield from self.transfers.obtain(jobs)
            refused = [each for result in results.values() for each in result.refused.items()]
            if not refused:
                return
        for place, words in refused:
            raise Obstructed(words + _remedy(place))

    def _write_optional(self) -> Script[None]:
        """Write the optional settings; warn once of those that a drive lacks."""
        unwatched = () if self.group.watches else (heartbeat_watch(self.io.settings, on=False),)
        jobs = {
            node: (*optional_settings(self.io.settings, node), *unwatched)
            for node in self.group.by_node
        }
        results = yield from self.transfers.obtain(jobs, lenient=True)
        for result in results.values():
            for place, words in result.refused.items():
                if place.index >= _PROFILE_OBJECTS and not self.group.configured:
                    self.io.notify(ProtocolWarning(words))

    def _start(self) -> Script[None]:
        """Let the drives take part in PDOs, and read every position."""
        self.io.last_command = "SYNC"
        missing = self.io.drives
        for _ in range(TRIES):
            self.io.send_nmt(NmtCommand.START, missing)
            yield from self.io.wait(self.io.now_s + self.io.cycle_s)
            missing = yield from self.io.look()
            if not missing:
                return
        if len(missing) == len(self.io.drives):
            raise Obstructed(self.io.silence(self.io.began_s))
        raise Obstructed(
            f"{missing[0]} answers, but sends no PDO upon SYNC: another program may have set it up"
        )

    # -- current and faults -------------------------------------------------------------------
    #
    # Drives that hold also watch this program's heartbeat.

    def read(self) -> Script[Reply]:
        """Read every position, and report a drive that has moved although it should hold."""
        yield from self.io.require_positions()
        for drive in self.group.off_target if self.group.on else ():
            self.io.notify(off_target_alert(drive))
            drive.rest()
        return self.group.registers()

    def switch_on(self) -> Script[Reply]:
        """Make every drive hold its motor where it is and watch this program's heartbeat."""
        self.group.on = False
        yield from self.io.require_positions()
        for drive in self.io.drives:
            if drive.state in FAULTS:
                yield from self._refuse(drive)
        self.io.beats.begin(self.io.now_s)
        yield from self._watch(on=True)
        yield from self.io.require_positions()  # a hand may have turned a shaft
        for drive in (yield from self.states.bring(self.io.drives, DriveState.ENABLED)):
            yield from self._refuse(drive)
        yield from self.states.hold_here(self.io.drives)
        yield from self._adopt_positions()
        self.group.on = True
        return Done()

    def _refuse(self, drive: Cia402Drive) -> Script[NoReturn]:
        """Raise `Obstructed` with the reason why a drive is not switched on."""
        yield from self.transfers.explain(drive)
        if drive.state in FAULTS:
            raise Obstructed(drive.locked_words)
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
        left = yield from self.states.bring(self.io.drives, DriveState.DISABLED)
        off = [drive for drive in left if drive.state not in FAULTS]
        if mute := [drive for drive in off if not drive.has_just_reported]:
            raise Obstructed(self.io.absence(mute))
        for drive in off:
            raise Obstructed(RequestRejected(f"{drive} does not switch its motor off"))
        self.io.beats.end()
        return reply

    def clear(self) -> Script[Reply]:
        """Reset faults and leave quick stops. Currents stay as they are, and nothing moves."""
        yield from self.io.require_positions()
        for drive in self.io.drives:
            self.group.report(drive)  # faults that were not reported yet
        faulty = [drive for drive in self.io.drives if drive.state in FAULTS]
        for drive in (yield from self.states.reset_faults(faulty)):
            yield from self.transfers.explain(drive)
            words = (
                f"{drive.fault_words}, and does not leave it: clear the cause, then call `reset()`"
            )
            raise Obstructed(words)
        yield from self.states.leave_quick_stop(self.io.drives)
        yield from self._adopt_positions()
        held = all(drive.state is DriveState.ENABLED for drive in self.io.drives)
        self.group.on = self.io.beats.on and held
        return Done()

    def shutdown_frames(self) -> bytes:
        """Return frames that end the heartbeat watch: the drives then hold without an alarm."""
        if not self.io.beats.on:
            return b""
        self.io.beats.end()
        if not self.group.watches:
            return b""
        return self.transfers.unanswered_writes(heartbeat_watch(self.io.settings, on=False))

    def _adopt_positions(self) -> Script[None]:
        """Adopt every drive's position as its target, and forget its past faults."""
        yield from self.io.require_positions()
        for drive in self.group.off_target:
            drive.rest()
        for drive in self.io.drives:
            drive.recover()

    def _watch(self, *, on: bool) -> Script[None]:
        """Make the drives watch this program's heartbeat, or not, and verify that.

        A drive whose reaction is not set might let its motor go, so it watches nothing.
        """
        if not self.group.watches:
            return
        write = heartbeat_watch(self.io.settings, on=on)
        self.io.last_command = "SDO 1016"
        yield from self.transfers.carry_out(self.transfers.of_each(write), _remedy)
        yield from self.transfers.verify((write,), "without which it would not stop")
