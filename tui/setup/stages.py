"""The stages that lead to an arm file: ports, what is behind one, questions, what is written.

Each stage is a list, a question, or a text; the screen shows one of them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from armdrive.errors import BadRequest
from armdrive.errors.printable import command_line
from armdrive.registry.arm_files import arm_path
from armdrive.render.scene import Moment
from armdrive.setup.bus_survey import probe
from armdrive.setup.filing import ArmFiles, FileProposal, write
from armdrive.setup.interview import Describing
from armdrive.setup.ports import ClosedPort, closed_ports, look_at
from armdrive.setup.survey import OPENING_RISK, Report
from armdrive.storage.files import arm_files, require_writable
from tui.desk import Desk
from tui.keys.table import STOP
from tui.widgets import TypedText

RISK = OPENING_RISK.format(port="it")

FOR_MOTORS = "that is for checking motors: choose that step first"

# The rows that say what was seen of a motor.
ANSWERS = ("setup-yes", "setup-reversed", "setup-nothing", "setup-another", "setup-double",
           "setup-half")  # fmt: skip

SKIP = "setup-on"

# Shows another stage.
Go = Callable[["SetupStage"], None]


@dataclass(frozen=True, slots=True)
class StageText:
    """What a stage says: a text, a list of which one row may be marked, and a text below it."""

    head: str
    rows: tuple[str, ...] = ()
    marked: int | None = None
    tail: str = ""


class SetupStage:
    """One stage. It knows the desk and how to go on to another one, and nothing of the screen."""

    def __init__(self, desk: Desk, go: Go, before: SetupStage | None = None) -> None:
        self.desk = desk
        self.go = go
        self.before = before
        self.marked = 0

    @property
    def typing(self) -> TypedText | None:
        """The line that is typed into, if there is one."""
        return None

    @property
    def idle(self) -> tuple[str, ...]:
        """Rows of the table of keys that do nothing at this stage."""
        return ("setup-turn", *ANSWERS, SKIP)

    def text(self) -> StageText:
        """Say what the stage is about, what is marked, and what comes next."""
        raise NotImplementedError

    def moment(self) -> Moment | None:
        """Return the posture to be drawn, if there is one."""
        return None

    def rows(self) -> int:
        """Return how many lines there are to mark."""
        return 0

    def mark(self, by: int) -> bool:
        """Mark another line; tell whether there are lines to mark, and not a text to scroll."""
        if self.rows():
            self.marked = (self.marked + by) % self.rows()
        return bool(self.rows())

    def enter(self) -> None:
        """Do what is marked, or take a press of the two that it needs."""

    def skip(self) -> None:
        """Go on without it."""
        raise BadRequest("there is nothing to skip here")

    def turn(self) -> None:
        """Turn a motor, or bring it back."""
        raise BadRequest(FOR_MOTORS)

    def saw(self, what: str) -> None:  # noqa: ARG002 - for the stage that checks motors
        """Take what was seen of a motor."""
        raise BadRequest(FOR_MOTORS)

    def another(self) -> None:
        """Take that another motor's part moved."""
        raise BadRequest(FOR_MOTORS)

    def back(self) -> None:
        """Go back. Raises `BadRequest` at the first stage."""
        if self.before is None:
            raise BadRequest("this is the first step")
        self.go(self.before)

    def forget(self) -> None:
        """Let nothing be half chosen."""

    def twice(self, what: str) -> str:
        """Say how `what` is confirmed, once more after the first press."""
        enter = self.desk.keys.label("setup-enter")
        return self.desk.confirmation.again or f"{enter}, twice: {what}"


