"""The keyboard at hand: which keys do what, how they are printed, and footer and help from that."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any, Self

from textual.binding import Binding, BindingType
from textual.keys import KEY_NAME_REPLACEMENTS, _character_to_key, key_to_character

from armdrive.errors.actions import Words, desk_words, presented
from kinematics.text import shown_name
from tui.keys.layouts import LAYOUTS, QWERTY
from tui.keys.table import AXIS_KEYS, STOP, TABLE, DeskKey, JogPair, titled

# The line of keys offers no more rows than this; the help has all.
KEYS_OFFERED = 12

# Rows that the line of keys offers on every screen.
KEYS_LAST = ("help", "palette", "quit")

# The place of a model's screen, and how its help begins.
MODEL = "model"
MODEL_HELP = (
    "Jog keys: the first moves by +, the second by -. Each press is one step, at once;",
    "nothing is armed, as nothing moves.",
)

# So wide is the column of keys in the help.
KEYS_WIDTH = 18

_UNICODE_NAMES = {name: unicode for unicode, name in KEY_NAME_REPLACEMENTS.items()}
_LABELS: Mapping[str, str] = MappingProxyType({"escape": "Esc"})


def label(key: str) -> str:
    """Return what is printed on a key, by the framework's name of it."""
    if key in _LABELS:
        return _LABELS[key]
    character = key_to_character(_UNICODE_NAMES.get(key, key))
    return character if character and character.isprintable() and character != " " else key


def short_label(row: DeskKey) -> str:
    """Return the first key of a row, and the first that does the opposite, in few letters."""
    keys = (*row.back[:1], *row.keys[:1])
    return " ".join(label(key).replace("ctrl+", "^") for key in keys)


@dataclass(frozen=True)
class Keyboard:
    """The table of keys as it is on this keyboard: the same rows, maybe with other keys.

    The desk asks it at every poll, hence the indexes.
    """

    rows: tuple[DeskKey, ...] = TABLE

    @cached_property
    def _by_id(self) -> dict[str, DeskKey]:
        return {row.id: row for row in self.rows}

    @cached_property
    def _words(self) -> Words:
        return desk_words(self.label)

    @cached_property
    def _jog_keys(self) -> dict[str, str]:
        """The jog key of the table for each jog key of this keyboard."""
        return {
            own: key
            for row in AXIS_KEYS
            if row.id in self._by_id
            for own, key in zip(self._by_id[row.id].all_keys, row.all_keys, strict=True)
        }

    def row(self, name: str) -> DeskKey:
        """Return the row of an id; raises `KeyError`."""
        return self._by_id[name]

    def action(self, name: str) -> tuple[DeskKey, str]:
        """Return the row of a binding and its action, by the binding's id."""
        row = self.row(name.removesuffix("-back"))
        return row, next(action for each, _, action in row.bound if each == name)

    def of(self, name: str) -> tuple[str, ...]:
        """Return the keys of a row."""
        return self.row(name).keys

    def label(self, name: str) -> str:
        """Return what is printed on the first key of a row."""
        return label(self.of(name)[0])

    def presented(self, sentence: str) -> str:
        """Return a sentence in the words of the desk: its actions by their keys."""
        return presented(sentence, self._words)

    def jog(self, key: str) -> str:
        """Return what is printed on the key that jogs as this one of the table does."""
        return label(next((own for own, jogs in self._jog_keys.items() if jogs == key), key))

    def jog_key(self, key: str) -> str | None:
        """Return the jog key of the table that a key of this keyboard stands for."""
        return self._jog_keys.get(key)

    def at(self, place: str) -> tuple[DeskKey, ...]:
        """Return the rows that count on one screen, those of all screens after its own."""
        own = tuple(row for row in self.rows if row.counts_at(place))
        return (*own, *(row for row in self.rows if not row.places))

    def only(self, place: str, common: Collection[str]) -> Self:
        """Return a keyboard of one screen alone, with a few of the rows of every screen, by id."""
        rows = (row for row in self.rows if row.counts_at(place) or row.id in common)
        return replace(self, rows=tuple(rows))

    def keymap(self, bound: Sequence[DeskKey] = TABLE) -> dict[str, str]:
        """Return the keys by id, as the framework takes them, of rows that are bound otherwise.

        It goes through all of them for every key that is pressed, each with every binding.
        """
        before = {name: keys for row in bound for name, keys, _ in row.bound}
        after = {name: keys for row in self.rows for name, keys, _ in row.bound}
        return {name: ",".join(keys) for name, keys in after.items() if before.get(name) != keys}

    def next_keys(
        self, place: str, idle: Collection[str] = (), first: Sequence[str] = ()
    ) -> list[DeskKey]:
        """Return the rows that make sense next on a screen.

        They are the stop, those named `first`, the screen's own, and the help. Rows that are
        `idle`, by id, would do nothing now, and are left out.
        """
        at_hand = {row.id: row for row in self.at(place) if row.description and row.id not in idle}
        own = [row.id for row in at_hand.values() if row.places]
        room = KEYS_OFFERED - 1 - len(first) - len(KEYS_LAST)
        ids = dict.fromkeys((STOP, *first, *own[:room], *KEYS_LAST))
        return [at_hand[each] for each in ids if each in at_hand]

    def help(self, place: str, pairs: Sequence[JogPair]) -> Iterator[str]:
        """Yield what moves, by which keys, then a line for each row that counts on a screen."""
        yield from MODEL_HELP if place == MODEL else self._arm_help()
        for pair in pairs:
            moves = (
                shown_name(pair.joint),
                pair.cartesian and f"(Cartesian mode: {pair.cartesian})",
            )
            keys = f"{self.jog(pair.plus)} {self.jog(pair.minus)}"
            yield _line(keys, " ".join(filter(None, moves)))
        for title, of_screen in ((f"On the {titled(place)} screen", True), ("Everywhere", False)):
            yield from ("", title)
            for row in self.at(place):
                if bool(row.places) is of_screen and not row.jogs:
                    yield _line(" ".join(map(label, row.all_keys)), row.tooltip)

    def _arm_help(self) -> Iterator[str]:
        yield f"Move the arm, on the {titled('jog')} screen ({self.label('screen-jog')})"
        yield f"1  {self.label('reference')} tells the desk where the arm is (the reference)."
        yield f"2  {self.label('arm')} arms the keys below; they disarm after 60 s without a key."
        yield "3  Tap a key for one step. Hold it to keep moving; let go and the arm stops."
        yield f"4  {self.label(STOP)} stops it on every screen, unless the link is lost."
        yield ""
        yield "Jog keys, while armed: the first moves by +, the second by -."


