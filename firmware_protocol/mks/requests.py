"""What a host says to an MKS drive: what it reads, sets up, orders and sets going.

Each is checked when it is built; `forms` says how. What moves a drive works in a bus mode alone.
Targets are absolute or relative, in encoder counts (`...Axis`) or in pulses, which are microsteps.
`acc` is the drive's own measure of a ramp (`ramp_rpm_s`), and 0 has none. A nine-byte example of F4
in the manual is a misprint: no frame of CAN is so long.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar, Self, TypeAlias, get_args

from firmware_protocol.errors import BadField, RemoteProtocolError, whole
from firmware_protocol.mks.forms import (
    Form,
    Message,
    Switch,
    choice,
    one_of,
    signed,
    sized,
    unsigned,
)
from firmware_protocol.mks.forms import switch as checked_switch
from firmware_protocol.mks.values import (
    NODE_MAX,
    SPEED_MAX_RPM,
    TARGET_MAX,
    Ability,
    Bitrate,
    Code,
    Mode,
    ReplyMode,
)

# -- readings ------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class ReadEncoder(Message, code=Code.ENCODER):
    """Ask where the shaft is, in counts from the zero that was set; F4 and F5 count so too."""


@dataclass(frozen=True, slots=True)
class ReadRawEncoder(Message, code=Code.RAW_ENCODER, needs=Ability.RAW_ENCODER):
    """Ask where the shaft is, in counts, whatever zero was set."""


@dataclass(frozen=True, slots=True)
class ReadSpeed(Message, code=Code.SPEED):
    """Ask how fast the shaft turns."""


@dataclass(frozen=True, slots=True)
class ReadPulses(Message, code=Code.PULSES):
    """Ask for the pulses that were commanded."""


@dataclass(frozen=True, slots=True)
class ReadInputs(Message, code=Code.INPUTS, needs=Ability.INPUTS):
    """Ask for the levels of the switches' inputs and of the outputs."""


@dataclass(frozen=True, slots=True)
class ReadAngleError(Message, code=Code.ANGLE_ERROR):
    """Ask how far the shaft is from where it was commanded."""


@dataclass(frozen=True, slots=True)
class ReadEnabled(Message, code=Code.ENABLED):
    """Ask whether the motor has current."""


@dataclass(frozen=True, slots=True)
class ReadHoming(Message, code=Code.HOMING_STATE):
    """Ask how a return to zero stands."""


@dataclass(frozen=True, slots=True)
class ReadStall(Message, code=Code.STALL):
    """Ask whether a protection has let the shaft go: after a stall, or too large an error."""


@dataclass(frozen=True, slots=True)
class ReadVersion(Message, code=Code.VERSION, needs=Ability.VERSION):
    """Ask for the board and its firmware. Older firmware has no answer."""


@dataclass(frozen=True, slots=True)
class ReadState(Message, code=Code.STATE):
    """Ask what the motor does."""


Read: TypeAlias = (
    ReadEncoder
    | ReadRawEncoder
    | ReadSpeed
    | ReadPulses
    | ReadInputs
    | ReadAngleError
    | ReadEnabled
    | ReadHoming
    | ReadStall
    | ReadVersion
    | ReadState
)
READS: tuple[type[Read], ...] = get_args(Read)
READ_CODES = frozenset(read.code for read in READS)

# -- settings, which a drive keeps without current -----------------------------------------------
#
# A setting is read back (`ReadSetting`) in the form in which it is set. The mode that checks no
# check bytes (0F) is left out: it is meant for typing by hand.

CURRENT_MAX_MA = 5200
"""Of a SERVO57D; a 42D, 35D or 28D takes 3000. The manual warns of setting the maximum at once."""
MICROSTEPS_MAX = 256


def _read_replies(data: bytes) -> ReplyMode:
    if max(data) > 1:
        raise RemoteProtocolError(f"{data.hex(' ')} where zeros and ones belong")
    return ReplyMode(data) if data[0] else ReplyMode.NONE  # the second means nothing then


