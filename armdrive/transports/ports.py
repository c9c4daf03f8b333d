"""The serial ports and CAN adapters of this computer, and why one cannot be opened.

Listing them opens none of them. Each error says what to do about it.
"""

from __future__ import annotations

import contextlib
import errno
import os
import socket
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

# --- Which program has a device open -------------------------------------------------------------
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
    """Return the first holder of each device that has one; links are followed."""
    wanted: dict[str, list[str]] = {}
    for device in devices:
        wanted.setdefault(os.path.realpath(device), []).append(device)
    found: dict[str, PortHolder] = {}
    for folder in _processes() if wanted else ():
        for opened in _open_files(folder):
            for device in wanted.get(opened, ()):
                found.setdefault(device, PortHolder(int(folder.name), _program(folder)))
    return found


def holder(device: str) -> PortHolder | None:
    """Return the program that has a device open, or None if there is none or it is not visible."""
    return holders([device]).get(device)


def terminal_user(device: str) -> PortHolder | None:
    """Return the oldest program whose terminal a device is, or None if it is no one's terminal."""
    try:
        number = Path(device).stat().st_rdev
    except (OSError, ValueError):
        return None
    for folder in _processes() if number else ():
        if _terminal(folder) == number:
            return PortHolder(int(folder.name), _program(folder))
    return None


def _terminal(process: Path) -> int:
    """Return the device number of a process's controlling terminal; 0 if it has none."""
    try:
        after_name = (process / "stat").read_bytes().rpartition(b")")[2].split()
        number = int(after_name[4])
    except (OSError, IndexError, ValueError):  # the process has ended
        return 0
    # proc_pid_stat(5): bits 31 to 20 and 7 to 0 are the minor number, 15 to 8 the major number
    return os.makedev(number >> 8 & 0xFFF, number & 0xFF | number >> 12 & 0xFFF00) if number else 0


def _processes() -> Iterator[Path]:
    try:
        pids = sorted(int(entry.name) for entry in PROC.iterdir() if entry.name.isdecimal())
    except OSError:
        return
    for pid in pids:
        yield PROC / str(pid)


def _open_files(process: Path) -> set[str]:
    """Return the files that a process has open; the process may end meanwhile."""
    opened = set()
    try:
        for link in (process / "fd").iterdir():
            try:
                opened.add(str(link.readlink()))
            except OSError:  # closed meanwhile
                continue
    except OSError:  # another user's process, or ended
        pass
    return opened


def _program(process: Path) -> str:
    try:
        return (process / "comm").read_text(encoding="utf-8", errors="replace").strip()
    except OSError:
        return "unknown"


# --- Serial ports --------------------------------------------------------------------------------

BY_ID = Path("/dev/serial/by-id")
_NOTHING = "n/a"


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
        return "" if self.vid is None or self.pid is None else f"{self.vid:04x}:{self.pid:04x}"


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
        f"no port has the USB serial number {serial_number} (present: "
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


# --- Why a serial port or a host cannot be opened ------------------------------------------------

_ABSENT = frozenset({errno.ENOENT, errno.ENODEV, errno.ENXIO, errno.EIO})
_BUSY = frozenset({errno.EBUSY, errno.EAGAIN})
_FORBIDDEN = frozenset({errno.EACCES, errno.EPERM})
# Groups that grant far too much for us to recommend joining them.
_ADMIN_GROUPS = frozenset({"root", "wheel"})


def refusal(port: str, error: BaseException) -> PortUnavailable:
    """Return the error for a device that could not be opened."""
    text = str(error)
    number = number_of(error)
    if number in _BUSY or "Access is denied" in text:  # the latter on Windows
        return PortInUse(_in_use(port))
    if number in _FORBIDDEN:
        return PortForbidden(_forbidden(port))
    if number in _ABSENT or "FileNotFoundError" in text:
        return NoSuchPort(_absent(port))
    if "Could not configure port" in text:
        return NoSuchPort(
            f"{port} is not a serial port, or nothing is connected to it ({text}): "
            "name another port, or check the cable"
        )
    return PortUnavailable(f"{port} cannot be opened ({text}): check its name and its settings")


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
    if user is None and is_left_link(Path(port)):
        raise PortUnavailable(
            f"{port} is a link that an ended simulator has left: {os.path.realpath(port)} now "
            "belongs to another program. Remove the link, and start the simulator again"
        )
    if user is None:
        return
    way = "end that program, or name another port"
    if Path(port).is_symlink():
        way = f"remove the link if its simulator has ended, or {way}"
    raise PortInUse(
        f"{port} is the terminal of another program, {user.program} (pid {user.pid}): {way}"
    )


