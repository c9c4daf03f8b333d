"""Find an arm's drives, learn their abilities, and switch their current. Nothing moves.

Connecting to an arm, surveying a bus and setting a drive up all ask here for a drive's firmware,
whether it is alone, and why it does not move.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import NoReturn, TypeAlias

from armdrive.dialects.bus.drives import shared_words, unstopped_words
from armdrive.dialects.bus.homing import end_earlier_motion
from armdrive.dialects.exchange import TRIES, Obstructed
from armdrive.dialects.mks.drive import MksDrive, obeys_bus, setting_of
from armdrive.dialects.mks.exchange import MksExchange, MksScript, Script, is_done
from armdrive.dialects.mks.stops import halt, pushing_words, relieve
from armdrive.tasks import Alert, AlertKind, Done, ProtocolWarning, RequestRejected
from firmware_protocol.mks import (
    LATEST,
    Ability,
    ClearStall,
    Code,
    Enable,
    EnabledRead,
    Mode,
    MotorState,
    Read,
    ReadEnabled,
    ReadSetting,
    ReadStall,
    ReadState,
    ReadVersion,
    SetMode,
    StallRead,
    Version,
    VersionRead,
    abilities_of,
)
from firmware_protocol.mks import Request as Message

# The firmware of a drive. Before 1.0.8 it does not report its version, which then follows from the
# questions that it answers.

# A drive that reports braking stands if its count has not changed for this long. Firmware 1.0.6 was
# seen to report that for ever after a motion (riccardi-samuele/mks-servo, FAQ).
BRAKING_S = 0.2
TURNING = (
    MotorState.ACCELERATING,
    MotorState.FULL_SPEED,
    MotorState.DECELERATING,
    MotorState.HOMING,
)
# Assumed for a drive that reports neither its version nor a setting.
OLDEST: Version = (1, 0, 4)


@dataclass(frozen=True, slots=True)
class Firmware:
    """A drive's firmware: `reported` by the drive, or concluded from what it answers.

    `calibrated` and the number of its `board` are None if it reports neither.
    """

    version: Version = OLDEST
    reported: bool = False
    calibrated: bool | None = None
    board: int | None = None
    e_series: bool = False

    def __str__(self) -> str:
        return ".".join(map(str, self.version))


def firmware_of(
    io: MksExchange, drives: Collection[MksDrive]
) -> MksScript[dict[MksDrive, Firmware]]:
    """Find out the firmware of each drive."""
    answers = yield from io.read(ReadVersion(), drives)
    found = {}
    for drive in drives:
        read = answers.get(drive)
        if isinstance(read, VersionRead):
            found[drive] = Firmware(read.version, True, read.calibrated, read.board, read.e_series)
        else:
            mode = yield from io.reading(drive, ReadSetting(Code.MODE))
            found[drive] = Firmware(OLDEST if mode is None else Ability.READ_SETTINGS.since)
    return found


def series_words(name: object) -> str:
    """Return that a drive is of a series that armdrive does not drive."""
    return (
        f"{name} is of the E series (SERVO42E, 42ES, 57E). armdrive drives SERVO42D and SERVO57D: "
        "in the E series some commands mean something else (98 is no watchdog, 8C has one byte), "
        "and settings last only after a save (60). Nothing was written"
    )


# Why a drive does not follow its orders.

Words: TypeAlias = MksScript[str]


class TroubleKind(Enum):
    """What is wrong with a drive in motion."""

    LIMIT = "a limit switch has stopped it"
    UNFIT = "it has reported a stall, no current, or another mode"
    OFF_PATH = "it is not where it should be"
    SILENT = "it owes replies"


@dataclass(frozen=True, slots=True)
class Trouble:
    """What is wrong with a drive, and the nearest place where it should be."""

    drive: MksDrive
    kind: TroubleKind
    place: int = 0


def stalled_among(io: MksExchange, drives: Collection[MksDrive]) -> MksScript[list[MksDrive]]:
    """Return the drives whose stall protection has released the shaft."""
    found = yield from io.read(ReadStall(), drives)
    return [drive for drive, each in found.items() if each == StallRead(on=True)]


def off_among(io: MksExchange, drives: Collection[MksDrive]) -> MksScript[list[MksDrive]]:
    """Return the drives whose motors have no current."""
    found = yield from io.read(ReadEnabled(), drives)
    return [drive for drive, each in found.items() if each == EnabledRead(on=False)]


def mode_words(io: MksExchange, drive: MksDrive) -> Words:
    """Return that a drive is in a mode that the bus cannot move; empty if it is not."""
    if not io.can(Ability.READ_SETTINGS):
        return ""
    mode = yield from io.setting(drive, Code.MODE)
    if not isinstance(mode, SetMode) or obeys_bus(mode):
        return ""
    return (
        f"{drive} is in mode {mode.mode.title}, in which the bus moves nothing: set mode "
        f"{Mode.BUS_FOC.title} in its menu, or run `armdrive doctor --fix`"
    )


def ask_fitness(io: MksExchange, drive: MksDrive) -> None:
    """Ask a moving drive what may keep it from moving; its `unfit` takes the answers.

    Waits for nothing, since the other drives are still moving and a stop must not wait.
    """
    questions: list[Read | ReadSetting] = [ReadStall(), ReadEnabled()]
    if io.can(Ability.READ_SETTINGS):
        questions.append(ReadSetting(Code.MODE))
    for question in questions:
        io.put(drive, question)


def explain(io: MksExchange, trouble: Trouble) -> MksScript[Alert]:
    """Find out why a drive is in trouble, and what that means for the arm."""
    drive = trouble.drive
    if trouble.kind is TroubleKind.LIMIT:
        words = f"{drive} has run into a limit switch, which stopped it"
        return Alert(AlertKind.ALARM_LOST, words)
    if (yield from stalled_among(io, (drive,))):
        return Alert(AlertKind.SWITCHED_OFF, stall_words(drive))
    if drive.restarted:
        return Alert(
            AlertKind.RESTARTED,
            f"{drive} was reset or lost its power: it counts from zero again",
        )
    if (yield from off_among(io, (drive,))):
        return Alert(AlertKind.SWITCHED_OFF, f"{drive} has switched its motor off")
    mode = yield from mode_words(io, drive)
    return Alert(AlertKind.OFF_PATH, mode or off_path_words(drive, trouble.place))


def stall_words(drive: MksDrive) -> str:
    """Return that a drive's stall protection has acted."""
    return (
        f"{drive} has stalled, and its protection has released the shaft: find "
        "out what blocked it, or give it more current or less speed"
    )