class FileToWrite(SetupStage):
    """What a new arm file would say, or the arm's own one instead; two presses write it."""

    def __init__(
        self,
        desk: Desk,
        go: Go,
        before: SetupStage,
        path: Path,
        shown: str,
        write: Callable[[], None] | None,
        after: Sequence[str],
    ) -> None:
        """`shown` is what is written, `write` is None for nothing; `after` is said afterwards."""
        super().__init__(desk, go, before)
        self.path, self.written = path, False
        self._shown, self._write, self._after = shown, write, after

    def text(self) -> StageText:
        """Show what is to be written, or what comes next."""
        if self.written:
            return StageText("\n".join([f"written: {self.path}", "", *self._after]))
        twice = [self.twice(f"writes {self.path}"), ""] if self._write is not None else []
        return StageText("\n".join([*twice, self._shown]))

    def enter(self) -> None:
        """Take a press of the two; go back to the first step where nothing is left to write."""
        if self._write is not None and not self.written:
            self.desk.confirmation.press(f"writes {self.path}", self._do, row="setup-enter")
            return
        stage: SetupStage = self
        while stage.before is not None:
            stage = stage.before
        self.go(stage)

    def _do(self) -> None:
        if self._write is not None:
            self._write()
            self.written = True


def new_file(stage: InterviewAsking, files: ArmFiles, name: str) -> FileToWrite:
    """Return the stage of the file that the answers make; nothing stands on the disk yet."""
    path, leave = arm_path(name), stage.desk.keys.label("quit")

    def write_new() -> None:
        if path.exists():
            raise BadRequest(f"{path} already exists, and is not overwritten")
        write(files, path)

    after = (
        f"This desk still has the arm it began with. Leave it ({leave}), then:",
        f"  {command_line('config', 'check', path.stem)}",
        "    (opens nothing)",
        f"  {command_line('jog', '--arm', path.stem, '--setup')}",
        "    (connects, moves nothing: reference it there, and check its motors)",
    )
    return FileToWrite(stage.desk, stage.go, stage, path, files.shown, write_new, after)


def correction(stage: SetupStage, proposal: FileProposal) -> FileToWrite:
    """Return the stage of what the arm's own file should say instead, as a difference."""
    path = proposal.path
    lines = [*proposal.remarks, ""] if proposal.remarks else []
    unchanged = (f"{path} is left as it is: nothing in it has to be changed.",)
    lines += proposal.difference if proposal.differs else unchanged
    after = ("It takes effect when the arm is next connected: check once more then.",)
    change = proposal.write if proposal.differs else None
    return FileToWrite(stage.desk, stage.go, stage, path, "\n".join(lines), change, after)


# The stages that lead to the answers.


