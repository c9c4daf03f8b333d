"""What can be said of a port while it is still closed."""

from __future__ import annotations

import contextlib
import errno
import os
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from armdrive.dialog.conversation import Finding, note, ok, problem
from armdrive.errors import ArmError, NoSuchPort
from armdrive.registry.arm_files import arm_paths, load_arm
from armdrive.storage.lock_client import ask_holder
from armdrive.text.toml import value as toml
from armdrive.transports.address import scheme
from armdrive.transports.open_errors import holder, owning_group, refusal
from armdrive.transports.ports import PortInfo, device_names, device_of, list_ports

# Who has a port, and which arm files it belongs to: asked of files and local sockets alone.


@dataclass(frozen=True, slots=True)
class PortNaming:
    """Which port an arm file names, by a USB serial number if it gives one, else by its name.

    `error` says why a file cannot be used.
    """

    arm: str
    port: str = ""
    usb_serial: str = ""
    error: str = ""

    def find(self) -> str:
        """Return the present name of the arm's port. Raises `NoSuchPort` as connecting would."""
        return device_of(self.usb_serial, self.port) if self.usb_serial else self.port


@dataclass(frozen=True, slots=True)
class PortOwner:
    """An arm file that a port belongs to, and by what: a name, or the number of its adapter."""

    arm: str
    usb_serial: str = ""

    def __str__(self) -> str:
        by = f" (by the USB serial number {self.usb_serial})" if self.usb_serial else ""
        return f"{self.arm}{by}"


def arm_files() -> tuple[PortNaming, ...]:
    """Return the ports that the arm files name, and the files that cannot be read."""
    return tuple(map(_naming, arm_paths()))


def _naming(path: Path) -> PortNaming:
    try:
        wire = load_arm(path).connection
    except ArmError as error:
        return PortNaming(path.stem, error=str(error))
    return PortNaming(path.stem, wire.port, wire.usb_serial)


def owners_of(port: str, namings: Iterable[PortNaming]) -> tuple[PortOwner, ...]:
    """Return the arm files that a port belongs to, under whichever of its names."""
    found = []
    for each in namings:
        with contextlib.suppress(NoSuchPort):
            name = each.find()
            if name and same_port(name, port):
                found.append(PortOwner(each.arm, each.usb_serial))
    return tuple(found)


def strangers_to(port: str, namings: Iterable[PortNaming]) -> tuple[PortNaming, ...]:
    """Return the arm files that have a port's name, but want an adapter that it is not."""
    namings = [each for each in namings if each.usb_serial and each.port]
    owners = [owner.arm for owner in owners_of(port, namings)]
    return tuple(each for each in namings if same_port(each.port, port) and each.arm not in owners)


def same_port(one: str, other: str) -> bool:
    """Tell whether two names lead to one port."""
    if "://" in one or "://" in other:
        return one == other
    return os.path.realpath(one) == os.path.realpath(other)


def held_by_armdrive(port: str, arms: Iterable[str] = ()) -> str:
    """Return the arm as which an armdrive program holds a port; empty where none does."""
    for name in (port, os.path.realpath(port), *arms):
        with contextlib.suppress(ArmError):
            told = ask_holder(name, "status")
            return str(told.get("arm") or name)
    return ""


SYSFS = Path("/sys/bus/usb-serial/devices")
PSEUDO = "/dev/pts/"
LATENCY_MS = 1
"""What an FTDI adapter should wait at most before it hands bytes on; it comes with 16."""


@dataclass(frozen=True, slots=True)
class Before:
    """The findings, and whether there is any use in opening the port.

    `owners` are the arms whose files the port belongs to, and `usb_serial` its adapter's number.
    """

    findings: tuple[Finding, ...]
    openable: bool
    owners: tuple[str, ...] = ()
    usb_serial: str = ""


