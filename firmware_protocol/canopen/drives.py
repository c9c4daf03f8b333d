"""The drive profile CiA 402: controlword (6040), statusword (6041), modes and states of a drive.

The mode defines the meaning of bits 4, 5, 6 and 9 of the controlword and bits 12 and 13 of the
statusword. They are named for profile position; comments give the meaning in homing if it differs.
"""

from __future__ import annotations

from enum import Enum, IntEnum, IntFlag
from functools import lru_cache
from typing import TypeAlias

from firmware_protocol.errors import BadField, whole
from firmware_protocol.fields import in_words, message

WORD_MAX = 0xFFFF


class ControlBit(IntFlag):
    """Bits of the controlword."""

    SWITCH_ON = 1 << 0
    ENABLE_VOLTAGE = 1 << 1
    NO_QUICK_STOP = 1 << 2
    """0 commands a quick stop."""
    ENABLE_OPERATION = 1 << 3
    NEW_SET_POINT = 1 << 4
    """Rising edge: take the target. In homing: start homing."""
    AT_ONCE = 1 << 5
    """The target replaces the active one; otherwise it is queued after it."""
    RELATIVE = 1 << 6
    FAULT_RESET = 1 << 7
    """Rising edge: reset the fault."""
    HALT = 1 << 8
    """Stop, and stay enabled."""
    CHANGE_ON_SET_POINT = 1 << 9
    """Pass through the active set-point to the next one without stopping."""


class StatusBit(IntFlag):
    """Bits of the statusword."""

    READY = 1 << 0
    SWITCHED_ON = 1 << 1
    ENABLED = 1 << 2
    FAULT = 1 << 3
    VOLTAGE = 1 << 4
    """The power section has voltage."""
    NO_QUICK_STOP = 1 << 5
    DISABLED = 1 << 6
    WARNING = 1 << 7
    REMOTE = 1 << 9
    """The drive obeys the controlword."""
    REACHED = 1 << 10
    """The target is reached; during a halt: the drive is at rest."""
    LIMITED = 1 << 11
    """An internal limit is active."""
    ACKNOWLEDGED = 1 << 12
    """The set-point was accepted, or there is no room for another. In homing: home was found."""
    FOLLOWING_ERROR = 1 << 13
    """In homing: homing failed."""


class Command(Enum):
    """A command to the state machine: mask and value to recognise it, and the word to send."""

    DISABLE_VOLTAGE = (0x82, 0x00, 0x00)
    QUICK_STOP = (0x86, 0x02, 0x02)
    SHUT_DOWN = (0x87, 0x06, 0x06)
    SWITCH_ON = (0x8F, 0x07, 0x07)
    """Also means disable operation."""
    ENABLE_OPERATION = (0x8F, 0x0F, 0x0F)
    FAULT_RESET = (0x80, 0x80, 0x80)
    """Acts on the rising edge only."""

    def __init__(self, mask: int, wanted: int, word: int) -> None:
        self.mask = mask
        self.wanted = wanted
        self.word = word


class DriveState(Enum):
    """A state of the drive, with the statusword's mask and value for it."""

    NOT_READY = (0x4F, 0x00)
    DISABLED = (0x4F, 0x40)
    """Switch on disabled."""
    READY = (0x6F, 0x21)
    """Ready to switch on."""
    SWITCHED_ON = (0x6F, 0x23)
    ENABLED = (0x6F, 0x27)
    """Operation enabled."""
    QUICK_STOP = (0x6F, 0x07)
    """Quick stop active."""
    FAULT_REACTION = (0x4F, 0x0F)
    """Fault reaction active."""
    FAULT = (0x4F, 0x08)

    def __init__(self, mask: int, wanted: int) -> None:
        self.mask = mask
        self.wanted = wanted

    @property
    def holds(self) -> bool:
        """Whether the motor has current and holds the arm."""
        return self in (DriveState.ENABLED, DriveState.QUICK_STOP, DriveState.FAULT_REACTION)


