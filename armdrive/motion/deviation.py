"""Room for a burst of a device that does not coordinate its motors: how far it may stray.

A whole motion is audited as if it were straight in joint space. Such a device keeps to that only
at the ends of its bursts; between them each motor goes its own way. So a burst is made short
enough that the tip stays within `motion.straying_mm` of the straight way, and shorter where a
guard or a joint's limit is nearer than that. Where a joint is beside its limit, a small burst is
made motor by motor.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence

from armdrive.abilities import Abort
from armdrive.runtime.arm_state import Core
from armdrive.runtime.position import joints_between
from armdrive.runtime.stop_bounds import straying_mm
from armdrive.tasks import MoveBy
from kinematics.spaces import Joints, Motors

# Where joints may be during a burst whose motors are not coordinated, and in which order they go.
#
# Each motor is somewhere between its start and its target, and nobody knows in which company: the
# joints are somewhere in the picture of that box. Through the couplings every joint is a sum over
# the motors, so that its extremes are at corners of the box.

Span = tuple[float, float]


class Corridor:
    """What every joint has to keep to on the way from a start to a target.

    Its limits, or what the start or the target are beyond them already, and a step of one motor.
    """

    def __init__(self, core: Core, start: Motors, target: Motors) -> None:
        self._core = core
        self._rows = core.transmission.inverse
        here, there = (core.transmission.to_joints(each)[0] for each in (start, target))
        self._allowed = [
            (min(bounds.low_rad, a, b) - step, max(bounds.high_rad, a, b) + step)
            for bounds, a, b, step in zip(
                core.config.model.arm.limits, here, there, self._steps_rad(), strict=False
            )
        ]

    def holds(self, start: Motors, end: Motors, strays: Sequence[float] | None = None) -> bool:
        """Tell whether no joint leaves the corridor, whichever motors are ahead of the others.

        `strays` says how far each is from its share of the way at most. It is of use where nothing
        ends a burst in mid-way: a ramp ends the motors each at a place of its own.
        """
        here, _ = self._core.transmission.to_joints(start)
        there, _ = self._core.transmission.to_joints(end)
        if self._core.controller.abilities.abort is not Abort.NONE:
            strays = None
        for row, a, b, (low, high) in zip(self._rows, here, there, self._allowed, strict=False):
            reach_low, reach_high = _box(row, a, end - start)
            if strays is not None:
                stray = sum(abs(share) * one for share, one in zip(row, strays, strict=True))
                reach_low = max(reach_low, min(a, b) - stray)
                reach_high = min(reach_high, max(a, b) + stray)
            if reach_low < low or reach_high > high:
                return False
        return True

    def _steps_rad(self) -> Iterator[float]:
        return (max(map(abs, row)) for row in self._rows)


def _box(row: Sequence[float], angle: float, steps: Motors) -> Span:
    """Return the least and the greatest angle of a joint while motors make steps in any order."""
    turns_rad = [share * one for share, one in zip(row, steps, strict=True)]
    return (
        angle + sum(min(turn, 0.0) for turn in turns_rad),
        angle + sum(max(turn, 0.0) for turn in turns_rad),
    )


def turns(corridor: Corridor, start: Motors, target: Motors) -> tuple[Motors, ...]:
    """Return the ends of bursts that lead to a target, in which motors take turns.

    As many motors go at once as the corridor has room for; nothing where no order stays in it.
    """
    moving = [motor for motor, one in enumerate(target - start) if one]
    order = _order(corridor, start, target, frozenset(moving), set())
    ends: list[Motors] = []
    at = before = start
    for motor in order:
        further = _with(before, target, motor)
        if before != at and not corridor.holds(at, further):
            ends.append(before)
            at = before
        before = further
    return (*ends, before) if order else ()


def _order(
    corridor: Corridor, at: Motors, target: Motors, left: frozenset[int], dead: set[frozenset[int]]
) -> tuple[int, ...]:
    """Return in which order motors go one by one, empty where none stays in the corridor."""
    for motor in sorted(left):
        rest, there = left - {motor}, _with(at, target, motor)
        if rest in dead or not corridor.holds(at, there):
            continue
        if not rest:
            return (motor,)
        if order := _order(corridor, there, target, rest, dead):
            return (motor, *order)
    dead.add(left)
    return ()


def _with(at: Motors, target: Motors, motor: int) -> Motors:
    return Motors(target[n] if n == motor else one for n, one in enumerate(at))


SMALL_STEPS = 8
"""A burst this small is sent whatever the tip may stray: there must be a way out of a guard."""

WAY_OUT_MM = 0.5
"""An arm within a guard goes out in bursts that stray no more: the steps of drives are tiny."""

LOOKS = (0.25, 0.5, 0.75)
"""Where on its way a burst is compared with the guards; its ends have been audited."""


def has_room(core: Core, target: Motors, rate_hz: float) -> bool:
    """Tell whether a burst from where the arm is may stray as far as it can."""
    start = core.position.acknowledged
    largest = (target - start).largest
    if core.controller.abilities.coordinated or largest <= 1:
        return True
    if largest <= SMALL_STEPS:
        return bool(in_turn(core, target, rate_hz))
    strays = core.controller.strays_steps(target - start, rate_hz)
    here, _ = core.transmission.to_joints(start)
    stray_mm = straying_mm(core.config, here, strays)
    if stray_mm > core.config.motion.straying_mm:
        return False
    if not core.position_known:
        return True
    if not Corridor(core, start, target).holds(start, target, strays):
        return False
    there, _ = core.transmission.to_joints(target)
    if _clear_of_guards(core, here, there, stray_mm):
        return True
    return stray_mm <= WAY_OUT_MM and _within_a_guard(core, here)


def _within_a_guard(core: Core, joints: Joints) -> bool:
    guards = core.config.model.guards.over(core.config.model.arm)
    return min(guards.room(joints)) < 0.0


def _clear_of_guards(core: Core, here: Joints, there: Joints, stray_mm: float) -> bool:
    guards = core.config.model.guards.over(core.config.model.arm)
    on_the_way = (joints_between(here, there, look) for look in LOOKS)
    return all(min(guards.room(joints)) >= stray_mm for joints in on_the_way)


def strays_steps(core: Core, steps: Motors, rate_hz: float) -> tuple[float, ...]:
    """Bound how far what motors drive is beside its straight way, backlash included."""
    sent = core.position.slack.to_send(steps)
    strays = core.controller.strays_steps(sent, rate_hz)
    if sent == steps:
        return strays
    return tuple(map(sum, zip(strays, lags(steps, sent), strict=True)))


def lags(steps: Motors, sent: Motors) -> tuple[float, ...]:
    """Return how far each motor's load is behind its share of a piece that takes backlash up.

    It stands while the others go, and catches up: at most d w / (d + w) steps behind, where d are
    driven and w taken up.
    """
    found = []
    for driven, turned in zip(steps, sent, strict=True):
        taken_up = abs(turned - driven)
        found.append(abs(driven) * taken_up / (abs(driven) + taken_up) if taken_up else 0.0)
    return tuple(found)


def may_lag(core: Core, steps: Motors, rate_hz: float) -> bool:
    """Tell whether backlash may be taken up in the piece of these steps, as the tip keeps its way.

    Devices that coordinate their motors keep to `motion.line_tolerance_mm` there as everywhere.
    """
    start, target = core.position.commanded, core.position.commanded + steps
    strays = strays_steps(core, steps, rate_hz)
    here, there = (core.transmission.to_joints(each)[0] for each in (start, target))
    motion, able = core.config.motion, core.controller.abilities
    stray_mm = straying_mm(core.config, here, strays)
    if stray_mm > (motion.line_tolerance_mm if able.coordinated else motion.straying_mm):
        return False
    if not core.position_known:
        return True
    holds = Corridor(core, start, target).holds(start, target, strays)
    return holds and _clear_of_guards(core, here, there, stray_mm)


def in_turn(core: Core, target: Motors, rate_hz: float) -> tuple[Motors, ...]:
    """Return where the bursts end that a burst is made of: itself alone, nearly always.

    A small one beside a joint's limit is made of several, motor by motor, in an order in which no
    joint passes its limit; nothing is returned where there is no such order.
    """
    start = core.position.acknowledged
    steps = target - start
    free = core.controller.abilities.coordinated or not core.position_known
    if free or not 1 < steps.largest <= SMALL_STEPS:
        return (target,)
    corridor = Corridor(core, start, target)
    if corridor.holds(start, target, core.controller.strays_steps(steps, rate_hz)):
        return (target,)
    return turns(corridor, start, target)


# Bursts and segments in which a motor reverses: it has to take its backlash up as well.
#
# That is merged into the piece of motion in which it reverses, which lasts as long as without it
# where the motor can turn so fast, and longer where not. A piece that would last longer than is
# announced is preceded by pieces of its own for the backlash, in which nothing but motors turns;
# so is one in which the tip would leave its way too far while a motor takes it up.

Lasts = Callable[[float, float], float]
"""How long the busiest motor's steps may take at a rate."""


def pieces(
    core: Core, steps: Motors, rate_hz: float, longest_s: float, lasts: Lasts
) -> Sequence[MoveBy]:
    """Return what is sent so that some steps are driven: as a rule a single piece.

    None but that of the steps themselves lasts longer than `longest_s`, as `lasts` knows it.
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
    """Return the least time, from `duration_s` on, in which no motor that reverses is too fast."""
    each = zip(sent, taken_up, _rates_hz(core), strict=True)
    return max(duration_s, *(abs(turns) / most for turns, up, most in each if up), 1e-9)


def _rates_hz(core: Core) -> Iterator[float]:
    """Give how fast each motor turns for the fastest of its joints alone, where it is able to."""
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
