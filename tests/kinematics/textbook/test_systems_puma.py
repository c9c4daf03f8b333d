"""The Puma: eight branches of any lengths, its textbook posture, and every degenerate one."""

import math

import pytest
from amounts import every_row
from chain_cases import gap
from hypothesis import given
from systems_cases import postures, same_joints

from kinematics.chains.closed_form import closed_form
from kinematics.errors import OutOfReach
from kinematics.frames.transforms import position_of, transform
from kinematics.textbook.systems import PUMA

HALF = math.pi / 2.0
SIMPLE = PUMA
_, _, _, UPPER, _, FORE, _ = SIMPLE.sizes
BOUNDLESS = ((-360.0, 360.0),) * 6
ARMS = (
    SIMPLE,
    PUMA.sized(660.0, 0.0, 149.09, 431.8, -20.32, 433.07, 56.25),
    PUMA.sized(400.0, 150.0, 0.0, 300.0, 30.0, 320.0, 80.0, ranges=BOUNDLESS),
    PUMA.sized(0.0, -60.0, -90.0, 250.0, 0.0, 250.0, 0.0, ranges=BOUNDLESS),
)


def inverse(frame, arm, near=(0.0,) * 6):
    """Every posture that the closed form finds, before it is checked."""
    return list(closed_form(arm.chain()).finder.postures(frame, near))


def solved(arm, frame, seed=None):
    return arm.ik(arm.goal_of(frame), seed)


def test_the_textbook_posture_of_fu_gonzalez_and_lee():
    posture = (HALF, 0.0, HALF, 0.0, 0.0, 0.0)
    printed = (
        (0.0, -1.0, 0.0, -149.09),
        (0.0, 0.0, 1.0, 921.12),
        (-1.0, 0.0, 0.0, 20.32),
        (0.0, 0.0, 0.0, 1.0),
    )
    assert gap(PUMA.sized(a3=-20.32).fk(posture), printed) < 1e-9
    assert gap(position_of(SIMPLE.fk(posture)), (-149.09, 921.12, 0.0)) < 1e-9


def test_eight_branches_are_eight_postures_with_names():
    frame = SIMPLE.fk((0.4, -0.6, 1.2, 0.5, 0.7, -0.3))
    found = solved(SIMPLE, frame)
    assert [branch.name for branch in found] == list(SIMPLE.signs)
    assert len({tuple(round(v, 6) for v in branch.joints) for branch in found}) == 8
    assert max(gap(SIMPLE.fk(branch.joints), frame) for branch in found) < 1e-9
    again = pytest.approx((0.4, -0.6, 1.2, 0.5, 0.7, -0.3))
    assert [branch.name for branch in found if branch.joints == again] == [
        "base front, elbow down, wrist plain"
    ]


@given(postures(SIMPLE))
def test_the_names_say_where_base_elbow_and_wrist_are(joints):
    frame = SIMPLE.fk(joints)
    for branch in solved(SIMPLE, frame):
        if branch.degenerate:
            continue
        _, second, third, _, fifth, _ = branch.joints
        out = UPPER * math.cos(second) + FORE * math.sin(second + third)
        up = -UPPER * math.sin(second) + FORE * math.cos(second + third)
        # The elbow against the line from the shoulder to the wrist, seen outwards.
        above = (-UPPER * math.sin(second)) * out - UPPER * math.cos(second) * up
        assert ("base front" in branch.name) == (out > 0.0)
        assert ("elbow up" in branch.name) == (above * math.copysign(1.0, out) > 0.0)
        assert ("wrist plain" in branch.name) == (math.sin(fifth) > 0.0)


@every_row(
    "arm, joints, free, words",
    [
        (SIMPLE, (0.3, -0.5, 1.0, 0.5, 0.0, 0.2), ("theta4",), "joint 5 is straight"),
        (SIMPLE, (0.3, -0.5, HALF, 0.5, 0.8, 0.2), (), "elbow stretched"),
        (PUMA.sized(a2=500.0), (0.3, -0.5, -HALF, 0.5, 0.8, 0.2), (), "elbow folded"),
    ],
)
def test_degenerate_postures_say_what_they_lose(arm, joints, free, words):
    (found,) = [
        one for one in solved(arm, arm.fk(joints), joints) if same_joints(arm, one.joints, joints)
    ]
    assert words in found.degenerate
    assert found.free == free


@every_row("arm", ARMS, ids=range(len(ARMS)))
@every_row(
    "place",
    [
        (2000.0, 0.0, 100.0),
        (0.0, 0.0, 4000.0),
        (-900.0, 900.0, 900.0),
        (100.0, 20.0, 10.0),
        (0.0, 0.0, 0.0),
    ],
)
def test_a_wrist_out_of_reach_is_refused_with_a_frame_that_is_reached(arm, place):
    frame = transform(((1.0, 0.0, 0.0), (0.0, 0.0, -1.0), (0.0, 1.0, 0.0)), place)
    if inverse(frame, arm):
        assert all(gap(arm.fk(one.joints), frame) < 1e-8 for one in solved(arm, frame))
        return
    with pytest.raises(OutOfReach) as caught:
        solved(arm, frame)
    near = caught.value.nearest
    assert caught.value.away_mm == pytest.approx(math.dist(near[:3], place))
    assert near[3:] == pytest.approx(arm.goal_of(frame)[3:], abs=1e-6)  # as the hand was asked
    for branch in arm.ik(near):
        assert gap(position_of(arm.fk(branch.joints)), near[:3]) < 1e-5
