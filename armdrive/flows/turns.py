"""Where joints may be during a burst whose motors are not coordinated, and in which order they go.

Each motor is somewhere between its start and its target, and nobody knows in which company: the
joints are somewhere in the picture of that box. Through the couplings every joint is a sum over
the motors, so that its extremes are at corners of the box.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from armdrive.abilities import Abort
from kinematics import Motors

if TYPE_CHECKING:
    from armdrive.core import Core

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
