"""Which programs have a device open, read from /proc: nothing is opened to find out.

Only the programs of the same user can be seen, unless one is root; on systems without /proc, none.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

PROC = Path("/proc")


@dataclass(frozen=True, slots=True)
class Holder:
    """A program that has a device open."""

    pid: int
    program: str


def holders(devices: Iterable[str], proc: Path = PROC) -> dict[str, Holder]:
    """Return the first holder of each device that has one; links are followed."""
    wanted: dict[str, list[str]] = {}
    for device in devices:
        wanted.setdefault(os.path.realpath(device), []).append(device)
    found: dict[str, Holder] = {}
    for folder in _processes(proc) if wanted else ():
        for opened in _open_files(folder):
            for device in wanted.get(opened, ()):
                found.setdefault(device, Holder(int(folder.name), _program(folder)))
    return found


def holder(device: str) -> Holder | None:
    """Return who has a device open, where that can be seen."""
    return holders([device]).get(device)


def _processes(proc: Path) -> Iterator[Path]:
    try:
        pids = sorted(int(entry.name) for entry in proc.iterdir() if entry.name.isdecimal())
    except OSError:
        return
    for pid in pids:
        yield proc / str(pid)


def _open_files(process: Path) -> set[str]:
    """Return what a process has open; it may end while it is looked at."""
    opened = set()
    try:
        for link in (process / "fd").iterdir():
            try:
                opened.add(str(link.readlink()))
            except OSError:  # closed since
                continue
    except OSError:  # not ours to look at, or ended
        pass
    return opened


def _program(process: Path) -> str:
    try:
        return (process / "comm").read_text(encoding="utf-8", errors="replace").strip()
    except OSError:
        return "unknown"
