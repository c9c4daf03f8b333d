"""A drive that restarts counts from zero: what shows a restart, and what must not be taken for one.

A count that no shaft can have reached shows it at once. Near zero, only the replies that never come
show it.
"""

from __future__ import annotations

import random
import re

import pytest
from amounts import amount, each_value
from can_fault_bench import check_recovery, fail_in_motion
from faults import arm_config, driven
from mks_bench import (
    BURSTS,
    FAR_FROM_ZERO,
    MksBench,
    along,
    begun,
    check_blamed,
    check_done,
    check_halted,
    requests,
    restart,
    segments,
    straight,
    total,
)

from armdrive.dialects.mks.drive import GIVE
from armdrive.status import Trust
from armdrive.tasks import AlertKind, Halted, MoveBy, RequestRejected
from firmware_protocol.mks import Code, MoveAbsoluteAxis
from kinematics import Joints, Motors

TOLD_S = 0.15
"""A look every 0.1 s, another one at once, and their answers."""
RUN_ON_S = 0.3
"""What is sent ahead, and a ramp."""
DEAD_S = 0.1
SLOWLY = (2500, 400, 0, 0, 0, 0)
ALONE = (300, 0, 0, 0, 0, 0)
BURST = MoveBy(Motors((30_000, 300, 0, 0, 0, 0)), 30_000.0)


def others_at_zero(start, **more) -> MksBench:
    """Return drives of which the first counts so much, and the others zero."""
    return MksBench(starts=(start, 0, 0, 0, 0, 0), **more).ready()


# -- far from zero: its count has leapt ------------------------------------------------------------