def no_connection(url: str, error: BaseException) -> PortUnavailable:
    """Return the error for a host that could not be reached."""
    for cause in causes(error):
        if isinstance(cause, ConnectionRefusedError):
            return NoConnection(
                f"{url} refused the connection: start the program that listens there, or correct "
                "the port number"
            )
        if isinstance(cause, socket.gaierror):
            return NoConnection(
                f"{url} names an unknown host ({cause.strerror}): correct the name, or use the "
                "host's IP address"
            )
        if isinstance(cause, TimeoutError):
            return NoConnection(
                f"{url} does not answer: check that the host is on and in the same network"
            )
    return NoConnection(f"{url} cannot be reached ({error}): check the address and the network")


def _in_use(port: str) -> str:
    found = holder(port)
    if found is None:
        return f"{port} is in use by another program: end that program first"
    if found.pid == os.getpid():
        return (
            f"{port} is in use by another program or by this one (pid {found.pid}): close the "
            "connection that uses it first"
        )
    return (
        f"{port} is in use by another program, {found.program} (pid {found.pid}): end that "
        "program first"
    )


def _forbidden(port: str) -> str:
    group = owning_group(port)
    if group is None or group in _ADMIN_GROUPS:
        return (
            f"no permission to open {port}: it belongs to {group or 'another user'} alone; ask "
            "the administrator of this computer to give users access, for instance by a udev rule"
        )
    return (
        f"no permission to open {port}: it belongs to the group {group}. Add yourself with "
        f"`sudo usermod -aG {group} $USER`, then log in again"
    )


def owning_group(port: str) -> str | None:
    """Return the name of the group that owns a device; None on Windows."""
    if sys.platform == "win32":
        return None
    try:
        number = Path(port).stat().st_gid
    except OSError:
        return None
    try:
        return grp.getgrgid(number).gr_name
    except KeyError:
        return str(number)


def _absent(port: str) -> str:
    found = ", ".join(device_names())
    there = f"present: {found}" if found else "there is no serial port at all"
    return f"there is no port {port} ({there}): check the cable and the name"


# --- CAN adapters, with the address that opens each ----------------------------------------------
#
# The system knows its own CAN interfaces, and serial adapters by their USB ids. The drivers of
# python-can are not asked for others: they load libraries of many vendors, which may hang or crash.

NET = Path("/sys/class/net")
# The kernel's type of a network interface that is a CAN bus (ARPHRD_CAN).
CAN_TYPE = "280"
_UP = 0x1  # IFF_UP


def can_interfaces() -> dict[str, bool]:
    """Return the kernel's CAN interfaces, and whether each is up; none except on Linux."""
    found = {}
    try:
        folders = sorted(NET.iterdir())
    except OSError:
        return {}
    for folder in folders:
        try:
            if (folder / "type").read_text().strip() == CAN_TYPE:
                found[folder.name] = bool(int((folder / "flags").read_text(), 16) & _UP)
        except (OSError, ValueError):  # gone meanwhile
            continue
    return found


def bring_up(channel: str, bitrate: str = "") -> str:
    """Return the command that brings a kernel interface up."""
    return (
        f"sudo ip link set {channel} up type can bitrate {bitrate or 500000} restart-ms 100"
        if not channel.startswith("vcan")
        else f"sudo ip link set {channel} up"
    )


