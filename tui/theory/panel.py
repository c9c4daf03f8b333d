"""The theory of a posture: the arm in space, its joints, and pages of matrices."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from itertools import zip_longest
from typing import cast

from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical

from armdrive.render.figure import ChainFigure, DrawnChain
from armdrive.render.scene import Moment
from kinematics.chains.links import JointKind
from kinematics.presets import ArmModel
from kinematics.textbook.pages import Column, laid, sections, summary, symbol_sections
from kinematics.textbook.study import Study, Subject, searched
from kinematics.textbook.systems.named import Lost
from kinematics.textbook.worked_example import ExampleSection
from tui.app import HoldAlarm, KeyApp
from tui.arm_view import SpaceView
from tui.axes import bar
from tui.keys.keyboard import Keyboard
from tui.keys.table import JogPair, spoken, words
from tui.painting import PlainText

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
        self._numbers = numbers
        self._braille = braille
        self._figure = ChainFigure(subject.chain)
        self._joint_names = subject.chain.joint_names
        self._study: Study | None = None
        self._symbols: tuple[ExampleSection, ...] | None = None
        self._writing = False
        self._near: tuple[tuple[float, ...], tuple[Lost, ...]] = ((), ())
        self._searching = False
        self._rests = HoldAlarm(cast("KeyApp", self.app), self.look_now)

    def compose(self) -> ComposeResult:
        """Lay the arm and its numbers out on the left, the pages on the right."""
        drawn = cast("ArmModel", DrawnChain(self._figure))  # a view asks for no more than it has
        with Vertical(id="theory-left"):
            yield SpaceView(drawn, braille=self._braille, id="theory-space")
            yield PlainText(id="theory-numbers")
            yield PlainText(id="theory-summary")
        for place in range(MOST_COLUMNS):
            yield PlainText(id=f"theory-page-{place}").add_class("theory-page")

    # -- what is shown ------------------------------------------------------------------------

    def show(self, of: Study | None) -> None:
        """Show a study; None while the posture is unknown."""
        before, self._study = self._study, of
        if of is not None and (before is None or of.values != before.values):
            self._look_soon(of)
        if not self.size:
            return
        joints = None if of is None else self._figure.joints(of.values)
        self.query_one(SpaceView).show(Moment(joints))
        left = self.query_one("#theory-left").size.width
        self._text("theory-numbers").show("" if of is None else self._numbers(of, left))
        found = None if of is None else self._found(of)
        self._text("theory-summary").show("" if of is None else self._spoken(summary(of, found)))
        self._show_pages(of)

    def turn(self, by: int) -> None:
        """Turn this many pages on; after the last comes the first."""
        pages = self.pages
        self.page = (self.page + by) % max(pages, 1)
        self._again()

    def switch_symbols(self) -> None:
        """Switch between numbers and symbols, from the first page on."""
        self.symbolic = not self.symbolic
        self.page = 0
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
        columns = () if of is None else self._columns(of)
        count = self._at_once
        self.page = min(self.page, max(-(-len(columns) // count) - 1, 0))
        for place in range(MOST_COLUMNS):
            text = self._text(f"theory-page-{place}")
            text.display = place < count
            at = self.page * count + place
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

    def _text(self, name: str) -> PlainText:
        return self.query_one(f"#{name}", PlainText)

    # -- what takes long ----------------------------------------------------------------------

    def _in_symbols(self, of: Study) -> tuple[ExampleSection, ...]:
        """Return the formulas of the arm, the same for every posture, as soon as they are there."""
        if self._symbols is None and not self._writing:
            self._writing = True
            self._aside(partial(self._write_symbols, of))
        return self._symbols or (WORKING,)

    def _write_symbols(self, of: Study) -> None:
        found = symbol_sections(of, COLUMN_WIDTH - 1)
        self.app.call_from_thread(self._keep_symbols, found)

    def _keep_symbols(self, found: tuple[ExampleSection, ...]) -> None:
        self._symbols = found
        self._again()

    def _found(self, of: Study) -> tuple[Lost, ...] | None:
        """Return the singularity that was found near this posture of a link table, if it was."""
        return self._near[1] if self._near[0] == of.values else None

    def _look_soon(self, of: Study) -> None:
        """Have the nearest singularity looked for, once the posture has rested for a while.

        That takes up to seconds, and an arm that moves needs them more.
        """
        known = of.subject.system is not None or self._found(of) is not None
        self._rests.after(math.inf if known else REST_S)

    def look_now(self) -> None:
        """Look for the singularity nearest to the posture that is shown, one at a time."""
        of = self._study
        if of is None or self._searching or not self.is_attached:
            return
        self._searching = True
        self._aside(partial(self._search, of))

    def _search(self, of: Study) -> None:
        try:
            found = searched(of.subject, of.values)
        finally:
            self._searching = False
        self.app.call_from_thread(self._keep_found, of, found)

    def _keep_found(self, of: Study, found: tuple[Lost, ...]) -> None:
        self._near = (of.values, found)
        self._again()

    def _aside(self, work: Callable[[], None]) -> None:
        self.run_worker(work, thread=True, exit_on_error=False, group="theory")


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
    letters = (pair for pair in pairs if len(pair.plus) == 1)
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
        return f"{round(math.degrees(value), 1) + 0.0:.1f}\N{DEGREE SIGN}"
    return f"{round(value, 1) + 0.0:.1f}mm"
