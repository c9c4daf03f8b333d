"""The states of a simulated CiA 402 drive: transitions, errors, and a missing master."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from functools import cache

from armdrive.sim.bus.node import NodeMotor
from armdrive.sim.cia402.motion import Cia402Motion, Homing
from armdrive.sim.cia402.objects import DriveObjects
from firmware_protocol import canopen
from firmware_protocol.canopen import (
    Command,
    DriveState,
    Happening,
    OperationMode,
    QuickStopOption,
    StatusBit,
)

PDO_TOO_SHORT = 0x8210
TOO_FAR_BEHIND = 0x8611

# The kind of an error by the first digit of its code; all others are of the profile.
_KINDS = {
    0x2: canopen.ErrorRegister.CURRENT,
    0x3: canopen.ErrorRegister.VOLTAGE,
    0x4: canopen.ErrorRegister.TEMPERATURE,
}
_OF_TALK = range(0x8100, 0x8300)
_FAULT_RESET = 15
# The braking ramp for options of 605A, if it is not that of the quick stop.
_QUICK_STOP_RAMPS = {
    QuickStopOption.RAMP: canopen.PROFILE_DECELERATION,
    QuickStopOption.RAMP_AND_STAY: canopen.PROFILE_DECELERATION,
}
# The option of 605E to free the motor at once; with all others it brakes first.
_FREE_AT_ONCE = 0
_FAULT = 1
# The reactions to a missing master (6007), besides nothing and a fault.
_REACTIONS = {2: Command.DISABLE_VOLTAGE, 3: Command.QUICK_STOP}
_FAULTY = (DriveState.FAULT, DriveState.FAULT_REACTION)
_OBEYING = (DriveState.ENABLED, DriveState.QUICK_STOP)
_UNWATCHED = 0xFFFF_FFFF
_OF_MODE_MASK = int(StatusBit.REACHED | StatusBit.ACKNOWLEDGED)
# What the end of a motion means in these states.
_ENDS = {
    DriveState.FAULT_REACTION: Happening.REACTED,
    DriveState.QUICK_STOP: Happening.QUICK_STOPPED,
}


class Cia402States:
    """The state machine of one drive. `emcy` sends an error code, 0 for no error."""

    def __init__(
        self,
        motor: NodeMotor,
        motion: Cia402Motion,
        objects: DriveObjects,
        emcy: Callable[[int], None],
    ) -> None:
        self._motor, self._motion, self._objects, self._emcy = motor, motion, objects, emcy
        self.active_errors: set[int] = set()
        """The codes of errors whose cause still exists."""
        self.forget()

    def forget(self) -> None:
        """Reset to the state after power-on."""
        self.machine = canopen.DriveDevice()
        self.machine.happen(Happening.INITIALISED)
        self.mode: int = OperationMode.NONE
        self.watch_stops = 0
        """How often a missing heartbeat has made it react."""
        self.master_lost = False
        """Whether its master's heartbeat is missing."""
        self._following_error = False  # the shaft was too far away, which was a fault
        self._behind_since_s = math.inf  # since when it is farther away than the window

    @property
    def state(self) -> DriveState:
        """The state of its state machine."""
        return self.machine.state

    @property
    def enabled(self) -> bool:
        """Whether the drive obeys set-points."""
        return self.machine.state is DriveState.ENABLED

    @property
    def follows(self) -> bool:
        """Whether it follows cyclic targets: at the start, that may be an old one."""
        return self.mode == OperationMode.CYCLIC_POSITION and self.enabled

    # Orders of a master.

    def control(self, now_s: float) -> None:
        """Obey the controlword in its object."""
        word = canopen.Controlword(self._objects.number_of(canopen.CONTROLWORD, 0))
        self.machine.faulty = bool(self.active_errors)
        taken, is_new = self.machine.control(word)
        self._take(taken, now_s)
        if not self.enabled:
            return
        if self.mode == OperationMode.PROFILE_POSITION:
            if is_new:
                self._motion.go(now_s)
            return
        self.machine.points.active = False
        if self.mode == OperationMode.HOMING:
            if not word.has(canopen.ControlBit.NEW_SET_POINT):
                self._motion.break_off_homing(now_s)
            elif is_new:
                self._motion.home(now_s)

    def set_mode(self, mode: int, now_s: float) -> None:
        """Change the mode; a motion under way brakes."""
        if mode == self.mode:
            return
        if self.enabled and self._motion.moving(now_s):
            self._motion.slow_down(now_s)
        self.mode = mode
        self._motion.end_search()
        self.machine.points.active = False

    def set_quick_stop(self) -> None:
        """Adopt the quick stop option (605A)."""
        option = self._objects.number_of(canopen.QUICK_STOP_OPTION, 2)
        self.machine.quick_stop = QuickStopOption(option)

    def command(self, what: Command, now_s: float) -> None:
        """Make the drive execute a command by itself."""
        self._take(self.machine.control(canopen.Controlword.of(what))[0], now_s)

    def _take(self, taken: Iterable[canopen.Transition], now_s: float) -> None:
        """Carry out what transitions mean for the motor."""
        for row in taken:
            if row.number == _FAULT_RESET:
                self._following_error = False
                self.over()
            if row.end is DriveState.QUICK_STOP:
                option = self.machine.quick_stop
                ramp = _QUICK_STOP_RAMPS.get(option, canopen.QUICK_STOP_DECELERATION)
                self._motion.break_off_homing(now_s)
                self._motion.brake(self._motion.slope(ramp), now_s)
            if row.end is DriveState.ENABLED and not self._motor.holding:
                self._motor.hold(now_s)
            if not row.end.holds:
                self._behind_since_s = math.inf
                self._motion.let_go(now_s)

    # Supervision by the drive itself.

    @property
    def due_s(self) -> float:
        """When the motion ends, or the following error becomes a fault."""
        if math.isinf(self._behind_since_s):
            return self._motion.due_s
        return min(self._motion.due_s, self._behind_since_s + self._patience_s)

    def live(self, now_s: float) -> None:
        """Supervise the shaft, a search and the end of a motion."""
        self._watch_shaft(now_s)
        self._motion.watch_switch(now_s)
        self._watch_end(now_s)

    @property
    def _patience_s(self) -> float:
        return self._objects.number_of(canopen.FOLLOWING_ERROR_TIMEOUT_MS, 0) / 1000

    def _watch_shaft(self, now_s: float) -> None:
        """Go into fault if the following error was too large for too long."""
        behind = abs(self._motion.behind(now_s)) if self.state in _OBEYING else 0
        if not behind:  # as nearly always
            self._behind_since_s = math.inf
            return
        window = self._objects.number_of(canopen.FOLLOWING_ERROR_WINDOW, _UNWATCHED)
        if window == _UNWATCHED or behind <= window:
            self._behind_since_s = math.inf
            return
        self._behind_since_s = min(self._behind_since_s, now_s)
        if now_s >= self._behind_since_s + self._patience_s:
            self._behind_since_s, self._following_error = math.inf, True
            self.fault(TOO_FAR_BEHIND, now_s)

    def _watch_end(self, now_s: float) -> None:
        """Act on the end of a motion."""
        motion, points = self._motion, self.machine.points
        if not motion.ends or motion.moving(now_s):
            return
        if not self.enabled:
            motion.ends = False
            if self.state in _ENDS and (row := self.machine.happen(_ENDS[self.state])) is not None:
                self._take((row,), now_s)
            return
        motion.waits = not motion.arrived
        if not motion.waits:
            motion.ends = points.active = False

    # Errors: EMCY, error register, error code.

    def fault(self, code: int, now_s: float) -> None:
        """Go into fault and report why: brake as 605E says, then free the motor."""
        self._report(code)
        self.machine.happen(Happening.FAULT)
        self._motion.break_off_homing(now_s)
        free = self._objects.number_of(canopen.FAULT_REACTION_OPTION, 2) == _FREE_AT_ONCE
        slope = math.inf if free else self._motion.slope(canopen.QUICK_STOP_DECELERATION)
        self._motion.brake(slope, now_s)

    def over(self) -> None:
        """Report that an error is over, if there was one."""
        if self._objects.number_of(canopen.ERROR_REGISTER, 0):
            self._objects.keep(canopen.ERROR_REGISTER, 0)
            self._objects.keep(canopen.ERROR_CODE, 0)
            self._emcy(0)

    def _report(self, code: int) -> None:
        """Report an error, and store it."""
        kind = _KINDS.get(code >> 12, canopen.ErrorRegister.DEVICE_PROFILE)
        kind = canopen.ErrorRegister.COMMUNICATION if code in _OF_TALK else kind
        register = self._objects.number_of(canopen.ERROR_REGISTER, 0)
        self._objects.keep(canopen.ERROR_REGISTER, canopen.ErrorRegister.GENERIC | kind | register)
        self._objects.keep(canopen.ERROR_CODE, code)
        self._emcy(code)

    # A lost master: object 6007.

    def lose_master(self, now_s: float) -> None:
        """React to a missing heartbeat of the master, and report it."""
        self.master_lost = True
        self.watch_stops += 1
        if self._objects.number_of(canopen.HEARTBEAT_REACTION, _FAULT) != _FAULT:
            self._report(canopen.HEARTBEAT_MISSING)
        self.react(now_s)

    def react(self, now_s: float) -> None:
        """React as 6007 says: nothing, a fault, free the motor, or a quick stop."""
        reaction = self._objects.number_of(canopen.HEARTBEAT_REACTION, _FAULT)
        if reaction == _FAULT:
            self.fault(canopen.HEARTBEAT_MISSING, now_s)
        elif reaction in _REACTIONS and self.enabled:
            self.command(_REACTIONS[reaction], now_s)

    def regain_master(self) -> None:
        """Record that the master's heartbeat has returned."""
        if self.master_lost:
            self.master_lost = False
            if self.state not in _FAULTY:
                self.over()

    # The statusword.

    def statusword(self, now_s: float, *, withheld: bool) -> canopen.Statusword:
        """Return its statusword; if `withheld`, without the report that a target is reached."""
        common = _common(self._following_error, self.master_lost)
        word = self.machine.statusword(common)
        if not self.enabled:
            moves = self._motion.moving(now_s)
            bits = StatusBit(0) if moves else StatusBit.REACHED
        else:
            bits = self._bits_of_mode(self.machine.points.bits, now_s, withheld=withheld)
        return canopen.Statusword(word.value & ~_OF_MODE_MASK | int(bits))

    def _bits_of_mode(self, bits: StatusBit, now_s: float, *, withheld: bool) -> StatusBit:
        """Return bits 10, 12 and 13 as the mode defines them."""
        motion = self._motion
        match self.mode:
            case OperationMode.PROFILE_POSITION:
                return bits & ~StatusBit.REACHED if withheld else bits
            case OperationMode.CYCLIC_POSITION:  # it follows its targets; bit 10 says nothing
                return StatusBit.ACKNOWLEDGED
            case OperationMode.HOMING:
                if motion.homing is Homing.FAILED:
                    return StatusBit.FOLLOWING_ERROR | StatusBit.REACHED
                stands = not motion.moving(now_s) and motion.arrived
                if motion.homing.searches or not stands or withheld:
                    return StatusBit(0)
                home = motion.homing is Homing.DONE
                return StatusBit.REACHED | (StatusBit.ACKNOWLEDGED if home else StatusBit(0))
        return StatusBit(0) if motion.moving(now_s) else StatusBit.REACHED


@cache
def _common(following_error: bool, master_lost: bool) -> StatusBit:
    bits = StatusBit.VOLTAGE
    bits |= StatusBit.FOLLOWING_ERROR if following_error else StatusBit(0)
    return bits | StatusBit.WARNING if master_lost else bits
