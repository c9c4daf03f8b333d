"""The desk of a model: a named system or a link table, jogged with no arm connected at all."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import ClassVar, cast

from textual.app import ComposeResult
from textual.binding import BindingType
from textual.screen import Screen

from kinematics.textbook.stepping import axes_of, axis_unit, has_inverse, step_axis, step_joint
from kinematics.textbook.study import Study, Subject, example_posture, study
from tui.app import KeyApp
from tui.arm_view import SpaceView
from tui.keys.keyboard import DEFAULT_KEYS, Keyboard, bindings_of
from tui.keys.table import STOP, VIEW_KEYS, DeskKey, JogPair, pairs_of, words
from tui.settings import INCREMENTS, memory_file, neighbour, recall
from tui.terminal import draws_braille
from tui.theory import TheoryPanel, axis_rows, joint_rows
from tui.widgets import PlainText, fill_frame, framed, text_of

# The keyboard of a model: the rows of the desk's table that make sense with no arm.

PLACE = "theory"
"""The place of all rows of a model's keyboard."""

KEPT = ("mode", "finer", "coarser", *(row.id for row in VIEW_KEYS))
"""Rows by id; those that jog, and those of the theory, are kept too."""

NOTHING_TO_STOP = "Close a dialog. There is nothing to stop: no arm is connected."

_OWN_PLACES = ("theory", "model")


class ModelKeyboard(Keyboard):
    """A keyboard on which nothing has to be armed."""

    __slots__ = ()

    def _jog_help(self, pairs: Sequence[JogPair]) -> Iterator[str]:
        yield "Jog keys: each press is one step, at once; nothing is armed, as nothing moves."
        for pair in pairs:
            keys = f"{self.jog(pair.plus)} {self.jog(pair.minus)}"
            hand = f"of the hand: {pair.cartesian}" if pair.cartesian else ""
            joint = f"joint {words(pair.joint)}" if pair.joint else ""
            yield f"{keys:<17} {', '.join(filter(None, (joint, hand)))}, + and -"


def model_keys(keys: Keyboard = DEFAULT_KEYS) -> ModelKeyboard:
    """Return the rows of a keyboard that a model has, with the keys that they have there."""
    return ModelKeyboard(tuple(_rows(keys)))


def _rows(keys: Keyboard) -> Iterator[DeskKey]:
    for row in keys.rows:
        if row.id == STOP:
            yield replace(row, description="", tooltip=NOTHING_TO_STOP)
        elif row.id == "quit":
            yield replace(row, tooltip="Leave the model.")
        elif row.id in ("help", "help-close"):
            yield row
        elif row.id in KEPT or row.place in _OWN_PLACES or row.jogs:
            yield replace(row, place=PLACE)


# The hand on a model: its posture, and what each key makes of it. Pure: it knows no screen.


@dataclass(slots=True)
class ModelHand:
    """A model in a posture, and what its keys move."""

    subject: Subject
    values: tuple[float, ...] = ()
    cartesian: bool = False
    increment: float = 5.0
    """One step, in degrees or mm."""
    pairs: tuple[JogPair, ...] = field(init=False)
    axes: tuple[str, ...] = field(init=False)

    def __post_init__(self) -> None:
        self.values = self.values or example_posture(self.subject.chain)
        self.axes = axes_of(self.subject)
        self.pairs = pairs_of(self.subject.chain.joint_names, self.axes)

    @property
    def study(self) -> Study:
        """The results for the present posture."""
        return study(self.subject, self.values)

    @property
    def way(self) -> str:
        """Say what the keys move, and how."""
        if not self.cartesian:
            return "joints"
        return "the hand, by closed form" if has_inverse(self.subject) else "the hand, by Jacobian"

    def press(self, key: str) -> str:
        """Make the step of a jog key; return what it could not do."""
        pair = next((each for each in self.pairs if key in (each.plus, each.minus)), None)
        name = "" if pair is None else pair.axis(cartesian=self.cartesian)
        if pair is None or not name:
            return "this model has no axis for that key"
        sign = 1.0 if key == pair.plus else -1.0
        if self.cartesian:
            by = sign * self._amount(axis_unit(name))
            stepped = step_axis(self.subject, self.values, self.axes.index(name), by)
        else:
            chain = self.subject.chain
            joint = chain.joint_names.index(name)
            by = sign * self._amount(chain.kinds[joint].unit)
            stepped = step_joint(self.subject, self.values, joint, by)
        self.values = stepped.values
        return stepped.message

    def next_solution(self) -> str:
        """Go on to the next solution within the limits; return its name, or why there is none."""
        of = self.study
        if of.refusal:
            return of.refusal
        after = -1 if of.here is None else of.here
        order = [*of.branches[after + 1 :], *of.branches[: max(after, 0)]]
        taken = next((branch for branch in order if branch.within_limits), None)
        if taken is None:
            return "no other solution is within the limits"
        self.values = taken.joints
        return f"the same pose of the hand by {taken.name}"

    def zero(self) -> str:
        """Put every joint at zero, or at the limit nearest to it."""
        chain = self.subject.chain
        self.values = chain.clamp(chain.zero)
        moved = "" if self.values == chain.zero else ", or at the limit nearest to it"
        return f"every joint at zero{moved}"

    def switch_mode(self) -> None:
        """Switch between joints and the hand."""
        self.cartesian = not self.cartesian

    def change_step(self, by: int) -> None:
        """Make the increment smaller or larger."""
        self.increment = neighbour(INCREMENTS, self.increment, by)

    def _amount(self, unit: str) -> float:
        return math.radians(self.increment) if unit == "rad" else self.increment


