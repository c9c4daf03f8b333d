"""A host's requests to an MKS drive: reads, settings, motions and actions.

Fields are checked when a request is built (see `forms`). Motions work only in a bus mode. Targets
are absolute or relative, in encoder counts (`...Axis`) or in pulses, which are microsteps. `acc` is
the drive's own unit for a ramp (`ramp_rpm_s`); 0 means no ramp. The manual's nine-byte example of
F4 is a misprint: a CAN frame has at most eight bytes.
"""

from __future__ import annotations

from typing import Annotated, ClassVar, Self, TypeAlias, get_args

from firmware_protocol.errors import BadField, RemoteProtocolError, whole
from firmware_protocol.fields import boolean, message
from firmware_protocol.mks.values import (
    NODE_MAX,
    SPEED_MAX_RPM,
    TARGET_MAX,
    Ability,
    Bitrate,
    Code,
    Form,
    Message,
    Mode,
    ReplyMode,
    Switch,
    choice,
    one_of,
    signed,
    sized,
    unsigned,
)

# -- readings ------------------------------------------------------------------------------------


@message()
class ReadEncoder(Message, code=Code.ENCODER):
    """Ask for the shaft's position in counts from the set zero, the scale of F4 and F5."""


@message()
class ReadRawEncoder(Message, code=Code.RAW_ENCODER, needs=Ability.RAW_ENCODER):
    """Ask for the shaft's raw position in counts, regardless of the zero."""


@message()
class ReadAngleError(Message, code=Code.ANGLE_ERROR):
    """Ask for the shaft's following error."""


@message()
class ReadEnabled(Message, code=Code.ENABLED):
    """Ask whether the motor has current."""


@message()
class ReadHoming(Message, code=Code.HOMING_STATE):
    """Ask for the state of a return to zero."""


@message()
class ReadStall(Message, code=Code.STALL):
    """Ask whether a protection has released the shaft, after a stall or too large an error."""


@message()
class ReadVersion(Message, code=Code.VERSION, needs=Ability.VERSION):
    """Ask for the board and its firmware. Older firmware has no answer."""


@message()
class ReadState(Message, code=Code.STATE):
    """Ask for the motor's state."""


Read: TypeAlias = (
    ReadEncoder
    | ReadRawEncoder
    | ReadAngleError
    | ReadEnabled
    | ReadHoming
    | ReadStall
    | ReadVersion
    | ReadState
)
READS: tuple[type[Read], ...] = get_args(Read)

# -- settings, which survive a loss of power -----------------------------------------------------
#
# `ReadSetting` returns a setting in the format of the write. The mode without check bytes (0F) is
# left out: it is meant for typing by hand.

# For a SERVO57D; a 42D, 35D or 28D takes 3000. The manual warns: do not start at the maximum.
CURRENT_MAX_MA = 5200
MICROSTEPS_MAX = 256


def _read_replies(data: bytes) -> ReplyMode:
    if max(data) > 1:
        raise RemoteProtocolError(f"{data.hex(' ')} where zeros and ones belong")
    return ReplyMode(data) if data[0] else ReplyMode.NONE  # the second byte then has no meaning


