"""A simulated arm on a CAN bus for other programs: its drives behind a serial CAN adapter."""

from __future__ import annotations

from armdrive.sim.device import WireDevice
from armdrive.transports.can_adapter import Adapter
from armdrive.transports.can_memory import BusLine


class AdapterBus(BusLine):
    """A bus whose host is a simulated adapter: that is what leaves it, and comes back."""

    def __init__(self, device: WireDevice, adapter: Adapter) -> None:
        self.adapter = adapter
        super().__init__(device, adapter.bus_bitrate)

    @property
    def bus_off(self) -> bool:
        """Whether the adapter has left the bus; its host ends that by opening it anew."""
        return self.adapter.faults.bus_off

    @bus_off.setter
    def bus_off(self, off: bool) -> None:
        self.adapter.faults.bus_off = off
