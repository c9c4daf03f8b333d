"""A drive that begins anew for a moment counts near where it counted: what shows it anyway."""

from __future__ import annotations

import random

import pytest
from mks_bench import BURSTS, MksBench, along, hold_up, segments, straight, suspend

from armdrive.tasks import AlertKind, Done, Halted, MoveBy, RequestRejected
from firmware_protocol.mks import Code
from kinematics import Motors

DEAD_S = 0.1


def begins_anew(bench, number, after_s, dead_s=DEAD_S):
    """Have a drive lose its supply for a moment: mute and deaf, then holding, with a count of 0."""
    node = bench.node(number)

    bench.at_s[bench.now_s + after_s] = lambda: node.lose_power(bench.now_s)
    bench.at_s[bench.now_s + after_s + dead_s] = lambda: node.find_power(bench.now_s)


@pytest.mark.parametrize("start", [0, -2000, 900])
@pytest.mark.parametrize("after_s", [0.09, 0.12, 0.15, 0.17])
def test_a_steered_drive_that_was_gone_for_a_moment_near_zero_ends_the_motion(start, after_s):
    bench = MksBench(starts=(start, 0, 0, 0, 0, 0)).ready()
    begins_anew(bench, 1, after_s)
    assert isinstance(bench.do(along(straight(20, (2500, 400, 0, 0, 0, 0)))), RequestRejected)
    (alert,) = bench.alerts()
    assert alert.kind is AlertKind.RESTARTED
    assert "drive 1 (base)" in alert.text


@pytest.mark.parametrize("after_s", [0.1, 0.2, 0.4, 0.6])
@pytest.mark.parametrize("start", [-3000, 60_000])
def test_a_drive_that_began_anew_in_a_burst_is_not_sent_the_whole_way_again(start, after_s):
    bench = MksBench(settings=BURSTS, starts=(start, 0, 0, 0, 0, 0)).ready()
    begins_anew(bench, 1, after_s, 0.15)
    burst = MoveBy(Motors((30_000, 300, 0, 0, 0, 0)), 30_000.0)
    assert isinstance(bench.do(burst), RequestRejected)
    assert bench.alerts()[0].kind is AlertKind.RESTARTED
    sent = [order for at_s, order in bench.node(1).orders if at_s > 0.0]
    assert len(sent) == 1


@pytest.mark.parametrize("seed", range(8))
def test_lost_frames_are_no_drive_that_began_anew(seed):
    bench = MksBench(starts=(-9000, 60_000, 20_000, 0, 0, 0)).ready()
    dice = random.Random(seed)
    bench.loses = lambda _frame, _host: dice.random() < 0.05
    assert isinstance(bench.do(along(straight(10, (3000, 1500, -700, 0, 0, 0)))), Done)
    assert not bench.alerts()


@pytest.mark.parametrize("start", [0, -2000, 900])
def test_a_drive_that_answers_when_it_is_asked_again_at_once_was_there(start):
    bench = MksBench(starts=(start, 0, 0, 0, 0, 0)).ready()
    began_s = bench.now_s

    def lost(frame, _host):
        gone = began_s + 0.1 < bench.now_s < began_s + 0.21
        return gone and frame.can_id == 1 and frame.data[0] != Code.STATE

    bench.loses = lost
    assert isinstance(bench.do(along(straight(10, (2500, 400, 0, 0, 0, 0)))), Done)
    assert not bench.alerts()


@pytest.mark.parametrize("for_s", [0.1, 0.15, 0.3])
def test_a_program_that_wakes_late_near_zero_blames_no_drive(for_s):
    bench = MksBench(starts=(-2000, 0, 0, 0, 0, 0)).ready()
    bench.begin(along(straight(20, (2500, 400, 0, 0, 0, 0))))
    bench.run(0.12)
    suspend(bench, for_s)
    assert isinstance(bench.finish(), Done)
    assert not bench.alerts()


def test_a_drive_that_slips_a_little_beside_zero_has_not_begun_anew():
    bench = MksBench(settings=BURSTS, starts=(17, 0, 0, 0, 0, 0)).ready()
    bench.at_s[bench.now_s + 0.004] = lambda: setattr(bench.node(1), "slipped", -12)
    bench.at_s[bench.now_s + 0.05] = lambda: setattr(bench.node(1), "slipped", 0)
    assert isinstance(bench.do(MoveBy(Motors((2, 0, 3000, 0, 0, 0)), 9_000.0)), Done)
    assert not bench.alerts()


