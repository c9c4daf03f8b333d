"""What is known of a port while it is closed: asked of the system, arm files and local sockets."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from armdrive.config.arm import ArmConfig
from armdrive.connect.port import PortOpening
from armdrive.dialog import Finding, Grade, note, ok, parted, problem
from armdrive.errors import ArmError, BadRequest, NoSuchPort, PortUnavailable
from armdrive.errors.printable import command_line
from armdrive.registry.arm_files import arm_paths, load_arm
from armdrive.storage.lock_client import is_held, name_held
from armdrive.text.reading import is_there
from armdrive.transports import ports as system
from armdrive.transports.address import CanAddress, is_can, scheme
from armdrive.transports.ports import (
    PSEUDO_TERMINALS,
    PortInfo,
    holder,
    is_readable,
    refusal,
)

# Which arm files a port belongs to, and which armdrive program has it open.


@dataclass(frozen=True, slots=True)
class PortNaming:
    """How an arm file names its port: by its adapter's USB serial number if given, else by name.

    `error` says why a file cannot be used.
    """

    arm: str
    port: str = ""
    usb_serial: str = ""
    error: str = ""

    def find(self) -> str:
        """Return the present name of the arm's port. Raises `NoSuchPort` as connecting would."""
        return system.device_of(self.usb_serial, self.port)

    def owns(self, port: str) -> bool:
        """Return whether a port belongs to the arm, under whichever of its names."""
        try:
            name = self.find()
        except NoSuchPort:
            return False
        return bool(name) and same_port(name, port)

    def missing(self) -> str:
        """Return why the arm's port is missing; empty if it is there or cannot be looked for."""
        try:
            port = serial_device(self.find())
        except NoSuchPort as error:
            return str(error)
        elsewhere = not port or "://" in port or is_can(port) or os.name != "posix"
        there = elsewhere or is_there(Path(port))
        return "" if there else f"its port {port} is missing: check the cable and the name"

    def __str__(self) -> str:
        by = f" (by the USB serial number {self.usb_serial})" if self.usb_serial else ""
        return f"{self.arm}{by}"


def arm_files() -> tuple[PortNaming, ...]:
    """Return how each arm file names its port, with the files that cannot be read."""
    return tuple(map(_naming, arm_paths()))


def _naming(path: Path) -> PortNaming:
    try:
        connection = load_arm(path).connection
    except ArmError as error:
        return PortNaming(path.stem, error=str(error))
    return PortNaming(path.stem, connection.port, connection.usb_serial)


def serial_device(port: str) -> str:
    """Return the serial port that is a CAN adapter; any other port unchanged."""
    try:
        return (CanAddress.parse(port).device if is_can(port) else "") or port
    except BadRequest:  # a mistake in one arm file, which keeps no other port from being looked at
        return port


def same_port(one: str, other: str) -> bool:
    """Return whether two names lead to the same port, such as a CAN adapter's serial port."""
    one, other = serial_device(one), serial_device(other)
    return one == other or (
        "://" not in one + other and os.path.realpath(one) == os.path.realpath(other)
    )


# A port that is looked at, and not opened.

SYSFS = Path("/sys/bus/usb-serial/devices")
# How long an FTDI adapter may hold bytes back; new ones are set to 16.
LATENCY_MS = 1


@dataclass(frozen=True, slots=True)
class ClosedPort:
    """A port or a CAN interface, what is known of it, and whether opening it can succeed.

    `owners` are the arm files that the port belongs to. `driven` is the arm that an armdrive
    program drives on it.
    """

    port: str
    findings: tuple[Finding, ...] = ()
    openable: bool = True
    info: PortInfo = field(default_factory=PortInfo)
    owners: tuple[PortNaming, ...] = ()
    driven: str = ""

    @property
    def arms(self) -> tuple[str, ...]:
        """The arms whose files the port belongs to."""
        return tuple(each.arm for each in self.owners)

    @property
    def lines(self) -> tuple[str, ...]:
        """The findings as text."""
        return lines_of(self.findings)


def lines_of(findings: Sequence[Finding]) -> tuple[str, ...]:
    """Return findings as text, each with its remedy."""
    return tuple(
        f"{'' if each.grade is Grade.OK else each.grade.value + ': '}{each.what}"
        + (f" - {each.fix}" if each.fix else "")
        for each in findings
    )


