"""The boundary and the points that an arm reaches, against its own answers place by place."""

import math
from itertools import pairwise

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from kinematics_cases import TEACHMOVER, UNEVEN

from kinematics import FiveAxisArm, JointRange, Pose
from kinematics.five_axis.closed_form import forward
from kinematics.five_axis.rates import (
    braked,
    joint_rates,
    ramped,
    share_of_limits,
    shares_to_stop,
    task_jacobian,
)
from kinematics.five_axis.workspace import NUDGE_MM, section
from kinematics.frames.matrices import times
from kinematics.presets import preset
from kinematics.spaces import Joints

PITCHES_DEG = (-90, 0, 35)
FREE = FiveAxisArm(150.0, 120.0, 80.0, 60.0, (JointRange.of(-180, 180),) * 5)


def points_of(found):
    return [point for curve in found.boundary for point in curve]


def from_curves(found, x, z):
    """How far a place is from the boundary, measured to the chords between its points."""
    return min(to_chord(x, z, a, b) for curve in found.boundary for a, b in pairwise(curve))


def to_chord(x, z, a, b):
    dx, dz = b[0] - a[0], b[1] - a[1]
    square = dx * dx + dz * dz
    along = 0.0 if square == 0.0 else ((x - a[0]) * dx + (z - a[1]) * dz) / square
    along = min(max(along, 0.0), 1.0)
    return math.hypot(x - a[0] - along * dx, z - a[1] - along * dz)


@pytest.mark.parametrize("pitch_deg", PITCHES_DEG)
@pytest.mark.parametrize("arm", [TEACHMOVER, UNEVEN], ids=["teachmover", "uneven"])
def test_between_what_is_reached_and_what_is_not_lies_the_boundary(arm, pitch_deg):
    found = section(arm, math.radians(pitch_deg), step_mm=8.0)
    spacing = 31.0
    lattice = [
        (column * spacing + 7.0, row * spacing)
        for column in range(-16, 17)
        for row in range(-14, 22)
    ]
    held = {place: found.holds(*place) for place in lattice}
    crossings = 0
    for (x, z), inside in held.items():
        for beside in ((x + spacing, z), (x, z + spacing)):
            if held.get(beside, inside) != inside:
                crossings += 1
                edge = crossing(found, (x, z), beside)
                assert from_curves(found, *edge) < 0.3, edge
    assert crossings > 20


def crossing(found, a, b):
    """The place between two where reach begins, by halving."""
    inside = found.holds(*a)
    for _ in range(30):
        middle = (a[0] + b[0]) / 2.0, (a[1] + b[1]) / 2.0
        if found.holds(*middle) == inside:
            a = middle
        else:
            b = middle
    return a


@pytest.mark.parametrize("pitch_deg", PITCHES_DEG)
def test_the_boundary_s_points_lie_close_together_and_on_the_edge(pitch_deg):
    found = section(TEACHMOVER, math.radians(pitch_deg), step_mm=10.0)
    for curve in found.boundary:
        for a, b in pairwise(curve):
            assert math.dist(a, b) < 10.5
    for x, z in points_of(found)[::7]:
        around = [
            found.holds(x + 2 * NUDGE_MM * math.cos(t), z + 2 * NUDGE_MM * math.sin(t))
            for t in (k * math.pi / 8 for k in range(16))
        ]
        assert any(around)
        assert not all(around)


def test_stretched_level_the_arm_reaches_its_whole_length():
    found = section(TEACHMOVER, 0.0)
    assert found.box_mm[1] == pytest.approx(452.1, abs=0.1)
    assert from_curves(found, 452.1, 193.7) < 0.1


def test_without_limits_the_reach_is_the_ring_between_stretched_and_folded():
    found = section(FREE, -math.pi / 2, step_mm=4.0)
    centre = 150.0 - 60.0  # the hand points down
    radii = {round(math.hypot(x, z - centre), 1) for x, z in points_of(found)}
    assert radii == {40.0, 200.0}


