"""The set-up screen: from a port nobody knows to an arm file that was checked on the arm."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from textual import events
from textual.app import ComposeResult
from textual.binding import BindingType
from textual.containers import Horizontal, VerticalScroll

from armdrive.errors import ArmError
from armdrive.render.scene import Moment
from armdrive.setup.directions import Saw
from armdrive.setup.filing import file_of
from armdrive.status import Status
from kinematics import KinematicsError
from tui.framework import PlainText
from tui.layout import bindings
from tui.screens.base import DeskScreen
from tui.setup_motors import Motors
from tui.setup_steps import Steps
from tui.widgets.arm_view import SpaceView

if TYPE_CHECKING:
    from collections.abc import Callable

    from tui.setup_stage import Stage


class SetupScreen(DeskScreen):
    """Shows one stage, and hands keys on to it. Nothing here moves the arm but `t`."""

    place = "setup"
    BINDINGS: ClassVar[list[BindingType]] = bindings(place)
    CSS = """
    #setup-panel { width: 1fr; min-width: 42; padding: 0 0 0 1; scrollbar-size: 1 0; }
    #setup-text { height: auto; }
    """

    def __init__(self) -> None:
        super().__init__()
        path = file_of(self.desk.arm.config)
        self.first = Steps(self.desk, self._go, path)
        self.stage: Stage = self.first

    def _go(self, stage: Stage) -> None:
        self.stage.forget()
        self.stage = stage
        if self._laid_out:
            self.query_one("#setup-panel").scroll_home(animate=False)

    def disarm(self, reason: str) -> None:
        """Take a first press back; a stop also leaves the step."""
        self.stage.forget()
        if reason == "stopped":
            self._go(self.first)

    def compose_body(self) -> ComposeResult:
        """Lay the middle out: the arm, where it is drawn, and the words of the stage."""
        desk = self.desk
        with Horizontal():
            yield SpaceView(desk.arm.model, braille=desk.braille, id="space", clock=desk.clock)
            with VerticalScroll(id="setup-panel", can_focus=False):
                yield PlainText(id="setup-text")

    def show_body(self, status: Status) -> None:
        """Show the stage, and do what two presses have confirmed."""
        del status
        self._try(self.stage.due)
        view, moment = self.query_one(SpaceView), self.stage.moment()
        view.display = moment is not None
        view.show(moment or Moment())
        self.text("setup-text").show(self.stage.text())

    def on_key(self, event: events.Key) -> None:
        """Type into the stage where it is typed; other keys go on to the table of keys."""
        character = event.character
        if self.stage.typing and character and character.isprintable() and character != " ":
            event.stop()
            event.prevent_default()
            self._do(lambda: self.stage.type(character))

    def _try(self, deed: Callable[[], object]) -> None:
        try:
            deed()
        except (ArmError, KinematicsError, OSError) as error:
            self.desk.message = str(error)

    def _do(self, deed: Callable[[], object]) -> None:
        self.desk.message = ""
        self._try(deed)
        self.desk.show()

    def action_enter(self) -> None:
        """Do what is marked."""
        self._do(self.stage.enter)

    def action_mark(self, by: int) -> None:
        """Mark another line, or scroll a text."""
        if self.stage.mark(by):
            self._do(lambda: None)
        else:
            self.query_one("#setup-panel").scroll_relative(y=3 * by, animate=False)

    def action_on(self) -> None:
        """Go on without opening."""
        self._do(self.stage.on)

    def action_back(self) -> None:
        """Go back."""
        self._do(self.stage.back)

    def action_erase(self) -> None:
        """Take the last character away."""
        self._do(self.stage.erase)

    def _motors(self) -> Motors | None:
        if isinstance(self.stage, Motors):
            return self.stage
        self.desk.say("that is for checking motors: choose that step first")
        return None

    def action_turn(self) -> None:
        """Turn the motor, or bring it back."""
        if motors := self._motors():
            self._do(motors.turn)

    def action_saw(self, what: str) -> None:
        """Say what was seen."""
        if motors := self._motors():
            self._do(lambda: motors.saw(Saw[what]))

    def action_another(self) -> None:
        """Say that another motor's part moved."""
        if motors := self._motors():
            self._do(motors.another)
