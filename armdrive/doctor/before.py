"""What can be said of a port while it is still closed."""

from __future__ import annotations

import errno
import os
from dataclasses import dataclass
from pathlib import Path

from armdrive.doctor.findings import Finding, note, ok, problem
from armdrive.doctor.owners import held_by_armdrive
from armdrive.transports.holders import holder
from armdrive.transports.ports import PortInfo, list_ports
from armdrive.transports.refusals import owning_group, refusal
from armdrive.transports.url import scheme

SYSFS = Path("/sys/bus/usb-serial/devices")
PSEUDO = "/dev/pts/"
LATENCY_MS = 1
"""What an FTDI adapter should wait at most before it hands bytes on; it comes with 16."""


@dataclass(frozen=True, slots=True)
class Before:
    """The findings, and whether there is any use in opening the port."""

    findings: tuple[Finding, ...]
    openable: bool


def look_at(port: str) -> Before:
    """Look at a port without opening it; of a network address nothing can be said."""
    if scheme(port):
        return Before((), openable=True)
    if not Path(port).exists() and os.name == "posix":
        absent = FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT))
        return Before((_sentence(port, absent),), openable=False)
    info = info_of(port)
    if not info.readable:
        return Before((forbidden(port),), openable=False)
    if info.holder is not None:
        return Before((in_use(port),), openable=False)
    made_here = os.path.realpath(port).startswith(PSEUDO)
    free = "" if made_here else " nobody has it open,"
    found = [ok(f"{port} is there{_described(info)},{free} and you may open it")]
    if info.stable_name and info.stable_name != port:
        found.append(
            note(
                f"{port} may have another name when it is next plugged in",
                f'in an arm file write port = "{info.stable_name}"',
            )
        )
    found += latency(port)
    return Before(tuple(found), openable=True)


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


def in_use(port: str) -> Finding:
    """Return the finding of a port that a program has open."""
    arm = held_by_armdrive(port)
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
    what, colon, mend = str(refusal(port, error)).partition(": ")
    return problem(what, mend) if colon else problem(what, "name another port")
