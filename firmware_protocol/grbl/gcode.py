"""The g-code that a simulated GRBL board understands: words, blocks and modes.

`parse_block` reads the words of one line, and finds the errors that any state would give. `Modal`
has the active modes; it finds the errors that depend on them, and `after` returns the next modes.

Arcs (G2, G3), probing (G38), tool lengths (G43, G49) and inverse-time feed (G93) are left out: they
are refused like any unknown word, with error 20. No driver sends them.

Source: gnea/grbl grbl/gcode.c, steps 2 and 3; the M62 to M68 of grbl-Mega-5X and grblHAL.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import Enum, auto
from types import MappingProxyType

from firmware_protocol.errors import RemoteProtocolError
from firmware_protocol.fields import message
from firmware_protocol.grbl.answers import Remark
from firmware_protocol.grbl.codes import error_code
from firmware_protocol.grbl.dialect import Dialect, take_number, write_number


class Group(Enum):
    """Modal groups. A block may have one word of each."""

    NON_MODAL = auto()
    MOTION = auto()
    PLANE = auto()
    DISTANCE = auto()
    ARC_DISTANCE = auto()
    FEED_MODE = auto()
    UNITS = auto()
    CUTTER = auto()
    COORDINATES = auto()
    CONTROL = auto()
    FLOW = auto()
    SPINDLE = auto()
    COOLANT = auto()
    OUTPUT = auto()


@message()
class Word:
    """A command word, its group, and whether the axis words of its block belong to it."""

    name: str
    group: Group
    takes_axes: bool


_ROWS: tuple[tuple[str, Group, bool], ...] = (
    ("G0 G1", Group.MOTION, True),
    ("G80", Group.MOTION, False),
    ("G10 G28 G30 G92", Group.NON_MODAL, True),
    ("G4 G53 G28.1 G30.1 G92.1", Group.NON_MODAL, False),
    ("G17 G18 G19", Group.PLANE, False),
    ("G90 G91", Group.DISTANCE, False),
    ("G91.1", Group.ARC_DISTANCE, False),
    ("G94", Group.FEED_MODE, False),
    ("G20 G21", Group.UNITS, False),
    ("G40", Group.CUTTER, False),
    ("G54 G55 G56 G57 G58 G59", Group.COORDINATES, False),
    ("G61", Group.CONTROL, False),
    ("M0 M1 M2 M30", Group.FLOW, False),
    ("M3 M4 M5", Group.SPINDLE, False),
    ("M7 M8 M9", Group.COOLANT, False),
    ("M62 M63 M64 M65 M67 M68", Group.OUTPUT, False),
)

COMMANDS: dict[str, Word] = {
    name: Word(name, group, takes) for names, group, takes in _ROWS for name in names.split()
}
"""Every command word by its name."""

WHOLE_COMMANDS = frozenset(name.partition(".")[0] for name in COMMANDS)
"""The whole parts of the commands: after them, a wrong decimal is error 20 or 23."""
BAD_DECIMALS_UNSUPPORTED = frozenset({"G28", "G30", "G61", "G90", "G91", "G92"})
"""After these, decimals that do not exist are error 20, after others error 23."""
VALUE_LETTERS = frozenset("FIJKLNPRST")
OUTPUT_LETTERS = frozenset("EQ")
NOT_NEGATIVE = frozenset("FNPTS")
JOG_GROUPS = frozenset({Group.DISTANCE, Group.UNITS, Group.NON_MODAL})
LINE_NUMBER_MAX = 10_000_000
TOOL_MAX = 255


# One line of g-code as a block, like step 2 of GRBL's parser.
#
# Errors of the words alone are found here, errors that depend on the active modes by `Modal`. A
# refusal has the number of GRBL's answer.


class GcodeError(RemoteProtocolError):
    """The host sent a line that GRBL refuses with `code`."""

    def __init__(self, code: int, detail: str = "") -> None:
        self.code = code
        meaning = error_code(code).meaning
        super().__init__(f"error {code}: {meaning}{f' ({detail})' if detail else ''}")


@dataclass(frozen=True, slots=True)
class Block:
    """The words of one line: commands by group, axis words, and the other values by letter.

    Numbers are as written, in the active unit. `jog` means that the words followed `$J=`.
    """

    commands: Mapping[Group, str] = field(default_factory=dict, hash=False)
    axes: Mapping[str, float] = field(default_factory=dict, hash=False)
    values: Mapping[str, float] = field(default_factory=dict, hash=False)
    jog: bool = False

    def __post_init__(self) -> None:
        for name in ("commands", "axes", "values"):
            object.__setattr__(self, name, MappingProxyType(dict(getattr(self, name))))

    @property
    def motion_use(self) -> bool:
        """Whether the block's axis words are the target of a motion, or a motion lacks them."""
        takers = {group for group, name in self.commands.items() if COMMANDS[name].takes_axes}
        return Group.MOTION in takers or (not takers and bool(self.axes))


