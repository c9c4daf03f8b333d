"""A stop that one drive did not hear, and a host that dies: the whole arm stands as announced."""

from __future__ import annotations

import pytest
from amounts import each_value
from driver_bench import ANSWERS
from mks_bench import AHEAD_S, MksBench, along, begun, check_halted, requests, segments, straight

from armdrive.dialects.mks.stops import STOP_POLL_S
from firmware_protocol.mks import Code, EmergencyStop, MoveAbsoluteAxis, Stop, decode_request

# -- A stop is told again at once, since others brake already --------------------------------------

WAY = (0, 0, 0, 3000, -3000, 0)
"""Counts in 0.1 s, of the two motors of a wrist."""
SOON_S = 0.005


def stops_of(bench, number):
    """Return when one drive was told to stop."""
    return [at_s for at_s, *_ in requests(bench, Stop, EmergencyStop, node=number)]


def wrist_in_motion():
    return begun(straight(12, WAY), 0.8)


def is_order(frame):
    """Return whether a frame of the host is an order to move."""
    return isinstance(decode_request(frame), MoveAbsoluteAxis)


def is_stop(frame):
    """Return whether a frame of the host is a stop."""
    return isinstance(decode_request(frame), Stop | EmergencyStop)


@each_value("hard, number", [False, True], [4, 5])
def test_the_other_motor_of_a_joint_is_not_left_running(number, hard):
    lost = []

    def loses(frame, host):
        strikes = host and frame.can_id == number and is_stop(frame) and not lost
        lost.extend([frame] if strikes else [])
        return strikes

    bench = wrist_in_motion()
    bench.loses = loses
    check_halted(bench, hard=hard)
    first_s, second_s = stops_of(bench, number)
    assert second_s <= first_s + SOON_S
    apart = bench.positions[3] - 50_000 + bench.positions[4] - 50_000
    assert abs(apart) <= 30_000 * SOON_S


@pytest.mark.parametrize("hard", [False, True])
def test_drives_that_brake_get_the_stop_once(hard):
    bench = wrist_in_motion()
    check_halted(bench, hard=hard)
    assert [len(stops_of(bench, number)) for number in (4, 5)] == [1, 1]


@pytest.mark.parametrize("hard", [False, True])
@pytest.mark.parametrize(
    ("lost_s", "of_host"),
    [(0.01, True), (0.055, True), (0.105, True), (0.3, False)],
    ids=["0.01 s of orders", "0.055 s of orders", "0.105 s of orders", "first stop, then answers"],
)
def test_a_stop_is_repeated_until_the_drive_answers(lost_s, of_host, hard):
    bench, lost = wrist_in_motion(), []
    until_s = bench.now_s + lost_s

    def loses(frame, host):
        if frame.can_id != 4 or bench.now_s >= until_s:
            return False
        if of_host or not host:
            return host is of_host
        strikes = is_stop(frame) and not lost
        lost.extend([frame] if strikes else [])
        return strikes

    bench.loses = loses
    check_halted(bench, hard=hard)
    unheard_until_s = until_s if of_host else stops_of(bench, 4)[0] + 1e-9
    heard_s = next(at_s for at_s in stops_of(bench, 4) if at_s >= unheard_until_s)
    assert heard_s <= unheard_until_s + STOP_POLL_S + SOON_S
    # the other one has said that it brakes, and is told no more
    assert len([at_s for at_s in stops_of(bench, 5) if at_s < until_s]) == 1


@pytest.mark.parametrize("later_s", [0.002, 0.005, 0.012])
def test_a_drive_that_gets_its_last_order_after_the_stop_is_stopped_again(later_s):
    """Mission mks 690000069: the stop had overtaken the order, and the drive had said it brakes."""
    bench = wrist_in_motion()
    orders = [frame for _, frame in bench.sent if frame.can_id == 4 and is_order(frame)]
    stopped_s = bench.now_s
    bench.at_s[stopped_s + later_s] = lambda: bench.node(4).receive(orders[-1])
    check_halted(bench)
    first_s, again_s, *_ = stops_of(bench, 4)
    assert first_s < stopped_s + later_s
    assert again_s <= stopped_s + later_s + STOP_POLL_S + SOON_S
    assert len(stops_of(bench, 5)) == 1


