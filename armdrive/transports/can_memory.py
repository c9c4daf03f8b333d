"""A CAN bus within the process: one end is the engine's, on the other hang simulated drives.

Packed frames take the place of bytes, so that engine, recorder and faults are those of every wire.
"""

from __future__ import annotations

from armdrive.errors import LinkLost
from armdrive.sim.device import WireDevice
from armdrive.sim.pacing import PacedDevice
from armdrive.transports.can_wire import FrameWire, Side
from armdrive.transports.memory import MemoryLink
from firmware_protocol.frames import Frame, Unpacker, pack

BITRATE = 500_000


class BusLine(PacedDevice):
    """A simulated device (all the drives of an arm) behind a bus, in place of a serial line.

    The device is handed packed frames, each at the moment when it has passed, and returns packed
    frames. A message of the fault lanes is one frame; one that they spoil is lost, as by its CRC.
    """

    def __init__(self, device: WireDevice, bitrate: int = BITRATE) -> None:
        super().__init__(device, None)
        self.bus = FrameWire(bitrate)
        self.bus_off = False
        """Whether the host's controller has left the bus: it neither sends nor hears."""
        self._of_host = Unpacker()
        self._heard: list[tuple[float, bytes]] = []

    @property
    def backlog(self) -> int:
        """How many frames of the host have not passed yet."""
        return self.bus.waiting_of(Side.HOST)

    def send(self, data: bytes, now_s: float) -> None:
        """Hand the host's frames to its adapter; half a frame waits for its other half."""
        self.advance(now_s)
        for frame in self._of_host.feed(data):
            if self._on_bus:
                self._pass(frame, Side.HOST, now_s)

    def receive(self, now_s: float) -> bytes:
        """Take the frames that the host has heard by now."""
        self.advance(now_s)
        taken, self._heard = self._heard, []
        return b"".join(data for _, data in taken)

    def next_s(self) -> float:
        """Tell when something next happens on either side; infinity while all is quiet."""
        return self._heard[0][0] if self._heard else self._due_s()

    def unplug(self) -> None:
        """Pull the adapter out: what it had to say is lost; the drives live on."""
        super().unplug()
        self._of_host = Unpacker()
        self._heard.clear()
        self.bus.clear(Side.HOST)

    def say(self, data: bytes, now_s: float) -> None:
        """Have the host hear bytes that no drive has sent, as noise within its adapter."""
        if self._on_bus:
            self._heard.append((now_s, data))

    def leave_bus(self, off: bool = True) -> None:
        """Have the host's controller go bus-off, or come back; what it had to say is lost."""
        self.bus_off = off
        if off:
            self.bus.clear(Side.HOST)
            self._heard.clear()

    @property
    def _on_bus(self) -> bool:
        return self._plugged and not self.bus_off

    def _pass(self, frame: Frame, sender: Side, now_s: float) -> None:
        """Put a frame on the bus, as far as the faults of its lane let it."""
        lane = self.faults.host if sender is Side.HOST else self.faults.device
        if lane.clear:
            self.bus.push(frame, sender, now_s)
            return
        for piece in lane.passed(pack(frame), now_s):
            self._put(piece, sender, now_s)

    def _put(self, piece: bytes, sender: Side, now_s: float) -> None:
        for frame in Unpacker().feed(piece):
            self.bus.push(frame, sender, now_s)

    def _due_s(self) -> float:
        return min(self.bus.next_s(), self.device.next_s(), self.faults.next_s)

    def _exchange(self, now_s: float) -> None:
        for late in self.faults.host.due(now_s):
            self._put(late, Side.HOST, now_s)
        for arrival in self.bus.pull(now_s):
            if arrival.sender is Side.HOST:
                self.device.receive(pack(arrival.frame), now_s)
            elif self._on_bus:
                self._heard.append((now_s, pack(arrival.frame)))
        said = self.device.transmit(now_s)
        for frame in Unpacker().feed(said) if said else ():
            self._pass(frame, Side.DEVICE, now_s)
        for late in self.faults.device.due(now_s):
            self._put(late, Side.DEVICE, now_s)


class CanMemoryLink(MemoryLink):
    """A `Link` to simulated drives over a bus in this process. Only one thread may use it."""

    def __init__(
        self, device: WireDevice, bitrate: int = BITRATE, name: str = "simulated arm"
    ) -> None:
        super().__init__(device, None, name)
        self._bus_line = BusLine(device, bitrate)
        self._line = self._bus_line
        self._bitrate = bitrate

    @property
    def line(self) -> BusLine:
        """The bus; its faults are the wire's."""
        return self._bus_line

    @property
    def description(self) -> str:
        """Name the bus for people."""
        return f"{self._name} on a CAN bus at {self._bitrate // 1000} kbit/s"

    def reopen(self) -> CanMemoryLink:
        """Take the adapter up again, which brings its controller back to the bus."""
        super().reopen()
        self._bus_line.leave_bus(off=False)
        return self

    def _check(self, now_s: float) -> None:
        super()._check(now_s)
        if self._bus_line.bus_off:
            self._line.advance(now_s)  # the drives live on
            raise LinkLost(
                f"the adapter of the {self._name} is bus-off: it saw too many errors and left the "
                "bus. Check the cable, its two terminating resistors and the bit rate, then "
                "connect again"
            )