@pytest.mark.parametrize("after_s", [0.1, 0.3, 0.5])
@pytest.mark.parametrize("dead_s", [0.15, 0.5])
@pytest.mark.parametrize("start", [0, -3000])
def test_drives_that_all_began_anew_in_a_burst_are_not_sent_the_whole_way_again(
    start, dead_s, after_s
):
    bench = MksBench(settings=BURSTS, starts=(start, 0, 0, 0, 0, 0)).ready()
    for number in range(1, 7):
        begins_anew(bench, number, after_s + number * 1e-6, dead_s)
    burst = MoveBy(Motors((30_000, 300, 0, 0, 0, 0)), 30_000.0)
    assert isinstance(bench.do(burst), RequestRejected)
    sent = [order for at_s, order in bench.node(1).orders if at_s > 0.0]
    assert len(sent) == 1


@pytest.mark.parametrize("after_s", [0.16, 0.19, 0.22, 0.25])
@pytest.mark.parametrize("slow", [60, 150])
@pytest.mark.parametrize("start", [0, -900])
def test_one_that_began_anew_while_it_was_fast_is_found_though_it_is_slow_since(
    start, slow, after_s
):
    bench = MksBench(starts=(start, 0, 0, 0, 0, 0)).ready()
    fast, later = (700, 300, 0, 0, 0, 0), (slow, slow, 0, 0, 0, 0)
    begins_anew(bench, 1, after_s)
    began_s = bench.now_s
    bench.loses = lambda frame, host: (  # it is not looked at until it is slow
        not host and frame.data[0] == Code.ENCODER and 0.3 < bench.now_s - began_s < 0.68
    )
    assert isinstance(bench.do(along(segments(*([fast] * 5 + [later] * 8)))), RequestRejected)
    (alert,) = bench.alerts()
    assert alert.kind is AlertKind.RESTARTED
    assert "drive 1 (base)" in alert.text


@pytest.mark.parametrize("dead_s", [0.1, 0.5])
@pytest.mark.parametrize("stop_s", [0.0, 0.02])
@pytest.mark.parametrize("start", [4, -450])
@pytest.mark.parametrize("hard", [False, True])
def test_one_that_moves_alone_and_begins_anew_around_a_stop_is_found(hard, start, stop_s, dead_s):
    bench = MksBench(starts=(start, 0, 0, 0, 0, 0)).ready()
    begins_anew(bench, 1, 0.11, dead_s)
    bench.begin(along(straight(20, (300, 0, 0, 0, 0, 0))))
    bench.run(0.11 + stop_s)
    bench.controller.stop(hard=hard)
    assert isinstance(bench.finish(), Halted)
    (alert,) = bench.alerts()
    assert alert.kind is AlertKind.RESTARTED
    assert "drive 1 (base)" in alert.text


@pytest.mark.parametrize("stop_s", [0.0, 0.02])
def test_drives_that_all_began_anew_as_they_were_stopped_are_found(stop_s):
    bench = MksBench(starts=(4, -450, 0, 0, 0, 0)).ready()
    for number in range(1, 7):
        begins_anew(bench, number, 0.2 + number * 1e-6, 0.3)
    bench.begin(along(straight(20, (300, 300, 0, 0, 0, 0))))
    bench.run(0.2 + stop_s)
    bench.controller.stop(hard=False)
    assert isinstance(bench.finish(), Halted)
    assert {alert.kind for alert in bench.alerts()} == {AlertKind.RESTARTED}
    assert len(bench.alerts()) == 2


@pytest.mark.parametrize("seed", range(8))
def test_lost_frames_behind_a_stop_are_no_drive_that_began_anew(seed):
    bench = MksBench(starts=(-300, 0, 0, 0, 0, 0)).ready()
    dice = random.Random(seed)
    bench.loses = lambda _frame, _host: dice.random() < 0.1
    bench.begin(along(straight(20, (300, 0, 0, 0, 0, 0))))
    bench.run(0.11)
    bench.controller.stop(hard=False)
    assert isinstance(bench.finish(), Halted)
    assert not bench.alerts()


@pytest.mark.parametrize("for_s", [0.05, 0.1, 0.3])
def test_a_bus_that_stands_still_behind_a_stop_near_zero_blames_no_drive(for_s):
    bench = MksBench(starts=(-300, 0, 0, 0, 0, 0)).ready()
    bench.begin(along(straight(20, (300, 0, 0, 0, 0, 0))))
    bench.run(0.11)
    bench.controller.stop(hard=False)
    hold_up(bench, for_s)
    assert isinstance(bench.finish(), Halted)
    assert not bench.alerts()