def closed_ports() -> tuple[ClosedPort, ...]:
    """Return every port and interface that an arm may be connected to. Opens none."""
    listed = system.list_ports()
    namings = arm_files()
    serial = (look_at(each.stable_name or each.device, namings, listed) for each in listed)
    buses = system.list_can_ports(listed)
    return (*serial, *(_closed_bus(each.port, each.description, each.todo) for each in buses))


def _closed_bus(port: str, description: str, todo: str = "") -> ClosedPort:
    findings = (ok(description), *([note(todo)] if todo else []))
    return ClosedPort(port, findings, openable=not todo)


def port_of(config: ArmConfig) -> ClosedPort:
    """Return the port of an arm file, under its present name; an empty name if it is not there."""
    try:
        port = PortOpening(config).find()
    except PortUnavailable as error:
        what, fix = parted(str(error))
        return ClosedPort("", (problem(what, fix),), openable=False)
    connection = config.connection
    own = PortNaming(
        config.name, connection.port, connection.usb_serial
    )  # its file may lie elsewhere
    return look_at(port, (own, *(each for each in arm_files() if each.arm != own.arm)))


def look_at(
    port: str,
    namings: Sequence[PortNaming] | None = None,
    listed: Iterable[PortInfo] | None = None,
) -> ClosedPort:
    """Look at a port without opening it; of a network address the system knows nothing.

    `listed` are the ports that the system knows, if they have been asked for already.
    """
    if is_can(port):
        return _closed_bus(port, "a CAN bus")
    owners = tuple(
        each for each in (arm_files() if namings is None else namings) if each.owns(port)
    )
    belongs = tuple(ok(f"it belongs to the arm file {each}") for each in owners)
    arm = name_held(*(each.arm for each in owners), port)
    driven = arm if is_held(arm) else ""  # the system does not know who opened a pseudo-terminal
    if scheme(port):
        found = (*belongs, *([_in_use(port, driven)] if driven else []))
        return ClosedPort(port, found, not driven, PortInfo(port), owners, driven)
    if os.name == "posix" and not is_there(Path(port)):
        return ClosedPort(port, (_refused(port, errno.ENOENT),), openable=False)
    info = info_of(port, system.list_ports() if listed is None else listed)
    free = info.readable and info.holder is None and not driven
    number = f"USB serial number {info.serial_number}" if info.serial_number else ""
    known = ", ".join(word for word in (info.description, info.usb_id, number) if word)
    words = f"{port} is there{f' ({known})' if known else ''}{', and you may open it' * free}"
    findings = [ok(words), *belongs]
    if not info.readable:
        findings.append(_refused(port, errno.EACCES))
    elif not free:
        findings.append(_in_use(port, driven))
    else:
        findings += latency(port)
    return ClosedPort(port, tuple(findings), free, info, owners, driven)


def info_of(port: str, listed: Iterable[PortInfo]) -> PortInfo:
    """Return what the system knows of a port; little of a port that it does not list.

    A pseudo-terminal is always held by the program that made it. Whether another program has it
    too shows only when it is opened.
    """
    real = os.path.realpath(port)
    for info in listed:
        if os.path.realpath(info.device) == real:
            return info
    held = None if real.startswith(PSEUDO_TERMINALS) else holder(real)
    return PortInfo(port, holder=held, readable=is_readable(port))


def _in_use(port: str, arm: str) -> Finding:
    """Return the finding for a port that a program has open, perhaps to drive an arm."""
    if not arm:
        return _refused(port, errno.EBUSY)
    # a program that was given the port itself knows no other name
    by_port = same_port(arm, port)
    asks = "" if by_port else f"`{command_line('status', '--arm', arm)}` asks it, "
    return problem(
        f"{port} is in use: an armdrive program drives {'an arm' if by_port else arm} on it",
        f"end that program; {asks}`armdrive stop` stops it",
    )


def latency(port: str, sysfs: Path = SYSFS) -> list[Finding]:
    """Report how long a USB adapter may hold bytes back, if the system says so (FTDI on Linux)."""
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


def _refused(port: str, number: int) -> Finding:
    """Return the finding for an error that opening the port would raise, with its remedy."""
    what, fix = parted(str(refusal(port, OSError(number, os.strerror(number)))))
    return problem(what, fix or "name another port")
