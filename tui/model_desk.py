"""The desk of a model: a named system or a link table, jogged with no arm connected at all.

It shows the model in space, and beside it what `armdrive explain` prints of the same posture.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import ClassVar, cast

from textual.app import ComposeResult
from textual.binding import BindingType
from textual.containers import Horizontal, Vertical
from textual.screen import Screen

from armdrive.render.canvas import draws_braille
from armdrive.render.figure import ChainFigure, DrawnChain
from armdrive.render.scene import Moment
from kinematics.presets import ArmModel
from kinematics.text import deg_text, folded, shown_name
from kinematics.textbook.stepping import coordinates_of, step_axis, step_joint
from kinematics.textbook.study import Study, Subject, example_posture, study
from kinematics.textbook.systems.named import frame_coordinates
from kinematics.textbook.worked_example import ExampleSection, measures, sections
from tui.app import KeyApp
from tui.arm_view import SpaceView
from tui.axes import DEGREE, NAME_WIDTH, AxisRow, AxisTable
from tui.keys.keyboard import DEFAULT_KEYS, Keyboard, bindings_of
from tui.keys.table import STOP, VIEW_KEYS, DeskKey, JogPair, pairs_of, spoken
from tui.settings import INCREMENTS, memory_file, neighbour, recall
from tui.widgets import PlainText, fill_frame, framed, text_of

# The keyboard of a model: the rows of the desk's table that make sense with no arm.

PLACE = "model"
"""The place of all rows of a model's keyboard."""

KEPT = ("mode", "finer", "coarser", *(row.id for row in VIEW_KEYS))
"""Rows by id; those that jog, and those of a model alone, are kept too."""

NOTHING_TO_STOP = "Close a dialog. There is nothing to stop: no arm is connected."


class ModelKeyboard(Keyboard):
    """A keyboard on which nothing has to be armed."""

    def _jog_help(self, pairs: Sequence[JogPair]) -> Iterator[str]:
        yield "Jog keys: each press is one step, at once; nothing is armed, as nothing moves."
        for pair in pairs:
            keys = f"{self.jog(pair.plus)} {self.jog(pair.minus)}"
            hand = f"of the hand: {pair.cartesian}" if pair.cartesian else ""
            joint = f"joint {shown_name(pair.joint)}" if pair.joint else ""
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
        elif row.id in KEPT or row.place == PLACE or row.jogs:
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


# What is shown: the model in space with its numbers, and the pages of its worked example.

NO_ARM = "MODEL ONLY: no arm is connected"

COLUMN_WIDTH, MOST_COLUMNS = 44, 3
"""A column of a page holds any matrix of six joints."""

LEAST_VIEW_WIDTH = 34

Column = tuple[str, ...]

RULE, PLAIN_RULE = "\N{BOX DRAWINGS LIGHT HORIZONTAL}", "-"


