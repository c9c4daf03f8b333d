"""Reading one typed answer: each reader takes a line and returns a value, or says what is wrong.

A reader is a plain function from text to a value; those with bounds or choices are made by one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from armdrive.errors import BadRequest
from kinematics.errors import suggestion

Reader = Callable[[str], Any]


@dataclass(frozen=True, slots=True)
class Question:
    """One question, ready to be asked. `default` is what an empty line stands for."""

    key: str
    words: str
    why: str
    read: Reader
    default: str | None
    choices: tuple[tuple[str, str], ...] = ()


YES, NO = ("yes", "y", "true"), ("no", "n", "false")


class WrongAnswer(BadRequest):
    """An answer that cannot be used; the message says what is wrong with it."""


def text(line: str) -> str:
    """Return the line as it is."""
    return line


def yes_or_no(line: str) -> bool:
    """Return whether the answer is yes."""
    word = line.lower()
    if word not in (*YES, *NO):
        raise WrongAnswer(f"answer yes or no, not {line!r}")
    return word in YES


def choice(words: Sequence[str]) -> Reader:
    """Return a reader of one of these words, or of its number in the list."""

    def read(line: str) -> str:
        if line in words:
            return line
        if line.isdecimal() and 1 <= int(line) <= len(words):
            return words[int(line) - 1]
        hint = suggestion(line, words)
        raise WrongAnswer(f"answer one of {', '.join(words)}, not {line!r}{hint}")

    return read


def several(words: Sequence[str]) -> Reader:
    """Return a reader of any of these words, separated by commas; "none" is none of them."""

    def read(line: str) -> tuple[str, ...]:
        parts = [part.strip() for part in line.split(",") if part.strip()]
        if parts == ["none"]:
            return ()
        return tuple(choice(words)(part) for part in parts)

    return read


def number(low: float, high: float, unit: str = "") -> Reader:
    """Return a reader of a number between these bounds, both included."""

    def read(line: str) -> float:
        value = plain_number(line.removesuffix(unit).strip() if unit else line)
        if not low <= value <= high:
            raise WrongAnswer(f"a number from {low:g} to {high:g} is needed, not {value:g}")
        return value

    return read


def whole(low: int, high: int) -> Reader:
    """Return a reader of a whole number between these bounds, both included."""

    def read(line: str) -> int:
        value = number(low, high)(line)
        if value != int(value):
            raise WrongAnswer(f"a whole number is needed, not {line}")
        return int(value)

    return read


def numbers(names: Sequence[str]) -> Reader:
    """Return a reader of as many numbers as there are names, in their order."""

    def read(line: str) -> tuple[float, ...]:
        words = line.replace(",", " ").split()
        if len(words) != len(names):
            raise WrongAnswer(
                f"{len(names)} numbers are needed ({', '.join(names)}), not {len(words)}"
            )
        return tuple(map(plain_number, words))

    return read


def bounds(line: str) -> tuple[float, float]:
    """Return two numbers, the first below the second."""
    low, high = numbers(("lowest", "highest"))(line)
    if low >= high:
        raise WrongAnswer(f"the first number must be below the second, not {low:g} and {high:g}")
    return low, high


def groups(motors: int) -> Reader:
    """Return a reader of motor numbers: "3; 2; 1 4 5" homes 3, then 2, then the others."""

    def read(line: str) -> tuple[tuple[int, ...], ...]:
        if line in ("", "own"):
            return ()
        parts = [part.replace(",", " ").split() for part in line.split(";")]
        listed = tuple(tuple(whole(1, motors)(word) for word in part) for part in parts if part)
        every = [motor for part in listed for motor in part]
        if len(set(every)) != len(every):
            raise WrongAnswer("a motor is listed twice")
        return listed

    return read


def plain_number(line: str) -> float:
    """Return a finite number."""
    try:
        value = float(line)
    except ValueError:
        raise WrongAnswer(f"a number is needed, not {line!r}") from None
    if not math.isfinite(value):
        raise WrongAnswer(f"a finite number is needed, not {line!r}")
    return value
