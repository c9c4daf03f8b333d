"""Bringing CiA 402 drives from one state to another: on, off, out of a fault, to a stand-still.

Nothing here moves a motor: a drive that gets its current is told before that it is where it should
be. A stop is the drive's own quick stop; when it stands it is taken back from there, and holds.
"""

from __future__ import annotations

from collections.abc import Collection, Generator

from armdrive.dialects.cia402.cycle import ENABLE, STOP, Cia402Cycle
from armdrive.dialects.cia402.drive import Cia402Drive
from armdrive.dialects.cia402.master import Heard
from armdrive.dialects.cia402.receive import FAULTS
from armdrive.tasks import RequestRejected, Timeout
from firmware_protocol.canopen import (
    Command,
    Controlword,
    DriveState,
    OperationMode,
    way,
)

BRING_S = 1.0
"""So long a drive may take from one state to another."""
STAND_TURNS = 3
"""A drive that braked stands when it has not turned for so many turns."""
BRAKING_S = 1.0
"""So much longer than its ramp a drive may take to stand."""

_TO_BE_STOPPED = (None, DriveState.ENABLED, DriveState.QUICK_STOP)
"""One that has stopped by itself, too: what it was told before, and waits for a SYNC, is void."""

Unmoved = Generator[float, Heard | None, tuple[Cia402Drive, ...]]
Hindrance = Generator[float, Heard | None, Timeout | RequestRejected | None]


class Cia402States(Cia402Cycle):
    """Knows the ways between the states."""

    resting_mode = OperationMode.CYCLIC_POSITION
    """The mode in which drives hold their motors when nothing moves."""

    # -- ways ---------------------------------------------------------------------------------

    def bring(self, drives: Collection[Cia402Drive], goal: DriveState) -> Unmoved:
        """Bring drives to a state; return those that do not come there."""
        given_up_s = self.now_s + BRING_S
        while left := tuple(drive for drive in drives if not self._is_there(drive, goal)):
            if self.now_s >= given_up_s:
                return left
            for drive in left:
                self.command(drive, self._next_word(drive, goal), self.resting_mode)
            given_up_s += yield from self.timed(self.turn())
        return ()

    def _is_there(self, drive: Cia402Drive, goal: DriveState) -> bool:
        return drive.state is goal and (not goal.holds or drive.mode == self.resting_mode)

    def _next_word(self, drive: Cia402Drive, goal: DriveState) -> Controlword:
        """Return the next command on a drive's way; one that holds is given its mode first."""
        state = drive.state
        if state is DriveState.QUICK_STOP and goal.holds and drive.mode != self.resting_mode:
            return STOP
        found = None if state is None else way(state, goal, resume=True)
        cause = found[0].cause if found else None  # it is there, or will be, or nobody knows
        if isinstance(cause, Command):
            return Controlword.of(cause)
        return ENABLE if goal.holds else Controlword.of(Command.DISABLE_VOLTAGE)

    def reset_faults(self, drives: Collection[Cia402Drive]) -> Unmoved:
        """Reset faults, by an edge that rises; return the drives that stay in theirs."""
        given_up_s = self.now_s + BRING_S
        left = tuple(drives)
        while left and self.now_s < given_up_s:
            for command in (Command.DISABLE_VOLTAGE, Command.FAULT_RESET):
                for drive in left:
                    self.command(drive, Controlword.of(command), self.resting_mode)
                yield from self.turn()
            yield from self.turn()
            left = tuple(drive for drive in left if drive.state in FAULTS)
        return left

    def resume(self, drives: Collection[Cia402Drive]) -> Hindrance:
        """Take drives back that stand in a quick stop; they hold where they are."""
        stopped = tuple(drive for drive in drives if drive.state is DriveState.QUICK_STOP)
        left = yield from self.bring(stopped, DriveState.ENABLED)
        for drive in stopped:
            drive.rest()
        held = [drive for drive in left if drive.state is DriveState.QUICK_STOP]
        if not held:
            return None
        return RequestRejected(
            f"{held[0]} holds in its quick stop and does not come back from there by a command: "
            "support the arm, call `disable()`, then call `enable()`",
            moved=False,
        )

    # -- stops --------------------------------------------------------------------------------

    def halt(self) -> Hindrance:
        """Stop every drive and wait until all stand and hold; return why that is not known."""
        began_s = self.now_s
        left = {drive.node for drive in self.drives}
        given_up_s = began_s + 2.0 * self.settings.quick_stop_s + BRAKING_S
        mute: tuple[Cia402Drive, ...] = ()
        while left and self.now_s < given_up_s:
            for drive in self.drives:
                if drive.node in left and drive.state in _TO_BE_STOPPED:
                    self.command(drive, STOP, self._mode_of(drive))
            self.last_said = "QUICK STOP"
            given_up_s += yield from self.timed(self.turn())
            self.progress()
            left -= {drive.node for drive in self.drives if self._has_stopped(drive, began_s)}
            mute = self.mute([self._by_node[node] for node in left])
            if mute and len(mute) == len(left):
                break
        return (yield from self._stopped(left, mute, began_s))

    def _has_stopped(self, drive: Cia402Drive, since_s: float) -> bool:
        if drive.booted:
            return True  # it has lost its current, and will not say so
        if drive.told_s < since_s or drive.state in (None, DriveState.ENABLED):
            return False
        if not drive.holds:
            return True  # nothing can be done about how it turns
        return drive.stands(since_s, (STAND_TURNS - 1) * self.cycle_s * 0.9)

    def _stopped(
        self, left: Collection[int], mute: tuple[Cia402Drive, ...], began_s: float
    ) -> Hindrance:
        held = yield from self.resume([each for each in self.drives if each.node not in left])
        for drive in self.drives:
            drive.rest()
        if mute and len(mute) == len(left):
            self.contacted = False
            if len(mute) == len(self.drives):
                return self.silence(began_s)
            return RequestRejected(self.absent_words(mute), silent=True)
        if left:
            drive = self._by_node[min(left)]
            return RequestRejected(f"{drive} was told to stop, and does not come to rest")
        return held

    def _mode_of(self, drive: Cia402Drive) -> OperationMode:
        """Return the mode that a drive is in, so that a stop changes nothing else."""
        return next((each for each in OperationMode if each == drive.mode), self.resting_mode)
