"""What a device tells when asked for its build, its modes and its coordinates.

Values checked when built, each with its line.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from firmware_protocol.errors import BadField, whole
from firmware_protocol.grbl.answers import within
from firmware_protocol.grbl.dialect import RING_BYTES_MAX
from firmware_protocol.grbl.words import AXIS_LETTERS, number, printable

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