@pytest.mark.parametrize("silent_s", [0.06, 0.1, 0.15])
def test_a_late_drive_in_a_stop_near_zero_is_no_restart(silent_s):
    bench = MksBench(starts=(0, 50_000, 0, 0, 0, 0)).ready()
    bench.begin(along(straight(30, (1000, 3000, 0, 0, 0, 0))))
    bench.run(0.5)
    bench.delay_frames(silent_s, ANSWERS, node=1)
    bench.run(0.02)
    check_halted(bench)


def test_the_stop_because_of_a_silent_drive_is_repeated_to_one_that_missed_it():
    bench, lost = begun(straight(30), 0.5, ahead_s=1.0), list[float]()
    bench.node(3).mute = True

    def loses(frame, host):
        if lost or not host or frame.can_id != 1 or not is_stop(frame):
            return False
        lost.append(bench.now_s)
        return True

    bench.loses = loses
    while not lost:
        bench.run(0.001)
    bench.run(0.004)
    bench.controller.stop(hard=False)
    bench.finish()
    assert stops_of(bench, 1)[1] < lost[0] + 2.0 * STOP_POLL_S


@pytest.mark.parametrize("after_s", [0.42, 0.48, 0.49, 0.5])
def test_a_stop_near_the_end_of_a_motion_takes_no_drive_past_it(after_s):
    """A drive that brakes at its target already brakes no gentler after a stop."""
    way = (6000, -3000, 1500, 0, 700, 20)
    bench = begun(straight(5, way), after_s)
    check_halted(bench, hard=False)
    gone = [here - 50_000 for here in bench.positions]
    assert all(abs(count) <= 5 * abs(each) + 1 for count, each in zip(gone, way, strict=True))


# -- If the host dies, a drive that has lost orders also stops as soon as announced ----------------

FAST, SLOW = (9000, -3000, 700, 0, 0, 0), (90, -30, 7, 0, 0, 0)
MOST_S = 2.0
LOOK_S = 0.005
LOOKED_S = 0.02


def stands_after_s(moves, loses, dies_s):
    """Lose frames to the first drive, then the host; return how long the arm goes on.

    `loses` takes the time since the motion began, and the code of a frame from the host.
    """
    bench = MksBench(starts=(50_000,) * 6).ready()
    began_s = bench.now_s
    bench.loses = lambda frame, host: (
        host and frame.can_id == 1 and loses(bench.now_s - began_s, frame.data[0])
    )
    bench.begin(along(moves))
    bench.run(dies_s)
    bench.dead = True
    dead_s, stood_s, before = bench.now_s, bench.now_s, bench.positions
    while bench.now_s < dead_s + MOST_S:
        bench.run(LOOK_S)
        if bench.positions != before:
            before, stood_s = bench.positions, bench.now_s
    return stood_s - dead_s, bench.controller.stopping(AHEAD_S).silent_s


def orders(from_s, to_s):
    """Return what loses the orders of a while."""
    return lambda at_s, code: code == Code.ABSOLUTE_AXIS and from_s <= at_s < to_s


FASTER_THAN_SLOW = segments(*([(3000, -900, 0, 0, 0, 0)] * 3 + [(60, -20, 0, 0, 0, 0)] * 6))
SLOW_AT_THE_END = [segments(*([FAST] * 5 + [SLOW] * tail)) for tail in (0, 1, 4)]


@each_value(
    "later_s, lost, moves",
    [0.02, 0.12, 0.25],
    [(0.02, 0.4), (0.2, 0.65), (0.5, 0.75)],
    [*SLOW_AT_THE_END, FASTER_THAN_SLOW],
)
def test_a_drive_that_lost_orders_stops_as_soon_as_announced(moves, lost, later_s):
    took_s, announced_s = stands_after_s(moves, orders(*lost), lost[1] + later_s)
    assert took_s <= announced_s + LOOK_S


@each_value(
    "count, dies, read_s",
    [9000, 3000, 1500],
    [(0.35, 0.045), (0.39, 0.045), (0.45, 0.02)],
    [0.2, 0.3, 0.4],
)
def test_a_drive_that_lost_orders_and_readings_stops_as_soon_as_announced(count, dies, read_s):
    """One reading shows that it stands, but not whether it has begun since."""
    lost_s, later_s = dies

    def loses(at_s, code):
        unread = code == Code.ENCODER and 0.05 < at_s < lost_s and abs(at_s - read_s) > LOOKED_S
        return unread or orders(0.0, lost_s)(at_s, code)

    moves = segments(*[(count, -900, 0, 0, 0, 0)] * 6)
    took_s, announced_s = stands_after_s(moves, loses, lost_s + later_s)
    assert took_s <= announced_s + LOOK_S
