"""The stages that lead to an arm file: ports, what is behind one, questions, what is written.

Each stage is a list, a question, or a text; the screen shows one of them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from armdrive.errors import ArmError, BadRequest
from armdrive.errors.printable import command_line
from armdrive.registry.arm_files import arm_path
from armdrive.render.scene import Moment
from armdrive.setup.bus_survey import probe
from armdrive.setup.filing import ArmFiles, FileProposal, write
from armdrive.setup.interview import Describing
from armdrive.setup.ports import ClosedPort, closed_ports, look_at
from armdrive.setup.survey import OPENING_RISK, Report
from armdrive.storage.files import arm_files, require_writable
from kinematics.errors import KinematicsError
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

    def confirm(self, effect: str, act: Callable[[], object]) -> None:
        """Take a press of the two that this needs."""
        self.desk.confirmation.press(effect, act, row="setup-enter")


def first_of(stage: SetupStage) -> SetupStage:
    """Return the stage that all began with."""
    while stage.before is not None:
        stage = stage.before
    return stage


# The stages that write: a new arm file, or corrections of a present one.


class NewFile(SetupStage):
    """The file that the answers make; nothing stands on the disk yet."""

    def __init__(
        self, desk: Desk, go: Go, before: InterviewAsking, files: ArmFiles, name: str
    ) -> None:
        super().__init__(desk, go, before)
        self.files, self.name, self.asking = files, name, before

    def text(self) -> StageText:
        """Show the file."""
        path = arm_path(self.name)
        return StageText("\n".join([self.twice(f"writes {path}"), "", self.files.shown]))

    def enter(self) -> None:
        """Take a press."""
        self.confirm(f"writes {arm_path(self.name)}", self._write)

    def back(self) -> None:
        """Go back to the last question."""
        self.asking.describing.back()
        super().back()

    def _write(self) -> None:
        """Write it, unless a file of that name has been written meanwhile."""
        path = arm_path(self.name)
        if path.exists():
            raise BadRequest(f"{path} already exists, and is not overwritten")
        write(self.files, path)
        self.go(Written(self.desk, self.go, first_of(self), path))


class Closing(SetupStage):
    """A stage after which the desk may be opened on an arm file; that takes two presses."""

    path: Path

    def reopening(self) -> list[str]:
        """Say how the desk is opened on the file."""
        return [
            self.twice(f"leaves this arm, and opens the desk on {self.path.stem}"),
            RISK,
        ]

    def enter(self) -> None:
        """Take a press towards the other desk."""
        self.confirm(f"opens the desk on {self.path.stem}", self._open)

    def _open(self) -> None:
        """Leave this arm, for a desk on the arm of the file."""
        self.desk.opens = self.path
        self.desk.action_leave()


class Written(Closing):
    """A new file is written: what comes next."""

    def __init__(self, desk: Desk, go: Go, before: SetupStage, path: Path) -> None:
        super().__init__(desk, go, before)
        self.path = path

    def text(self) -> StageText:
        """Say what comes next, from the safest on."""
        name, leave = self.path.stem, self.desk.keys.label("quit")
        lines = (
            f"written: {self.path}",
            "",
            *self.reopening(),
            "",
            f"This desk still has the arm it began with. Or leave it ({leave}), then:",
            f"  {command_line('config', 'check', name)}",
            "    (opens nothing)",
            f"  {command_line('jog', '--arm', name, '--setup')}",
            "    (connects, moves nothing: reference it there, and check its motors)",
        )
        return StageText("\n".join(lines))


class Correction(Closing):
    """What the arm's own file should say instead, as a difference; two presses write it."""

    def __init__(self, desk: Desk, go: Go, before: SetupStage, proposal: FileProposal) -> None:
        super().__init__(desk, go, before)
        self.proposal, self.path = proposal, proposal.path
        self.written = False

    def text(self) -> StageText:
        """Show the difference and the remarks."""
        proposal = self.proposal
        lines = [*proposal.remarks, ""] if proposal.remarks else []
        if self.written:
            takes_up = "It takes effect when the arm is next connected"
            lines += [f"written: {proposal.path}", f"{takes_up}: check once more then.", ""]
            lines += self.reopening()
        elif proposal.differs:
            lines += [self.twice(f"writes {proposal.path}"), "", *proposal.difference]
        else:
            lines += [f"{proposal.path} is left as it is: nothing in it has to be changed."]
        return StageText("\n".join(lines))

    def enter(self) -> None:
        """Take a press; go back where there is nothing to write."""
        if self.written:
            super().enter()
        elif self.proposal.differs:
            self.confirm(f"writes {self.path}", self._write)
        else:
            self.go(first_of(self))

    def _write(self) -> None:
        self.proposal.write()
        self.written = True


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
            self.confirm(f"opens {self.port}", self._begin_asking)

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
