"""The person at the terminal to whom a commissioning talk is held."""

from __future__ import annotations

from typing import Any

from armdrive.cli.presenter import say
from armdrive.cli.questions import Back, ask
from armdrive.dialog import Ask, WrongAnswer
from armdrive.errors import BadRequest, OperatorNeeded


class TerminalPerson:
    """Reads answers line by line; `?` explains a question."""

    def __init__(self, arm: str) -> None:
        self._arm = arm

    def tell(self, text: str) -> None:
        """Print a line."""
        say(text)

    def watch(self, motor: int) -> None:
        """Do nothing: people have eyes."""

    def answer(self, asked: Ask) -> Any:
        """Ask until the answer can be used. Raises `OperatorNeeded` where answers have ended."""
        question = asked.question

        def take(line: str) -> Any:
            if not line and question.default is None:
                raise WrongAnswer("an answer is needed; ? explains")
            return question.read(line or question.default or "")

        while True:
            try:
                return ask(question, take)
            except Back:
                say("  there is no way back here; Ctrl-C leaves, and the same command goes on")
            except BadRequest as ended:
                raise OperatorNeeded(
                    f"the answers ended at {question.words!r}: what was done stays done, and "
                    f"`armdrive can setup {self._arm}` goes on there"
                ) from ended
