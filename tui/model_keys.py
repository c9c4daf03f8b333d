"""The keyboard of a model: the rows of the desk's table that make sense with no arm."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from armdrive.errors import KeyFileError
from tui.key_row import DeskKey
from tui.keyboard import DEFAULT_KEYS, Keyboard, label
from tui.keys import LETTERS, STOP, JogPair, words

PLACE = "theory"
"""Where all rows of a model's keyboard count."""

KEPT = (STOP, "help", "quit", "help-close", "mode", "finer", "coarser")
"""Rows by id; those that jog, and those of the theory, are kept too."""

NOTHING_TO_STOP = "Close a dialog. There is nothing to stop: no arm is connected."

_ARROWS = (("left", "right", 0, "y"), ("up", "down", 1, "z"))
_OWN_PLACES = ("theory", "model")
_OWN_ACTIONS = ("jog(", "view(")


class ModelKeyboard(Keyboard):
    """A keyboard on which nothing has to be armed."""

    __slots__ = ()

    def _jog_help(self, pairs: Sequence[JogPair]) -> Iterator[str]:
        yield ""
        yield "Jog keys: each press is one step, at once; nothing is armed, as nothing moves."
        for pair in pairs:
            keys = f"{self.jog(pair.plus)} {self.jog(pair.minus)}"
            hand = f"of the hand: {pair.cartesian}" if pair.cartesian else ""
            joint = f"joint {words(pair.joint)}" if pair.joint else ""
            yield f"{keys:<17} {', '.join(filter(None, (joint, hand)))}, + and -"


def model_keys(keys: Keyboard = DEFAULT_KEYS) -> ModelKeyboard:
    """Return the rows of a keyboard that a model has, with the keys that they have there.

    Raises `KeyFileError` where a file of keys gives one key to two of them: on the desk they may
    be far apart.
    """
    rows = tuple(_rows(keys))
    owners: dict[str, DeskKey] = {}
    for row in rows:
        for key in row.keys if row.place in ("", PLACE) else ():
            other = owners.setdefault(key, row)
            if other is not row:
                raise KeyFileError(
                    f"with a model, {label(key)} would be both {other.id} and {row.id}: give one "
                    "of them another key"
                )
    return ModelKeyboard(rows)


def model_pairs(joints: Sequence[str], axes: Sequence[str]) -> tuple[JogPair, ...]:
    """Return the jog keys of a model: a row of letters for each joint and axis of the hand.

    Where there are more of the ones than of the others the names of the rest are empty. There are
    keys for seven.
    """
    count = min(max(len(joints), len(axes)), len(LETTERS))
    letters = [JogPair(*LETTERS[row], _at(joints, row), _at(axes, row)) for row in range(count)]
    arrows = [
        JogPair(plus, minus, _at(joints, row), axis if axis in axes else "")
        for plus, minus, row, axis in _ARROWS
    ]
    return (*letters, *(pair for pair in arrows if pair.joint or pair.cartesian))


def _rows(keys: Keyboard) -> Iterator[DeskKey]:
    for row in keys.rows:
        if row.id == STOP:
            yield replace(row, description="", tooltip=NOTHING_TO_STOP)
        elif row.id == "quit":
            yield replace(row, tooltip="Leave the model.")
        elif row.id in ("help", "help-close"):
            yield row
        elif row.id in KEPT or row.place in _OWN_PLACES or row.action.startswith(_OWN_ACTIONS):
            yield replace(row, place=PLACE)


def _at(names: Sequence[str], row: int) -> str:
    return names[row] if row < len(names) else ""
