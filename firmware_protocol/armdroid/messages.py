"""What a host asks of an Armdroid with the serial driver sketch, as values checked when built.

Source: Armdroid/Armdroid-Arduino-Library, examples/SerialDriver/SerialDriver.ino (firmware 2.0,
protocol 1.0a) and Armdroid.cpp. Counts are whole motor steps, 48 a turn, in signed 16 bit, as the
sketch keeps them on an AVR board. What does not fit raises `BadField`.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import ClassVar, TypeAlias

from firmware_protocol.errors import BadField
from firmware_protocol.fields import BYTE, boolean, checks, optional, row_of, whole_from

MOTORS = 6
"""1 gripper, 2 left wrist, 3 right wrist, 4 elbow, 5 shoulder, 6 base."""
KEPT = MOTORS - 1
"""How many arguments the sketch keeps; the sixth number is its accumulator."""
STEPS_MIN, STEPS_MAX = -(1 << 15), (1 << 15) - 1
STEPS_PER_TURN = 48
RPM_DEFAULT = 100
"""The speed after the board has started."""
RPM_MAX = 60 * 1000 // STEPS_PER_TURN
"""One step a millisecond. Above it the sketch steps as fast as it can; 0 it divides by."""


STEPS = whole_from(STEPS_MIN, STEPS_MAX)
SIX_STEPS = row_of(STEPS, MOTORS, f"{MOTORS} counts of steps")


@dataclass(frozen=True, slots=True)
@checks(motor=whole_from(1, MOTORS), steps=STEPS)
class DriveOne:
    """Move one motor, 1 to 6, by relative steps; the answer comes at the motion's end.

    It leaves arguments behind in the board: the first becomes the motor's number and the others
    stay what the last `DriveAll` made them. A `D` that somebody else sends later moves motors 1
    to 5 by those numbers. `DropArguments` takes them away.
    """

    letter: ClassVar[str] = "d"
    motor: int
    steps: int


@dataclass(frozen=True, slots=True)
@checks(steps=SIX_STEPS)
class DriveAll:
    """Move all six motors together by relative steps, each at the same rate until it is done.

    All six numbers are always written, so that what the board has kept never matters here. It
    keeps the first five: the letter `D` alone, in the text `@READ` say, moves motors 1 to 5 once
    more. `DropArguments` takes them away.
    """

    letter: ClassVar[str] = "D"
    steps: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class HomeToOffsets:
    """Drive all motors back to offset zero, the whole way; nothing stops it."""

    letter: ClassVar[str] = "h"


@dataclass(frozen=True, slots=True)
class ReportOffsets:
    """Ask for the six offsets."""

    letter: ClassVar[str] = "o"


@dataclass(frozen=True, slots=True)
class ZeroOffsets:
    """Call the present position zero; the board forgets its accumulator and arguments too."""

    letter: ClassVar[str] = "r"


@dataclass(frozen=True, slots=True)
@checks(rpm=whole_from(1, RPM_MAX))
class SetSpeed:
    """Set the speed of later motions, 1 to 1250 rpm.

    The board waits a whole number of milliseconds between steps, so that many speeds are one.
    """

    letter: ClassVar[str] = "s"
    rpm: int

    @property
    def step_interval_ms(self) -> int:
        """The least time between two steps at this speed."""
        return RPM_MAX // self.rpm


@dataclass(frozen=True, slots=True)
@checks(on=boolean)
class Torque:
    """Switch the motor current on or off; off lets the arm sag."""

    letter: ClassVar[str] = "t"
    on: bool


@dataclass(frozen=True, slots=True)
class Version:
    """Ask for the versions of the firmware and the protocol."""

    letter: ClassVar[str] = "v"


@dataclass(frozen=True, slots=True)
class InterfaceKind:
    """Ask which interface to the motors the firmware was built for."""

    letter: ClassVar[str] = "V"


@dataclass(frozen=True, slots=True)
class ReportArguments:
    """Ask for the kept arguments and the accumulator (the sketch's own debugging command)."""

    letter: ClassVar[str] = "g"


@dataclass(frozen=True, slots=True)
class Clear:
    """Empty the accumulator and the argument index whatever was left in them; moves nothing.

    A comma takes the left-over number out of the accumulator, and a `d` of 0 steps resets the
    index. Numbers that another program left half sent would else become part of the next motion:
    make this the first command of a session and the first after a command that was given up.
    """

    letter: ClassVar[str] = "d"


@dataclass(frozen=True, slots=True)
class DropArguments:
    """Make the kept arguments zero, so that a stray `D` moves nothing; moves nothing itself.

    Only after `Clear` or any drive: with the index elsewhere the last comma would write behind
    the sketch's array of five.
    """

    letter: ClassVar[str] = "d"


@dataclass(frozen=True, slots=True)
@checks(motor=BYTE, steps=STEPS)
class DriveNone:
    """What a board makes of a `d` for a motor that does not exist: it moves nothing and answers.

    Only devices meet it. `motor` is the low byte of the first argument, as the sketch takes it.
    """

    letter: ClassVar[str] = "d"
    motor: int
    steps: int

    def __post_init__(self) -> None:
        if 1 <= self.motor <= MOTORS:
            raise BadField("motor", self.motor, "no motor of the arm: use DriveOne")


@dataclass(frozen=True, slots=True)
@checks(rpm=STEPS)
class OddSpeed:
    """An `s` with a speed that no host of ours sends. Only devices meet it.

    At 0 the sketch divides by zero, which on an AVR means that later motions never end; below 0
    and above 1250 it steps as fast as it can.
    """

    letter: ClassVar[str] = "s"
    rpm: int

    def __post_init__(self) -> None:
        if 1 <= self.rpm <= RPM_MAX:
            raise BadField("rpm", self.rpm, f"no whole number from 1 to {RPM_MAX}: use SetSpeed")


Command: TypeAlias = (
    DriveOne
    | DriveAll
    | HomeToOffsets
    | ReportOffsets
    | ZeroOffsets
    | SetSpeed
    | Torque
    | Version
    | InterfaceKind
    | ReportArguments
    | Clear
    | DropArguments
)

Request: TypeAlias = Command | DriveNone | OddSpeed
"""What a device can be asked: it sees `Clear` and `DropArguments` as drives that move nothing."""


# What an Armdroid with the serial driver sketch says, as values checked when they are built.

_WORD = re.compile(r"[!-.0-~]{1,16}")


def _word(field: str, value: object) -> str:
    if not isinstance(value, str) or not _WORD.fullmatch(value):
        raise BadField(field, value, "1 to 16 printable ASCII characters, no space and no slash")
    return value


@dataclass(frozen=True, slots=True)
@checks(offsets=SIX_STEPS)
class OffsetsReported:
    """Where the motors are, in steps from where the offsets were zeroed. They wrap at 16 bit."""

    offsets: tuple[int, ...]


@dataclass(frozen=True, slots=True)
@checks(rpm=STEPS)
class SpeedReported:
    """The number that was taken for a speed."""

    rpm: int


@dataclass(frozen=True, slots=True)
@checks(on=boolean)
class TorqueReported:
    """Whether the motor current is on now."""

    on: bool


@dataclass(frozen=True, slots=True)
@checks(firmware=_word, protocol=optional(_word))
class VersionReported:
    """The versions; sketches up to 1.3 name one alone, and `protocol` is None."""

    firmware: str = "2.0"
    protocol: str | None = "1.0a"


@dataclass(frozen=True, slots=True)
@checks(kind=_word)
class InterfaceReported:
    """The interface to the motors: `direct-drive`, or `logic-drive` of the prototype models."""

    kind: str = "direct-drive"


@dataclass(frozen=True, slots=True)
@checks(arguments=row_of(STEPS, KEPT, f"{KEPT} counts of steps"), accumulator=STEPS)
class ArgumentsReported:
    """The five kept arguments and the accumulator."""

    arguments: tuple[int, ...]
    accumulator: int


@dataclass(frozen=True, slots=True)
class Welcome:
    """What a board with native USB says when its port is opened; it has then forgotten arguments.

    Commands that were sent before it are carried out after it.
    """


Answer: TypeAlias = (
    OffsetsReported
    | SpeedReported
    | TorqueReported
    | VersionReported
    | InterfaceReported
    | ArgumentsReported
)

ANSWER_TO: dict[str, type[Answer]] = {
    "d": OffsetsReported,
    "D": OffsetsReported,
    "h": OffsetsReported,
    "o": OffsetsReported,
    "r": OffsetsReported,
    "s": SpeedReported,
    "t": TorqueReported,
    "v": VersionReported,
    "V": InterfaceReported,
    "g": ArgumentsReported,
}
"""What answers each letter that is a command; every other letter is ignored."""
