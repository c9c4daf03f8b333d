"""Commissions the drives of an arm. MKS drives get ids and settings.

Of CiA 402 drives it measures the units.
"""

from __future__ import annotations

import argparse
import contextlib
from collections.abc import Iterator
from dataclasses import dataclass

from armdrive.cli.presenter import Result, say, say_lines, tell
from armdrive.cli.questions import TerminalPerson, ask_yes_no
from armdrive.cli.set_up.arm_trials import Attendance, attendance
from armdrive.config.arm import ArmConfig
from armdrive.config.sections import Connection
from armdrive.connect.control_socket import serve_stop
from armdrive.connect.port import PortOpening
from armdrive.dialects.bus.tools import BusTools, UnitKeys
from armdrive.dialog import DialogPerson
from armdrive.errors import BadRequest
from armdrive.errors.printable import command_line
from armdrive.registry import DIALECTS, simulate
from armdrive.registry.arm_files import (
    ENDING,
    arm_path,
    load_arm,
    preset_arm,
    require_name,
)
from armdrive.setup import dialog_runner
from armdrive.setup.commissioning import (
    CommissioningPlan,
    commission,
    commissionable,
    measure_units,
    plan_of,
)
from armdrive.setup.dialog_runner import Clock, DialogClock, drive_dialog
from armdrive.setup.filing import (
    FileProposal,
    after_writing,
    propose_drives,
    propose_keys,
)
from armdrive.storage.arm_lock import hold
from armdrive.storage.files import kept_aside, require_writable
from armdrive.text.reading import is_there
from armdrive.transports import opening
from armdrive.transports.address import is_can
from armdrive.transports.link import Link

DONE, UNFINISHED = 0, 1


def set_up(options: argparse.Namespace) -> Iterator[Result]:
    """Hold the dialog, then write the arm file."""
    attended = attendance(options, "plug real drives in and watch their motors")
    if attended.simulated and options.port:
        raise BadRequest("--sim needs no --port: the drives are in this program")
    config = _config(options.name)
    bus = DIALECTS[config.connection.dialect].bus
    if bus is not None and bus.units is not None:
        return _measure(config, bus, bus.units, options, attended)
    plan = plan_of(config)
    if not is_there(arm_path(options.name)):
        tell(
            options,
            f"There is no arm file named {options.name} yet: the arm is taken for a "
            f"{config.title}. For another arm write its file first, with `armdrive config new`.",
        )
    return _commission(plan, options, attended)


def _config(name: str) -> ArmConfig:
    """Return the arm of a file, or the preset's if there is no such file yet."""
    path = arm_path(name)
    if is_there(path):
        return load_arm(path)
    require_name(name.removesuffix(ENDING))
    row = commissionable()[0]
    connection = Connection(dialect=row.name, port="", baud=row.baud)
    return preset_arm(path.stem, connection)


# The drives of a dialog: behind the adapter of a real arm, or simulated as they are shipped.


@dataclass(frozen=True, slots=True)
class _Drives:
    """The link to the drives, its clock, who handles and watches them, and their port."""

    link: Link
    clock: Clock
    person: DialogPerson
    port: str = ""


@contextlib.contextmanager
def _drives(
    config: ArmConfig, options: argparse.Namespace, attended: Attendance, *, unplugged: int = 0
) -> Iterator[_Drives]:
    """Open the adapter of real drives, or make simulated ones, the first of them `unplugged`.

    Other armdrive programs can only stop a dialog with real ones. Raises `OSError` if the arm file
    could not be written afterwards.
    """
    if attended.simulated:
        twin = simulate(config, factory=True)
        attended.tell("These drives are simulated, and new; nothing is written.")
        person = attended.simulated_person(twin)
        person.unplug_all(unplugged)
        yield _Drives(twin.link, DialogClock(), person)
        return
    require_writable(arm_path(options.name).parent)  # before a person works for nothing
    port = options.port or (PortOpening(config).find() if config.connection.names_port else "")
    if not is_can(port):
        raise BadRequest(
            "which adapter? --port names it, as in --port can:slcan:/dev/ttyACM0?bitrate=500000; "
            "`armdrive ports` lists those that are there"
        )
    terminal = TerminalPerson(command_line("can", "setup", options.name))
    with (
        hold(config.name, port) as lock,
        contextlib.closing(opening.open_link(port, config.connection.baud)) as link,
    ):
        serve_stop(lock, "sets its drives up")
        yield _Drives(link, dialog_runner.RealClock(), terminal, port)


def _commission(
    plan: CommissioningPlan, options: argparse.Namespace, attended: Attendance
) -> Iterator[Result]:
    """Commission drives, show the arm file, and write it if the user agrees."""
    with _drives(plan.config, options, attended, unplugged=len(plan.drives)) as drives:
        dialog = drive_dialog(drives.link, plan.scripts(), drives.clock, drives.person)
        outcome = commission(dialog, plan, again=options.again)
    path = arm_path(options.name)
    proposal = propose_drives(path, plan, outcome.currents_ma, drives.port)
    left_out = outcome.left_out
    if left_out:
        yield Result(None, f"Left out: {', '.join(left_out)}. The same command continues there.")
    view = {"arm": plan.config.name, "left_out": list(left_out), "arm_file": proposal.after}
    text = ("", "The arm file would be:" * attended.simulated, *proposal.after.split("\n"))
    yield Result(view, text, DONE if outcome.finished else UNFINISHED, verbatim=True)
    if not attended.simulated:
        _write_down(proposal)


def _write_down(proposal: FileProposal) -> None:
    """Write the arm file if the user agrees, and say what comes next."""
    path = proposal.path
    old = f" (the old text is kept as {kept_aside(path).name})" if proposal.before else ""
    if not proposal.differs:
        say(f"{path} contains all this already.")
    elif ask_yes_no(f"Write this to {path}{old}?", "no leaves the file unchanged."):
        proposal.write(keep_old=True)
        say_lines("\n".join(after_writing(path, load_arm(path))))


# The units of drives that have their ids and settings already.

MEASURED = "measured by `armdrive can setup`"


def _measure(
    config: ArmConfig,
    bus: BusTools,
    units: UnitKeys,
    options: argparse.Namespace,
    attended: Attendance,
) -> Iterator[Result]:
    """Measure the units of an arm's drives, and write them if the user agrees."""
    controller = DIALECTS[bus.dialect].controller(config)
    with _drives(config, options, attended) as drives:
        scripts = bus.scripts(config.device.ids)
        dialog = drive_dialog(drives.link, scripts, drives.clock, drives.person)
        try:
            found = measure_units(dialog, config, controller)
        finally:
            # they end the heartbeat watch: the drives hold, without an alarm, after this program
            drives.link.write(controller.shutdown_frames(), drives.clock.now_s())
    if not found:
        yield Result({"arm": config.name, "units": {}}, (), UNFINISHED)
        return
    keys = units(config.device, found)
    proposal = propose_keys(arm_path(options.name), bus.dialect, keys, MEASURED)
    view = {"arm": config.name, "units": dict(keys), "lines": list(proposal.difference)}
    nothing = ("Nothing to write: the arm file or the drives say so already.",)
    yield Result(view, proposal.difference or nothing)
    attended.write_down(proposal)
