"""A drive off its path: one that is only late is not blamed; one that is blocked or too slow is.

One drive that lags while the others go on leads the arm off its path. Drives that are all late do
not.
"""

from __future__ import annotations

from itertools import pairwise

import pytest
from amounts import each_value
from mks_bench import (
    FAR_FROM_ZERO,
    MksBench,
    begun,
    check_blamed,
    check_done,
    segments,
    straight,
    total,
)

from armdrive.dialects.bus.intervals import CONFIRMING_LOOKS, LOOK_S, MAX_DELAY_S, STANDING_S
from armdrive.dialects.mks.settings import MksSettings
from armdrive.tasks import AlertKind, MoveAlong
from firmware_protocol.mks import Code
from kinematics import Motors

SHORT_AHEAD_S = 0.06
"""So little that a drive whose orders are late stands before they come."""
STALL_S = 0.05
"""Shorter than what is noticed as a bus that stands still."""
FAST, SLOW = (9000, -3000, 0, 0, 0, 0), (300, -100, 0, 0, 0, 0)
LATE_S = 0.005
"""So long at most does an answer take on this bus."""
POLL_S, CORRIDOR = MksSettings().poll_s, MksSettings().following_error_counts
REST, AHEAD_S = MksSettings().in_position_counts, 0.2
SPEEDS = (9000, -6000, 3000, -1000, 300, 0)
RELIEVED_S = 0.2
"""So long after it was found, a blocked drive is told to hold where it stands."""


def moving(moves, after_s, ahead_s=SHORT_AHEAD_S, **settings):
    return begun(moves, after_s, ahead_s, segment_s=0.02, **settings)


def run_until_told(bench):
    """Let time pass until something has alarmed."""
    while not bench.alerts():
        bench.run(0.001)
        bench.reply()


