"""The lines of a program as they are taught, one after another. Units: mm, s."""

from __future__ import annotations

from armdrive.errors import BadRequest
from armdrive.programs.language.syntax import (
    NAME,
    Do,
    Expression,
    Name,
    Number,
    Statement,
    TextValue,
    Tree,
    Use,
    every,
    names_of,
)
from armdrive.programs.language.words import FUNCTIONS, RESERVED
from armdrive.programs.language.writing import unparse
from armdrive.programs.program import read_program

GRIPS = ("open", "close", "grasp")
"""What the fingers do, besides going to an opening in mm."""


class TaughtLines:
    """Lines that follow a program, or that begin one.

    `speed` is the speed at the end of what is written so far, None if only a run can tell. `own`
    are the names that the program defines, in lower case: they hide points of the same name.
    """

    def __init__(self, speed: float | None = 1.0, own: frozenset[str] = frozenset()) -> None:
        self._speed = speed
        self._own = own
        self._lines: list[Statement] = []

    @classmethod
    def after(cls, text: str, file: str = "") -> TaughtLines:
        """Return what writes lines at the end of a program. Raises `ProgramError`."""
        tree = read_program(text, file).tree
        return cls(_speed_at_end(tree), names_of(tree).variables)

    @property
    def text(self) -> str:
        """All lines so far."""
        return unparse(Tree(tuple(self._lines)))

    def go(self, point: str, *, line: bool = False, speed: float = 1.0) -> None:
        """Go to a point, by a joint motion or along a straight line."""
        self._set_speed(speed)
        self._lines.append(Do("move_line" if line else "move", (self._place(point),)))

    def fingers(self, grip: str | float, *, speed: float = 1.0) -> None:
        """Move the fingers to an opening in mm, or as one of `GRIPS` says."""
        if grip != "grasp":
            self._set_speed(speed)
        if isinstance(grip, str):
            if grip not in GRIPS:
                raise BadRequest(f"the fingers {', '.join(GRIPS)}, or go to mm, not {grip!r}")
            self._lines.append(Do("grasp" if grip == "grasp" else f"{grip}_now"))
        else:
            self._lines.append(Do("open_now", (Number(grip),)) if grip else Do("close_now"))

    def delay(self, time_s: float) -> None:
        """Let time pass."""
        self._lines.append(Do("delay", (Number(time_s),)))

    def _set_speed(self, speed: float) -> None:
        if speed != self._speed:
            self._lines.append(Do("speed", (Number(speed, percent=True),)))
            self._speed = speed

    def _place(self, point: str) -> Expression:
        other = (RESERVED - FUNCTIONS.keys()) | self._own  # a function has brackets behind it
        plain = NAME.fullmatch(point) and point.lower() not in other
        return Name(point) if plain else Use("taught", (TextValue(point),))


def _speed_at_end(tree: Tree) -> float | None:
    """Return the speed after the last line; None if it depends on values or on the way there."""
    lines = [each for each in every(tree.body) if isinstance(each, Do) and each.word == "speed"]
    if not lines:
        return 1.0
    value = lines[-1].arguments[0]
    certain = isinstance(value, Number) and all(
        any(line is each for each in tree.body) for line in lines
    )
    return value.value if certain and isinstance(value, Number) else None
