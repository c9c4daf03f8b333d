"""Why a port could not be opened, as an error of its own kind that says what to do.

PortUnavailable
+-- NoSuchPort        there is no such device, or nothing behind it
+-- PortInUse         another program has it
+-- PortForbidden     the user may not open it
+-- NoConnection      nobody answers at the other end of the network
"""

from __future__ import annotations

import errno
import os
import socket
import sys
from collections.abc import Iterator
from pathlib import Path

from armdrive.errors import PortUnavailable
from armdrive.transports.holders import holder

_ABSENT = frozenset({errno.ENOENT, errno.ENODEV, errno.ENXIO, errno.EIO})
_BUSY = frozenset({errno.EBUSY, errno.EAGAIN})
_FORBIDDEN = frozenset({errno.EACCES, errno.EPERM})
_NOBODY_OF_USE = frozenset({"root", "wheel"})
"""Groups that nobody should be put in for the sake of a port."""


class NoSuchPort(PortUnavailable):
    """There is no such device, or nothing behind it."""


class PortInUse(PortUnavailable):
    """Another program has the port."""


class PortForbidden(PortUnavailable):
    """The user may not open the port."""


class NoConnection(PortUnavailable):
    """Nobody answers at that host and port."""


def refusal(port: str, error: BaseException) -> PortUnavailable:
    """Return the error that says why a device could not be opened and what to do about it."""
    text = str(error)
    number = _number(error)
    if number in _BUSY or "Access is denied" in text:  # the latter is how Windows says it
        return PortInUse(_in_use(port))
    if number in _FORBIDDEN:
        return PortForbidden(_forbidden(port))
    if number in _ABSENT or "FileNotFoundError" in text:
        return NoSuchPort(_absent(port))
    if "Could not configure port" in text:
        return NoSuchPort(
            f"{port} is no serial port, or nothing is connected to it ({text}): "
            "name another port, or check the cable"
        )
    return PortUnavailable(f"{port} cannot be opened ({text}): check its name and its settings")


def no_connection(url: str, error: BaseException) -> PortUnavailable:
    """Return the error that says why a host could not be reached and what to do about it."""
    for cause in _causes(error):
        if isinstance(cause, ConnectionRefusedError):
            return NoConnection(
                f"{url} refused the connection: start the program that listens there, or correct "
                "the port number"
            )
        if isinstance(cause, socket.gaierror):
            return NoConnection(
                f"{url} names a host that is not known ({cause.strerror}): correct the name, or "
                "write the host's address in numbers"
            )
        if isinstance(cause, TimeoutError):
            return NoConnection(
                f"{url} does not answer: check that the host is on and in the same network"
            )
    return NoConnection(f"{url} cannot be reached ({error}): check the address and the network")


def _number(error: BaseException) -> int | None:
    """Return the system's number of an error; pyserial hands it on in one way or another."""
    for cause in _causes(error):
        if isinstance(cause, OSError) and cause.errno is not None:
            return cause.errno
    return None


def _causes(error: BaseException | None) -> Iterator[BaseException]:
    while error is not None:
        yield error
        error = error.__cause__ or error.__context__


def _in_use(port: str) -> str:
    found = holder(port)
    if found is None:
        return f"{port} is in use by another program: end that program first"
    if found.pid == os.getpid():
        return (
            f"{port} is in use by another program or by this one (pid {found.pid}): close the "
            "connection that has it first"
        )
    return (
        f"{port} is in use by another program, {found.program} (pid {found.pid}): end that "
        "program first"
    )


def _forbidden(port: str) -> str:
    group = owning_group(port)
    if group is None or group in _NOBODY_OF_USE:
        return (
            f"no permission to open {port}: it belongs to {group or 'somebody else'} alone; let "
            "the administrator of this computer give its users access, by a udev rule say"
        )
    return (
        f"no permission to open {port}: it belongs to the group {group}. Add yourself with "
        f"`sudo usermod -aG {group} $USER`, then log in again"
    )


def owning_group(port: str) -> str | None:
    """Return the name of the group that owns a device, where there are groups."""
    if sys.platform == "win32":
        return None
    import grp

    try:
        number = Path(port).stat().st_gid
    except OSError:
        return None
    try:
        return grp.getgrgid(number).gr_name
    except KeyError:
        return str(number)


def _absent(port: str) -> str:
    from armdrive.transports.ports import device_names

    names = device_names()
    there = f"there are {', '.join(names)}" if names else "no serial port is there at all"
    return f"there is no port {port} ({there}): check the cable and the name"
