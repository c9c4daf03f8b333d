"""The bus of an arm with CAN drives: `monitor` shows its frames in words, `setup` its drives."""

from __future__ import annotations

import argparse
import contextlib
import math
import sys
import time
import tomllib
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

from armdrive.cli.presenter import (
    Outcome,
    Result,
    as_json,
    put,
    put_error,
    say,
    say_lines,
    show,
    tell,
)
from armdrive.cli.questions import TerminalPerson, agree, ask_value
from armdrive.cli.set_up.arguments import ADAPTERS
from armdrive.config.arm import ArmConfig
from armdrive.config.sections import Connection
from armdrive.connect.control_socket import serve_stop
from armdrive.connect.port import PortOpening, lock_names
from armdrive.connect.target import find, require_real_ports, simulation_forced
from armdrive.dialects import Language
from armdrive.dialects.bus.tools import BusTools, UnitKeys
from armdrive.dialog import DialogPerson, Question, WrongAnswer
from armdrive.errors import BadRequest, HolderError, OperatorNeeded, PortInUse
from armdrive.errors.printable import command_line
from armdrive.registry import DIALECTS, LANGUAGES, USUAL, language_of, simulate
from armdrive.registry.arm_files import (
    ENDING,
    arm_path,
    load_arm,
    parse_arm,
    preset_arm,
    require_name,
)
from armdrive.setup import dialog_runner
from armdrive.setup import plan as kept
from armdrive.setup.commissioning import CommissioningOutcome, measure_units, walk
from armdrive.setup.dialog_runner import DialogClock, RealClock, drive_dialog
from armdrive.setup.filing import after_writing, propose_drives, propose_keys, signs_of
from armdrive.setup.plan import CommissioningPlan, commissionable, plan_of
from armdrive.setup.simulated_person import SimulatedPerson
from armdrive.sim.simulated_arm import SimulatedArm
from armdrive.storage.arm_lock import hold
from armdrive.storage.files import kept_aside, require_writable
from armdrive.storage.lock_client import holder_words, is_held, name_held, tap_holder
from armdrive.tasks import MeasuredUnits
from armdrive.text.reading import is_there
from armdrive.transports import opening, ports
from armdrive.transports.address import CanAddress, is_can
from armdrive.transports.link import Link
from firmware_protocol.frames import Frame, Unpacker
from kinematics.text import counted

ONE_PROGRAM = (
    "Only one program can open a serial adapter: listen with a second adapter on the bus. If an "
    "armdrive of yours holds the arm, `armdrive can monitor --arm NAME` shows its frames"
)


# `armdrive can monitor` shows the frames on a bus in words. It only listens, and sends nothing.


def monitor(options: argparse.Namespace) -> int:
    """Listen until the time or the count is reached, or Ctrl-C."""
    config = _watched(options)
    language = _language(options, config)
    address = _address(options, config)
    try:
        link = opening.open_link(str(address), 0)
    except PortInUse as error:
        name = name_held(*((options.port,) if config is None else lock_names(config)))
        if not is_held(name):
            raise PortInUse(f"{error}. {ONE_PROGRAM}") from None
        frames = held_frames(name, options.seconds, _passed_over)
        tell(options, f"{holder_words(name)} holds {name}: these are its frames")
        shown, foreign = _shown(options, language, frames)
    else:
        try:
            shown, foreign = _shown(options, language, _heard(link, options.seconds))
        finally:
            link.close()
    if explanation := _explanation(language, shown, foreign):
        tell(options, explanation)
    return 0


def _shown(
    options: argparse.Namespace, language: Language, frames: Iterator[tuple[float, Frame]]
) -> tuple[int, int]:
    """Print frames as they come; return how many, and how many of them were unreadable."""
    shown = foreign = 0
    describer, ids = language.describer(), frozenset(options.id)
    with contextlib.suppress(KeyboardInterrupt):
        for time_s, frame in frames:
            message = describer.describe(frame)
            if ids and message.node not in ids:
                continue
            show(Result(message.view(time_s), message.line(time_s)), options)
            shown, foreign = shown + 1, foreign + message.foreign
            if shown == options.count:
                break
    return shown, foreign


