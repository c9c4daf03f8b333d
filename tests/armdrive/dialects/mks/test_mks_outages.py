"""A bus outage of some tenths of a second in motion blames no drive, and the motion continues."""

from __future__ import annotations

import re

import pytest
from amounts import each_value
from driver_bench import ANSWERS, BOTH, ORDERS
from mks_bench import (
    AHEAD_S,
    BURSTS,
    FAR_FROM_ZERO,
    WAY,
    MksBench,
    along,
    begun,
    check_blamed,
    check_done,
    check_halted,
    off_path,
    segments,
    straight,
    total,
)
from test_mks_arm import ready

from armdrive.arm import moving
from armdrive.status import State, Trust
from armdrive.tasks import AlertKind, Done, Halted, MoveAlong, MoveBy, RequestRejected, Timeout
from kinematics import Motors

AFTER_S = [0.0, 0.31, 0.9]
ALL_SIDES = [BOTH, ORDERS, ANSWERS]


AS_IT_COMES_BACK = [(1.4, 0.9, ORDERS), (1.4, 0.95, BOTH), (1.4, 1.0, BOTH)]
"""Outages that end while the drives are asked for their positions: some answer, others do not."""


@pytest.mark.parametrize(("for_s", "after_s", "sides"), AS_IT_COMES_BACK)
def test_a_bus_that_comes_back_blames_no_drive(for_s, after_s, sides):
    check_blames_no_drive(for_s, after_s, sides)


@each_value("for_s, after_s, sides", [1.4, 2.5], AFTER_S, ALL_SIDES)
def test_a_long_outage_ends_the_motion_and_blames_no_drive(for_s, after_s, sides):
    check_blames_no_drive(for_s, after_s, sides)


def check_blames_no_drive(for_s, after_s, sides):
    bench = begun(straight(10), after_s)
    bench.delay_frames(for_s, sides)
    reply = bench.finish()
    assert isinstance(reply, Timeout) or (reply.silent and "no drive answered" in reply.reason)
    assert not bench.alerts()
    bench.run(for_s)
    bench.check_stands()


@pytest.mark.parametrize("sides", [BOTH, ORDERS])
def test_no_target_is_sent_during_an_outage(sides):
    """Nor while drives only say that they have come to their last targets, as all of them do."""
    bench = begun(straight(20, (6000, -3000, 1500, 600, 700, 300)), 0.5)
    bench.delay_frames(0.8, sides)
    began_s = bench.now_s
    bench.run(0.8)
    orders = [at_s for at_s, frame in bench.sent if frame.data[0] == 0xF5]
    assert max(orders) < began_s + 0.2
    assert any(at_s > began_s + 0.4 for at_s, frame in bench.sent if frame.data[0] == 0x31)


CORNER = segments(*([(6000, 3000, 0, 0, 0, 0)] * 8 + [(-6000, 3000, 0, 0, 0, 0)] * 8))


@each_value("after_s, for_s, sides", [0.55, 0.7], [0.2, 0.7], ALL_SIDES)
def test_the_motion_continues_from_where_the_drives_are_and_cuts_no_corner(after_s, for_s, sides):
    bench = begun(CORNER, after_s)
    corners, at = [(0.0, Motors(FAR_FROM_ZERO))], Motors(FAR_FROM_ZERO)
    for number, move in enumerate(CORNER):
        at = at + move.steps
        corners.append(((number + 1) * 0.1, at))
    bench.delay_frames(for_s, sides)
    worst = 0.0
    while bench.controller.busy:
        bench.run(0.04)
        looks = (off_path(corners, step * 0.04, bench.positions) for step in range(41))
        worst = max(worst, min(looks))
    assert isinstance(bench.finish(), Done)
    assert bench.positions == at
    assert worst < 5000  # of 48000 each way: a drive waits at the corner while the other goes on


def test_a_stop_during_an_outage_ends_the_motion():
    bench = begun(straight(20), 0.5)
    bench.delay_frames(0.5)
    bench.run(0.3)
    check_halted(bench)


def test_a_drive_that_is_blocked_during_an_outage_is_found():
    bench = begun(straight(20), 0.3)
    bench.delay_frames(0.4)
    bench.node(3).block()
    check_blamed(bench, "drive 3 (elbow)")
    assert bench.now_s < 2.5


@each_value("start, dead_s, after_s", [50_000, -2000, 0], [0.15, 0.7], [0.1, 0.55])
def test_a_supply_of_all_drives_that_fails_for_a_moment_is_no_outage(after_s, dead_s, start):
    way = (6000, 3000, 1500, 0, 700, 20) if abs(start) > 2000 else (2500, 400, 0, 0, 0, 0)
    bench = MksBench(starts=(start,) * 6).ready()
    bench.begin(along(straight(20, way)))
    bench.run(after_s)
    for node in bench.nodes:
        node.lose_power()
    bench.run(dead_s)
    for node in bench.nodes:
        node.restore_power()
    assert isinstance(bench.finish(), RequestRejected)
    assert bench.alerts()[0].kind is AlertKind.RESTARTED
    bench.run(2.0)
    assert bench.positions.largest < 4500


# -- a bus that is always slow ---------------------------------------------------------------------

WELL, TOO_SLOW = "done", "the bus is too slow for this arm: answers take more than 0.1 s"
EITHER = f"{WELL}|{TOO_SLOW}"
LATE_ANSWERS = [
    (0.065, 0.0, {}, WELL),
    (0.09, 0.5, {"segment_s": 0.1}, WELL),
    (0.09, 0.0, BURSTS, WELL),
    (0.12, 0.5, {"poll_s": 0.2}, EITHER),
    (0.12, 0.0, {}, EITHER),
    (0.25, 0.5, BURSTS, TOO_SLOW),
    (0.25, 0.0, {"segment_s": 0.1}, TOO_SLOW),
    (0.8, 0.0, {"poll_s": 0.2}, "too slow|answer|did not store its order"),
    (0.8, 0.5, {}, "too slow|answer|did not store its order"),
]
"""How late every answer comes, from when on, and how the motion ends."""