# No bits besides those of the command or the state.
NO_CONTROL, NO_STATUS = ControlBit(0), StatusBit(0)

_STATE_BITS = 0x6F
_OPERATION_BITS = ControlBit.NEW_SET_POINT | ControlBit.AT_ONCE | ControlBit.RELATIVE
_FREE = _OPERATION_BITS | ControlBit.HALT | ControlBit.CHANGE_ON_SET_POINT


@message()
class Controlword:
    """A 16-bit controlword."""

    value: int

    def __post_init__(self) -> None:
        whole("controlword", self.value, 0, WORD_MAX)

    @classmethod
    def of(cls, command: Command, bits: ControlBit = NO_CONTROL) -> Controlword:
        """Build a controlword from a command and bits that do not change the command."""
        if bits & ~_FREE:
            raise BadField("bits", bits, "none of those that are the command's")
        return cls(int(command.word | bits))

    @property
    def command(self) -> Command:
        """The command to the state machine; every controlword contains one."""
        return _command_of(self.value)

    def has(self, bit: ControlBit) -> bool:
        """Whether a bit is set."""
        return bool(self.value & int(bit))  # combining IntFlags is slow, and this is called often

    def __str__(self) -> str:
        """Format as in manuals, with the command."""
        return f"{self.value:04X} ({in_words(self.command)})"


@message()
class Statusword:
    """A 16-bit statusword."""

    value: int

    def __post_init__(self) -> None:
        whole("statusword", self.value, 0, WORD_MAX)

    @classmethod
    def of(cls, state: DriveState, bits: StatusBit = NO_STATUS) -> Statusword:
        """Build a statusword from a state and bits that do not change the state."""
        if bits & _STATE_BITS:
            raise BadField("bits", bits, "none of those that are the state's")
        return cls(int(state.wanted | bits))

    @property
    def state(self) -> DriveState | None:
        """The drive's state; None for a pattern that CiA 402 does not define."""
        return _state_of(self.value)

    def has(self, bit: StatusBit) -> bool:
        """Whether a bit is set."""
        return bool(self.value & int(bit))  # combining IntFlags is slow, and this is called often

    def __str__(self) -> str:
        """Format as in manuals, with the state."""
        state = self.state
        words = "no state" if state is None else in_words(state)
        return f"{self.value:04X} ({words})"


# Cached, because the same few words recur all the time.


@lru_cache(maxsize=256)
def _command_of(value: int) -> Command:
    return next(each for each in Command if value & each.mask == each.wanted)


@lru_cache(maxsize=256)
def _state_of(value: int) -> DriveState | None:
    return next((each for each in DriveState if value & each.mask == each.wanted), None)


# Options of CiA 402: modes of operation, and the reaction to a quick stop.


class OperationMode(IntEnum):
    """A mode of operation: written to 6060, and shown in 6061 once active."""

    NONE = 0
    PROFILE_POSITION = 1
    VELOCITY = 2
    PROFILE_VELOCITY = 3
    PROFILE_TORQUE = 4
    HOMING = 6
    INTERPOLATED_POSITION = 7
    CYCLIC_POSITION = 8
    """Cyclic synchronous position: a target with every SYNC."""
    CYCLIC_VELOCITY = 9
    CYCLIC_TORQUE = 10


def mode_of(shown: int) -> OperationMode | None:
    """Return the mode for a value of 6061; None for a manufacturer's or reserved mode."""
    return next((mode for mode in OperationMode if mode == shown), None)


def supported_modes(word: int) -> frozenset[OperationMode]:
    """Return the modes listed in object 6502: bit n stands for mode n + 1."""
    return frozenset(mode for mode in OperationMode if mode and word >> mode - 1 & 1)


def supported_word(modes: frozenset[OperationMode]) -> int:
    """Return the value of object 6502 for these modes."""
    return sum(1 << mode - 1 for mode in modes if mode)