def parse_block(text: str, dialect: Dialect, *, jog: bool = False) -> Block:
    """Read the words of a cleaned line; raises `GcodeError`."""
    commands: dict[Group, str] = {}
    axes: dict[str, float] = {}
    values: dict[str, float] = {}
    taken_axes = False
    at = 0
    while at < len(text):
        letter = text[at]
        if not "A" <= letter <= "Z":
            raise GcodeError(1, letter)
        taken = take_number(text, at + 1)
        if taken is None:
            raise GcodeError(2, letter)
        value, at = taken
        if letter in "GM":
            word = _command(letter, value, dialect)
            if word.takes_axes and taken_axes:
                raise GcodeError(24, word.name)
            taken_axes |= word.takes_axes
            if word.group in commands:
                raise GcodeError(21, word.name)
            commands[word.group] = word.name
        else:
            _store(letter, value, dialect, axes, values)
    if values.get("N", 0) > LINE_NUMBER_MAX:
        raise GcodeError(27)
    return Block(commands, axes, values, jog)


def _command(letter: str, value: float, dialect: Dialect) -> Word:
    """Find a command word; GRBL identifies decimal words by their hundredths."""
    whole_part = int(value)
    hundredths = round(100 * (value - whole_part))
    stem = f"{letter}{whole_part}"
    if value < 0 or stem not in WHOLE_COMMANDS:
        raise GcodeError(20, stem)
    name = stem if hundredths == 0 else f"{stem}.{hundredths:02d}".rstrip("0")
    word = COMMANDS.get(name)
    if word is None:
        raise GcodeError(20 if stem in BAD_DECIMALS_UNSUPPORTED else 23, name)
    if word.group is Group.OUTPUT and not dialect.outputs:
        raise GcodeError(20, name)
    return word


def _store(
    letter: str,
    value: float,
    dialect: Dialect,
    axes: dict[str, float],
    values: dict[str, float],
) -> None:
    """Add a value word to the axes or the other values."""
    into = axes if letter in dialect.axes else values
    known = VALUE_LETTERS | OUTPUT_LETTERS if dialect.outputs else VALUE_LETTERS
    if into is values and letter not in known:
        raise GcodeError(20, letter)
    if letter == "T" and value > TOOL_MAX:
        raise GcodeError(38)
    if letter in into:
        raise GcodeError(25, letter)
    if letter in NOT_NEGATIVE and value < 0:
        raise GcodeError(4, letter)
    into[letter] = value


# The active modes and how a block changes them, like step 3 of GRBL's parser.
#
# Checks that need positions are left out: the simulated board makes those.

MM_PER_INCH = 25.4
_FIELDS = {
    Group.MOTION: "motion",
    Group.COORDINATES: "coordinates",
    Group.PLANE: "plane",
    Group.UNITS: "units",
    Group.DISTANCE: "distance",
    Group.SPINDLE: "spindle",
    Group.COOLANT: "coolant",
}
_NEEDED = {"G4": "P", "G10": "PL", "M62": "P", "M63": "P", "M64": "P", "M65": "P"}
_NEEDED |= {"M67": "EQ", "M68": "EQ"}
_ALWAYS_USED = {False: frozenset("NFST"), True: frozenset("NF")}
_COORDINATE_SYSTEMS = 6


