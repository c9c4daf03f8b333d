"""The codecs' errors, by the side that made the mistake.

ProtocolError                base class
+-- LocalProtocolError       this program asked for something invalid; nothing was sent
|   +-- BadField             a message field is out of range
+-- RemoteProtocolError      the other side sent something that the dialect does not define
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager


class ProtocolError(ValueError):
    """Base class of the codecs' errors."""


class LocalProtocolError(ProtocolError):
    """The caller asked for something that the dialect does not allow, or not at this time."""


class BadField(LocalProtocolError):
    """A message field has a value that the dialect cannot carry.

    `field` is its name, `value` is the given value, and `allowed` describes the valid values.
    """

    def __init__(self, field: str, value: object, allowed: str) -> None:
        self.field = field
        self.value = value
        self.allowed = allowed
        super().__init__(f"{field} must be {allowed}, not {value!r}")


class RemoteProtocolError(ProtocolError):
    """The other side sent something that is unreadable or out of place."""


@contextmanager
def chosen_by_sender() -> Iterator[None]:
    """Raise `RemoteProtocolError` for a bad field of a message that is made from received bytes.

    Works as a block, and as a decorator of a function that decodes.
    """
    try:
        yield
    except BadField as error:
        raise RemoteProtocolError(str(error)) from None


def whole(field: str, value: object, low: int, high: int) -> int:
    """Return `value` if it is an integer from low to high, or raise `BadField`.

    Booleans, floats and text are refused even if they equal an integer: the caller must decide how
    to round.
    """
    if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
        raise BadField(field, value, f"a whole number from {low} to {high}")
    return value
