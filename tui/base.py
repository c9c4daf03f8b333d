"""What stands on the desk's screen: laid out once, and shown anew from each status of the arm."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from typing import ClassVar

from textual.app import App, ComposeResult
from textual.binding import BindingType
from textual.containers import Horizontal, Vertical, VerticalScroll

from armdrive.draw.armview import ArmScene, side_view, top_view
from armdrive.errors import ArmError
from armdrive.status import State, Status
from kinematics import KinematicsError
from tui import panels
from tui.arm_port import DeskArm
from tui.framework import PlainText
from tui.keys import footer, jog_pairs
from tui.layout import CSS, bindings
from tui.settings import Settings
from tui.views import ArmView, scene_of

Done = str | Callable[[Status], str] | None


class ArmScreen(App[int]):
    """One arm on one screen, and calls to it that keep nobody waiting."""

    ENABLE_COMMAND_PALETTE = False
    TITLE = "armdrive"
    BINDINGS: ClassVar[list[BindingType]] = bindings()
    CSS = CSS
    HORIZONTAL_BREAKPOINTS = [(0, "-narrow"), (100, "-wide")]  # noqa: RUF012 - as App declares it

    def __init__(
        self, arm: DeskArm, *, braille: bool, clock: Callable[[], float] = time.monotonic
    ) -> None:
        super().__init__()
        self._arm = arm
        self._braille = braille
        self._clock = clock
        geometry = arm.model.arm
        pairs = jog_pairs(geometry.joint_names, has_yaw=geometry.has_yaw)
        self._settings = Settings(pairs=pairs, frames=arm.frames)
        self._message = "enter arms the jog keys; space stops at any time"
        self._status: Status = arm.status

    def compose(self) -> ComposeResult:
        """Lay the screen out: drawings on the left, words and numbers on the right."""
        yield PlainText(id="title")
        yield PlainText(id="banner")
        with Horizontal():
            with Vertical(id="views"):
                yield ArmView("side", side_view, braille=self._braille, id="side")
                yield ArmView("above", top_view, braille=self._braille, id="top")
            with VerticalScroll(id="panel", can_focus=False):
                for name in ("conduct", "joints", "tip", "bottom"):
                    yield PlainText(id=name)
        yield PlainText(id="remarks")
        yield PlainText(id="footer")

    @property
    def armed(self) -> bool:
        """Whether jog keys have any effect."""
        return False

    @property
    def settings(self) -> Settings:
        """Mode, increment and speed as they are set."""
        return self._settings

    @property
    def _lost(self) -> bool:
        """Whether there is no link to the arm."""
        return self._status.state is State.DISCONNECTED

    def _show(self) -> None:
        if not self.is_running:
            return  # the widgets are already being taken down
        status, settings, model = self._status, self._settings, self._arm.model
        screen = self.screen_stack[0]
        width = max(screen.query_one("#panel").content_size.width, 1)
        texts = {
            "title": panels.title(status, self.size.width),
            "banner": panels.banner(status, looked_for=self._arm.reconnects),
            "conduct": panels.conduct(status, settings, armed=self.armed),
            "joints": panels.joint_table(status, model, settings, width),
            "tip": panels.tip_lines(status, settings),
            "bottom": panels.bottom_lines(status),
            "remarks": panels.remarks(status, self._message),
            "footer": footer(self.size.width),
        }
        for name, text in texts.items():
            screen.query_one(f"#{name}", PlainText).show(text)
        screen.query_one("#title").set_class(not status.simulated, "-real")
        screen.query_one("#banner").set_class(bool(texts["banner"]), "-shown")
        screen.query_one("#conduct").set_class(self.armed, "-armed")
        scene = self._scene()
        for name in ("side", "top"):
            screen.query_one(f"#{name}", ArmView).show(scene)

    def _scene(self) -> ArmScene | None:
        """Return what is to be drawn of the arm as it stands."""
        joints = self._status.joints
        if joints is None:
            return None
        return scene_of(self._arm.model, joints, self._status.gripper_mm)

    def _say(self, message: str) -> None:
        self._message = message
        self._show()

    def _in_thread(self, call: Callable[[], object], done: Done) -> None:
        """Make a call that takes a moment, without keeping the stop key waiting.

        `done` is said when it has gone well, or what it says of the status then; without it the
        status speaks for itself.
        """
        self.run_worker(partial(self._called, call, done), thread=True, exit_on_error=False)

    def _called(self, call: Callable[[], object], done: Done) -> None:
        try:
            call()
            said = done(self._arm.status) if callable(done) else done
        except (ArmError, KinematicsError) as error:
            said = str(error)
        if said is not None:
            self.call_from_thread(self._say, said)