_Replies: TypeAlias = Annotated[
    ReplyMode,
    Form(
        2,
        lambda field, value: one_of(field, value, ReplyMode),
        lambda value: value.value,
        _read_replies,
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
_Kept: TypeAlias = Annotated[  # empty if the current is stored
    bool,
    Form(0, boolean, lambda value: b"" if value else b"\0", lambda data: data != b"\0"),
]


@message()
class SetMode(Message, code=Code.MODE):
    """Set the source of commands and the kind of control; `Mode.BUS_FOC` for an arm."""

    mode: Annotated[Mode, choice(Mode)]


@message()
class SetCurrent(Message, code=Code.CURRENT):
    """Set the motor's current; setting it without storing (`keep`) works since 1.0.7."""

    current_ma: Annotated[int, unsigned(2, 1, CURRENT_MAX_MA)]
    keep: _Kept = True

    @classmethod
    def read(cls, payload: bytes) -> Self:
        """Decode a payload; it has an extra byte if the current is not stored."""
        keep = payload[2:] != b"\0"
        sized(payload, 2 if keep else 3)
        return cls(int.from_bytes(payload[:2], "big"), keep)


@message()
class SetMicrosteps(Message, code=Code.MICROSTEPS):
    """Set the pulses per full step. 256 is sent as 0, which the CAN manuals do not mention."""

    microsteps: _Microsteps


@message()
class SetStallProtection(Message, code=Code.STALL_PROTECTION):
    """Make the drive release the shaft when it stalls, or not (the factory setting)."""

    on: Switch


@message()
class SetHoming(Message, code=Code.HOMING):
    """Configure `Home`. After a change of `limits` the manual requires a `Home`.

    `method`: 0 to a switch, 1 against a hard stop, 2 within a turn. With `limits`, the switches
    stop motions; reaching a switch while homing then releases the shaft.
    """

    active_high: Switch
    counter_clockwise: Switch
    speed_rpm: Annotated[int, unsigned(2, 0, SPEED_MAX_RPM)]
    limits: Switch
    method: Annotated[int, unsigned(1, 0, 2)]


@message()
class SetArrival(Message, code=Code.ARRIVAL, needs=Ability.ARRIVAL_THRESHOLD):
    """Set how close to its target a motion must come to be `DONE`; 65535 is one turn."""

    on: Switch
    threshold: _Word = 200


@message()
class SilenceWatchdog(Message, code=Code.WATCHDOG, needs=Ability.SILENCE_WATCHDOG):
    """Make the drive stop after this long without a request; 0 (the factory setting): never.

    The manual does not say whether frames to other drives feed this watchdog.
    """

    timeout_ms: Annotated[int, unsigned(4)]


@message()
class SetBitrate(Message, code=Code.BITRATE):
    """Set the bus speed; all drives need the same. The speed of the answer is unknown."""

    bitrate: Annotated[Bitrate, choice(Bitrate)]


@message()
class SetId(Message, code=Code.NODE):
    """Change the drive's id. Whether the answer has the old or the new id is not documented."""

    node: _Node


@message()
class SetReplies(Message, code=Code.REPLIES, needs=Ability.CHOICE_OF_COMPLETION):
    """Set which replies the drive sends to commands. In this format since 1.0.4."""

    mode: _Replies


Setting: TypeAlias = (
    SetMode
    | SetCurrent
    | SetMicrosteps
    | SetStallProtection
    | SetHoming
    | SetArrival
    | SilenceWatchdog
    | SetBitrate
    | SetId
    | SetReplies
)
SETTINGS: tuple[type[Setting], ...] = get_args(Setting)
SETTING_CODES = frozenset(setting.code for setting in SETTINGS)


def _code_of(codes: frozenset[Code], words: str) -> Form:
    """Return the form of a code from a set."""

    def check(field: str, value: object) -> None:
        if value not in codes or not isinstance(value, Code):
            raise BadField(field, value, f"the Code of {words}")

    return Form(1, check, lambda value: bytes((value,)), lambda data: Code(data[0]))


@message()
class ReadSetting(Message, code=Code.READ_SETTING, needs=Ability.READ_SETTINGS):
    """Ask for a setting, by the code that sets it.

    The answer has the same code as the answer to the setting's write, so a host never has both
    requests open at once.
    """

    setting: Annotated[Code, _code_of(SETTING_CODES, "a setting")]


# -- moves ---------------------------------------------------------------------------------------

ACC_MAX = 255
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


@message()
class MoveRelativeAxis(Message, code=Code.RELATIVE_AXIS, order=(*_MOVE_ORDER, "counts")):
    """Move by a number of encoder counts."""

    counts: _Target
    speed_rpm: _Speed
    acc: _Acc


@message()
class MoveAbsoluteAxis(Message, code=Code.ABSOLUTE_AXIS, order=(*_MOVE_ORDER, "counts")):
    """Move to an encoder count. Since 1.0.5 it also replaces a motion under way."""

    counts: _Target
    speed_rpm: _Speed
    acc: _Acc


@message()
class MoveAbsolutePulses(
    Message,
    code=Code.ABSOLUTE_PULSES,
    needs=Ability.ABSOLUTE_PULSES,
    order=(*_MOVE_ORDER, "pulses"),
):
    """Move to a position in pulses."""

    pulses: _Target
    speed_rpm: _Speed
    acc: _Acc


_DISTANCE_MAX = (1 << 8 * TARGET_BYTES) - 1


@message()
class MoveRelativePulses(Message, code=Code.RELATIVE_PULSES):
    """Move by a number of pulses. The direction is sent with the speed."""

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
        """Decode a payload."""
        sized(payload, 6)
        way = int.from_bytes(payload[:2], "big")
        distance = int.from_bytes(payload[3:], "big")
        return cls(-distance if way & _CLOCKWISE else distance, way & _SPEED, payload[2])


@message()
class RunAtSpeed(Message, code=Code.SPEED_MODE):
    """Run at a signed speed until the next command; only the silence watchdog ends it otherwise."""

    speed_rpm: _SignedSpeed
    acc: _Acc


Move: TypeAlias = MoveRelativeAxis | MoveAbsoluteAxis | MoveRelativePulses | MoveAbsolutePulses
MOVES: tuple[type[Move], ...] = get_args(Move)
MOTION_CODES = frozenset((*(move.code for move in MOVES), Code.SPEED_MODE))

# -- stops, current, homing and other actions ----------------------------------------------------


@message()
class Stop:
    """End a motion with this code by a ramp of `acc`, or at once if `acc` is 0."""

    needs: ClassVar[Ability | None] = None
    code: Code
    acc: int

    def __post_init__(self) -> None:
        _code_of(MOTION_CODES, "a motion").check("code", self.code)
        whole("acc", self.acc, 0, ACC_MAX)

    @property
    def payload(self) -> bytes:
        """A speed of 0, acc, and, for moves with a distance, a distance of 0."""
        rest = b"" if self.code is Code.SPEED_MODE else bytes(TARGET_BYTES)
        return bytes((0, 0, self.acc)) + rest


@message()
class EmergencyStop(Message, code=Code.EMERGENCY_STOP, needs=Ability.EMERGENCY_STOP):
    """Stop at once, without a ramp; not advisable above 1000 rpm."""


@message()
class Enable(Message, code=Code.ENABLE):
    """Switch the motor's current on or off. Off releases the shaft."""

    on: Switch


@message()
class ArmSynchronous(Message, code=Code.ARM, needs=Ability.SYNCHRONOUS_START):
    """Make the drive store motions until `GoSynchronous`, or end this mode."""

    on: Switch


@message()
class GoSynchronous(Message, code=Code.GO, needs=Ability.SYNCHRONOUS_START):
    """Start every stored motion. Broadcast only; repeat it after 1 ms, as drives may miss it."""


@message()
class Home(Message, code=Code.HOME):
    """Search for the zero as configured by `SetHoming`. The motor moves."""


@message()
class Calibrate(Message, code=Code.CALIBRATE):
    """Calibrate the encoder. The motor turns and must not have a load on its shaft."""

    @property
    def payload(self) -> bytes:
        """A zero."""
        return b"\0"

    @classmethod
    def read(cls, payload: bytes) -> Self:
        """Decode a payload."""
        if sized(payload, 1) != b"\0":
            raise BadField("payload", payload, "a zero")
        return cls()


@message()
class SetZero(Message, code=Code.ZERO, needs=Ability.ZERO):
    """Set the present position as zero. Moves nothing."""


@message()
class ClearStall(Message, code=Code.CLEAR_STALL):
    """Switch the current on again after a protection has released the shaft."""


# Requests that the drive first answers with `STARTED`, and later with their outcome.
Motion: TypeAlias = Move | RunAtSpeed | Stop | Home | Calibrate
# The codes of these requests.
COURSE_CODES = MOTION_CODES | {Code.HOME, Code.CALIBRATE}
Action: TypeAlias = EmergencyStop | Enable | ArmSynchronous | GoSynchronous | SetZero | ClearStall
ACTIONS: tuple[type[Action], ...] = get_args(Action)
Request: TypeAlias = Read | ReadSetting | Motion | Action | Setting


def needed_for(request: Request) -> Ability | None:
    """Return the ability that a request requires; None if every drive understands it."""
    if isinstance(request, SetCurrent) and not request.keep:
        return Ability.UNKEPT_CURRENT
    return request.needs


def answer_code(request: Request) -> Code:
    """Return the code of the answer to a request."""
    return request.setting if isinstance(request, ReadSetting) else request.code
