"""The desk of a model: a named system or a link table, jogged with no arm connected at all.

It shows the model in space, and beside it what `armdrive explain` prints of the same posture.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from typing import ClassVar, cast

from textual import events, on
from textual.app import ComposeResult
from textual.binding import BindingType
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.screen import Screen

from armdrive.render.canvas import draws_braille
from armdrive.render.figure import ChainFigure, DrawnChain
from armdrive.render.scene import Moment
from kinematics.presets import ArmModel
from kinematics.text import deg_text, shown_name
from kinematics.textbook.stepping import coordinates_of, step_axis, step_joint
from kinematics.textbook.study import Study, Subject, example_posture, study
from kinematics.textbook.systems.named import frame_coordinates
from kinematics.textbook.worked_example import measures, sections
from tui.app import KeyApp
from tui.arm_view import SpaceView
from tui.axes import DEGREE, NAME_WIDTH, AxisRow, AxisTable
from tui.keys.keyboard import DEFAULT_KEYS, MODEL, Keyboard, bindings
from tui.keys.table import STOP, VIEW_KEYS, JogPair, pairs_of, spoken
from tui.settings import INCREMENTS, memory_file, neighbour, recall
from tui.widgets import PlainText, Span, fill_frame, framed, text_of

# The keyboard of a model: the rows of the desk's table that make sense with no arm.

# The rows of every screen that count here too.
COMMON = (STOP, "quit", "help", *(row.id for row in VIEW_KEYS))

NOTHING_TO_STOP = "Close a dialog. There is nothing to stop: no arm is connected."


def model_keys(keys: Keyboard = DEFAULT_KEYS) -> Keyboard:
    """Return the rows of a keyboard that a model has, with the keys that they have there."""
    words = {STOP: NOTHING_TO_STOP, "quit": "Leave the model."}
    rows = keys.only(MODEL, (*COMMON, "close")).rows
    return Keyboard(
        tuple(
            replace(
                row,
                description="" if row.id == STOP else row.description,
                tooltip=words.get(row.id, row.tooltip),
            )
            for row in rows
        )
    )


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
    axes: tuple[tuple[str, str], ...] = field(init=False)
    """Names and units of the hand's coordinates."""
    held_button: str = ""
    """No cap is ever held: pressing one makes a step, as its key does."""

    def __post_init__(self) -> None:
        self.values = self.values or example_posture(self.subject.chain)
        named = (name.rpartition("_") for name in coordinates_of(self.subject))
        self.axes = tuple((name, unit) for name, _, unit in named)
        names = tuple(name for name, _ in self.axes)
        self.pairs = pairs_of(self.subject.chain.joint_names, names)

    @property
    def study(self) -> Study:
        """The results for the present posture."""
        return study(self.subject, self.values)

    def press(self, key: str) -> str:
        """Make the step of a jog key; return what it could not do."""
        pair = next((each for each in self.pairs if key in (each.plus, each.minus)), None)
        name = "" if pair is None else pair.axis(cartesian=self.cartesian)
        if pair is None or not name:
            return "this model has no axis for that key"
        sign = 1.0 if key == pair.plus else -1.0
        if self.cartesian:
            axis = [each for each, _ in self.axes].index(name)
            by = sign * self._amount(self.axes[axis][1])
            stepped = step_axis(self.subject, self.values, axis, by)
        else:
            chain = self.subject.chain
            joint = chain.joint_names.index(name)
            by = sign * self._amount(chain.kinds[joint].unit)
            stepped = step_joint(self.subject, self.values, joint, by)
        self.values = stepped.values
        return stepped.message

    def pair_of(self, name: str) -> JogPair | None:
        """Return the letters that move a joint or a coordinate; None if there are none left."""
        letters = (pair for pair in self.pairs if not pair.is_arrow)
        return next((one for one in letters if one.axis(cartesian=self.cartesian) == name), None)

    def moved(self) -> None:
        """Do nothing: the mouse holds nothing."""

    def lift(self) -> None:
        """Do nothing: the mouse holds nothing."""

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


# What is shown: the model in space with its numbers, and its worked example.

NO_ARM = "MODEL ONLY: no arm is connected"


