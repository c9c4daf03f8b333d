"""One row of the catalogue of errors: what it is called, and the four things a person asks."""

from __future__ import annotations

from dataclasses import dataclass

NOTHING_SENT = "Nothing was sent, nothing moved."
NO_ARM = "None: no arm is concerned."
STANDS = "The arm stands once its last burst has ended, and is held where its motors have current."


@dataclass(frozen=True, slots=True)
class Entry:
    """One kind of error.

    `name` is the class of an error, the member of `Evidence`, or the situation. A `code` is never
    given to another error, so that it can be looked up in any version.
    """

    code: str
    name: str
    title: str
    cause: str
    effect: str
    remedy: str
