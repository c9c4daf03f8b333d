"""The set-up screen: from an unknown port to an arm file that was checked on the arm."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import ClassVar

from textual.app import ComposeResult
from textual.binding import BindingType
from textual.containers import Horizontal, Vertical, VerticalScroll

from armdrive.errors import BadRequest
from armdrive.render.scene import Moment
from armdrive.setup.filing import file_of
from armdrive.status import Status, Trust
from armdrive.storage.files import require_writable
from tui.arm_view import SpaceView
from tui.desk import Desk, DeskScreen
from tui.keys.keyboard import bindings
from tui.setup.motors import MotorsStage
from tui.setup.stages import Go, InterviewAsking, Ports, SetupStage, StageText
from tui.widgets import ChoiceList, PlainText, TypedText

# The first stage of setting up: the steps, which of them can be taken here, and why not.

# In the order in which a new arm is set up.
STEPS = (
    ("find", "find the arm", "its port or CAN interface; none is opened before you ask"),
    ("describe", "describe it", "questions that make its file; nothing is sent"),
    ("reference", "reference it", "tell armdrive where it stands, with the posture drawn"),
    ("motors", "check its motors", "each turns a little, by a key; you say what you saw"),
)


class Steps(SetupStage):
    """The steps. Those that need another arm than the desk's say how to come to it."""

    def __init__(self, desk: Desk, go: Go, path: Path | None) -> None:
        super().__init__(desk, go)
        self.path = path
        self._motors: MotorsStage | None = None
        self.marked = 0 if self.free else 2
        self._referencing = False
        self._left: InterviewAsking | None = None
        """Questions that a stop has ended before the last one."""

    @property
    def free(self) -> bool:
        """Whether the arm on this desk is only simulated and has no file."""
        return self.desk.link.status.simulated and self.path is None

    def text(self) -> StageText:
        """List the steps, and whose arm they are for."""
        if self._referencing and self.desk.link.status.trust is Trust.REFERENCED:
            self._referencing, self.marked = False, len(STEPS) - 1
        width = max(len(title) for _, title, _ in STEPS)
        rows = tuple(f"{n} {title:<{width}}  {why}" for n, (_, title, why) in enumerate(STEPS, 1))
        enter = self.desk.keys.label("setup-enter")
        tail = f"{enter} begins the marked step. A stop leaves it; questions stay answered."
        return StageText(self._whose(), rows, self.marked, tail)

    def _whose(self) -> str:
        status = self.desk.link.status
        if self.path is not None:
            twin = ", its simulated twin" if status.simulated else ""
            return f"This desk has the arm {status.arm}{twin}: {self.path}"
        if self.free:
            return (
                "No arm of yours is on this desk: it is simulated. The first two steps make a file "
                "of yours; the others are tried on the simulated arm."
            )
        return f"This desk has an arm without a file, on {status.link}: describe it first."

    def rows(self) -> int:
        """Return the number of steps."""
        return len(STEPS)

    def enter(self) -> None:
        """Begin the marked step."""
        step = STEPS[self.marked][0]
        if step in ("find", "describe") and not self.free:
            self._other(step)
        elif step == "find":
            self.go(Ports(self.desk, self.go, self))
        elif step == "describe":
            left, self._left = self._left, None
            self.go(left or InterviewAsking(self.desk, self.go, self, {}))
        elif step == "reference":
            self._referencing = self.desk.link.status.trust is not Trust.REFERENCED
            self.desk.control.reference()
        elif self.path is not None and file_of(self.desk.arm.config) != self.path:
            raise BadRequest(f"{self.path} was changed: leave this desk and come back first")
        else:
            self.go(self._begun())

    def leave(self, stage: SetupStage) -> None:
        """Come back from a stage that a stop has ended: a space may have been meant as a letter."""
        if isinstance(stage, InterviewAsking) and stage.describing.question is not None:
            self._left, self.marked = stage, 1

    def _begun(self) -> MotorsStage:
        """Return the check that was left half-way, or a new one."""
        if self.path is not None:
            require_writable(self.path.parent)  # before a motor turns for what cannot be kept
        if self._motors is None or self._motors.check.trial is None:
            self._motors = MotorsStage(self.desk, self.go, self)
        return self._motors

    def _other(self, step: str) -> None:
        """Describe the arm of a port that has no file; else say that this needs leaving."""
        connection = self.desk.arm.config.connection
        if step == "describe" and self.path is None:
            known = {"connection.port": connection.port, "dialect": connection.dialect,
                     "connection.baud": str(connection.baud)}  # fmt: skip
            self.go(InterviewAsking(self.desk, self.go, self, known))
            return
        leave = self.desk.keys.label("quit")
        raise BadRequest(
            f"this desk holds {self.desk.link.status.arm}: leave it ({leave}), then `armdrive jog "
            "--sim teachmover --setup` sets up another one"
        )


class SetupScreen(DeskScreen):
    """Shows one stage, and hands keys on to it. Nothing here moves the arm but `t`."""

    place = "setup"
    go = "setup-enter"
    BINDINGS: ClassVar[list[BindingType]] = bindings(place)

    def __init__(self) -> None:
        super().__init__()
        path = file_of(self.desk.arm.config)
        self.first = Steps(self.desk, self._go, path)
        self.stage: SetupStage = self.first

    @property
    def typing(self) -> TypedText | None:
        """The line of the stage that is typed into."""
        return self.stage.typing

    def _go(self, stage: SetupStage) -> None:
        self.stage.forget()
        self.desk.confirmation.forget()
        self.stage = stage
        if self.is_mounted:
            self.query_one("#setup-panel").scroll_home(animate=False)

    @property
    def works(self) -> Mapping[str, bool]:
        """Some keys are for another stage than this one."""
        back = self.stage.before is not None
        return {**dict.fromkeys(self.stage.idle, False), "setup-back": back}

    def disarm(self, reason: str) -> None:
        """Let nothing be half chosen; a stop also leaves the step."""
        self.stage.forget()
        if reason == "stopped":
            self.first.leave(self.stage)
            self._go(self.first)

    def compose_body(self) -> ComposeResult:
        """Lay the middle out: the arm, where it is drawn, and the words of the stage."""
        with Horizontal():
            yield from self.arm_panel()
            scrolled = VerticalScroll(id="setup-panel", can_focus=False)
            with scrolled, Vertical(classes="panel") as panel:
                panel.border_title = "Set up an arm"
                yield PlainText(id="setup-head")
                yield ChoiceList("choose", id="setup-rows")
                yield PlainText(id="setup-tail")

    def show_body(self, status: Status) -> None:
        """Show the stage."""
        del status
        view, moment = self.query_one(SpaceView), self.stage.moment()
        self.query_one("#arm").display = moment is not None
        view.show(moment or Moment())
        text, rows = self.stage.text(), self.query_one(ChoiceList)
        self.text("setup-head").show(text.head)
        rows.show_rows(text.rows, text.marked)
        rows.display = bool(text.rows)
        self.text("setup-tail").show(text.tail)

    def action_choose(self, by: int) -> None:
        """Mark another line, or scroll a text."""
        if not self.stage.mark(by):
            self.query_one("#setup-panel").scroll_relative(y=3 * by, animate=False)
