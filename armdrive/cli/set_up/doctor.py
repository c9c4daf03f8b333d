"""Finds out what a port leads to, and what keeps it from working. Moves nothing."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Mapping
from types import MappingProxyType

from armdrive.cli.presenter import Result, agreed, as_json, at_terminal, put_error, say, tell
from armdrive.config.arm import ArmConfig
from armdrive.connect.port import PortOpening, require_port
from armdrive.connect.target import find, require_real_ports
from armdrive.dialog import Finding
from armdrive.errors import BadRequest, OperatorNeeded
from armdrive.setup.bus_survey import ids_of, only_bus, survey_bus
from armdrive.setup.keyboard import examine, raw_terminal
from armdrive.setup.ports import look_at, port_of
from armdrive.setup.survey import (
    OPENING_RISK,
    Agree,
    Diagnosis,
    Report,
    survey_port,
)
from armdrive.tasks import DeviceSettings
from armdrive.transports.address import PREFIX, is_can
from kinematics.text import counted

EXIT_CODES: Mapping[Diagnosis, int] = MappingProxyType(
    {Diagnosis.FINE: 0, Diagnosis.PROBLEM: 1, Diagnosis.CLOSED: 4, Diagnosis.NO_ARM: 6}
)


def doctor(options: argparse.Namespace) -> Result:
    """Survey the port, and report the findings."""
    if options.keyboard:
        return _keyboard(options)
    config = _config(options)
    # a bus is meant by --can, by the port, or by the arm file's port
    if options.can is not None or is_can(
        options.port or (config.connection.port if config else "")
    ):
        return _on_bus(options, config)
    if options.ids:
        raise BadRequest("--ids are about a CAN bus: name one with --can")
    closed = port_of(config) if config is not None and options.arm else look_at(options.port)
    report = _report(closed.port, options)
    report.more = {"arm_files": list(closed.arms)}
    report.add(closed.findings)
    if not closed.openable:
        return _result(report, Diagnosis.CLOSED)
    _require_consent(closed.port, options)
    found = survey_port(report, closed, config, options.baud, _fixing(options))
    return _result(report, found)


def _report(port: str, options: argparse.Namespace) -> Report:
    def print_finding(finding: Finding) -> None:
        tell(options, f"{finding.grade.value:<8} {finding.what}")
        if finding.fix:
            tell(options, f"{'':<8}   {finding.fix}")

    return Report(port, print_finding, options.arm or "")


def _result(report: Report, diagnosis: Diagnosis) -> Result:
    listed = [f"  {line}" for line in report.more.get("next", ())]
    return Result(report.view(), ["Next:", *listed] if listed else (), EXIT_CODES[diagnosis])


def _on_bus(options: argparse.Namespace, config: ArmConfig | None) -> Result:
    """Survey the CAN bus that is meant."""
    own = None if options.can or config is None else PortOpening(config).find()
    port = own or _named_port(options)
    if not is_can(port):
        raise BadRequest(f"{port} is no CAN bus: write can:INTERFACE:CHANNEL")
    report = _report(port, options)
    ids = ids_of(options.ids) if options.ids else ()
    found = survey_bus(report, config, ids, _fixing(options))
    return _result(report, found)


def _named_port(options: argparse.Namespace) -> str:
    """Return the port that the command names; the only CAN bus if it names none."""
    bus: str = options.can or ""
    if bus and not is_can(bus):
        return PREFIX + bus
    return bus or options.port or only_bus()


def _fixing(options: argparse.Namespace) -> Agree | None:
    """Return what asks whether to write settings; None without --fix."""

    def may_write(settings: DeviceSettings) -> bool:
        if options.yes or as_json(options):
            return bool(options.yes)
        for each in settings.differences:
            say(f"  {each}")
        these = counted(len(settings.differences), "setting")
        return agreed(f"Write {these} to the controller? Type yes: ")

    return may_write if options.fix else None


def _config(options: argparse.Namespace) -> ArmConfig | None:
    """Return the arm that is expected at the port, or None."""
    require_real_ports()
    if bool(options.port) == bool(options.arm) and (options.port or options.can is None):
        raise BadRequest(
            "name one port, or an arm file with --arm; `armdrive ports` lists the ports"
        )
    if (options.can and options.port) or (options.arm and options.dialect):
        raise BadRequest("--can names the bus, and --arm the dialect: name each only once")
    if options.fix and not (options.arm or options.dialect):
        raise BadRequest("--fix needs --arm or --dialect, which say what is expected")
    if not (options.arm or options.dialect):
        return None
    target = find(
        options.arm or _named_port(options), dialect_name=options.dialect, baud=options.baud
    )
    if target.simulated:
        raise BadRequest(f"{options.arm} is simulated: there is no port to look at")
    require_port(target.config)
    return target.config


def _require_consent(port: str, options: argparse.Namespace) -> None:
    """Ask whether the port may be opened; raise `OperatorNeeded` if not."""
    if options.yes:
        return
    if as_json(options) or not sys.stdin.isatty():
        raise OperatorNeeded(f"{OPENING_RISK.format(port=port)} Add --yes if that may happen now")
    say(OPENING_RISK.format(port=port))
    if not agreed(f"Open {port}? Type yes: "):
        raise OperatorNeeded(f"{port} was not opened, and nothing was sent")


# The keyboard of this terminal: whether a held key will jog the arm.


def _keyboard(options: argparse.Namespace) -> Result:
    """Examine the keyboard; opens no port. The exit code is 1 if a held key does not work."""
    if options.port or options.arm:
        raise BadRequest("--keyboard examines this terminal and no port: leave the port out")
    if not at_terminal():
        raise OperatorNeeded(
            "you have to hold a key: run `armdrive doctor --keyboard` in a terminal"
        )

    def whisper(text: str) -> None:
        """Print on the error output, since standard output gets the JSON."""
        put_error(f"{text}\n")

    with raw_terminal() as terminal:
        found = examine(terminal, os.environ, whisper if as_json(options) else say)
    return Result(found.view(), found.lines, 0 if found.works else 1)
