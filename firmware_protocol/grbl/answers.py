"""A board's answers and messages: ok, errors, alarms, banners, settings, build info.

Fields are checked when a message is built; each message can format its line.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

from firmware_protocol.errors import BadField
from firmware_protocol.fields import checks, each, optional, whole_from
from firmware_protocol.grbl.commands import SETTING_MAX
from firmware_protocol.grbl.dialect import RING_BYTES_MAX, Variant
from firmware_protocol.grbl.words import (
    AXIS_LETTERS,
    Template,
    coordinates,
    printable,
    within,
    written,
)

CODE_MAX = 255
CODE = whole_from(1, CODE_MAX)


@dataclass(frozen=True, slots=True)
class Ok:
    """The line was accepted."""

    line: ClassVar[str] = "ok"


@dataclass(frozen=True, slots=True)
@checks(code=CODE)
class Error:
    """The line was refused and had no effect."""

    code: int

    line = Template("error:{code}")


@dataclass(frozen=True, slots=True)
@checks(code=CODE)
class Alarm:
    """The machine is locked."""

    code: int

    line = Template("ALARM:{code}")


@dataclass(frozen=True, slots=True)
@checks(version=within(" []'<>"), firmware=within("[]'"))
class Banner:
    """The first line after a start or a reset.

    `firmware` is FluidNC's own version; the others have none here.
    """

    version: str = "1.1h"
    variant: Variant = Variant.GRBL
    firmware: str = ""

    def __post_init__(self) -> None:
        if not self.version:
            raise BadField("version", self.version, "not empty")
        if (self.variant is Variant.FLUIDNC) != bool(self.firmware):
            raise BadField("firmware", self.firmware, "given by FluidNC and by no other")

    @property
    def line(self) -> str:
        """The line without its end."""
        if self.variant is Variant.FLUIDNC:
            return f"Grbl {self.version} [FluidNC {self.firmware} '$' for help]"
        hint = "'$' or '$HELP'" if self.variant is Variant.GRBLHAL else "'$'"
        return f"{self.variant} {self.version} [{hint} for help]"


def _key(field: str, value: object) -> object:
    number_or_name = within("= ") if isinstance(value, str) else whole_from(0, SETTING_MAX)
    return number_or_name(field, value)


@dataclass(frozen=True, slots=True)
@checks(key=_key, value=printable)
class Setting:
    """A setting's value, as text. Keys that are not numbers, such as FluidNC's paths, stay text.

    Startup lines come as the keys N0 and N1.
    """

    key: int | str
    value: str

    def __post_init__(self) -> None:
        if self.key == "" or (isinstance(self.key, str) and self.key.isdigit()):
            raise BadField("key", self.key, "a number, or a name that is none")
        if self.value.strip() != self.value:
            raise BadField("value", self.value, "text without spaces around it")

    line = Template("${key}={value}")


@dataclass(frozen=True, slots=True)
@checks(text=printable)
class Feedback:
    """A message for people: `[MSG:...]`."""

    text: str

    line = Template("[MSG:{text}]")


@dataclass(frozen=True, slots=True)
@checks(text=printable, code=optional(CODE))
class StartupEcho:
    """A startup line was executed, or refused with a code; this does not answer a line."""

    text: str
    code: int | None = None

    @property
    def line(self) -> str:
        """The line without its end."""
        return f">{self.text}:{'ok' if self.code is None else f'error:{self.code}'}"


@dataclass(frozen=True, slots=True)
@checks(text=printable)
class Bracketed:
    """The contents of any other line in brackets, such as `[HLP:...]` or `[FIRMWARE:grblHAL]`."""

    text: str

    line = Template("[{text}]")


# Answers about the build, the modes and the coordinates.

BLOCKS_MAX = 65535


@dataclass(frozen=True, slots=True)
@checks(version=within(":"), note=printable)
class Version:
    """The firmware's version and the owner's note, from `$I`."""

    version: str
    note: str = ""

    line = Template("[VER:{version}:{note}]")


@dataclass(frozen=True, slots=True)
@checks(
    letters=within(","),
    blocks=optional(whole_from(0, BLOCKS_MAX)),
    rx_bytes=optional(whole_from(0, RING_BYTES_MAX)),
    more=each(within(",")),
)
class BuildInfo:
    """Option letters, planner blocks and the receive buffer, from `$I`; FluidNC sends only letters.

    `more` contains additional fields of newer firmware, unparsed.
    """

    letters: str
    blocks: int | None = None
    rx_bytes: int | None = None
    more: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        given = [part is not None for part in (self.blocks, self.rx_bytes)] + [bool(self.more)]
        if given != sorted(given, reverse=True):
            raise BadField("blocks", self.blocks, "given where what follows is")

    @property
    def line(self) -> str:
        """The line without its end."""
        numbers = [str(n) for n in (self.blocks, self.rx_bytes) if n is not None]
        return f"[OPT:{','.join([self.letters, *numbers, *self.more])}]"


@dataclass(frozen=True, slots=True)
@checks(count=whole_from(1, len(AXIS_LETTERS)))
class AxesInfo:
    """The number of axis motors and their letters; two motors may share a letter."""

    count: int
    letters: str

    def __post_init__(self) -> None:
        if not isinstance(self.letters, str) or not set(self.letters) <= set(AXIS_LETTERS):
            raise BadField("letters", self.letters, f"letters out of {AXIS_LETTERS}")

    line = Template("[AXS:{count}:{letters}]")


@dataclass(frozen=True, slots=True)
@checks(words=each(within(" ]")))
class ParserState:
    """The modes in force, as words: `G0`, `G54`, ..., `F0`, `S0`."""

    words: tuple[str, ...]

    def __post_init__(self) -> None:
        if not self.words or not all(self.words):
            raise BadField("words", self.words, "words, none of them empty")

    @property
    def line(self) -> str:
        """The line without its end."""
        return f"[GC:{' '.join(self.words)}]"


@dataclass(frozen=True, slots=True)
@checks(values=coordinates)
class Parameter:
    """Stored coordinates: G54 to G59, G28, G30, G92, TLO or PRB.

    `success` belongs to PRB: whether the last probing touched something.
    """

    name: str
    values: tuple[float, ...]
    success: bool | None = field(default=None)

    def __post_init__(self) -> None:
        if not is_parameter(self.name):
            raise BadField("name", self.name, "a G number, TLO or PRB")
        if (self.name == "PRB") != (self.success is not None):
            raise BadField("success", self.success, "given for PRB and for no other")

    @property
    def line(self) -> str:
        """The line without its end."""
        end = "" if self.success is None else f":{int(self.success)}"
        return f"[{self.name}:{written(self.values)}{end}]"


def is_parameter(name: object) -> bool:
    """Return whether answers to `$#` use this name."""
    if not isinstance(name, str):
        return False
    return name in ("TLO", "PRB") or (name[:1] == "G" and name[1:2].isdigit() and name.isascii())
