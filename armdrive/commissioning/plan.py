"""Which drives an arm has, what each should do, and in which order they are met."""

from __future__ import annotations

import math
from dataclasses import dataclass

from armdrive.armfile import ArmConfig
from armdrive.controllers.mks_settings import MksSettings
from armdrive.errors import BadRequest
from armdrive.interview.signs import Trial, roll_joint, trials
from armdrive.sim.found import found_posture
from firmware_protocol.mks import COUNTS_PER_TURN, NODE_DEFAULT

DEGREES, MM = "°", "mm"


@dataclass(frozen=True, slots=True)
class Planned:
    """One motor and its drive.

    `trial` is a small motion of it and what ought to be seen; `moves` names the joint (or the
    fingers) that it moves most, by `per_turn` degrees (or mm) a turn of the motor alone. `gear` is
    the arm file's: turns of the motor for a turn of what its gear drives, or for a mm.
    """

    motor: int
    name: str
    node: int
    trial: Trial
    moves: str
    per_turn: float
    unit: str
    gear: float

    @property
    def gear_words(self) -> str:
        """What the gear counts."""
        return "a mm of the fingers" if self.unit == MM else "one turn of what its gear drives"

    def shown(self, amount: float) -> str:
        """Return degrees or mm for people."""
        return f"{amount:.2g}{'' if self.unit == DEGREES else ' '}{self.unit}"

    @property
    def title(self) -> str:
        """Name it for people."""
        return f"{self.name} (drive {self.node})"


@dataclass(frozen=True, slots=True)
class Plan:
    """The arm as its file, or its preset, says."""

    name: str
    drives: tuple[Planned, ...]
    device: MksSettings
    roll_joint: str

    @property
    def order(self) -> tuple[Planned, ...]:
        """The drives as they are met: the one that keeps the id of a new drive comes last.

        So each new one can be plugged in beside those that have their ids already.
        """
        return tuple(sorted(self.drives, key=lambda each: each.node == NODE_DEFAULT))


def plan_of(config: ArmConfig) -> Plan:
    """Return the plan for an arm. Raises `BadRequest` for one without drives on a CAN bus."""
    transmission, device = config.model.transmission, config.device
    if transmission is None or not isinstance(device, MksSettings):
        raise BadRequest(
            f"{config.name} has no MKS drives: `armdrive can setup` is for arm files that say "
            'dialect = "mks" under [connection]'
        )
    if len(device.ids) < len(transmission.motors):
        raise BadRequest(
            f"mks.ids names {len(device.ids)} drives, and the arm has {len(transmission.motors)} "
            "motors: give each its own"
        )
    arm = config.model.arm
    posture = found_posture(arm)
    by_motor = {each.motor: each for each in trials(arm, transmission, posture)}
    drives = []
    for motor, node in enumerate(device.ids[: len(transmission.motors)]):
        column = [row[motor] for row in transmission.inverse]
        turning = column[: len(transmission.joint_names)]
        most = max(range(len(turning)), key=lambda at: abs(turning[at]))
        if turning[most]:
            moves, unit = transmission.joint_names[most].replace("_", " "), DEGREES
            per_turn = math.degrees(turning[most]) * COUNTS_PER_TURN
        else:
            moves, unit, per_turn = "fingers", MM, column[-1] * COUNTS_PER_TURN
        spec = transmission.motors[motor]
        gear = abs(spec.steps_per_unit) * (1.0 if unit == MM else math.tau) / COUNTS_PER_TURN
        drives.append(Planned(motor, spec.name, node, by_motor[motor], moves, per_turn, unit, gear))
    return Plan(config.name, tuple(drives), device, roll_joint(arm, posture))
