"""The theory of a posture: the arm in space, its joints, and pages of matrices.

The theory screen says what the lecture notes say of the arm as it stands. It moves nothing.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from itertools import zip_longest
from typing import ClassVar, cast

from textual.app import ComposeResult
from textual.binding import BindingType
from textual.containers import Horizontal, Vertical
from textual.geometry import Size

from armdrive.render.camera import Dome
from armdrive.render.figure import ChainFigure, DrawnChain
from armdrive.render.frame_steps import StepDrawing
from armdrive.render.scene import Moment, SceneSpace
from armdrive.status import Status
from kinematics.chains.assignment import assign_frames
from kinematics.chains.links import Convention, JointKind
from kinematics.presets import ArmModel
from kinematics.text import rounded
from kinematics.textbook.pages import Column, laid, sections, summary, symbol_sections, wrapped
from kinematics.textbook.stepping import axes_of
from kinematics.textbook.study import Study, Subject, searched, study, subject_of_arm
from kinematics.textbook.systems.named import NamedSingularity
from kinematics.textbook.thirteen_steps import assignment_steps, axes_lines, result_lines
from kinematics.textbook.worked_example import ExampleSection
from tui.app import HoldAlarm, Job, KeyApp
from tui.arm_view import SpaceView
from tui.axes import bar
from tui.desk import DeskScreen
from tui.keys.keyboard import Keyboard, bindings
from tui.keys.table import JogPair, spoken, words
from tui.widgets import PlainText, text_of

Numbers = Callable[[Study, int], str]

COLUMN_WIDTH, MOST_COLUMNS = 43, 3
"""A column of a page holds any matrix of six joints."""

LEAST_VIEW_WIDTH = 34

REST_S = 0.5
"""A posture that has been shown for this long is at rest."""

WORKING = ExampleSection("in symbols", ("working them out: it takes a moment",))


class TheoryPanel(Horizontal):
    """Shows a study, and works out in a thread what takes long. It moves nothing and knows no arm.

    `numbers` writes the rows of joints and coordinates for a width.
    """

    def __init__(self, subject: Subject, numbers: Numbers, *, braille: bool) -> None:
        super().__init__(id="theory")
        self.subject = subject
        self.page = 0
        self.symbolic = False
        self._walk: AxesWalk | None = None
        self._numbers = numbers
        self._braille = braille
        self._figure = ChainFigure(subject.chain)
        self._joint_names = subject.chain.joint_names
        self._study: Study | None = None
        self._symbols: tuple[ExampleSection, ...] | None = None
        self._writing = Job()
        self._near: tuple[tuple[float, ...], tuple[NamedSingularity, ...]] = ((), ())
        self._searching = Job()
        app = cast("KeyApp", self.app)
        self._calls = app.calls
        self._rests = HoldAlarm(app, self.look_now)

    def compose(self) -> ComposeResult:
        """Lay the arm and its numbers out on the left, the pages on the right."""
        drawn = cast("ArmModel", DrawnChain(self._figure))  # a view asks for no more than it has
        with Vertical(id="theory-left"):
            yield SpaceView(drawn, braille=self._braille, id="theory-space")
            yield PlainText(id="theory-numbers")
            yield PlainText(id="theory-summary")
        for place in range(MOST_COLUMNS):
            yield PlainText(id=f"theory-page-{place}").add_class("theory-page")

    @property
    def _left_size(self) -> Size:
        return self.query_one("#theory-left").size

    @property
    def room(self) -> tuple[Size, Size]:
        """The sizes that decide what is shown: of the panel, and of its left part."""
        return self.size, self._left_size

    # -- what is shown ------------------------------------------------------------------------

    def show(self, of: Study | None) -> None:
        """Show a study; None while the posture is unknown."""
        before, self._study = self._study, of
        if of is not None and (before is None or of.values != before.values):
            self._look_soon(of)
        if not self.size:
            return
        joints = None if of is None else self._figure.joints(of.values)
        view = self.query_one(SpaceView)
        view.show(Moment(joints))
        view.show_drawing(None if self._walk is None else self._walk.drawing)
        walks = self._walk is not None  # it shows the zero posture, not the present one
        left = self._left_size.width
        numbers, short = text_of(self, "theory-numbers"), text_of(self, "theory-summary")
        numbers.display = short.display = not walks
        numbers.show("" if of is None else self._numbers(of, left))
        found = None if of is None else self._found(of)
        short.show("" if of is None else self._spoken(summary(of, found)))
        self._show_pages(of)

    def turn(self, by: int) -> None:
        """Turn this many pages or steps on; after the last comes the first."""
        if self._walk is not None:
            self._walk.turn(by)
            self._again()
            return
        pages = self.pages
        self.page = (self.page + by) % max(pages, 1)
        self._again()

    def switch_symbols(self) -> None:
        """Switch between numbers and symbols, from the first page on."""
        self._walk = None
        self.symbolic = not self.symbolic
        self.page = 0
        self._again()

    def switch_axes(self) -> None:
        """Go on to the steps from axes to link table, in both conventions, then to the numbers."""
        own = self.subject.chain.convention
        if self._walk is None:
            self._walk = AxesWalk(self.subject, own)
        elif self._walk.convention is own:
            other = next(one for one in Convention if one is not own)
            self._walk = AxesWalk(self.subject, other)
        else:
            self._walk = None
        self._again()

    @property
    def pages(self) -> int:
        """How many pages there are at the present size."""
        of = self._study
        return 0 if of is None else -(-len(self._columns(of)) // self._at_once)

    @property
    def _at_once(self) -> int:
        """How many columns are shown side by side."""
        room = (self.size.width - LEAST_VIEW_WIDTH) // COLUMN_WIDTH
        return min(max(room, 1), MOST_COLUMNS)

    def _show_pages(self, of: Study | None) -> None:
        count = self._at_once
        if self._walk is not None:
            plain = not self._braille
            count = max(count - 1, 1)  # the picture gets more room
            columns = self._walk.columns(COLUMN_WIDTH - 1, self.size.height, count, plain=plain)
            self._show_columns(columns, 0, count)
            return
        columns = () if of is None else self._columns(of)
        self.page = min(self.page, max(-(-len(columns) // count) - 1, 0))
        self._show_columns(columns, self.page * count, count)

    def _show_columns(self, columns: tuple[Column, ...], first: int, count: int) -> None:
        """Show `count` columns side by side, from column `first` on."""
        for place in range(MOST_COLUMNS):
            text = text_of(self, f"theory-page-{place}")
            text.display = place < count
            at = first + place
            text.show(self._spoken("\n".join(columns[at])) if at < len(columns) else "")

    def _spoken(self, text: str) -> str:
        """Return a text with the joints as people write them; its columns stay what they are."""
        return spoken(text, self._joint_names)

    def _columns(self, of: Study) -> tuple[Column, ...]:
        width = COLUMN_WIDTH - 1
        parts = self._in_symbols(of) if self.symbolic else sections(of, width, self._found(of))
        return laid(parts, width, self.size.height, plain=not self._braille)

    def _again(self) -> None:
        self.show(self._study)

    # -- what takes long ----------------------------------------------------------------------

    def _in_symbols(self, of: Study) -> tuple[ExampleSection, ...]:
        """Return the formulas of the arm, the same for every posture, as soon as they are there."""
        if self._symbols is None and not self._writing.busy:  # asked at each repaint
            work = partial(symbol_sections, of, COLUMN_WIDTH - 1)
            self._writing = self._calls.work_out(work, self._keep_symbols)
        return self._symbols or (WORKING,)

    def _keep_symbols(self, found: tuple[ExampleSection, ...] | None) -> bool:
        self._symbols = found
        self._again()
        return True

    def _found(self, of: Study) -> tuple[NamedSingularity, ...] | None:
        """Return the singularity that was found near this posture of a link table, if it was."""
        return self._near[1] if self._near[0] == of.values else None

    def _look_soon(self, of: Study) -> None:
        """Search for the nearest singularity once the posture has rested for a while.

        That takes up to seconds, and an arm that moves needs them more.
        """
        known = of.subject.system is not None or self._found(of) is not None
        self._rests.after(math.inf if known else REST_S)

    def look_now(self) -> None:
        """Look for the singularity nearest to the posture that is shown, one at a time."""
        of = self._study
        if of is None or self._searching.busy or not self.is_attached:
            return
        work = partial(searched, of.subject, of.values)
        self._searching = self._calls.work_out(work, partial(self._keep_found, of))

    def _keep_found(self, of: Study, found: tuple[NamedSingularity, ...] | None) -> bool:
        if found is not None:
            self._near = (of.values, found)
        self._again()
        return True


class AxesWalk:
    """The thirteen steps of one arm in one convention, and the step that is shown."""

    def __init__(self, subject: Subject, convention: Convention) -> None:
        zero = subject.zero
        self.convention = convention
        self._found = assign_frames(zero.axes, zero.tool, convention)
        self._steps = assignment_steps(self._found)
        self._drawn = StepDrawing(self._found)
        self._place = 0
        self.drawing = self._draw()

    def turn(self, by: int) -> None:
        """Go this many steps on; after the last comes the link table, and then the first step."""
        self._place = (self._place + by) % (len(self._steps) + 1)
        self.drawing = self._draw()

    def columns(self, width: int, height: int, count: int, *, plain: bool) -> tuple[Column, ...]:
        """Return `count` columns at most: the step, and the given axes if there is room.

        Only the last lines of a step that is too long are shown.
        """
        step = self._section(width)
        given = ExampleSection("given: every joint at zero, in mm", self._given(width))
        both = laid([step, given], width, height, plain=plain)
        return both if len(both) <= count else laid([step], width, height, plain=plain)[-count:]

    def _section(self, width: int) -> ExampleSection:
        if self._place == len(self._steps):
            lines = [f"{self.convention.value} frames, link table", *result_lines(self._found)]
            return ExampleSection("from axes: the result", tuple(wrapped(lines, width)))
        now = self._steps[self._place]
        so_far = [step for step in self._steps[: self._place + 1] if step.stage == now.stage]
        lines = [line for step in so_far for line in step.lines]
        title = f"{self.convention.value} frames, {self._place + 1} of {len(self._steps)}"
        return ExampleSection(title, (now.stage, *wrapped(lines, width)))

    def _given(self, width: int) -> tuple[str, ...]:
        return tuple(wrapped(list(axes_lines(self._found)), width))

    def _draw(self) -> tuple[SceneSpace, Dome]:
        step = self._steps[min(self._place, len(self._steps) - 1)]
        return self._drawn.space(step.known), self._drawn.dome


# Joints and coordinates of a posture that is studied, as rows of plain text.

NAME_WIDTH = 11
"""A longer name is cut."""

NO_KEYS = "   "
VALUE_WIDTH = 8
ENDS_WIDTH = 9
"""The width of the two limits at the ends of a bar."""

SHORTEST_BAR, LONGEST_BAR = 7, 22


def joint_rows(
    of: Study, width: int, keys: Keyboard | None = None, pairs: Sequence[JogPair] = ()
) -> str:
    """List the joints: keys where they move it, value, and the place between its limits."""
    chain = of.subject.chain
    names = [words(name)[:NAME_WIDTH] for name in chain.joint_names]
    longest = max(map(len, names))
    letters = [_keys(keys, pairs, name, cartesian=False) for name in chain.joint_names]
    room = width - (longest + VALUE_WIDTH + 2) - (len(letters[0]) + 1 if keys else 0)
    rows = zip(letters, names, of.values, chain.kinds, chain.limits, strict=True)
    return "\n".join(
        f"{letter} {name:<{longest}}{_value(value, kind.unit):>{VALUE_WIDTH}} "
        f"{_range(value, limits, kind, room)}".rstrip()[0 if keys else 1 :]
        for letter, name, value, kind, limits in rows
    )


def axis_rows(
    of: Study,
    axes: Sequence[str],
    keys: Keyboard | None = None,
    pairs: Sequence[JogPair] = (),
) -> str:
    """List the coordinates of the hand, in two columns, with the keys that move them."""
    found = dict(_coordinates(of))
    cells = [(_keys(keys, pairs, axis, cartesian=True), axis, found.get(axis, "")) for axis in axes]
    half = (len(cells) + 1) // 2
    columns = [_column(part, bare=keys is None) for part in (cells[:half], cells[half:])]
    pairs_of_rows = zip_longest(*columns, fillvalue="")
    return "\n".join(f"{left}  {right}".rstrip() for left, right in pairs_of_rows)


def _column(cells: Sequence[tuple[str, str, str]], *, bare: bool) -> list[str]:
    """Return cells in line, names and values as wide as the widest."""
    name_width = max((len(name) for _, name, _ in cells), default=0)
    value_width = max((len(value) for *_, value in cells), default=0)
    return [
        f"{letters} {name:<{name_width}} {value:>{value_width}}"[1 if bare else 0 :]
        for letters, name, value in cells
    ]


def _coordinates(of: Study) -> list[tuple[str, str]]:
    """Return the system's own coordinates of the hand; of a link table, where its tip is."""
    system = of.subject.system
    if system is not None and of.goal:
        split = [name.rpartition("_") for name in system.coordinates]
        pairs = zip(split, of.goal, strict=True)
        return [(name, _value(value, unit)) for (name, _, unit), value in pairs]
    return [(name, _value(of.frame[row][3], "mm")) for row, name in enumerate("xyz")]