@pytest.mark.parametrize(("late_s", "after_s", "settings", "words"), LATE_ANSWERS)
def test_a_motion_on_a_bus_that_is_always_slow_ends_by_itself_and_blames_no_drive(
    late_s, after_s, settings, words
):
    moves, start = straight(12), Motors((500_000,) * 6)
    bench = MksBench(starts=tuple(start), settings=settings).ready()
    bench.begin(MoveBy(total(moves), 60_000.0) if settings == BURSTS else along(moves))
    bench.run(after_s)
    bench.waits_s = lambda _frame, host: 0.0 if host else late_s
    reply = bench.finish(12.0)
    assert re.search(words, str(reply)), str(reply)
    assert not bench.alerts()
    if words == WELL:
        assert (bench.positions - start - total(moves)).largest <= 8
    bench.check_stands(1.0)


TO_AND_FRO = segments(*([(5000, -4000, 300, 0, 700, 40)] * 4 + [(-5000, 4000, -300, 0, 0, 0)] * 4))


@each_value("late_s, late_host, start", [0.055, 0.08], [True, False], [-2000, 0, 300])
def test_near_zero_a_link_that_is_slow_from_the_beginning_blames_no_drive(late_s, late_host, start):
    """Where a drive that had no power would count the same, and always owes a reply."""
    bench = MksBench(starts=(start,) * 6)
    bench.waits_s = lambda _frame, host: late_s if host is late_host else 0.0
    bench.ready().begin(along(TO_AND_FRO))
    check_done(bench)


# -- a pause in a hold-up --------------------------------------------------------------------------


def paused_in_a_hold_up(sides, *, for_s=0.5, after_s=0.3):
    """Return a bench whose motion is paused while its bus stands still, and who resumes it."""
    paused = [False]
    bench = MksBench(starts=FAR_FROM_ZERO).ready()
    bench.begin(MoveAlong(iter(straight(10)), AHEAD_S, held_back=lambda: paused[0]))
    bench.run(0.5)
    bench.delay_frames(for_s, sides)
    bench.run(after_s)
    paused[0] = True
    bench.run(for_s - after_s + AHEAD_S + 0.3)  # orders that were held up are obeyed now
    return bench, paused


@each_value("sides, after_s", ALL_SIDES, [0.15, 0.45])
def test_an_arm_that_is_paused_during_an_outage_stands_until_it_resumes(sides, after_s):
    bench, paused = paused_in_a_hold_up(sides, after_s=after_s)
    bench.check_stands()
    assert bench.controller.busy
    paused[0] = False
    check_done(bench)
    assert (bench.positions - Motors(50_000 + 10 * each for each in WAY)).largest <= 8


def test_nothing_moves_during_a_pause_if_only_replies_were_late():
    bench, _ = paused_in_a_hold_up(ANSWERS, for_s=0.8, after_s=0.5)
    orders = [at_s for at_s, frame in bench.sent if frame.data[0] == 0xF5]
    assert max(orders) < bench.now_s - 0.8


def test_a_drive_that_is_turned_in_such_a_pause_ends_the_motion():
    bench, _ = paused_in_a_hold_up(ANSWERS)
    bench.node(2).load(300)
    check_blamed(bench, "drive 2 (shoulder)")


def test_a_stop_in_such_a_pause_ends_the_motion_and_nothing_moves():
    bench, _ = paused_in_a_hold_up(ANSWERS)
    stood = bench.positions
    bench.controller.stop(hard=False)
    assert isinstance(bench.finish(), Halted)
    assert bench.positions == stood
    assert not bench.alerts()


def test_a_bus_that_falls_silent_in_such_a_pause_is_reported():
    bench, _ = paused_in_a_hold_up(ANSWERS)
    bench.loses = lambda *_: True
    assert isinstance(bench.finish(), Timeout)


# -- a whole arm ----------------------------------------------------------------------------------

PAUSED_S = 20.0
"""Longer than the call waits for its motion if nothing pauses it, and its patience is short."""


def arm_paused_in_a_hold_up(for_s):
    """Return an arm whose next motion meets late answers after 0.4 s, and a pause after 0.7 s."""
    arm = ready()
    device, began_s = arm.twin.device, arm.parts.pace.now_s()
    device.at(began_s + 0.4, lambda: arm.twin.faults.add("delay", 1.0, "next", side="device"))
    device.at(began_s + 0.7, arm.pause)
    device.at(began_s + 0.7 + for_s, arm.resume)
    return arm


def test_the_call_waits_for_as_long_as_the_arm_is_paused(monkeypatch):
    monkeypatch.setattr(moving, "PATIENCE_S", 3.0)
    arm = arm_paused_in_a_hold_up(PAUSED_S)
    arm.move_j(base_deg=30)
    assert arm.parts.pace.now_s() > PAUSED_S
    assert arm.status.trust is Trust.REFERENCED
    assert arm.twin.world.motors == arm.status.acknowledged


def test_the_arm_says_that_it_is_paused_and_stands():
    arm = arm_paused_in_a_hold_up(PAUSED_S)
    motion = arm.move_j(base_deg=30, wait=False)
    arm.sleep(1.5)
    stood = arm.twin.world.motors
    assert arm.status.paused
    assert arm.status.state is State.MOVING
    arm.sleep(5.0)
    assert arm.twin.world.motors == stood
    arm.stop()
    assert motion.done
    assert arm.twin.world.motors == stood
    assert arm.status.trust is Trust.REFERENCED