def _passed_over(count: int) -> None:
    missing = counted(count, "exchange is missing: it", "exchanges are missing: they")
    put_error(f"{missing} came faster than could be shown\n")


def _explanation(language: Language, shown: int, foreign: int) -> str:
    """Return what it may mean if no frame, or no readable one, came; else an empty text."""
    if not shown:
        return (
            f"no frame came. {language.silence}. A wrong bit rate looks the same: `armdrive doctor "
            "--can` tells them apart"
        )
    if 2 * foreign > shown:
        others = " or ".join(f"--protocol {name}" for name in LANGUAGES if name != language.name)
        return (
            f"{foreign} of {counted(shown, 'frame is', 'frames are')} not from "
            f"{language.title}: try {others}"
        )
    return ""


def _language(options: argparse.Namespace, config: ArmConfig | None) -> Language:
    if options.protocol:
        return LANGUAGES[options.protocol]
    return USUAL if config is None else language_of(config.connection.dialect)


def _watched(options: argparse.Namespace) -> ArmConfig | None:
    """Return the arm whose bus is meant; None if a bus is named. Raises `BadRequest`."""
    require_real_ports()
    if bool(options.port) == bool(options.arm):
        raise BadRequest("name one bus, or an arm file with --arm; `armdrive ports` lists them")
    return find(options.arm).config if options.arm else None


def _address(options: argparse.Namespace, config: ArmConfig | None) -> CanAddress:
    port = str(options.port if config is None else PortOpening(config).find())
    if not is_can(port):
        raise BadRequest(
            f"{port} is no CAN bus: write can:INTERFACE:CHANNEL, `armdrive ports` lists them"
        )
    return replace(CanAddress.parse(port), ids=frozenset()).listening()


def _heard(link: Link, seconds: float | None) -> Iterator[tuple[float, Frame]]:
    """Yield the frames as they come, with the time since the bus was opened."""
    clock, unpacker = RealClock(), Unpacker()
    began_s = clock.now_s()
    end_s = math.inf if seconds is None else began_s + seconds
    while (now_s := clock.now_s()) < end_s:
        for frame in unpacker.feed(link.read(now_s)):
            yield now_s - began_s, frame
        clock.sleep(link, min(end_s, now_s + 1.0))


# The frames of an adapter that another program of the same user has open, sent by that program.

EVERY_S = 0.05
"""How often the other program sends its frames."""


def held_frames(
    name: str, seconds: float | None, missed: Callable[[int], None]
) -> Iterator[tuple[float, Frame]]:
    """Yield the frames of the program that holds an arm, with the time since the first one.

    Ends after `seconds`, or when that program closes the arm. `missed` is called with the number of
    exchanges that came too fast. Raises `HolderError` if the program does not answer.
    """
    sides = {"sent": Unpacker(), "received": Unpacker()}
    end_s = time.monotonic() + (math.inf if seconds is None else seconds)
    began_s: float | None = None
    for message in tap_holder(name, EVERY_S):
        if "error" in message:
            raise HolderError(str(message["error"]))
        if message.get("missed"):
            missed(int(message["missed"]))
            sides = {side: Unpacker() for side in sides}  # half of a frame may be missing
        for time_s, side, data in message.get("wire", ()):
            began_s = time_s if began_s is None else began_s
            for frame in sides[side].feed(bytes.fromhex(data)):
                yield time_s - began_s, frame
        if time.monotonic() >= end_s:
            return


# `armdrive can setup` commissions MKS drives one at a time: ids, settings, directions, gears. Of
# CiA 402 drives it measures the units.

DONE, UNFINISHED = 0, 1


