"""Joints and coordinates of a posture that is studied, as rows of plain text."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import zip_longest

from kinematics.chains.links import JointKind
from kinematics.textbook.study import Study
from tui.keyboard import Keyboard
from tui.keys import JogPair, words
from tui.tables import bar

NAME_WIDTH = 11
"""A longer name is cut."""

NO_KEYS = "   "
VALUE_WIDTH = 8
ENDS_WIDTH = 9
"""What the two limits take beside a bar."""

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
