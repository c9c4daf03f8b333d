"""Asking at a terminal, line by line: a question, its default, and what `?` and `back` do.

The same from a pipe, where each line of the input is an answer and is printed as one.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

from armdrive.cli.presenter import put, say
from armdrive.dialog.conversation import Question, WrongAnswer, yes_or_no
from armdrive.errors import BadRequest

HELP, BACK = "?", "back"


class Back(Exception):
    """Somebody wants to answer the question before once more."""


def ask(question: Question, take: Callable[[str], Any]) -> Any:
    """Ask until `take` accepts a line; return what it returns. Raises `Back`."""
    _show(question)
    while True:
        line = _line(question).strip()
        if line == HELP:
            say(question.why)
            continue
        if line == BACK:
            raise Back
        try:
            return take(line)
        except WrongAnswer as wrong:
            say(f"  {wrong}")


def ask_value(question: Question) -> Any:
    """Ask a question that stands by itself, and return its value."""

    def take(line: str) -> Any:
        if not line and question.default is None:
            raise WrongAnswer("an answer is needed")
        return question.read(line or question.default or "")

    while True:
        try:
            return ask(question, take)
        except Back:
            say("  there is no way back from here")


def agree(words: str, why: str, default: str = "no") -> bool:
    """Ask a question whose answer is yes or no."""
    return bool(ask_value(Question("", words, why, yes_or_no, default)))


def _show(question: Question) -> None:
    say("")
    for number, (word, meaning) in enumerate(question.choices, 1):
        say(f"  {number}  {word}" + (f": {meaning}" if meaning else ""))


def _line(question: Question) -> str:
    default = f" [{question.default}]" if question.default is not None else ""
    put(f"{question.words}{default} ")
    line = sys.stdin.readline()
    if not line:
        say("")
        raise BadRequest(
            f"the answers ended at the question {question.words!r}: nothing is written"
        )
    if not sys.stdin.isatty():
        say(line.strip())
    return line
