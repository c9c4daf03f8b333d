"""The g-code words of the GRBL family: which there are, and what excludes what.

Source: gnea/grbl grbl/gcode.c, step 2; the M62 to M68 of grbl-Mega-5X and grblHAL.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, auto


class Group(Enum):
    """Modal groups: of each a block may have one word."""

    NON_MODAL = auto()
    MOTION = auto()
    PLANE = auto()
    DISTANCE = auto()
    ARC_DISTANCE = auto()
    FEED_MODE = auto()
    UNITS = auto()
    CUTTER = auto()
    TOOL_LENGTH = auto()
    COORDINATES = auto()
    CONTROL = auto()
    FLOW = auto()
    SPINDLE = auto()
    COOLANT = auto()
    OUTPUT = auto()


class AxisUse(Enum):
    """What wants the axis words of a block."""

    MOTION = auto()
    NON_MODAL = auto()
    TOOL_LENGTH = auto()


@dataclass(frozen=True, slots=True)
class Word:
    """A command word, the group it is of, and whether it claims the axis words."""

    name: str
    group: Group
    axis_use: AxisUse | None = None
    outputs_only: bool = False


_ROWS: tuple[tuple[str, Group, AxisUse | None], ...] = (
    ("G0 G1 G2 G3 G38.2 G38.3 G38.4 G38.5", Group.MOTION, AxisUse.MOTION),
    ("G80", Group.MOTION, None),
    ("G10 G28 G30 G92", Group.NON_MODAL, AxisUse.NON_MODAL),
    ("G4 G53 G28.1 G30.1 G92.1", Group.NON_MODAL, None),
    ("G17 G18 G19", Group.PLANE, None),
    ("G90 G91", Group.DISTANCE, None),
    ("G91.1", Group.ARC_DISTANCE, None),
    ("G93 G94", Group.FEED_MODE, None),
    ("G20 G21", Group.UNITS, None),
    ("G40", Group.CUTTER, None),
    ("G43.1 G49", Group.TOOL_LENGTH, AxisUse.TOOL_LENGTH),
    ("G54 G55 G56 G57 G58 G59", Group.COORDINATES, None),
    ("G61", Group.CONTROL, None),
    ("M0 M1 M2 M30", Group.FLOW, None),
    ("M3 M4 M5", Group.SPINDLE, None),
    ("M7 M8 M9", Group.COOLANT, None),
    ("M62 M63 M64 M65 M67 M68", Group.OUTPUT, None),
)

COMMANDS: dict[str, Word] = {
    name: Word(name, group, use, group is Group.OUTPUT)
    for names, group, use in _ROWS
    for name in names.split()
}
"""Every command word by its name."""

WHOLE_COMMANDS = frozenset(name.partition(".")[0] for name in COMMANDS)
"""Commands whose whole part is known: behind them a wrong decimal is error 20 or 23."""
BAD_DECIMALS_UNSUPPORTED = frozenset({"G28", "G30", "G38", "G43", "G61", "G90", "G91", "G92"})
"""Where decimals that do not exist are answered with error 20, elsewhere with error 23."""
VALUE_LETTERS = frozenset("FIJKLNPRST")
OUTPUT_LETTERS = frozenset("EQ")
NOT_NEGATIVE = frozenset("FNPTS")
JOG_GROUPS = frozenset({Group.DISTANCE, Group.UNITS, Group.NON_MODAL})
LINE_NUMBER_MAX = 10_000_000
TOOL_MAX = 255
