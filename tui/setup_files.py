"""The stages that write: a new arm file, or what is corrected in a present one."""

from __future__ import annotations

from typing import TYPE_CHECKING

from armdrive.errors import BadRequest
from armdrive.setup.describing import path_of
from armdrive.setup.filing import Proposal, write
from tui.setup_stage import Go, Stage, first_of

if TYPE_CHECKING:
    from pathlib import Path

    from armdrive.interview.writing import Files
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


class Written(Stage):
    """A new file is written: what comes next."""

    def __init__(self, desk: Desk, go: Go, before: Stage, path: Path) -> None:
        super().__init__(desk, go, before)
        self.path = path

    def text(self) -> str:
        """Say what comes next, from the safest on."""
        name, quit_ = self.path.stem, self.desk.keys.label("quit")
        return "\n".join(
            (
                f"written: {self.path}",
                "",
                f"This desk still has the arm it began with. Leave it ({quit_}), then:",
                f"  armdrive config check {name}",
                "    (opens nothing)",
                f"  armdrive jog --arm {name} --setup",
                "    (connects, moves nothing: reference it there, and check its motors)",
            )
        )

    def enter(self) -> None:
        """Go back to the steps."""
        self.back()


class Correction(Stage):
    """What the arm's own file should say instead, as a difference; two presses write it."""

    def __init__(self, desk: Desk, go: Go, before: Stage, proposal: Proposal) -> None:
        super().__init__(desk, go, before)
        self.proposal = proposal
        self.written = False

    def text(self) -> str:
        """Show the difference and the remarks."""
        proposal = self.proposal
        lines = [*proposal.remarks, ""] if proposal.remarks else []
        if self.written:
            leave = self.desk.keys.label("quit")
            lines += [
                f"written: {proposal.path}",
                f"The arm takes it up when it is next connected: leave ({leave}),",
                "come back, and check once more.",
            ]
        elif proposal.differs:
            lines += [self.again(f"writes {proposal.path}"), "", *proposal.difference]
        else:
            lines += [f"{proposal.path} is left as it is: nothing in it has to be changed."]
        return "\n".join(lines)

    def enter(self) -> None:
        """Take a press; go back where there is nothing to write."""
        if self.written or not self.proposal.differs:
            self.go(first_of(self))
        else:
            self.twice.press()

    def due(self) -> None:
        """Write it."""
        if self.twice.due():
            self.proposal.write()
            self.written = True
