"""The arms of missions, which differ in bursts, obstacles, polls, boards, drives and switches.

Motors home in turn, from the base outwards, or as the board decides. Each motor has its switch at
the upper end of its travel, since simulated drives seek upwards. On an arm of the Mini-mover's
build that is where the arm reaches down, so its joints are limited to postures above the table.
"""

import math
import random
from collections.abc import Iterable, Mapping
from dataclasses import fields, replace
from functools import cache
from types import MappingProxyType

from armdrive.config.arm import ArmConfig
from armdrive.config.sections import HomingSettings
from armdrive.connect.target import simulated_config
from armdrive.sim.armdroid import BOARDS as ARMDROIDS
from armdrive.sim.cia402.quirks import Cia402Quirks
from armdrive.sim.device import Value
from armdrive.sim.grbl.firmware import FIRMWARES
from armdrive.sim.mks.quirks import MksQuirks
from armdrive.text.toml import rule_of
from kinematics import Joints
from kinematics.guards import Box
from tests.scenarios.stage import Stage

HOMING_SHARE = 0.3
"""The share of arms that home by their switches, if their devices can."""
BOX = Box("post", (-60.0, 300.0, 0.0), (60.0, 360.0, 120.0))
RADII_MM = (10.0, 10.0, 10.0)
"""An obstacle next to the arm, and the thickness of its links, in half of the missions."""
VARIANTS = 8
NUMBERS = {"flash_ms": 200.0}
"""The values of quirks that are numbers."""
LEFT_OUT: Mapping[str, str] = MappingProxyType(
    {
        "e_series": "armdrive refuses these drives",
        "homes_reversed": "such an arm cannot home, and otherwise is like any other",
        "hold_after_loss": "drives that extrapolate pass their last target while the bus fails",
        "retarget_creeps": "the arm file has to say `segment_s = 0`",
        "speed_unit": "the arm file has to name the unit",
        "ramp_unit": "the arm file has to name the unit",
    }
)
"""The quirks that missions cannot have, and why."""
CANNOT_HOME: Mapping[str, str] = MappingProxyType(
    {
        "homing": "such drives do not home",
        "keeps_count": "armdrive refuses the zero, and moves nothing until the next program",
    }
)
"""The quirks with which an arm cannot home, and why."""


def quirks(kind: type) -> Iterable[dict[str, Value]]:
    """Yield the options of usual drives, and of drives with one quirk: each of its other values."""
    yield {}
    for each in fields(kind):
        rule = rule_of(each)
        if rule.source and each.name not in LEFT_OUT:
            values = (True, False) if isinstance(each.default, bool) else rule.words
            values = values or (NUMBERS[each.name],)
            yield from ({each.name: value} for value in values if value != each.default)


BOARDS: Mapping[str, tuple[dict[str, Value], ...]] = MappingProxyType(
    {
        "grbl": tuple({"firmware": name} for name in FIRMWARES),
        "armdroid": tuple({"board": name} for name in ARMDROIDS),
        "mks": tuple(quirks(MksQuirks)),
        "cia402": tuple(quirks(Cia402Quirks)),
    }
)
"""The options of the simulated devices of a dialect that has several."""

LOWEST_DEG: Mapping[str, float] = MappingProxyType(
    {"shoulder": 28.0, "elbow": -100.0, "wrist_pitch": -40.0}
)
HOMED, HOMED_MM = Joints.of(88.0, 30.0, -90.0, -20.0, 0.0), 74.0
GROUPS = ((2,), (3,), (1,), (4, 5), (6,))
HOMING: Mapping[str, Mapping[str, object]] = MappingProxyType(
    {
        "grbl": {"homing": True},
        "mks": {},
        "cia402": {"homing_methods": (18,) * 6, "homing_speeds": (10_000, 1000)},
    }
)
"""What the section of a dialect says of homing. The other dialects have no homing of their own."""


@cache
def config_of(name: str, variant: int, *, homes: bool = False) -> ArmConfig:
    """Return the arm of a dialect in a variant."""
    config = simulated_config(name)
    motion, model, guards = config.motion, config.model, config.model.guards
    if variant & 1:
        motion = replace(motion, planned_burst_s=0.2)
    if variant & 2:
        guards = replace(guards, boxes=(BOX,), radii_mm=RADII_MM)
    if variant & 4:
        motion = replace(motion, idle_poll_s=0.3)
    config = replace(config, motion=motion, model=replace(model, guards=guards))
    if not homes:
        return config
    arm = model.arm
    limits = tuple(
        replace(each, low_rad=math.radians(LOWEST_DEG[joint])) if joint in LOWEST_DEG else each
        for joint, each in zip(arm.joint_names, arm.limits, strict=True)
    )
    return replace(
        config,
        model=replace(config.model, arm=replace(arm, limits=limits)),
        device=replace(config.device, **HOMING[name]),
        homing=HomingSettings(HOMED, HOMED_MM, GROUPS if variant & 1 else ()),
    )


def an_arm(name: str, draw: random.Random) -> Stage:
    """Return a random arm of a dialect."""
    options = draw.choice(BOARDS.get(name, ({},)))
    able = name in HOMING and not CANNOT_HOME.keys() & options.keys()
    homes = draw.random() < HOMING_SHARE and able
    return Stage(config_of(name, draw.randrange(VARIANTS), homes=homes), options)
