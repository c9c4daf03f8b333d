"""The serial ports of this computer, for people to choose from. No port is opened to find out."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from armdrive.transports.can_address import CanAddress, is_can
from armdrive.transports.holders import Holder, holders
from armdrive.transports.refusals import NoSuchPort, owning_group

if TYPE_CHECKING:
    from collections.abc import Iterable

    from serial.tools.list_ports_common import ListPortInfo

BY_ID = Path("/dev/serial/by-id")
_NOTHING = "n/a"


@dataclass(frozen=True, slots=True)
class PortInfo:
    """One serial port. What is not known is empty or None.

    `vid` and `pid` are the USB numbers. `holder` is the program that has the port open, where
    that can be seen. `readable` says whether this user may read and write it, and `group` whose
    members may. `stable_name` is the name that stays when the port is plugged in elsewhere.
    """

    device: str
    description: str = ""
    vid: int | None = None
    pid: int | None = None
    serial_number: str | None = None
    manufacturer: str | None = None
    holder: Holder | None = None
    readable: bool = True
    group: str | None = None
    stable_name: str | None = None


def list_ports() -> tuple[PortInfo, ...]:
    """Return the serial ports of this computer, by name."""
    found = _found()
    held = holders(info.device for info in found)
    stable = _stable_names()
    return tuple(_info(each, held, stable) for each in found)


def device_names() -> tuple[str, ...]:
    """Return the names of the serial ports alone."""
    return tuple(info.device for info in _found())


def serial_number_of(device: str) -> str:
    """Return the USB serial number behind a port's name; empty where there is none.

    Of a CAN bus it is that of an adapter which is a serial port.
    """
    if is_can(device):
        device = CanAddress.parse(device).device
    if not device:
        return ""
    real = os.path.realpath(device)
    names = (info.serial_number for info in _found() if os.path.realpath(info.device) == real)
    return next(names, None) or ""


def device_of(serial_number: str, before: str = "") -> str:
    """Return the port that has a USB serial number, under whatever name. Raises `NoSuchPort`.

    Adapters that are sold with one number for all of them are told apart by the name `before`.
    Where that is a CAN bus, it is returned with its adapter wherever that is now.
    """
    if is_can(before):
        address = CanAddress.parse(before)
        return str(address.at(device_of(serial_number, address.device)))
    found = _found()
    devices = [info.device for info in found if info.serial_number == serial_number]
    if before and any(os.path.realpath(each) == os.path.realpath(before) for each in devices):
        return before
    if len(devices) == 1:
        return devices[0]
    if devices:
        raise NoSuchPort(
            f"the USB serial number {serial_number} stands on {' and '.join(devices)}: give the "
            "port of the arm as well"
        )
    numbers = [f"{info.serial_number} ({info.device})" for info in found if info.serial_number]
    raise NoSuchPort(
        f"no port has the USB serial number {serial_number} (there are "
        f"{', '.join(numbers) or 'none with a number'}): plug the adapter in, or correct "
        "usb_serial; `armdrive ports` lists them"
    )


def _found() -> list[ListPortInfo]:
    from serial.tools import list_ports as pyserial

    return sorted(_unique(pyserial.comports()), key=lambda info: info.device)


def _unique(infos: Iterable[ListPortInfo]) -> list[ListPortInfo]:
    return list({info.device: info for info in infos}.values())


def _info(found: ListPortInfo, held: dict[str, Holder], stable: dict[str, str]) -> PortInfo:
    description = found.description or ""
    return PortInfo(
        device=found.device,
        description="" if description == _NOTHING else description,
        vid=found.vid,
        pid=found.pid,
        serial_number=found.serial_number,
        manufacturer=found.manufacturer,
        holder=held.get(found.device),
        readable=os.name != "posix" or os.access(found.device, os.R_OK | os.W_OK),
        group=owning_group(found.device),
        stable_name=stable.get(os.path.realpath(found.device)),
    )


def _stable_names() -> dict[str, str]:
    """Return the link that udev has made to each device, where it makes links."""
    try:
        return {os.path.realpath(link): str(link) for link in sorted(BY_ID.iterdir())}
    except OSError:
        return {}
