"""A simulated CAN bus for other programs: a serial CAN adapter (slcan) on a pseudo-terminal.

Another program opens `can:slcan:PATH`, or whatever it uses for such adapters. On the simulator's
side packed frames come and go, as on every other server of it.
"""

from __future__ import annotations

from pathlib import Path

from armdrive.transports.can_adapter import Adapter
from armdrive.transports.serve import PtyServer
from firmware_protocol.frames import Unpacker, pack


class SlcanServer:
    """A `Server` whose other end is a serial CAN adapter; its `adapter` can be made to fail.

    Unplugging it (`close`, and `open` again) is pulling the adapter out: it forgets its bit rate
    and that it was open.
    """

    paced = False

    def __init__(self, path: Path | None = None, adapter: Adapter | None = None) -> None:
        """Make the pseudo-terminal, linked at a path. Raises `PortUnavailable`."""
        self.adapter = adapter or Adapter()
        self._port = PtyServer(path)
        self._unpacker = Unpacker()

    @property
    def address(self) -> str:
        """The path of the serial port that others open."""
        return self._port.address

    @property
    def can_address(self) -> str:
        """The same as armdrive takes it."""
        return f"can:slcan:{self.address}?bitrate={self.adapter.bus_bitrate}"

    @property
    def is_open(self) -> bool:
        """Whether the adapter is plugged in."""
        return self._port.is_open

    def open(self, address: str | None = None) -> None:
        """Plug the adapter in, under another name perhaps. Raises `PortUnavailable`."""
        self._port.open(address)

    def filenos(self) -> tuple[int, ...]:
        """What to select on for reading."""
        return self._port.filenos()

    def read(self) -> bytes:
        """Return the frames that the other program has sent, packed; the rest is answered."""
        frames = self.adapter.hear(self._port.read())
        self._answer()
        return b"".join(map(pack, frames))

    def write(self, data: bytes) -> None:
        """Have the adapter hear frames of the bus."""
        for frame in self._unpacker.feed(data):
            self.adapter.show(frame)
        self._answer()

    def close(self) -> None:
        """Pull the adapter out of its port."""
        self._port.close()
        self.adapter.restart()

    def _answer(self) -> None:
        said = self.adapter.say()
        if said:
            self._port.write(said)
