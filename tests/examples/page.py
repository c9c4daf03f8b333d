"""The table on the page about the examples: which ran on which arm, and how long that took."""

import re
from collections.abc import Mapping, Sequence

from armdrive.registry import DIALECTS

from .on_arms import Example, Form, Ran

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