NO_ARM = "MODEL ONLY: no arm is connected"


class ModelScreen(Screen[None]):
    """A model, its theory, and the keys that move it."""

    place = PLACE
    AUTO_FOCUS = ""
    BINDINGS: ClassVar[list[BindingType]] = bindings_of(
        row for row in model_keys().rows if row.place == PLACE
    )

    def __init__(self) -> None:
        super().__init__()
        self.adjustments = self.desk.hand

    @property
    def desk(self) -> ModelDesk:
        """The app that the screen belongs to."""
        return cast("ModelDesk", self.app)

    def compose(self) -> ComposeResult:
        """Lay the title, the theory, a remark and the keys out."""
        panel = TheoryPanel(self.desk.hand.subject, self._numbers, braille=self.desk.braille)
        yield from framed([PlainText(id="title")], [panel])

    def on_mount(self) -> None:
        """Show the model as soon as there is room to show it in."""
        self.call_after_refresh(self.show)

    def on_resize(self) -> None:
        """Fit everything to the new size."""
        self.call_after_refresh(self.show)

    @property
    def panel(self) -> TheoryPanel:
        """The panel that shows the theory."""
        return self.query_one(TheoryPanel)

    def show(self) -> None:
        """Show the model as it stands."""
        if not self.is_attached:
            return
        desk, width = self.desk, self.size.width
        size = f"{desk.hand.increment:g}"
        step = f"one step is {size}\N{DEGREE SIGN} or {size} mm; keys move {desk.hand.way}"
        text_of(self, "title").show(f"{NO_ARM}. {desk.hand.subject.title}"[:width].ljust(width))
        message = f"{step}\n{desk.message}" if desk.message else step
        fill_frame(self, message, desk.keys.next_keys(PLACE))
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

    # -- keys ---------------------------------------------------------------------------------

    def action_jog(self, key: str) -> None:
        """Make one step of the model."""
        self.desk.say(self.desk.hand.press(key))

    def action_solution(self) -> None:
        """Go on to the next solution for the same place of the hand."""
        self.desk.say(self.desk.hand.next_solution())

    def action_zero(self) -> None:
        """Put every joint at zero."""
        self.desk.say(self.desk.hand.zero())

    def action_view(self, what: str) -> None:
        """Look at the model from elsewhere."""
        self.query_one(SpaceView).look(what)


class ModelDesk(KeyApp):
    """One model, and no arm: nothing here can be stopped, for nothing moves."""

    TITLE = "armdrive"
    BINDINGS: ClassVar[list[BindingType]] = bindings_of(
        row for row in model_keys().rows if not row.place
    )
    keys_bound = model_keys().rows

    def __init__(
        self, subject: Subject, *, braille: bool, keys: Keyboard = DEFAULT_KEYS, look: str = ""
    ) -> None:
        super().__init__(model_keys(keys), braille=braille, look=look)
        self.hand = ModelHand(subject)
        self.pairs = self.hand.pairs

    def get_default_screen(self) -> ModelScreen:
        """Return the only screen."""
        return ModelScreen()

    def show(self) -> None:
        """Show the model as it stands."""
        cast("ModelScreen", self.screen_stack[0]).show()

    def action_stop_arm(self) -> None:
        """Close what lies over the model, and say that nothing moves."""
        self.dialogs.close_all()
        self.say("there is nothing to stop: no arm is connected")

    def action_leave(self) -> None:
        """End it."""
        self.exit(0)


def run_model(subject: Subject, *, ascii_only: bool = False, keys: Keyboard = DEFAULT_KEYS) -> int:
    """Show a model until the user leaves it, and return the exit code."""
    braille = draws_braille(ascii_only=ascii_only)
    desk = ModelDesk(subject, braille=braille, keys=keys, look=recall(memory_file()).look)
    desk.run_or_raise()
    return desk.return_code or 0
