"""A drive seen off its way: who was only late comes nearer and is not blamed; who is blocked is."""

from __future__ import annotations

import pytest
from mks_bench import BOTH, ORDERS, begun, hold_up, segments

from armdrive.dialects.bus import observer
from armdrive.dialects.bus.ledger import LOOK_S
from armdrive.dialects.mks.settings import MksSettings
from armdrive.tasks import AlertKind, Done, RequestRejected
from kinematics import Motors

SHORT_AHEAD_S = 0.06
"""So little that a drive whose orders are late stands before they come."""
STALL_S = 0.05
"""Shorter than what is noticed as a bus that stands still."""
FAST, SLOW = (9000, -3000, 0, 0, 0, 0), (300, -100, 0, 0, 0, 0)
LATE_S = 0.005
"""So long at most does an answer take on this bus."""


def moving(moves, after_s, ahead_s=SHORT_AHEAD_S, **settings):
    return begun(moves, after_s, ahead_s, segment_s=0.02, **settings)


def block(bench, number):
    """Have a shaft stand where it is, whatever its drive is told."""
    bench.node(number).block(bench.now_s)


@pytest.mark.parametrize("tail", [0, 1, 6])
@pytest.mark.parametrize("after_s", [0.48, 0.49, 0.5, 0.51, 0.52])
@pytest.mark.parametrize("sides", [BOTH, ORDERS])
def test_a_drive_that_was_late_before_its_slow_end_is_not_called_blocked(sides, after_s, tail):
    bench = moving(segments(*([FAST] * 6 + [SLOW] * tail)), after_s)
    hold_up(bench, STALL_S, sides)
    reply = bench.finish()
    assert isinstance(reply, Done), str(reply)
    assert not bench.alerts()
    assert bench.positions == Motors(
        50_000 + 6 * fast + tail * slow for fast, slow in zip(FAST, SLOW, strict=True)
    )


def run_until_told(bench):
    """Let time pass until something has alarmed."""
    while not bench.alerts():
        bench.run(0.001)
        bench.reply()


def hold_back(bench, number, for_s):
    """Have a shaft stand for a moment; then it springs to where its drive wants it."""
    block(bench, number)
    bench.at_s[bench.now_s + for_s] = bench.node(number).free


@pytest.mark.parametrize(
    ("speed", "for_s", "poll_s"),
    [
        (3000, 0.1, 0.02),
        (3000, 0.15, 0.2),
        (9000, 0.11, 0.02),
        (9000, 0.15, 0.1),
        (9000, 0.15, 0.2),
    ],
)
def test_one_that_is_behind_and_goes_on_is_waited_for(speed, for_s, poll_s):
    way = (speed, -speed // 3, 0, 0, 0, 0)
    bench = moving(segments(*([way] * 20)), 0.5, 0.3, poll_s=poll_s)
    hold_back(bench, 1, for_s)
    reply = bench.finish()
    assert isinstance(reply, Done), str(reply)
    assert not bench.alerts()
    assert bench.positions == Motors(50_000 + 20 * each for each in way)


@pytest.mark.parametrize("after_s", [0.3, 0.33, 0.36, 0.4])
@pytest.mark.parametrize("poll_s", [0.02, 0.03, 0.1, 0.2])
@pytest.mark.parametrize("counts_s", [9000, 30_000, 90_000])
def test_a_blocked_shaft_is_told_within_the_documented_time(counts_s, poll_s, after_s):
    way = (counts_s // 10, 0, 0, 0, 0, 0)
    bench = moving(segments(*([way] * 40)), after_s, 0.3, poll_s=poll_s)
    block(bench, 1)
    began_s = bench.now_s
    run_until_told(bench)
    (alert,) = bench.alerts()
    assert alert.kind is AlertKind.ASTRAY
    assert "drive 1 (base)" in alert.text
    behind_s = MksSettings().corridor_counts / counts_s + observer.MAX_DELAY_S
    assert bench.now_s - began_s <= behind_s + 2.0 * poll_s + LOOK_S + 4.0 * LATE_S


def test_a_blocked_shaft_is_told_where_its_motor_has_come_back_halfway_to_it():
    there, back = (9000, 0, 0, 0, 0, 0), (-3000, 0, 0, 0, 0, 0)
    bench = moving(segments(*([there] * 5 + [back] * 10)), 0.2, 0.3)
    block(bench, 1)
    run_until_told(bench)
    assert bench.now_s < 1.0
    assert isinstance(bench.finish(), RequestRejected)


@pytest.mark.parametrize("counts", [-60_000, 60_000])
def test_a_drive_that_keeps_its_distance_and_is_far_off_is_told_of(counts):
    bench = moving(segments(*([FAST] * 20)), 0.5, 0.3)
    began_s = bench.now_s
    bench.node(1).hang(counts)
    run_until_told(bench)
    assert "drive 1 (base)" in bench.alerts()[0].text
    assert bench.now_s < began_s + 0.3
