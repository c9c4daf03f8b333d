"""How a simulated CiA 402 drive moves: to a target with ramps, from SYNC to SYNC, to a stand."""

from __future__ import annotations

import math

from armdrive.sim.cia402_node import Node
from armdrive.sim.cia402_places import (
    ENCODER_INCREMENTS,
    LEAST_POSITION,
    MOST_MOTOR_SPEED,
    MOST_POSITION,
    PERIOD,
    PERIOD_POWER,
    POSITION_WINDOW,
)
from firmware_protocol.canopen import (
    PROFILE_ACCELERATION,
    PROFILE_DECELERATION,
    PROFILE_SPEED,
    QUICK_STOP_DECELERATION,
    TARGET_POSITION,
    OperationMode,
    Place,
    SetPoint,
)

_USUAL_SLOPE, _USUAL_WINDOW = 100_000, 10
_MS_POWER = -3
_SHORTEST_S = 1e-4


def aim(node: Node, point: SetPoint) -> None:
    """Take a set-point as the goal: a relative one begins where the last goal was."""
    base = node.goal if point.relative else 0
    node.goal = within(node, base + point.target)


def go(node: Node, now_s: float) -> None:
    """Go to the goal with speed and ramps of the profile."""
    node.point.go_to(
        node.zero + node.goal,
        max(min(node.number_of(PROFILE_SPEED, 0), top_rate(node)), 1.0),
        slope(node, PROFILE_ACCELERATION),
        now_s,
        braking=slope(node, PROFILE_DECELERATION),
    )
    moved(node, now_s)


def follow(node: Node, now_s: float) -> None:
    """Go straight to what the target is now, within the period of interpolation."""
    target = within(node, node.number_of(TARGET_POSITION, 0))
    power = node.number_of(PERIOD_POWER, _MS_POWER)
    period_s = max(node.number_of(PERIOD, 1) * 10.0**power, _SHORTEST_S)
    node.point.glide_to(
        node.zero + target, period_s, top_rate(node), now_s, on=node.habits.extrapolates
    )
    node.ends = False
    if node.habits.limits:
        node.switch_s = switch_s(node, now_s)


def brake(node: Node, steep: float, now_s: float) -> None:
    """Slow down to a stand, and hold there."""
    node.point.go_at(0.0, steep, now_s)
    moved(node, now_s)


def slow_down(node: Node, now_s: float) -> None:
    """Slow down by the ramp of the profile."""
    brake(node, slope(node, PROFILE_DECELERATION), now_s)


def quickly(node: Node) -> float:
    """Return the ramp of a quick stop."""
    return slope(node, QUICK_STOP_DECELERATION)


def moved(node: Node, now_s: float) -> None:
    """Take note that a motion has begun, whose end something waits for."""
    node.ends, node.waits = True, False
    node.switch_s = switch_s(node, now_s) if node.habits.limits else math.inf


def arrived(node: Node) -> bool:
    """Tell whether the shaft is where the set-point has ended, as nearly as its window asks."""
    return abs(node.point.end - node.shaft) <= node.number_of(POSITION_WINDOW, _USUAL_WINDOW)


def switch_s(node: Node, now_s: float) -> float:
    """Return when the set-point comes to the limit switch."""
    return node.point.passes_s(node.switch.at, node.switch.way, now_s)


def slope(node: Node, place: Place) -> float:
    """Return an acceleration that an object holds."""
    return float(max(node.number_of(place, _USUAL_SLOPE), 1))


def top_rate(node: Node) -> float:
    """Return the increments a second that the motor can turn."""
    return node.number_of(MOST_MOTOR_SPEED, 3000) * node.number_of(ENCODER_INCREMENTS, 10_000) / 60


def within(node: Node, target: int) -> int:
    """Return a target as the software limits let it be."""
    low, high = node.number_of(LEAST_POSITION, 0), node.number_of(MOST_POSITION, 0)
    held = min(max(target, low), high) if low < high else target
    node.limited = held != target
    return held


def set_mode(node: Node, mode: int, now_s: float) -> None:
    """Have another mode: what is under way ends, slowing down."""
    if mode == node.mode:
        return
    if node.enabled and node.point.moving(now_s):
        slow_down(node, now_s)
    node.mode, node.homing = mode, node.homing.given_up
    forget_targets(node)


def forget_targets(node: Node) -> None:
    """Drive to none of what was handed over."""
    while node.machine.points.active is not None:
        node.machine.points.arrived()


def of_profile(node: Node) -> bool:
    """Tell whether it drives to set-points by itself."""
    return node.mode == OperationMode.PROFILE_POSITION