# Units of CiA 303-2, of which object 60A9 has one over another.
INCREMENTS, REVOLUTIONS, A_SECOND, A_MINUTE = 0xB5, 0xB4, 0x03, 0x47
# The value of 60A8 (unit of position) for increments of the encoder.
POSITION_INCREMENTS = INCREMENTS << 16
# The value of 60A9 (unit of speed) for increments a second.
INCREMENTS_A_SECOND = INCREMENTS << 16 | A_SECOND << 8
# The value of 60A9 for revolutions a minute.
RPM = REVOLUTIONS << 16 | A_MINUTE << 8


def speed_unit_hz(word: int, per_turn: float) -> float | None:
    """Return the unit of speeds in object 60A9, in increments/s; None if it is another one.

    `per_turn` are the encoder's increments in a turn of the motor. Source: CiA 402-2 (object 60A9)
    and CiA 303-2: a power of ten in bits 24 to 31, a unit in bits 16 to 23, over that in bits 8 to
    15.
    """
    power, over, under = word >> 24, word >> 16 & 0xFF, word >> 8 & 0xFF
    lengths = {INCREMENTS: 1.0, REVOLUTIONS: per_turn}
    times = {A_SECOND: 1.0, A_MINUTE: 60.0}
    if over not in lengths or under not in times:
        return None
    return lengths[over] / times[under] * 10.0 ** (power - 0x100 * (power >> 7))


class QuickStopOption(IntEnum):
    """A value of 605A: how the drive stops, and whether it then disables itself.

    If not, the drive stays in QUICK_STOP and holds.
    """

    DISABLE = 0
    """No ramp: the current is switched off at once."""
    RAMP = 1
    QUICK_RAMP = 2
    """The default of most drives."""
    CURRENT_LIMIT = 3
    VOLTAGE_LIMIT = 4
    RAMP_AND_STAY = 5
    QUICK_RAMP_AND_STAY = 6
    """The right choice for an arm without brakes."""
    CURRENT_LIMIT_AND_STAY = 7
    VOLTAGE_LIMIT_AND_STAY = 8

    @property
    def stays(self) -> bool:
        """Whether the drive stays in QUICK_STOP after stopping."""
        return self >= QuickStopOption.RAMP_AND_STAY


# The state machine of a CiA 402 drive: one table.
#
#     0, 1  NOT_READY -> DISABLED -> READY -> SWITCHED_ON -> ENABLED -> QUICK_STOP
#     13    any state -> FAULT_REACTION -> FAULT -> DISABLED
#
# Source: CiA 402-2 (IEC 61800-7-201), the finite state automaton and its transitions 0 to 16.


class Happening(Enum):
    """An event that changes a drive's state without a command."""

    INITIALISED = "its self-test is done"
    QUICK_STOPPED = "the quick stop has ended, and its option says to disable"
    FAULT = "something is wrong"
    REACTED = "the reaction to a fault has ended"


Cause: TypeAlias = Command | Happening


@message()
class Transition:
    """A row of the table. `number` is the transition's number in CiA 402."""

    number: int
    begin: DriveState
    cause: Cause
    end: DriveState


_NOT_READY, _DISABLED, _READY = DriveState.NOT_READY, DriveState.DISABLED, DriveState.READY
_ON, _ENABLED, _QUICK = DriveState.SWITCHED_ON, DriveState.ENABLED, DriveState.QUICK_STOP
_REACTION, _FAULT = DriveState.FAULT_REACTION, DriveState.FAULT