def moving(start, speed, after_s, turns=False):
    way = (speed, -speed // 2, 700, 0, 0, 0)
    back = tuple(-each for each in way)
    moves = segments(*([way] * 12 + [back] * 12 * turns))
    return begun(moves, after_s, starts=(start, 50_000, 50_000, 0, 0, 0))


@each_value(
    "start_speed, after_s, dead_s",
    [(9000, 9000), (-3000, 9000), (0, 3000), (20_000, 3000), (20_000, -3000), (60_000, 300)],
    [0.21, 0.47],
    [0.0, 0.05],
)
def test_a_short_restart_is_found_and_the_drive_goes_no_farther_than_sent(
    start_speed, after_s, dead_s
):
    start, speed = start_speed
    bench = moving(start, speed, after_s)
    began_s, stood = bench.now_s, bench.node(1).count
    shaft = restart(bench, 1, dead_s=dead_s)
    assert "reset" in check_blamed(bench).text
    bench.run(1.0)
    most = abs(speed) * 10 * (dead_s + TOLD_S + RUN_ON_S)
    assert abs(shaft() - stood) <= most
    assert bench.now_s - 1.0 < began_s + dead_s + 2.0


@each_value(
    "start, after_s, dead_s",
    [-20_000, 0, 20_000],
    [0.47, 0.49, 0.52],
    [0.1, 0.4],
)
def test_a_drive_that_restarts_gets_no_order_from_its_new_zero(start, after_s, dead_s):
    bench = moving(start, 9000, after_s)
    back_s = bench.now_s + dead_s
    restart(bench, 1, dead_s=dead_s)
    check_blamed(bench)
    assert not requests(bench, MoveAbsoluteAxis, since_s=back_s)  # nor does any other drive


def test_a_restarted_drive_that_keeps_its_angle_is_found_by_its_missing_turns():
    bench = moving(40_000, 3000, 0.47)
    restart(bench, 1, keeps_angle=True)
    check_blamed(bench)


def test_a_standing_drive_that_restarts_is_found():
    bench = begun(straight(12, (3000, 0, 0, 0, 0, 0)), 0.3, starts=(0, 0, 30_000, 0, 0, 0))
    restart(bench, 3)
    check_blamed(bench, "drive 3 (elbow)")


@pytest.mark.parametrize(("start", "after_s"), [(9000, 0.02), (-20_000, 0.2), (2 * GIVE, 0.5)])
def test_a_restart_in_a_burst_is_found(start, after_s):
    bench = others_at_zero(start, settings=BURSTS)
    bench.begin(MoveBy(Motors((30_000, -9000, 0, 0, 0, 0)), 30_000.0))
    bench.run(after_s)
    restart(bench, 1)
    assert check_blamed(bench).kind in (AlertKind.RESTARTED, AlertKind.OFF_PATH)


@each_value("after_s, start", [0.0, 0.02, 0.06], [9000, -13])
def test_a_restart_while_the_drives_brake_is_found(start, after_s):
    bench = moving(start, 9000, 0.5)
    bench.controller.stop(hard=False)
    bench._send()
    bench.run(after_s)
    restart(bench, 1)
    assert isinstance(bench.finish(), Halted)
    alert = bench.alerts()[0]
    assert alert.kind is AlertKind.RESTARTED
    assert "drive 1 (base) was reset or lost its power" in alert.text


@each_value("hard, after_s", [False, True], [0.05, 0.3, 0.9])
def test_drives_that_stop_as_they_should_raise_no_alert(hard, after_s):
    check_halted(begun(straight(10), after_s, starts=(-13, 0, 0, 0, 0, 0)), hard=hard)


@pytest.mark.parametrize("late_s", [0.05, 0.3])
def test_a_late_answer_is_no_restart(late_s):
    bench = moving(50_000, 9000, 0.5)
    kept = []

    def waits_s(frame, host):
        if host or kept or frame.can_id != 1 or frame.data[0] != Code.ENCODER:
            return 0.0
        kept.append(frame)
        return late_s

    bench.waits_s = waits_s
    check_done(bench)
    assert kept


# -- near zero: it counts near where it counted ----------------------------------------------------


def begins_anew(bench, number, after_s, dead_s=DEAD_S):
    """Have a drive lose its supply for a moment: mute and deaf, then holding, with a count of 0."""
    node = bench.node(number)
    bench.at_s[bench.now_s + after_s] = node.lose_power
    bench.at_s[bench.now_s + after_s + dead_s] = node.restore_power


def begin_anew(bench, drives, after_s, dead_s):
    """Have the supply of the first drives fail for a moment."""
    for number in range(1, drives + 1):
        begins_anew(bench, number, after_s + number * 1e-6, dead_s)


@each_value("start, after_s", [0, -2000, 900], [0.09, 0.15])
def test_a_steered_drive_that_was_gone_for_a_moment_near_zero_ends_the_motion(start, after_s):
    bench = others_at_zero(start)
    begins_anew(bench, 1, after_s)
    bench.begin(along(straight(20, SLOWLY)))
    check_blamed(bench, kind=AlertKind.RESTARTED)


@each_value("drives, after_s, dead_s, start", [1, 6], [0.1, 0.5], [0.15, 0.5], [-3000, 0, 60_000])
def test_drives_that_restarted_in_a_burst_do_not_get_their_order_again(
    drives, after_s, dead_s, start
):
    bench = others_at_zero(start, settings=BURSTS)
    begin_anew(bench, drives, after_s, dead_s)
    assert isinstance(bench.do(BURST), RequestRejected)
    if drives == 1:
        assert bench.alerts()[0].kind is AlertKind.RESTARTED
    assert len(requests(bench, MoveAbsoluteAxis, node=1)) == 1


AGAIN = [
    (-40_000, False, "can count the same"),
    (-40_000, True, "was reset"),
    (0, True, "was reset"),
    (200_000, False, ""),
    (200_000, True, "was reset"),
]


@pytest.mark.parametrize(("start", "restarts", "words"), AGAIN)
def test_a_drive_that_was_mute_for_long_is_called_reset_only_if_no_order_took_it_there(
    start, restarts, words
):
    bench = begun(straight(20), 0.5, starts=(start, 0, 0, 0, 0, 0))
    if restarts:
        restart(bench, 1, dead_s=0.5)
    else:
        bench.node(1).mute = True
        bench.at_s[bench.now_s + 0.5] = lambda: setattr(bench.node(1), "mute", False)
    reply = bench.finish()
    assert isinstance(reply, RequestRejected)
    if words:
        assert words in check_blamed(bench, kind=AlertKind.RESTARTED, reply=reply).text
    else:
        assert reply.silent
        assert "drive 1 (base) did not answer for a while" in reply.reason
        assert not bench.alerts()


@pytest.mark.parametrize("seed", range(amount(4, 8)))
@pytest.mark.parametrize(
    ("starts", "lost"), [((-9000, 60_000, 20_000, 0, 0, 0), 0.05), (FAR_FROM_ZERO, 0.1)]
)
def test_lost_frames_are_no_restart_and_lose_no_steps(seed, starts, lost):
    dice, moves = random.Random(seed), straight(10, (3000, 1500, -700, 0, 0, 0))
    bench = MksBench(starts=starts).ready()
    bench.loses = lambda _frame, _host: dice.random() < lost
    bench.begin(along(moves))
    check_done(bench)
    off = bench.positions - Motors(starts) - total(moves)
    assert off.largest <= bench.controller.settings.in_position_counts


@pytest.mark.parametrize("seed", range(amount(4, 8)))
def test_frames_that_are_lost_around_a_stop_are_no_restart(seed):
    dice = random.Random(seed)
    bench = others_at_zero(-300)
    bench.loses = lambda _frame, _host: dice.random() < 0.1
    bench.begin(along(straight(20, ALONE)))
    bench.run(0.11)
    check_halted(bench)


@pytest.mark.parametrize("start", [0, -2000, 900])
def test_a_drive_that_answers_when_it_is_asked_again_at_once_was_there(start):
    bench = others_at_zero(start)
    began_s = bench.now_s

    def lost(frame, _host):
        gone = began_s + 0.1 < bench.now_s < began_s + 0.21
        return gone and frame.can_id == 1 and frame.data[0] != Code.STATE

    bench.loses = lost
    bench.begin(along(straight(10, SLOWLY)))
    check_done(bench)


def slowed_in_motion(seed):
    """Return drives near zero in a rough motion, and on a link that has just become slow."""
    dice = random.Random(seed)
    speeds, start = (9000, -6000, 3000, -1000, 300, 0), dice.choice((-9000, -2000, 0, 300))
    ways = [tuple(dice.choice(speeds) for _ in range(6)) for _ in range(4)]
    moves = segments(*(way for way in ways for _ in range(6)))
    bench = begun(moves, dice.uniform(0.05, 1.8), starts=(start,) * 6)
    late_s, late_host = dice.uniform(0.06, 0.09), dice.random() < 0.5
    bench.waits_s = lambda _frame, host: late_s if host is late_host else 0.0
    return bench


@pytest.mark.parametrize("seed", [14, 17, 24, 37])
def test_a_link_that_becomes_slow_in_motion_is_no_restart(seed):
    """Every drive owes its latest replies from then on, but answers those that it owed."""
    check_done(slowed_in_motion(seed))


def test_a_restart_on_a_link_that_has_become_slow_is_found():
    """Its drives are suspected again and again, and acquitted; then one falls silent for longer."""
    ways = [
        (700, 700, 300, 0, -700, 20),
        (0, 20, 0, 300, 300, 100),
        (-700, 100, 700, 100, 20, -700),
    ]
    bench = MksBench(starts=(-300,) * 6).ready()
    bench.begin(along(segments(*(way for way in ways for _ in range(8)))))
    bench.run(0.3)
    bench.waits_s = lambda _frame, host: 0.0 if host else 0.07
    begins_anew(bench, 6, 1.055, 0.25)
    check_blamed(bench, "drive 6 (gripper)", AlertKind.RESTARTED)


def test_a_shaft_that_slips_a_little_near_zero_is_no_restart():
    bench = others_at_zero(17, settings=BURSTS)
    bench.at_s[bench.now_s + 0.004] = lambda: bench.node(1).load(-12)
    bench.at_s[bench.now_s + 0.05] = lambda: bench.node(1).load(0)
    bench.begin(MoveBy(Motors((2, 0, 3000, 0, 0, 0)), 9_000.0))
    check_done(bench)


@each_value("start, slow, after_s", [0, -900], [60, 150], [0.16, 0.22])
def test_a_restart_of_a_fast_drive_that_is_slow_afterwards_is_found(start, slow, after_s):
    bench = others_at_zero(start)
    fast, later = (700, 300, 0, 0, 0, 0), (slow, slow, 0, 0, 0, 0)
    begins_anew(bench, 1, after_s)
    began_s = bench.now_s
    bench.loses = lambda frame, host: (  # it is not looked at until it is slow
        not host and frame.data[0] == Code.ENCODER and 0.3 < bench.now_s - began_s < 0.68
    )
    bench.begin(along(segments(*([fast] * 5 + [later] * 8))))
    check_blamed(bench, kind=AlertKind.RESTARTED)


@each_value("start, after_s, dead_s", [0, -300], [0.36, 0.4], [0.06, 0.1])
def test_two_drives_that_restart_together_as_they_arrive_are_told_from_a_silent_bus(
    start, after_s, dead_s
):
    """A drive that stands is asked along with them, and answers."""
    bench = MksBench(starts=(0, 0, 0, start, start, 0)).ready()
    began_s = bench.now_s
    begins_anew(bench, 4, after_s, dead_s)
    begins_anew(bench, 5, after_s + 1e-6, dead_s)
    bench.begin(along(straight(4, (0, 0, 0, 300, -300, 0))))
    alert = check_blamed(bench, "drive 4 (right wrist) was reset or lost its power")
    assert alert.kind is AlertKind.RESTARTED
    assert bench.now_s < began_s + after_s + dead_s + 0.2


def check_restart_found(bench, *, hard=False):
    """Stop the motion; check that the first drive, and no other, is reported to have restarted."""
    bench.controller.stop(hard=hard)
    assert isinstance(bench.finish(), Halted)
    (alert,) = bench.alerts()
    assert alert.kind is AlertKind.RESTARTED
    assert "drive 1 (base)" in alert.text


@each_value("hard, start, stop_s, dead_s", [False, True], [4, -450], [0.0, 0.02], [0.1, 0.5])
def test_a_restart_around_a_stop_of_a_drive_that_moves_alone_is_found(hard, start, stop_s, dead_s):
    bench = others_at_zero(start)
    begins_anew(bench, 1, 0.11, dead_s)
    bench.begin(along(straight(20, ALONE)))
    bench.run(0.11 + stop_s)
    check_restart_found(bench, hard=hard)


@pytest.mark.parametrize(("speed", "dead_s"), [(100, 0.3), (100, 0.6), (1000, 0.5)])
def test_a_restart_near_zero_just_before_a_stop_is_found(speed, dead_s):
    bench = begun(straight(30, (speed, 3000, 0, 0, 0, 0)), 0.5, starts=(0, 50_000, 0, 0, 0, 0))
    restart(bench, 1, dead_s=dead_s)
    bench.run(0.2)
    check_restart_found(bench)


@pytest.mark.parametrize("stop_s", [0.0, 0.02])
def test_a_restart_of_all_drives_as_they_are_stopped_is_found(stop_s):
    bench = MksBench(starts=(4, -450, 0, 0, 0, 0)).ready()
    begin_anew(bench, 6, 0.2, 0.3)
    bench.begin(along(straight(20, (300, 300, 0, 0, 0, 0))))
    bench.run(0.2 + stop_s)
    bench.controller.stop(hard=False)
    assert isinstance(bench.finish(), Halted)
    assert {alert.kind for alert in bench.alerts()} == {AlertKind.RESTARTED}
    assert len(bench.alerts()) == 2


@each_value("start, after_s, dead_s", [4, -450], [-0.02, 0.005, 0.02], [0.08, 0.1, 0.14])
def test_a_short_power_cut_while_all_drives_brake_near_zero_is_found(start, after_s, dead_s):
    """Since none of them stands, none shows that the bus still works."""
    bench = MksBench(starts=(start,) * 6).ready()
    begin_anew(bench, 6, 0.2 + after_s, dead_s)
    bench.begin(along(straight(20, (300,) * 6)))
    bench.run(0.2)
    bench.controller.stop(hard=False)
    assert isinstance(bench.finish(), Halted)
    assert {alert.kind for alert in bench.alerts()} == {AlertKind.RESTARTED}
    assert len(bench.alerts()) == 6


@pytest.mark.parametrize("for_s", [0.05, 0.1, 0.3])
def test_an_outage_after_a_stop_near_zero_blames_no_drive(for_s):
    bench = others_at_zero(-300)
    bench.begin(along(straight(20, ALONE)))
    bench.run(0.11)
    bench.controller.stop(hard=False)
    bench.delay_frames(for_s)
    assert isinstance(bench.finish(), Halted)
    assert not bench.alerts()


# -- a whole arm ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("fault", "base_deg"),
    [("brown-out", -3.0), ("reset", 0.5)],
)
def test_all_drives_that_lose_their_power_near_zero_are_found_out(fault, base_deg):
    arm = driven(arm_config("mks"), at=Joints.of(base_deg, 0.0, 0.0, 0.0, 0.0))
    said, _ = fail_in_motion(arm, fault, {"base_deg": 40})
    assert re.search("reset|power|switched", said), said
    assert arm.status.trust is Trust.SUSPECT
    check_recovery(arm)


@pytest.mark.parametrize(
    ("drive", "goal"),
    [(1, {"shoulder_deg": 60}), (6, {"base_deg": 60})],
)
def test_a_drive_that_does_not_move_and_is_reset_meanwhile_is_named(drive, goal):
    """Its firmware keeps the angle within a turn, so that it does not count from zero."""
    arm = driven(arm_config("mks"), at=Joints.of(30.0, 40.0, -80.0, -40.0, 0.0), keeps_angle=True)
    said, _ = fail_in_motion(arm, f"drive-reset {drive}", goal)
    assert f"drive {drive} (" in said
    assert "reset" in said
    assert arm.status.trust is Trust.SUSPECT
    check_recovery(arm)
