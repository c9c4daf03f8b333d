"""A simulated CAN bus with two adapters on it: what one program sends, the other one hears too."""

from __future__ import annotations

from pathlib import Path

from armdrive.transports.can_adapter import Adapter
from armdrive.transports.serve_can import SlcanServer


class TwoAdapters(SlcanServer):
    """A `Server` whose bus a second program can listen to, or speak on, by an adapter of its own.

    Faults strike the first adapter; `second` is a server like it.
    """

    def __init__(self, path: Path | None, beside: Path | None, bits_s: int = 500_000) -> None:
        """Make two pseudo-terminals, linked at paths. Raises `PortUnavailable`."""
        super().__init__(path, Adapter(bits_s))
        self.second = SlcanServer(beside, Adapter(bits_s))

    def filenos(self) -> tuple[int, ...]:
        """What to select on for reading."""
        return (*super().filenos(), *self.second.filenos())

    def read(self) -> bytes:
        """Return the frames that both programs have sent; each hears those of the other."""
        first, other = super().read(), self.second.read()
        if first:
            self.second.write(first)
        if other:
            super().write(other)
        return first + other

    def write(self, data: bytes) -> None:
        """Have both adapters hear frames of the bus."""
        super().write(data)
        self.second.write(data)

    def close(self) -> None:
        """Pull both adapters out."""
        super().close()
        self.second.close()
