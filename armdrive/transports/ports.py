"""The serial ports and CAN adapters of this computer, and why one cannot be opened.

Listing them opens none of them. Each error says what to do about it.
"""

from __future__ import annotations

import contextlib
import errno
import os
import sys
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType

from armdrive.errors import (
    NoConnection,
    NoSuchPort,
    PortForbidden,
    PortInUse,
    PortUnavailable,
)
from armdrive.errors.printable import reason_of
from armdrive.transports.address import BITRATE, CanAddress, is_can
from kinematics.errors import suggestion

if sys.platform != "win32":
    import grp

# Which program has a device open.
#
# Read from /proc, without opening any device. Unless run as root, a program sees only the other
# programs of its user; without /proc it sees none.

PROC = Path("/proc")


@dataclass(frozen=True, slots=True)
class PortHolder:
    """A program that has a device open."""

    pid: int
    program: str


def holders(devices: Iterable[str]) -> dict[str, PortHolder]:
    """Return the first holder of each device that has one, by the device's real path."""
    wanted = {os.path.realpath(device) for device in devices}
    found: dict[str, PortHolder] = {}
    for process in _processes() if wanted else ():
        for device in wanted & _opened(process):
            found.setdefault(device, _named(process))
    return found


def holder(device: str) -> PortHolder | None:
    """Return the program that has a device open, or None if there is none or it is not visible."""
    return next(iter(holders([device]).values()), None)


def terminal_user(device: str) -> PortHolder | None:
    """Return the oldest program whose terminal a device is, or None if it is no one's terminal."""
    try:
        number = Path(device).stat().st_rdev
    except (OSError, ValueError):
        return None
    users = (each for each in _processes() if number and _terminal(each) == number)
    return next(map(_named, users), None)


def _processes() -> list[Path]:
    """Return the folders of the running programs, the oldest first."""
    try:
        return sorted((each for each in PROC.iterdir() if each.name.isdecimal()), key=_pid)
    except OSError:
        return []


def _pid(process: Path) -> int:
    return int(process.name)


def _terminal(process: Path) -> int:
    """Return the device number of a process's controlling terminal; 0 if it has none."""
    try:
        # proc_pid_stat(5): tty_nr is the fifth field after the name, encoded as st_rdev is
        return int((process / "stat").read_bytes().rpartition(b")")[2].split()[4])
    except (OSError, IndexError, ValueError):  # the process has ended
        return 0


def _opened(process: Path) -> set[str]:
    """Return the files that a process has open."""
    opened = set()
    with contextlib.suppress(OSError):  # another user's process, or ended
        for link in (process / "fd").iterdir():
            with contextlib.suppress(OSError):  # closed meanwhile
                opened.add(str(link.readlink()))
    return opened


def _named(process: Path) -> PortHolder:
    try:
        name = (process / "comm").read_text(encoding="utf-8", errors="replace").strip()
    except OSError:
        name = "unknown"
    return PortHolder(_pid(process), name)


# Serial ports.

BY_ID = Path("/dev/serial/by-id")


@dataclass(frozen=True, slots=True)
class PortInfo:
    """One serial port. Unknown fields are empty or None.

    `vid` and `pid` are the USB vendor and product ids. `holder` is the program that has the port
    open, if that is visible. `readable` is whether this user may read and write the port.
    `stable_name` stays the same if the port is plugged in elsewhere.
    """

    device: str = ""
    description: str = ""
    vid: int | None = None
    pid: int | None = None
    serial_number: str | None = None
    manufacturer: str | None = None
    holder: PortHolder | None = None
    readable: bool = True
    stable_name: str | None = None

    @property
    def usb_id(self) -> str:
        """The USB vendor and product ids, as other programs write them; empty without them."""
        return "" if self.vid is None else f"{self.vid:04x}:{self.pid:04x}"


def list_ports() -> tuple[PortInfo, ...]:
    """Return the serial ports of this computer, by name."""
    stable: dict[str, str] = {}
    with contextlib.suppress(OSError):  # without udev
        stable = {os.path.realpath(link): str(link) for link in sorted(BY_ID.iterdir())}
    found = _found()
    held = holders(info.device for info in found)
    return tuple(
        replace(
            info,
            holder=held.get(os.path.realpath(info.device)),
            readable=is_readable(info.device),
            stable_name=stable.get(os.path.realpath(info.device)),
        )
        for info in found
    )


