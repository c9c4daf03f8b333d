"""The parts of a drawing in space, and the look of each kind of line (its ink).

Colour is never the only difference: each ink has its own pattern in braille and mark in ASCII.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum
from types import MappingProxyType

from kinematics.geometry import Point


class Ink(IntEnum):
    """The meaning of a line. A cell with several inks takes the style of the greatest."""

    NONE = 0
    TABLE = 1
    REACH = 2
    GUARD = 3
    BASE = 4
    PLANNED = 5
    DRIVEN = 6
    GOAL = 7
    ARM = 8
    GRIPPER = 9
    JOINT = 10
    AXIS = 11
    WORD = 12


@dataclass(frozen=True, slots=True)
class Pattern:
    """The look of an ink: of each `period` dots of a line, the first `on` are drawn.

    `mark` is its character in ASCII; if empty, the character depends on the slope. `word` is its
    name in the legend.
    """

    on: int = 1
    period: int = 1
    mark: str = ""
    thick: bool = False
    word: str = ""


PATTERNS: Mapping[Ink, Pattern] = MappingProxyType(
    {
        Ink.TABLE: Pattern(1, 6, "."),
        Ink.REACH: Pattern(1, 3, ":", word="reach"),
        Ink.GUARD: Pattern(4, 6, "#", word="guard"),
        Ink.BASE: Pattern(),
        Ink.PLANNED: Pattern(2, 5, "+", word="way"),
        Ink.DRIVEN: Pattern(1, 1, "~", word="driven"),
        Ink.GOAL: Pattern(5, 8, "=", word="goal G"),
        Ink.ARM: Pattern(thick=True),
        Ink.GRIPPER: Pattern(),
        Ink.JOINT: Pattern(1, 1, "o"),
        Ink.AXIS: Pattern(),
    }
)
"""Every ink that draws lines."""


@dataclass(frozen=True, slots=True)
class Stroke:
    """A line through points in mm; its pattern continues around the corners."""

    ink: Ink
    points: tuple[Point, ...]


@dataclass(frozen=True, slots=True)
class Letters:
    """Text at a point in mm."""

    ink: Ink
    at: Point
    text: str


@dataclass(frozen=True, slots=True)
class Layer:
    """Lines, texts, and points that are marked as joints."""

    strokes: tuple[Stroke, ...] = ()
    letters: tuple[Letters, ...] = ()
    joints: tuple[Point, ...] = ()

    def __add__(self, other: Layer) -> Layer:
        return Layer(
            self.strokes + other.strokes,
            self.letters + other.letters,
            self.joints + other.joints,
        )
