"""Many poses at once: the same answers as one by one, and no number where there is no posture."""

import math

import numpy as np
import pytest
from kinematics_cases import ARMS, TEACHMOVER, UNEVEN

from kinematics import Base, Elbow, Joints, KinematicsError, Pose
from kinematics.five_axis.batch import (
    BLOCK,
    BRANCHES,
    branches_many,
    branches_of_frames,
    forward_many,
    frames_many,
    inverse_many,
    within_limits,
)
from kinematics.five_axis.closed_form import ON_MANIFOLD_RAD

each_arm = pytest.mark.parametrize("arm", ARMS, ids=["teachmover", "uneven"])


def random_postures(arm, count, seed=3):
    low = [bounds.low_rad for bounds in arm.limits]
    high = [bounds.high_rad for bounds in arm.limits]
    return np.random.default_rng(seed).uniform(low, high, (count, 5))


def random_goals(count, seed=4):
    generator = np.random.default_rng(seed)
    low, high = (-500, -500, -300, -3.5, -3.0), (500, 500, 700, 3.5, 3.0)
    return generator.uniform(low, high, (count, 5))


def apart(a, b):
    """Largest difference in mm, and largest difference in rad, turns left out."""
    turn = a[..., 3:] - b[..., 3:]
    return (
        np.abs(a[..., :3] - b[..., :3]).max(initial=0.0),
        np.abs(turn - np.rint(turn / math.tau) * math.tau).max(initial=0.0),
    )


@each_arm
def test_forward_is_what_one_pose_gives(arm):
    postures = random_postures(arm, 300)
    found = forward_many(arm, postures)
    for posture, pose in zip(postures, found, strict=True):
        one = arm.fk(Joints(tuple(posture)))
        expected = (one.x_mm, one.y_mm, one.z_mm, one.pitch_rad, one.roll_rad)
        assert max(apart(pose, np.array(expected))) < 1e-9


@each_arm
def test_frames_are_what_one_posture_gives(arm):
    postures = random_postures(arm, 300)
    for posture, frame in zip(postures, frames_many(arm, postures), strict=True):
        assert frame == pytest.approx(np.array(arm.transform(Joints(tuple(posture)))), abs=1e-9)


@each_arm
@pytest.mark.parametrize("count", [0, 1, 7, BLOCK - 1, BLOCK, 2 * BLOCK + 5])
def test_every_branch_of_every_length_of_array_holds_its_pose(arm, count):
    poses = forward_many(arm, random_postures(arm, count))
    branches = branches_many(arm, poses)
    assert branches.shape == (count, 4, 5)
    assert not np.isnan(branches).any()
    for index in range(4):
        distance, turn = apart(forward_many(arm, branches[:, index]), poses)
        assert distance < 1e-6
        assert turn < 1e-9


@each_arm
def test_the_branches_are_those_of_one_pose_and_out_of_reach_is_no_number(arm):
    goals = random_goals(400)
    found = branches_many(arm, goals)
    for goal, four in zip(goals, found, strict=True):
        expected = {(one.base, one.elbow): one.joints for one in arm.branches(Pose(*goal))}
        if not expected:
            assert np.isnan(four).all()
            continue
        for key, joints in zip(BRANCHES, four, strict=True):
            turn = joints - np.array(expected[key].angles_rad)
            assert np.abs(turn - np.rint(turn / math.tau) * math.tau).max() < 1e-7


@each_arm
@pytest.mark.parametrize("base", Base)
@pytest.mark.parametrize("elbow", Elbow)
def test_one_branch_is_that_one_of_the_four(arm, base, elbow):
    goals = random_goals(1000)
    one = inverse_many(arm, goals, base, elbow)
    four = branches_many(arm, goals)[:, BRANCHES.index((base, elbow))]
    np.testing.assert_allclose(one, four, atol=1e-12)
    assert np.isnan(one).any(axis=1).sum() == np.isnan(one).all(axis=1).sum() > 100


@each_arm
def test_frames_have_the_branches_of_their_poses(arm):
    postures = random_postures(arm, 1000)
    frames = frames_many(arm, postures)
    found = branches_of_frames(arm, frames)
    assert found.off_manifold_rad.max() < 1e-9
    for index in range(4):
        again = frames_many(arm, found.joints[:, index])
        np.testing.assert_allclose(again, frames, atol=1e-6)


