"""The one catalogue of errors: code, title, cause, effect on the arm, and what to do.

Its rows are in catalogue.txt. Help, docs/reference/errors.md, `--json` and the status take their
codes from there. A row has the name of a class of errors, of a member of `Evidence`, or of a
situation that is neither. Each class of errors has its own code as well, so that an error can be
raised without this table.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from types import MappingProxyType


@dataclass(frozen=True, slots=True)
class CatalogueEntry:
    """One kind of error: its title, and answers to the four questions that a person asks.

    `name` is the class of an error, the member of `Evidence`, or the situation. A `code` is never
    given to another error, so that it can be looked up in any version.
    """

    code: str
    name: str
    title: str
    cause: str
    effect: str
    remedy: str


# Sentences of several rows.
_PHRASES = {
    "LATCHED": "The arm stands still, and error-stop is latched: nothing moves before `reset()`.",
    "STANDS": "The arm stops after its last burst; motors that have current hold it there.",
    "NO_PLANNING": (
        "Planned motion is refused until the arm is referenced; jogging is still allowed."
    ),
    "SUSPECT_LATCHED": (
        "The arm stands still, its position is suspect, and error-stop is latched."
    ),
    "LOOK_RESET_HOME": "Look at the arm, call `reset()`, then `home()`.",
    "LOOK_AND_HOME": "Look at the arm, then call `home()`.",
}

_ROW = re.compile(r"(E\d{3}): (.+) \((\w+)\)")
_LABEL = len("  remedy  ")


def _read(catalogue: str) -> Mapping[str, tuple[CatalogueEntry, ...]]:
    """Return the rows of the catalogue by subject."""
    groups: dict[str, list[CatalogueEntry]] = {}
    subject = ""
    unfolded = catalogue.replace("\n" + " " * _LABEL, " ")
    lines = iter([line for line in unfolded.splitlines() if line and not line.startswith("#")])
    for line in lines:
        row = _ROW.fullmatch(line)
        if row is None:
            subject = line
            continue
        code, title, name = row.groups()
        cause, effect, remedy = (next(lines)[_LABEL:].format(**_PHRASES) for _ in range(3))
        entry = CatalogueEntry(code, name, title, cause, effect, remedy)
        groups.setdefault(subject, []).append(entry)
    return MappingProxyType({subject: tuple(rows) for subject, rows in groups.items()})


# The rows by subject.
GROUPS = _read(Path(__file__).with_name("catalogue.txt").read_text("utf-8"))

# Every row, in the order of the codes.
ENTRIES: tuple[CatalogueEntry, ...] = tuple(row for rows in GROUPS.values() for row in rows)

_BY_NAME = MappingProxyType({row.name: row for row in ENTRIES})
_BY_CODE = MappingProxyType({row.code: row for row in ENTRIES})


def named(name: str) -> CatalogueEntry:
    """Return the row of a class, an evidence or a situation by its name."""
    return _BY_NAME[name]


def entry(error: BaseException) -> CatalogueEntry:
    """Return the row of an error: that of its class, or of the nearest class it derives from."""
    names = (kind.__name__ for kind in type(error).__mro__)
    return next((_BY_NAME[name] for name in names if name in _BY_NAME), _BY_NAME["ArmError"])


def entry_of(evidence: Enum) -> CatalogueEntry | None:
    """Return the row of an evidence; None if it speaks for the position."""
    return _BY_NAME.get(evidence.name)


def code_of_name(name: str) -> str:
    """Return the code of a class of errors or of an evidence; "" if it has no row."""
    row = _BY_NAME.get(name)
    return "" if row is None else row.code


def by_code(code: str) -> CatalogueEntry | None:
    """Return the row of a code, also in brackets or lower case; None if there is none."""
    return _BY_CODE.get(code.strip().strip("[]").upper())


def tagged(error: BaseException) -> str:
    """Return an error's message after its code, as people see it."""
    return f"[{entry(error).code}] {error}"


def advice(error: BaseException) -> str:
    """Return an error's code, what it did to the arm, and what to do."""
    row = entry(error)
    return _plain(f"[{row.code}] {row.effect} {row.remedy}")


def error_view(error: BaseException) -> dict[str, str]:
    """Return an error as plain data: what `--json` prints."""
    row = entry(error)
    return {
        "code": row.code,
        "title": row.title,
        "message": str(error),
        "effect": row.effect,
        "remedy": row.remedy,
    }


# The catalogue as people read it: a list, and one row in full.


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


def _plain(text: str) -> str:
    return text.replace("**", "")
