"""Commissions the drives of an arm. MKS drives get ids, settings, directions and gears.

Of CiA 402 drives it measures the units.
"""

from __future__ import annotations

import argparse
import contextlib
import tomllib
from collections.abc import Iterator

from armdrive.cli.presenter import Outcome, Result, put, say, say_lines, tell
from armdrive.cli.questions import TerminalPerson, ask_value, ask_yes_no
from armdrive.cli.set_up.arguments import ADAPTERS
from armdrive.cli.set_up.attendance import Attendance, attendance
from armdrive.config.arm import ArmConfig
from armdrive.config.sections import Connection
from armdrive.connect.control_socket import serve_stop
from armdrive.connect.port import PortOpening
from armdrive.dialects.bus.tools import BusTools, UnitKeys
from armdrive.dialog import DialogPerson, Question, WrongAnswer
from armdrive.errors import BadRequest
from armdrive.errors.printable import command_line
from armdrive.registry import DIALECTS, simulate
from armdrive.registry.arm_files import (
    ENDING,
    arm_path,
    load_arm,
    parse_arm,
    preset_arm,
    require_name,
)
from armdrive.setup import dialog_runner
from armdrive.setup.commissioning import CommissioningOutcome, commission, measure_units
from armdrive.setup.dialog_runner import DialogClock, drive_dialog
from armdrive.setup.filing import after_writing, propose_drives, propose_keys, signs_of
from armdrive.setup.plan import (
    CommissioningPlan,
    commissionable,
    plan_of,
    read_notes,
    without_motions,
    write_notes,
)
from armdrive.setup.simulated_person import SimulatedPerson
from armdrive.sim.simulated_arm import SimulatedArm
from armdrive.storage.arm_lock import hold
from armdrive.storage.files import kept_aside, require_writable
from armdrive.tasks import MeasuredUnits
from armdrive.text.reading import is_there
from armdrive.transports import opening, ports
from armdrive.transports.address import is_can
from armdrive.transports.link import Link

DONE, UNFINISHED = 0, 1


def set_up(options: argparse.Namespace) -> Outcome:
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
    if attended.simulated:
        return _practise(config, plan, options, attended)
    return _commission(config, plan, options)


def _config(name: str) -> ArmConfig:
    """Return the arm of a file, or the preset's if there is no such file yet."""
    path = arm_path(name)
    if is_there(path):
        return load_arm(path)
    require_name(name.removesuffix(ENDING))
    row = commissionable()[0]
    connection = Connection(dialect=row.name, port="", baud=row.baud)
    return preset_arm(path.stem, connection)


def _commission(config: ArmConfig, plan: CommissioningPlan, options: argparse.Namespace) -> int:
    """Commission real drives."""
    port = _port_of(config, options)
    notes = read_notes(plan.name, config.calibration)
    with _opened(config, port) as link:
        keep = lambda found: write_notes(plan.name, config.calibration, found)  # noqa: E731
        person = _person(options)
        dialog = drive_dialog(link, plan.scripts(), dialog_runner.RealClock(), person, keep)
        outcome = commission(dialog, plan, notes, again=options.again)
    _end(config, plan, outcome, port, options)
    return DONE if outcome.finished else UNFINISHED


@contextlib.contextmanager
def _opened(config: ArmConfig, port: str) -> Iterator[Link]:
    """Open the adapter and lock the arm: other armdrive programs can only stop this one."""
    with (
        hold(config.name, port) as lock,
        contextlib.closing(opening.open_link(port, config.connection.baud)) as link,
    ):
        serve_stop(lock, "sets its drives up")
        yield link


def _port_of(config: ArmConfig, options: argparse.Namespace) -> str:
    """Return the adapter that is named, or the arm file's, or the one that the user chooses.

    Raises `OSError` if the arm file could not be written afterwards.
    """
    require_writable(arm_path(options.name).parent)  # before a person works for nothing
    return options.port or _known_port(config) or chosen_port()


def _known_port(config: ArmConfig) -> str:
    return PortOpening(config).find() if config.connection.names_port else ""


def _person(options: argparse.Namespace) -> TerminalPerson:
    return TerminalPerson(command_line("can", "setup", options.name))


def _new_drives(config: ArmConfig, attended: Attendance) -> tuple[SimulatedArm, SimulatedPerson]:
    """Return simulated drives as they are shipped, and who handles them."""
    twin = simulate(config, factory=True)
    attended.tell("These drives are simulated, and new; nothing is written.")
    return twin, attended.simulated_person(twin)


