"""The desk of a model: a named system or a link table, jogged with no arm connected at all."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Mapping
from typing import ClassVar, cast

from textual.app import ComposeResult
from textual.binding import BindingType
from textual.containers import Container
from textual.screen import Screen

from armdrive.render.canvas import can_braille
from kinematics.textbook.study import Study, Subject
from tui.dialogs import HelpScreen
from tui.framework import FirstKeys, PlainText
from tui.keyboard import DEFAULT_KEYS, Keyboard
from tui.layout import CSS, bindings_of
from tui.model_hand import ModelHand
from tui.model_keys import PLACE, model_keys
from tui.model_tables import axis_rows, joint_rows
from tui.widgets.arm_view import SpaceView
from tui.widgets.theory_panel import TheoryPanel

NO_ARM = "MODEL ONLY: no arm is connected"


class ModelScreen(Screen[None]):
    """A model, its theory, and the keys that move it."""

    AUTO_FOCUS = ""
    BINDINGS: ClassVar[list[BindingType]] = bindings_of(
        row for row in model_keys().rows if row.place == PLACE
    )

    @property
    def desk(self) -> ModelDesk:
        """The app that the screen belongs to."""
        return cast("ModelDesk", self.app)

    def compose(self) -> ComposeResult:
        """Lay the title, the theory, a remark and the keys out."""
        yield PlainText(id="title")
        with Container(id="body"):
            yield TheoryPanel(self.desk.hand.subject, self._numbers, braille=self.desk.braille)
        yield PlainText(id="remarks")
        yield PlainText(id="footer")

    def on_mount(self) -> None:
        """Show the model as soon as there is room to show it in."""
        self.call_after_refresh(self.show)

    def on_resize(self) -> None:
        """Fit everything to the new size."""
        self.call_after_refresh(self.show)

    @property
    def panel(self) -> TheoryPanel:
        """What shows the theory."""
        return self.query_one(TheoryPanel)

    def show(self) -> None:
        """Show the model as it stands."""
        if not self.is_attached:
            return
        desk, width = self.desk, self.size.width
        step = f"step {desk.hand.increment:g}\N{DEGREE SIGN}/mm, keys move {desk.hand.way}"
        self._text("title").show(f"{NO_ARM}. {desk.hand.subject.title}"[:width].ljust(width))
        self._text("remarks").show(f"{step}\n! {desk.said}" if desk.said else step)
        self._text("footer").show(desk.keys.footer(PLACE, width))
        self.panel.show(desk.hand.study)

    def _numbers(self, of: Study, width: int) -> str:
        desk = self.desk
        hand, keys = desk.hand, desk.keys
        return "\n".join(
            (
                joint_rows(of, width, None if hand.cartesian else keys, hand.pairs),
                axis_rows(of, hand.axes, keys if hand.cartesian else None, hand.pairs),
            )
        )

    def _text(self, name: str) -> PlainText:
        return self.query_one(f"#{name}", PlainText)

    # -- keys ---------------------------------------------------------------------------------

    def action_jog(self, key: str) -> None:
        """Make one step of the model."""
        self.desk.say(self.desk.hand.press(key))

    def action_mode(self) -> None:
        """Switch between joints and the hand."""
        self.desk.hand.cartesian = not self.desk.hand.cartesian
        self.desk.say("")

    def action_finer(self) -> None:
        """Make the increment smaller."""
        self.desk.hand.coarser(-1)
        self.desk.say("")

    def action_coarser(self) -> None:
        """Make the increment larger."""
        self.desk.hand.coarser(1)
        self.desk.say("")

    def action_solution(self) -> None:
        """Go on to the next solution for the same place of the hand."""
        self.desk.say(self.desk.hand.next_solution())

    def action_zero(self) -> None:
        """Put every joint at zero."""
        self.desk.say(self.desk.hand.zero())

    def action_view(self, what: str) -> None:
        """Look at the model from elsewhere."""
        self.query_one(SpaceView).look(what)

    def action_turn(self, by: int) -> None:
        """Turn pages."""
        self.panel.turn(by)

    def action_symbols(self) -> None:
        """Switch between numbers and symbols."""
        self.panel.switch_symbols()


class ModelDesk(FirstKeys):
    """One model, and no arm: nothing here can be stopped, for nothing moves."""

    ENABLE_COMMAND_PALETTE = False
    TITLE = "armdrive"
    BINDINGS: ClassVar[list[BindingType]] = bindings_of(
        row for row in model_keys().rows if not row.place
    )
    CSS = CSS

    def __init__(self, subject: Subject, *, braille: bool, keys: Keyboard = DEFAULT_KEYS) -> None:
        super().__init__()
        self.hand = ModelHand(subject)
        self.braille = braille
        self.keys = model_keys(keys)
        self.said = ""

    def get_default_screen(self) -> ModelScreen:
        """Return the only screen."""
        return ModelScreen()

    def on_mount(self) -> None:
        """Take the keys of the user's own file."""
        self.set_keymap(self.keys.keymap(model_keys().rows))

    def say(self, message: str) -> None:
        """Show the model with a remark; an empty one takes the last away."""
        self.said = message
        cast("ModelScreen", self.screen_stack[0]).show()

    def first_keys(self) -> Mapping[str, Callable[[], None]]:
        """Return what no widget may keep for itself, as on the desk of an arm."""
        return dict.fromkeys(self.keys.of("stop"), self.action_stop_arm)

    def action_stop_arm(self) -> None:
        """Close what lies over the model, and say that nothing moves."""
        while len(self.screen_stack) > 1:
            self.pop_screen()
        self.say("there is nothing to stop: no arm is connected")

    def action_help(self) -> None:
        """Show all keys."""
        self.push_screen(HelpScreen(self.keys, PLACE, self.hand.pairs))

    def action_leave(self) -> None:
        """End it."""
        self.exit(0)


def run_model(subject: Subject, *, ascii_only: bool = False, keys: Keyboard = DEFAULT_KEYS) -> int:
    """Show a model until somebody leaves it, and return the exit code."""
    braille = not ascii_only and can_braille(sys.stdout.encoding, os.environ)
    desk = ModelDesk(subject, braille=braille, keys=keys)
    desk.run_or_raise()
    return desk.return_code or 0
