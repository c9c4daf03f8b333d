"""Runs a simulated arm as a program of its own, for any program that can drive a real one."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from armdrive.cli.presenter import put_error, say, say_lines
from armdrive.config.arm import ArmConfig
from armdrive.connect.target import find, simulated_config
from armdrive.errors import BadRequest
from armdrive.registry import DIALECTS, simulated_kind
from armdrive.sim.bus import DrivesBoard
from armdrive.sim.device import parse_settings, settings_of
from armdrive.sim.faults import FAULT_NOTE, arguments_of, faults_of, parse_option
from armdrive.sim.simulated_arm import SimDeviceKind
from armdrive.text.toml import Rule, rule_of
from armdrive.text.toml import value as toml
from armdrive.transports.address import BITRATE


def sim(options: argparse.Namespace) -> int:
    """Serve until Ctrl-C or `quit`."""
    if options.list:
        names = [options.dialect] if options.dialect else list(DIALECTS)
        say_lines(_listing({name: simulated_kind(name) for name in names}))
        return 0
    config = _config(options)
    _check_wire(options, config.connection.dialect)
    return _serve(options, config)


def _config(options: argparse.Namespace) -> ArmConfig:
    """Return the arm whose device is simulated: that of a file, or the usual one of a dialect."""
    if bool(options.dialect) == bool(options.arm):
        raise BadRequest(f"a dialect is required, or an arm file with --arm: {', '.join(DIALECTS)}")
    config = find(options.arm).config if options.arm else simulated_config(options.dialect)
    if options.baud is None:
        return config
    return replace(config, connection=replace(config.connection, baud=options.baud))


def _check_wire(options: argparse.Namespace, dialect: str) -> None:
    """Raise `BadRequest` unless the options offer the device over a wire of its kind."""
    on_bus = DIALECTS[dialect].can
    if on_bus and not options.slcan:
        raise BadRequest(f"{dialect} is spoken on a CAN bus: --slcan PATH is required")
    if not on_bus and (options.listener or not (options.pty or options.tcp or options.udp)):
        raise BadRequest(
            f"{dialect} is not spoken on a CAN bus: --pty PATH, --tcp HOST:PORT or --udp HOST:PORT "
            "is required"
        )


def _serve(options: argparse.Namespace, config: ArmConfig) -> int:
    # they load python-can, which a list of the dialects does not need
    from armdrive.sim import serving
    from armdrive.sim.serving import servers

    dialect = config.connection.dialect
    kind = simulated_kind(dialect)
    settings = parse_settings(kind.settings, options.set)
    device = kind.simulate(config, play=options.play, settings=settings).device
    board = device.board
    faults = [parse_option(text) for text in options.fault]
    for fault in faults:
        arguments_of(fault, device)
    server = serving.make_server(
        pty=Path(options.pty) if options.pty else None,
        tcp=options.tcp,
        udp=options.udp,
        slcan=Path(options.slcan) if options.slcan else None,
        listener=Path(options.listener) if options.listener else None,
        bits_s=board.bits_s if isinstance(board, DrivesBoard) else BITRATE,
    )
    where = server.address
    if isinstance(server, servers.SlcanServer):
        where = server.can_addresses[0]
    say(
        f"a simulated {config.title} speaks {dialect} at {where}; "
        "Ctrl-C ends it, help lists commands"
    )
    if options.arm and config.connection.port != where:
        say(f"connect with port = {toml(where)} in the arm file")
    warning = servers.beyond_this_computer(options.tcp or options.udp or ":0")
    if warning:
        put_error(f"armdrive: {warning}\n")
    commands = None if sys.stdin.closed else sys.stdin.fileno()
    serving.run_device(device, server, commands, say_lines, faults=faults)
    return 0


# The tables of what people can choose: settings and faults of each dialect's device.


def _listing(kinds: Mapping[str, SimDeviceKind]) -> str:
    """Return the tables of these dialects."""
    return "\n\n".join([*(_one(name, kind) for name, kind in kinds.items()), FAULT_NOTE])


def _one(dialect: str, kind: SimDeviceKind) -> str:
    settings = [
        (f"{name}={_shown(row.default)}", _with_choices(rule_of(row)))
        for name, row in settings_of(kind.settings).items()
    ]
    faults = [(row.usage, row.summary) for row in faults_of(kind.board)]
    width = max(len(usage) for usage, _ in [*settings, *faults])
    lines = [f"{dialect}: a simulated {kind.board.title}"]
    for title, rows in (("settings (--set NAME=VALUE)", settings), ("faults (--fault)", faults)):
        lines += [f"  {title}:"] if rows else []
        lines += [f"    {usage:<{width}}  {summary}" for usage, summary in rows]
    return "\n".join(lines)


def _shown(value: object) -> str:
    return ("yes" if value else "no") if isinstance(value, bool) else str(value)


def _with_choices(rule: Rule) -> str:
    return f"{rule.help} ({', '.join(map(str, rule.words))})" if rule.words else rule.help