def off_path_words(drive: MksDrive, place: int) -> str:
    """Return how far a drive is from where it should be, and the likely causes."""
    return (
        f"{drive} is at {drive.count} counts, {abs(drive.count - place)} from where it should be: "
        "it is blocked or overloaded, was turned by force or reset, got its orders late, or cannot "
        "follow them, since its supply or its ramp is too weak, or its firmware slows down at new "
        "targets in motion (`segment_s = 0` under [mks] sends none)"
    )


REPLIES_OFF = (
    "answers queries, but does not confirm orders: its replies are off. Set them to full "
    "(`armdrive doctor --fix`, or code 8C with 01 01)"
)
NO_SUCH_ORDER = (
    "it may be in a mode in which it ignores motion commands: set mode "
    f"{Mode.BUS_FOC.title} in its menu"
)
# What to do about an id that more than one drive answers to.
OWN_ID = (
    "every drive ships with id 1. Unplug all but one and give each an id of its own, one at a time"
)


# Bringing all drives to the state in which they stand, reply and hold.


def connect(io: MksExchange) -> MksScript[None]:
    """Find every drive and wait until all stand. Raises `Obstructed` if that fails."""
    began_s, io.last_command = io.now_s, "READ ENCODER"
    io.surplus.clear()
    for _ in range(TRIES):
        if missing := (yield from io.look()):
            yield from _refuse_absent(io, missing, began_s)
    if words := (yield from _shared_words(io)):
        raise Obstructed(words)
    yield from _recognise(io)
    yield from _end_earlier_motion(io)
    for drive in io.drives:
        drive.target, drive.fresh = drive.count, True
        drive.stand(io.now_s)
    io.watched = not (yield from _unwatched(io))
    io.connected = True


def _refuse_absent(
    io: MksExchange, missing: Sequence[MksDrive], since_s: float
) -> MksScript[NoReturn]:
    """Raise `Obstructed` for missing drives; they may have the ids of others."""
    absence = io.absence(missing, since_s)
    if isinstance(absence, RequestRejected):
        there = [drive for drive in io.drives if drive not in missing]
        for _ in range(TRIES):
            yield from io.look(there)
        if shared := (yield from _shared_words(io)):
            raise Obstructed(f"{absence.reason}. And {shared}")
    raise Obstructed(absence)


def _shared_words(io: MksExchange) -> Words:
    """Wait for the answers of a second drive; return which ids two drives answer to."""
    yield from io.pause(io.now_s + io.settings.answer_s)
    return shared_words(io.surplus.shared, "id", OWN_ID)


def _recognise(io: MksExchange) -> MksScript[None]:
    """Learn the abilities that all drives have: those of the oldest firmware."""
    version = io.settings.version
    if version is None:
        found = yield from firmware_of(io, io.drives)
        for drive, each in found.items():
            if each.e_series:
                raise Obstructed(series_words(drive))
        version = min(LATEST, *(each.version for each in found.values()))
    io.firmware = str(Firmware(version))
    io.able = abilities_of(version)


def _end_earlier_motion(io: MksExchange) -> MksScript[None]:
    """Wait until all drives stand, and stop those that do not."""
    return end_earlier_motion(
        io, lambda: _turning(io), lambda drives: _stop(io, drives), lambda drive: drive.homes
    )