def _keys(keys: Keyboard | None, pairs: Sequence[JogPair], name: str, *, cartesian: bool) -> str:
    """Return the letters that move an axis, or as much room."""
    if keys is None:
        return ""
    letters = (pair for pair in pairs if not pair.is_arrow)
    pair = next((one for one in letters if one.axis(cartesian=cartesian) == name), None)
    return NO_KEYS if pair is None else f"{keys.jog(pair.plus)}/{keys.jog(pair.minus)}"


def _range(value: float, limits: tuple[float, float], kind: JointKind, room: int) -> str:
    """Show where a value lies between two limits, with these where there is room."""
    low, high = limits
    if not (math.isfinite(low) and math.isfinite(high)):
        return "no limits"
    cells = room - ENDS_WIDTH - 2
    if cells < SHORTEST_BAR:
        return bar(value, low, high, max(min(room - 2, LONGEST_BAR), SHORTEST_BAR))
    ends = [math.degrees(end) if kind is JointKind.REVOLUTE else end for end in limits]
    return f"{ends[0]:>4.0f} {bar(value, low, high, min(cells, LONGEST_BAR))} {ends[1]:.0f}"


def _value(value: float, unit: str) -> str:
    if unit == "rad":
        return f"{rounded(math.degrees(value), 1)}\N{DEGREE SIGN}"
    return f"{rounded(value, 1)}mm"


