"""What an Armdroid with the serial driver sketch says, as values checked when they are built."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TypeAlias

from firmware_protocol.armdroid.commands import KEPT, STEPS_MAX, STEPS_MIN, six_steps
from firmware_protocol.errors import BadField, whole

_WORD = re.compile(r"[!-.0-~]{1,16}")


def _word(field: str, value: object) -> None:
    if not isinstance(value, str) or not _WORD.fullmatch(value):
        raise BadField(field, value, "1 to 16 printable ASCII characters, no space and no slash")


@dataclass(frozen=True, slots=True)
class OffsetsReported:
    """Where the motors are, in steps from where the offsets were zeroed. They wrap at 16 bit."""

    offsets: tuple[int, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "offsets", six_steps("offsets", self.offsets))


@dataclass(frozen=True, slots=True)
class SpeedReported:
    """The number that was taken for a speed."""

    rpm: int

    def __post_init__(self) -> None:
        whole("rpm", self.rpm, STEPS_MIN, STEPS_MAX)


@dataclass(frozen=True, slots=True)
class TorqueReported:
    """Whether the motor current is on now."""

    on: bool

    def __post_init__(self) -> None:
        if not isinstance(self.on, bool):
            raise BadField("on", self.on, "True or False")


@dataclass(frozen=True, slots=True)
class VersionReported:
    """The versions; sketches up to 1.3 name one alone, and `protocol` is None."""

    firmware: str = "2.0"
    protocol: str | None = "1.0a"

    def __post_init__(self) -> None:
        _word("firmware", self.firmware)
        if self.protocol is not None:
            _word("protocol", self.protocol)


@dataclass(frozen=True, slots=True)
class InterfaceReported:
    """The interface to the motors: `direct-drive`, or `logic-drive` of the prototype models."""

    kind: str = "direct-drive"

    def __post_init__(self) -> None:
        _word("kind", self.kind)


@dataclass(frozen=True, slots=True)
class ArgumentsReported:
    """The five kept arguments and the accumulator."""

    arguments: tuple[int, ...]
    accumulator: int

    def __post_init__(self) -> None:
        object.__setattr__(self, "arguments", six_steps("arguments", self.arguments, KEPT))
        whole("accumulator", self.accumulator, STEPS_MIN, STEPS_MAX)


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