# Serial CAN adapters by their USB ids; those with the generic ids of their chip are left out.
SLCAN: Mapping[tuple[int, int], str] = MappingProxyType(
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


def list_can_ports(ports: Iterable[PortInfo]) -> list[CanPort]:
    """Return the adapters known to the system; `ports` are its serial ports."""
    return [*_of_kernel(), *_on_serial(ports)]


def _of_kernel() -> list[CanPort]:
    return [
        CanPort(
            f"can:socketcan:{name}",
            "the kernel's CAN interface" + ("" if up else ", which is down"),
            "" if up else f"bring it up with `{bring_up(name)}`",
        )
        for name, up in can_interfaces().items()
    ]


def _on_serial(ports: Iterable[PortInfo]) -> list[CanPort]:
    return [
        CanPort(f"can:slcan:{info.device}?bitrate={BITRATE}", SLCAN[info.vid, info.pid])
        for info in ports
        if info.vid is not None and info.pid is not None and (info.vid, info.pid) in SLCAN
    ]


# --- Why a CAN adapter cannot be opened ----------------------------------------------------------
#
# Recognizes python-can's errors without importing python-can.

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


def is_down(address: CanAddress) -> PortUnavailable | None:
    """Return the error for a kernel interface that exists but is down."""
    if address.interface != "socketcan" or can_interfaces().get(address.channel, True):
        return None
    return _down(address)


def _down(address: CanAddress) -> PortUnavailable:
    return PortUnavailable(
        f"the CAN interface {address.channel} is down: bring it up with "
        f"`{bring_up(address.channel, address.option('bitrate'))}`"
    )


def unknown_interface(address: CanAddress, known: Iterable[str]) -> PortUnavailable:
    """Return the error for an interface that python-can does not have, or that is not named."""
    names = sorted(known)
    if not address.interface:
        return PortUnavailable(
            f"{address} names no CAN interface, and python-can's configuration names none: write "
            "can:INTERFACE:CHANNEL, or set CAN_INTERFACE and CAN_CHANNEL, or write ~/.canrc. "
            + SLCAN_OR_NOT
        )
    hint = suggestion(address.interface, names)
    return PortUnavailable(
        f"python-can has no interface {address.interface!r}; it has {', '.join(names)}{hint}"
    )


def can_refusal(address: CanAddress, error: BaseException) -> PortUnavailable:
    """Return the error for an adapter that could not be opened."""
    text = _text(error)
    if missing := _missing(address, error, text):
        return missing
    if not address.channel and (address.on_serial or "channel" in text):
        return PortUnavailable(
            f"{address} names no channel: write can:{address.interface}:CHANNEL. {SLCAN_OR_NOT}"
        )
    if address.device and any(isinstance(cause, OSError) for cause in causes(error)):
        found = refusal(address.device, error)
        if isinstance(found, NoSuchPort):
            return NoSuchPort(f"{found}. {SLCAN_OR_NOT}")
        return found
    if address.interface == "socketcan":
        return _socketcan(address, error, text)
    if address.interface == "gs_usb":
        return _gs_usb(address, error, text)
    return PortUnavailable(
        f"{address} cannot be opened ({text}): check its channel and its options; they are those "
        f"of python-can's interface {address.interface}"
    )


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
    cause = error.__cause__ or error
    why = reason_of(cause)
    if number_of(error) not in _GONE and "disconnected" not in why:
        return ""
    return f"its adapter has gone, or its interface is down ({why})"


def causes(error: BaseException | None) -> Iterator[BaseException]:
    """Yield an error, its cause, the cause of that, and so on."""
    while error is not None:
        yield error
        error = error.__cause__ or error.__context__


def _text(error: BaseException) -> str:
    return str(error).strip() or type(error).__name__


def _missing(address: CanAddress, error: BaseException, text: str) -> PortUnavailable | None:
    """Return the error for an interface whose library is not installed; None for other errors."""
    kinds = (ImportError, NameError)  # some interfaces without their library raise the latter
    absent = "Cannot import" in text or any(isinstance(each, kinds) for each in causes(error))
    if not absent and not any(words in text for words in ("No backend", "library not found")):
        return None
    # pip's extras of python-can are named as its interfaces, but not every interface has one
    extra = address.interface.replace("_", "-")
    how = f"run `pip install 'python-can[{extra}]'`, or install its driver's library"
    if "No backend" in text:
        how = "install libusb (libusb-1.0-0 on Debian, `brew install libusb` on macOS)"
    return PortUnavailable(
        f"python-can's interface {address.interface} lacks what it needs ({text}): {how}"
    )


def _socketcan(address: CanAddress, error: BaseException, text: str) -> PortUnavailable:
    number = number_of(error)
    if number == errno.ENODEV:
        there = ", ".join(can_interfaces()) or "none"
        return NoSuchPort(
            f"there is no CAN interface {address.channel} (there are: {there}): check the adapter. "
            + SLCAN_OR_NOT
        )
    if number == errno.ENETDOWN:
        return _down(address)
    if number == errno.EAFNOSUPPORT or "PF_CAN" in text or os.name != "posix":
        return PortUnavailable(
            f"this system has no SocketCAN ({text}): it needs Linux with the kernel's CAN "
            "modules. " + SLCAN_OR_NOT
        )
    return PortUnavailable(f"{address} cannot be opened ({text}): look at `ip -details link`")


def _gs_usb(address: CanAddress, error: BaseException, text: str) -> PortUnavailable:
    number = number_of(error)
    if number == errno.EACCES:
        return PortForbidden(
            f"no permission to open {address}: a udev rule has to give its USB device to you "
            '(SUBSYSTEM=="usb", ATTR{idVendor}=="1d50", ATTR{idProduct}=="606f", MODE="0666")'
        )
    if number == errno.EBUSY:
        return PortInUse(
            f"{address} is in use: the kernel's own driver has it, so use can:socketcan:can0"
        )
    if "Cannot find device" in text or number == errno.ENODEV:
        return NoSuchPort(f"there is no adapter {address} ({text}). {SLCAN_OR_NOT}")
    return PortUnavailable(f"{address} cannot be opened ({text}). {SLCAN_OR_NOT}")
