"""Path deviation: how far a burst may leave the straight path, and how long it may be.

A motion is audited as if it were straight in joint space. A device that does not coordinate its
motors is on that path only at the ends of its bursts; in between, each motor turns by itself. A
burst is therefore short enough that the tip stays within `motion.deviation_mm` of the path, and
shorter near a guard or a joint limit: a joint that moves along its limit may pass it by the few
steps of the smallest burst.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence

from armdrive.abilities import Abort
from armdrive.runtime.arm_state import Core
from armdrive.runtime.position import joints_between
from armdrive.runtime.stop_bounds import deviation_mm
from armdrive.tasks import MoveBy
from kinematics.spaces import Motors

# Joint angles during an uncoordinated burst.
#
# Each motor is somewhere between its start and its target, independently of the others: the motor
# positions fill a box. Every joint is a weighted sum of motors, so its extremes are at corners of
# the box.

Span = tuple[float, float]


def within_limits(core: Core, start: Motors, target: Motors, strays: Sequence[float]) -> bool:
    """Return whether no joint passes its limit on the way, in whatever order the motors turn.

    A limit extends to the start and the target if those lie beyond, plus one motor step. `strays`
    bounds each motor's deviation from its share of the path. The bound applies only if the device
    has no abort: an abort stops the motors with ramps of their own.
    """
    bounded = core.controller.abilities.abort is Abort.NONE
    here, there = (core.transmission.to_joints(each)[0] for each in (start, target))
    limits = core.config.model.arm.limits
    for limit, row, a, b in zip(limits, core.transmission.inverse, here, there, strict=False):
        step = max(map(abs, row))
        low, high = _box(row, a, target - start)
        if bounded:
            stray = sum(abs(share) * one for share, one in zip(row, strays, strict=True))
            low, high = max(low, min(a, b) - stray), min(high, max(a, b) + stray)
        if low < min(limit.low_rad, a, b) - step or high > max(limit.high_rad, a, b) + step:
            return False
    return True


def _box(row: Sequence[float], angle: float, steps: Motors) -> Span:
    """Return the range of a joint's angle while motors make steps in any order."""
    turns_rad = [share * one for share, one in zip(row, steps, strict=True)]
    return (
        angle + sum(min(turn, 0.0) for turn in turns_rad),
        angle + sum(max(turn, 0.0) for turn in turns_rad),
    )


SMALL_STEPS = 2  # a burst this small is always allowed: a step or two of each motor, at most
WAY_OUT_MM = 0.5  # deviation allowed to an arm inside a guard on its way out
LOOKS = (0.25, 0.5, 0.75)  # where a burst is checked against guards; its ends were audited


def has_room(core: Core, target: Motors, rate_hz: float) -> bool:
    """Return whether a burst from the present position may deviate as far as it can."""
    start = core.position.acknowledged
    largest = (target - start).largest
    if core.controller.abilities.coordinated or largest <= SMALL_STEPS:
        return True
    strays = core.controller.deviation_steps(target - start, rate_hz)
    return _stays_near(core, start, target, strays, core.config.motion.deviation_mm, way_out=True)


def _stays_near(
    core: Core,
    start: Motors,
    target: Motors,
    strays: Sequence[float],
    tolerance_mm: float,
    *,
    way_out: bool,
) -> bool:
    """Return whether motors that deviate by `strays` steps keep the arm near its path.

    The tip stays within the tolerance, every joint within its limits, and the arm clear of guards.
    With `way_out`, an arm that is inside a guard may deviate a little on its way out.
    """
    here, there = (core.transmission.to_joints(each)[0] for each in (start, target))
    stray_mm = deviation_mm(core.config, here, strays)
    if stray_mm > tolerance_mm:
        return False
    if not core.position_known:
        return True
    if not within_limits(core, start, target, strays):
        return False
    guards = core.config.model.guards.over(core.config.model.arm)
    on_the_way = (joints_between(here, there, look) for look in LOOKS)
    if all(guards.room_mm(joints) >= stray_mm for joints in on_the_way):
        return True
    return way_out and stray_mm <= WAY_OUT_MM and guards.room_mm(here) < 0.0


