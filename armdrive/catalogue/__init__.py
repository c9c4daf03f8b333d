"""The one catalogue of errors: code, title, cause, effect on the arm, and what to do.

Help, docs/errors.md, `--json` and the status take their codes from it. Rows go by the name of a
class of errors, of a member of `Evidence`, or of a situation that is neither; importing it imports
no other part of armdrive that is heavy.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING

from armdrive.catalogue.calls import GENERAL, REFUSALS, REQUESTS, STOPS
from armdrive.catalogue.entry import Entry
from armdrive.catalogue.mathematics import MATHEMATICS
from armdrive.catalogue.positions import POSITIONS
from armdrive.catalogue.wires import BYTES, CONTROLLERS, WIRES
from kinematics.errors import nearest_word

if TYPE_CHECKING:
    from armdrive.trust import Evidence

GROUPS: Mapping[str, tuple[Entry, ...]] = MappingProxyType(
    {
        "Anything": GENERAL,
        "Requests and files": REQUESTS,
        "Refusals": REFUSALS,
        "Stops": STOPS,
        "Ports and wires": WIRES,
        "Controllers": CONTROLLERS,
        "Kinematics": MATHEMATICS,
        "Positions": POSITIONS,
        "Bytes": BYTES,
    }
)
"""The rows by what they are about."""

ENTRIES: tuple[Entry, ...] = tuple(row for rows in GROUPS.values() for row in rows)
"""Every row, in the order of the codes."""

_BY_NAME = MappingProxyType({row.name: row for row in ENTRIES})
_BY_CODE = MappingProxyType({row.code: row for row in ENTRIES})


def named(name: str) -> Entry:
    """Return the row of a class, an evidence or a situation by its name."""
    return _BY_NAME[name]


def entry(error: BaseException) -> Entry:
    """Return the row of an error: its own class's, or the nearest one's that it is made from."""
    names = (kind.__name__ for kind in type(error).__mro__)
    return next((_BY_NAME[name] for name in names if name in _BY_NAME), _BY_NAME["ArmError"])


def entry_of(evidence: Evidence) -> Entry | None:
    """Return the row of an evidence; None of one that speaks for the position."""
    return _BY_NAME.get(evidence.name)


def code_of_reason(reason: str) -> str:
    """Return the code of a trust's reason, which begins with the words of its evidence."""
    from armdrive.trust import Evidence

    for evidence in Evidence:
        if reason.startswith(evidence.value):
            row = entry_of(evidence)
            return "" if row is None else row.code
    return ""


def code_of_class(name: str) -> str:
    """Return the code of a class of errors by its name; nothing where it has no row of its own."""
    row = _BY_NAME.get(name)
    return "" if row is None else row.code


def found(words: str) -> tuple[Entry, ...]:
    """Return the rows in which all these words stand, in any capitals; they are apart by commas."""
    wanted = words.lower().split(",")
    return tuple(row for row in ENTRIES if all(word in _said(row) for word in wanted))


def _said(row: Entry) -> str:
    return " ".join((row.code, row.name, row.title, row.cause, row.effect, row.remedy)).lower()


def by_code(code: str) -> Entry:
    """Return the row of a code. Raises `BadRequest` with the nearest one."""
    from armdrive.errors import BadRequest

    wanted = code.strip().strip("[]").upper()
    if wanted in _BY_CODE:
        return _BY_CODE[wanted]
    near = nearest_word(wanted, _BY_CODE)
    hint = "" if near is None else f"did you mean {near}? "
    raise BadRequest(f"there is no error {code!r}; {hint}`armdrive errors` lists them all")


def tagged(error: BaseException) -> str:
    """Return an error's sentence behind its code, as people are shown it."""
    return f"[{entry(error).code}] {error}"


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
