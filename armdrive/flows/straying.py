"""Room for a burst of a device that does not coordinate its motors: how far it may stray.

A whole motion is audited as if it were straight in joint space. Such a device keeps to that only
at the ends of its bursts; between them each motor goes its own way. So a burst is made short
enough that the tip stays within `motion.straying_mm` of the straight way, and shorter where a
guard or a joint's limit is nearer than that. Where a joint is beside its limit, a small burst is
made motor by motor (flows/turns.py).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from armdrive.flows.turns import Corridor, turns
from armdrive.stopping import straying_mm

if TYPE_CHECKING:
    from armdrive.core import Core
    from kinematics import Joints, Motors

SMALL_STEPS = 8
"""A burst this small is sent whatever the tip may stray: there must be a way out of a guard."""

WAY_OUT_MM = 0.5
"""An arm within a guard goes out in bursts that stray no more: the steps of drives are tiny."""

LOOKS = (0.25, 0.5, 0.75)
"""Where on its way a burst is compared with the guards; its ends have been audited."""


def has_room(core: Core, target: Motors, rate_hz: float) -> bool:
    """Tell whether a burst from where the arm is may stray as far as it can."""
    start = core.acknowledged
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
    for look in LOOKS:
        angles = (a + (b - a) * look for a, b in zip(here, there, strict=True))
        room = guards.room(here.replace(**dict(zip(here.names, angles, strict=True))))
        if min(room) < stray_mm:
            return False
    return True


def strays_steps(core: Core, steps: Motors, rate_hz: float) -> tuple[float, ...]:
    """Bound how far what motors drive is beside its straight way, backlash included."""
    sent = core.slack.to_send(steps)
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
    start, target = core.commanded, core.commanded + steps
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
    start = core.acknowledged
    steps = target - start
    free = core.controller.abilities.coordinated or not core.position_known
    if free or not 1 < steps.largest <= SMALL_STEPS:
        return (target,)
    corridor = Corridor(core, start, target)
    if corridor.holds(start, target, core.controller.strays_steps(steps, rate_hz)):
        return (target,)
    return turns(corridor, start, target)
