"""One drive that lags while the others go on leads the arm off its way; drives all late do not."""

from __future__ import annotations

import random

import pytest
from mks_bench import BOTH, ORDERS, MksBench, along, begun, hold_up, segments, straight, suspend

from armdrive.dialects.bus.observer import CONFIRMING_LOOKS, MAX_DELAY_S
from armdrive.dialects.mks.settings import MksSettings
from armdrive.tasks import AlertKind, Done, RequestRejected
from kinematics import Motors

POLL_S = MksSettings().poll_s
SPEEDS = (9000, -6000, 3000, -1000, 300, 0)
TOLD_S = 1.1
"""Half a second of looks behind those of the time before, and a stop."""


def weaken(bench, number, share):
    """Have a motor turn no faster than a share of what its drive is told."""
    flash = bench.node(number).sim.flash
    rpm_of = flash.rpm_of
    flash.rpm_of = lambda rpm: rpm_of(rpm) * share


def let_pass(speed):
    return MksSettings().corridor_counts + speed * 10 * MAX_DELAY_S


def beside(bench, way):
    """Return how far the first two motors are from every place of their common way, at least."""
    gone = [bench.node(number).at(bench.now_s) - 50_000 for number in (1, 2)]
    places = ([each * tenth / 10.0 for each in way[:2]] for tenth in range(401))
    return min(max(abs(a - b) for a, b in zip(gone, place, strict=True)) for place in places)


@pytest.mark.parametrize("share", [0.2, 0.3, 0.4])
@pytest.mark.parametrize("speed", [3000, 9000])
def test_a_drive_that_lags_ends_the_motion_before_the_arm_is_far_off_its_way(speed, share):
    way = (speed, -speed, 0, 0, 0, 0)
    bench = begun(straight(40, way))
    bench.run(0.5)
    weaken(bench, 1, share)
    worst = 0.0
    while not bench.alerts():
        bench.run(0.005)
        worst = max(worst, beside(bench, way))
        assert bench.reply() is None or bench.alerts()
        assert bench.now_s < 6.0, "nobody has noticed"
    (alert,) = bench.alerts()
    assert alert.kind is AlertKind.ASTRAY
    assert "drive 1 (base)" in alert.text
    assert isinstance(bench.finish(), RequestRejected)
    noticed = speed * 10 * (1.0 - share) * (CONFIRMING_LOOKS + 1) * POLL_S
    assert worst <= let_pass(speed) + noticed


@pytest.mark.parametrize("count", [12, 40])
@pytest.mark.parametrize("share", [0.5, 0.6, 0.7])
@pytest.mark.parametrize("speed", [-9000, 3000, 9000])
def test_one_that_is_too_slow_for_half_a_second_is_told_of_though_it_stays_near_its_way(
    speed, share, count
):
    bench = begun(straight(count, (speed, -speed, 700, 0, 0, 0)))
    bench.run(0.5)
    weaken(bench, 1, share)
    assert isinstance(bench.finish(), RequestRejected)
    (alert,) = bench.alerts()
    assert alert.kind is AlertKind.ASTRAY
    assert "drive 1 (base)" in alert.text
    assert bench.now_s < 0.5 + TOLD_S


@pytest.mark.parametrize("seed", range(20))
def test_a_host_that_is_always_late_calls_no_drive_too_slow(seed):
    dice = random.Random(seed)
    bench = MksBench(starts=(50_000,) * 6).ready()
    ways = [tuple(dice.choice(SPEEDS) for _ in range(6)) for _ in range(3)]
    bench.begin(along(segments(*(way for way in ways for _ in range(6)))))
    while bench.controller.busy:
        bench.run(dice.uniform(0.005, 0.06))
        suspend(bench, dice.uniform(0.005, 0.08))
    assert isinstance(bench.finish(), Done)
    assert not bench.alerts()


@pytest.mark.parametrize("share", [0.8])
@pytest.mark.parametrize("speed", [3000, 9000])
def test_one_that_is_too_slow_leads_no_arm_far_off_its_way_whether_it_is_told_of_or_not(
    speed, share
):
    way = (speed, -speed, 0, 0, 0, 0)
    bench = begun(straight(40, way))
    bench.run(0.5)
    weaken(bench, 1, share)
    worst = 0.0
    while bench.controller.busy and not bench.alerts():
        bench.run(0.005)
        worst = max(worst, beside(bench, way))
    noticed = speed * 10 * (1.0 - share) * (CONFIRMING_LOOKS + 1) * POLL_S
    assert worst <= let_pass(speed) + noticed


def test_a_drive_that_lags_a_little_is_let_pass_and_gets_there():
    bench = begun(straight(20, (9000, -9000, 0, 0, 0, 0)))
    weaken(bench, 1, 0.9)
    assert isinstance(bench.finish(), Done)
    assert not bench.alerts()
    assert bench.positions == Motors((230_000, -130_000, *[50_000] * 4))


@pytest.mark.parametrize("acceleration", [100, 200, 252])
def test_drives_with_gentle_ramps_are_late_together_and_well(acceleration):
    bench = begun(straight(20, (3000, -1500, 900, 0, 0, 0)), acceleration=acceleration)
    assert isinstance(bench.finish(), Done)
    assert not bench.alerts()


@pytest.mark.parametrize("sides", [BOTH, ORDERS])
@pytest.mark.parametrize("seed", range(6))
def test_a_computer_that_is_late_blames_no_drive(seed, sides):
    dice = random.Random(seed)
    bench = MksBench(starts=(50_000,) * 6).ready()
    speeds = [dice.choice((1.0, 0.1, -1.0, -0.3)) for _ in range(5)]
    ways = [(round(6000 * s), round(-3000 * s), 700, 0, 0, 0) for s in speeds for _ in range(5)]
    bench.begin(along(segments(*ways)))
    while bench.controller.busy and bench.now_s < 30.0:
        bench.run(dice.uniform(0.0, 0.3))
        late = dice.choice((hold_up, suspend))
        late(bench, dice.uniform(0.0, 0.2), *([sides] if late is hold_up else []))
    assert isinstance(bench.finish(), Done)
    assert not bench.alerts()
