"""The serial ports and CAN adapters of this computer. Listing them opens none of them."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType

from armdrive.errors import LinkError, NoSuchPort
from armdrive.transports.address import CanAddress, is_can
from armdrive.transports.open_errors import (
    NET,
    PortHolder,
    bring_up,
    can_interfaces,
    holders,
    owning_group,
)

BY_ID = Path("/dev/serial/by-id")
_NOTHING = "n/a"


@dataclass(frozen=True, slots=True)
class PortInfo:
    """One serial port. Unknown fields are empty or None.

    `vid` and `pid` are the USB vendor and product ids. `holder` is the program that has the port
    open, if that is visible. `readable` is whether this user may read and write the port, and
    `group` the group whose members may. `stable_name` stays the same if the port is plugged in
    elsewhere.
    """

    device: str
    description: str = ""
    vid: int | None = None
    pid: int | None = None
    serial_number: str | None = None
    manufacturer: str | None = None
    holder: PortHolder | None = None
    readable: bool = True
    group: str | None = None
    stable_name: str | None = None


def list_ports() -> tuple[PortInfo, ...]:
    """Return the serial ports of this computer, by name."""
    found = _found()
    held = holders(info.device for info in found)
    stable = _stable_names()
    return tuple(
        replace(
            each,
            holder=held.get(each.device),
            readable=os.name != "posix" or os.access(each.device, os.R_OK | os.W_OK),
            group=owning_group(each.device),
            stable_name=stable.get(os.path.realpath(each.device)),
        )
        for each in found
    )


def device_names() -> tuple[str, ...]:
    """Return the names of the serial ports alone."""
    return tuple(info.device for info in _found())


def serial_number_of(device: str) -> str:
    """Return the USB serial number of a port, or of a CAN adapter that is a serial port.

    Empty if there is none.
    """
    if is_can(device):
        device = CanAddress.parse(device).device
    if not device:
        return ""
    real = os.path.realpath(device)
    names = (info.serial_number for info in _found() if os.path.realpath(info.device) == real)
    return next(names, None) or ""


def device_of(serial_number: str, before: str = "") -> str:
    """Return the present name of the port with a USB serial number. Raises `NoSuchPort`.

    Some adapters are all sold with the same number; the former name `before` then decides. If
    `before` is a CAN bus, return its address with the adapter's present port.
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
            f"{' and '.join(devices)} have the same USB serial number {serial_number}: give the "
            "port of the arm as well"
        )
    numbers = [f"{info.serial_number} ({info.device})" for info in found if info.serial_number]
    raise NoSuchPort(
        f"no port has the USB serial number {serial_number} (there are "
        f"{', '.join(numbers) or 'none with a number'}): plug the adapter in, or correct "
        "usb_serial; `armdrive ports` lists them"
    )


def _found() -> list[PortInfo]:
    """Return the ports that pyserial finds, by name."""
    from serial.tools import list_ports as pyserial  # an arm on simulated time needs no ports

    unique = {info.device: info for info in pyserial.comports()}
    return [
        PortInfo(
            device=device,
            description="" if info.description in (None, _NOTHING) else info.description,
            vid=info.vid,
            pid=info.pid,
            serial_number=info.serial_number,
            manufacturer=info.manufacturer,
        )
        for device, info in sorted(unique.items())
    ]


def _stable_names() -> dict[str, str]:
    """Return udev's stable link to each device; none without udev."""
    try:
        return {os.path.realpath(link): str(link) for link in sorted(BY_ID.iterdir())}
    except OSError:
        return {}


# --- CAN adapters, with the address that opens each ----------------------------------------------
#
# The system knows most adapters: its own CAN interfaces, and others by their USB ids. python-can's
# drivers are queried only on request, and in a separate process, because they load libraries of
# many vendors, which may hang or crash.

