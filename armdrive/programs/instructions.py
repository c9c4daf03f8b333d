"""What a program is compiled to: a flat list of small instructions over a stack of values."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from armdrive.programs.acts import Mark
from armdrive.programs.values import Value


class Op(Enum):
    """What an instruction does; in brackets what it finds in `name`, `value`, `target`, `count`."""

    PUSH = "push a constant (value)"
    LOAD = "push a variable (name)"
    LOAD_OWN = "push a parameter (name)"
    LOAD_POINT = "push a point of the arm's own book (name)"
    LOAD_SHIFTED = "push a variable, or the book's point while it has not been shifted (name)"
    STORE = "pop into a variable (name)"
    STORE_OWN = "pop into a parameter (name)"
    DROP = "pop"
    NEGATE = "the other sign"
    NOT = "the other truth"
    BINARY = "two values and what stands between them (name)"
    USE = "a function (name) of so many values (count)"
    PART = "a part of a place (name)"
    JOINTS = "a place of so many angles (count), their joints between commas (name)"
    JUMP = "go on elsewhere (target)"
    JUMP_UNLESS = "pop, and go on elsewhere if it is off (target)"
    JUMP_IF = "pop, and go on elsewhere if it is on (target)"
    KEEP_OFF = "go on elsewhere if it is off, else pop (target)"
    KEEP_ON = "go on elsewhere if it is on, else pop (target)"
    ROUNDS = "pop how many rounds a loop (name) has"
    FOREVER = "a loop (name) has no end"
    COUNT = "push the round's number of a loop without an end (name)"
    ROUND = "push the round's number (name), or go on behind the loop (target)"
    CALL = "call a subprogram (target) with so many values (count)"
    RETURN = "leave a subprogram; in the program itself, end it"
    END = "end the program"
    FAIL = "end the program with an error of so many values (count), or of a text (value)"
    SPEED = "pop the speed"
    OPENING = "the fingers' opening with the next move: pop it (count 1), or all the way"
    FINGERS = "the act of that opening, where the next move (name) cannot have it along"
    LOOK = "the act of looking: push the place"
    INPUT = "the act of reading an input: pop its number, push on or off"
    ACT = "the act of a word (name) of so many values (count); pushes its answer if (value)"


@dataclass(frozen=True, slots=True)
class Instruction:
    """One instruction, and where in the program it comes from."""

    op: Op
    mark: Mark
    name: str = ""
    value: Value | None = None
    target: int = 0
    count: int = 0
    about: str = ""
    """What the program calls the place that an act goes to."""