def set_up(options: argparse.Namespace) -> Outcome:
    """Hold the dialog, then write the arm file."""
    simulated = options.sim or simulation_forced()
    alone = options.yes or as_json(options)
    if not simulated and (alone or not sys.stdin.isatty()):
        raise OperatorNeeded(
            "you have to plug real drives in and watch their motors: run this in a terminal, or "
            "give --sim (with --yes or --json it asks no questions)"
        )
    if simulated and options.port:
        raise BadRequest("--sim needs no --port: the drives are in this program")
    config = _config(options.name)
    bus = DIALECTS[config.connection.dialect].bus
    if bus is not None and bus.units is not None:
        return _measure(config, bus, bus.units, options, simulated=simulated, alone=alone)
    plan = plan_of(config)
    if not is_there(arm_path(options.name)):
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
    if is_there(path):
        return load_arm(path)
    require_name(name.removesuffix(ENDING))
    row = commissionable()[0]
    connection = Connection(dialect=row.name, port="", baud=row.baud)
    return preset_arm(row.preset, name=path.stem, connection=connection)


def _commission(config: ArmConfig, plan: CommissioningPlan, options: argparse.Namespace) -> int:
    """Commission real drives."""
    port = _port_of(config, options)
    notes = kept.read(plan.name, config.calibration)
    with _opened(config, port) as link:
        keep = lambda found: kept.write(plan.name, config.calibration, found)  # noqa: E731
        person = _person(config)
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


def _port_of(config: ArmConfig, options: argparse.Namespace) -> str:
    """Return the adapter that is named, or the arm file's, or the one that the user chooses.

    Raises `OSError` if the arm file could not be written afterwards.
    """
    require_writable(arm_path(options.name).parent)  # before a person works for nothing
    return options.port or _known_port(config) or chosen_port()


def _known_port(config: ArmConfig) -> str:
    connection = config.connection
    return PortOpening(config).find() if connection.port or connection.usb_serial else ""


def _person(config: ArmConfig, *more: str) -> TerminalPerson:
    return TerminalPerson(command_line("can", "setup", config.name, *more))


def _new_drives(
    config: ArmConfig, options: argparse.Namespace, *, alone: bool
) -> tuple[SimulatedArm, SimulatedPerson]:
    """Return simulated drives as they are shipped, and who handles them."""
    twin = simulate(config, factory=True)
    ask = None if alone else _person(config, "--sim").answer
    tell(options, "These drives are simulated, and new; nothing is written.")
    return twin, SimulatedPerson(twin, partial(tell, options), ask)


def _practise(
    config: ArmConfig, plan: CommissioningPlan, options: argparse.Namespace, *, alone: bool
) -> Result:
    """Commission simulated new drives. Nothing is kept, and no file is written."""
    twin, person = _new_drives(config, options, alone=alone)
    person.unplug_all(len(plan.drives))
    dialog = drive_dialog(twin.link, plan.scripts(), DialogClock(), person, lambda _notes: None)
    outcome = walk(dialog, plan, {}, again=True)
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
    *,
    simulated: bool,
    alone: bool,
) -> Outcome:
    """Measure the units of an arm's drives, and write them if the user agrees."""
    if simulated:
        twin, person = _new_drives(config, options, alone=alone)
        found = _measured(twin.link, DialogClock(), person, config, bus)
    else:
        with _opened(config, _port_of(config, options)) as link:
            found = _measured(link, dialog_runner.RealClock(), _person(config), config, bus)
    if not found:
        return Result({"arm": config.name, "units": {}}, (), UNFINISHED)
    path, keys = arm_path(options.name), units(config.device, found)
    proposal = propose_keys(path, bus.dialect, keys, MEASURED)
    view = {"arm": config.name, "units": dict(keys), "lines": list(proposal.difference)}
    if simulated:
        return Result(view, proposal.difference)
    say_lines(
        "\n".join(proposal.difference)
        or "Nothing to write: the arm file or the drives say so already."
    )
    if proposal.differs and agree(f"Write this to {path}?", "no leaves it unchanged.", "yes"):
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
    elif agree(f"Write this to {path}{old}?", "no leaves the file unchanged; the notes are kept."):
        proposal.write(keep_old=True)
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
