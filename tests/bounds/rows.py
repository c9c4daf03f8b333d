"""The worst of each dialect: how it moves, what its wire does, and when the motion is ended.

A row says which motion is ended by what, at which moments, and what the wire does from then on. Of
all its moments, the worst must reach half of what was announced, unless a reason of `REASONS` says
why the simulated device cannot.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from itertools import product
from types import MappingProxyType

from armdrive import Jog
from armdrive.armfile import ArmConfig
from armdrive.connecting import simulated_config
from armdrive.engine import Engine
from armdrive.errors import ArmError
from armdrive.sim.fault_request import parse_words
from armdrive.sim.options import Value
from firmware_protocol.frames import Unpacker
from kinematics import Joints

from .stand import OPENING_MM, Overrun, Stand

HOST_S = 0.03
"""What every bound allows for a message that this computer or an adapter holds back."""
RESTS_S = 2.5
"""By then every arm stands; no bound is longer."""
ASLEEP_S = 4.0

# -- the motions --------------------------------------------------------------------------------

OUTSTRETCHED_DEG = {"base": 0.0, "shoulder": 28.0, "elbow": -16.0, "wrist_pitch": -85.0}
"""From here all joints turn upwards at full speed, and the arm is nearly straight a second later.
"""
PLANNED_S = 1.2


def start_of(config: ArmConfig) -> Joints:
    """Return where the motions begin."""
    return Joints.of(*(math.radians(each) for each in (*OUTSTRETCHED_DEG.values(), 0.0)))


def together(config: ArmConfig) -> tuple[float, ...]:
    """Return the joint speeds of the fastest motion, in rad/s: each joint at its limit.

    Where motors are not coordinated, a burst is shorter the more their ways differ. There all
    motors make the same steps, in the directions in which they move the tip furthest.
    """
    *limits, _ = config.model.joint_speeds_rad_s
    if config.connection.dialect in ("teachmover", "grbl", "mks", "cia402"):
        return (*limits, 0.0)
    transmission, arm = config.model.transmission, config.model.arm
    assert transmission is not None
    start, found = start_of(config), []
    here = arm.fk(start)
    for signs in product((1, -1), repeat=4):
        steps = (*signs, signs[-1], 0)
        turns = [sum(a * b for a, b in zip(row, steps, strict=True)) for row in transmission.inverse]
        there = arm.fk(Joints.of(*(a + 10.0 * b for a, b in zip(start, turns, strict=False))))
        way = math.dist((here.x_mm, here.y_mm, here.z_mm), (there.x_mm, there.y_mm, there.z_mm))
        low = start.deg["shoulder"] + math.degrees(60.0 * turns[1])
        elbow = start.deg["elbow"] + math.degrees(60.0 * turns[2])
        if low > 5.0 and -140.0 < elbow < 0.0 and -90 < start.deg["wrist_pitch"] + math.degrees(60.0 * turns[3]) < 90:
            found.append((way, tuple(turns[:5])))
    turned = max(found)[1]
    share = min(
        (limit / abs(turn) for limit, turn in zip(limits, turned, strict=False) if turn),
        default=1.0,
    )
    return tuple(share * turn for turn in turned)
