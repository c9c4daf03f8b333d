"""What the codecs refuse, and whose fault it was.

ProtocolError                root of the room
+-- LocalProtocolError       we asked for nonsense: nothing was sent
|   +-- BadField             a field of a message outside its range
+-- RemoteProtocolError      the other side sent what the dialect does not have
"""

from __future__ import annotations


class ProtocolError(ValueError):
    """Root of everything this room refuses."""


class LocalProtocolError(ProtocolError):
    """Our own side asked for something that the dialect does not have, or not now."""


class BadField(LocalProtocolError):
    """A field of a message that is not what the dialect can carry.

    `field` names it, `value` is what was given and `allowed` says in words what fits.
    """

    def __init__(self, field: str, value: object, allowed: str) -> None:
        self.field = field
        self.value = value
        self.allowed = allowed
        super().__init__(f"{field} must be {allowed}, not {value!r}")


class RemoteProtocolError(ProtocolError):
    """The other side sent something that cannot be read, or that does not belong here."""


def whole(field: str, value: object, low: int, high: int) -> int:
    """Return `value` where it is a whole number from low to high, or raise `BadField`.

    Booleans, floats and text are refused, also where they equal a whole number: a float that
    reaches a codec was not rounded by the one who knew how.
    """
    if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
        raise BadField(field, value, f"a whole number from {low} to {high}")
    return value
