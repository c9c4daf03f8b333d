"""A drive that is steered ends where it is sent, and does not run past that to come back."""

from __future__ import annotations

import math

import pytest
from mks_bench import MksBench, along

from armdrive.dialects.bus.paths import Course
from armdrive.dialects.mks.stops import ramp_to
from armdrive.tasks import Done, MoveBy
from firmware_protocol.mks import COUNTS_S_PER_RPM, slope_of
from kinematics import Motors

CONFIGURED = 252


def course(speed: float) -> Course:
    """A drive at zero that turns so fast."""
    found = Course()
    found.rest_at(0.0, 0.0)
    found.put(0.0, speed, 0.0)
    return found


@pytest.mark.parametrize("share", [0.05, 0.3, 1.0])
@pytest.mark.parametrize(("speed", "left"), [(20_000.0, 4000), (20_000.0, -4000), (3000.0, 60)])
def test_a_drive_is_given_a_ramp_by_which_it_can_end(share, speed, left):
    drive = course(math.copysign(speed, left))
    slope = slope_of(ramp_to(drive, left, CONFIGURED, share))
    assert slope <= slope_of(CONFIGURED)
    assert speed**2 / (2.0 * slope) <= max(abs(left), speed**2 / (2.0 * slope_of(CONFIGURED)))


@pytest.mark.parametrize("share", [0.05, 0.3, 0.8, 1.0])
@pytest.mark.parametrize(("speed", "left"), [(22_937.0, 266), (41_000.0, 900), (9000.0, 90)])
def test_it_can_end_there_though_the_order_comes_a_little_late(share, speed, left):
    slope = slope_of(ramp_to(course(speed), left, CONFIGURED, share))
    late = speed * 0.002
    assert speed**2 / (2.0 * slope) <= max(left - late, speed**2 / (2.0 * slope_of(CONFIGURED)))


@pytest.mark.parametrize("share", [0.05, 0.1, 0.3])
@pytest.mark.parametrize("ahead_s", [0.0005, 0.001, 0.003])
def test_it_keeps_the_ramp_by_which_it_brakes_though_its_course_is_there_already(share, ahead_s):
    drive = course(0.0)
    drive.order(10_000, 60 * COUNTS_S_PER_RPM, slope_of(235), 0.0)
    drive.advance(0.6)
    drive.order(10_000, 14 * COUNTS_S_PER_RPM, slope_of(246), 0.6)
    now_s = 0.6
    while drive.speed:
        now_s += 0.0005
        drive.advance(now_s)
    slope = slope_of(246)
    speed = slope * ahead_s  # of the shaft itself, which is so much later
    left = speed**2 / (2.0 * slope)
    kept = slope_of(ramp_to(drive, 10_000, CONFIGURED, share, kept=246))
    assert speed**2 / (2.0 * kept) <= left


def test_a_drive_that_stood_starts_with_its_share_of_the_ramp():
    drive = course(0.0)
    drive.order(1000, 14 * COUNTS_S_PER_RPM, slope_of(246), 0.0)
    drive.rest_at(1000, 2.0)
    begins = ramp_to(drive, 5000, CONFIGURED, 0.1)
    assert begins == ramp_to(drive, -5000, CONFIGURED, 0.1)
    assert begins < 246


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
