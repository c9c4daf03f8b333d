"""Arms whose file has more lines than the dialect's preset."""

import math
import tomllib

from armdrive.config.arm import ArmConfig
from armdrive.config.preset import LENGTHS
from armdrive.registry import Dialect
from armdrive.registry.arm_files import parse_arm
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