def _turning(io: MksExchange) -> MksScript[list[MksDrive]]:
    """Return the drives that turn. Raises `Obstructed` if one calibrates its encoder.

    A stop would leave that one without a calibration.
    """
    yield from io.read(ReadState())
    yield from io.require_positions()
    turning = []
    for drive in io.drives:
        if drive.state is MotorState.CALIBRATING:
            raise Obstructed(
                f"{drive} is calibrating: wait until it has finished. If it does not, "
                "switch its supply off and on: one that cannot turn its motor stays so"
            )
        drive.homes = drive.state is MotorState.HOMING
        # some firmware reports braking for ever
        brakes = drive.state is MotorState.DECELERATING
        stands = brakes and drive.stands(-math.inf, BRAKING_S)
        if drive.state in TURNING and not stands:
            turning.append(drive)
    if turning:
        yield from io.pause(io.now_s + io.settings.poll_s)
    return turning


def _stop(io: MksExchange, drives: Sequence[MksDrive]) -> MksScript[None]:
    """Stop drives. Raises `Obstructed` if one does not come to rest."""
    left = yield from halt(io, drives, hard=any(drive.homes for drive in drives))
    if left:
        raise Obstructed(unstopped_words(left[0]))


def read(io: MksExchange) -> Script:
    """Read every encoder, and find out why a drive has moved that should hold its place."""
    yield from io.require_positions()
    for drive in io.drives:
        if not io.on or drive.moving or drive.is_near:
            continue
        trouble = Trouble(drive, TroubleKind.OFF_PATH, drive.target)
        io.notify((yield from explain(io, trouble)))
        drive.stand(io.now_s)
    return io.registers()


def adopt_positions(io: MksExchange) -> MksScript[None]:
    """Read where the drives stand, and take that for their targets."""
    yield from io.require_positions()
    for drive in io.drives:
        drive.stand(io.now_s)


def _adopt_and_relieve(io: MksExchange) -> MksScript[None]:
    """Adopt the drives' positions, and relieve those that push.

    A drive may have been blocked when its last program died or its cable was lost. It would
    spring to its set-point as soon as it comes free.
    """
    yield from adopt_positions(io)
    pushing = yield from relieve(io, io.drives)
    for drive, off in pushing.items():
        if why := (yield from mode_words(io, drive)):  # it obeys nothing, and pushes
            raise Obstructed(why)
        io.notify(ProtocolWarning(pushing_words(drive, off)))
    yield from adopt_positions(io)


def enable(io: MksExchange) -> Script:
    """Make every drive hold its motor where it is, and switch on its watchdog."""
    io.on = False
    yield from adopt_positions(io)
    if stalled := (yield from stalled_among(io, io.drives)):
        raise Obstructed(f"{stall_words(stalled[0])}; `reset()` clears that")
    for drive in io.drives:  # before any is switched on: else some would hold, others not
        if words := (yield from mode_words(io, drive)):
            raise Obstructed(words)
    yield from _command(io, Enable(on=True), "ENABLE")
    if off := (yield from off_among(io, io.drives)):
        raise Obstructed(f"{off[0]} does not switch its motor on")
    io.watched = yield from _watch(io)
    io.on = True
    yield from _adopt_and_relieve(io)
    return Done()


def disable(io: MksExchange) -> Script:
    """Switch every drive's motor off."""
    io.on = False
    yield from _command(io, Enable(on=False), "DISABLE")
    return Done()


def _unwatched(io: MksExchange) -> MksScript[list[MksDrive]]:
    """Return the drives that do not report the arm file's watchdog."""
    if not io.watchable:
        return list(io.drives)
    answers = yield from io.read(ReadSetting(Code.WATCHDOG))
    return [drive for drive in io.drives if setting_of(answers.get(drive)) != io.watchdog]


def _watch(io: MksExchange) -> MksScript[bool]:
    """Switch on the watchdog of every drive; return whether it is certainly on in all.

    A drive keeps it in a memory that wears out, so it is written only where it differs.
    """
    for _ in range(TRIES if io.watchable else 0):
        other = yield from _unwatched(io)
        if not other:
            return True
        yield from io.ask(dict.fromkeys(other, io.watchdog), text="WATCHDOG")
    return not (yield from _unwatched(io))


def _command(io: MksExchange, message: Message, text: str) -> MksScript[None]:
    """Send every drive a command that is safe to repeat.

    Raises `Obstructed` if one does not obey.
    """
    began_s = io.now_s
    found = yield from io.ask(dict.fromkeys(io.drives, message), text=text)
    if missing := [drive for drive in io.drives if drive not in found]:
        silent = yield from io.look(missing)
        replies = f"{missing[0]} {REPLIES_OFF}"
        raise Obstructed(io.absence(missing, began_s) if silent else replies)
    for drive, reply in found.items():
        if not is_done(reply):
            why = yield from mode_words(io, drive)
            raise Obstructed(why or f"{drive} refused {text}: {NO_SUCH_ORDER}")


def reset(io: MksExchange) -> Script:
    """Clear stalls. Motor currents stay as they are, and nothing moves."""
    yield from _end_earlier_motion(io)
    stalled = yield from stalled_among(io, io.drives)
    if stalled:
        yield from io.ask(dict.fromkeys(stalled, ClearStall()), text="CLEAR STALL")
    yield from _adopt_and_relieve(io) if io.on else adopt_positions(io)
    return Done()