@given(st.floats(-180.0, 180.0), st.data())
def test_every_posture_s_tip_is_held(pitch_deg, data):
    pitch = math.radians(pitch_deg)
    _, shoulder, elbow, wrist, _ = UNEVEN.limits
    s = data.draw(st.floats(shoulder.low_rad, shoulder.high_rad))
    e = data.draw(st.floats(elbow.low_rad, elbow.high_rad))
    w = pitch - s - e
    if not wrist.low_rad <= w <= wrist.high_rad:
        return
    x, y, z, task_pitch, _ = forward((0.0, s, e, w, 0.0), UNEVEN.lengths)
    assert y == 0.0
    assert section(UNEVEN, task_pitch, step_mm=1000.0).holds(x, z)


def test_the_points_are_those_of_a_lattice_that_ik_reaches():
    pitch = math.radians(-90)
    found = section(TEACHMOVER, pitch, math.radians(30))
    points = found.points(60.0)
    assert len(points) > 15
    for x, z in points:
        assert (x % 60.0, z % 60.0) == (0.0, 0.0)
        goal = Pose(x * math.cos(math.pi / 6), x * math.sin(math.pi / 6), z, pitch)
        assert TEACHMOVER.solve(goal) is not None
    assert (180.0, 120.0) in points
    assert (600.0, 120.0) not in points


def test_behind_the_arm_less_is_reached_than_before_it():
    found = section(TEACHMOVER, 0.0)
    behind = [x for x, _ in found.points(20.0) if x < 0]
    ahead = [x for x, _ in found.points(20.0) if x > 0]
    assert len(behind) < len(ahead)


def test_a_pitch_that_is_never_held_reaches_nothing():
    still = FiveAxisArm(100, 100, 100, 50, (JointRange.of(0, 0),) * 5)
    found = section(still, 1.0)
    assert found.boundary == ()
    assert found.points(50.0) == ()
    assert found.box_mm == (0.0, 0.0, 0.0, 0.0)


# Laws of a jog's arithmetic: ramps, the rates of joints under a moving tip, and braking.


ARM = preset("teachmover").arm
LENGTHS = ARM.lengths
BOUNDS = tuple((one.low_rad, one.high_rad) for one in ARM.limits)
SHARES = st.tuples(*[st.floats(-1.0, 1.0)] * 3)
POSTURES = st.tuples(*[st.floats(low, high) for low, high in BOUNDS])
TIPS = st.tuples(*[st.floats(-100.0, 100.0)] * 3, *[st.floats(-1.0, 1.0)] * 2)


@given(POSTURES, TIPS)
def test_joint_rates_are_the_inverse_of_the_jacobian_in_front_and_behind(angles, tip):
    assume(abs(math.sin(angles[2])) > 0.02)
    r = math.hypot(*forward(angles, LENGTHS)[:2])
    assume(r > 5.0)
    rates = joint_rates(angles, tip, LENGTHS)
    made = times(task_jacobian(ARM, Joints(angles)), rates)
    assert made == pytest.approx(tip, abs=1e-6)


@pytest.mark.parametrize("angles", [(0.0, 1.0, 0.0, 0.0, 0.0), (0.0, 0.5, math.pi, 0.0, 0.0)])
def test_a_straight_or_folded_elbow_gives_no_rates(angles):
    assert joint_rates(angles, (1.0, 0.0, 0.0, 0.0, 0.0), LENGTHS) is None


def test_a_tip_on_the_base_axis_moves_only_in_the_arms_plane():
    angles = (0.0, math.pi / 2 + 0.5, -1.0, 0.0, 0.0)
    wrist_r = LENGTHS[1] * math.cos(angles[1]) + LENGTHS[2] * math.cos(angles[1] + angles[2])
    third = math.acos(-wrist_r / LENGTHS[3])
    angles = (0.0, angles[1], angles[2], third - angles[1] - angles[2], 0.0)
    assert joint_rates(angles, (10.0, 0.0, 0.0, 0.0, 0.0), LENGTHS) is not None
    assert joint_rates(angles, (0.0, 10.0, 0.0, 0.0, 0.0), LENGTHS) is None


