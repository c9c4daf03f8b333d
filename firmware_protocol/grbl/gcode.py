"""The g-code that a simulated GRBL board understands: words, blocks and modes.

`parse_block` reads the words of one line, and finds the errors that any state would give. `Modal`
has the active modes; it finds the errors that depend on them, and `after` returns the next modes.

These are the words that the driver sends, and those into which a lost or changed byte turns them.
All others are refused as a board refuses what its build leaves out, with error 20.

Source: gnea/grbl grbl/gcode.c, steps 2 and 3; the M64 to M68 of grblHAL and FluidNC.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import Enum
from types import MappingProxyType

from firmware_protocol.errors import RemoteProtocolError
from firmware_protocol.fields import message
from firmware_protocol.grbl.dialect import Dialect, take_number, write_number


class Group(Enum):
    """Modal groups. A block may have one word of each. Some are named as the mode in `Modal`."""

    MOTION = "motion"
    COORDINATES = "coordinates"
    PLANE = "plane"
    UNITS = "units"
    DISTANCE = "distance"
    SPINDLE = "spindle"
    COOLANT = "coolant"
    FEED_MODE = "feed mode"
    OUTPUT = "output"


# Every command word and its group.
COMMANDS: Mapping[str, Group] = MappingProxyType(
    {
        name: group
        for names, group in (
            ("G0 G1", Group.MOTION),
            # no offsets are stored, so all coordinate systems are the same
            ("G54 G55 G56 G57 G58 G59", Group.COORDINATES),
            ("G17 G18 G19", Group.PLANE),
            ("G20 G21", Group.UNITS),
            ("G90 G91", Group.DISTANCE),
            ("M3 M5", Group.SPINDLE),
            ("M7 M8 M9", Group.COOLANT),
            ("G94", Group.FEED_MODE),
            ("M64 M65 M67 M68", Group.OUTPUT),
        )
        for name in names.split()
    }
)


class GcodeError(RemoteProtocolError):
    """The host sent a line that GRBL refuses with `code`."""

    def __init__(self, code: int) -> None:
        self.code = code
        super().__init__(f"error {code}")


@dataclass(frozen=True, slots=True)
class Block:
    """The words of one line: commands by group, axis words, and the other values by letter.

    Numbers are as written, in the active unit. `jog` means that the words followed `$J=`.
    """

    commands: Mapping[Group, str] = field(default_factory=dict, hash=False)
    axes: Mapping[str, float] = field(default_factory=dict, hash=False)
    values: Mapping[str, float] = field(default_factory=dict, hash=False)
    jog: bool = False

    @property
    def moves(self) -> bool:
        """Whether the block's axis words are the target of a motion, or a motion lacks them."""
        return bool(self.axes) or Group.MOTION in self.commands


VALUE_LETTERS = frozenset("FPS")
OUTPUT_LETTERS = frozenset("EQ")


def parse_block(text: str, dialect: Dialect, *, jog: bool = False) -> Block:
    """Read the words of a cleaned line; raises `GcodeError`."""
    commands: dict[Group, str] = {}
    axes: dict[str, float] = {}
    values: dict[str, float] = {}
    known = VALUE_LETTERS | OUTPUT_LETTERS if dialect.outputs else VALUE_LETTERS
    at = 0
    while at < len(text):
        letter = text[at]
        if not "A" <= letter <= "Z":
            raise GcodeError(1)
        taken = take_number(text, at + 1)
        if taken is None:
            raise GcodeError(2)
        value, at = taken
        if letter in "GM":
            name = f"{letter}{write_number(value)}"
            group = COMMANDS.get(name)
            if group is None or (group is Group.OUTPUT and not dialect.outputs):
                raise GcodeError(20)
            if group in commands:
                # two motions on one line: so a lost line end gives error 24, as was seen
                raise GcodeError(24 if group is Group.MOTION else 21)
            commands[group] = name
        elif letter not in known and letter not in dialect.axes:
            raise GcodeError(20)
        elif letter in axes or letter in values:
            raise GcodeError(25)
        elif letter in VALUE_LETTERS and value < 0:
            raise GcodeError(4)
        else:
            (axes if letter in dialect.axes else values)[letter] = value
    return Block(commands, axes, values, jog)


# The active modes and how a block changes them, like step 3 of GRBL's parser.

MM_PER_INCH = 25.4
# The value words that a command needs.
_NEEDED: Mapping[str, str] = {"M64": "P", "M65": "P", "M67": "EQ", "M68": "EQ"}


@message()
class Modal:
    """GRBL's parser state, at first as after a start. `feed` is in mm/min, 0 if none is set."""

    motion: str = "G0"
    units: str = "G21"
    distance: str = "G90"
    spindle: str = "M5"
    coolant: str = "M9"
    feed: float = 0.0
    speed: float = 0.0

    def during(self, block: Block) -> Modal:
        """Return the modes while a block is executed; raises `GcodeError`."""
        named = {group.value: name for group, name in block.commands.items()}
        words = {mode: name for mode, name in named.items() if hasattr(self, mode)}
        modes = replace(self, **words, speed=block.values.get("S", self.speed))  # type: ignore[arg-type]
        if block.jog:
            modes = replace(modes, motion="G1", feed=0.0)  # a jog needs a feed of its own
        feed = block.values.get("F")
        if feed is not None:
            modes = replace(modes, feed=feed * modes.unit_mm)
        needed = {letter for name in named.values() for letter in _NEEDED.get(name, "")}
        if not needed <= block.values.keys():
            raise GcodeError(28)
        if (block.jog or (block.moves and modes.motion == "G1")) and modes.feed == 0:
            raise GcodeError(22)
        if block.values.keys() - needed - set("F" if block.jog else "FS"):
            raise GcodeError(36)
        # A jog without an axis word is accepted and moves nothing: observed on grbl-Mega-5X,
        # grblHAL and FluidNC, although doc/markdown/jogging.md says that it is refused.
        if block.jog and block.commands.keys() - {Group.DISTANCE, Group.UNITS}:
            raise GcodeError(16)
        return modes

    def after(self, block: Block) -> Modal:
        """Return the modes after a block, which a jog leaves unchanged; raises `GcodeError`."""
        modes = self.during(block)
        return self if block.jog else modes

    @property
    def unit_mm(self) -> float:
        """The length of one unit in mm."""
        return MM_PER_INCH if self.units == "G20" else 1.0
