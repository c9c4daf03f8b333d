"""MKS drives in motion: together, never further than announced, and what goes wrong is said."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest
from amounts import each_value
from hypothesis import Phase, example, given, settings
from hypothesis import strategies as st
from mks_bench import (
    AHEAD_S,
    BURSTS,
    SEGMENT_S,
    MksBench,
    along,
    off_path,
    requests,
    segments,
    straight,
    total,
)

from armdrive.tasks import (
    Done,
    Halted,
    HomeDevice,
    MoveAlong,
    MoveBy,
    ReadPosition,
    Registers,
    RequestRejected,
)
from firmware_protocol import mks
from kinematics import Motors


def ramped(way, count=8):
    """Return segments from rest to rest that begin and end gently."""
    places = [(1.0 - math.cos(math.pi * part / count)) / 2.0 for part in range(count + 1)]
    points = [Motors(round(place * one) for one in way) for place in places]
    parts = [b - a for a, b in pairwise(points)]
    return [MoveBy(part, part.largest / SEGMENT_S) for part in parts if part.largest]


FAST = (6000, -3000, 1500, 0, 700, 20)


@pytest.mark.parametrize(
    ("way", "says_done"),
    [(FAST, True), (FAST, False), ((20, 0, 0, 0, 0, 3), True)],
)
def test_a_motion_ends_where_it_should_in_its_time(way, says_done):
    """Also if no drive says "done": it has arrived when it stands."""
    bench = MksBench(starts=(5, -5, 0, 100, 0, 0)).ready()
    for node in bench.nodes:
        node.sim.port.withheld = not says_done
    moves = straight(way=way)
    start, began_s = bench.positions, bench.now_s
    assert isinstance(bench.do(along(moves)), Done)
    assert bench.positions == start + total(moves)
    assert not requests(bench, mks.MoveAbsoluteAxis, node=4)  # it stands
    assert bench.now_s - began_s == pytest.approx(1.0, abs=0.2)
    assert bench.controller.underruns == 0


GENTLE = settings(
    max_examples=2, deadline=None, phases=(Phase.explicit, Phase.generate), derandomize=True
)


@GENTLE
@example([(9000, -3000, 0, 0, 700, 0), (-9000, 3000, 0, 0, -700, 0)])
@given(st.lists(st.tuples(*[st.integers(-9000, 9000)] * 6).filter(any), min_size=1, max_size=2))
def test_every_path_is_followed_to_its_end(ways):
    bench = MksBench().ready()
    moves = [move for way in ways for move in ramped(way)]
    began_s, at, time_s = bench.now_s, Motors([0] * 6), 0.0
    corners = [(0.0, at)]
    for move in moves:
        at, time_s = at + move.steps, time_s + move.duration_s
        corners.append((time_s, at))
    bench.begin(along(moves))
    worst = 0.0
    while bench.controller.busy and bench.now_s < began_s + 5.0:
        bench.run(0.02)
        worst = max(worst, off_path(corners, bench.now_s - began_s, bench.positions))
    assert isinstance(bench.finish(), Done)
    assert bench.positions == at
    assert worst < 150


WAY = (30_000, -15_000, 7_500, 0, 3_750, 90)


def out_of_proportion(bench) -> float:
    share = bench.positions[0] / WAY[0]
    return max(abs(at - share * way) for at, way in zip(bench.positions, WAY, strict=True))


def out_of_proportion_until(bench, end_s) -> float:
    """Let the motion go on until a time or its end; return how far it was out of proportion."""
    worst = 0.0
    while bench.controller.busy and bench.now_s < end_s:
        bench.run(0.005)
        worst = max(worst, out_of_proportion(bench))
    return worst


@pytest.mark.parametrize(
    ("end", "reply", "most"),
    [
        ("by itself", Done(), 30),  # what 2.5 rpm are in a period
        ("stopped", Halted(), 75),
        ("held back", Done(), 75),  # at the end of what was drawn
    ],
)
def test_motors_keep_in_proportion_however_the_motion_ends(end, reply, most):
    bench, held = MksBench().ready(), []
    bench.begin(along(ramped(WAY), held_back=lambda: bool(held)))
    worst = out_of_proportion_until(bench, bench.now_s + 0.3)
    if end == "stopped":
        bench.controller.stop(hard=False)
    elif end == "held back":
        held.append(True)
    worst = max(worst, out_of_proportion_until(bench, math.inf))
    assert worst < most
    assert bench.finish() == reply
    assert (0 < bench.positions[0] < WAY[0]) if end != "by itself" else bench.positions == WAY


def test_the_next_segment_is_drawn_no_earlier_than_announced():
    bench = MksBench().ready()
    drawn = []

    def lazily():
        for move in straight(20):
            drawn.append(bench.now_s)
            yield move

    began_s = bench.now_s
    bench.do(along(lazily()))
    for number, at_s in enumerate(drawn):
        assert at_s >= began_s + number * SEGMENT_S - AHEAD_S - 1e-6


FASTEST = (15000, -3000, 1500, 0, 700, 20)
JOINED = [(6000, 100 * part**2 if part > 0 else 0, 0, 0, 0, 0) for part in range(-4, 8)]
"""One motor turns evenly, and another one joins it and accelerates."""
PATHS = [straight(12, FASTEST), ramped(tuple(10 * each for each in FASTEST)), segments(*JOINED)]


@each_value("firmware, dies_s, moves", [(1, 0, 9), (1, 0, 5)], [0.62, 0.05, 0.55], PATHS)
def test_a_dead_host_leaves_no_motion_beyond_the_bound(firmware, dies_s, moves):
    bench = MksBench(firmware, {"firmware": ".".join(map(str, firmware))}).ready()
    bench.begin(along(moves))
    bench.run(dies_s)
    bench.dead, died_s = True, bench.now_s
    bound = bench.controller.stopping(AHEAD_S)
    bench.run(bound.silent_s)
    bench.check_stands()
    assert bench.now_s > died_s


def test_the_drives_watchdog_stops_what_was_sent_far_ahead():
    bench = MksBench(settings={"watchdog_s": 0.2}).ready()
    bench.begin(MoveAlong(iter(straight(60)), 5.0))
    bench.run(1.0)
    bench.dead = True
    assert bench.controller.stopping(5.0).silent_s < 0.5
    bench.run(bench.controller.stopping(5.0).silent_s)
    bench.check_stands()


@each_value("end, after_s", ["stop", "hard stop", "release"], [0.05, 0.33, 0.71])
def test_a_motion_that_is_stopped_ends_within_the_bound_and_reports_where(end, after_s):
    bench, released = MksBench().ready(), []
    bench.begin(along(straight(30), jog=end == "release", released=lambda: bool(released)))
    bench.run(after_s)
    if end == "release":
        released.append(True)
    else:
        bench.controller.stop(hard=end == "hard stop")
    asked_s = bench.now_s
    assert bench.finish() == Halted()
    assert bench.now_s - asked_s <= bench.controller.stopping(AHEAD_S).asked_s
    here = bench.positions
    assert 0 < here[0] < 60_000
    assert bench.do(ReadPosition()) == Registers(here)
    bench.check_stands(1.0)
    assert bool(requests(bench, mks.EmergencyStop)) == (end == "hard stop")


def test_disabled_motors_are_not_moved():
    bench = MksBench()
    bench.do(ReadPosition())
    for request in (along(straight(2)), HomeDevice(((0,),))):
        reply = bench.do(request)
        assert isinstance(reply, RequestRejected)
        assert not reply.moved
    assert not requests(bench, mks.MoveAbsoluteAxis, mks.Home)


def test_a_target_that_cannot_be_expressed_is_refused():
    bench = MksBench(starts=(mks.TARGET_MAX - 100, 0, 0, 0, 0, 0)).ready()
    reply = bench.do(along(straight(2)))
    assert isinstance(reply, RequestRejected)
    assert "512 turns" in reply.reason
    bench.check_stands()


@pytest.mark.parametrize("ways", [(3000, 100), (3000, 20, 5), (2500, 1200, 300)])
def test_a_motor_that_slows_more_than_the_others_does_not_pass_its_end(ways):
    bench = MksBench().ready()
    moves = [MoveBy(Motors((4000, way, 0, 0, 0, 0)), 40_000.0) for way in ways]
    end, most = sum(ways), 0
    bench.begin(along(moves))
    for _ in range(2000):
        bench.run(0.001)
        most = max(most, bench.positions[1])
        if (reply := bench.reply()) is not None:
            break
    assert isinstance(reply, Done)
    assert most <= end + 2


# -- bursts ----------------------------------------------------------------------------------------


def bursting(firmware) -> MksBench:
    """Return drives of a firmware that the arm file names, and that are sent bursts."""
    return MksBench(firmware, BURSTS | {"firmware": ".".join(map(str, firmware))}).ready()


@pytest.mark.parametrize("firmware", [(1, 0, 9), (1, 0, 8), (1, 0, 4)])
def test_a_burst_ends_where_it_should_in_the_time_that_was_announced(firmware):
    bench = bursting(firmware)
    steps = Motors((9000, -4500, 300, 0, 20, 1))
    began_s = bench.now_s
    lasts_s = bench.controller.duration_s(9000, 30_000)
    assert isinstance(bench.do(MoveBy(steps, 30_000)), Done)
    assert bench.positions == steps
    assert bench.now_s - began_s < lasts_s + 0.15


def armed(answer_s: float = 0.001) -> MksBench:
    """Return a bench whose drives another program has told to store motions."""
    bench = MksBench(settings=BURSTS)
    for node in bench.nodes:
        node.sim.port.answer_s = answer_s
    bench.ready()
    for node in bench.nodes:
        node.sim.motion.armed = True
    return bench


def test_drives_that_another_program_has_armed_move_all_the_same():
    bench = armed()
    assert bench.do(MoveBy(Motors((9000, -4500, 300, 0, 20, 0)), 30_000)) == Done()
    assert bench.positions == Motors((9000, -4500, 300, 0, 20, 0))
    assert not any(node.sim.motion.armed for node in bench.nodes[:3])


@each_value("answer_s, hard", [0.001, 0.02], [False, True])
def test_an_order_that_a_drive_has_only_stored_is_not_sent_again_after_a_stop(answer_s, hard):
    bench = armed(answer_s)
    bench.begin(MoveBy(Motors((90_000, -45_000, 300, 0, 20, 0)), 30_000))
    bench.run(answer_s / 2.0)
    bench.controller.stop(hard=hard)
    assert bench.finish() == Halted()
    bench.run(3.0)
    assert bench.positions == Motors([0] * 6)


@GENTLE
@given(st.tuples(*[st.integers(-9_000, 9_000)] * 6).filter(any), st.floats(3_000, 60_000),
       st.sampled_from([(1, 0, 9), (1, 0, 4)]))  # fmt: skip
def test_a_burst_strays_no_further_than_announced(steps, rate_hz, firmware):
    bench = bursting(firmware)
    steps = Motors(steps)
    bound = bench.controller.deviation_steps(steps, rate_hz)
    bench.begin(MoveBy(steps, rate_hz))
    largest = max(range(6), key=lambda motor: abs(steps[motor]))
    while bench.controller.busy:
        bench.run(0.004)
        share = bench.positions[largest] / steps[largest]
        for at, way, most in zip(bench.positions, steps, bound, strict=True):
            assert abs(at - share * way) <= most + math.ceil(abs(way) * 0.02) + 2


def test_a_lost_order_of_a_burst_is_repeated_unchanged():
    bench = bursting((1, 0, 4))
    said = []

    def loses(frame, host):
        order = mks.decode_request(frame) if host and frame.can_id == 2 else None
        said.extend([order] if isinstance(order, mks.MoveAbsoluteAxis) else [])
        return isinstance(order, mks.MoveAbsoluteAxis) and len(said) == 1

    bench.loses = loses
    assert isinstance(bench.do(MoveBy(Motors((9000, -900, 0, 0, 0, 0)), 30_000)), Done)
    assert len(said) > 1
    assert len(set(said)) == 1


def test_a_burst_that_is_released_before_it_begins_is_not_sent():
    bench = MksBench(settings=BURSTS).ready()
    assert bench.do(MoveBy(Motors((900, 0, 0, 0, 0, 0)), 3000, lambda: True)) == Halted()
    assert bench.positions == Motors([0] * 6)


def test_no_watchdog_no_promise_of_it():
    bench = MksBench(settings={"watchdog_s": 0.0}).ready()
    assert not requests(bench, mks.SilenceWatchdog)
    assert bench.controller.stopping(5.0).silent_s > 5.0
