"""Dialogs with a person: what is asked of the operator at an arm, and the questions of a set-up.

Nothing here touches a wire, a terminal or a clock. The person may be a user at a terminal, a
simulated one, or a test.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from enum import Enum, auto
from typing import Any, Protocol, Unpack

from armdrive.errors import BadRequest
from armdrive.moves import BASE_FRAME, Angles, Jog, JointJog, TipJog
from armdrive.status import Status
from armdrive.text import numbers as typed
from kinematics.errors import suggestion
from kinematics.geometry import ArmGeometry
from kinematics.presets import ArmModel
from kinematics.spaces import Joints, Pose
from kinematics.text import counted

# What `home` and `verify` ask of an operator, and the arm as an operator sees it.


class JogResult(Protocol):
    """The result of a jog."""

    @property
    def note(self) -> str:
        """What was clipped or left out; empty if nothing was."""


class HeldJogs(Protocol):
    """Jogs that nobody waits for."""

    def hold(self, jog: Jog, *, speed: float, for_s: float) -> None:
        """Jog for a time, unless called again before its end; do not wait."""

    def nudge(self, jog: Jog, *, speed: float) -> None:
        """Jog by one increment; do not wait."""

    def release(self) -> None:
        """End a held jog."""


class JoggedArm(Protocol):
    """An arm that can be watched, jogged and stopped, and nothing else."""

    @property
    def status(self) -> Status:
        """The arm's present status."""

    @property
    def model(self) -> ArmModel:
        """Its geometry and its limits."""

    def jog_j(
        self,
        amounts: Angles | None = None,
        /,
        *,
        speed: float = 0.25,
        duration_s: float | None = None,
        **axes: Unpack[JointJog],
    ) -> JogResult:
        """Jog joints by increments, or for a time."""

    def jog_l(
        self,
        amounts: Angles | None = None,
        /,
        *,
        speed: float = 0.25,
        duration_s: float | None = None,
        frame: str = BASE_FRAME,
        **axes: Unpack[TipJog],
    ) -> JogResult:
        """Jog the tip by increments, or for a time."""

    @property
    def jogging(self) -> HeldJogs:
        """Jogs that nobody waits for."""

    def move_motors(self, *steps: int, speed: float = 0.25) -> object:
        """Move each motor by whole steps from where it is."""

    def sleep(self, time_s: float) -> None:
        """Let time pass on the arm's own clock."""

    def stop(self) -> None:
        """Stop, and wait until the arm stands."""


@dataclass(frozen=True, slots=True, eq=False)
class PostureRequest:
    """Asks an operator to bring the arm to a posture and to say whether it is there.

    The operator may jog `arm`, and do nothing else with it.
    """

    arm: JoggedArm
    pose: Pose
    joints: Joints
    opening_mm: float

    def __str__(self) -> str:
        return (
            f"Bring the arm to its reference posture: finger tips touching the table "
            f"{self.pose.x_mm:.0f} mm in front of the base axis, hand straight down, wrist "
            f"turnbuckles lined up, fingers just touching each other. ({self.pose})"
        )


@dataclass(frozen=True, slots=True, eq=False)
class MarkRequest(PostureRequest):
    """Asks for the same posture, reached by small jogs, as exactly as possible."""

    def __str__(self) -> str:
        return (
            f"Bring the finger tips onto the reference mark, {self.pose.x_mm:.0f} mm in front of "
            f"the base axis, in small jogs: tips just touching the table, hand straight down, "
            f"wrist turnbuckles lined up, fingers just touching each other. ({self.pose})"
        )


# Returns True when the arm stands in the requested posture.
Operator = Callable[[PostureRequest], bool]


# A dialog about a device: questions, lines to tell, and findings.
#
# A reader turns a typed line into a value, or raises `WrongAnswer`.

Reader = Callable[[str], Any]


@dataclass(frozen=True, slots=True)
class ArmMotion:
    """A motion of an arm: its joints and the opening of its fingers before and after."""

    arm: ArmGeometry
    before: Joints
    after: Joints
    opened_from_mm: float
    opened_to_mm: float

    @property
    def opened_mm(self) -> float:
        """How far the fingers have opened."""
        return self.opened_to_mm - self.opened_from_mm

    def turned_deg(self, joint: str) -> float:
        """Return how far a joint has turned."""
        at = self.after.names.index(joint)
        return math.degrees(self.after[at] - self.before[at])


# Returns the answer that a simulated person sees in a motion of the arm.
ByEye = Callable[[ArmMotion], str]


class About(Enum):
    """The subject of a question: the simulated person does what it asks for, before answering."""

    ANSWER = auto()
    AGREEMENT = auto()
    CONNECT = auto()
    FREE = auto()
    PRESS = auto()
    RELEASE = auto()


@dataclass(frozen=True, slots=True)
class Question:
    """One question; `default` is the answer that an empty line gives.

    An interview knows its questions by their keys. The rest tells a simulated person what to do:
    `motor` is the index of the motor that is to be plugged in or pressed.
    """

    words: str
    why: str
    read: Reader
    default: str | None = None
    choices: tuple[tuple[str, str], ...] = ()
    key: str = ""
    about: About = About.ANSWER
    motor: int = 0
    by_eye: ByEye | None = None

    def answered(self, line: str) -> Any:
        """Return the value of a line that was typed. Raises `WrongAnswer`."""
        given = line.strip() or self.default
        if given is None:
            raise WrongAnswer("this question has no default: an answer is needed")
        return self.read(given)


