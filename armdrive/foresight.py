"""What can be foreseen of a plan: the postures on its way, joint margins, and how long it takes.

Units: mm, rad, s.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from armdrive.dialects import dialect

if TYPE_CHECKING:
    from armdrive.armfile import ArmConfig
    from armdrive.controllers.controller import Controller
    from armdrive.legs import Leg
    from armdrive.planning import Plan
    from kinematics import ArmGeometry, ArmModel, Joints

STEP_MM = 2.0
"""No point of the arm travels further than this between two postures, on all but long ways."""

MOST_POSTURES = 500
"""A way that would need more of them is looked at so often, evenly."""


@dataclass(frozen=True, slots=True)
class Margin:
    """How near a joint, or a guarded sum of joints, comes to a bound: below 0 beyond it.

    `index` is that of the posture in which it does.
    """

    joint: str
    margin_rad: float
    value_rad: float
    bound_rad: float
    index: int


def postures_along(arm: ArmGeometry, plan: Plan) -> tuple[Joints, ...]:
    """Return postures along a plan, its start and every corner among them."""
    travels = [_travel_mm(arm, leg) for leg in plan.legs]
    step_mm = max(STEP_MM, math.fsum(travels) / MOST_POSTURES)
    found = [plan.start.joints]
    for leg, travel in zip(plan.legs, travels, strict=True):
        count = max(math.ceil(travel / step_mm), 1)
        found += [leg.start.towards(leg.end, part / count).joints for part in range(1, count + 1)]
    return tuple(found)


def _travel_mm(arm: ArmGeometry, leg: Leg) -> float:
    ends = zip(leg.start.joints, leg.end.joints, strict=True)
    return arm.travel_bound_mm(tuple(b - a for a, b in ends))


def least_margins(model: ArmModel, postures: Sequence[Joints]) -> tuple[Margin, ...]:
    """Return each joint's least distance from its limits, the smallest first, and each sum's.

    A leg is straight in joint space, so that its ends are its worst points: nothing lies between.
    """
    found = []
    for name, bounds in zip(model.arm.joint_names, model.arm.limits, strict=True):
        values = [joints[name] for joints in postures]
        found.append(_least(name, values, bounds.low_rad, bounds.high_rad))
    for one in model.guards.sums:
        sums = [math.fsum(share * each[joint] for joint, share in one.shares) for each in postures]
        found.append(_least(one.name, sums, one.low_rad, one.high_rad))
    return tuple(sorted(found, key=lambda one: one.margin_rad))


def _least(name: str, values: Sequence[float], low: float, high: float) -> Margin:
    def margin(index: int) -> float:
        return min(values[index] - low, high - values[index])

    index = min(range(len(values)), key=margin)
    value = values[index]
    bound = low if value - low <= high - value else high
    return Margin(name, margin(index), value, bound, index)


def foreseen_s(config: ArmConfig, controller: Controller, plan: Plan) -> float:
    """Return about how long a plan takes on the wire, with a device that is as slow as it may be.

    A queue is driven on without a break; bursts wait for one another's exchange. What a device
    that does not coordinate its motors needs besides, to stay near the way, is not foreseen.
    """
    wire = config.connection
    able = dialect(wire.dialect).abilities
    if able.queued_segments:
        return plan.duration_s
    exchange_s, burst_s = able.traffic.exchange_s(wire.baud), config.motion.planned_burst_s
    return math.fsum(_bursts_s(config, controller, leg, burst_s, exchange_s) for leg in plan.legs)


def _bursts_s(
    config: ArmConfig, controller: Controller, leg: Leg, burst_s: float, exchange_s: float
) -> float:
    transmission = config.model.transmission
    if transmission is None or leg.duration_s <= 0.0:
        return leg.duration_s
    begin, end = (transmission.to_exact(one.joints, one.opening_mm) for one in (leg.start, leg.end))
    steps = max(abs(b - a) for a, b in zip(begin, end, strict=True))
    rate_hz = steps / leg.duration_s
    count = max(math.ceil(controller.duration_s(steps, rate_hz) / burst_s - 1e-9), 1)
    one_s = max(leg.duration_s / count, controller.duration_s(steps / count, rate_hz))
    return count * (one_s + exchange_s)