def _line(keys: str, words: str) -> str:
    return f"{keys:<{KEYS_WIDTH - 1}} {words}"


# The table as it stands.
DEFAULT_KEYS = Keyboard()


def keyboard_of(layout: str) -> Keyboard:
    """Return the keyboard of a layout; that of the table where there is none of that name."""
    upper, middle, others = LAYOUTS.get(layout, LAYOUTS[QWERTY])
    pairs = enumerate(zip(middle, upper, strict=True), 1)
    changed = {**others, **{f"axis-{number}": minus + plus for number, (minus, plus) in pairs}}
    return Keyboard(
        tuple(_with_keys(row, changed[row.id]) if row.id in changed else row for row in TABLE)
    )


def _with_keys(row: DeskKey, characters: str) -> DeskKey:
    """Return a row with other keys: the last one, and before it the one that does the opposite."""
    *back, key = map(_character_to_key, characters)
    return replace(row, keys=(key,), back=tuple(back) or row.back)


def as_rows(keyboard: Keyboard) -> list[dict[str, Any]]:
    """Return the table as plain data: what `--json` prints."""
    return [
        {
            "id": row.id,
            "keys": [label(key) for key in row.all_keys],
            "screen": ", ".join(row.places.split()) or "all",
            "does": row.tooltip,
        }
        for row in keyboard.rows
    ]


def as_text(keyboard: Keyboard) -> Iterator[str]:
    """Yield the table line by line."""
    for row in as_rows(keyboard):
        yield f"{row['id']:<15} {' '.join(row['keys']):<15} {row['screen']:<9} {row['does']}"


def bindings(place: str, common: Collection[str] = ()) -> list[BindingType]:
    """Make the framework's bindings of the rows of a screen or dialog.

    `common` are rows of every screen that count there too, by id. "" alone stands for all of those.
    A keyboard layout changes keys later, by the ids of their rows.
    """
    rows = DEFAULT_KEYS.only(place, common).rows if place or common else DEFAULT_KEYS.at("")
    return [
        Binding(",".join(keys), action, row.description, priority=row.everywhere, id=name)
        for row in rows
        for name, keys, action in row.bound
    ]