def deviation_steps(core: Core, steps: Motors, rate_hz: float) -> tuple[float, ...]:
    """Bound each motor's deviation from the straight path in steps, backlash included."""
    sent = core.position.slack.to_send(steps)
    strays = core.controller.deviation_steps(sent, rate_hz)
    if sent == steps:
        return strays
    return tuple(map(sum, zip(strays, lags(steps, sent), strict=True)))


def lags(steps: Motors, sent: Motors) -> tuple[float, ...]:
    """Return how far each joint lags, in motor steps, while its motor takes up backlash.

    The joint stands while the others move, then catches up. With d steps driven and w taken up, it
    lags by at most d w / (d + w) steps.
    """
    found = []
    for driven, turned in zip(steps, sent, strict=True):
        taken_up = abs(turned - driven)
        found.append(abs(driven) * taken_up / (abs(driven) + taken_up) if taken_up else 0.0)
    return tuple(found)


def may_lag(core: Core, steps: Motors, rate_hz: float) -> bool:
    """Return whether the tip stays near its path if backlash is taken up during these steps.

    The tolerance is `motion.line_tolerance_mm` if the device coordinates its motors.
    """
    start, motion = core.position.commanded, core.config.motion
    coordinated = core.controller.abilities.coordinated
    tolerance_mm = motion.line_tolerance_mm if coordinated else motion.deviation_mm
    strays = deviation_steps(core, steps, rate_hz)
    return _stays_near(core, start, start + steps, strays, tolerance_mm, way_out=False)


# Backlash compensation: a motor that reverses also has to take up its backlash.
#
# The extra steps are merged into the burst or segment in which the motor reverses, which takes
# longer only if the motor cannot turn that fast. If the result would last longer than announced, or
# take the tip too far off its path, the backlash is taken up beforehand, in pieces of its own that
# move no joint.

# Takes the busiest motor's steps and a rate; returns the longest time they may take.
Lasts = Callable[[float, float], float]


def pieces(
    core: Core, steps: Motors, rate_hz: float, longest_s: float, lasts: Lasts
) -> Sequence[MoveBy]:
    """Return the motions to send so that the joints move by some steps; usually a single one.

    The pieces that only take up backlash last at most `longest_s` each, by the measure of `lasts`.
    """
    sent = core.position.slack.to_send(steps)
    if sent == steps:
        return (MoveBy(steps, rate_hz),)
    taken_up = sent - steps
    whole = MoveBy(sent, sent.largest / _least_s(core, sent, taken_up, steps.largest / rate_hz))
    longest_s = max(longest_s, lasts(steps.largest, rate_hz)) + 1e-9
    if lasts(sent.largest, whole.rate_hz) <= longest_s and may_lag(core, steps, rate_hz):
        return (whole,)
    rate = taken_up.largest / _least_s(core, taken_up, taken_up, 0.0)
    return (*_parts(taken_up, rate, longest_s, lasts), MoveBy(steps, rate_hz))


def _least_s(core: Core, sent: Motors, taken_up: Motors, duration_s: float) -> float:
    """Return the least time, at least `duration_s`, in which no reversing motor is too fast."""
    each = zip(sent, taken_up, _rates_hz(core), strict=True)
    return max(duration_s, *(abs(turns) / most for turns, up, most in each if up), 1e-9)


def _rates_hz(core: Core) -> Iterator[float]:
    """Yield the rate of each motor for its fastest joint, limited to what the device can do."""
    model, able_hz = core.config.model, core.controller.usable_rate_hz(math.inf)
    speeds = (*model.joint_speeds_rad_s, model.gripper_speed_mm_s)
    for row in core.transmission.matrix:
        yield min(able_hz, max(abs(a) * b for a, b in zip(row, speeds, strict=False)))


def _parts(steps: Motors, rate_hz: float, longest_s: float, lasts: Lasts) -> Iterator[MoveBy]:
    count = 1
    while (largest := -(-steps.largest // count)) > 1 and lasts(largest, rate_hz) > longest_s:
        count += 1
    made = Motors([0] * len(steps))
    for part in range(1, count + 1):
        share = Motors(abs(one) * part // count * (1 if one > 0 else -1) for one in steps)
        yield MoveBy(share - made, rate_hz)
        made = share