def _found() -> list[PortInfo]:
    """Return the ports as pyserial finds them, without a look at who holds them."""
    from serial.tools import list_ports as pyserial  # an arm on simulated time needs no ports

    unique = {info.device: info for info in pyserial.comports()}
    return [
        PortInfo(
            device,
            "" if info.description in (None, "n/a") else info.description,
            info.vid,
            info.pid,
            info.serial_number,
            info.manufacturer,
        )
        for device, info in sorted(unique.items())
    ]


def is_readable(device: str) -> bool:
    """Return whether this user may read and write a device; other systems than POSIX do not say."""
    return os.name != "posix" or os.access(device, os.R_OK | os.W_OK)


def serial_number_of(device: str) -> str:
    """Return the USB serial number of a port, or of a CAN adapter that is a serial port.

    Empty if there is none.
    """
    if is_can(device):
        device = CanAddress.parse(device).device
    real = os.path.realpath(device) if device else ""
    names = (info.serial_number for info in _found() if os.path.realpath(info.device) == real)
    return next(names, None) or ""


def device_of(serial_number: str, before: str = "") -> str:
    """Return the present name of the port with a USB serial number; `before` without a number.

    Some adapters are all sold with the same number; the former name `before` then decides. If
    `before` is a CAN bus, return its address with the adapter's present port. Raises `NoSuchPort`.
    """
    if not serial_number:
        return before
    if is_can(before):
        address = CanAddress.parse(before)
        return str(address.at(device_of(serial_number, address.device)))
    found = _found()
    devices = [info.device for info in found if info.serial_number == serial_number]
    if any(os.path.realpath(each) == os.path.realpath(before) for each in devices):
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
        f"no port has the USB serial number {serial_number} (present: "
        f"{', '.join(numbers) or 'none with a number'}): plug the adapter in, or correct "
        "usb_serial; `armdrive ports` lists them"
    )


# Why a serial port or a host cannot be opened.

_ABSENT = frozenset({errno.ENOENT, errno.ENODEV, errno.ENXIO, errno.EIO})
_BUSY = frozenset({errno.EBUSY, errno.EAGAIN})
_FORBIDDEN = frozenset({errno.EACCES, errno.EPERM})
# Groups that grant far too much for us to recommend joining them.
_ADMIN_GROUPS = frozenset({"root", "wheel", None})


def refusal(port: str, error: BaseException) -> PortUnavailable:
    """Return the error for a device that could not be opened."""
    text, number = str(error), number_of(error)
    if number in _BUSY or "Access is denied" in text:  # the latter on Windows
        return PortInUse(_in_use(port))
    if number in _FORBIDDEN:
        return PortForbidden(_forbidden(port))
    if number in _ABSENT or "FileNotFoundError" in text:
        found = ", ".join(info.device for info in _found())
        there = f"present: {found}" if found else "there is no serial port at all"
        return NoSuchPort(f"there is no port {port} ({there}): check the cable and the name")
    if "Could not configure port" in text:
        return NoSuchPort(
            f"{port} is not a serial port, or nothing is connected to it ({text}): "
            "name another port, or check the cable"
        )
    return PortUnavailable(f"{port} cannot be opened ({text}): check its name and its settings")


def _in_use(port: str) -> str:
    found = holder(port)
    named = "another program" if found is None else f"{found.program} (pid {found.pid})"
    return f"{port} is in use by {named}: end that program, or close its connection, first"


def _forbidden(port: str) -> str:
    group = owning_group(port)
    if group in _ADMIN_GROUPS:
        todo = "ask the administrator of this computer for access, for instance by a udev rule"
    else:
        todo = f"add yourself to its group with `sudo usermod -aG {group} $USER`, then log in again"
    return f"no permission to open {port}: {todo}"


def owning_group(port: str) -> str | None:
    """Return the name of the group that owns a device; None on Windows, and if it has no name."""
    if sys.platform != "win32":
        with contextlib.suppress(OSError, KeyError):
            return grp.getgrgid(Path(port).stat().st_gid).gr_name
    return None


def no_connection(url: str, error: BaseException) -> PortUnavailable:
    """Return the error for a host that could not be reached."""
    return NoConnection(
        f"{url} cannot be reached ({error}): check the address, that the host is on and in the "
        "same network, and that a program listens there"
    )


