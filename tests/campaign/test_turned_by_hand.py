"""`TurnedByHand` excuses the turned shaft alone, between the two places, for a moment."""

import random

import pytest

from kinematics import Motors

from .excuses import TurnedByHand
from .faults import FAULTS
from .physical import Bound
from .stage import Stage

BASE, SHOULDER, BY = 0, 1, 25
SOON_S, LATE_S = 0.02, 0.1
RESTS = 8
"""How many counts a drive that holds may be off its target."""


def only(motor: int, count: int) -> Motors:
    return Motors(count if each == motor else 0 for each in range(6))


def turned(dialect: str = "cia402") -> Stage:
    """Return a standing arm whose base a hand has turned."""
    stage = Stage(dialect, random.Random(1), 0)
    stage.watch.add_bound(Bound("stop", -9.0, stage.world.tip, 0.2, 20.0))
    before = stage.world.motors
    assert stage.turn_by_hand(only(BASE, BY))
    stage.watch.turned_by_hand = excuse_of(stage, before)
    return stage


def excuse_of(stage: Stage, before: Motors) -> TurnedByHand | None:
    return TurnedByHand.of(stage.config, before, stage.world.motors, stage.now_s)


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
    assert excuse_of(stage, stage.world.motors) is None


@pytest.mark.parametrize("referencing", [True, False])
def test_only_a_reference_that_is_being_taken_hides_the_hand(referencing):
    stage = Stage("armdroid", random.Random(1), 0)
    hand = next(fault for fault in FAULTS if fault.name == "pendant used")
    with stage.watch.reference_attempt() as ended_well:
        stage.referenced_s = stage.now_s
        if referencing:
            hand.begin(stage)
        ended_well()
    if not referencing:
        hand.begin(stage)
    assert bool(stage.watch.slipped) is referencing
