"""Bursts and segments in which a motor reverses: it has to take its backlash up as well.

That is merged into the piece of motion in which it reverses, which lasts as long as without it
where the motor can turn so fast, and longer where not. A piece that would last longer than is
announced is preceded by pieces of its own for the backlash, in which nothing but motors turns;
so is one in which the tip would leave its way too far while a motor takes it up.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

from armdrive.controllers.requests import MoveBy
from armdrive.flows.straying import may_lag
from kinematics import Motors

if TYPE_CHECKING:
    from collections.abc import Sequence

    from armdrive.core import Core

Lasts = Callable[[float, float], float]
"""How long the busiest motor's steps may take at a rate."""


def pieces(
    core: Core, steps: Motors, rate_hz: float, longest_s: float, lasts: Lasts
) -> Sequence[MoveBy]:
    """Return what is sent so that some steps are driven: as a rule a single piece.

    None but that of the steps themselves lasts longer than `longest_s`, as `lasts` knows it.
    """
    sent = core.slack.to_send(steps)
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