@message()
class Modal:
    """GRBL's parser state, at first as after a start. `feed` is in mm/min, 0 if none is set."""

    motion: str = "G0"
    coordinates: str = "G54"
    plane: str = "G17"
    units: str = "G21"
    distance: str = "G90"
    spindle: str = "M5"
    coolant: str = "M9"
    tool: int = 0
    feed: float = 0.0
    speed: float = 0.0

    @property
    def report(self) -> Remark:
        """The answer to `$G`."""
        modes = (self.motion, self.coordinates, self.plane, self.units, self.distance, "G94")
        numbers = (f"T{self.tool}", f"F{write_number(self.feed)}", f"S{write_number(self.speed)}")
        return Remark(f"[GC:{' '.join((*modes, self.spindle, self.coolant, *numbers))}]")

    def during(self, block: Block) -> Modal:
        """Return the modes while a block is executed; raises `GcodeError`."""
        words = {_FIELDS[group]: name for group, name in block.commands.items() if group in _FIELDS}
        modes = replace(self, **words)  # type: ignore[arg-type]
        if block.jog:
            modes = replace(modes, motion="G1")
        modes = replace(
            modes,
            feed=self._feed(block, modes),
            speed=block.values.get("S", self.speed),
            tool=int(block.values.get("T", self.tool)),
        )
        _check_non_modal(block, modes)
        _check_motion(block, modes)
        _check_leftovers(block)
        if block.jog:
            _check_jog(block)
        return modes

    def after(self, block: Block) -> Modal:
        """Return the modes after a block, which a jog leaves unchanged; raises `GcodeError`."""
        modes = self.during(block)
        if block.jog:
            return self
        if block.commands.get(Group.FLOW) in ("M2", "M30"):
            return Modal(
                "G1", units=modes.units, tool=modes.tool, feed=modes.feed, speed=modes.speed
            )
        return modes

    def _feed(self, block: Block, modes: Modal) -> float:
        """Return the feed of a block in mm/min; a jog needs its own."""
        given = block.values.get("F")
        if given is not None:
            return given * modes.unit_mm
        if block.jog:
            raise GcodeError(22)
        return self.feed

    @property
    def unit_mm(self) -> float:
        """The length of one unit in mm."""
        return MM_PER_INCH if self.units == "G20" else 1.0


def lengths_mm(block: Block, modes: Modal) -> dict[str, float]:
    """Return the axis words in millimetres, under the modes that hold during the block."""
    return {letter: value * modes.unit_mm for letter, value in block.axes.items()}


def _check_non_modal(block: Block, modes: Modal) -> None:
    name = block.commands.get(Group.NON_MODAL)
    if name in ("G10", "G92") and not block.axes:
        raise GcodeError(26, name)
    for command in (name, block.commands.get(Group.OUTPUT)):
        if command and not set(_NEEDED.get(command, "")) <= block.values.keys():
            raise GcodeError(28, command)
    if name == "G10":
        _check_g10(block)
    if name == "G53" and modes.motion not in ("G0", "G1"):
        raise GcodeError(30)


def _check_g10(block: Block) -> None:
    if int(block.values["P"]) > _COORDINATE_SYSTEMS:
        raise GcodeError(29)
    how = int(block.values["L"])
    if how not in (2, 20) or (how == 2 and "R" in block.values):
        raise GcodeError(20, f"G10 L{how}")


def _check_motion(block: Block, modes: Modal) -> None:
    if modes.motion == "G80" and block.axes:
        raise GcodeError(31)
    if block.motion_use and modes.motion == "G1" and modes.feed == 0:
        raise GcodeError(22)


def _check_leftovers(block: Block) -> None:
    """Refuse unused value words; axis words are used, or were refused before."""
    used = set().union(*(_NEEDED.get(name, "") for name in block.commands.values()))
    if block.values.keys() - used - _ALWAYS_USED[block.jog]:
        raise GcodeError(36)


def _check_jog(block: Block) -> None:
    """Refuse all commands in a jog except distance, units and G53.

    A jog without an axis word is accepted and moves nothing: observed on grbl-Mega-5X, grblHAL and
    FluidNC, although doc/markdown/jogging.md says that it is refused.
    """
    if block.commands.keys() - JOG_GROUPS or block.commands.get(Group.NON_MODAL, "G53") != "G53":
        raise GcodeError(16)
