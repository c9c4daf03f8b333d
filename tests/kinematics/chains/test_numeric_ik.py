"""Inverse kinematics by numbers: right where it says so, and an honest account where not."""

import math
from dataclasses import replace

import pytest
from amounts import every_row
from chain_cases import ALPHA_II, MINI_MOVER, PUMA, gap
from hypothesis import given, settings
from hypothesis import strategies as st

from kinematics import FiveAxisArm, JointRange, Pose
from kinematics.chains.chain import Chain
from kinematics.chains.goals import ALL_PARTS, Part, frame_goal, pose_goal
from kinematics.chains.inverse import Reason, descend, solve_goal
from kinematics.chains.links import DHLink, JointKind
from kinematics.five_axis.nearest import nearest
from kinematics.frames.rotations import rot_x
from kinematics.frames.transforms import compose, position_of, transform
from kinematics.frames.vectors import distance

ARM = FiveAxisArm(
    195.0, 177.8, 177.8, 96.5, tuple(JointRange(one.low, one.high) for one in MINI_MOVER.links)
)
QUICK = 6


def solve_pose_ik(chain, pose, *, free=frozenset(), **further):
    goal = pose_goal(pose)
    return solve_goal(chain, replace(goal, parts=goal.parts - free), **further)


SLIDER = Chain(
    (
        DHLink(0.0, 300.0, 0.0, 0.0, low=-3.0, high=3.0),
        DHLink(0.0, 0.0, 0.0, -math.pi / 2, JointKind.PRISMATIC, low=0.0, high=400.0),
        DHLink(0.0, 100.0, 0.0, 0.0, JointKind.PRISMATIC, low=0.0, high=300.0),
    ),
    name="cylindrical",
)


def holds(chain, solution, frame):
    """The claim of a solution, checked by the product of the matrices."""
    assert gap(chain.fk(solution.joints), frame) < 1e-3
    assert not chain.violations(solution.joints)


def test_a_goal_so_far_away_that_its_square_is_no_number_is_beyond_reach():
    turret = Chain((DHLink(d_mm=200.0, alpha_rad=math.pi / 2), DHLink(a_mm=150.0)))
    for x_mm in (1e100, 1e153, 1e200, 1e308):
        solution = solve_pose_ik(turret, Pose(x_mm, 0.0, 0.0, 0.0))
        assert solution.reason is Reason.BEYOND_REACH


@every_row(
    "x, y, z, pitch",
    [
        (250, 80, 120, -90),
        (150, -200, 300, 20),
        (300, 0, 400, 70),
        (430, 0, 100, -60),
        (-200, 50, 300, 0),
        (120, 30, 60, 100),
    ],
)
def test_the_closed_form_and_the_numbers_agree_on_what_can_be_reached(x, y, z, pitch):
    pose = Pose.of(x_mm=x, y_mm=y, z_mm=z, pitch_deg=pitch, roll_deg=15)
    exact = ARM.solve(pose)
    solution = solve_pose_ik(MINI_MOVER, pose)
    assert solution.ok == (exact is not None)
    if exact is not None:
        holds(MINI_MOVER, solution, MINI_MOVER.fk(exact.angles_rad))
    else:
        assert solution.missed
        assert solution.reason is not Reason.NONE


@every_row(
    "pose",
    [
        Pose.of(x_mm=420, y_mm=60, z_mm=120, pitch_deg=-60),
        Pose.of(x_mm=380, y_mm=0, z_mm=500, pitch_deg=0, roll_deg=30),
        Pose.of(x_mm=250, y_mm=-90, z_mm=20, pitch_deg=40),
    ],
)
def test_with_the_pitch_kept_the_nearest_pose_is_that_of_the_closed_form(pose):
    assert ARM.solve(pose) is None
    exact = nearest(ARM, pose)
    solution = solve_pose_ik(MINI_MOVER, pose, hand_first=True)
    assert solution.met == ALL_PARTS - {Part.POSITION}
    assert solution.residual_mm == pytest.approx(exact.distance_mm, rel=1e-3)


