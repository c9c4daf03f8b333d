"""A shaft that a hand turns is turned back: it alone, no farther than the hand, and at once."""

from __future__ import annotations

import random

import pytest

from kinematics import Motors

from .physical import Bound
from .stage import Stage
from .turned import turned_by_hand

BASE, SHOULDER, BY = 0, 1, 25
SOON_S, LATE_S = 0.02, 0.1
RESTS = 8
"""How many increments a drive that holds may be off its target."""


def only(motor: int, count: int) -> Motors:
    return Motors(count if each == motor else 0 for each in range(6))


def turned(dialect: str = "cia402") -> Stage:
    """Return an arm that stands, and whose base a hand has turned."""
    stage = Stage(dialect, random.Random(1), 0)
    stage.watch.promise(Bound("stop", -9.0, stage.world.tip, 0.2, 20.0))
    before = stage.world.motors
    assert stage.turn_by_hand(only(BASE, BY))
    stage.watch.turned = turned_by_hand(stage, before)
    return stage


@pytest.mark.parametrize("counts", [(-BY,), (-10,), (-BY, BY)])
def test_its_drive_may_turn_it_back_and_forth(counts):
    stage = turned()
    for count in counts:
        stage.world.drive(only(BASE, count), SOON_S)
    assert not stage.watch.broken


@pytest.mark.parametrize(
    ("motor", "count", "time_s"),
    [
        (BASE, -BY, LATE_S),
        (BASE, -BY - 1, SOON_S),
        (BASE, RESTS + 1, SOON_S),
        (SHOULDER, RESTS + 1, SOON_S),
    ],
)
def test_nothing_else_moves(motor, count, time_s):
    stage = turned()
    stage.world.drive(only(motor, count), time_s)
    assert any("stop: it moved" in each for each in stage.watch.broken)


def test_no_stepper_is_turned_back():
    stage = Stage("teachmover", random.Random(1), 0)
    assert turned_by_hand(stage, stage.world.motors) is None
