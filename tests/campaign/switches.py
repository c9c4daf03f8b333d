"""Arms that home by their switches: what their arm file says of it.

Each motor has its switch at the upper end of its travel, since simulated drives seek upwards. On an
arm of the Mini-mover's build that is where the arm reaches down, so its joints are limited to
postures above the table. Its motors home in turn, from the base outwards, or as the board decides.
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

from armdrive.config.arm import ArmConfig
from armdrive.config.sections import HomingSettings
from armdrive.sim.device import Value
from kinematics import Joints

LOWEST_DEG: Mapping[str, float] = MappingProxyType(
    {"shoulder": 28.0, "elbow": -100.0, "wrist_pitch": -40.0}
)
HOMED, HOMED_MM = Joints.of(88.0, 30.0, -90.0, -20.0, 0.0), 74.0
GROUPS = ((2,), (3,), (1,), (4, 5), (6,))
SETTINGS: Mapping[str, Mapping[str, object]] = MappingProxyType(
    {
        "grbl": {"homing": True},
        "mks": {},
        "cia402": {"homing_methods": (18,) * 6, "homing_speeds": (10_000, 1000)},
    }
)
"""What the section of a dialect says of homing. The other dialects have no homing of their own."""
LEFT_OUT: Mapping[str, str] = MappingProxyType(
    {
        "homing": "such drives do not home",
        "keeps_count": "armdrive refuses the zero, and moves nothing until the next program",
    }
)
"""The quirks with which an arm cannot home, and why."""


def can_home(dialect: str, board: Mapping[str, Value]) -> bool:
    """Return whether a simulated device with these options can home by itself."""
    return dialect in SETTINGS and not LEFT_OUT.keys() & board.keys()


def with_switches(config: ArmConfig, *, grouped: bool) -> ArmConfig:
    """Return an arm that homes by its switches, in groups or as its device decides."""
    arm = config.model.arm
    limits = tuple(
        replace(each, low_rad=math.radians(LOWEST_DEG[name])) if name in LOWEST_DEG else each
        for name, each in zip(arm.joint_names, arm.limits, strict=True)
    )
    return replace(
        config,
        model=replace(config.model, arm=replace(arm, limits=limits)),
        device=replace(config.device, **SETTINGS[config.connection.dialect]),
        homing=HomingSettings(HOMED, HOMED_MM, GROUPS if grouped else ()),
    )