# -- blocked, or only behind -----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("speed", "for_s", "poll_s"),
    [(3000, 0.1, 0.02), (3000, 0.15, 0.2), (9000, 0.11, 0.02), (9000, 0.15, 0.1),
     (9000, 0.15, 0.2)],
)  # fmt: skip
def test_the_motion_waits_for_a_drive_that_is_behind_and_makes_progress(speed, for_s, poll_s):
    way = (speed, -speed // 3, 0, 0, 0, 0)
    bench = moving(straight(20, way), 0.5, 0.3, poll_s=poll_s)
    bench.node(1).block()  # then it springs to where its drive wants it
    bench.at_s[bench.now_s + for_s] = bench.node(1).free
    check_done(bench)
    assert bench.positions == Motors(50_000 + 20 * each for each in way)


@each_value(
    "counts_s, poll_s, after_s",
    [9000, 30_000, 90_000],
    [0.02, 0.1, 0.2],
    [0.3, 0.33, 0.36],
)
def test_a_blocked_shaft_is_reported_within_the_documented_time(counts_s, poll_s, after_s):
    way = (counts_s // 10, 0, 0, 0, 0, 0)
    bench = moving(straight(40, way), after_s, 0.3, poll_s=poll_s)
    bench.node(1).block()
    began_s = bench.now_s
    run_until_told(bench)
    (alert,) = bench.alerts()
    assert alert.kind is AlertKind.OFF_PATH
    assert "drive 1 (base)" in alert.text
    behind_s = CORRIDOR / counts_s + MAX_DELAY_S
    assert bench.now_s - began_s <= behind_s + 2.0 * poll_s + LOOK_S + 4.0 * LATE_S


@each_value("counts_s, after_s, paused_s", [-200, 600, -2458], [0.0, 0.3], [0.05, 0.5, 9.0])
def test_a_slow_drive_that_is_blocked_is_reported_also_in_a_pause(counts_s, after_s, paused_s):
    """Its targets stay near it, within its corridor, and it would spring there at any time."""
    bench, paused = MksBench(starts=FAR_FROM_ZERO).ready(), []
    moves = straight(20, (6000, -3000, 1500, counts_s // 10, 700, 20))
    bench.begin(MoveAlong(iter(moves), AHEAD_S, held_back=lambda: bool(paused)))
    bench.run(after_s)
    bench.node(4).block()
    began_s = bench.now_s
    bench.at_s[began_s + paused_s] = lambda: paused.append(True)
    check_blamed(bench, "drive 4 (right wrist)", AlertKind.OFF_PATH)
    found_s = MAX_DELAY_S + STANDING_S + 2.0 * REST / abs(counts_s) + 2.0 * POLL_S
    assert bench.now_s - began_s <= found_s + RELIEVED_S
    bench.node(4).free()
    bench.check_stands()


def test_a_blocked_shaft_is_reported_although_its_path_comes_back_halfway():
    there, back = (9000, 0, 0, 0, 0, 0), (-3000, 0, 0, 0, 0, 0)
    bench = moving(segments(*([there] * 5 + [back] * 10)), 0.2, 0.3)
    bench.node(1).block()
    run_until_told(bench)
    assert bench.now_s < 1.0
    check_blamed(bench)


@pytest.mark.parametrize("counts", [-60_000, 60_000])
def test_a_drive_that_stays_far_off_its_path_is_reported(counts):
    bench = moving(straight(20, FAST), 0.5, 0.3)
    began_s = bench.now_s
    bench.node(1).load(counts)
    run_until_told(bench)
    assert "drive 1 (base)" in bench.alerts()[0].text
    assert bench.now_s < began_s + 0.3


# -- one that missed orders ------------------------------------------------------------------------

SHARED_HZ, WINDOW_S = 20_000.0, 0.2
"""How fast a joint turns that the first two motors turn, and how long a mean of its speed is."""
SETTLED_S = AHEAD_S + 0.3
"""Until then others may go on without a drive that gets no orders."""


def eased(way, count):
    """Return the way in pieces of 0.05 s, from rest to rest."""
    rates = [min(1.0, (piece + 0.5) / 3.0, (count - piece - 0.5) / 3.0) for piece in range(count)]
    places = [
        Motors(round(sum(rates[:piece]) * each) for each in way) for piece in range(count + 1)
    ]
    return segments(*(b - a for a, b in pairwise(places)), duration_s=0.05)


@pytest.mark.parametrize(
    ("count", "after_s", "for_s"), [(18, 0.2, 0.35), (24, 0.2, 0.4), (24, 0.4, 0.4)]
)
def test_the_path_waits_for_a_drive_that_missed_orders(count, after_s, for_s):
    """Each motor alone turns their joint twice as fast as both do, in opposite directions."""
    moves = [*eased((2000, -1000, 0, 0, 0, 0), count), *eased((-1000, 2000, 0, 0, 0, 0), 24)]
    bench = begun(moves, after_s)
    until_s, seen = bench.now_s + for_s, []
    bench.loses = lambda frame, host: (
        host and frame.can_id == 1 and frame.data[0] == Code.ABSOLUTE_AXIS and bench.now_s < until_s
    )
    while bench.controller.busy:
        bench.run(0.02)
        seen.append((bench.now_s, bench.positions))
    check_done(bench)
    assert bench.positions == Motors(FAR_FROM_ZERO) + total(moves)
    for (_, before), (now_s, there) in zip(seen, seen[10:], strict=False):
        if now_s > until_s + SETTLED_S:
            turned = there - before
            assert abs(turned[0] + turned[1]) <= 1.2 * SHARED_HZ * WINDOW_S
            assert abs(turned[0]) <= 1.1 * 2.0 * SHARED_HZ * WINDOW_S


@pytest.mark.parametrize("way", [(300, -3000, 1500, 0, 700, 20), (1500, -1500, 0, 0, 0, 0)])
def test_a_drive_that_missed_an_order_makes_up_for_it_before_a_pause_ends(way):
    bench, paused = MksBench(starts=FAR_FROM_ZERO).ready(), []
    leg, began_s = eased(way, 12), bench.now_s
    bench.begin(MoveAlong(iter(leg * 2), 0.3, held_back=lambda: bool(paused)))
    bench.loses = lambda frame, host: (
        host
        and frame.can_id == 1
        and frame.data[0] == Code.ABSOLUTE_AXIS
        and 0.09 <= bench.now_s - began_s < 0.2
    )
    bench.at_s[began_s + 0.33] = lambda: paused.append(True)  # all of the first leg has been sent
    bench.run(0.6 + STALL_S)
    bench.check_stands()
    assert bench.positions == Motors(FAR_FROM_ZERO) + total(leg)
    check_done(bench)


# -- one that lags, all that are late --------------------------------------------------------------


def weaken(bench, number, share):
    """Have a motor turn no faster than a share of what its drive is told."""
    flash = bench.node(number).sim.flash
    rpm_of = flash.rpm_of
    flash.rpm_of = lambda rpm: rpm_of(rpm) * share


def weakened(moves, share):
    """Return drives in motion, the first of which has just become too slow."""
    bench = begun(moves, 0.5)
    weaken(bench, 1, share)
    return bench


def beside(bench, end):
    """Return how far two motors are from the nearest place of their way, which they go oppositely.

    The way ends where the first one has gone to `end`.
    """
    first, second = (bench.node(number).count - 50_000 for number in (1, 2))
    nearest = min(max((first - second) / 2.0, 0.0), end)
    return max(abs(first - nearest), abs(second + nearest))


@pytest.mark.parametrize(("speed", "share"), [(3000, 0.2), (3000, 0.4), (9000, 0.3), (9000, 0.8)])
def test_a_slow_drive_never_leads_the_arm_far_off_its_path(speed, share):
    bench = weakened(straight(40, (speed, -speed, 0, 0, 0, 0)), share)
    worst = 0.0
    while bench.controller.busy and not bench.alerts():
        bench.run(0.005)
        worst = max(worst, beside(bench, 40 * speed))
        bench.reply()
        assert share == 0.8 or bench.now_s < 6.0, "nobody has noticed"
    noticed = speed * 10 * (1.0 - share) * (CONFIRMING_LOOKS + 1) * POLL_S
    assert worst <= CORRIDOR + speed * 10 * MAX_DELAY_S + noticed
    if share < 0.8:
        check_blamed(bench, kind=AlertKind.OFF_PATH)


def test_a_drive_that_lags_a_little_arrives():
    bench = begun(straight(20, (9000, -9000, 0, 0, 0, 0)))
    weaken(bench, 1, 0.9)
    check_done(bench)
    assert bench.positions == Motors((230_000, -130_000, *[50_000] * 4))


@pytest.mark.parametrize("acceleration", [100, 200])
def test_drives_with_gentle_ramps_that_are_late_together_are_not_blamed(acceleration):
    check_done(begun(straight(12, (3000, -1500, 900, 0, 0, 0)), acceleration=acceleration))
