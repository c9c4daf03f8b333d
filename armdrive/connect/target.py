"""From what a person calls an arm to the parts of a connected one: names, files, ports, twins."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from armdrive.blocking import blocking, coroutine_of
from armdrive.config.arm import ArmConfig
from armdrive.config.sections import Connection
from armdrive.connect.parts import Parts, assemble
from armdrive.connect.port import PortOpening, overheard
from armdrive.connect.reconnect import NewLink
from armdrive.dialog import Operator
from armdrive.errors import ArmFileError, BadRequest, PortUnavailable
from armdrive.registry import DEFAULT, DIALECTS, dialect
from armdrive.registry.arm_files import load_arm, preset_arm
from armdrive.registry.simulate import simulate
from armdrive.runtime.clock import SimulatedClock
from armdrive.runtime.drive import PaceChoice, RealPace, pace_of
from armdrive.storage import files as places
from armdrive.storage.arm_lock import hold
from armdrive.storage.record import FileRecorder, NoRecorder, PositionRecorder
from armdrive.storage.verifications import logbook_file
from armdrive.trace.calls import Tracer
from armdrive.trace.files import recordings
from armdrive.trace.recorder import FlightRecorder
from armdrive.transports.address import is_can
from armdrive.transports.in_process import MemoryLink
from kinematics.errors import suggestion

if TYPE_CHECKING:  # a real arm loads no simulation
    from armdrive.sim.simulated_arm import SimulatedArm

SIM = "sim:"
DEFAULT_TARGET = f"{SIM}{DEFAULT}"
"""What a program connects to that names nothing."""
SIM_PLANNED_BURST_S = 0.5
"""A simulated arm harms nobody: its planned bursts are longer than an unconfigured real arm's."""


@dataclass(frozen=True, slots=True)
class Target:
    """What is to be connected: an arm, and whether its simulated twin stands in for it."""

    config: ArmConfig
    simulated: bool


def find(name: str, *, dialect_name: str | None = None, baud: int | None = None) -> Target:
    """Turn a name into an arm: `sim:DIALECT`, an arm file's name or path, or a port.

    A port needs a dialect, since nothing is sent to find it out. Raises `BadRequest` or
    `ArmFileError` with what is known.
    """
    if name.startswith(SIM):
        return Target(simulated_config(name.removeprefix(SIM)), simulated=True)
    path = _arm_file(name)
    if path is not None:
        return _real_unless_forced(load_arm(path))
    if not _looks_like_port(name):
        raise ArmFileError(_unknown(name))
    if dialect_name is None:
        raise BadRequest(
            f"which dialect does the arm on {name} speak? Give dialect= (or --dialect), one of "
            f"{', '.join(DIALECTS)}; `armdrive doctor {name}` finds it out without moving anything"
        )
    row = dialect(dialect_name)
    wire = Connection(row.name, name, baud or row.baud, row.raise_dtr)
    return _real_unless_forced(preset_arm(row.preset, name=name, connection=wire))


def simulation_forced() -> bool:
    """Tell whether the environment turns every arm into its simulated twin."""
    return os.environ.get("ARMDRIVE_FORCE_SIM", "") not in ("", "0")


def _real_unless_forced(config: ArmConfig) -> Target:
    """Return an arm, or its twin under a name of its own.

    The name keeps the real arm's record, lock and socket out of the twin's hands.
    """
    if simulation_forced():
        return Target(replace(config, name=f"{SIM}{config.name}"), simulated=True)
    return Target(config, simulated=False)


def simulated_config(name: str) -> ArmConfig:
    """Return the arm that speaks a dialect, as a simulated one."""
    row = dialect(name)
    wire = Connection(dialect=row.name, port="", baud=row.baud)
    config = preset_arm(row.preset, name=f"{SIM}{row.name}", connection=wire)
    return replace(config, motion=replace(config.motion, planned_burst_s=SIM_PLANNED_BURST_S))


@dataclass(frozen=True, slots=True, kw_only=True)
class ConnectOptions:
    """The options of `Arm.connect`, which says what each does."""

    dialect: str | None = None
    baud: int | None = None
    pace: PaceChoice = None
    allow_restored: bool = False
    operator: Operator | None = None
    twin: SimulatedArm | None = None
    reconnect: bool | None = None
    clock: SimulatedClock | None = None
    """The time that a simulated arm lives in where `pace` is None. None: a clock of its own."""

    @property
    def simulated_pace(self) -> PaceChoice:
        """The pace of a simulated arm."""
        return self.clock if self.pace is None else self.pace


