"""Guards over whole paths: proved free, found where they begin, and always a way out."""

import math
from dataclasses import replace

import pytest
from amounts import amount, every_row
from hypothesis import given, settings
from hypothesis import strategies as st
from kinematics_cases import LAMP, TEACHMOVER, UNEVEN, VICE, postures

from kinematics import Guards, JointPath, Joints, Pose, first_violation, line_path
from kinematics.guards import AngleSum
from kinematics.guards.shapes import Box

WALL = Box("wall", (-500.0, 200.0, -10.0), (500.0, 204.0, 600.0))
FOREARM = AngleSum("forearm elevation", (("shoulder", 1.0), ("elbow", 1.0)), -1.8, 0.8)
EVERYTHING = Guards(
    radii_mm=(35.0, 30.0, 25.0),
    base_radius_mm=50.0,
    base_top_mm=140.0,
    boxes=(VICE, WALL, LAMP),
    sums=(FOREARM,),
)
POINTS = Guards()
ONLY_BOXES = replace(
    EVERYTHING,
    inner_radius_mm=None,
    outer_radius_mm=None,
    hand_wrist_radius_mm=None,
    base_radius_mm=None,
    sums=(),
)
UNSEEN_MM = 1.0
"""Half of the least distance between looks: nothing deeper than that passes unseen."""

LOOKS = 150


def densely(path):
    for index in range(LOOKS + 1):
        yield path.at(index / LOOKS)


def beyond_mm(guards, arm, joints):
    """How deep a posture is inside the guards and their tolerance."""
    worst = 0.0
    for one in guards.violations(arm, joints):
        loose = one.guard in ("table", "base column", "arm against itself") or "box" in one.guard
        worst = max(worst, one.excess_mm - guards.tolerance_mm * loose)
    return worst


@given(
    st.sampled_from((TEACHMOVER, UNEVEN)).flatmap(
        lambda arm: st.tuples(st.just(arm), postures(arm), postures(arm))
    ),
    st.sampled_from((POINTS, EVERYTHING, ONLY_BOXES)),
    st.sampled_from((0.02, 0.1, 0.5)),
)
@settings(max_examples=amount(50, 1000))
def test_what_is_proved_free_is_free_wherever_one_looks(case, guards, share):
    arm, start, goal = case
    path = JointPath(start, JointPath(start, goal).at(share))
    if guards.violations(arm, start):
        return
    found = first_violation(arm, guards, (path.start, path.goal))
    deepest = [beyond_mm(guards, arm, joints) for joints in densely(path)]
    if found is None:
        assert max(deepest) <= UNSEEN_MM + 1e-5
        return
    fraction, violation = found
    there = guards.violation(arm, path.at(fraction))
    assert there is not None
    assert there.excess_mm == pytest.approx(violation.excess_mm, abs=1e-3)
    before = deepest[: int(fraction * LOOKS)]
    travel_mm = arm.travel_bound_mm(path.changes_rad)
    spared = int(2.0 / max(travel_mm, 1e-9) * LOOKS) + 1
    assert max(before[: len(before) - spared] or [0.0]) <= UNSEEN_MM + 1e-5


@every_row(
    "name, start, goal, share",
    [
        ("box wall", (230, 130, 120), (230, 190, 120), 0.7),
        ("box lamp", (230, -90, 180), (250, -150, 180), 0.5),
        ("box vice", (280, 0, 20), (240, 0, 20), 0.5),
        ("table", (250, 100, 20), (250, 100, -20), 0.5),
        ("table", (250, -100, 120), (250, -100, -80), 0.6),
    ],
)
def test_the_first_guard_on_a_straight_line_is_named_where_it_begins(name, start, goal, share):
    before, behind = (
        Pose.of(**dict(zip(("x_mm", "y_mm", "z_mm"), one, strict=True)), pitch_deg=-80)
        for one in (start, goal)
    )
    waypoints = line_path(TEACHMOVER, TEACHMOVER.ik(before), behind)
    fraction, violation = first_violation(TEACHMOVER, ONLY_BOXES, waypoints)
    assert violation.guard == name
    assert fraction == pytest.approx(share, abs=0.15)
    assert 1.0 < violation.excess_mm <= 1.0 + 2.0


class Counting:
    """An arm that counts how often its points are asked for."""

    def __init__(self, arm):
        self._arm = arm
        self.looks = 0

    def __getattr__(self, name):
        return getattr(self._arm, name)

    def points(self, joints):
        self.looks += 1
        return self._arm.points(joints)


def test_a_few_looks_prove_a_long_line_in_the_open():
    start = TEACHMOVER.ik(Pose.of(x_mm=300, y_mm=-110, z_mm=150, pitch_deg=-90))
    end = Pose.of(x_mm=300, y_mm=110, z_mm=150, pitch_deg=-90)
    waypoints = line_path(TEACHMOVER, start, end)
    arm = Counting(TEACHMOVER)
    assert first_violation(arm, POINTS, waypoints) is None
    assert arm.looks <= 3 * len(waypoints)


@given(st.floats(-60.0, -2.0), st.floats(-1.0, 1.0), st.floats(-0.6, 0.6))
def test_an_arm_below_the_table_may_rise_and_may_not_sink(z_mm, direction, turn):
    pose = Pose(260 * math.cos(direction), 260 * math.sin(direction), z_mm, -math.pi / 2)
    low = TEACHMOVER.ik(pose)
    above, below = (TEACHMOVER.ik(replace(pose, z_mm=z_mm + by)) for by in (80.0, -8.0))
    up = (low, above.replace(base=low["base"] + turn * 0.5))
    assert first_violation(TEACHMOVER, POINTS, up) is None
    assert first_violation(TEACHMOVER, POINTS, (low, below)) is not None


def test_a_way_out_leads_into_no_other_guard():
    inside = TEACHMOVER.ik(Pose.of(x_mm=250, y_mm=0, z_mm=30, pitch_deg=-90))
    guards = replace(ONLY_BOXES, boxes=(VICE,))
    assert guards.violation(TEACHMOVER, inside).guard == "box vice"
    out = TEACHMOVER.ik(Pose.of(x_mm=290, y_mm=0, z_mm=30, pitch_deg=-90))
    down = TEACHMOVER.ik(Pose.of(x_mm=290, y_mm=0, z_mm=-3, pitch_deg=-90))
    fraction, violation = first_violation(TEACHMOVER, guards, (inside, out, down))
    assert violation.guard == "table"
    assert fraction > 0.5


def test_a_sum_of_joints_beyond_its_range_comes_back_and_goes_no_further():
    guards = Guards(sums=(FOREARM,), outer_radius_mm=None, inner_radius_mm=None)
    beyond = Joints.of(0, 60, -5, 0, 0)
    back, on = Joints.of(0, 60, -30, 0, 0), Joints.of(0, 61, -5, 0, 0)
    aside = Joints.of(20, 62, -7, 10, 50)
    for goal, free in ((back, True), (aside, True), (on, False)):
        found = first_violation(TEACHMOVER, guards, (beyond, goal))
        assert (found is None) == free
