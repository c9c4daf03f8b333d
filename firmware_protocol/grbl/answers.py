"""What a device says of lines and of itself: ok, errors, alarms, banners, settings, messages.

Values checked when built, each with its line.
"""

from __future__ import annotations

from dataclasses import dataclass

from firmware_protocol.errors import BadField, whole
from firmware_protocol.grbl.dialect import Variant
from firmware_protocol.grbl.system import SETTING_MAX
from firmware_protocol.grbl.words import printable

CODE_MAX = 255


def within(field_name: str, value: object, forbidden: str) -> str:
    """Return printable text without the signs that would end it early, or raise `BadField`."""
    text = printable(field_name, value)
    if any(sign in forbidden for sign in text):
        raise BadField(field_name, value, f"text without any of {forbidden}")
    return text


@dataclass(frozen=True, slots=True)
class Ok:
    """The line was taken."""

    @property
    def line(self) -> str:
        """The line without its end."""
        return "ok"


@dataclass(frozen=True, slots=True)
class Error:
    """The line was refused and did nothing."""

    code: int

    def __post_init__(self) -> None:
        whole("code", self.code, 1, CODE_MAX)

    @property
    def line(self) -> str:
        """The line without its end."""
        return f"error:{self.code}"


@dataclass(frozen=True, slots=True)
class Alarm:
    """The machine has locked itself."""

    code: int

    def __post_init__(self) -> None:
        whole("code", self.code, 1, CODE_MAX)

    @property
    def line(self) -> str:
        """The line without its end."""
        return f"ALARM:{self.code}"


@dataclass(frozen=True, slots=True)
class Banner:
    """The first line after a start or a reset.

    `firmware` is FluidNC's own version; the others have none here.
    """

    version: str = "1.1h"
    variant: Variant = Variant.GRBL
    firmware: str = ""

    def __post_init__(self) -> None:
        if not within("version", self.version, " []'<>"):
            raise BadField("version", self.version, "not empty")
        within("firmware", self.firmware, "[]'")
        if (self.variant is Variant.FLUIDNC) != bool(self.firmware):
            raise BadField("firmware", self.firmware, "given by FluidNC and by no other")

    @property
    def line(self) -> str:
        """The line without its end."""
        if self.variant is Variant.FLUIDNC:
            return f"Grbl {self.version} [FluidNC {self.firmware} '$' for help]"
        hint = "'$' or '$HELP'" if self.variant is Variant.GRBLHAL else "'$'"
        return f"{self.variant} {self.version} [{hint} for help]"


@dataclass(frozen=True, slots=True)
class Setting:
    """A setting's value, as text. A key that is no number, as FluidNC's paths, stays text.

    Startup lines come as the keys N0 and N1.
    """

    key: int | str
    value: str

    def __post_init__(self) -> None:
        if isinstance(self.key, str):
            if not within("key", self.key, "= ") or self.key.isdigit():
                raise BadField("key", self.key, "a number, or a name that is none")
        else:
            whole("key", self.key, 0, SETTING_MAX)
        if printable("value", self.value).strip() != self.value:
            raise BadField("value", self.value, "text without spaces around it")

    @property
    def line(self) -> str:
        """The line without its end."""
        return f"${self.key}={self.value}"


@dataclass(frozen=True, slots=True)
class Feedback:
    """A message for people: `[MSG:...]`."""

    text: str

    def __post_init__(self) -> None:
        printable("text", self.text)

    @property
    def line(self) -> str:
        """The line without its end."""
        return f"[MSG:{self.text}]"


@dataclass(frozen=True, slots=True)
class StartupEcho:
    """A startup line was executed, or refused with a code; this is no answer to any line."""

    text: str
    code: int | None = None

    def __post_init__(self) -> None:
        printable("text", self.text)
        if self.code is not None:
            whole("code", self.code, 1, CODE_MAX)

    @property
    def line(self) -> str:
        """The line without its end."""
        return f">{self.text}:{'ok' if self.code is None else f'error:{self.code}'}"


@dataclass(frozen=True, slots=True)
class Bracketed:
    """Any other line in brackets, as `[HLP:...]` or `[FIRMWARE:grblHAL]`: what stands inside."""

    text: str

    def __post_init__(self) -> None:
        printable("text", self.text)

    @property
    def line(self) -> str:
        """The line without its end."""
        return f"[{self.text}]"