class Ports(SetupStage):
    """The ports and CAN interfaces, as they are known while closed; one of them is asked."""

    def __init__(self, desk: Desk, go: Go, before: SetupStage) -> None:
        super().__init__(desk, go, before)
        self.candidates: tuple[ClosedPort, ...] = ()
        self.other = TypedText()
        """A port that is not listed."""
        self.found: Report | None = None
        self._asked = ""
        """The port that is being asked."""
        # who holds a port is not found in a moment
        self._looking = desk.calls.work_out(closed_ports, self._list)

    def _list(self, found: tuple[ClosedPort, ...] | None) -> None:
        if found is not None:
            self.marked = len(found) if self.other.text else 0
            self.candidates = found

    @property
    def idle(self) -> tuple[str, ...]:
        """A port can be skipped: it is described without opening it."""
        return tuple(row for row in super().idle if row != SKIP)

    def rows(self) -> int:
        """Return the number of ports, and one to be typed."""
        return len(self.candidates) + 1

    @property
    def typing(self) -> TypedText | None:
        """The line for another port, while that is marked."""
        return self.other if self.marked == len(self.candidates) else None

    @property
    def port(self) -> str:
        """The port that is marked or typed."""
        return self.other.text if self.typing else self.candidates[self.marked].port

    def text(self) -> StageText:
        """List the ports; of the marked one, all that is known, and what was found behind it."""
        rows = [each.port for each in self.candidates]
        looking = "looking for ports ..." if self._looking.busy else "Listing has opened none."
        head = f"Which port leads to the arm? {looking}"
        known = [] if self.typing else ["", *self.candidates[self.marked].lines]
        tail = "\n".join([*known, "", *self._next()]).removeprefix("\n")
        return StageText(head, (*rows, f"another: {self.other.text}_"), self.marked, tail)

    def _next(self) -> list[str]:
        keys = self.desk.keys
        on = f"{keys.label('setup-on')}: describe the arm without opening it"
        if self._asked:
            return [f"asking {self._asked} ... (some seconds; nothing moves)"]
        if self.found is not None and self.found.port == self.port:
            report = list(self.found.lines)
            if self.found.dialect:
                return [*report, "", f"{keys.label('setup-enter')}: describe this arm"]
            return [*report, "", self.twice("asks again"), on]
        return [RISK, self.twice("opens it and recognises the controller"), on]

    def enter(self) -> None:
        """Go on with a port that was recognised, or take a press towards asking."""
        if self.found is not None and self.found.port == self.port and self.found.dialect:
            self.go(InterviewAsking(self.desk, self.go, self, self.found.answers))
        elif self._asked:
            raise BadRequest(f"{self._asked} is being asked: wait")
        elif not self.port:
            raise BadRequest("type a port first: /dev/ttyUSB0, COM3, socket://HOST:PORT, can:...")
        else:
            opens = f"opens {self.port}"
            self.desk.confirmation.press(opens, self._begin_asking, row="setup-enter")

    def skip(self) -> None:
        """Describe the arm on this port, or on none yet."""
        known = {"connection.port": self.port} if self.port else {}
        self.go(InterviewAsking(self.desk, self.go, self, known))

    def _begin_asking(self) -> None:
        """Ask the port, in a thread."""
        self._asked = self.port
        self.desk.calls.work_out(partial(_report_on, self.port), self._take_report)

    def _take_report(self, found: Report | None) -> None:
        self._asked, self.found = "", found or self.found


def _report_on(port: str) -> Report:
    """Ask a port that can be opened what is behind it; else say why it cannot."""
    closed = look_at(port)
    return probe(port) if closed.openable else Report(port, findings=[*closed.findings])


class InterviewAsking(SetupStage):
    """The questions of `armdrive config new`, one at a time."""

    def __init__(self, desk: Desk, go: Go, before: SetupStage, found: dict[str, str]) -> None:
        super().__init__(desk, go, before)
        require_writable(arm_files())  # not only after forty questions
        self.describing = Describing(found)

    @property
    def typing(self) -> TypedText:
        """The answer."""
        return TypedText(self.describing.typed, changed=partial(setattr, self.describing, "typed"))

    def text(self) -> StageText:
        """Put the question, with why it is asked, its choices, and what enter would answer."""
        question, keys = self.describing.question, self.desk.keys
        if question is None:
            return StageText("")
        offered = self.describing.line or "(type an answer)"
        stop = keys.label(STOP)
        hint = f"Type _ for a space: {stop} stops." if self.describing.is_free_text else ""
        below = (
            question.why,
            "",
            *([f"answer: {self.describing.typed}_"] if self.describing.typed else []),
            f"{keys.label('setup-enter')}: {offered}",
            f"{keys.label('setup-back')}: the question before. {hint}".rstrip(),
        )
        width = max((len(word) for word, _ in question.choices), default=0)
        rows = tuple(f"{word:<{width}}  {meaning}".rstrip() for word, meaning in question.choices)
        marked = None if self.describing.typed or not rows else self.describing.marked
        return StageText(question.words, rows, marked, "\n".join(below))

    def mark(self, by: int) -> bool:
        """Mark another choice."""
        self.describing.mark(by)
        return True

    def enter(self) -> None:
        """Answer; after the last question show the file."""
        self.describing.enter()
        if self.describing.question is None:
            self._show()

    def _show(self) -> None:
        name = self.describing.name
        try:
            files = self.describing.files()
        finally:
            self.describing.back()  # to the last question: there the file can still be changed
        self.go(new_file(self, files, name))

    def back(self) -> None:
        """Go back to the question before, or to where it began."""
        if not self.describing.back():
            super().back()
