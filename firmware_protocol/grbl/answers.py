"""What a device says of lines and of itself: ok, errors, alarms, banners, settings, messages.

Values checked when built, each with its line.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from firmware_protocol.errors import BadField, whole
from firmware_protocol.grbl.commands import SETTING_MAX
from firmware_protocol.grbl.dialect import RING_BYTES_MAX, Variant
from firmware_protocol.grbl.words import AXIS_LETTERS, number, printable

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


# What a device tells when asked for its build, its modes and its coordinates.
#
# Values checked when built, each with its line.

BLOCKS_MAX = 65535
COORDINATE_DECIMALS = 3
COORDINATE_MAX = 1e9


def coordinates(field_name: str, values: object) -> tuple[float, ...]:
    """Return at least one coordinate as a tuple, or raise `BadField`."""
    if not isinstance(values, tuple | list) or not 1 <= len(values) <= len(AXIS_LETTERS):
        raise BadField(field_name, values, f"1 to {len(AXIS_LETTERS)} numbers")
    return tuple(
        number(f"{field_name}[{i}]", v, -COORDINATE_MAX, COORDINATE_MAX)
        for i, v in enumerate(values)
    )


def write_coordinates(values: tuple[float, ...]) -> str:
    """Return coordinates as GRBL writes them, with three decimals."""
    return ",".join(f"{value:.{COORDINATE_DECIMALS}f}" for value in values)


@dataclass(frozen=True, slots=True)
class Version:
    """The firmware's version and the owner's note, out of `$I`."""

    version: str
    note: str = ""

    def __post_init__(self) -> None:
        within("version", self.version, ":")
        printable("note", self.note)

    @property
    def line(self) -> str:
        """The line without its end."""
        return f"[VER:{self.version}:{self.note}]"


@dataclass(frozen=True, slots=True)
class BuildInfo:
    """Option letters, planner blocks and the receive ring, out of `$I`; FluidNC gives letters.

    `more` is what newer firmwares add, as it came.
    """

    letters: str
    blocks: int | None = None
    rx_bytes: int | None = None
    more: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        within("letters", self.letters, ",")
        object.__setattr__(self, "more", tuple(within("more", part, ",") for part in self.more))
        given = [part is not None for part in (self.blocks, self.rx_bytes)] + [bool(self.more)]
        if given != sorted(given, reverse=True):
            raise BadField("blocks", self.blocks, "given where what follows is")
        if self.blocks is not None:
            whole("blocks", self.blocks, 0, BLOCKS_MAX)
        if self.rx_bytes is not None:
            whole("rx_bytes", self.rx_bytes, 0, RING_BYTES_MAX)

    @property
    def line(self) -> str:
        """The line without its end."""
        numbers = [str(n) for n in (self.blocks, self.rx_bytes) if n is not None]
        return f"[OPT:{','.join([self.letters, *numbers, *self.more])}]"


@dataclass(frozen=True, slots=True)
class AxesInfo:
    """How many motors the board drives as axes, and their letters; two may share a letter."""

    count: int
    letters: str

    def __post_init__(self) -> None:
        whole("count", self.count, 1, len(AXIS_LETTERS))
        if not isinstance(self.letters, str) or not set(self.letters) <= set(AXIS_LETTERS):
            raise BadField("letters", self.letters, f"letters out of {AXIS_LETTERS}")

    @property
    def line(self) -> str:
        """The line without its end."""
        return f"[AXS:{self.count}:{self.letters}]"


@dataclass(frozen=True, slots=True)
class ParserState:
    """The modes in force, as words: `G0`, `G54`, ..., `F0`, `S0`."""

    words: tuple[str, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "words", tuple(within("words", w, " ]") for w in self.words))
        if not self.words or not all(self.words):
            raise BadField("words", self.words, "words, none of them empty")

    @property
    def line(self) -> str:
        """The line without its end."""
        return f"[GC:{' '.join(self.words)}]"


@dataclass(frozen=True, slots=True)
class Parameter:
    """Coordinates that the device keeps: G54 to G59, G28, G30, G92, TLO or PRB.

    `success` belongs to PRB: whether the last probing touched something.
    """

    name: str
    values: tuple[float, ...]
    success: bool | None = field(default=None)

    def __post_init__(self) -> None:
        if not is_parameter(self.name):
            raise BadField("name", self.name, "a G number, TLO or PRB")
        object.__setattr__(self, "values", coordinates("values", self.values))
        if (self.name == "PRB") != (self.success is not None):
            raise BadField("success", self.success, "given for PRB and for no other")

    @property
    def line(self) -> str:
        """The line without its end."""
        end = "" if self.success is None else f":{int(self.success)}"
        return f"[{self.name}:{write_coordinates(self.values)}{end}]"


def is_parameter(name: object) -> bool:
    """Tell whether `$#` answers with such a name."""
    if not isinstance(name, str):
        return False
    return name in ("TLO", "PRB") or (name[:1] == "G" and name[1:2].isdigit() and name.isascii())