USB = Path("/sys/bus/usb/devices")
SLCAN: Mapping[tuple[int, int], str] = MappingProxyType(
    {
        (0xAD50, 0x60C4): "CANable or CANtact with slcan firmware",
        (0x16D0, 0x117E): "CANable 2 with slcan firmware",
        (0x0403, 0xFFA8): "Lawicel CANUSB (slcan)",
    }
)
"""Serial CAN adapters by their USB ids; those with the generic ids of their chip are left out."""
CANDLELIGHT: Mapping[tuple[int, int], str] = MappingProxyType(
    {
        (0x1D50, 0x606F): "CANable or other adapter with candleLight firmware (gs_usb)",
        (0x1209, 0x2323): "candleLight (gs_usb)",
        (0x1209, 0xCA01): "CANnectivity adapter (gs_usb)",
        (0x1CD2, 0x606F): "CANext FD (gs_usb)",
        (0x16D0, 0x10B8): "CANdebugger FD (gs_usb)",
    }
)
"""Adapters that are not serial ports (linux/drivers/net/can/usb/gs_usb.c)."""
BITRATE = 500_000
PATIENCE_S = 10.0
_NO_ADAPTERS = ("virtual", "udp_multicast", "serial")
"""Interfaces of python-can that also list devices that are not CAN adapters."""
_DETECT = """
import can, json, logging, sys
logging.disable()
output, sys.stdout = sys.stdout, sys.stderr
names = [name for name in can.VALID_INTERFACES if name not in sys.argv[1:]]
found = can.detect_available_configs(names)
keys = ("interface", "channel")
json.dump([[str(one.get(key, "")) for key in keys] for one in found], output)
output.flush()
"""


@dataclass(frozen=True, slots=True)
class CanPort:
    """One adapter: the address that opens it, a description, and what has to be done first."""

    port: str
    description: str
    todo: str = ""


def list_can_ports(ports: Iterable[PortInfo], net: Path = NET, usb: Path = USB) -> list[CanPort]:
    """Return the adapters known to the system; `ports` are its serial ports."""
    return [*_of_kernel(net), *_on_serial(ports), *_without_driver(net, usb)]


def ask_drivers(patience_s: float = PATIENCE_S) -> list[CanPort]:
    """Return the adapters that python-can's drivers find; raises `LinkError` if they fail."""
    command = [sys.executable, "-c", _DETECT, *_NO_ADAPTERS]
    try:
        done = subprocess.run(  # noqa: S603 - our own program
            command, capture_output=True, timeout=patience_s, check=True, stdin=subprocess.DEVNULL
        )
        found = json.loads(done.stdout)
    except subprocess.TimeoutExpired:
        raise LinkError(
            f"a driver of python-can did not answer within {patience_s:g} s: unplug adapters whose "
            "driver hangs, or name the adapter as can:INTERFACE:CHANNEL without this list"
        ) from None
    except (subprocess.CalledProcessError, OSError, ValueError) as error:
        raise LinkError(
            f"the drivers of python-can cannot be queried ({error}): name the adapter as "
            "can:INTERFACE:CHANNEL without this list"
        ) from None
    return [CanPort(f"can:{name}:{channel}", f"python-can's {name}") for name, channel in found]


def _of_kernel(net: Path) -> list[CanPort]:
    return [
        CanPort(
            f"can:socketcan:{name}",
            "the kernel's CAN interface" + ("" if up else ", which is down"),
            "" if up else f"bring it up with `{bring_up(name)}`",
        )
        for name, up in can_interfaces(net).items()
    ]


def _on_serial(ports: Iterable[PortInfo]) -> list[CanPort]:
    return [
        CanPort(f"can:slcan:{info.device}?bitrate={BITRATE}", SLCAN[info.vid, info.pid])
        for info in ports
        if info.vid is not None and info.pid is not None and (info.vid, info.pid) in SLCAN
    ]


def _without_driver(net: Path, usb: Path) -> list[CanPort]:
    """Return the candleLight adapters without a kernel interface."""
    owned = [str((net / name / "device").resolve()) for name in can_interfaces(net)]
    found: list[CanPort] = []
    for folder in sorted(usb.glob("*")):
        what = CANDLELIGHT.get(_usb_numbers(folder))
        place = str(folder.resolve())
        if what and not any(each.startswith(place) for each in owned):
            todo = "load its driver with `sudo modprobe gs_usb`; it is can:socketcan:can0 then"
            found.append(CanPort(f"can:gs_usb:{len(found)}?bitrate={BITRATE}", what, todo))
    return found


def _usb_numbers(folder: Path) -> tuple[int, int]:
    try:
        vendor, product = (
            int((folder / name).read_text(), 16) for name in ("idVendor", "idProduct")
        )
    except (OSError, ValueError):
        return 0, 0
    return vendor, product
