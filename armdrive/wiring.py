"""How the wire of a real arm is found and opened, the first time and after it was lost."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from armdrive.errors import PortUnavailable

if TYPE_CHECKING:
    from armdrive.armfile import ArmConfig
    from armdrive.transports.link import Link


class Wiring:
    """The way to one arm: by the USB serial number of its adapter, else by the port's name.

    An adapter that tells a number is remembered by it from the first opening on, since plugged in
    again it may have another name, and its name may be another adapter's.
    """

    def __init__(self, config: ArmConfig) -> None:
        self._wire = config.connection
        self._port = config.connection.port
        self._serial_number = config.connection.usb_serial
        own: tuple[int, ...] = getattr(config.device, "ids", ())
        self._ids: tuple[int, ...] = getattr(config.device, "frame_ids", own)
        if not (self._port or self._serial_number):
            raise PortUnavailable(
                f'the arm file of {config.name} names no port: write port = "/dev/ttyUSB0", say, '
                "or usb_serial, under [connection]"
            )

    def find(self) -> str:
        """Return the port's present name. Raises `NoSuchPort` where no port has the number."""
        from armdrive.transports.ports import device_of

        if self._serial_number:
            self._port = device_of(self._serial_number, self._port)
        return self._port

    def open(self) -> Link:
        """Open the wire, wherever it is now. Raises `PortUnavailable`; sends nothing."""
        from armdrive.transports.ports import serial_number_of
        from armdrive.transports.url import open_link, scheme

        port = self.find()
        link = open_link(
            self._heard(port),
            self._wire.baud,
            raise_dtr=self._wire.raise_dtr,
            keep_dtr_on_close=self._wire.keep_dtr_on_close,
        )
        if not self._serial_number and not scheme(port):
            self._serial_number = serial_number_of(port)
        return link

    def _heard(self, port: str) -> str:
        """Return a port; of a CAN bus, with the ids of what the drives say: no more is heard."""
        from armdrive.transports.can_address import CanAddress, is_can

        if not (self._ids and is_can(port)):
            return port
        address = CanAddress.parse(port)
        return port if address.ids else str(replace(address, ids=frozenset(self._ids)))
