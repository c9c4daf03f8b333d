"""An interview under way: the next question, an answer, a step back. It prints and reads nothing.

`question` is the next one or None at the end; `answer` takes a line for it, and raises
`WrongAnswer` without having changed anything.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from armdrive.interview import rows_arm, rows_device, rows_use, rows_wire
from armdrive.interview.draft import Draft, Surroundings
from armdrive.interview.readers import Question, WrongAnswer

ROWS = (*rows_wire.ROWS, *rows_arm.ROWS, *rows_use.ROWS, *rows_device.ROWS)


class Interview:
    """Questions of the table, in its order, as earlier answers open them."""

    def __init__(self, around: Surroundings) -> None:
        self._around = around
        self._answers: dict[str, Any] = {}

    @property
    def draft(self) -> Draft:
        """The answers so far."""
        return Draft(dict(self._answers), self._around)

    @property
    def question(self) -> Question | None:
        """The next question, None when all have been answered."""
        return next((each for each in self._all() if each.key not in self._answers), None)

    def answer(self, line: str) -> None:
        """Take a line as the answer to the next question; an empty one is its default."""
        question = self.question
        if question is None:
            raise WrongAnswer("there is nothing left to answer")
        typed = line.strip()
        if not typed:
            if question.default is None:
                raise WrongAnswer("this question has no default: an answer is needed")
            typed = question.default
        self._answers[question.key] = question.read(typed)

    def back(self) -> str | None:
        """Take the last answer back and return its key; None where there is none."""
        return self._answers.popitem()[0] if self._answers else None

    def settle(self, found: Mapping[str, Any]) -> Draft:
        """Return the draft with answers that were found rather than asked for."""
        return Draft({**self._answers, **found}, self._around)

    def _all(self) -> Iterator[Question]:
        for row in ROWS:
            yield from row.questions(self.draft)
            if any(question.key not in self._answers for question in row.questions(self.draft)):
                return  # what follows may depend on what is open
