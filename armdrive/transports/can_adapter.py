"""A simulated serial CAN adapter: lines of slcan in, lines out, frames to its bus and from it.

It is a Lawicel adapter: a command is answered by CR or the bell, a frame that was taken by `z` or
`Z`, and `F`, `V` and `N` by words. Timestamps are off.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from armdrive.transports.can_slcan_text import BELL, CR, ON_BUS, Lines, frame_of, line_of
from firmware_protocol.frames import Frame

BITRATES: Mapping[bytes, int] = MappingProxyType(
    {
        b"0": 10_000,
        b"1": 20_000,
        b"2": 50_000,
        b"3": 100_000,
        b"4": 125_000,
        b"5": 250_000,
        b"6": 500_000,
        b"7": 750_000,
        b"8": 1_000_000,
    }
)
VERSION = b"V1013"
SERIAL_NUMBER = b"NA123"
_PASSIVE, _BUS_ERRORS = 0x20, 0x80


@dataclass(slots=True)
class AdapterFaults:
    """What is wrong with the adapter or its bus; nothing, unless somebody says so."""

    bus_off: bool = False
    """Its controller has left the bus, until the channel is closed and opened again."""
    alone: bool = False
    """No other node is there to acknowledge a frame."""
    mute: bool = False
    """It answers no command, as the CANable's first firmware does; `V` excepted."""
    dead: bool = False
    """It has hung: nothing at all comes from it."""


class Adapter:
    """The device's side of slcan."""

    def __init__(self, bus_bitrate: int = 500_000) -> None:
        self.bus_bitrate = bus_bitrate
        self.faults = AdapterFaults()
        self.refused = 0
        """How many frames of its host it did not send."""
        self._bitrate = 0
        self._open = False
        self._listens = False
        self._lines = Lines()
        self._said = bytearray()
        self._sent: list[Frame] = []

    @property
    def on_bus(self) -> bool:
        """Whether frames pass, in one direction at least."""
        return self._open and self._bitrate == self.bus_bitrate and not self.faults.bus_off

    def hear(self, data: bytes) -> list[Frame]:
        """Take what the host says; return the frames that go out to the bus."""
        for line in self._lines.feed(data):
            if not self.faults.dead:
                self._obey(line)
        sent, self._sent = self._sent, []
        return sent

    def show(self, frame: Frame) -> None:
        """Hear a frame of the bus."""
        if self.on_bus and not self.faults.dead:
            self._said += line_of(frame)

    def say(self) -> bytes:
        """Take what the adapter has to say to its host."""
        said = bytes(self._said)
        self._said.clear()
        return said

    def restart(self) -> None:
        """Lose the power: everything that the host has set is forgotten."""
        self._open, self._bitrate, self._lines = False, 0, Lines()
        self._said.clear()

    def _obey(self, line: bytes) -> None:
        order, rest = line[:1], line[1:]
        if order == b"":
            self._reply(CR)
        elif order in (b"V", b"N"):
            self._said += (VERSION if order == b"V" else SERIAL_NUMBER) + CR
        elif order[0] in ON_BUS:
            self._transmit(line)
        elif order == b"F" and self._open:
            self._reply(b"F%02X" % self._status() + CR)
        else:
            change = _ORDERS.get(order)
            self._reply(CR if change is not None and change(self, rest) else BELL)

    def _reply(self, words: bytes) -> None:
        if not self.faults.mute:
            self._said += words

    def _transmit(self, line: bytes) -> None:
        frame = frame_of(line)
        troubled = self.faults.alone or not self.on_bus or self._listens
        if frame is None or troubled:
            self.refused += 1
            self._reply(BELL)
            return
        self._sent.append(frame)
        self._reply((b"Z" if frame.extended else b"z") + CR)

    def _status(self) -> int:
        if self.faults.bus_off:
            return _PASSIVE | _BUS_ERRORS
        return _PASSIVE if self.refused and (self.faults.alone or not self.on_bus) else 0

    def _set_up(self, rest: bytes) -> bool:
        if self._open or rest not in BITRATES:
            return False
        self._bitrate = BITRATES[rest]
        return True

    def _begin(self, rest: bytes, *, listens: bool = False) -> bool:
        if self._open or rest or not self._bitrate:
            return False
        self._open, self._listens, self.refused = True, listens, 0
        return True

    def _listen(self, rest: bytes) -> bool:
        return self._begin(rest, listens=True)

    def _end(self, rest: bytes) -> bool:
        was, self._open = self._open, False
        self.faults.bus_off = False
        return was and not rest

    def _stamp(self, rest: bytes) -> bool:
        return rest == b"0"


_ORDERS: Mapping[bytes, Callable[[Adapter, bytes], bool]] = MappingProxyType(
    {
        b"S": Adapter._set_up,  # noqa: SLF001 - the table of the class itself
        b"O": Adapter._begin,  # noqa: SLF001
        b"L": Adapter._listen,  # noqa: SLF001
        b"C": Adapter._end,  # noqa: SLF001
        b"Z": Adapter._stamp,  # noqa: SLF001
    }
)
