"""The motors of an arm with drives on a CAN bus: one drive each, how fast and far they turn."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from armdrive.config.arm import ArmConfig
from armdrive.config.sections import GripperSettings
from armdrive.errors import ArmFileError, Refused
from armdrive.text.toml import within
from armdrive.transports.address import is_can
from kinematics.transmission import MotorSpec, Transmission

ALL_SILENT = (
    "Check that the drives have power, that the bus's cable sits and has a resistor of 120 ohm at "
    "each of its two ends, and that ids and bit rate are those of the arm file"
)
"""What a person does about a bus on which no drive answers."""


HOST_S = 0.03
"""What an operating system, an adapter and a bus with other traffic may add to a frame's way."""


def absent_words(drives: Sequence[object], number: str) -> str:
    """Say which drives do not answer, and what to look at; `number` is what tells them apart."""
    named, verb = ", ".join(map(str, drives)), "does" if len(drives) == 1 else "do"
    return (
        f"{named} {verb} not answer, while others on the bus do: check that it has power, that its "
        f"CAN plug sits, and that its {number} and bit rate are those of the arm file"
    )


def check_ids(section: str, ids: Sequence[int], most: int, number: str) -> None:
    """Raise `ArmFileError` unless the drives of an arm have numbers of their own."""
    for index, node in enumerate(ids):
        within(f"{section}.ids[{index}]", node, 1, most)
    if not ids or len(set(ids)) != len(ids):
        raise ArmFileError(f"{section}.ids gives each motor {number} of its own, not {list(ids)}")


@dataclass(frozen=True, slots=True)
class BusMotors:
    """In the order of the motors: `ranges` are how many steps each turns between its limits.

    `fastest_hz` is how many steps a second the fastest makes at most.
    """

    names: tuple[str, ...]
    fastest_hz: float
    ranges: tuple[float, ...]

    @property
    def count(self) -> int:
        """How many there are."""
        return len(self.names)


def bus_motors(config: ArmConfig, section: str, ids: Sequence[int]) -> BusMotors:
    """Return the motors of an arm, for each of which its file's section names a drive.

    Raises `Refused` where its port is no CAN adapter or its gripper none of a drive's, and
    `ArmFileError` where drives or transmission are missing.
    """
    port, transmission = config.connection.port, config.model.transmission
    if port and not is_can(port):
        raise Refused(
            f"{port} is no CAN adapter, and these drives are on a CAN bus: write the port as "
            "can:slcan:/dev/ttyACM0?bitrate=500000, or see `armdrive ports`"
        )
    if config.gripper.kind in ("servo", "output"):
        raise Refused(
            f'gripper.kind is "{config.gripper.kind}", which no drive commands: let a '
            'drive move the fingers ("stepper"), or nothing ("none")'
        )
    if transmission is None:
        raise ArmFileError("no motor steps are known of this arm: give steps_per_turn")
    names = tuple(motor.name for motor in transmission.motors)
    if len(ids) < len(names):
        raise ArmFileError(
            f"{section}.ids names {len(ids)} drives, but the arm has {len(names)} motors"
        )
    speeds = (*config.model.joint_speeds_rad_s, config.model.gripper_speed_mm_s)
    spans = [one.high_rad - one.low_rad for one in config.model.arm.limits]
    low_mm, high_mm = config.model.gripper_range_mm
    spans.append(high_mm - low_mm)
    return BusMotors(
        names,
        max(_sum(row, speeds) for row in transmission.matrix),
        tuple(_sum(row, spans) for row in transmission.matrix),
    )


def one_motor(config: ArmConfig, name: str, fastest_hz: float) -> ArmConfig:
    """Return an arm that is one motor alone, which turns no faster, one step a count.

    For a controller that is to turn a motor of which nobody knows what it moves.
    """
    turns = Transmission((MotorSpec(name, 1.0, (1.0,)),), (name,))
    return replace(
        config,
        model=replace(config.model, transmission=turns, joint_speeds_rad_s=(fastest_hz,)),
        connection=replace(config.connection, port=""),
        gripper=GripperSettings(),
    )


def _sum(row: Sequence[float], of_joints: Sequence[float]) -> float:
    """Return what all joints together, each as it is, make of a motor."""
    return math.fsum(abs(share * each) for share, each in zip(row, of_joints, strict=False))
