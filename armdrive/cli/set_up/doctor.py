"""Find out what a port leads to, and what keeps it from working. Moves nothing."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable

from armdrive.cli.presenter import say
from armdrive.cli.screens import agreed
from armdrive.cli.set_up.doctor_keyboard import run as examine_keyboard
from armdrive.cli.set_up.doctor_report import Report
from armdrive.config.arm import ArmConfig
from armdrive.connect.port import PortOpening
from armdrive.connect.target import find, simulation_forced
from armdrive.dialog.conversation import any_problem
from armdrive.errors import BadRequest, OperatorNeeded, PortUnavailable
from armdrive.registry import DIALECTS
from armdrive.setup import findings as after
from armdrive.setup import prober
from armdrive.setup.ports import Before, PortNaming, arm_files, look_at, unfound
from armdrive.setup.prober import Examination
from armdrive.storage.arm_lock import hold
from armdrive.transports.address import is_can

DONE, MENDING, CLOSED, NOBODY = 0, 1, 4, 6

Survey = Callable[[argparse.Namespace, ArmConfig | None], int]
Comparison = Callable[[ArmConfig, Report, argparse.Namespace], None]

WARNING = (
    "Opening {port} can restart the board behind it: its motors lose their current, and an arm "
    "that is raised sags. Support it, or park it first. Nothing that is sent moves it."
)


def run(options: argparse.Namespace) -> int:
    """Examine the port, and say what was found."""
    if options.keyboard:
        return _keyboard(options)
    config = _config(options)
    if _on_can(options, config):
        survey, _ = _deeper()
        return survey(options, config)
    port, before = _before(options, config)
    report = Report(port, options.json)
    report.more = {"arm_files": list(before.owners)}
    report.add(list(before.findings))
    if not before.openable:
        return report.end(CLOSED)
    report.add([after.finding(after.measure())])
    _agree(port, options)
    found = _examined(port, options, config)
    return report.end(_weigh(found, before, report, options, config))


def _deeper() -> tuple[Survey, Comparison]:
    """Return what surveys a CAN bus, and what compares the settings of a controller."""
    # all that drives an arm, and every protocol of a bus: a silent port needs neither
    from armdrive.cli.set_up import doctor_can, doctor_settings

    return doctor_can.run, doctor_settings.compare


def _keyboard(options: argparse.Namespace) -> int:
    if options.port or options.arm:
        raise BadRequest("--keyboard looks at this terminal, and at no port: leave the port out")
    return examine_keyboard(options.json)


def _on_can(options: argparse.Namespace, config: ArmConfig | None) -> bool:
    """Tell whether a CAN bus is meant: by the option, by the port, or by the arm file's port."""
    wire = config.connection.port if config is not None else ""
    return options.can is not None or is_can(options.port or wire)


def _before(options: argparse.Namespace, config: ArmConfig | None) -> tuple[str, Before]:
    """Return the port's present name, and what can be said of it while it is closed."""
    if config is None or not options.arm:
        return str(options.port), look_at(str(options.port), arm_files())
    try:
        port = PortOpening(config).find()
    except PortUnavailable as error:
        return "", unfound(error)
    wire = config.connection
    own = PortNaming(config.name, wire.port, wire.usb_serial)  # its file may lie elsewhere
    return port, look_at(port, (own, *(each for each in arm_files() if each.arm != own.arm)))


def _config(options: argparse.Namespace) -> ArmConfig | None:
    """Return the arm that is expected at the port, if one is."""
    if simulation_forced():
        raise PortUnavailable(
            "ARMDRIVE_FORCE_SIM is set, so no port is opened: clear that variable first"
        )
    if bool(options.port) == bool(options.arm) and (options.port or options.can is None):
        raise BadRequest(
            "name one port, or an arm file with --arm; `armdrive ports` lists the ports"
        )
    if options.arm and options.dialect:
        raise BadRequest("the arm file says which dialect it is: leave out --dialect")
    if options.mend and not (options.arm or options.dialect):
        raise BadRequest("--mend needs --arm or --dialect: else nobody knows what is expected")
    if not (options.arm or options.dialect):
        return None
    target = find(options.arm or options.port, dialect_name=options.dialect, baud=options.baud)
    if target.simulated:
        raise BadRequest(f"{options.arm} is simulated: there is no port to look at")
    wire = target.config.connection
    if not (wire.port or wire.usb_serial):
        raise PortUnavailable(
            f"the arm file of {options.arm} names no port: write port or usb_serial under "
            "[connection]; `armdrive ports` lists those there are"
        )
    return target.config


def _agree(port: str, options: argparse.Namespace) -> None:
    if options.yes:
        return
    if options.json or not sys.stdin.isatty():
        raise OperatorNeeded(f"{WARNING.format(port=port)} Add --yes if that may happen now")
    say(WARNING.format(port=port))
    if not agreed(f"Open {port}? Type yes: "):
        raise OperatorNeeded(f"{port} was not opened, and nothing was sent")


def _examined(port: str, options: argparse.Namespace, config: ArmConfig | None) -> Examination:
    holding = hold(config.name if config is not None else port, port)
    try:
        return prober.examine_port(port, _baud(options, config))
    finally:
        holding.release()


def _baud(options: argparse.Namespace, config: ArmConfig | None) -> int | None:
    """Return the one baud rate to try: a given one, or one that is not its dialect's usual."""
    given: int | None = options.baud
    if given is not None or config is None:
        return given
    wire = config.connection
    return None if wire.baud == DIALECTS[wire.dialect].baud else wire.baud


def _weigh(
    found: Examination,
    before: Before,
    report: Report,
    options: argparse.Namespace,
    config: ArmConfig | None,
) -> int:
    wire = config.connection if config is not None else None
    expected = after.Expected(baud=_baud(options, config))
    if wire is not None:
        spared = wire.raise_dtr and wire.keep_dtr_on_close
        expected = after.Expected(wire.dialect, expected.baud, spared)
    report.add(after.findings(found, expected))
    identity = found.identity
    arm, port = options.arm or "", report.port
    known = bool(arm or before.owners)
    report.more |= {
        "dialect": identity.dialect if identity else "",
        "firmware": identity.firmware if identity else "",
        "baud": found.baud if identity else None,
        "restarted": found.restarted,
        "next": after.next_steps(
            port, found, arm=arm, owners=before.owners, compared=config is not None
        ),
        "arm_file": [] if known else after.arm_file_lines(port, found, before.usb_serial),
    }
    if identity is None or not identity.dialect:
        return NOBODY
    if config is not None and identity.dialect == config.connection.dialect:
        _, compare = _deeper()
        compare(config, report, options)
    return MENDING if any_problem(report.findings) else DONE