@given(SHARES, SHARES, st.floats(0.5, 20.0), st.floats(0.01, 1.0))
def test_a_ramp_never_changes_faster_than_its_slope_and_arrives(now, wish, slope, time_s):
    mean, end = ramped(now, wish, slope, time_s)
    for a, middle, b, there in zip(now, mean, wish, end, strict=True):
        assert abs(there - a) <= slope * time_s + 1e-9
        assert min(a, b) - 1e-9 <= there <= max(a, b) + 1e-9
        assert min(a, there) - 1e-9 <= middle <= max(a, there) + 1e-9
    for _ in range(int(2.0 / (slope * time_s)) + 2):
        _, now = ramped(now, wish, slope, time_s)
    assert now == pytest.approx(wish, abs=1e-9)


@given(SHARES, st.floats(0.5, 20.0), st.floats(0.01, 1.0))
def test_a_ramp_from_rest_goes_in_the_direction_of_the_wish_from_the_first_moment(
    wish, slope, time_s
):
    mean, end = ramped((0.0, 0.0, 0.0), wish, slope, time_s)
    for made in (mean, end):
        assert all(
            abs(a * d - b * c) <= 1e-9
            for a, b, c, d in ((made[i], made[j], wish[i], wish[j]) for i, j in ((0, 1), (1, 2)))
        )


def test_a_change_of_direction_passes_through_zero():
    now, seen = (1.0,), []
    for _ in range(8):
        mean, now = ramped(now, (-1.0,), 5.0, 0.05)
        seen.append(mean[0])
    assert seen == sorted(seen, reverse=True)
    assert seen[0] > 0.0 > seen[-1]
    assert now == (-1.0,)


@given(st.floats(0.0, 5.0), st.floats(0.01, 0.5), st.floats(0.0, 2.0))
def test_braking_ends_at_the_bound_and_is_never_beyond_it(way_s, time_s, ramp_s):
    speed, left = 1.0, way_s
    for _ in range(400):
        share = braked(left / speed, time_s, ramp_s * speed) if speed else 0.0
        speed *= share
        left -= speed * time_s
        assert left >= -1e-9
        assert speed * speed * ramp_s <= 2.0 * left + 1e-9
    assert left <= 1e-6


def test_braking_from_afar_keeps_the_speed():
    assert braked(10.0, 0.05, 0.2) == 1.0
    assert braked(0.15, 0.05, 0.2) == pytest.approx(1.0)
    assert braked(0.0, 0.05, 0.2) == braked(-1.0, 0.05, 0.2) == 0.0
    assert braked(0.02, 0.05, 0.0) == pytest.approx(0.4)


def test_limits_slow_all_rates_alike():
    assert share_of_limits((1.0, -2.0), (4.0, 1.0)) == 0.5
    assert share_of_limits((1.0, -2.0), (4.0, 2.0)) == 1.0


@given(POSTURES, st.tuples(*[st.floats(-2.0, 2.0)] * 5))
def test_joints_that_are_slowed_to_stop_end_within_their_limits(angles, rates):
    for _ in range(60):
        ramps_s = [abs(rate) / 5.0 for rate in rates]
        shares = shares_to_stop(angles, rates, BOUNDS, 0.05, ramps_s)
        rates = tuple(rate * share for rate, share in zip(rates, shares, strict=True))
        angles = tuple(a + rate * 0.05 for a, rate in zip(angles, rates, strict=True))
        for angle, (low, high) in zip(angles, BOUNDS, strict=True):
            assert low - 1e-9 <= angle <= high + 1e-9
