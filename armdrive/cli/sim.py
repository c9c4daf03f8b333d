"""A simulated arm as a program of its own: whatever speaks to a real one can speak to it.

Examples:
  armdrive sim teachmover --pty /tmp/arm          then: armdrive jog --port /tmp/arm --dialect teachmover
  armdrive sim teachmover --tcp 127.0.0.1:4001    then: armdrive jog --port socket://127.0.0.1:4001 --dialect teachmover

One-line commands on standard input steer it (`help` lists them); the end of input does not end
it, Ctrl-C does.

"""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from pathlib import Path

from armdrive.cli.numbers import count, number
from armdrive.cli.output import say
from armdrive.dialects import DIALECTS


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("dialect", choices=list(DIALECTS), help="what it speaks")
    where = parser.add_mutually_exclusive_group(required=True)
    where.add_argument("--pty", metavar="PATH", help="a new serial port, linked from PATH")
    where.add_argument("--tcp", metavar="HOST:PORT", help="a TCP port (the way on Windows)")
    parser.add_argument("--baud", type=count, help="pace the bytes like this line")
    parser.add_argument(
        "--speed-error",
        type=number,
        default=0.0,
        metavar="FRACTION",
        help="0.2: motors a fifth slower than the driver's table says",
    )


def run(options: argparse.Namespace) -> int:
    """Serve until told to end."""
    from armdrive.connecting import simulated_config
    from armdrive.sim.run import make_server, run_device
    from armdrive.sim.twin import make_device

    config = simulated_config(options.dialect)
    if options.baud is not None:
        config = replace(config, connection=replace(config.connection, baud=options.baud))
    device = make_device(config, speed_error=options.speed_error)
    server = make_server(pty=Path(options.pty) if options.pty else None, tcp=options.tcp)
    say(
        f"a simulated {config.title} speaks {options.dialect} at {server.address}; "
        "Ctrl-C ends it, help lists commands"
    )
    commands = None if sys.stdin.closed else sys.stdin.fileno()
    run_device(device, server, commands, sys.stdout)
    return 0
