"""What the stages of the set-up screen have in common; each is a list, a question, or a text."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from armdrive.errors import BadRequest
from armdrive.render.scene import Moment
from tui.keys.presses import DoublePress
from tui.screens import ScreenHost

WARNING = (
    "Opening it can restart the board behind it: motors lose their current, and an arm that is "
    "raised sags. Support it first. Nothing that is sent moves it."
)
"""The warning before a port is opened."""

Go = Callable[["SetupStage"], None]
"""Shows another stage."""


@dataclass(frozen=True, slots=True)
class StageText:
    """What a stage says: a text, a list of which one row may be marked, and a text below it."""

    head: str
    rows: tuple[str, ...] = ()
    marked: int | None = None
    tail: str = ""


class SetupStage:
    """One stage. It knows the desk and how to go on to another one, and nothing of the screen."""

    typing = False
    """Whether printable keys are typed into it."""

    def __init__(self, desk: ScreenHost, go: Go, before: SetupStage | None = None) -> None:
        self.desk = desk
        self.go = go
        self.before = before
        self.marked = 0
        self.twice = DoublePress(desk.clock)

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
        self.twice.forget()
        if self.rows():
            self.marked = (self.marked + by) % self.rows()
        return bool(self.rows())

    def type(self, character: str) -> None:
        """Type a character."""

    def erase(self) -> None:
        """Take the last character away."""

    def enter(self) -> None:
        """Do what is marked, or take a press of the two that it needs."""

    def on(self) -> None:
        """Go on without it."""
        raise BadRequest("there is nothing to skip here")

    def back(self) -> None:
        """Go back."""
        if self.before is not None:
            self.go(self.before)

    def due(self) -> None:
        """Do what two presses have confirmed, once."""

    def forget(self) -> None:
        """Take a first press back."""
        self.twice.forget()

    def again(self, what: str) -> str:
        """Say how `what` is confirmed."""
        enter = self.desk.keys.label("setup-enter")
        if self.twice.waiting:
            return f"{enter} ONCE MORE {what}; anything else takes it back"
        return f"{enter}, twice: {what}"


def first_of(stage: SetupStage) -> SetupStage:
    """Return the stage that all began with."""
    while stage.before is not None:
        stage = stage.before
    return stage
