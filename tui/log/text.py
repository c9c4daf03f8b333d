"""What the log screen and its dialogs say, as text that fits a width."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence

from armdrive.errors.printing import in_full
from armdrive.errors.table import CatalogueEntry, by_code
from armdrive.trace.entries import Topic
from armdrive.trace.log import LogBook, LogFilter, LogLine
from tui.keys.keyboard import Keyboard

CUT = "~"
"""Stands at the end of what did not fit; enter shows the whole line."""

WAYS: Mapping[str, str] = {"->": "to the arm", "<-": "from the arm"}


def head(book: LogBook, keys: Keyboard, *, following: bool, held: bool) -> str:
    """Return what is shown of how much, and by which keys that changes."""
    topics = "  ".join(
        f"{keys.label(f'log-{topic.value}')} [{'x' if topic in book.filter.topics else ' '}] "
        f"{topic.value}"
        for topic in Topic
    )
    conduct = "HELD STILL" if held else "newest last" if following else "looking back"
    text = f"  find: {book.filter.text}" if book.filter.text else ""
    return f"{topics}\n{conduct}, {len(book.lines)} of {book.total} lines{text}"


def row(line: LogLine, width: int, *, chosen: bool) -> str:
    """Return a line of the log cut to a width: mark, time, direction, code, bytes, words."""
    mark = ">" if chosen else "!" if line.topic is Topic.ERRORS else " "
    start = f"{mark}{line.time_s:10.3f} {line.arrow} "
    code = f"[{line.code}] " if line.code and not line.words.startswith("[") else ""
    if not line.shown:
        return cut(f"{start}{code}{line.text}", width)
    room = max((width - len(start)) * 2 // 5, 8)
    return cut(f"{start}{cut(line.shown, room):<{room}}  {line.words}", width)


def cut(text: str, width: int) -> str:
    """Return as much of a text as fits, with a sign where it was cut."""
    return text if len(text) <= width else f"{text[: max(width - 1, 0)]}{CUT}"


def whole(line: LogLine, width: int, keys: Keyboard) -> str:
    """Return everything that is known of a line; of an error the catalogue's row too."""
    way = WAYS.get(line.arrow, "")
    parts = [
        f"{line.time_s:.4f} s after the connection, entry {line.number}: {line.kind.value} {way}",
        line.shown,
        line.words,
        *(in_full(by_code(line.code)) if line.code else ()),
    ]
    return "\n\n".join(_filled(keys.presented(part), width) for part in parts if part)


def catalogue(
    rows: Sequence[CatalogueEntry], at: int, width: int, height: int, keys: Keyboard
) -> str:
    """Return a list of errors with one chosen, and that one in full below it."""
    if not rows:
        return "no error has these words"
    below = "\n".join(_filled(keys.presented(part), width) for part in in_full(rows[at]))
    room = max(height - below.count("\n") - 2, 1)
    first = min(max(at - room // 2, 0), max(len(rows) - room, 0))
    listed = (
        cut(f"{'>' if index == at else ' '} {each.code}  {each.title}", width)
        for index, each in enumerate(rows[first : first + room], first)
    )
    return "\n".join((*listed, "", below))


def asked_text(what: str, text: str) -> str:
    """Return the line in which a search is typed."""
    return f"{what}: {text}_   (commas between words; space stops the arm)"


def nothing(sieve: LogFilter) -> str:
    """Return why there is no line in sight."""
    missing = [topic.value for topic in Topic if topic not in sieve.topics]
    reasons = [f"left out: {', '.join(missing)}"] if missing else []
    reasons += [f"only with: {sieve.text}"] if sieve.text else []
    return f"no line ({'; '.join(reasons)})" if reasons else "nothing has passed yet"


def _filled(text: str, width: int) -> str:
    return textwrap.fill(text, max(width, 20), subsequent_indent="  ")
