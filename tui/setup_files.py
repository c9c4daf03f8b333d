"""The stages that write: a new arm file, or what is corrected in a present one."""

from __future__ import annotations

from typing import TYPE_CHECKING

from armdrive.errors import BadRequest
from armdrive.setup.filing import Proposal, write
from armdrive.setup.interview import path_of
from tui.setup_stage import WARNING, Go, Stage, first_of

if TYPE_CHECKING:
    from pathlib import Path

    from armdrive.setup.arm_text import Files
    from tui.desk import Desk
    from tui.setup_new import Asking


class NewFile(Stage):
    """The file that the answers make; nothing stands on the disk yet."""

    def __init__(self, desk: Desk, go: Go, before: Asking, files: Files, name: str) -> None:
        super().__init__(desk, go, before)
        self.files, self.name, self.asking = files, name, before

    def text(self) -> str:
        """Show the file."""
        path = path_of(self.name)
        return "\n".join([self.again(f"writes {path}"), "", self.files.shown])

    def enter(self) -> None:
        """Take a press."""
        self.twice.press()

    def back(self) -> None:
        """Go back to the last question."""
        self.asking.describing.back()
        super().back()

    def due(self) -> None:
        """Write it, unless somebody else has meanwhile written one of that name."""
        if not self.twice.due():
            return
        path = path_of(self.name)
        if path.exists():
            raise BadRequest(f"{path} exists by now, and is not overwritten")
        write(self.files, path)
        self.go(Written(self.desk, self.go, first_of(self), path))


class Closing(Stage):
    """A stage behind which the desk may be opened anew, on an arm file; that takes two presses."""

    path: Path

    def reopening(self) -> list[str]:
        """Say how the desk is opened on the file; nothing where nobody would do that."""
        if not self.desk.reopens:
            return []
        return [self.again(f"leaves this arm, and opens the desk on {self.path.stem}"), WARNING]

    def enter(self) -> None:
        """Take a press towards the other desk; without one, go back to the steps."""
        if self.desk.reopens:
            self.twice.press()
        else:
            self.go(first_of(self))

    def due(self) -> None:
        """Leave for the desk of the file."""
        if self.twice.due():
            self.desk.open_next(self.path)


class Written(Closing):
    """A new file is written: what comes next."""

    def __init__(self, desk: Desk, go: Go, before: Stage, path: Path) -> None:
        super().__init__(desk, go, before)
        self.path = path

    def text(self) -> str:
        """Say what comes next, from the safest on."""
        name, quit_ = self.path.stem, self.desk.keys.label("quit")
        reopening = self.reopening()
        leave = f"{'Or l' if reopening else 'L'}eave it ({quit_}), then:"
        return "\n".join(
            (
                f"written: {self.path}",
                "",
                *reopening,
                *[""] * bool(reopening),
                f"This desk still has the arm it began with. {leave}",
                f"  armdrive config check {name}",
                "    (opens nothing)",
                f"  armdrive jog --arm {name} --setup",
                "    (connects, moves nothing: reference it there, and check its motors)",
            )
        )


class Correction(Closing):
    """What the arm's own file should say instead, as a difference; two presses write it."""

    def __init__(self, desk: Desk, go: Go, before: Stage, proposal: Proposal) -> None:
        super().__init__(desk, go, before)
        self.proposal, self.path = proposal, proposal.path
        self.written = False

    def text(self) -> str:
        """Show the difference and the remarks."""
        proposal = self.proposal
        lines = [*proposal.remarks, ""] if proposal.remarks else []
        if self.written:
            leave = self.desk.keys.label("quit")
            takes_up = "The arm takes it up when it is next connected"
            reopening = self.reopening()
            lines += [f"written: {proposal.path}", f"{takes_up}: check once more then.", ""]
            lines += reopening or [f"Leave ({leave}), and come back."]
        elif proposal.differs:
            lines += [self.again(f"writes {proposal.path}"), "", *proposal.difference]
        else:
            lines += [f"{proposal.path} is left as it is: nothing in it has to be changed."]
        return "\n".join(lines)

    def enter(self) -> None:
        """Take a press; go back where there is nothing to write."""
        if self.written:
            super().enter()
        elif self.proposal.differs:
            self.twice.press()
        else:
            self.go(first_of(self))

    def due(self) -> None:
        """Write it; once that is done, open the desk on it."""
        if self.written:
            super().due()
        elif self.twice.due():
            self.proposal.write()
            self.written = True