class ModelScreen(Screen[None]):
    """A model, its worked example, and the keys that move it."""

    place = PLACE
    AUTO_FOCUS = ""
    BINDINGS: ClassVar[list[BindingType]] = bindings_of(
        row for row in model_keys().rows if row.place == PLACE
    )

    def __init__(self) -> None:
        super().__init__()
        self.adjustments = self.desk.hand
        self.page = 0
        self._columns: tuple[Column, ...] = ((),)
        """What is computed of the posture, laid out for the present height."""
        self._figure = ChainFigure(self.desk.hand.subject.chain)

    @property
    def desk(self) -> ModelDesk:
        """The app that the screen belongs to."""
        return cast("ModelDesk", self.app)

    def compose(self) -> ComposeResult:
        """Lay the title, the model, its pages, a remark and the keys out."""
        yield from framed([PlainText(id="title")], [Horizontal(*self._body(), id="model")])

    def _body(self) -> Iterator[Vertical | PlainText]:
        drawn = cast("ArmModel", DrawnChain(self._figure))  # a view asks for no more than it has
        yield Vertical(
            SpaceView(drawn, braille=self.desk.braille, id="model-space"),
            *(self._table(name) for name in ("joints", "hand")),
            PlainText(id="model-summary"),
            id="model-left",
        )
        for place in range(MOST_COLUMNS):
            yield PlainText(id=f"model-page-{place}").add_class("model-page")

    def on_mount(self) -> None:
        """Show the model as soon as there is room to show it in."""
        self.call_after_refresh(self.show)

    def on_resize(self) -> None:
        """Fit everything to the new size."""
        self.call_after_refresh(self.show)

    def show(self) -> None:
        """Show the model as it stands."""
        if not self.is_attached:
            return
        desk, width = self.desk, self.size.width
        hand, of = desk.hand, desk.hand.study
        size = f"{hand.increment:g}"
        moved = "the hand" if hand.cartesian else "joints"
        step = f"one step is {size}\N{DEGREE SIGN} or {size} mm; keys move {moved}"
        text_of(self, "title").show(f"{NO_ARM}. {hand.subject.title}"[:width].ljust(width))
        message = f"{step}\n{desk.message}" if desk.message else step
        fill_frame(self, message, desk.keys.next_keys(PLACE))
        self.query_one(SpaceView).show(Moment(self._figure.joints(of.values)))
        self._show_axes("joints", joint_rows(of, hand), driven=not hand.cartesian)
        self._show_axes("hand", axis_rows(of, hand), driven=hand.cartesian)
        text_of(self, "model-summary").show(self._spoken(_summary(of)))
        shown = (one for one in sections(of) if one.title != "Figure")
        height = self.query_one("#model").size.height
        self._columns = laid(shown, COLUMN_WIDTH - 1, height, plain=not desk.braille)
        self._show_pages()

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

    # -- pages --------------------------------------------------------------------------------

    @property
    def pages(self) -> int:
        """How many pages there are at the present size."""
        return -(-len(self._columns) // self._at_once)

    @property
    def _at_once(self) -> int:
        """How many columns are shown side by side."""
        room = (self.size.width - LEAST_VIEW_WIDTH) // COLUMN_WIDTH
        return min(max(room, 1), MOST_COLUMNS)

    def _show_pages(self) -> None:
        count, columns = self._at_once, self._columns
        self.page = min(self.page, self.pages - 1)
        for place in range(MOST_COLUMNS):
            text = text_of(self, f"model-page-{place}")
            text.display = place < count
            at = self.page * count + place
            text.show(self._spoken("\n".join(columns[at])) if at < len(columns) else "")

    def _spoken(self, text: str) -> str:
        """Return a text with the joints as people write them; its columns stay what they are."""
        return spoken(text, self.desk.hand.subject.chain.joint_names)

    # -- keys ---------------------------------------------------------------------------------

    def action_page(self, by: int) -> None:
        """Turn this many pages on; after the last comes the first."""
        self.page = (self.page + by) % self.pages
        self._show_pages()

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


def _summary(of: Study) -> str:
    """Return how well the posture moves and its nearest singularity, in one line."""
    turning = [one for one in of.singularities if one.distance_rad is not None]
    near = min(turning, key=lambda one: one.distance_rad or 0.0, default=None)
    if near is None or near.distance_rad is None:
        return measures(of)
    away = deg_text(math.degrees(near.distance_rad))
    return f"{measures(of)}; singular {away} away: {near.reason}"


def laid(
    parts: Iterable[ExampleSection], width: int, height: int, *, plain: bool = False
) -> tuple[Column, ...]:
    """Return the columns that hold all sections in order, none higher than `height` lines.

    Words are broken to the width; rows of matrices stay as they are. A section that does not fit
    in what is left begins a column of its own, unless it would not fit in a whole one either: then
    it begins at once and goes on in the next.
    """
    height = max(height, 2)
    rule = PLAIN_RULE if plain else RULE
    columns: list[list[str]] = [[]]
    for part in parts:
        lines = [f"{rule}{rule} {part.title} ".ljust(width, rule)[:width]]
        for line in part.lines:
            lines += [line] if "[ " in line else folded(line, max(width, 1))
        left = height - len(columns[-1])
        if len(lines) > left and (len(lines) <= height or left < height // 2):
            columns.append([])
        for line in lines:
            if len(columns[-1]) == height:
                columns.append([])
            columns[-1].append(line)
    return tuple(map(tuple, columns))


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
    BINDINGS: ClassVar[list[BindingType]] = bindings_of(
        row for row in model_keys().rows if not row.place
    )
    keys_bound = model_keys().rows

    def __init__(
        self, subject: Subject, *, braille: bool, keys: Keyboard = DEFAULT_KEYS, look: str = ""
    ) -> None:
        super().__init__(model_keys(keys), braille=braille, look=look)
        self.input.suspended_s = math.inf  # it does not poll, and seems idle between two keys
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
