"""Bringing the drives from one state to another: held, stopped, off, out of a fault."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from itertools import cycle
from types import MappingProxyType

from armdrive.dialects.bus.drives import LAST_TRY_S
from armdrive.dialects.cia402.drives import FAULTS, HOLDING, Cia402Drive
from armdrive.dialects.cia402.exchange import LOST_CYCLES, Cia402Exchange
from armdrive.dialects.cia402.transfers import Job, Script
from armdrive.dialects.exchange import Obstructed
from firmware_protocol.canopen import (
    CONTROLWORD,
    POSITION,
    STATUSWORD,
    Command,
    Controlword,
    DataType,
    DriveState,
    OperationMode,
    Write,
    mode_of,
)
from firmware_protocol.fields import in_words

ENABLE = Controlword.of(Command.ENABLE_OPERATION)
DISABLE = Controlword.of(Command.DISABLE_VOLTAGE)
STOP = Controlword.of(Command.QUICK_STOP)
STOP_WRITE = Write(CONTROLWORD, DataType.U16, STOP.value)
TOWARDS_ENABLED: Mapping[DriveState | None, Controlword] = MappingProxyType(
    {
        DriveState.DISABLED: Controlword.of(Command.SHUT_DOWN),
        DriveState.READY: Controlword.of(Command.SWITCH_ON),
    }
)
# Drives obey within this time; simulated ones need three cycles to switch on.
RESPONSE_S = 1.0
# A drive stands once it was read in one place for this many cycles ...
STAND_CYCLES = 3
# ... and a stop is obeyed and reported within this many.
STOP_CYCLES = 2
# A drive that has neither reported nor answered for this long is mute.
MUTE_S = 0.4


def stands_for_s(io: Cia402Exchange) -> float:
    """Return for how long a drive is read in one place before it counts as standing.

    With short cycles and a wide window, a drive that brakes stays within its tremble for longer
    than some cycles: for as long as the end of its ramp takes.
    """
    ramp_end_s = io.limits.ramp_end_s(io.drives[0].tremble)
    return max(STAND_CYCLES * io.limits.cycle_s, ramp_end_s) - 1e-9


def hold(
    io: Cia402Exchange, mode: OperationMode, drives: Collection[Cia402Drive] = ()
) -> Script[None]:
    """Make drives (by default all) hold where they stand: enabled, and in a mode.

    Each turns to the goal that it gets with the word that enables it, so that is its position. A
    shaft that was pressed against something may spring back meanwhile. So positions are adopted
    only once all shafts stand still. Raises `Obstructed` for a drive that does not get there.
    """
    profile, began_s = mode is OperationMode.PROFILE_POSITION, io.listened.s
    drives = drives or io.drives
    # a quick stop ends where its ramp ends, and a blocked shaft is not there
    handed = {drive for drive in drives if drive.state is DriveState.ENABLED and drive.is_near}
    if all(drive in handed and drive.mode == mode for drive in drives):
        return

    def is_held(drive: Cia402Drive) -> bool:
        taken = not profile or (drive in handed and drive.handshake.taken)
        enabled = drive.state is DriveState.ENABLED and drive.mode == mode
        return enabled and taken and drive.is_near and _is_still(io, drive)

    resumed = False
    while left := [drive for drive in drives if not is_held(drive)]:
        if io.listened.s > began_s + RESPONSE_S:
            raise Obstructed(_unheld_words(left[0], mode))
        stopped = [drive for drive in drives if drive.state is DriveState.QUICK_STOP]
        # In their mode first, or they would go on in the old one; and all at once: two shafts that
        # press against each other turn if one of them lets go.
        ready = all(drive.mode == mode and _is_still(io, drive) for drive in stopped)
        for drive in drives:
            enabled, word = drive.state is DriveState.ENABLED, ENABLE
            if drive in stopped and not resumed:
                drive.offer(drive.count)
                word = ENABLE if ready else STOP
            elif not enabled:
                drive.offer(drive.count)
                word = TOWARDS_ENABLED.get(drive.state, ENABLE)
            elif drive not in handed:
                drive.offer(drive.count)
                handed.add(drive)
            if enabled and profile:
                word = drive.handshake.controlword
            io.command(drive, word, mode, drive.goal)
        resumed = resumed or (ready and bool(stopped))
        yield from io.cycle()


def _is_still(io: Cia402Exchange, drive: Cia402Drive) -> bool:
    return drive.still_for_s >= stands_for_s(io)


def _unheld_words(drive: Cia402Drive, mode: OperationMode) -> str:
    if drive.state is DriveState.QUICK_STOP:
        return (
            f"{drive} holds in its quick stop and no command brings it back: support the arm, call "
            "`disable()`, then call `enable()`"
        )
    if drive.state is not DriveState.ENABLED:
        state = "in no state" if drive.word is None else f"at {drive.word}"
        return (
            f"{drive} does not switch its motor on, it stays {state}: check the motors' supply and "
            "the drive's own enable input"
        )
    if drive.mode != mode:
        return (
            f"{drive} does not take mode {int(mode)} ({in_words(mode)}), it reports {drive.mode}: "
            "another program may command it"
        )
    return f"{drive} does not stay where it is: something turns it. Then call `reset()`"


def stop(io: Cia402Exchange) -> Script[tuple[Cia402Drive, ...]]:
    """Stop all drives; return those that are not known to stand.

    The stop is repeated until a drive is seen to stand. One that sends no reports is stopped and
    read by SDO: it may have left the bus's operation, because another program ordered that or
    because it missed a heartbeat (CiA 301, object 1029).
    """
    io.last_command, asked_s, began_s = "QUICK STOP", io.now_s, io.listened.s
    acts_s = asked_s + STOP_CYCLES * io.limits.cycle_s
    ends_s = began_s + io.limits.quick_stop_s(io.limits.fastest_hz) + RESPONSE_S
    objects: dict[Cia402Drive, cycle[Job]] = {}

    def stands(drive: Cia402Drive) -> bool:
        if drive.state not in (None, *HOLDING):
            return True  # it has switched its motor off
        still_s = drive.read_s - max(drive.still_s, acts_s)
        return drive.state is DriveState.QUICK_STOP and still_s >= stands_for_s(io)

    while left := [drive for drive in io.drives if not stands(drive)]:
        mute = all(drive.read_s < asked_s for drive in left)
        if io.listened.s > (began_s + MUTE_S if mute else ends_s):
            break
        for drive in left:
            # in its present mode, so that the stop changes nothing else
            io.command(drive, STOP, mode_of(drive.mode) or io.resting_mode, drive.count)
            if drive.missed > LOST_CYCLES or not drive.operates:
                jobs = objects.setdefault(drive, cycle((STOP_WRITE, STATUSWORD, POSITION)))
                late = io.now_s > drive.asked_s + io.settings.answer_s + LAST_TRY_S
                if drive.answer is not None or late:
                    io.transfers.ask(drive, next(jobs))
        yield from io.cycle()
    io.transfers.give_up(objects)
    return tuple(left)


def repeat(
    io: Cia402Exchange,
    left: Callable[[], list[Cia402Drive]],
    word: Callable[[Cia402Drive, int], Controlword],
) -> Script[list[Cia402Drive]]:
    """Repeat a command in each cycle until no drive is left; return those that take too long."""
    began_s, turn = io.listened.s, 0
    while (drives := left()) and io.listened.s < began_s + RESPONSE_S:
        for drive in drives:
            io.command(drive, word(drive, turn), io.resting_mode, drive.count)
        turn += 1
        yield from io.cycle()
    return drives


def switch_off(io: Cia402Exchange) -> Script[list[Cia402Drive]]:
    """Switch all motors off; return the drives that do not obey."""
    on = (None, DriveState.SWITCHED_ON, *HOLDING)
    return repeat(
        io,
        lambda: [drive for drive in io.drives if drive.state in on],
        lambda _drive, _turn: DISABLE,
    )


def reset_faults(io: Cia402Exchange) -> Script[list[Cia402Drive]]:
    """Reset the drives' faults by a rising edge; return those that stay in fault."""
    words = (Controlword(0), Controlword.of(Command.FAULT_RESET))
    return repeat(
        io,
        lambda: [drive for drive in io.drives if drive.state in FAULTS],
        lambda _drive, turn: words[turn % 2],
    )
