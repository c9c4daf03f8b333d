"""Simulated arms on MKS drives: how one is made.

`node` is one drive, `motion` how it moves, `quirks` what can be chosen.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from armdrive.config.arm import ArmConfig
from armdrive.errors import BadRequest
from armdrive.sim.bus import DrivesBoard
from armdrive.sim.bus.node import NodeMotor, motors_of, node_ids
from armdrive.sim.mechanics.shafts import ShaftDrive
from armdrive.sim.mks.motion import TOP_RATE, Flash
from armdrive.sim.mks.node import MksNode, SavedMksDrive
from armdrive.sim.mks.quirks import AS_THE_ARM_FILE, BITRATES, MksQuirks
from armdrive.sim.simulated_arm import SimDeviceKind
from armdrive.sim.world import World
from firmware_protocol import mks
from firmware_protocol.errors import BadField

HOMING_RPM = 60
USUAL_MA, USUAL_MICROSTEPS = 1600, 16
_FIRMWARE = re.compile(r"(\d{1,2})\.(\d{1,2})\.(\d{1,2})")


@dataclass(frozen=True, slots=True)
class SavedMksDrives:
    """What is saved of the drives."""

    drives: tuple[SavedMksDrive, ...]


class MksBoard(DrivesBoard[MksNode]):
    """The MKS drives of an arm."""

    saved_as = SavedMksDrives
    title = "arm on MKS drives"


def _make(config: ArmConfig, world: World, quirks: MksQuirks) -> MksBoard:
    count, bits_s = len(world.motors), quirks.bitrate
    versions = _versions(quirks.firmware, config, count)
    shafts = ShaftDrive(world, TOP_RATE)
    motors = motors_of(config, shafts)
    settings = _settings(config, motors, BITRATES[bits_s], quirks)
    nodes = [
        MksNode(motor, version, Flash(own), quirks, bits_s)
        for motor, version, own in zip(motors, versions, settings, strict=True)
    ]
    return MksBoard(world, shafts, nodes, bits_s)


def _settings(
    config: ArmConfig, motors: Sequence[NodeMotor], bitrate: mks.Bitrate, quirks: MksQuirks
) -> list[list[mks.Setting]]:
    """Return the settings of each drive as set up for this arm; of new ones, the speed.

    The arm file's own section is read without the driver's class. The driver's figures stay its
    own, so that a difference shows. Each drive searches in the direction of its switch.
    """
    device: Any = config.device
    ids = node_ids(getattr(device, "ids", ()), len(motors))
    if quirks.factory:
        return [[mks.SetBitrate(bitrate)] for _ in ids]
    try:
        return [
            [
                mks.SetBitrate(bitrate),
                mks.SetId(node),
                mks.SetMode(mks.Mode.BUS_FOC),
                mks.SetCurrent(getattr(device, "current_ma", 0) or USUAL_MA),
                mks.SetMicrosteps(getattr(device, "microsteps", 0) or USUAL_MICROSTEPS),
                mks.SetStallProtection(quirks.stall_protection),
                mks.SetHoming(
                    active_high=False,
                    counter_clockwise=motor.switch.way > 0,
                    speed_rpm=HOMING_RPM,
                    limits=quirks.limits,
                    method=0,
                ),
            ]
            for node, motor in zip(ids, motors, strict=True)
        ]
    except BadField as error:
        raise BadRequest(str(error)) from None


def _versions(text: str, config: ArmConfig, count: int) -> tuple[mks.Version, ...]:
    """Return the firmware of each drive, from one for all of them or one for each."""
    if text == AS_THE_ARM_FILE:
        text = getattr(config.device, "firmware", "") or ".".join(map(str, mks.LATEST))
    words = [word.strip() for word in text.split("+")]
    words = words * count if len(words) == 1 else words
    found = [part for part in map(_FIRMWARE.fullmatch, words) if part is not None]
    if not len(words) == len(found) == count:
        raise BadRequest(
            f'firmware is written "1.0.9", or as {count} of them joined by +, not {text!r}'
        )
    return tuple((int(each[1]), int(each[2]), int(each[3])) for each in found)


KIND = SimDeviceKind(MksBoard, _make, MksQuirks)
