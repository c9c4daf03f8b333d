"""Who connects in the place of a program's own connections: a rehearsal, a run, a test.

What stands in is of the whole process on purpose: a thread that the program starts is no way
around it, since in a rehearsal its connection would move the real arm.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from armdrive.arm import Arm

Standin = Callable[[str | None, Mapping[str, Any]], "Arm | None"]
"""Gets what `Arm.connect` was called with; returns an arm, or None to let it go on as it says.

The target is None where the program named none.
"""

_PRESENT: list[Standin] = []


@contextlib.contextmanager
def standing_in(standin: Standin) -> Iterator[None]:
    """Have every connection of this process made by somebody else meanwhile; the latest counts."""
    _PRESENT.append(standin)
    try:
        yield
    finally:
        _PRESENT.remove(standin)


def stood_in(target: str | None, options: Mapping[str, Any]) -> Arm | None:
    """Return the arm that somebody gives instead; None where nobody stands in."""
    return _PRESENT[-1](target, options) if _PRESENT else None


def anybody() -> bool:
    """Tell whether somebody stands in at present."""
    return bool(_PRESENT)