def _practise(
    config: ArmConfig,
    plan: CommissioningPlan,
    options: argparse.Namespace,
    attended: Attendance,
) -> Result:
    """Commission simulated new drives. Nothing is kept, and no file is written."""
    twin, person = _new_drives(config, attended)
    person.unplug_all(len(plan.drives))
    dialog = drive_dialog(twin.link, plan.scripts(), DialogClock(), person, lambda _notes: None)
    outcome = commission(dialog, plan, {}, again=True)
    notes, left_out = outcome.notes, outcome.left_out
    text = propose_drives(arm_path(options.name), config, plan, notes, "", left_out).after
    view = {"arm": plan.name, "left_out": list(left_out), "arm_file": text}
    lines = ("", "The arm file would be:", "", *text.split("\n"))
    return Result(view, lines, DONE if outcome.finished else UNFINISHED)


# The units of drives that have their ids and settings already.

MEASURED = "measured by `armdrive can setup`"


def _measure(
    config: ArmConfig,
    bus: BusTools,
    units: UnitKeys,
    options: argparse.Namespace,
    attended: Attendance,
) -> Outcome:
    """Measure the units of an arm's drives, and write them if the user agrees."""
    if attended.simulated:
        twin, person = _new_drives(config, attended)
        found = _measured(twin.link, DialogClock(), person, config, bus)
    else:
        with _opened(config, _port_of(config, options)) as link:
            found = _measured(link, dialog_runner.RealClock(), _person(options), config, bus)
    if not found:
        return Result({"arm": config.name, "units": {}}, (), UNFINISHED)
    path, keys = arm_path(options.name), units(config.device, found)
    proposal = propose_keys(path, bus.dialect, keys, MEASURED)
    view = {"arm": config.name, "units": dict(keys), "lines": list(proposal.difference)}
    if attended.simulated:
        return Result(view, proposal.difference)
    say_lines(
        "\n".join(proposal.difference)
        or "Nothing to write: the arm file or the drives say so already."
    )
    if proposal.differs and ask_yes_no(f"Write this to {path}?", "no leaves it unchanged.", "yes"):
        proposal.write()
        say(f"written: {path}")
    return DONE


def _measured(
    link: Link,
    clock: dialog_runner.Clock,
    person: DialogPerson,
    config: ArmConfig,
    bus: BusTools,
) -> tuple[MeasuredUnits, ...]:
    """Hold the dialog; afterwards the drives hold without this program's heartbeat."""
    controller = DIALECTS[bus.dialect].controller(config)
    scripts = bus.scripts(config.device.ids)
    dialog = drive_dialog(link, scripts, clock, person, lambda _notes: None)
    try:
        return measure_units(dialog, config, controller)
    finally:
        link.write(controller.shutdown_frames(), clock.now_s())


def _end(
    config: ArmConfig,
    plan: CommissioningPlan,
    outcome: CommissioningOutcome,
    port: str,
    options: argparse.Namespace,
) -> None:
    """Show the arm file, and write it if the user agrees."""
    path = arm_path(options.name)
    proposal = propose_drives(path, config, plan, outcome.notes, port, outcome.left_out)
    arm = parse_arm(tomllib.loads(proposal.after), name=plan.name, folder=path.parent)
    if unclear := signs_of(plan, outcome.notes).unclear:
        say(f"The directions of {', '.join(unclear)} contradict each other: repeat with --again.")
    if outcome.left_out:
        say(f"Left out: {', '.join(outcome.left_out)}. The same command continues there.")
    put(f"\n{proposal.after}\n")
    old = f" (the old text is kept as {kept_aside(path).name})" if proposal.before else ""
    if not proposal.differs:
        say(f"{path} contains all this already.")
    elif ask_yes_no(
        f"Write this to {path}{old}?", "no leaves the file unchanged; the notes are kept."
    ):
        proposal.write(keep_old=True)
        found = {name: without_motions(each) for name, each in outcome.notes.items()}
        write_notes(plan.name, arm.calibration, found)
        say_lines("\n".join(after_writing(path, arm)))


def chosen_port() -> str:
    """Show how adapters are named, and ask for one. Opens none."""
    found = ports.list_can_ports(ports.list_ports())
    say_lines(ADAPTERS)
    lines = tuple((each.port, each.todo or each.description) for each in found)

    def read(line: str) -> str:
        if line.isdecimal() and 1 <= int(line) <= len(lines):
            return lines[int(line) - 1][0]
        if not is_can(line):
            raise WrongAnswer("write the adapter, such as can:slcan:/dev/ttyACM0?bitrate=500000")
        return line

    default = lines[0][0] if len(lines) == 1 else None
    why = "A CANable is a serial port with slcan firmware, and a CAN interface with candleLight."
    return str(ask_value(Question("Which adapter?", why, read, default, lines)))
