"""Asking at a terminal, line by line: a question, its default, and what `?` and `back` do.

The same from a pipe, where each line of the input is an answer and is printed as one.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from armdrive.cli.presenter import forget_typed, say, typed
from armdrive.dialog import Question, WrongAnswer, yes_or_no
from armdrive.errors import BadRequest, OperatorNeeded

HELP, BACK = "?", "back"


class Back(Exception):
    """The user wants to answer the previous question again."""


def ask(question: Question, take: Callable[[str], Any]) -> Any:
    """Ask until `take` accepts a line; return what it returns. Raises `Back`."""
    _show(question)
    while True:
        line = _line(question)
        if line == HELP:
            say(question.why)
            continue
        if line == BACK:
            raise Back
        try:
            return take(line)
        except WrongAnswer as wrong:
            say(f"  {wrong}")


def ask_value(question: Question, *, resumed_by: str = "") -> Any:
    """Ask a single question, and return its value.

    `resumed_by` is the command that continues from here, if there is one. Raises `BadRequest` if
    the input has ended, or `OperatorNeeded` with that command.
    """
    while True:
        try:
            return ask(question, question.answered)
        except Back:
            say("  you cannot go back from here")
        except BadRequest as ended:
            if not resumed_by:
                raise
            raise OperatorNeeded(
                f"the input ended at the question {question.words!r}: finished steps are kept, "
                f"and `{resumed_by}` continues there"
            ) from ended


def ask_yes_no(words: str, why: str, default: str = "no") -> bool:
    """Ask a question whose answer is yes or no."""
    return bool(ask_value(Question(words, why, yes_or_no, default)))


@dataclass(frozen=True, slots=True)
class TerminalPerson:
    """The person at the terminal, in a dialog."""

    resumed_by: str = ""

    def tell(self, text: str) -> None:
        """Print a line."""
        say(text)

    def look(self, *, moved: bool) -> None:
        """Do nothing: the user looks at the arm anyway."""

    def answer(self, question: Question) -> Any:
        """Ask until the answer can be used. Raises as `ask_value` does."""
        forget_typed()  # it may switch motors on or turn them
        return ask_value(question, resumed_by=self.resumed_by)


def _show(question: Question) -> None:
    say("")
    for number, (word, meaning) in enumerate(question.choices, 1):
        say(f"  {number}  {word}" + (f": {meaning}" if meaning else ""))


def _line(question: Question) -> str:
    default = f" [{question.default}]" if question.default is not None else ""
    line = typed(f"{question.words}{default} ")
    if line is None:
        raise BadRequest(f"the input ended at the question {question.words!r}: nothing is written")
    if not sys.stdin.isatty():
        say(line)
    return line
