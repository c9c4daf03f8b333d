"""A host's requests to an MKS drive: reads, settings, motions and actions.

Fields are checked when a request is built. Motions work only in a bus mode. Targets are encoder
counts. `acc` is the drive's own unit for a ramp (`ramp_rpm_s`); 0 means no ramp.
"""

from __future__ import annotations

from typing import Annotated, ClassVar, Self, TypeAlias, get_args

from firmware_protocol.errors import BadField, RemoteProtocolError
from firmware_protocol.fields import message
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
    """Ask for the shaft's position in counts from the set zero, the scale of F5."""


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


@message()
class SetMode(Message, code=Code.MODE):
    """Set the source of commands and the kind of control; `Mode.BUS_FOC` for an arm."""

    mode: Annotated[Mode, choice(Mode)]


@message()
class SetCurrent(Message, code=Code.CURRENT):
    """Set the motor's current."""

    current_ma: Annotated[int, unsigned(2, 1, CURRENT_MAX_MA)]


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
    | SilenceWatchdog
    | SetBitrate
    | SetId
    | SetReplies
)
SETTINGS: tuple[type[Setting], ...] = get_args(Setting)
SETTING_CODES = frozenset(setting.code for setting in SETTINGS)


def _check_setting(field: str, value: object) -> None:
    if value not in SETTING_CODES or not isinstance(value, Code):
        raise BadField(field, value, "the Code of a setting")


_SettingCode: TypeAlias = Annotated[
    Code, Form(1, _check_setting, lambda value: bytes((value,)), lambda data: Code(data[0]))
]


@message()
class ReadSetting(Message, code=Code.READ_SETTING, needs=Ability.READ_SETTINGS):
    """Ask for a setting, by the code that sets it.

    The answer has the same code as the answer to the setting's write, so a host never has both
    requests open at once.
    """

    setting: _SettingCode


# -- moves ---------------------------------------------------------------------------------------

_TARGET_BYTES = 3


@message()
class MoveAbsoluteAxis(Message, code=Code.ABSOLUTE_AXIS, order=("speed_rpm", "acc", "counts")):
    """Move to an encoder count. Since 1.0.5 it also replaces a motion under way."""

    counts: Annotated[int, signed(_TARGET_BYTES, TARGET_MAX)]
    speed_rpm: Annotated[int, unsigned(2, 1, SPEED_MAX_RPM)]
    acc: Annotated[int, unsigned(1)]


# The other kinds of motions, with the number of bytes after the code: by a distance (F4, FD), to a
# pulse (FE), without an end (F6), and the common start of stored ones (4B).
OTHER_MOTIONS = {
    Code.RELATIVE_AXIS: 6,
    Code.RELATIVE_PULSES: 6,
    Code.ABSOLUTE_PULSES: 6,
    Code.SPEED_MODE: 3,
    Code.GO: 0,
}
MOTION_CODES = frozenset({Code.ABSOLUTE_AXIS, *OTHER_MOTIONS}) - {Code.GO}


@message()
class OtherMotion:
    """A motion of a kind that no program here sends: its bytes, for people who watch a bus."""

    needs: ClassVar[Ability | None] = None
    code: Code
    payload: bytes

    def __post_init__(self) -> None:
        if self.code not in OTHER_MOTIONS:
            raise BadField("code", self.code, "the Code of another motion than F5")
        sized(self.payload, OTHER_MOTIONS[self.code])


# -- stops, current, homing and other actions ----------------------------------------------------


@message()
class Stop(Message, code=Code.ABSOLUTE_AXIS):
    """End a motion by a ramp of `acc`, or at once if `acc` is 0: a speed of 0 and any target."""

    acc: Annotated[int, unsigned(1)]

    @property
    def payload(self) -> bytes:
        """A speed of 0, acc, a target of 0."""
        return bytes((0, 0, self.acc)) + bytes(_TARGET_BYTES)


@message()
class EmergencyStop(Message, code=Code.EMERGENCY_STOP, needs=Ability.EMERGENCY_STOP):
    """Stop at once, without a ramp; not advisable above 1000 rpm."""


@message()
class Enable(Message, code=Code.ENABLE):
    """Switch the motor's current on or off. Off releases the shaft."""

    on: Switch


@message()
class ArmSynchronous(Message, code=Code.ARM, needs=Ability.SYNCHRONOUS_START):
    """Make the drive store motions until a common start (4B), or end this mode."""

    on: Switch


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
Motion: TypeAlias = MoveAbsoluteAxis | OtherMotion | Stop | Home | Calibrate
# The codes of these requests.
COURSE_CODES = MOTION_CODES | {Code.HOME, Code.CALIBRATE}
Action: TypeAlias = EmergencyStop | Enable | ArmSynchronous | SetZero | ClearStall
ACTIONS: tuple[type[Action], ...] = get_args(Action)
Request: TypeAlias = Read | ReadSetting | Motion | Action | Setting


def answer_code(request: Request) -> Code:
    """Return the code of the answer to a request."""
    return request.setting if isinstance(request, ReadSetting) else request.code
