"""The screen of an arm that another program drives: what it does, and nothing that moves it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, cast

from textual.app import ComposeResult
from textual.containers import Container, Horizontal, VerticalScroll
from textual.screen import Screen

from armdrive.render.scene import Moment
from kinematics import Joints
from tui import watch_words
from tui.framework import PlainText
from tui.widgets.arm_view import SpaceView

if TYPE_CHECKING:
    from kinematics import ArmModel
    from tui.watching import Watching


class WatchScreen(Screen[None]):
    """A picture and words of what another program says of its arm."""

    AUTO_FOCUS = ""
    CSS = """
    #panel { width: 1fr; padding: 0 0 0 1; scrollbar-size: 0 0; }
    #watched { height: auto; }
    """

    _laid_out = False

    @property
    def watching(self) -> Watching:
        """The app that the screen belongs to."""
        return cast("Watching", self.app)

    def compose(self) -> ComposeResult:
        """Lay the screen out: the arm on the left, words and numbers on the right."""
        app = self.watching
        yield PlainText(id="title")
        yield PlainText(id="banner")
        with Container(id="body"), Horizontal():
            yield SpaceView(app.model, braille=app.braille, id="space")
            with VerticalScroll(id="panel", can_focus=False):
                yield PlainText(id="watched")
        yield PlainText(id="remarks")
        yield PlainText(id="footer")

    def on_mount(self) -> None:
        """Show what was heard before there was room for it."""
        self._laid_out = True
        self.call_after_refresh(self.watching.poll)

    def show(self, view: watch_words.View, ended: str, message: str) -> None:
        """Show what is known, why it is no longer new, and what was said last."""
        if not (self._laid_out and self.is_attached):
            return  # not laid out yet, or already being taken down
        app, width = self.watching, self.size.width
        texts = {
            "title": watch_words.title(app.arm_name, view, width),
            "banner": f"NOT WATCHED ANY MORE: {ended}" if ended else "",
            "watched": watch_words.lines(view),
            "remarks": f"! {message}" if message else "",
            "footer": app.keys.footer("watch", width),
        }
        for name, text in texts.items():
            self.query_one(f"#{name}", PlainText).show(text)
        self.query_one("#banner").set_class(bool(ended), "-shown")
        real = bool(view) and not view.get("simulated")
        self.query_one("#title").set_class(real, "-real")
        self.query_one(SpaceView).show(moment(view, app.model))


def moment(view: watch_words.View, model: ArmModel) -> Moment:
    """Return what is to be drawn of what another program says of its arm."""
    names, told = model.arm.joint_names, view.get("joints")
    if not isinstance(told, dict) or set(told) != {f"{name}_deg" for name in names}:
        return Moment()
    values = [told[f"{name}_deg"] for name in names]
    if not all(isinstance(value, int | float) for value in values):
        return Moment()
    opening = view.get("gripper_mm")
    joints = Joints(tuple(math.radians(value) for value in values), names)
    return Moment(joints, float(opening) if isinstance(opening, int | float) else None)