def test_frames_off_the_manifold_are_no_number_and_say_by_how_much():
    frames = frames_many(UNEVEN, random_postures(UNEVEN, 500))
    turn = np.linspace(-1.2, 1.2, len(frames))
    turn[::5] = 0.0
    normal = np.cross(frames[:, :3, 2], (0.0, 0.0, 1.0))
    side = normal / np.linalg.norm(normal, axis=1, keepdims=True)
    up = np.cross(side, frames[:, :3, 2])
    for column in range(3):  # about an axis in the plane, normal to the hand
        frames[:, :3, column] = rotated(frames[:, :3, column], up, turn)
    found = branches_of_frames(UNEVEN, frames)
    np.testing.assert_allclose(found.off_manifold_rad, np.abs(turn), atol=1e-9)
    off = found.off_manifold_rad > ON_MANIFOLD_RAD
    assert off.sum() == 400
    assert np.isnan(found.joints[off]).all()
    assert not np.isnan(found.joints[~off]).any()


def rotated(vectors, axis, angle):
    """Rodrigues' formula, row by row."""
    cos, sin = np.cos(angle)[:, None], np.sin(angle)[:, None]
    along = (vectors * axis).sum(axis=1, keepdims=True) * axis
    return along + cos * (vectors - along) + sin * np.cross(axis, vectors)


@pytest.mark.parametrize("upright", [True, False])
def test_a_tip_on_the_base_axis_has_branches_that_hold_it(upright):
    lengths = TEACHMOVER.lengths
    posture = np.array([[0.6, 2.2, -0.9, 0.0, 0.4]])
    if upright:
        posture[0, :4] = (0.6, math.pi / 2, 0.0, 0.0)
    else:
        wrist_r = lengths[1] * math.cos(2.2) + lengths[2] * math.cos(1.3)
        posture[0, 3] = math.acos(-wrist_r / lengths[3]) - 1.3
    frames = frames_many(TEACHMOVER, posture)
    assert np.hypot(frames[0, 0, 3], frames[0, 1, 3]) < 1e-9
    found = branches_of_frames(TEACHMOVER, frames)
    for index in range(4):
        again = frames_many(TEACHMOVER, found.joints[:, index])
        np.testing.assert_allclose(again, frames, atol=1e-5)
    poses = np.array([[0.0, 0.0, 500.0, 0.3, 0.2]])
    again = forward_many(TEACHMOVER, branches_many(TEACHMOVER, poses)[:, 0])
    assert max(apart(again, poses)) < 1e-6


@each_arm
def test_full_stretch_and_a_hair_beyond_are_reached_and_more_is_not(arm):
    height, upper, fore, hand = arm.lengths
    stretched = [upper + fore + hand + beyond for beyond in (-1e-10, 0.0, 1e-10, 1e-6)]
    goals = np.array([[r, 0.0, height, 0.0, 0.0] for r in stretched])
    assert np.isnan(inverse_many(arm, goals)[:, 2]).tolist() == [False, False, False, True]


def test_limits_are_looked_at_turn_by_turn():
    postures = random_postures(UNEVEN, 200)
    turned = postures + math.tau * np.random.default_rng(1).integers(-2, 3, postures.shape)
    assert within_limits(UNEVEN, turned).all()
    beyond = postures.copy()
    beyond[:, 3] = UNEVEN.limits[3].high_rad + 0.01
    assert not within_limits(UNEVEN, beyond).any()
    assert not within_limits(UNEVEN, np.full((1, 5), np.nan)).any()


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("column", range(4))
def test_what_is_no_number_has_no_posture(bad, column):
    goals = np.array([[200.0, 50.0, 100.0, -1.0, 0.0]] * 2)
    goals[0, column] = bad
    found = inverse_many(TEACHMOVER, goals)
    assert np.isnan(found[0]).any()
    assert not np.isnan(found[1]).any()


def test_results_go_where_they_are_wanted_in_any_layout():
    goals = random_goals(50)
    by_rows = np.empty((50, 5))
    found = inverse_many(TEACHMOVER, np.asfortranarray(goals), out=by_rows)
    assert found is by_rows
    np.testing.assert_array_equal(by_rows, inverse_many(TEACHMOVER, goals))
    frames = np.empty((50, 4, 4))
    assert frames_many(TEACHMOVER, goals, out=frames) is frames
    four = np.empty((50, 4, 5))
    assert branches_many(TEACHMOVER, goals, out=four) is four
    np.testing.assert_array_equal(four, branches_many(TEACHMOVER, goals))
    assert branches_of_frames(TEACHMOVER, frames, out=four).joints is four


def test_arrays_of_another_shape_are_refused():
    with pytest.raises(KinematicsError, match=r"shape \(N, 5\) is needed, not \(3, 4\)"):
        inverse_many(TEACHMOVER, np.zeros((3, 4)))
    with pytest.raises(KinematicsError, match=r"shape \(N, 4, 4\)"):
        branches_of_frames(TEACHMOVER, np.zeros((3, 5)))
    with pytest.raises(KinematicsError, match="`out` must be"):
        inverse_many(TEACHMOVER, np.zeros((3, 5)), out=np.zeros((2, 5)))