YES, NO = ("yes", "y", "true"), ("no", "n", "false")


class WrongAnswer(BadRequest):
    """An answer that cannot be used; the message says what is wrong with it."""

    code = "E102"


def text(line: str) -> str:
    """Return the line unchanged."""
    return line


def yes_or_no(line: str) -> bool:
    """Return whether the answer is yes."""
    word = line.lower()
    if word not in (*YES, *NO):
        raise WrongAnswer(f"answer yes or no, not {line!r}")
    return word in YES


def choice(words: Sequence[str]) -> Reader:
    """Return a reader for one of these words, or its number in the list."""

    def read(line: str) -> str:
        if line in words:
            return line
        if (listed := numbered(line, words)) is not None:
            return listed
        hint = suggestion(line, words)
        raise WrongAnswer(f"answer one of {', '.join(words)}, not {line!r}{hint}")

    return read


def numbered(line: str, words: Sequence[str]) -> str | None:
    """Return the word whose number in the list is typed, counted from 1; None for other lines."""
    return {str(place): word for place, word in enumerate(words, 1)}.get(line)


def number(low: float, high: float, unit: str = "") -> Reader:
    """Return a reader for a number between these bounds, both included."""

    def read(line: str) -> float:
        value = plain_number(line.removesuffix(unit).strip() if unit else line)
        if not low <= value <= high:
            raise WrongAnswer(f"a number from {low:g} to {high:g} is needed, not {value:g}")
        return value

    return read


def whole(low: int, high: int, unit: str = "") -> Reader:
    """Return a reader for a whole number between these bounds, both included."""

    def read(line: str) -> int:
        value = number(low, high, unit)(line)
        if value != int(value):
            raise WrongAnswer(f"a whole number is needed, not {line}")
        return int(value)

    return read


def numbers(names: Sequence[str]) -> Reader:
    """Return a reader for one number per name, in their order."""

    def read(line: str) -> tuple[float, ...]:
        words = line.replace(",", " ").split()
        if len(words) != len(names):
            raise WrongAnswer(
                f"{counted(len(names), 'number is', 'numbers are')} needed "
                f"({', '.join(names)}), not {len(words)}"
            )
        return tuple(map(plain_number, words))

    return read


def bounds(line: str) -> tuple[float, float]:
    """Return two numbers, the first below the second."""
    low, high = numbers(("lowest", "highest"))(line)
    if low >= high:
        raise WrongAnswer(f"the first number must be below the second, not {low:g} and {high:g}")
    return low, high


def plain_number(line: str) -> float:
    """Return a finite number."""
    try:
        return typed.number(line)
    except BadRequest as error:
        raise WrongAnswer(str(error)) from None


class DialogPerson(Protocol):
    """The person in a dialog: reads lines, answers questions, looks at the arm."""

    def tell(self, text: str) -> None:
        """Tell the person a line."""

    def answer(self, question: Question) -> Any:
        """Ask the person; return the answer as its reader gives it."""

    def look(self, *, moved: bool) -> None:
        """Ask the person to look at the arm before a motor turns, and again afterwards."""


@dataclass(frozen=True, slots=True)
class Dialog:
    """Tells and asks a person about a device."""

    person: DialogPerson

    def say(self, *lines: str) -> None:
        """Tell the person some lines."""
        for line in lines:
            self.person.tell(line)

    def ask(self, question: Question) -> Any:
        """Ask the person; return the value of the answer."""
        return self.person.answer(question)

    def agreed(
        self,
        words: str,
        why: str,
        about: About = About.AGREEMENT,
        motor: int = 0,
        default: str | None = None,
    ) -> bool:
        """Ask a question whose answer is yes or no. Give no default if a yes moves or writes."""
        question = Question(words, why, yes_or_no, default, about=about, motor=motor)
        return bool(self.ask(question))


# A finding: its severity, what was found, and the remedy.


class Grade(Enum):
    """The severity of a finding."""

    OK = "ok"
    NOTE = "note"
    PROBLEM = "problem"


@dataclass(frozen=True, slots=True)
class Finding:
    """A sentence that says what was found, and its remedy: a line to type, or a sentence."""

    grade: Grade
    what: str
    fix: str = ""

    def view(self) -> dict[str, str]:
        """Return it as plain data."""
        return {"grade": self.grade.value, "what": self.what, "fix": self.fix}


def ok(what: str) -> Finding:
    """Return a finding that everything is right."""
    return Finding(Grade.OK, what)


def note(what: str, fix: str = "") -> Finding:
    """Return a finding that is good to know."""
    return Finding(Grade.NOTE, what, fix)


def problem(what: str, fix: str) -> Finding:
    """Return a finding that needs a remedy."""
    return Finding(Grade.PROBLEM, what, fix)


def parted(error: str) -> tuple[str, str]:
    """Split an error into what is wrong and its remedy, at the first colon outside brackets."""
    depth = 0
    for at, each in enumerate(error):
        depth += (each == "(") - (each == ")")
        if depth == 0 and error.startswith(": ", at):
            return error[:at], error[at + 2 :]
    return error, ""


def any_problem(findings: Iterable[Finding]) -> bool:
    """Return whether a finding needs a remedy."""
    return any(each.grade is Grade.PROBLEM for each in findings)
