"""The catalogue as people read it: a list, one row in full, and docs/reference/errors.md."""

from __future__ import annotations

import re
from collections.abc import Iterator

from armdrive.errors.actions import ACTIONS, PHRASES
from armdrive.errors.table import ENTRIES, GROUPS, CatalogueEntry

_PAGE_BEGINS = """\
# Every error

What each message means, what it means for the arm, and what to do. The code stands in brackets:
`armdrive: [E203] planned motion needs ...`. In Python every error of a call is an `ArmError` with
`error.code`; a refusal of the kinematics is also an error of `kinematics`, such as `Unreachable`.
`armdrive errors CODE` prints one row, `armdrive errors --find lost,wire` the rows with both words.

With `--json` a failing command prints one object on standard error: `code`, `title`, `message`,
`effect` and `remedy`. The status has `error_code`, `notice_code` and `trust_code`. Text from files,
devices and the command line is printed with its control characters escaped (`\\x1b`).

An internal fault of armdrive is one sentence (E005) with exit code 70; the traceback is written to
`unexpected.txt` in the state folder, or printed with `ARMDRIVE_TRACEBACK=1`.
"""


def listing() -> Iterator[str]:
    """Return a line for each row."""
    width = max(len(row.title) for row in ENTRIES)
    for group, rows in GROUPS.items():
        yield f"{group}:"
        for row in rows:
            yield f"  {row.code}  {row.title:<{width}}  {row.name}"


def in_full(row: CatalogueEntry) -> Iterator[str]:
    """Return the lines of one row."""
    yield f"{row.code}: {row.title} ({row.name})"
    yield f"  cause   {_plain(row.cause)}"
    yield f"  effect  {_plain(row.effect)}"
    yield f"  remedy  {_plain(row.remedy)}"


def page() -> str:
    """Return docs/reference/errors.md."""
    parts = [_PAGE_BEGINS, *_actions()]
    for group, rows in GROUPS.items():
        parts.append(f"\n## {group}\n\n| code | error | cause | effect on the arm | what to do |\n")
        parts.append("|---|---|---|---|---|\n")
        parts += [
            f"| {row.code} | **{row.title}** (`{row.name}`) | {row.cause} | {row.effect} | "
            f"{row.remedy} |\n"
            for row in rows
        ]
    return "".join(parts)


def _actions() -> Iterator[str]:
    yield (
        "\n## What an error asks for\n\nThis page names actions as a Python program calls them. "
        "The command line, the shell and the\ndesk show their own words instead:\n\n"
        "| in Python | on the command line | in `armdrive shell` | at the desk, the key for |\n"
        "|---|---|---|---|\n"
    )
    for row in ACTIONS:
        yield f"| `{row.python}` | `{row.command_line}` | `{row.shell}` | {row.key} |\n"
    for phrase in PHRASES:
        key = re.sub(r"press \{([a-z-]+)\}", r"\1", phrase.desk)
        yield f"| {phrase.python} | {phrase.command_line} | {phrase.shell} | {key} |\n"


def _plain(text: str) -> str:
    return text.replace("**", "")