class ModelScreen(Screen[None]):
    """A model, its worked example, and the keys that move it."""

    AUTO_FOCUS = ""
    place = MODEL
    BINDINGS: ClassVar[list[BindingType]] = bindings(MODEL)

    def __init__(self) -> None:
        super().__init__()
        hand = self.desk.hand
        self.action_switch_mode, self.action_change_step = hand.switch_mode, hand.change_step
        self.action_next_solution, self.action_zero = hand.next_solution, hand.zero
        self.action_turn_page = self.desk.action_scroll
        self._figure = ChainFigure(hand.subject.chain)

    @property
    def desk(self) -> ModelDesk:
        """The app that the screen belongs to."""
        return cast("ModelDesk", self.app)

    def compose(self) -> ComposeResult:
        """Lay the screen out: the model on the left, its worked example on the right."""
        drawn = cast("ArmModel", DrawnChain(self._figure))  # a view asks for no more than it has
        left = Vertical(
            SpaceView(drawn, braille=self.desk.braille, id="model-space"),
            *(self._table(name) for name in ("joints", "hand")),
            PlainText(id="model-summary"),
            id="model-left",
        )
        example = VerticalScroll(PlainText(id="example"), id="model-right", can_focus=False)
        yield from framed([PlainText(id="title")], [Horizontal(left, example, id="model")])

    @on(events.Mount)
    @on(events.Resize)
    def _show_soon(self) -> None:
        """Show the model, fitted to the size."""
        self.call_after_refresh(self.desk.show)

    def show(self) -> None:
        """Show the model as it stands."""
        desk, width = self.desk, self.size.width
        hand, of = desk.hand, desk.hand.study
        size = f"{hand.increment:g}"
        moved = "the hand" if hand.cartesian else "joints"
        step = f"one step is {size}\N{DEGREE SIGN} or {size} mm; keys move {moved}"
        text_of(self, "title").show(f"{NO_ARM}. {hand.subject.title}"[:width].ljust(width))
        message = f"{step}\n{desk.message}" if desk.message else step
        fill_frame(self, message, desk.keys.next_keys(MODEL))
        self.query_one(SpaceView).show(Moment(self._figure.joints(of.values)))
        self._show_axes("joints", joint_rows(of, hand), driven=not hand.cartesian)
        self._show_axes("hand", axis_rows(of, hand), driven=hand.cartesian)
        text_of(self, "model-summary").show(self._spoken(_summary(of)))
        text_of(self, "example").show(*self._example(of))

    def _example(self, of: Study) -> Iterator[Span]:
        """Yield the worked example, section by section; words are broken, matrices fit."""
        for part in sections(of):
            if part.title != "Figure":
                yield f"{part.title}\n", "bold $text-primary"
                yield self._spoken("\n".join([*part.lines, "", ""])), ""

    def _table(self, name: str) -> AxisTable:
        hand = self.desk.hand
        width = max(len(shown_name(each)) for each in hand.subject.chain.joint_names)
        return AxisTable(
            hand,
            self.action_jog,
            cap=self.desk.keys.jog,
            id=name,
            name_width=min(width, NAME_WIDTH),
        )

    def _show_axes(self, name: str, rows: Iterable[AxisRow], *, driven: bool) -> None:
        """Show a table of axes; on a small terminal only the one that the keys move."""
        table, mode = self.query_one(f"#{name}", AxisTable), self.desk.keys.label("mode")
        table.show_axes(tuple(rows))
        table.set_titles(name.capitalize(), "" if driven else f"{mode}: keys move the {name}")
        table.set_class(driven, "-driven")
        table.display = driven or not self.has_class("-short")

    def _spoken(self, text: str) -> str:
        """Return a text with the joints as people write them; its columns stay what they are."""
        return spoken(text, self.desk.hand.subject.chain.joint_names)

    # -- keys ---------------------------------------------------------------------------------

    def action_jog(self, key: str) -> None:
        """Make one step of the model."""
        self.desk.say(self.desk.hand.press(key))


def _summary(of: Study) -> str:
    """Return how well the posture moves and its nearest singularity, in one line."""
    turning = [one for one in of.singularities if one.distance_rad is not None]
    near = min(turning, key=lambda one: one.distance_rad or 0.0, default=None)
    if near is None or near.distance_rad is None:
        return measures(of)
    away = deg_text(math.degrees(near.distance_rad))
    return f"{measures(of)}; singular {away} away: {near.reason}"


# Joints and coordinates of a posture, as rows of a table of axes.


def joint_rows(of: Study, hand: ModelHand) -> Iterator[AxisRow]:
    """Yield a row for each joint: its keys if these move joints, its value between its limits."""
    chain = of.subject.chain
    rows = zip(chain.joint_names, of.values, chain.kinds, chain.limits, strict=True)
    for name, value, kind, limits in rows:
        (shown, unit), (low, _), (high, _) = (
            as_shown(each, kind.unit) for each in (value, *limits)
        )
        ends = (low, high) if math.isfinite(low) and math.isfinite(high) else None
        pair = None if hand.cartesian else hand.pair_of(name)
        yield AxisRow(name, shown, unit, ends, pair)


def axis_rows(of: Study, hand: ModelHand) -> Iterator[AxisRow]:
    """Yield a row for each coordinate of the hand: its keys if these move it, and its value."""
    goal = of.goal or frame_coordinates(of.frame)
    for (name, unit), value in zip(hand.axes, goal, strict=False):
        pair = hand.pair_of(name) if hand.cartesian else None
        yield AxisRow(name, *as_shown(value, unit), None, pair)


def as_shown(value: float, unit: str) -> tuple[float, str]:
    """Return a value as people read it, and its unit: angles are in degrees."""
    return (math.degrees(value), DEGREE) if unit == "rad" else (value, unit)


class ModelDesk(KeyApp):
    """One model, and no arm: nothing here can be stopped, for nothing moves."""

    TITLE = "armdrive"
    BINDINGS: ClassVar[list[BindingType]] = bindings("", COMMON)
    keys_bound = model_keys().rows

    def __init__(
        self, subject: Subject, *, braille: bool, keys: Keyboard = DEFAULT_KEYS, look: str = ""
    ) -> None:
        super().__init__(model_keys(keys), braille=braille, look=look)
        self.input.fresh.suspended_s = math.inf  # it does not poll, and seems idle between two keys
        self.hand = ModelHand(subject)
        self.pairs = self.hand.pairs

    def get_default_screen(self) -> ModelScreen:
        """Return the only screen."""
        return ModelScreen()

    def action_stop_arm(self) -> None:
        """Close what lies over the model, and say that nothing moves."""
        self.close_dialogs()
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