_Replies: TypeAlias = Annotated[
    ReplyMode,
    Form(
        2,
        lambda field, value: one_of(field, value, ReplyMode),
        lambda value: value.value,
        _read_replies,
    ),
]
_Tens: TypeAlias = Annotated[
    int,
    Form(  # tens, from 0
        1,
        unsigned(1, 10, 90, unit=10).check,
        lambda value: bytes((value // 10 - 1,)),
        lambda data: 10 * (data[0] + 1),
    ),
]
_Microsteps: TypeAlias = Annotated[
    int,
    Form(
        1,
        unsigned(2, 1, MICROSTEPS_MAX).check,
        lambda value: bytes((value % MICROSTEPS_MAX,)),
        lambda data: data[0] or MICROSTEPS_MAX,
    ),
]
_Node: TypeAlias = Annotated[int, unsigned(2, 1, NODE_MAX)]
_Word: TypeAlias = Annotated[int, unsigned(2)]
_Kept: TypeAlias = Annotated[  # nothing is written where it is kept
    bool,
    Form(0, checked_switch, lambda value: b"" if value else b"\0", lambda data: data != b"\0"),
]


@dataclass(frozen=True, slots=True)
class SetMode(Message, code=Code.MODE):
    """Choose who commands the motor; `Mode.BUS_FOC` for an arm."""

    mode: Annotated[Mode, choice(Mode)]


@dataclass(frozen=True, slots=True)
class SetCurrent(Message, code=Code.CURRENT):
    """Set the motor's current; not to `keep` it works from 1.0.7 on."""

    current_ma: Annotated[int, unsigned(2, 1, CURRENT_MAX_MA)]
    keep: _Kept = True

    @classmethod
    def read(cls, payload: bytes) -> Self:
        """Read a payload: it has one byte more where it is not to be kept."""
        keep = payload[2:] != b"\0"
        sized(payload, 2 if keep else 3)
        return cls(int.from_bytes(payload[:2], "big"), keep)


@dataclass(frozen=True, slots=True)
class SetHoldingCurrent(Message, code=Code.HOLDING_CURRENT, needs=Ability.HOLDING_CURRENT):
    """Set the current at rest in percent of the other, 10 to 90 by tens; not in FOC."""

    percent: _Tens


@dataclass(frozen=True, slots=True)
class SetMicrosteps(Message, code=Code.MICROSTEPS):
    """Set the pulses of a full step. What 256 is on the wire, 0, is not in the CAN manuals."""

    microsteps: _Microsteps


@dataclass(frozen=True, slots=True)
class SetDirection(Message, code=Code.DIRECTION):
    """Choose which way pulses turn the motor. It does nothing to motions over the bus."""

    counter_clockwise: Switch


@dataclass(frozen=True, slots=True)
class SetStallProtection(Message, code=Code.STALL_PROTECTION):
    """Have the drive let the shaft go when it stalls, or not, as shipped."""

    on: Switch


@dataclass(frozen=True, slots=True)
class SetPositionProtection(
    Message, code=Code.POSITION_PROTECTION, needs=Ability.POSITION_PROTECTION
):
    """Have the drive let the shaft go when it is too far from its target.

    `window` counts about 15 ms; `error` 28000 is a turn. The flag of zeroing by the En pin, which
    is in the same byte, is left off.
    """

    on: Switch
    window: _Word
    error: _Word


@dataclass(frozen=True, slots=True)
class SetHoming(Message, code=Code.HOMING):
    """Set up what `Home` does. After a change of the limits the manual wants a `Home`.

    `method`: 0 by a switch, 1 against a stop, 2 within a turn. `limits` has the switches stop
    motions; reaching one in homing then lets the shaft go.
    """

    active_high: Switch
    counter_clockwise: Switch
    speed_rpm: Annotated[int, unsigned(2, 0, SPEED_MAX_RPM)]
    limits: Switch
    method: Annotated[int, unsigned(1, 0, 2)]


@dataclass(frozen=True, slots=True)
class SetArrival(Message, code=Code.ARRIVAL, needs=Ability.ARRIVAL_THRESHOLD):
    """Choose how near a motion must come to be said `DONE`; 65535 is a turn."""

    on: Switch
    threshold: _Word = 200


@dataclass(frozen=True, slots=True)
class SilenceWatchdog(Message, code=Code.WATCHDOG, needs=Ability.SILENCE_WATCHDOG):
    """Have the drive stop when it has been told nothing for so long; 0, as shipped, never.

    Whether frames to other drives count as something is not in the manual.
    """

    timeout_ms: Annotated[int, unsigned(4)]


@dataclass(frozen=True, slots=True)
class SetBitrate(Message, code=Code.BITRATE):
    """Choose the bus's speed, for all drives or none. At which speed it answers is unknown."""

    bitrate: Annotated[Bitrate, choice(Bitrate)]


@dataclass(frozen=True, slots=True)
class SetId(Message, code=Code.NODE):
    """Give the drive another id. Whether it answers by the old or the new one is not documented."""

    node: _Node


@dataclass(frozen=True, slots=True)
class SetGroup(Message, code=Code.GROUP, needs=Ability.GROUPS):
    """Have the drive listen to a group's id too; nothing sent to it is answered.

    Never the id of a drive: its answers would be taken for commands.
    """

    node: _Node


@dataclass(frozen=True, slots=True)
class SetReplies(Message, code=Code.REPLIES, needs=Ability.CHOICE_OF_COMPLETION):
    """Choose what the drive says of what it is told to do. In this form from 1.0.4 on."""

    mode: _Replies


Setting: TypeAlias = (
    SetMode
    | SetCurrent
    | SetHoldingCurrent
    | SetMicrosteps
    | SetDirection
    | SetStallProtection
    | SetPositionProtection
    | SetHoming
    | SetArrival
    | SilenceWatchdog
    | SetBitrate
    | SetId
    | SetGroup
    | SetReplies
)
SETTINGS: tuple[type[Setting], ...] = get_args(Setting)
SETTING_CODES = frozenset(setting.code for setting in SETTINGS)


def _code_of(codes: frozenset[Code], words: str) -> Form:
    """Return the form of one of some codes."""

    def check(field: str, value: object) -> None:
        if value not in codes or not isinstance(value, Code):
            raise BadField(field, value, f"the Code of {words}")

    return Form(1, check, lambda value: bytes((value,)), lambda data: Code(data[0]))


@dataclass(frozen=True, slots=True)
class ReadSetting(Message, code=Code.READ_SETTING, needs=Ability.READ_SETTINGS):
    """Ask for a setting, by the code that sets it.

    The answer has that code, and then looks like the answer to setting it: a host does not ask
    both at once.
    """

    setting: Annotated[Code, _code_of(SETTING_CODES, "a setting")]


@dataclass(frozen=True, slots=True)
class ReportByItself(Message, code=Code.REPORT, needs=Ability.REPORTS_BY_ITSELF):
    """Have the drive say a reading unasked every so many ms; 0 ends that."""

    reading: Annotated[Code, _code_of(READ_CODES, "a reading")]
    period_ms: _Word


# -- moves ---------------------------------------------------------------------------------------

ACC_MAX = 255
TICK_MS = 10
RUN_MAX_MS = 0xFF_FFFF * TICK_MS
TARGET_BYTES = 3
_CLOCKWISE = 0x8000
_SPEED = 0x0FFF
_MOVE_ORDER = ("speed_rpm", "acc")

_Target: TypeAlias = Annotated[int, signed(TARGET_BYTES, TARGET_MAX)]
_Speed: TypeAlias = Annotated[int, unsigned(2, 1, SPEED_MAX_RPM)]
_Acc: TypeAlias = Annotated[int, unsigned(1)]


def _way(speed_rpm: int, clockwise: bool) -> bytes:
    return (speed_rpm | (_CLOCKWISE if clockwise else 0)).to_bytes(2, "big")


def _check_signed_speed(field: str, value: object) -> None:
    if whole(field, value, -SPEED_MAX_RPM, SPEED_MAX_RPM) == 0:
        raise BadField(field, value, "other than 0, which is a Stop")


def _read_signed_speed(data: bytes) -> int:
    way = int.from_bytes(data, "big")
    return -(way & _SPEED) if way & _CLOCKWISE else way & _SPEED


_SignedSpeed: TypeAlias = Annotated[
    int,
    Form(2, _check_signed_speed, lambda value: _way(abs(value), value < 0), _read_signed_speed),
]


@dataclass(frozen=True, slots=True)
class MoveRelativeAxis(Message, code=Code.RELATIVE_AXIS, order=(*_MOVE_ORDER, "counts")):
    """Move by so many encoder counts."""

    counts: _Target
    speed_rpm: _Speed
    acc: _Acc


@dataclass(frozen=True, slots=True)
class MoveAbsoluteAxis(Message, code=Code.ABSOLUTE_AXIS, order=(*_MOVE_ORDER, "counts")):
    """Move to a count. From 1.0.5 on also while one is under way, which it replaces."""

    counts: _Target
    speed_rpm: _Speed
    acc: _Acc


@dataclass(frozen=True, slots=True)
class MoveAbsolutePulses(
    Message,
    code=Code.ABSOLUTE_PULSES,
    needs=Ability.ABSOLUTE_PULSES,
    order=(*_MOVE_ORDER, "pulses"),
):
    """Move to a pulse."""

    pulses: _Target
    speed_rpm: _Speed
    acc: _Acc


_DISTANCE_MAX = (1 << 8 * TARGET_BYTES) - 1


@dataclass(frozen=True, slots=True)
class MoveRelativePulses(Message, code=Code.RELATIVE_PULSES):
    """Move by so many pulses. Their direction is written with the speed."""

    pulses: Annotated[int, signed(TARGET_BYTES + 1, _DISTANCE_MAX)]
    speed_rpm: _Speed
    acc: _Acc

    @property
    def payload(self) -> bytes:
        """Direction and speed, acc, distance."""
        distance = abs(self.pulses).to_bytes(TARGET_BYTES, "big")
        return _way(self.speed_rpm, self.pulses < 0) + bytes((self.acc,)) + distance

    @classmethod
    def read(cls, payload: bytes) -> Self:
        """Read a payload."""
        sized(payload, 6)
        way = int.from_bytes(payload[:2], "big")
        distance = int.from_bytes(payload[3:], "big")
        return cls(-distance if way & _CLOCKWISE else distance, way & _SPEED, payload[2])


@dataclass(frozen=True, slots=True)
class RunAtSpeed(Message, code=Code.SPEED_MODE):
    """Run at a signed speed until told otherwise. Nothing else ends it but the silence watchdog."""

    speed_rpm: _SignedSpeed
    acc: _Acc


@dataclass(frozen=True, slots=True)
class RunFor(Message, code=Code.SPEED_MODE, needs=Ability.TIMED_RUN):
    """Run at a signed speed for a time, in steps of 10 ms; the drive ends it."""

    speed_rpm: _SignedSpeed
    acc: _Acc
    duration_ms: Annotated[int, unsigned(3, TICK_MS, RUN_MAX_MS, unit=TICK_MS)]


Move: TypeAlias = MoveRelativeAxis | MoveAbsoluteAxis | MoveRelativePulses | MoveAbsolutePulses
MOVES: tuple[type[Move], ...] = get_args(Move)
MOTION_CODES = frozenset((*(move.code for move in MOVES), Code.SPEED_MODE))

# -- what stops a drive, switches it, homes it ---------------------------------------------------


@dataclass(frozen=True, slots=True)
class Stop:
    """End a motion of this code by a ramp of `acc`, or at once by an `acc` of 0."""

    needs: ClassVar[Ability | None] = None
    code: Code
    acc: int

    def __post_init__(self) -> None:
        _code_of(MOTION_CODES, "a motion").check("code", self.code)
        whole("acc", self.acc, 0, ACC_MAX)

    @property
    def payload(self) -> bytes:
        """A speed of 0, acc, and a distance of 0 where a move has one."""
        rest = b"" if self.code is Code.SPEED_MODE else bytes(TARGET_BYTES)
        return bytes((0, 0, self.acc)) + rest


@dataclass(frozen=True, slots=True)
class EmergencyStop(Message, code=Code.EMERGENCY_STOP, needs=Ability.EMERGENCY_STOP):
    """Stop at once, without a ramp: not above 1000 rpm."""


@dataclass(frozen=True, slots=True)
class Enable(Message, code=Code.ENABLE):
    """Switch the motor's current on or off. Off lets the shaft go."""

    on: Switch


@dataclass(frozen=True, slots=True)
class ArmSynchronous(Message, code=Code.ARM, needs=Ability.SYNCHRONOUS_START):
    """Have the drive store motions until `GoSynchronous`, or no more."""

    on: Switch


@dataclass(frozen=True, slots=True)
class GoSynchronous(Message, code=Code.GO, needs=Ability.SYNCHRONOUS_START):
    """Start every stored motion. Broadcast alone; say it again 1 ms later, as drives miss it."""


@dataclass(frozen=True, slots=True)
class Home(Message, code=Code.HOME):
    """Search for the zero as the drive is set up to. It moves."""


@dataclass(frozen=True, slots=True)
class GoToZero(Message, code=Code.HOME, needs=Ability.GO_TO_ZERO):
    """Run to the zero that a `Home` has found. It moves."""

    @property
    def payload(self) -> bytes:
        """Its choice, beside a `Home`'s."""
        return b"\1"


@dataclass(frozen=True, slots=True)
class Calibrate(Message, code=Code.CALIBRATE):
    """Measure the encoder against the motor, which turns: nothing may be on its shaft."""

    @property
    def payload(self) -> bytes:
        """A zero."""
        return b"\0"

    @classmethod
    def read(cls, payload: bytes) -> Self:
        """Read a payload."""
        if sized(payload, 1) != b"\0":
            raise BadField("payload", payload, "a zero")
        return cls()


@dataclass(frozen=True, slots=True)
class SetZero(Message, code=Code.ZERO, needs=Ability.ZERO):
    """Call the present position zero. It moves nothing."""


@dataclass(frozen=True, slots=True)
class ClearStall(Message, code=Code.CLEAR_STALL):
    """Let the motor have current again after a protection has let the shaft go."""


@dataclass(frozen=True, slots=True)
class Restart(Message, code=Code.RESTART, needs=Ability.RESTART):
    """Start the drive anew; settings stay."""


Motion: TypeAlias = Move | RunAtSpeed | RunFor | Stop | Home | GoToZero | Calibrate
"""What a drive first says `STARTED` of, and later how it ended."""
COURSE_CODES = MOTION_CODES | {Code.HOME, Code.CALIBRATE}
"""What starts first and ends later."""
Action: TypeAlias = (
    EmergencyStop | Enable | ArmSynchronous | GoSynchronous | SetZero | ClearStall | Restart
)
ACTIONS: tuple[type[Action], ...] = get_args(Action)
Request: TypeAlias = Read | ReadSetting | ReportByItself | Motion | Action | Setting


def needed_for(request: Request) -> Ability | None:
    """Return what a drive must be able to do to understand a request; None for what all can."""
    if isinstance(request, SetCurrent) and not request.keep:
        return Ability.UNKEPT_CURRENT
    return request.needs


def answer_code(request: Request) -> Code:
    """Return the code that the answer to a request has."""
    return request.setting if isinstance(request, ReadSetting) else request.code