# Where Linux makes them, and gives the numbers of closed ones to new ones.
PSEUDO_TERMINALS = "/dev/pts/"


def is_left_link(port: Path) -> bool:
    """Return whether a link is older than the pseudo-terminal that it leads to.

    A program makes the link to its pseudo-terminal after that. Reading and writing a terminal
    leaves its `st_ctime` alone.
    """
    with contextlib.suppress(OSError):  # there is none, or its name is too long
        if port.is_symlink() and os.path.realpath(port).startswith(PSEUDO_TERMINALS):
            return port.lstat().st_mtime_ns < port.stat().st_ctime_ns
    return False


def require_no_terminal(port: str) -> None:
    """Raise `PortInUse` for the terminal of a shell or a login, `PortUnavailable` for an old link.

    What the driver sends would be typed there. A Raspberry Pi's serial port has a login until that
    is switched off. The link of a killed simulator may lead to a terminal that was opened later, or
    to another simulator's arm.
    """
    user = terminal_user(port)
    if user is not None:
        link = "remove the link if its simulator has ended, or " if Path(port).is_symlink() else ""
        raise PortInUse(
            f"{port} is the terminal of another program, {user.program} (pid {user.pid}): {link}"
            "end that program, or name another port"
        )
    if is_left_link(Path(port)):
        raise PortUnavailable(
            f"{port} is a link that an ended simulator has left: {os.path.realpath(port)} now "
            "belongs to another program. Remove the link, and start the simulator again"
        )


# CAN adapters, with the address that opens each.
#
# The system knows its own CAN interfaces, and serial adapters by their USB ids. The drivers of
# python-can are not asked for others: they load libraries of many vendors, which may hang or crash.

NET = Path("/sys/class/net")
# The kernel's type of a network interface that is a CAN bus (ARPHRD_CAN).
CAN_TYPE = "280"
_UP = 0x1  # IFF_UP

# Serial CAN adapters by their USB ids; those with the generic ids of their chip are left out.
SLCAN: Mapping[tuple[int | None, int | None], str] = MappingProxyType(
    {
        (0xAD50, 0x60C4): "CANable or CANtact with slcan firmware",
        (0x16D0, 0x117E): "CANable 2 with slcan firmware",
        (0x0403, 0xFFA8): "Lawicel CANUSB (slcan)",
    }
)


@dataclass(frozen=True, slots=True)
class CanPort:
    """One adapter: the address that opens it, a description, and what has to be done first."""

    port: str
    description: str
    todo: str = ""


def can_interfaces() -> dict[str, bool]:
    """Return the kernel's CAN interfaces, and whether each is up; none except on Linux."""
    found = {}
    for folder in sorted(NET.iterdir()) if NET.is_dir() else ():
        with contextlib.suppress(OSError, ValueError):  # gone meanwhile
            if (folder / "type").read_text().strip() == CAN_TYPE:
                found[folder.name] = bool(int((folder / "flags").read_text(), 16) & _UP)
    return found


def bring_up(channel: str, bitrate: str = "") -> str:
    """Return the command that brings a kernel interface up."""
    rate = f" type can bitrate {bitrate or BITRATE} restart-ms 100"
    return f"sudo ip link set {channel} up{'' if channel.startswith('vcan') else rate}"


def list_can_ports(ports: Iterable[PortInfo]) -> list[CanPort]:
    """Return the adapters known to the system; `ports` are its serial ports."""
    of_kernel = [
        CanPort(
            f"can:socketcan:{name}",
            "the kernel's CAN interface",
            "" if up else f"bring it up with `{bring_up(name)}`",
        )
        for name, up in can_interfaces().items()
    ]
    on_serial = [
        CanPort(f"can:slcan:{info.device}?bitrate={BITRATE}", SLCAN[info.vid, info.pid])
        for info in ports
        if (info.vid, info.pid) in SLCAN
    ]
    return of_kernel + on_serial


# Why a CAN adapter cannot be opened, from python-can's errors, without importing python-can.

