"""What a conversation with a person and with drives is made of, one act at a time.

A talk is a generator: it yields an act and is sent what came of it. Nothing here touches a wire, a
terminal or a clock, so that a test answers as it likes.
"""

from __future__ import annotations

from collections.abc import Generator, Mapping
from dataclasses import dataclass
from enum import Enum, auto
from typing import Any, TypeAlias, TypeVar

from armdrive.interview.readers import Question, WrongAnswer, choice
from firmware_protocol.mks import Event, Request

T = TypeVar("T")

ANSWER_S = 0.12
"""An answer is waited for so long: a drive needs some ms, a busy computer more."""
LINGER_S = 0.03
"""A second drive of the same id answers within this time after the first."""


class About(Enum):
    """What a question is about, for whoever answers in the place of a person."""

    AGREEMENT = auto()
    CONNECT = auto()
    FREE = auto()
    MOUNTED = auto()
    SEEN = auto()
    WAY = auto()
    ROLL = auto()
    AMOUNT = auto()
    NUMBER = auto()


@dataclass(frozen=True, slots=True)
class Say:
    """Tell the person something."""

    text: str


@dataclass(frozen=True, slots=True)
class Ask:
    """Ask the person; `motor` is the index of the motor that it is about."""

    question: Question
    about: About = About.AGREEMENT
    motor: int = 0


@dataclass(frozen=True, slots=True)
class Put:
    """Put a request to a drive. Ends with the first answer to it, or `linger_s` after it."""

    node: int
    request: Request
    wait_s: float = ANSWER_S
    linger_s: float = 0.0


@dataclass(frozen=True, slots=True)
class Hear:
    """Send nothing for a time, and hear what comes."""

    seconds: float


@dataclass(frozen=True, slots=True)
class Mark:
    """Remember how the arm stands: something is going to move. For eyes that are no person's."""

    motor: int


@dataclass(frozen=True, slots=True)
class Stands:
    """A drive is known to stand: nothing has to be stopped any more."""

    node: int


@dataclass(frozen=True, slots=True)
class Keep:
    """Write down what is known so far."""

    notes: Mapping[str, Any]


Act: TypeAlias = Say | Ask | Put | Hear | Mark | Stands | Keep
Talk: TypeAlias = Generator[Act, Any, T]


def say(*lines: str) -> Talk[None]:
    """Tell the person some lines."""
    for line in lines:
        yield Say(line)


def put(node: int, request: Request, wait_s: float = ANSWER_S) -> Talk[tuple[Event, ...]]:
    """Put a request to a drive; return what was heard until it was answered, or for the time."""
    heard: tuple[Event, ...] = yield Put(node, request, wait_s)
    return heard


def ask(question: Question, about: About, motor: int = 0) -> Talk[Any]:
    """Ask the person; return the value of the answer."""
    answer = yield Ask(question, about, motor)
    return answer


def agreed(
    words: str, why: str, about: About = About.AGREEMENT, motor: int = 0, default: str | None = None
) -> Talk[bool]:
    """Ask a question whose answer is yes or no. What moves or writes has no default."""
    answer = yield from ask(Question("", words, why, _yes_or_no, default), about, motor)
    return bool(answer == _YES)


_YES, _NO = "yes", "no"


def _yes_or_no(line: str) -> str:
    if line.lower() in ("y", "n"):
        return _YES if line.lower() == "y" else _NO
    return str(choice((_YES, _NO))(line.lower()))


def whole_or_empty(low: int, high: int, unit: str) -> Any:
    """Return a reader of a whole number between bounds."""

    def read(line: str) -> int:
        word = line.removesuffix(unit).strip()
        if not word.isdecimal() or not low <= int(word) <= high:
            raise WrongAnswer(f"a whole number from {low} to {high} is needed, not {line!r}")
        return int(word)

    return read