TRANSITIONS: tuple[Transition, ...] = (
    Transition(1, _NOT_READY, Happening.INITIALISED, _DISABLED),
    Transition(2, _DISABLED, Command.SHUT_DOWN, _READY),
    Transition(3, _READY, Command.SWITCH_ON, _ON),
    Transition(3, _READY, Command.ENABLE_OPERATION, _ON),  # and at once on by transition 4
    Transition(4, _ON, Command.ENABLE_OPERATION, _ENABLED),
    Transition(5, _ENABLED, Command.SWITCH_ON, _ON),
    Transition(6, _ON, Command.SHUT_DOWN, _READY),
    Transition(7, _READY, Command.DISABLE_VOLTAGE, _DISABLED),
    Transition(7, _READY, Command.QUICK_STOP, _DISABLED),
    Transition(8, _ENABLED, Command.SHUT_DOWN, _READY),
    Transition(9, _ENABLED, Command.DISABLE_VOLTAGE, _DISABLED),
    Transition(10, _ON, Command.DISABLE_VOLTAGE, _DISABLED),
    Transition(10, _ON, Command.QUICK_STOP, _DISABLED),
    Transition(11, _ENABLED, Command.QUICK_STOP, _QUICK),
    Transition(12, _QUICK, Command.DISABLE_VOLTAGE, _DISABLED),
    Transition(12, _QUICK, Happening.QUICK_STOPPED, _DISABLED),
    *(
        Transition(13, state, Happening.FAULT, _REACTION)
        for state in (_NOT_READY, _DISABLED, _READY, _ON, _ENABLED, _QUICK)
    ),
    Transition(14, _REACTION, Happening.REACTED, _FAULT),
    Transition(15, _FAULT, Command.FAULT_RESET, _DISABLED),
    Transition(16, _QUICK, Command.ENABLE_OPERATION, _ENABLED),  # optional: some drives lack it
)

_BY_CAUSE = {(row.begin, row.cause): row for row in TRANSITIONS}
RESUMES, RESETS = 16, 15


def transition(state: DriveState, cause: Cause) -> Transition | None:
    """Return the transition that a cause triggers in a state; None if there is none."""
    return _BY_CAUSE.get((state, cause))


# Statusword bits for (target reached, set-point acknowledged).
_BITS = {
    (False, False): NO_STATUS,
    (True, False): StatusBit.REACHED,
    (False, True): StatusBit.ACKNOWLEDGED,
    (True, True): StatusBit.REACHED | StatusBit.ACKNOWLEDGED,
}


class SetPoints:
    """The hand-over of set-points to an enabled drive: absolute ones, each obeyed at once.

    `word` is the controlword that enabled the drive; if its bit 4 is set, that is no rising edge.
    """

    def __init__(self, word: Controlword) -> None:
        self.active = False
        """Whether the drive is moving to a set-point."""
        self._asked = word.has(ControlBit.NEW_SET_POINT)
        self._acknowledged = False

    @property
    def bits(self) -> StatusBit:
        """The statusword bits for the set-points."""
        return _BITS[not self.active, self._acknowledged]

    def control(self, word: Controlword) -> bool:
        """Process a controlword; return whether the target in 607A is the new set-point."""
        asked = word.has(ControlBit.NEW_SET_POINT)
        rising, self._asked = asked and not self._asked, asked
        self._acknowledged = asked and (rising or self._acknowledged)
        self.active = self.active or rising
        return rising


# The drive's end of CiA 402: controlwords in; state, set-points and statusword out.
#
# The owner simulates the motion, the duration of a fault reaction or quick stop, and faults.


