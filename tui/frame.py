"""What surrounds the body of every screen: tabs, the safety panel, the line of keys."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from textual import events
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical
from textual.content import Content
from textual.widgets import Static, Tab, Tabs

from armdrive.errors.printable import printable
from tui.conduct import Conduct
from tui.keys.keyboard import KEYS_LAST, OWN_KEPT, PAIRS, Keyboard, label
from tui.keys.rows import DeskKey
from tui.keys.table import SCREENS, STOP, KeyEntry
from tui.painting import PlainText, Span

FACT_GAP = "   "
"""Between two facts on one line."""

KEY_GAP = "  "
"""Between two groups of the line of keys."""


class ScreenTabs(Tabs, can_focus=False):
    """The screens of the desk with their keys; this one's is lit. A click goes to another."""

    def __init__(self, place: str, keys: Keyboard) -> None:
        tabs = (Tab(_tab_text(entry, keys), id=entry.id) for entry in SCREENS)
        super().__init__(*tabs, active=place, id="tabs")
        self._place = place

    def on_tabs_tab_activated(self, event: Tabs.TabActivated) -> None:
        """Go to the screen of a tab that was clicked; on this screen its own tab stays lit."""
        event.stop()
        chosen = event.tab.id
        if chosen is not None and chosen != self._place:
            self.active = self._place
            self.app.call_later(self.app.run_action, f"show_screen('{chosen}')")


def _tab_text(entry: KeyEntry, keys: Keyboard) -> Content:
    key = keys.label(f"screen-{entry.id}").upper()
    return Content.assemble(key, f" {entry.title.capitalize()}")


class StopButton(Static, can_focus=False):
    """Stops the arm. The app takes a mouse button that is pressed on it before anything else."""

    def __init__(self, keys: Keyboard) -> None:
        stop = label(keys.of(STOP)[0])
        super().__init__(Content(f"   STOP   \n          \n{stop:^10}"), id="stop")


class SafetyPanel(Horizontal):
    """The one place for the arm's state, how far its position can be trusted, and the stop."""

    def __init__(self, keys: Keyboard) -> None:
        super().__init__(id="safety", classes="panel")
        self.arm = ""
        """Which arm the title of the panel names."""
        self._keys = keys

    def compose(self) -> ComposeResult:
        """Lay the panel out: the button on the left, three lines on the right."""
        yield StopButton(self._keys)
        with Vertical(id="safety-lines"):
            yield PlainText(id="conduct")
            yield PlainText(id="trust")
            yield PlainText(id="stopping")

    def show(self, conduct: Conduct, settings: str = "") -> None:
        """Show the arm's conduct, and how the keys of this screen move it."""
        word, colour = conduct.badge
        says = conduct.forbids or conduct.says
        self._text("conduct").show((f" {word} ", f"bold reverse {colour}"), f" {says}")
        self._text("trust").show((f"{conduct.dot[0]} ", conduct.dot[1]), conduct.position)
        facts = [conduct.stopping, *([settings] if settings else [])]
        self._text("stopping").show((FACT_GAP.join(facts), "dim"))
        self.set_class(conduct.real, "-real")
        self.set_class(bool(conduct.forbids), "-forbidden")
        if conduct.arm != self.arm:
            self.arm = conduct.arm
            colour = " reverse $error" if conduct.real else ""
            self.border_title = Content.styled(f" {printable(conduct.arm)} ", f"bold{colour}")

    def _text(self, name: str) -> PlainText:
        return self.query_one(f"#{name}", PlainText)


@dataclass(frozen=True, slots=True)
class KeyGroup:
    """One thing that the line of keys offers: a row, or two rows that do the opposite."""

    rows: tuple[DeskKey, ...]
    name: str

    @property
    def texts(self) -> tuple[str, ...]:
        """What each row is clicked on: its key; the last one has the name behind it."""
        keys = [label(row.keys[0]).replace("ctrl+", "^") for row in self.rows]
        return (*(f"{key} " for key in keys[:-1]), f"{keys[-1]} {self.name}{KEY_GAP}")


def grouped(rows: Sequence[DeskKey]) -> list[KeyGroup]:
    """Return these rows with the pairs among them in one group each."""
    by_id = {row.id: row for row in rows}
    seconds = {PAIRS[row.id][0] for row in rows if row.id in PAIRS}
    groups = []
    for row in rows:
        second, name = PAIRS.get(row.id, ("", ""))
        if second in by_id:
            groups.append(KeyGroup((row, by_id[second]), name))
        elif row.id not in seconds:
            groups.append(KeyGroup((row,), row.description))
    return groups


class KeyLine(PlainText):
    """The keys that make sense next. Clicking one does what its key does."""

    def __init__(self, *, id: str) -> None:  # noqa: A002
        super().__init__(id=id)
        self._ends: tuple[tuple[int, DeskKey], ...] = ()

    def show_keys(self, rows: Sequence[DeskKey], width: int) -> None:
        """Show these rows, without the less important ones where there is too little room."""
        groups = grouped(rows)
        while _width(groups) > width and len(groups) > 1:
            groups.remove(_least(groups))
        spans: list[Span] = []
        ends: list[tuple[int, DeskKey]] = []
        end = 0
        for group in groups:
            for row, text in zip(group.rows, group.texts, strict=True):
                key, gap, name = text.partition(" ")
                spans += [(key, "bold $text-primary"), (f"{gap}{name}", "")]
                end += len(text)
                ends.append((end, row))
        self._ends = tuple(ends)
        self.show(*spans)

    async def on_click(self, event: events.Click) -> None:
        """Do what the row under the mouse does."""
        found = next((row for end, row in self._ends if event.x < end), None)
        if found is not None:
            await self.app.run_action(f"app.do_row('{found.id}')")


def _least(groups: Sequence[KeyGroup]) -> KeyGroup:
    """Return the group that can be missed first."""
    shared = {group.rows[0].id: group for group in groups if group.rows[0].id in KEYS_LAST}
    own = [group for group in groups[1:] if group.rows[0].id not in shared]
    if len(own) <= OWN_KEPT and "palette" in shared:
        return shared["palette"]
    return own[-1] if own else groups[-1]


def _width(groups: Sequence[KeyGroup]) -> int:
    return sum(len(text) for group in groups for text in group.texts) - len(KEY_GAP)
