"""The posture of a chain a small step from one that is known, on bare floats and quickly, or none.

Levenberg and Marquardt's steps (Marquardt, 1963) by their normal equations. A jog asks this many
times for each leg, also of points that cannot be reached, and has no time for reasons: `ik_near`
gives those. Lengths in mm, angles in rad; errors count mm in the arm's length.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from kinematics.errors import KinematicsError
from kinematics.generated import generated
from kinematics.limits import LIMIT_TOLERANCE_RAD
from kinematics.singularities import length_of
from kinematics.vectors import dot

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kinematics.arm_geometry import ArmGeometry
    from kinematics.chain_arm import ChainArm
    from kinematics.goals import Goal
    from kinematics.spaces import Joints, Pose

ROUNDS = 16
MET = 1e-18
"""A squared error that is none: some 1e-7 mm."""

GENTLE, HARSH = 1e-12, 1.0
"""Between what the damping stays, as a share of the largest diagonal entry."""

EASIER, HARDER = 0.01, 30.0
HOPELESS = 0.999
"""A round that leaves more of the error than this, twice in a row, leads nowhere."""

INSIDE_RAD = 0.05
"""How far from a joint's limit the second look begins."""

Rows = list[list[float]]


def near(arm: ArmGeometry, pose: Pose, seed: Joints) -> Joints | None:
    """Return the posture for a pose a small step from the seed, None where there is none."""
    from kinematics.chain_arm import ChainArm  # few arms are chains

    try:
        return chain_near(arm, pose, seed) if isinstance(arm, ChainArm) else arm.ik_near(pose, seed)
    except KinematicsError:
        return None


def chain_near(arm: ChainArm, pose: Pose, seed: Joints) -> Joints | None:
    """Return the posture of a chain; raises `KinematicsError` for a pose of other axes.

    A singular posture is often one with a joint at its limit, as a straight elbow is: no slope
    leads out of it, so that a look from further inside comes second.
    """
    goal = arm.goal(pose)
    found = _descended(arm, goal, seed.angles_rad)
    if found is None and (inside := _inside(arm, seed.angles_rad)) is not None:
        found = _descended(arm, goal, inside)
    return None if found is None else _within(arm, found)


def _descended(arm: ChainArm, goal: Goal, start: Sequence[float]) -> Sequence[float] | None:
    """Return where the steps from a start meet a goal, None where they do not."""
    length, values = length_of(arm.chain), list(start)
    error, rows = _linear(arm, goal, values, length)
    cost, damping, stuck = _squared(error), 1e-6, 0
    for _ in range(ROUNDS):
        if cost < MET:
            return values
        step = _step(rows, error, damping)
        moved = [a + b for a, b in zip(values, step, strict=True)]
        next_error, next_rows = _linear(arm, goal, moved, length)
        next_cost = _squared(next_error)
        stuck = stuck + 1 if next_cost > HOPELESS * cost else 0
        if next_cost < cost:
            values, error, rows, cost = moved, next_error, next_rows, next_cost
            damping = max(damping * EASIER, GENTLE)
        else:
            damping = min(damping * HARDER, HARSH)
        if stuck > 1:
            return None
    return values if cost < MET else None


def _inside(arm: ChainArm, start: Sequence[float]) -> list[float] | None:
    """Return a start with the joints that stand at a limit inside of it; None where none does."""
    moved = [
        min(max(value, bounds.low_rad + INSIDE_RAD), bounds.high_rad - INSIDE_RAD)
        for bounds, value in zip(arm.limits, start, strict=True)
    ]
    return None if moved == list(start) else moved


def _within(arm: ChainArm, values: Sequence[float]) -> Joints | None:
    """Return the posture, none where it passes a limit by more than rounding."""
    turned = [bounds.clamp(value) for bounds, value in zip(arm.limits, values, strict=True)]
    excess = max(abs(a - b) for a, b in zip(turned, values, strict=True))
    return arm.joints_of(turned) if excess <= LIMIT_TOLERANCE_RAD else None


def _linear(
    arm: ChainArm, goal: Goal, values: Sequence[float], length: float
) -> tuple[list[float], Rows]:
    """Return the errors that are left, and how the joints reduce them."""
    frame, jacobian = generated(arm.chain).fk_and_jacobian(values)
    errors = [(goal.frame[row][3] - frame[row][3]) / length for row in range(3)]
    rows = [[entry / length for entry in jacobian[row]] for row in range(3)]
    turning = list(zip(*jacobian[3:], strict=True))
    for _, axis, miss in goal.turn(frame)[1]:
        errors.append(miss)
        rows.append([dot(column, axis) for column in turning])
    return errors, rows


def _step(rows: Rows, error: Sequence[float], damping: float) -> list[float]:
    """Solve the damped normal equations, by elimination with the largest pivot there is."""
    count = len(rows[0])
    columns = list(zip(*rows, strict=True))
    square = [
        [sum([a * b for a, b in zip(one, other, strict=True)]) for other in columns]
        for one in columns
    ]
    most = max([square[index][index] for index in range(count)])
    table = []
    for index, row in enumerate(square):
        row[index] += damping * most
        row.append(sum([a * b for a, b in zip(columns[index], error, strict=True)]))
        table.append(row)
    for index in range(count):
        best = max(range(index, count), key=lambda at: abs(table[at][index]))
        table[index], table[best] = table[best], table[index]
        head = table[index]
        for below in table[index + 1 :]:
            share = below[index] / head[index]
            for at in range(index, count + 1):
                below[at] -= share * head[at]
    step = [0.0] * count
    for index in reversed(range(count)):
        row = table[index]
        known = sum([row[at] * step[at] for at in range(index + 1, count)])
        step[index] = (row[count] - known) / row[index]
    return step


def _squared(values: Sequence[float]) -> float:
    """Return the sum of squares."""
    return sum([value * value for value in values])