class DriveDevice:
    """The state machine of a simulated drive. It begins in NOT_READY, without a fault."""

    def __init__(self, quick_stop: QuickStopOption = QuickStopOption.QUICK_RAMP) -> None:
        self.quick_stop = quick_stop
        self.state = DriveState.NOT_READY
        """The drive's state."""
        self.faulty = False
        """Whether the cause of a fault still exists, so that the fault cannot be reset."""
        self._word = Controlword(0)
        self.points = SetPoints(self._word)
        """The drive's set-points; meaningful while the drive is enabled."""

    def statusword(self, bits: StatusBit = NO_STATUS) -> Statusword:
        """Return the statusword, with bits from the owner: voltage, warning, following error."""
        return _statusword(self.state, bits, self.points.bits)

    def control(self, word: Controlword) -> tuple[tuple[Transition, ...], bool]:
        """Obey a controlword; return the transitions, and whether there is a new set-point."""
        rising = word.has(ControlBit.FAULT_RESET) and not self._word.has(ControlBit.FAULT_RESET)
        self._word = word
        taken: tuple[Transition, ...] = ()
        if word.command is not Command.FAULT_RESET or rising:
            taken = self._obey(word.command)
        if self.state is not DriveState.ENABLED or taken:
            return taken, False
        return taken, self.points.control(word)

    def happen(self, happening: Happening) -> Transition | None:
        """Process an event inside the drive; return the transition that it causes."""
        if happening is Happening.QUICK_STOPPED and self.quick_stop.stays:
            return None
        return self._change(happening)

    def _obey(self, command: Command) -> tuple[Transition, ...]:
        taken = []
        while (row := self._change(command)) is not None:  # transition 3 leads on to 4
            taken.append(row)
        at_once = self.quick_stop is QuickStopOption.DISABLE
        if self.state is DriveState.QUICK_STOP and taken and at_once:
            taken += filter(None, (self._change(Happening.QUICK_STOPPED),))
        return tuple(taken)

    def _change(self, cause: Cause) -> Transition | None:
        row = transition(self.state, cause)
        if row is None or (row.number == RESETS and self.faulty):
            return None
        if row.number == RESUMES and not self.quick_stop.stays:
            return None
        self.state = row.end
        self.points = SetPoints(self._word)
        return row


@lru_cache(maxsize=256)
def _statusword(state: DriveState, bits: StatusBit, of_points: StatusBit) -> Statusword:
    if bits & _BITS[True, True]:
        raise BadField("bits", bits, "none of those that are the set-points'")
    return Statusword.of(state, bits | StatusBit.REMOTE | of_points)


# The master's end of profile position mode: the handshake that hands a target to a drive.
#
#     WAITING    until the drive has room: bit 12 is 0
#     ASKING     bit 4 is set, until the drive acknowledges: bit 12 is 1
#     RELEASING  bit 4 is clear, until the drive has seen that: bit 12 is 0
#     TAKEN      the drive has the target, or none any more because it has left ENABLED


class SetPointPhase(Enum):
    """A phase of the handshake."""

    WAITING = "waiting"
    ASKING = "asking"
    RELEASING = "releasing"
    TAKEN = "taken"


class SetPointHost:
    """Hands one target to an enabled drive. The target replaces the drive's active one at once.

    Write the target (607A) before sending `controlword`. There is no clock: the owner keeps
    deadlines, and sees by the position when the drive has arrived. Pass statuswords in the order in
    which the drive sent them, from a single PDO or from SDO only; lost and repeated ones do no
    harm.
    """

    def __init__(self) -> None:
        self.phase = SetPointPhase.WAITING
        """The phase of the handshake."""

    @property
    def taken(self) -> bool:
        """Whether the drive has taken the target."""
        return self.phase is SetPointPhase.TAKEN

    @property
    def controlword(self) -> Controlword:
        """The controlword to send now; repeating it changes nothing."""
        asking = ControlBit.NEW_SET_POINT if self.phase is SetPointPhase.ASKING else NO_CONTROL
        return Controlword.of(Command.ENABLE_OPERATION, ControlBit.AT_ONCE | asking)

    def receive(self, word: Statusword) -> None:
        """Process a statusword. Never raises."""
        acknowledged = word.has(StatusBit.ACKNOWLEDGED)
        if word.state is not DriveState.ENABLED:
            self.phase = SetPointPhase.TAKEN
        elif self.phase is SetPointPhase.WAITING and not acknowledged:
            self.phase = SetPointPhase.ASKING
        elif self.phase is SetPointPhase.ASKING and acknowledged:
            self.phase = SetPointPhase.RELEASING
        elif self.phase is SetPointPhase.RELEASING and not acknowledged:
            self.phase = SetPointPhase.TAKEN
