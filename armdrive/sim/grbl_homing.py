"""Homing of a simulated GRBL board: towards the switches, off them, slowly on again, and off.

All axes that are homed move together, each at the homing rate, and drop out as their switches are
pressed. Unlike the real firmware, which stops an axis dead, the others pause while one drops out.
Source: gnea/grbl grbl/limits.c (limits_go_home).
"""

from __future__ import annotations

import math
from collections.abc import Generator, Sequence

from armdrive.sim.grbl_board import Board
from armdrive.sim.grbl_settings import (
    DEBOUNCE_MS,
    HOMING_DIRECTIONS,
    HOMING_FEED,
    HOMING_SEEK,
    PULL_OFF,
    STEPS,
    TRAVEL,
)
from firmware_protocol.grbl import State

SEARCH = 1.5
"""The way in which a switch is looked for, in travels."""
LOCATE = 5.0
"""The same in pull-offs, when it is looked for again."""
_STILL_PRESSED, _NOT_FOUND = 8, 9
_MINUTE_S = 60.0

Steps = Generator[float, None, int]


def home(board: Board, axes: Sequence[int]) -> Steps:
    """Home axes; returns 0, or the number of the alarm with which it failed."""
    settings = board.settings
    board.state = State.HOME
    board.drive.energise()
    board.idle_off_s = math.inf
    far = SEARCH * max(settings.axis(TRAVEL, axis) for axis in axes)
    back, seek = settings[PULL_OFF], settings[HOMING_SEEK] / _MINUTE_S
    feed = settings[HOMING_FEED] / _MINUTE_S
    for search, rate in ((far, seek), (LOCATE * back, feed)):
        found = yield from _approach(board, axes, search, rate)
        if not found:
            return _NOT_FOUND
        yield board.now_s + settings[DEBOUNCE_MS] / 1000
        yield from _go(board, axes, -back, seek)
        if any(board.switches.pressed(axis) for axis in axes):
            return _STILL_PRESSED
        yield board.now_s + settings[DEBOUNCE_MS] / 1000
    _set_position(board, axes)
    board.state = State.IDLE
    if not settings.motors_stay_on:
        board.let_motors_go()
    board.limits.forget(board)
    return 0


def _approach(
    board: Board, axes: Sequence[int], search: float, rate: float
) -> Generator[float, None, bool]:
    """Move axes until each has pressed its switch; False where one has not by then."""
    left = [axis for axis in axes if not board.switches.pressed(axis)]
    while left:
        if search <= 0.0:
            return False
        ways = [_units_to_switch(board, axis) for axis in left]
        way = min([search, *(way for way in ways if way is not None)])
        yield from _go(board, left, way, rate)
        search -= way
        left = [axis for axis in left if not board.switches.pressed(axis)]
    return True


def _units_to_switch(board: Board, axis: int) -> float | None:
    """Return how far an axis has to go, and a whole step at least; None where for ever."""
    steps = board.switches.steps_to(axis, _way(board, axis))
    return None if steps is None else max(steps, 1) / board.settings.axis(STEPS, axis)


def _way(board: Board, axis: int) -> int:
    return -1 if board.settings.mask(HOMING_DIRECTIONS, axis) else 1


def _go(
    board: Board, axes: Sequence[int], units: float, rate: float
) -> Generator[float, None, None]:
    """Move axes by as much each towards their switches (back where negative), and wait."""
    target = list(board.drive.units_of(board.drive.rack.goal))
    for axis in axes:
        target[axis] += units * _way(board, axis)
    board.drive.queue_to(target, rate * math.sqrt(len(axes)), board.now_s)
    while board.drive.rack.waiting:
        yield math.inf


def _set_position(board: Board, axes: Sequence[int]) -> None:
    """Have the axes stand a pull-off inside their travel, which is all on the negative side."""
    settings = board.settings
    place = list(board.drive.units_of(board.drive.rack.goal))
    for axis in axes:
        place[axis] = -settings[PULL_OFF]
        if settings.mask(HOMING_DIRECTIONS, axis):
            place[axis] = settings[PULL_OFF] - settings.axis(TRAVEL, axis)
    counts = board.drive.steps_of(place)
    board.drive.set_axes(counts, board.now_s)
    board.parser.position = board.drive.units_of(counts)
