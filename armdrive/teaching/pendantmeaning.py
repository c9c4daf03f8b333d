"""What the rows of a pendant's program mean on one arm: joint angles, fingers, and how fast.

Registers are added to the program's origin, which makes them motor steps of the arm's model.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from armdrive.controllers.speed import SpeedTable
from armdrive.errors import Refused
from armdrive.points import Point, Step, StepList
from armdrive.teaching.pendantrows import PendantProgram, is_move
from kinematics import Motors

if TYPE_CHECKING:
    from armdrive.armfile import ArmConfig
    from firmware_protocol.teachmover import ProgramRow
    from kinematics import Joints

SLOWEST = 0.01
"""No step of a sequence is slower: a share of the limits."""

SAME_MM = 1.0
"""Fingers that differ by less between two rows are left alone."""


@dataclass(frozen=True, slots=True)
class Place:
    """Where a row leads: joint angles, the fingers' opening, the busiest motor's rate."""

    joints: Joints
    opening_mm: float
    rate_hz: float
    speed: float


def rate_hz(config: ArmConfig, row: ProgramRow) -> float:
    """Return half-steps a second of a row's busiest motor, by the arm file's table."""
    return SpeedTable(config.device.speed_table).rate_hz(row.speed)


def place_of(config: ArmConfig, program: PendantProgram, row: ProgramRow) -> Place | None:
    """Return where a row leads; None of one that is no move, or where no origin is known."""
    transmission = config.model.transmission
    if not is_move(row) or program.origin is None or transmission is None:
        return None
    steps = (count + at for count, at in zip(row.positions, program.origin, strict=True))
    joints, opening_mm = transmission.to_joints(Motors(steps))
    rate = rate_hz(config, row)
    fastest = SpeedTable(config.device.speed_table).points[-1][1]
    return Place(joints, opening_mm, rate, min(max(round(rate / fastest, 2), SLOWEST), 1.0))


def meaning(config: ArmConfig, program: PendantProgram, row: ProgramRow) -> str:
    """Return what a row means, in words; what is not known of it is left out."""
    if not is_move(row):
        return "not a move that is known"
    fast = f"{rate_hz(config, row):.0f} steps/s"
    place = place_of(config, program, row)
    return fast if place is None else f"{fast}; {place.joints}; fingers {place.opening_mm:.1f} mm"


def taught_by(
    config: ArmConfig, program: PendantProgram, name: str, note: str = ""
) -> tuple[dict[str, Point], StepList]:
    """Return points and a sequence over them that do what a pendant's program does.

    Points are named after the sequence and their rows. Where a row moves nothing but the fingers,
    it is a step of the fingers; where it moves both, the arm goes first. Raises `Refused` where
    nobody knows what the rows mean.
    """
    if program.origin is None:
        raise Refused(
            "the rows say registers, and nobody knows what those counted from: read the program "
            "again from an arm that has been homed"
        )
    if not program.rows:
        raise Refused("the program has no rows: there is nothing to make points of")
    program.require_once()
    points: dict[str, Point] = {}
    steps: list[Step] = []
    last: Place | None = None
    for row in program.rows:
        place = place_of(config, program, row)
        if place is None:
            raise Refused(f"row {row.number} is of an unknown kind: take it out, or make it a move")
        if last is None or place.joints != last.joints:
            point = f"{name}-{row.number}"
            points[point] = Point(place.joints, place.opening_mm, f"row {row.number}")
            steps.append(Step(point, speed=place.speed))
        if last is None or abs(place.opening_mm - last.opening_mm) >= SAME_MM:
            opening = round(max(place.opening_mm, 0.0), 1)
            steps.append(Step(gripper=opening, speed=place.speed))
        last = place
    return points, StepList(tuple(steps), note or "from the arm's own program")
