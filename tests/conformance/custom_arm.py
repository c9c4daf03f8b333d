"""Arms whose file has more lines than the dialect's preset, and a program that simulates one.

    python -m tests.conformance.custom_arm FILE [NAME=VALUE ...] --pty PATH

The program runs like `armdrive sim`, also with `--tcp` or `--slcan`. NAME=VALUE is a setting of the
simulated device.
"""

import math
import sys
import tomllib
from functools import partial
from pathlib import Path

from armdrive.config.arm import ArmConfig
from armdrive.config.preset import LENGTHS
from armdrive.registry import Dialect, simulate, simulated_kind
from armdrive.registry.arm_files import load_arm, parse_arm
from armdrive.sim.device import parse_settings
from armdrive.sim.serving import make_server, run_device
from armdrive.sim.serving.servers import SlcanServer
from kinematics.presets import preset

MEASURED_MM = 0.1
"""How far measured lengths are from the template's, which do not count as measured."""


def arm_file(row: Dialect, lines: str, port: str = "") -> str:
    """Return the text of an arm file: the dialect's preset on a port, and more lines."""
    return (
        f'model = "{row.preset}"\n[connection]\ndialect = "{row.name}"\nport = "{port}"\n{lines}\n'
    )


def measured_lines(row: Dialect) -> str:
    """Return lines with measured dimensions, for a preset that is a template; else nothing."""
    model = preset(row.preset)
    if model.verified or model.transmission is None:
        return ""
    lengths = {name: getattr(model.arm, name) + MEASURED_MM for name in LENGTHS}
    turns = {
        f'"{motor.name}"': motor.steps_per_unit * math.tau
        for motor in model.transmission.motors[:5]
    }
    tables = {"lengths": lengths, "steps_per_turn": turns}
    return "\n".join(
        line
        for title, numbers in tables.items()
        for line in (f"[{title}]", *(f"{name} = {number}" for name, number in numbers.items()))
    )


def custom_config(row: Dialect, lines: str, name: str) -> ArmConfig:
    """Return the configuration of such an arm file."""
    return parse_arm(tomllib.loads(arm_file(row, lines)), name=name)


def main(path: str, *words: str) -> None:
    """Serve the device of an arm file until standard input says to end."""
    *settings, where, address = words
    config = load_arm(Path(path))
    chosen = parse_settings(simulated_kind(config.connection.dialect).settings, settings)
    server = make_server(
        pty=Path(address) if where == "--pty" else None,
        tcp=address if where == "--tcp" else None,
        slcan=Path(address) if where == "--slcan" else None,
    )
    offered = server.can_addresses[0] if isinstance(server, SlcanServer) else server.address
    sys.stdout.write(f"it speaks {config.connection.dialect} at {offered}; and waits\n")
    sys.stdout.flush()
    say = partial(print, flush=True)
    run_device(simulate(config, **chosen).device, server, sys.stdin.fileno(), say)


if __name__ == "__main__":
    main(*sys.argv[1:])