def look_at(port: str, files: Iterable[PortNaming] = ()) -> Before:
    """Look at a port without opening it; of a network address only its arm files are known."""
    files = tuple(files)
    belongs, owners = _belongs(port, files)
    if scheme(port):
        return Before(tuple(belongs), True, owners)
    if not Path(port).exists() and os.name == "posix":
        absent = FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT))
        return Before((_sentence(port, absent),), openable=False)
    info = info_of(port)
    if not info.readable:
        return Before((forbidden(port),), openable=False)
    if info.holder is not None:
        return Before((in_use(port, owners), *belongs), openable=False)
    made_here = os.path.realpath(port).startswith(PSEUDO)
    free = "" if made_here else " nobody has it open,"
    found = [ok(f"{port} is there{_described(info)},{free} and you may open it")]
    found += belongs
    by_number = any(each.arm in owners and each.usb_serial for each in files)
    if not by_number:
        found += _name_that_stays(port, info)
    found += latency(port)
    return Before(tuple(found), True, owners, info.serial_number or "")


def unfound(error: ArmError) -> Before:
    """Return what is to be said where the port of an arm file is not to be found."""
    what, _, mend = str(error).partition(": ")
    return Before((problem(what, mend),), openable=False)


def _belongs(port: str, files: tuple[PortNaming, ...]) -> tuple[list[Finding], tuple[str, ...]]:
    """Say which arm files a port belongs to, and which only name it."""
    owners = owners_of(port, files)
    found = [ok(f"it belongs to the arm file {each}") for each in owners]
    found += [
        note(
            f"the arm file {each.arm} names {port}, but wants the adapter with the USB serial "
            f"number {each.usb_serial}, which this is not",
            f"`armdrive doctor --arm {each.arm}` looks for that adapter",
        )
        for each in strangers_to(port, files)
    ]
    return found, tuple(each.arm for each in owners)


def _name_that_stays(port: str, info: PortInfo) -> list[Finding]:
    """Say how an arm file finds the port again, where that is surer than by its name."""
    if info.serial_number:
        mend = f"in an arm file write usb_serial = {toml(info.serial_number)}"
    elif info.stable_name and info.stable_name != port:
        mend = f"in an arm file write port = {toml(info.stable_name)}"
    else:
        return []
    return [note(f"{port} may have another name when it is next plugged in", mend)]


def info_of(port: str) -> PortInfo:
    """Return what is known of a port: of one that no list names, little.

    A pseudo-terminal is always held by the program that made it; who else has it is seen when it
    is opened.
    """
    real = os.path.realpath(port)
    for info in list_ports():
        if os.path.realpath(info.device) == real:
            return info
    readable = os.name != "posix" or os.access(port, os.R_OK | os.W_OK)
    held = None if real.startswith(PSEUDO) else holder(real)
    return PortInfo(port, holder=held, readable=readable, group=owning_group(real))


def forbidden(port: str) -> Finding:
    """Return the finding of a port that this user may not open."""
    return _sentence(port, PermissionError(errno.EACCES, os.strerror(errno.EACCES)))


def in_use(port: str, owners: Iterable[str] = ()) -> Finding:
    """Return the finding of a port that a program has open, perhaps for one of these arms."""
    arm = held_by_armdrive(port, owners)
    if arm:
        return problem(
            f"{port} is in use: an armdrive program drives {arm} on it",
            f"end that program; `armdrive status --arm {arm}` asks it, `armdrive stop` stops it",
        )
    return _sentence(port, OSError(errno.EBUSY, os.strerror(errno.EBUSY)))


def latency(port: str, sysfs: Path = SYSFS) -> list[Finding]:
    """Look at how long a USB adapter may hold bytes back, where it says so (FTDI on Linux)."""
    path = sysfs / Path(os.path.realpath(port)).name / "latency_timer"
    try:
        found_ms = int(path.read_text(encoding="ascii"))
    except (OSError, ValueError):
        return []
    if found_ms <= LATENCY_MS:
        return [ok(f"the adapter's latency timer is {found_ms} ms")]
    return [
        note(
            f"the adapter holds answers back for up to {found_ms} ms (its latency timer)",
            f"echo {LATENCY_MS} | sudo tee {path}",
        )
    ]


def _described(info: PortInfo) -> str:
    numbers = "" if info.vid is None or info.pid is None else f"{info.vid:04x}:{info.pid:04x}"
    words = ", ".join(word for word in (info.description, numbers) if word)
    return f" ({words})" if words else ""


def _sentence(port: str, error: OSError) -> Finding:
    """Return what opening would be refused with: what is wrong, and what to do about it."""
    what, colon, mend = str(refusal(port, error, device_names)).partition(": ")
    return problem(what, mend) if colon else problem(what, "name another port")
