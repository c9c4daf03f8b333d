"""The page of all errors, made from their catalogue; `generated.py` writes it."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from armdrive.errors.actions import ACTIONS, PHRASES
from armdrive.errors.table import GROUPS

PAGE = Path(__file__).parent / "reference" / "errors.md"

HEAD = """\
# Every error

What each error means, what it does to the arm, and what to do. The code stands in brackets before
the message: `armdrive: [E203] planned motion needs ...`. `armdrive errors CODE` prints one row.
On the log of the desk (F7), Enter on an error shows its row.

In Python, every error of a call of an arm is an `ArmError`, and `error.code` is its code. A refusal
of the kinematics is both: `move_to` raises an `Unreachable` that is an `ArmError` and a
`kinematics.Unreachable`. The kinematics alone raise errors of their own, whose row is
`armdrive.errors.table.entry(error)`.

With `--json` a failing command prints one object on standard error: `code`, `title`, `message`,
`effect` and `remedy`. The status has `error_code`, `notice_code` and `trust_code`.

Text from files, devices and the command line is never printed raw. Characters that a terminal would
act on, or not show, are printed as escapes: `\\x1b` for the escape character, `\\u202e` for one
that reverses the direction of writing. That holds for every output: messages, tables, drawings, the
shell, the desk and the log. A very long line loses its middle. `--json` escapes as JSON does.

If armdrive itself has a fault, it says so in one sentence (E005), writes the traceback to
`unexpected.txt` in the state folder, and ends with exit code 70. `ARMDRIVE_TRACEBACK=1` in the
environment prints the traceback instead.
"""


def page() -> str:
    """Return the whole page."""
    parts = [HEAD, *_actions()]
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
        yield (
            f"| `{row.python}` | `{row.command_line}` | `{row.shell}` | {_key_names(row.desk)} |\n"
        )
    for phrase in PHRASES:
        desk = _key_names(phrase.desk)
        yield f"| {phrase.python} | {phrase.command_line} | {phrase.shell} | {desk} |\n"


def _key_names(desk: str) -> str:
    """Return the desk's words with the names of its keys, not with the keys themselves."""
    return re.sub(r"(?:press )?\{([a-z-]+)\}", r"\1", desk)
