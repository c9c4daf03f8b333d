"""A drive that begins anew too quickly to miss a question: its count has leapt, which is seen."""

from __future__ import annotations

import random

import pytest
from mks_bench import (
    BOTH,
    BURSTS,
    ORDERS,
    MksBench,
    along,
    begun,
    hold_up,
    restart,
    segments,
    suspend,
)

from armdrive.dialects.mks.wire import GIVE
from armdrive.tasks import AlertKind, Done, Halted, MoveBy, RequestRejected
from firmware_protocol.mks import Code
from kinematics import Motors

TOLD_S = 0.15
"""A look every 0.1 s, another one at once, and their answers."""
RUN_ON_S = 0.3
"""What is sent ahead, and a ramp."""


def moving(start, speed, after_s, turns=False):
    way = (speed, -speed // 2, 700, 0, 0, 0)
    back = tuple(-each for each in way)
    moves = segments(*([way] * 12 + [back] * 12 * turns))
    return begun(moves, after_s, starts=(start, 50_000, 50_000, 0, 0, 0))


@pytest.mark.parametrize("dead_s", [0.0, 0.02, 0.05])
@pytest.mark.parametrize("after_s", [0.21, 0.47, 0.6])
@pytest.mark.parametrize(
    ("start", "speed"),
    [(9000, 9000), (-3000, 9000), (0, 3000), (20_000, 3000), (20_000, -3000), (60_000, 300)],
)
def test_a_drive_that_begins_anew_at_once_is_found_and_goes_no_farther_than_was_sent(
    start, speed, after_s, dead_s
):
    bench = moving(start, speed, after_s)
    began_s, stood = bench.now_s, bench.node(1).at(bench.now_s)
    shaft = restart(bench, 1, dead_s=dead_s)
    assert isinstance(bench.finish(), RequestRejected)
    (alert,) = bench.alerts()
    assert "drive 1 (base)" in alert.text
    assert "reset" in alert.text
    bench.run(1.0)
    most = abs(speed) * 10 * (dead_s + TOLD_S + RUN_ON_S)
    assert abs(shaft() - stood) <= most
    assert bench.now_s - 1.0 < began_s + dead_s + 2.0


def test_one_that_keeps_its_angle_is_found_by_the_turns_that_are_missing():
    bench = moving(40_000, 3000, 0.47)
    restart(bench, 1, keeps_angle=True)
    assert isinstance(bench.finish(), RequestRejected)
    assert "drive 1 (base)" in bench.alerts()[0].text


def test_one_that_does_not_move_is_found_as_well():
    bench = MksBench(starts=(0, 0, 30_000, 0, 0, 0)).ready()
    bench.begin(along(segments(*([(3000, 0, 0, 0, 0, 0)] * 12))))
    bench.run(0.3)
    restart(bench, 3)
    assert isinstance(bench.finish(), RequestRejected)
    assert "drive 3 (elbow)" in bench.alerts()[0].text


@pytest.mark.parametrize("after_s", [0.02, 0.2, 0.5])
@pytest.mark.parametrize("start", [9000, -20_000, 2 * GIVE])
def test_in_a_burst_it_is_found_as_well(start, after_s):
    bench = MksBench(settings=BURSTS, starts=(start, 0, 0, 0, 0, 0)).ready()
    bench.begin(MoveBy(Motors((30_000, -9000, 0, 0, 0, 0)), 30_000.0))
    bench.run(after_s)
    restart(bench, 1)
    assert isinstance(bench.finish(), RequestRejected)
    assert bench.alerts()[0].kind in (AlertKind.RESTARTED, AlertKind.ASTRAY)
    assert "drive 1 (base)" in bench.alerts()[0].text


@pytest.mark.parametrize("after_s", [0.0, 0.02, 0.06])
def test_one_that_begins_anew_while_it_brakes_is_found_as_well(after_s):
    bench = moving(9000, 9000, 0.5)
    bench.controller.stop(hard=False)
    bench._speak()
    bench.run(after_s)
    restart(bench, 1)
    assert isinstance(bench.finish(), Halted)
    assert "drive 1 (base)" in bench.alerts()[0].text


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("sides", [BOTH, ORDERS])
def test_a_bus_and_a_program_that_are_late_make_no_count_leap(sides, seed):
    dice = random.Random(seed)
    bench = moving(50_000, 9000, 0.1, turns=True)
    while bench.controller.busy and bench.now_s < 30.0:
        bench.run(dice.uniform(0.0, 0.4))
        late = dice.choice((hold_up, suspend))
        late(bench, dice.uniform(0.0, 0.3), *([sides] if late is hold_up else []))
    assert isinstance(bench.finish(), Done)
    assert not bench.alerts()


@pytest.mark.parametrize("late_s", [0.05, 0.3])
def test_one_answer_that_was_late_is_no_leap(late_s):
    bench = moving(50_000, 9000, 0.5)
    node = bench.node(1)
    hear, kept = node.hear, []

    def late(frame, now_s):
        said = hear(frame, now_s)
        if said and not kept and frame.data[0] == Code.ENCODER:
            kept.append(said)
            bench.at_s[now_s + late_s] = lambda: bench._answer(said)
            return []
        return said

    node.hear = late
    assert isinstance(bench.finish(), Done)
    assert kept
    assert not bench.alerts()
