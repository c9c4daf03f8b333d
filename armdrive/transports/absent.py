"""What stands in a wire's place while it is gone: nothing can be said or heard, only waited."""

from __future__ import annotations

from armdrive.errors import LinkLost
from armdrive.transports.bell import Bell


class AbsentLink:
    """A `Link` without a wire."""

    def __init__(self, description: str) -> None:
        """`description` is what the wire was called."""
        self._description = description
        self._bell = Bell()

    @property
    def description(self) -> str:
        """Name the wire that is gone."""
        return self._description

    def write(self, data: bytes, now_s: float) -> None:  # noqa: ARG002 - as any link
        """Raise `LinkLost`."""
        raise LinkLost(f"there is no wire in place of {self._description}: connect again")

    def read(self, now_s: float) -> bytes:  # noqa: ARG002
        """Raise `LinkLost`."""
        raise LinkLost(f"there is no wire in place of {self._description}: connect again")

    def next_s(self) -> float:
        """Return infinity: nothing comes."""
        return float("inf")

    def wait(self, timeout_s: float) -> None:
        """Sleep until `wake` is called, or the time is over."""
        self._bell.wait(timeout_s)

    def wake(self) -> None:
        """End a `wait` early."""
        self._bell.ring()

    def close(self) -> None:
        """Give up waiting."""
        self._bell.close()
