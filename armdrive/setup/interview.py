"""The interview that makes an arm file: the next question, an answer, a step back.

It opens no port and writes no file. `Describing` adds what a screen needs.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from armdrive.dialog import Question, WrongAnswer, text
from armdrive.errors import BadRequest
from armdrive.registry.arm_files import arm_path
from armdrive.setup.draft import Draft, Surroundings
from armdrive.setup.filing import ArmFiles, checked, files_of
from armdrive.setup.questions import ROWS
from armdrive.setup.templates import TEMPLATES
from armdrive.text.reading import is_there
from armdrive.transports import ports as system


class Interview:
    """Asks the questions of the table; earlier answers decide which ones come.

    A question whose answer is given beforehand is skipped, also on the way back. A given answer
    that is wrong raises `BadRequest`; unless `strict`, its question is asked after all.
    """

    def __init__(self, around: Surroundings, *, strict: bool = True) -> None:
        self._around = around
        self._given = dict(around.given)
        self._strict = strict
        self._answers: dict[str, Any] = {}
        self._take_given()

    @property
    def draft(self) -> Draft:
        """The answers so far."""
        return Draft(dict(self._answers), self._around)

    @property
    def question(self) -> Question | None:
        """The next question; None when all are answered."""
        # the rows are gone through lazily: those behind the open question depend on its answer
        draft = self.draft
        asked = (each for row in ROWS for each in row.questions(draft))
        return next((each for each in asked if each.key not in self._answers), None)

    def answer(self, line: str) -> None:
        """Take a line as the answer; an empty line is the default. Raises `WrongAnswer`."""
        question = self.question
        if question is None:
            raise WrongAnswer("there is nothing left to answer")
        self._take(question, line)
        self._take_given()

    def _take(self, question: Question, line: str) -> None:
        self._answers[question.key] = question.answered(line)

    def _take_given(self) -> None:
        while (question := self.question) is not None and question.key in self._given:
            try:
                self._take(question, self._given[question.key])
            except WrongAnswer as wrong:
                if self._strict:
                    raise BadRequest(f"the answer {question.key}: {wrong}") from None
                # a finding of the survey that does not fit is asked for like any other
                del self._given[question.key]

    def back(self) -> str | None:
        """Take back the last answer that was not given beforehand; return its key, or None."""
        while self._answers:
            key, _ = self._answers.popitem()
            if key not in self._given:
                return key
        self._take_given()
        return None


# The template of any arm and any dialect.
ANY = "own"


class Describing:
    """An interview on a screen: the open question, the text typed for it, the marked choice."""

    def __init__(self, found: Mapping[str, str]) -> None:
        self._dialect = found.get("dialect", "")
        self._interview = Interview(surroundings({**found}), strict=False)
        self.typed = ""
        self.marked = 0
        self._mark_default()

    @property
    def question(self) -> Question | None:
        """The open question; None when all are answered."""
        return self._interview.question

    @property
    def name(self) -> str:
        """What the arm is called."""
        return self._interview.draft.name

    def mark(self, by: int) -> None:
        """Mark another of the choices."""
        question = self.question
        if question is not None and question.choices:
            self.typed = ""
            self.marked = (self.marked + by) % len(question.choices)

    @property
    def is_free_text(self) -> bool:
        """Whether the open question takes any text. Its spaces are typed as `_`: a space stops."""
        return self.question is not None and self.question.read is text

    @property
    def line(self) -> str:
        """The answer that `enter` would give: the typed text, the marked choice, or the default."""
        question = self.question
        if question is None or self.typed:
            return self.typed.replace("_", " ") if self.is_free_text else self.typed
        if question.choices:
            return question.choices[self.marked][0]
        return question.default or ""

    def enter(self) -> None:
        """Answer the question. Raises `WrongAnswer` without having changed anything."""
        question = self.question
        line = self.line
        if question is not None and question.key == "name" and is_there(arm_path(line)):
            raise WrongAnswer(
                f"an arm file named {line} exists and is not overwritten: choose another name"
            )
        self._interview.answer(line)
        self._mark_default()

    def back(self) -> bool:
        """Go back to the previous question; return whether there was one."""
        was_asked = self._interview.back() is not None
        self._mark_default()
        return was_asked

    def files(self) -> ArmFiles:
        """Return the texts that the answers make, once read back. Raises `ArmFileError`."""
        files = files_of(self._interview.draft)
        checked(files, self.name)
        return files

    def _mark_default(self) -> None:
        self.typed, self.marked = "", 0
        question = self.question
        if question is None:
            return
        words = [word for word, _ in question.choices]
        if question.key == "template":
            dialect = self._dialect
            fits = [word for word in words if TEMPLATES[word].dialect == dialect]
            self.marked = words.index(fits[0] if fits else ANY if dialect else words[0])
        elif question.default in words:
            self.marked = words.index(question.default)
        elif words and question.default is not None:
            self.typed = question.default


def surroundings(given: dict[str, str]) -> Surroundings:
    """Return what an interview knows of this computer. Opens nothing."""
    found = system.list_ports()
    ports = tuple(each.stable_name or each.device for each in found)
    buses = tuple(each.port for each in system.list_can_ports(found))
    return Surroundings(ports, given, buses)
