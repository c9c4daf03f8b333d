"""The CAN adapters of this computer, with the line that opens each. Nothing is opened to find out.

The system knows most of them: its own CAN interfaces, and adapters by their USB numbers. The
drivers of python-can are asked only on request, in a process of its own: they load libraries of
many makers, which may hang, or end the process.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

from armdrive.errors import LinkError
from armdrive.transports.can_refusals import NET, bring_up, can_interfaces

if TYPE_CHECKING:
    from armdrive.transports.ports import PortInfo

USB = Path("/sys/bus/usb/devices")
SLCAN: Mapping[tuple[int, int], str] = MappingProxyType(
    {
        (0xAD50, 0x60C4): "CANable or CANtact with slcan firmware",
        (0x16D0, 0x117E): "CANable 2 with slcan firmware",
        (0x0403, 0xFFA8): "Lawicel CANUSB (slcan)",
    }
)
"""Serial CAN adapters by their USB numbers; those that use their chip maker's are not known."""
CANDLELIGHT: Mapping[tuple[int, int], str] = MappingProxyType(
    {
        (0x1D50, 0x606F): "CANable or other adapter with candleLight firmware (gs_usb)",
        (0x1209, 0x2323): "candleLight (gs_usb)",
        (0x1209, 0xCA01): "CANnectivity adapter (gs_usb)",
        (0x1CD2, 0x606F): "CANext FD (gs_usb)",
        (0x16D0, 0x10B8): "CANdebugger FD (gs_usb)",
    }
)
"""Adapters that are no serial ports (linux/drivers/net/can/usb/gs_usb.c)."""
BITRATE = 500_000
PATIENCE_S = 10.0
_NO_ADAPTERS = ("virtual", "udp_multicast", "serial")
"""Interfaces of python-can that find what is no CAN adapter."""
_ASKING = """
import can, json, logging, sys
logging.disable()
said, sys.stdout = sys.stdout, sys.stderr
names = [name for name in can.VALID_INTERFACES if name not in sys.argv[1:]]
found = can.detect_available_configs(names)
keys = ("interface", "channel")
json.dump([[str(one.get(key, "")) for key in keys] for one in found], said)
said.flush()
"""


@dataclass(frozen=True, slots=True)
class CanPort:
    """One adapter: the port's name that opens it, what it is, and what has to be done before."""

    port: str
    description: str
    todo: str = ""


def list_can_ports(ports: Iterable[PortInfo], net: Path = NET, usb: Path = USB) -> list[CanPort]:
    """Return the adapters that the system knows; `ports` are its serial ports."""
    return [*_of_kernel(net), *_on_serial(ports), *_without_driver(net, usb)]


def ask_drivers(patience_s: float = PATIENCE_S) -> list[CanPort]:
    """Return what the drivers of python-can find. Raises `LinkError` where they do not answer."""
    asking = [sys.executable, "-c", _ASKING, *_NO_ADAPTERS]
    try:
        done = subprocess.run(  # noqa: S603 - our own program
            asking, capture_output=True, timeout=patience_s, check=True, stdin=subprocess.DEVNULL
        )
        found = json.loads(done.stdout)
    except subprocess.TimeoutExpired:
        raise LinkError(
            f"a driver of python-can did not answer within {patience_s:g} s: unplug adapters whose "
            "driver hangs, or name the adapter as can:INTERFACE:CHANNEL without this list"
        ) from None
    except (subprocess.CalledProcessError, OSError, ValueError) as error:
        raise LinkError(
            f"the drivers of python-can cannot be asked ({error}): name the adapter as "
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
    """Return the candleLight adapters that no interface of the kernel belongs to."""
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
