"""The examples that run on every arm: one table, which the tests run and the page shows."""

import re
from collections.abc import Mapping, Sequence
from types import MappingProxyType

from armdrive.abilities import Abilities
from armdrive.registry import DIALECTS

from . import worlds
from .on_arms import Example, Form, Ran


def no_grip_switch(abilities: Abilities) -> str:
    """Say that an arm cannot measure what is between its fingers."""
    return "" if abilities.grip_switch else "needs a grip switch"


_ROW = {"repeat 2 as row": "repeat 1 as row"}
_ONE = {**_ROW, "repeat 2 as column": "repeat 1 as column"}
_ONLY_TEACHMOVER = dict.fromkeys(set(DIALECTS) - {"teachmover"})
"""Every day, other dialects show the same with `stacking.arm` or `circle.py`."""
_SMALL = {"SPEED = 0.5": "SPEED = 1.0", "RADIUS_MM = 35.0": "RADIUS_MM = 15.0"}

_ROWS = {
    "A": (230.0, -30.0, 0.0),
    "B": (180.0, -30.0, 0.0),
    "C": (280.0, -30.0, 0.0),
    "D": (180.0, -80.0, 0.0),
}

EXAMPLES: Mapping[str, Example] = MappingProxyType({each.file: each for each in (
    Example(
        "stacking.arm", "four blocks from the squares of a grid, one on the other",
        Form(4), worlds.tower,
        shorter={"robko01": None, "armdroid": Form(2, _ROW), "grbl": Form(1, _ONE),
                 "mks": Form(1, _ONE), "cia402": None},
    ),
    Example(
        "stacking.py", "the same in Python", Form(4), worlds.tower,
        shorter=_ONLY_TEACHMOVER,
    ),
    Example(
        "hanoi.arm", "three discs, and never one on a smaller one", Form(3), worlds.hanoi,
        shorter=_ONLY_TEACHMOVER,
    ),
    Example(
        "sorting.arm", "blocks by their width, which the fingers measure", Form(_ROWS),
        worlds.sorted_rows, no_grip_switch,
    ),
    Example(
        "circle.py", "with a pen, on paper", Form(35.0), worlds.circle,
        beside_mm=worlds.beside_circle_mm,
        shorter={"robko01": Form(15.0, _SMALL), "grbl": None, "mks": None, "cia402": None},
    ),
    Example(
        "lettering.py", "a word, with a pen", Form("ARM"), worlds.letters,
        beside_mm=worlds.beside_letters_mm,
        shorter=_ONLY_TEACHMOVER,
    ),
)})  # fmt: skip
"""Every example that carries or draws something, by its file."""


# The table on the page about the examples: which ran on which arm, and how long that took.


COMMAND = "python -m tests.examples --write docs/how-to/examples.md"

TABLE = re.compile(r"^\| example \|(?! what it shows).*?\n\n", re.MULTILINE | re.DOTALL)


def cell(example: Example, form: Form, ran: Ran) -> str:
    """Return what the table says of a run."""
    if example.beside_mm is None:
        return f"{ran.took_s:.0f} s"
    return f"{ran.took_s:.0f} s, {example.beside_mm(ran, form.size):.1f} mm"


def table(examples: Sequence[Example], cells: Mapping[tuple[str, str], str]) -> str:
    """Return the table; `cells` by example and dialect."""
    head = f"| example | what it does | {' | '.join(DIALECTS)} |"
    rows = [head, "|---" * (2 + len(DIALECTS)) + "|"]
    for each in examples:
        shown = [cells[each.file, dialect] for dialect in DIALECTS]
        rows.append(f"| `{each.file}` | {each.about} | {' | '.join(shown)} |")
    return "\n".join(rows) + "\n\n"


def with_table(page: str, made: str) -> str:
    """Return the page with another table."""
    changed, count = TABLE.subn(lambda _: made, page)
    if count != 1:
        raise ValueError(f"the page has {count} tables of examples instead of one")
    return changed


def told(page: str, file: str, dialect: str) -> str:
    """Return what a page says of an example on a dialect, "" where it says nothing."""
    row = re.search(rf"^\| `{re.escape(file)}` .*$", page, re.MULTILINE)
    if row is None:
        return ""
    return row[0].strip("| ").split(" | ")[2 + list(DIALECTS).index(dialect)]


def amounts(said: str) -> list[float]:
    """Return the numbers of a cell."""
    return [float(number) for number in re.findall(r"[\d.]+", said)]
