"""A drive that has lost orders stands as soon as announced all the same, when its host dies."""

from __future__ import annotations

import pytest
from mks_bench import AHEAD_S, MksBench, along, segments

from firmware_protocol.mks import Code

FAST, SLOW = (9000, -3000, 700, 0, 0, 0), (90, -30, 7, 0, 0, 0)
MOST_S = 3.0
LOOK_S = 0.005


def stands_after_s(moves, lost, dies_s):
    """Lose the orders of the first drive for a while, then the host; return how long it goes on."""
    bench = MksBench(starts=(50_000,) * 6).ready()
    began_s = bench.now_s

    def loses(frame, host):
        from_s, to_s = (began_s + each for each in lost)
        order = frame.can_id == 1 and frame.data[0] == Code.ABSOLUTE_AXIS
        return host and order and from_s <= bench.now_s < to_s

    bench.loses = loses
    bench.begin(along(moves))
    bench.run(dies_s)
    bench.dead = True
    dead_s, stood_s, before = bench.now_s, bench.now_s, bench.positions
    while bench.now_s < dead_s + MOST_S:
        bench.run(LOOK_S)
        if bench.positions != before:
            before, stood_s = bench.positions, bench.now_s
    return stood_s - dead_s, bench.controller.stopping(AHEAD_S).silent_s


@pytest.mark.parametrize("later_s", [0.02, 0.06, 0.1, 0.15, 0.25])
@pytest.mark.parametrize("lost", [(0.2, 0.65), (0.3, 0.7), (0.45, 0.62), (0.5, 0.75)])
@pytest.mark.parametrize("tail", [0, 1, 4])
def test_orders_that_were_lost_do_not_have_a_drive_go_on_for_longer(tail, lost, later_s):
    moves = segments(*([FAST] * 5 + [SLOW] * tail))
    took_s, announced_s = stands_after_s(moves, lost, lost[1] + later_s)
    assert took_s <= announced_s + LOOK_S


def test_a_slow_way_that_was_fast_before_is_no_longer_either():
    moves = segments(*([(3000, -900, 0, 0, 0, 0)] * 3 + [(60, -20, 0, 0, 0, 0)] * 6))
    took_s, announced_s = stands_after_s(moves, (0.02, 0.4), 0.52)
    assert took_s <= announced_s + LOOK_S