@blocking
async def connect(target: str | None, options: ConnectOptions) -> Parts:
    """Connect as `Arm.connect` says."""
    found = find(target or DEFAULT_TARGET, dialect_name=options.dialect, baud=options.baud)
    if found.simulated:
        return await coroutine_of(connect_simulated)(
            found.config,
            twin=options.twin,
            pace=options.simulated_pace,
            operator=options.operator,
            allow_restored=options.allow_restored,
            reconnect=options.reconnect,
        )
    if options.pace not in (None, "real", 1.0):
        raise BadRequest("a real arm knows one pace: real time")
    return await coroutine_of(connect_real)(
        found.config,
        allow_restored=options.allow_restored,
        operator=options.operator,
        reconnect=options.reconnect,
    )


@blocking
async def connect_simulated(
    config: ArmConfig,
    *,
    twin: SimulatedArm | None = None,
    pace: PaceChoice = None,
    operator: Operator | None = None,
    recorder: PositionRecorder | None = None,
    allow_restored: bool = False,
    tracer: Tracer | None = None,
    reconnect: bool | None = None,
) -> Parts:
    """Connect to a simulated twin in this process, on simulated time unless `pace` says real."""
    twin = twin or simulate(config)
    parts = await coroutine_of(assemble)(
        config,
        twin.link,
        pace_of(pace),
        simulated=True,
        recorder=recorder or NoRecorder(),
        operator=operator or twin.operator,
        allow_restored=allow_restored,
        tracer=tracer or FlightRecorder(),
        rewiring=_rewiring(twin, automatic=_wanted(reconnect, config)),
    )
    return replace(parts, twin=twin)


@blocking
async def connect_real(
    config: ArmConfig,
    *,
    allow_restored: bool = False,
    operator: Operator | None = None,
    reconnect: bool | None = None,
) -> Parts:
    """Open the arm's port and connect; one program holds an arm at a time.

    With `reconnect` (by default as the arm file says) a lost wire is looked for until it is back.
    Where another dialect answers, the `DeviceFault` says which.
    """
    if simulation_forced():
        raise PortUnavailable(
            f"ARMDRIVE_FORCE_SIM is set, so the port of {config.name} stays closed: connect to its "
            "simulated twin, or clear that variable"
        )
    wiring = PortOpening(config)
    lock = hold(config.name, wiring.find())
    try:
        with overheard(wiring.open(), config.connection) as ears:
            parts = await coroutine_of(assemble)(
                config,
                ears,
                RealPace(),
                simulated=False,
                recorder=FileRecorder(state_file(config.name)),
                allow_restored=allow_restored,
                operator=operator,
                tracer=FlightRecorder(recordings()),
                rewiring=NewLink(wiring.open, automatic=_wanted(reconnect, config), beside=True),
            )
    except BaseException:
        lock.release()
        raise
    return replace(parts, logbook=logbook_file(config.name), lock=lock, closers=(lock.release,))


def state_file(arm: str) -> Path:
    """Return the file in which an arm's position is remembered."""
    return places.states() / f"{places.file_name(arm)}.json"


def _rewiring(twin: SimulatedArm, *, automatic: bool) -> NewLink | None:
    """Return how a twin's wire is taken up again; None where somebody has put another there."""
    return NewLink(twin.link.reopen, automatic) if isinstance(twin.link, MemoryLink) else None


def _wanted(reconnect: bool | None, config: ArmConfig) -> bool:
    """Tell whether a lost wire is looked for: as the caller says, else as the arm file does."""
    return config.connection.reconnect if reconnect is None else reconnect


def _arm_file(name: str) -> Path | None:
    if name.endswith(".toml"):
        return Path(name)
    path = places.arm_files() / f"{name}.toml"
    return path if path.parent == places.arm_files() and path.is_file() else None


def _looks_like_port(name: str) -> bool:
    plain = "/" in name or "\\" in name or "://" in name or name.upper().startswith("COM")
    return plain or is_can(name)


def _unknown(name: str) -> str:
    folder = places.arm_files()
    known = [
        *(path.stem for path in sorted(folder.glob("*.toml"))),
        *(f"{SIM}{each}" for each in DIALECTS),
    ]
    hint = suggestion(name, known)
    return (
        f"no arm is called {name!r}: known are {', '.join(known)}{hint}. Arm files are looked for "
        f"in {folder}; a port is written in full, for example /dev/ttyUSB0"
    )