def test_a_goal_too_far_away_is_so_for_certain():
    solution = solve_pose_ik(MINI_MOVER, Pose.of(x_mm=900, y_mm=0, z_mm=195, pitch_deg=0))
    assert solution.reason is Reason.BEYOND_REACH
    assert solution.missed == {Part.POSITION}
    assert solution.residual_mm == pytest.approx(900 - 452.1, abs=1e-3)
    assert position_of(solution.frame) == pytest.approx((452.1, 0.0, 195.0), abs=0.1)
    assert "position by 448 mm" in solution.sentence


def test_a_joint_limit_is_named_with_what_the_joint_would_need():
    goal = Pose.of(x_mm=200, y_mm=0, z_mm=195, pitch_deg=-100)
    assert solve_pose_ik(MINI_MOVER, goal).ok
    stiff = replace(
        MINI_MOVER,
        links=(*MINI_MOVER.links[:3], replace(MINI_MOVER.links[3], low=-0.2), MINI_MOVER.links[4]),
    )
    solution = solve_pose_ik(stiff, goal)
    assert solution.reason is Reason.JOINT_LIMIT
    assert [one.joint for one in solution.violations] == ["wrist_pitch"]
    assert solution.violations[0].bound == -0.2
    assert "wrist_pitch" in solution.at_limit
    assert "the wrist pitch would have to be at" in solution.sentence
    assert not stiff.violations(solution.joints)


def test_a_joint_comes_back_from_its_limit():
    low = MINI_MOVER.links[2].low
    goal = frame_goal(MINI_MOVER.fk((0.2, 0.6, low + 0.3, 0.3, 0.4)))
    assert descend(MINI_MOVER, goal, (0.2, 0.6, low, 0.3, 0.4)).ok


@settings(max_examples=8)
@given(st.floats(0.05, 0.6))
def test_five_axes_meet_the_position_and_say_by_how_much_the_hand_is_off(tilt):
    goal = compose(
        MINI_MOVER.fk((0.2, 0.6, -1.0, 0.3, 0.4)), transform(rot_x(tilt), (0.0, 0.0, 0.0))
    )
    solution = solve_goal(MINI_MOVER, frame_goal(goal), starts=QUICK)
    assert solution.reason is Reason.NO_POSTURE
    assert Part.POSITION in solution.met
    assert Part.HEADING in solution.missed
    assert solution.residual_mm < 1e-4
    assert 0.0 < solution.residual_rad <= tilt + 1e-6  # leaving the hand alone misses by the tilt
    assert "no posture meets the goal, for certain" in solution.sentence


def test_what_is_left_free_is_not_missed():
    pose = Pose.of(x_mm=250, y_mm=80, z_mm=120, pitch_deg=150, roll_deg=20)
    assert not solve_pose_ik(MINI_MOVER, pose, starts=QUICK).ok
    free = solve_pose_ik(MINI_MOVER, pose, free={Part.PITCH})
    assert free.ok
    assert Part.PITCH not in free.met
    assert free.joints[4] == pytest.approx(math.radians(20), abs=1e-6)
    rolled = solve_pose_ik(MINI_MOVER, pose, free={Part.PITCH, Part.ROLL})
    assert rolled.ok
    assert Part.ROLL not in rolled.met | rolled.missed


@every_row("chain", [PUMA, MINI_MOVER, ALPHA_II, SLIDER], ids=lambda chain: chain.name)
def test_no_answer_is_wrong_and_not_flagged(chain):
    """Goals in reach, out of it, on the base axis, off the arm's manifold, on singularities."""
    frames = [
        transform(rot_x(tilt), place)
        for tilt in (1.2, math.pi)
        for place in ((300.0, 0.0, 200.0), (0.0, 0.0, 650.0))
    ]
    bent = [0.3, 0.5, -0.9, 0.4, 0.0, 0.2][: len(chain)]  # a Puma's wrist is straight
    frames += [chain.fk(chain.clamp(values)) for values in (chain.zero, bent)]
    for frame in frames:
        solution = solve_goal(chain, frame_goal(frame), starts=3)
        off = gap(chain.fk(solution.joints), frame)
        assert solution.ok == (off < 1e-3)
        assert not chain.violations(solution.joints)
        assert solution.residual_mm == pytest.approx(
            distance(position_of(chain.fk(solution.joints)), position_of(frame))
        )
