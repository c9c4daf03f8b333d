"""Who has a port, and which arm files name it: asked of files and local sockets alone."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from armdrive import places
from armdrive.errors import ArmError
from armdrive.holder import ask_holder


@dataclass(frozen=True, slots=True)
class Naming:
    """An arm file that names a port; `error` says why one cannot be used."""

    arm: str
    port: str
    error: str = ""


def arm_files() -> tuple[Naming, ...]:
    """Return the ports that the arm files name, and the files that cannot be read."""
    return tuple(map(_naming, sorted(places.arm_files().glob("*.toml"))))


def _naming(path: Path) -> Naming:
    from armdrive.armfile import load_arm_file

    try:
        return Naming(path.stem, load_arm_file(path).connection.port)
    except ArmError as error:
        return Naming(path.stem, "", str(error))


def naming(port: str, namings: Iterable[Naming]) -> tuple[str, ...]:
    """Return the arms whose files name a port, by whichever of its names."""
    return tuple(each.arm for each in namings if each.port and same_port(each.port, port))


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
