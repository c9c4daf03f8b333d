"""If the host dies, a drive that has lost orders also stops as soon as announced."""

from __future__ import annotations

from amounts import in_pairs
from mks_bench import AHEAD_S, MksBench, along, segments

from firmware_protocol.mks import Code

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


@in_pairs(
    "later_s, lost, moves",
    [0.02, 0.06, 0.12, 0.25],
    [(0.02, 0.4), (0.2, 0.65), (0.45, 0.62), (0.5, 0.75)],
    [*SLOW_AT_THE_END, FASTER_THAN_SLOW],
)
def test_a_drive_that_lost_orders_stops_as_soon_as_announced(moves, lost, later_s):
    took_s, announced_s = stands_after_s(moves, orders(*lost), lost[1] + later_s)
    assert took_s <= announced_s + LOOK_S


@in_pairs(
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