LOOK_S = 0.2
"""Matrices of a moving arm are worked out no more often: its own thread comes first."""

READ_ONLY = "read only: nothing here moves it"
UNKNOWN_BUILD = "this kind of arm has no theory screen"


class TheoryScreen(DeskScreen):
    """Link table, matrices, Jacobian, singularities and solutions of the present posture."""

    place = "theory"
    BINDINGS: ClassVar[list[BindingType]] = bindings(place)

    def __init__(self) -> None:
        super().__init__()
        self.subject: Subject | None = subject_of_arm(
            self.desk.link.status.title, self.desk.arm.model.arm
        )
        self._key: tuple[tuple[float, ...] | None, tuple[Size, Size]] = (None, (Size(), Size()))
        self._shown_s = -math.inf

    @property
    def panel(self) -> TheoryPanel | None:
        """What shows the theory; None where nothing is known of the arm's build."""
        return None if self.subject is None else self.query_one(TheoryPanel)

    def compose_body(self) -> ComposeResult:
        """Lay the middle out; it says so where nothing is known of the arm's build."""
        if self.subject is None:
            yield PlainText(id="no-theory")
        else:
            yield TheoryPanel(self.subject, _numbers, braille=self.desk.braille)

    def show_body(self, status: Status) -> None:
        """Show what follows from the posture, as soon as it or the size has changed."""
        if self.subject is None:
            self.text("no-theory").show(UNKNOWN_BUILD)
            return
        panel = self.query_one(TheoryPanel)
        values = None if status.joints is None else status.joints.angles_rad
        key, now_s = (values, panel.room), self.desk.clock()
        soon = key[1] == self._key[1] and now_s - self._shown_s < LOOK_S
        if key == self._key or soon:
            return
        self._key, self._shown_s = key, now_s
        panel.show(None if values is None else study(self.subject, values))


def _numbers(of: Study, width: int) -> str:
    rows = joint_rows(of, width), axis_rows(of, axes_of(of.subject))
    return "\n".join((READ_ONLY, *rows))
