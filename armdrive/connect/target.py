"""Finds the arm for a name: an arm file, a port, or a simulated arm."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

from armdrive.config.arm import ArmConfig
from armdrive.config.sections import Connection
from armdrive.errors import ArmFileError, BadRequest, PortUnavailable
from armdrive.errors.printable import command_line
from armdrive.registry import DEFAULT, DIALECTS, dialect
from armdrive.registry.arm_files import (
    ENDING,
    arm_path,
    arm_paths,
    load_arm,
    preset_arm,
)
from armdrive.storage import files as places
from armdrive.text.reading import is_there
from armdrive.transports.address import is_can
from kinematics.errors import suggestion

SIM = "sim:"
# The arm for a program that names none.
DEFAULT_TARGET = f"{SIM}{DEFAULT}"
# Longer than a real arm's default, because a simulated arm can do no harm.
SIM_PLANNED_BURST_S = 0.5


@dataclass(frozen=True, slots=True)
class Target:
    """The arm to connect to, and whether it is simulated."""

    config: ArmConfig
    simulated: bool


def find(name: str, *, dialect_name: str | None = None, baud: int | None = None) -> Target:
    """Return the arm for a name: `sim:DIALECT`, an arm file's name or path, or a port.

    A port needs a dialect, because nothing is sent to find it out. Other arms have one already.
    Raises `BadRequest`, or `ArmFileError`, which lists the known arms.
    """
    if not name:
        raise BadRequest(f"the name of the arm is empty: name one, for example {DEFAULT_TARGET}")
    if name.startswith(SIM):
        target = Target(simulated_config(name.removeprefix(SIM)), simulated=True)
        return _as_named(target, name, dialect_name, baud)
    path = _arm_file(name)
    if path is not None:
        return _as_named(_real_unless_forced(load_arm(path)), name, dialect_name, baud)
    if not _looks_like_port(name):
        raise ArmFileError(_unknown(name))
    if dialect_name is None:
        raise BadRequest(
            f"which dialect does the arm on {name} speak? Give dialect= (or --dialect), one of "
            f"{', '.join(DIALECTS)}; `{command_line('doctor', name)}` finds it out without moving "
            "anything"
        )
    row = dialect(dialect_name)
    connection = Connection(row.name, name, baud or row.baud, row.raise_dtr)
    return _real_unless_forced(preset_arm(name, connection))


def _as_named(target: Target, name: str, dialect_name: str | None, baud: int | None) -> Target:
    """Return an arm that has a dialect and a baud rate. Raises `BadRequest` for different ones."""
    connection = target.config.connection
    for option, value, own in (
        ("dialect", dialect_name, connection.dialect),
        ("baud", baud, connection.baud),
    ):
        if value not in (None, own):
            raise BadRequest(
                f"the {option} of {name} is {own}, not {value}: leave {option} out; only "
                "an arm that is named by its port needs it"
            )
    return target


# The environment variable that replaces every arm with its simulated twin and closes all ports.
FORCE_SIM = "ARMDRIVE_FORCE_SIM"


def simulation_forced() -> bool:
    """Return whether the environment variable replaces every arm with its simulated twin."""
    return os.environ.get(FORCE_SIM, "") not in ("", "0")


def require_real_ports() -> None:
    """Raise `PortUnavailable` if simulation is forced: called before any real port is opened."""
    if simulation_forced():
        raise PortUnavailable(
            f"{FORCE_SIM} is set, so no port is opened: clear that variable, or use a simulated arm"
        )


def _real_unless_forced(config: ArmConfig) -> Target:
    """Return a real arm, or its twin if simulation is forced.

    The twin has a name of its own, and therefore its own record, lock and socket.
    """
    if simulation_forced():
        return Target(replace(config, name=f"{SIM}{config.name}"), simulated=True)
    return Target(config, simulated=False)


@cache
def simulated_config(name: str) -> ArmConfig:
    """Return the simulated arm of a dialect."""
    if not name:
        raise BadRequest(f"{SIM} names no arm: write {SIM}DIALECT, one of {', '.join(DIALECTS)}")
    row = dialect(name)
    connection = Connection(dialect=row.name, port="", baud=row.baud)
    config = preset_arm(f"{SIM}{row.name}", connection)
    return replace(config, motion=replace(config.motion, planned_burst_s=SIM_PLANNED_BURST_S))


def state_file(arm: str) -> Path:
    """Return the file that records an arm's position."""
    return places.states() / f"{places.file_name(arm)}.json"


def _arm_file(name: str) -> Path | None:
    path = arm_path(name)
    named_by_path = name.endswith(ENDING)
    in_folder = path.parent == places.arm_files() and is_there(path)
    return path if named_by_path or in_folder else None


def _looks_like_port(name: str) -> bool:
    plain = "/" in name or "\\" in name or "://" in name or name.upper().startswith("COM")
    return plain or is_can(name)


def _unknown(name: str) -> str:
    folder = places.arm_files()
    known = [
        *(path.stem for path in arm_paths()),
        *(f"{SIM}{each}" for each in DIALECTS),
    ]
    return (
        f"no arm is called {name!r}: known are {', '.join(known)}. Arm files are looked for in "
        f"{folder}; a port is written in full, for example /dev/ttyUSB0"
        f"{suggestion(name, known)}"
    )