_GONE = frozenset({errno.ENODEV, errno.ENXIO, errno.EIO, errno.ENETDOWN, errno.EBADF})
SLCAN_OR_NOT = (
    "A CANable with slcan firmware is a serial port: can:slcan:/dev/ttyACM0?bitrate=500000; with "
    "candleLight firmware it is not: can:socketcan:can0 on Linux, can:gs_usb:0?bitrate=500000 "
    "elsewhere"
)
NOT_INSTALLED = (
    "python-can is not installed, and every CAN bus needs it: run `pip install python-can` in the "
    "environment that armdrive is in"
)
# What python-can's interfaces say if their library is missing; some raise a NameError.
_NO_LIBRARY = ("Cannot import", "No backend", "library not found")
# Advice on an adapter that cannot be opened, by its interface.
_ADVICE: Mapping[str, str] = MappingProxyType(
    {
        "socketcan": "check its name with `ip -details link`; it needs Linux with the kernel's CAN "
        f"modules. {SLCAN_OR_NOT}",
        "gs_usb": "if the kernel's own driver has it, use can:socketcan:can0; if you have no "
        'permission, a udev rule gives it to you (SUBSYSTEM=="usb", ATTR{idVendor}=="1d50", '
        f'ATTR{{idProduct}}=="606f", MODE="0666"). {SLCAN_OR_NOT}',
    }
)


def is_down(address: CanAddress) -> PortUnavailable | None:
    """Return the error for a kernel interface that exists but is down."""
    if address.interface != "socketcan" or can_interfaces().get(address.channel, True):
        return None
    return PortUnavailable(
        f"the CAN interface {address.channel} is down: bring it up with "
        f"`{bring_up(address.channel, address.option('bitrate'))}`"
    )


def unknown_interface(address: CanAddress, known: Iterable[str]) -> PortUnavailable:
    """Return the error for an interface that python-can does not have, or that is not named."""
    names = sorted(known)
    if address.interface:
        return PortUnavailable(
            f"python-can has no interface {address.interface!r}; it has {', '.join(names)}"
            f"{suggestion(address.interface, names)}"
        )
    return PortUnavailable(
        f"{address} names no CAN interface, and python-can's configuration names none: write "
        f"can:INTERFACE:CHANNEL, or set CAN_INTERFACE and CAN_CHANNEL, or write ~/.canrc. "
        f"{SLCAN_OR_NOT}"
    )


def can_refusal(address: CanAddress, error: BaseException) -> PortUnavailable:
    """Return the error for an adapter that could not be opened."""
    text = str(error).strip() or type(error).__name__
    no_library = any(isinstance(each, ImportError | NameError) for each in causes(error))
    if no_library or any(words in text for words in _NO_LIBRARY):
        # pip's extras of python-can are named as its interfaces, but not every interface has one
        return PortUnavailable(
            f"python-can's interface {address.interface} lacks what it needs ({text}): run `pip "
            f"install 'python-can[{address.interface.replace('_', '-')}]'`, or install its "
            "driver's library (of gs_usb: libusb)"
        )
    if address.device and any(isinstance(cause, OSError) for cause in causes(error)):
        found = refusal(address.device, error)
        return NoSuchPort(f"{found}. {SLCAN_OR_NOT}") if isinstance(found, NoSuchPort) else found
    number, kind = number_of(error), PortUnavailable
    if number in _FORBIDDEN:
        kind = PortForbidden
    elif number in _BUSY:
        kind = PortInUse
    elif number == errno.ENODEV or "Cannot find device" in text:
        kind = NoSuchPort
    advice = _ADVICE.get(
        address.interface,
        "check its channel and its options; they are those of python-can's interface "
        f"{address.interface}",
    )
    return kind(f"{address} cannot be opened ({text}): {advice}")


def number_of(error: BaseException) -> int | None:
    """Return an error's errno, wherever pyserial or python-can has put it."""
    for cause in causes(error):
        for name in ("errno", "error_code"):
            number = getattr(cause, name, None)
            if isinstance(number, int):
                return number
    return None


def gone_words(error: BaseException) -> str:
    """Describe an adapter that has gone or an interface that went down; empty for other errors."""
    why = reason_of(error.__cause__ or error)
    if number_of(error) not in _GONE and "disconnected" not in why:
        return ""
    return f"its adapter has gone, or its interface is down ({why})"


def causes(error: BaseException | None) -> Iterator[BaseException]:
    """Yield an error, its cause, the cause of that, and so on."""
    while error is not None:
        yield error
        error = error.__cause__ or error.__context__
