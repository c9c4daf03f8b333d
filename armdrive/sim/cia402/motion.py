"""How a simulated CiA 402 drive moves: by ramps, from SYNC to SYNC, to a stop, home."""

from __future__ import annotations

import math

from armdrive.sim.cia402.node import Cia402Node, Homing
from armdrive.sim.cia402.objects import (
    ENCODER_INCREMENTS,
    HOME_OFFSET,
    HOMING_ACCELERATION,
    HOMING_CREEP,
    HOMING_METHOD,
    HOMING_SPEED,
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


def aim(node: Cia402Node, point: SetPoint) -> None:
    """Take a set-point as the goal: a relative one begins where the last goal was."""
    base = node.goal if point.relative else 0
    node.goal = within(node, base + point.target)


def go(node: Cia402Node, now_s: float) -> None:
    """Go to the goal with speed and ramps of the profile."""
    node.point.go_to(
        node.zero + node.goal,
        max(min(node.number_of(PROFILE_SPEED, 0), top_rate(node)), 1.0),
        slope(node, PROFILE_ACCELERATION),
        now_s,
        braking=slope(node, PROFILE_DECELERATION),
    )
    moved(node, now_s)


def follow(node: Cia402Node, now_s: float) -> None:
    """Go straight to what the target is now, within the period of interpolation."""
    target = within(node, node.number_of(TARGET_POSITION, 0))
    power = node.number_of(PERIOD_POWER, _MS_POWER)
    period_s = max(node.number_of(PERIOD, 1) * 10.0**power, _SHORTEST_S)
    node.point.glide_to(
        node.zero + target, period_s, top_rate(node), now_s, on=node.quirks.extrapolates
    )
    node.ends = False
    if node.quirks.limits:
        node.switch_s = switch_s(node, now_s)


def brake(node: Cia402Node, steep: float, now_s: float) -> None:
    """Slow down to a stand, and hold there."""
    node.point.go_at(0.0, steep, now_s)
    moved(node, now_s)


def slow_down(node: Cia402Node, now_s: float) -> None:
    """Slow down by the ramp of the profile."""
    brake(node, slope(node, PROFILE_DECELERATION), now_s)


def quickly(node: Cia402Node) -> float:
    """Return the ramp of a quick stop."""
    return slope(node, QUICK_STOP_DECELERATION)


def moved(node: Cia402Node, now_s: float) -> None:
    """Take note that a motion has begun, whose end something waits for."""
    node.ends, node.waits = True, False
    node.switch_s = switch_s(node, now_s) if node.quirks.limits else math.inf


def arrived(node: Cia402Node) -> bool:
    """Tell whether the shaft is where the set-point has ended, as nearly as its window asks."""
    return abs(node.point.end - node.shaft) <= node.number_of(POSITION_WINDOW, _USUAL_WINDOW)


def switch_s(node: Cia402Node, now_s: float) -> float:
    """Return when the set-point comes to the limit switch."""
    return node.point.passes_s(node.switch.at, node.switch.way, now_s)


def slope(node: Cia402Node, place: Place) -> float:
    """Return an acceleration that an object holds."""
    return float(max(node.number_of(place, _USUAL_SLOPE), 1))


def top_rate(node: Cia402Node) -> float:
    """Return the increments a second that the motor can turn."""
    return node.number_of(MOST_MOTOR_SPEED, 3000) * node.number_of(ENCODER_INCREMENTS, 10_000) / 60


def within(node: Cia402Node, target: int) -> int:
    """Return a target as the software limits let it be."""
    low, high = node.number_of(LEAST_POSITION, 0), node.number_of(MOST_POSITION, 0)
    held = min(max(target, low), high) if low < high else target
    node.limited = held != target
    return held


def set_mode(node: Cia402Node, mode: int, now_s: float) -> None:
    """Have another mode: what is under way ends, slowing down."""
    if mode == node.mode:
        return
    if node.enabled and node.point.moving(now_s):
        slow_down(node, now_s)
    node.mode, node.homing = mode, node.homing.given_up
    forget_targets(node)


def forget_targets(node: Cia402Node) -> None:
    """Drive to none of what was handed over."""
    while node.machine.points.active is not None:
        node.machine.points.arrived()


def of_profile(node: Cia402Node) -> bool:
    """Tell whether it drives to set-points by itself."""
    return node.mode == OperationMode.PROFILE_POSITION


# --- Homing by the methods 18, 35 and 37 of object 6098 ------------------------------------------
#
# Method 18 goes up to the limit switch, and slowly back until it opens. Methods 35 and 37 take the
# place where the drive stands. From then on the position at home is the offset of 607C.

AT_UPPER_SWITCH = 18
IN_PLACE = (35, 37)
METHODS = frozenset((0, AT_UPPER_SWITCH, *IN_PLACE))
_USUAL_HOMING_SLOPE = 100_000
_USUAL_SPEED = 1000


def begin(node: Cia402Node, now_s: float) -> None:
    """Go home, by the method that is set."""
    forget_targets(node)
    method = node.number_of(HOMING_METHOD, 0)
    if method in IN_PLACE:
        _found(node, node.shaft)
    elif method == AT_UPPER_SWITCH:
        (_leave if node.switch.pressed else _seek)(node, now_s)
    else:
        node.homing = Homing.FAILED


def give_up(node: Cia402Node, now_s: float) -> None:
    """Break a search off, slowing down."""
    if node.homing.searches:
        node.homing, node.switch_s = Homing.NONE, math.inf
        brake(node, _slope(node), now_s)


def watch_switch(node: Cia402Node) -> None:
    """Do what is due at the switch: turn back there, or be home."""
    now_s = node.drive.rack.now_s
    if node.homing is Homing.SEEKING and node.switch.pressed:
        _leave(node, now_s)
    elif node.homing is Homing.LEAVING and not node.switch.pressed:
        _found(node, node.point.at(now_s))


def _seek(node: Cia402Node, now_s: float) -> None:
    node.homing = Homing.SEEKING
    _run(node, node.switch.way * _speed(node, fast=True), now_s)
    node.switch_s = node.point.passes_s(node.switch.at, node.switch.way, now_s)


def _leave(node: Cia402Node, now_s: float) -> None:
    node.homing = Homing.LEAVING
    way = -node.switch.way
    _run(node, way * _speed(node, fast=False), now_s)
    node.switch_s = node.point.passes_s(node.switch.at + way, way, now_s)


def _run(node: Cia402Node, rate: float, now_s: float) -> None:
    node.point.go_at(rate, _slope(node), now_s)
    node.ends = False


def _found(node: Cia402Node, at: int) -> None:
    node.point.hold(at)
    node.goal = node.number_of(HOME_OFFSET, 0)
    node.zero = at - node.goal
    node.homing, node.switch_s, node.ends = Homing.DONE, math.inf, False


def _speed(node: Cia402Node, *, fast: bool) -> float:
    return float(max(node.number_of(HOMING_SPEED if fast else HOMING_CREEP, _USUAL_SPEED), 1))


def _slope(node: Cia402Node) -> float:
    return float(max(node.number_of(HOMING_ACCELERATION, _USUAL_HOMING_SLOPE), 1))
