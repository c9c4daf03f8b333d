"""The stages that lead to a new arm file: ports, what is behind one, questions, the file."""

from __future__ import annotations

from typing import TYPE_CHECKING

from armdrive.errors import ArmError, BadRequest
from armdrive.setup.finding import Candidate, Found, candidates, looked_at, probe
from armdrive.setup.interview import Describing
from kinematics import KinematicsError
from tui.setup_files import NewFile
from tui.setup_stage import WARNING, Go, Stage, listed

if TYPE_CHECKING:
    from tui.desk import Desk

CHOICES = 8
"""So many choices are shown at once."""


class Ports(Stage):
    """The ports and CAN interfaces, as they are known while closed; one of them is asked."""

    def __init__(self, desk: Desk, go: Go, before: Stage) -> None:
        super().__init__(desk, go, before)
        self.candidates: tuple[Candidate, ...] = ()
        self.typed = ""
        self._looking = True
        self.found: Found | None = None
        self._asked = ""
        desk.call(self._look, None)  # who holds a port is not found in a moment

    def _look(self) -> None:
        try:
            found = candidates()
        finally:
            self._looking = False
        self.marked = len(found) if self.typed else 0
        self.candidates = found

    def rows(self) -> int:
        """Return the number of ports, and one to be typed."""
        return len(self.candidates) + 1

    @property
    def typing(self) -> bool:  # type: ignore[override]
        """Whether the line for another port is marked."""
        return self.marked == len(self.candidates)

    @property
    def port(self) -> str:
        """The port that is marked or typed."""
        return self.typed if self.typing else self.candidates[self.marked].port

    def text(self) -> str:
        """List the ports; of the marked one, all that is known, and what was found behind it."""
        rows = [each.port for each in self.candidates]
        looking = "looking for ports ..." if self._looking else "Listing has opened none."
        lines = [f"Which port leads to the arm? {looking}", ""]
        lines += listed([*rows, f"another: {self.typed}_"], self.marked)
        if not self.typing:
            lines += ["", *self.candidates[self.marked].lines]
        lines += ["", *self._next()]
        return "\n".join(lines)

    def _next(self) -> list[str]:
        keys = self.desk.keys
        on = f"{keys.label('setup-on')}: describe the arm without opening it"
        if self._asked:
            return [f"asking {self._asked} ... (some seconds; nothing moves)"]
        if self.found is not None and self.found.port == self.port:
            told = list(self.found.lines)
            if self.found.dialect:
                return [*told, "", f"{keys.label('setup-enter')}: describe this arm"]
            return [*told, "", self.again("asks again"), on]
        return [WARNING, self.again("opens it and asks who is there"), on]

    def type(self, character: str) -> None:
        """Type a port's name."""
        self.forget()
        self.typed += character

    def erase(self) -> None:
        """Take the last character away."""
        self.forget()
        self.typed = self.typed[:-1]

    def enter(self) -> None:
        """Go on with a port that was recognised, or take a press towards asking."""
        if self.found is not None and self.found.port == self.port and self.found.dialect:
            self.go(Asking(self.desk, self.go, self, self.found.answers))
        elif self._asked:
            raise BadRequest(f"{self._asked} is being asked: wait")
        elif not self.port:
            raise BadRequest("type a port first: /dev/ttyUSB0, COM3, socket://HOST:PORT, can:...")
        else:
            self.twice.press()

    def on(self) -> None:
        """Describe the arm on this port, or on none yet."""
        known = {"connection.port": self.port} if self.port else {}
        self.go(Asking(self.desk, self.go, self, known))

    def due(self) -> None:
        """Ask the port, in a thread."""
        if self.twice.due():
            self._asked, port = self.port, self.port
            self.desk.call(lambda: self._ask(port), None)

    def _ask(self, port: str) -> None:
        try:
            known = looked_at(port)
            self.found = probe(port) if known.openable else Found(port, known.lines)
        finally:
            self._asked = ""


class Asking(Stage):
    """The questions of `armdrive config new`, one at a time."""

    typing = True

    def __init__(self, desk: Desk, go: Go, before: Stage, found: dict[str, str]) -> None:
        super().__init__(desk, go, before)
        self.describing = Describing(found)

    def text(self) -> str:
        """Put the question, with why it is asked, its choices, and what enter would answer."""
        question, keys = self.describing.question, self.desk.keys
        if question is None:
            return ""
        lines = [question.words, "", *self._choices(), question.why, ""]
        lines += [f"answer: {self.describing.typed}_"] if self.describing.typed else []
        offered = self.describing.line or "(type an answer)"
        lines += [
            f"{keys.label('setup-enter')}: {offered}",
            f"{keys.label('setup-back')}: the question before. Numbers are parted by commas.",
        ]
        return "\n".join(lines)

    def _choices(self) -> list[str]:
        question, marked = self.describing.question, self.describing.marked
        if question is None or not question.choices:
            return []
        width = max(len(word) for word, _ in question.choices)
        rows = [f"{word:<{width}}  {meaning}".rstrip() for word, meaning in question.choices]
        first = max(0, min(marked - CHOICES // 2, len(rows) - CHOICES))
        at = -1 if self.describing.typed else marked - first
        return [*listed(rows[first : first + CHOICES], at), ""]

    def mark(self, by: int) -> bool:
        """Mark another choice."""
        self.describing.mark(by)
        return True

    def type(self, character: str) -> None:
        """Type a character of the answer."""
        self.describing.type(character)

    def erase(self) -> None:
        """Take the last character away."""
        self.describing.erase()

    def enter(self) -> None:
        """Answer; after the last question show the file."""
        self.describing.enter()
        if self.describing.question is None:
            self._show()

    def _show(self) -> None:
        try:
            files = self.describing.files()
        except (ArmError, KinematicsError):
            self.describing.back()
            raise
        self.go(NewFile(self.desk, self.go, self, files, self.describing.name))

    def back(self) -> None:
        """Go back to the question before, or to where it began."""
        if not self.describing.back():
            super().back()
