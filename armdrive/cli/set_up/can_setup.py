"""Commissions the drives of an arm one at a time: ids, settings, directions, gears."""

from __future__ import annotations

import argparse
import contextlib
import sys
import tomllib
from collections.abc import Iterator
from functools import partial

from armdrive.cli.presenter import Outcome, Result, as_json, put, say, say_lines, tell
from armdrive.cli.questions import TerminalPerson, agree, ask_value
from armdrive.cli.set_up.arguments import ADAPTERS
from armdrive.config.arm import ArmConfig
from armdrive.config.sections import Connection
from armdrive.connect.control_socket import serve_stop
from armdrive.connect.port import PortOpening
from armdrive.connect.target import simulation_forced
from armdrive.dialog.conversation import Question, WrongAnswer
from armdrive.errors import BadRequest, OperatorNeeded
from armdrive.registry.arm_files import (
    ENDING,
    arm_path,
    load_arm,
    parse_arm,
    preset_arm,
    require_name,
)
from armdrive.registry.simulate import simulate
from armdrive.setup import dialog_runner
from armdrive.setup import plan as kept
from armdrive.setup.commissioning import CommissioningOutcome, walk
from armdrive.setup.dialog_runner import DialogClock, drive_dialog
from armdrive.setup.filing import after_writing, propose_drives, signs_of
from armdrive.setup.plan import CommissioningPlan, commissionable, plan_of
from armdrive.setup.simulated_person import SimulatedPerson
from armdrive.storage.arm_lock import hold
from armdrive.storage.files import require_writable
from armdrive.transports import opening, ports
from armdrive.transports.address import is_can
from armdrive.transports.link import Link

DONE, UNFINISHED = 0, 1
BEFORE = ".before"
"""The ending of the copy of an arm file's old text."""


def set_up(options: argparse.Namespace) -> Outcome:
    """Hold the dialog, then write the arm file."""
    simulated = options.sim or simulation_forced()
    alone = options.yes or as_json(options)
    if not simulated and (alone or not sys.stdin.isatty()):
        raise OperatorNeeded(
            "you have to plug real drives in and watch their motors: run this in a terminal, or "
            "give --sim (with --yes or --json it asks no questions)"
        )
    config = _config(options.name)
    plan = plan_of(config)
    if not arm_path(options.name).is_file():
        tell(
            options,
            f"There is no arm file named {options.name} yet: the arm is taken for a "
            f"{config.title}. For another arm write its file first, with `armdrive config new`.",
        )
    if simulated:
        return _practise(config, plan, options, alone=alone)
    return _commission(config, plan, options)


def _config(name: str) -> ArmConfig:
    """Return the arm of a file, or the preset's if there is no such file yet."""
    path = arm_path(name)
    if path.is_file():
        return load_arm(path)
    require_name(name.removesuffix(ENDING))
    row = commissionable()[0]
    wire = Connection(dialect=row.name, port="", baud=row.baud)
    return preset_arm(row.preset, name=path.stem, connection=wire)


def _commission(config: ArmConfig, plan: CommissioningPlan, options: argparse.Namespace) -> int:
    """Commission real drives."""
    require_writable(arm_path(options.name).parent)
    port = options.port or _known_port(config) or chosen_port()
    notes = kept.read(plan.name, config.calibration)
    with _opened(config, port) as link:
        keep = lambda found: kept.write(plan.name, config.calibration, found)  # noqa: E731
        person = TerminalPerson(f"armdrive can setup {plan.name}")
        dialog = drive_dialog(link, plan.scripts(), dialog_runner.RealClock(), person, keep)
        outcome = walk(dialog, plan, notes, again=options.again)
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


def _known_port(config: ArmConfig) -> str:
    wire = config.connection
    return PortOpening(config).find() if wire.port or wire.usb_serial else ""


def _practise(
    config: ArmConfig, plan: CommissioningPlan, options: argparse.Namespace, *, alone: bool
) -> Result:
    """Commission simulated new drives. Nothing is kept, and no file is written."""
    if options.port:
        raise BadRequest("--sim needs no --port: the drives are in this program")
    twin = simulate(config, factory=True)
    terminal = TerminalPerson(f"armdrive can setup {plan.name} --sim")
    person = SimulatedPerson(twin, partial(tell, options), None if alone else terminal.answer)
    person.unplug_all(len(plan.drives))
    tell(options, "These drives are simulated, and new; nothing is written.")
    dialog = drive_dialog(twin.link, plan.scripts(), DialogClock(), person, lambda _notes: None)
    outcome = walk(dialog, plan, {}, again=True)
    notes, left_out = outcome.notes, outcome.left_out
    text = propose_drives(arm_path(options.name), config, plan, notes, "", left_out).after
    view = {"arm": plan.name, "left_out": list(left_out), "arm_file": text}
    lines = ("", "The arm file would be:", "", *text.split("\n"))
    return Result(view, lines, DONE if outcome.finished else UNFINISHED)


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
    aside = f"{path.name}{BEFORE}"
    old = f" (the old text is kept as {aside})" if proposal.before else ""
    if not proposal.differs:
        say(f"{path} contains all this already.")
    elif agree(f"Write this to {path}{old}?", "no leaves the file unchanged; the notes are kept."):
        proposal.write(aside)
        found = {name: kept.absorbed(each) for name, each in outcome.notes.items()}
        kept.write(plan.name, arm.calibration, found)
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
