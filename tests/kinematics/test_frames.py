"""Frames in frames, and frames on the bench."""

import math

import numpy as np
import pytest
from amounts import every_row
from chain_cases import any_angle, directed, gap, rotations, transforms, turn_gap, vectors
from hypothesis import given
from hypothesis import strategies as st

from kinematics import (
    RPY,
    AxisAngle,
    Degeneracy,
    EulerZYZ,
    Pose,
    ZeroVector,
    rotation_vector,
    solve_axis_angle,
    solve_euler,
    solve_quaternion,
    solve_rpy,
    turn_between,
)
from kinematics.chains.assignment import AxisLine
from kinematics.frames.numbers import QUARTER_TOLERANCE_RAD, cos_sin
from kinematics.frames.orientations import quaternion_of
from kinematics.frames.rotations import (
    IDENTITY,
    determinant,
    multiply,
    rotation_between,
    transpose,
)
from kinematics.frames.transforms import (
    IN_PLACE,
    compose,
    transform_point,
)
from kinematics.frames.user_frame import UserFrame
from kinematics.frames.vectors import (
    X_AXIS,
    ZERO,
    add,
    angle_between,
    any_normal,
    cross,
    dot,
    norm,
    project,
    reject,
    scale,
    unit,
)


@given(transforms, transforms, vectors)
def test_frames_compose_like_4_by_4_matrices(a, b, point):
    assert np.allclose(compose(a, b), np.array(a) @ np.array(b), atol=1e-9)
    assert (
        gap(transform_point(compose(a, b), point), transform_point(a, transform_point(b, point)))
        < 1e-8
    )
    assert compose() == IN_PLACE
    assert compose(a) == a


# Frames on the bench: what is laid out there is found there, and found again.


MM = st.floats(-500.0, 500.0)
TURN = st.floats(-math.pi, math.pi)


@given(MM, MM, TURN, st.floats(10.0, 300.0), st.floats(10.0, 300.0))
def test_three_touched_points_lay_out_the_frame_they_were_taken_from(
    x: float, y: float, yaw: float, along: float, across: float
) -> None:
    wanted = UserFrame.turned((x, y, 20.0), yaw, 0.2, -0.1)

    def at(u: float, v: float) -> tuple[float, float, float]:
        pose = wanted.to_base(Pose(u, v, 0.0, 0.0))
        return pose.x_mm, pose.y_mm, pose.z_mm

    found = UserFrame.through(at(0.0, 0.0), at(along, 0.0), at(5.0, across))
    assert gap(found.rotation, wanted.rotation) < 1e-9
    pose = Pose(10.0, 20.0, 30.0, 0.1, 0.2, 0.3)
    seen = wanted.to_base(pose)
    assert math.isclose(math.remainder(seen.yaw_rad - 0.3 - yaw, math.tau), 0.0, abs_tol=1e-9)
    assert wanted.from_base(seen).position_mm == pytest.approx(pose.position_mm)


# Vectors: products, lengths, angles, and what a vector without a direction cannot tell.


@every_row("tiny", [1e-12, 1e-9, 1e-6])
def test_the_smallest_angles_keep_their_digits(tiny):
    u, v = X_AXIS, (math.cos(tiny), math.sin(tiny), 0.0)
    assert math.isclose(angle_between(u, v), tiny, rel_tol=1e-9)
    assert math.isclose(math.pi - angle_between(scale(-1.0, u), v), tiny, abs_tol=1e-15)


@given(directed, directed)
def test_a_vector_is_its_part_along_and_its_part_across(u, v):
    along, across = project(u, v), reject(u, v)
    assert gap(add(along, across), u) < 1e-9 * norm(u)
    assert abs(dot(across, v)) < 1e-9 * norm(u) * norm(v)
    assert norm(cross(along, v)) < 1e-9 * norm(u) * norm(v)


@every_row(
    "ask",
    [
        unit,
        any_normal,
        lambda zero: angle_between(zero, X_AXIS),
        lambda zero: angle_between(X_AXIS, zero),
        lambda zero: project(X_AXIS, zero),
        lambda zero: AxisLine(ZERO, zero),
    ],
)
def test_no_direction_is_made_up(ask):
    with pytest.raises(ZeroVector, match="no direction"):
        ask(ZERO)


# Rotation matrices: the group they form, and the check that a matrix belongs to it.


@given(rotations, rotations, rotations)
def test_rotations_are_a_group(a, b, c):
    product = multiply(a, b)
    assert gap(multiply(product, transpose(product)), IDENTITY) < 1e-14
    assert math.isclose(determinant(multiply(a, b)), 1.0, abs_tol=1e-12)
    assert gap(multiply(a, transpose(a)), IDENTITY) < 1e-14
    assert gap(multiply(multiply(a, b), c), multiply(a, multiply(b, c))) < 1e-14
    assert gap(transpose(multiply(a, b)), multiply(transpose(b), transpose(a))) < 1e-15
    assert multiply() == IDENTITY
    assert multiply(a) == a


@given(st.lists(rotations, max_size=5), st.data())
def test_any_frame_of_a_chain_is_seen_from_any_other(steps, data):
    ends = st.integers(0, len(steps))
    i, j, k = data.draw(ends), data.draw(ends), data.draw(ends)
    through = multiply(rotation_between(steps, i, k), rotation_between(steps, k, j))
    assert gap(through, rotation_between(steps, i, j)) < 1e-13
    assert rotation_between(steps, i, i) == IDENTITY
    for at, step in enumerate(steps):
        assert rotation_between(steps, at, at + 1) == step


# Three three_of, axis and angle, quaternions: each both ways, and every degenerate case by name.

SOLVERS = (solve_rpy, solve_euler, solve_axis_angle, solve_quaternion)
every_solver = pytest.mark.parametrize("solve", SOLVERS, ids=lambda solve: solve.__name__)
three_angles = pytest.mark.parametrize(
    ("kind", "solve"), [(RPY, solve_rpy), (EulerZYZ, solve_euler)]
)


@every_solver
@given(matrix=rotations)
def test_both_answers_make_the_matrix_again(solve, matrix):
    solved = solve(matrix)
    assert gap(solved.first.rotation(), matrix) < 2e-9
    if solved.degeneracy is None:
        assert gap(solved.first.rotation(), matrix) < 1e-13
        assert gap(solved.second.rotation(), matrix) < 1e-13
        assert solved.second != solved.first


@three_angles
@given(phi=any_angle, theta=any_angle, psi=any_angle)
def test_the_angles_that_made_a_matrix_are_among_its_answers(kind, solve, phi, theta, psi):
    made = kind(phi, theta, psi)
    solved = solve(made.rotation())
    if solved.degeneracy is None:
        answers = [solved.first, solved.second]
    else:
        answers = [solve(made.rotation(), phi).first]
    assert min(turn_gap(three_of(answer), three_of(made)) for answer in answers) < 1e-8


def three_of(answer):
    return answer.phi_rad, answer.theta_rad, answer.psi_rad


@given(any_angle, any_angle, any_angle)
def test_the_orientation_transform_is_written_out_as_in_the_notes(phi, theta, psi):
    cf, sf = math.cos(phi), math.sin(phi)
    ct, st_ = math.cos(theta), math.sin(theta)
    cp, sp = math.cos(psi), math.sin(psi)
    expected = (
        (cf * ct, cf * st_ * sp - sf * cp, cf * st_ * cp + sf * sp),
        (sf * ct, sf * st_ * sp + cf * cp, sf * st_ * cp - cf * sp),
        (-st_, ct * sp, ct * cp),
    )
    assert gap(RPY(phi, theta, psi).rotation(), expected) < 1e-15
    assert gap(EulerZYZ(phi, theta, psi).rotation(), euler(cf, sf, ct, st_, cp, sp)) < 1e-15


def euler(cf, sf, ct, st_, cp, sp):
    return (
        (cf * ct * cp - sf * sp, -cf * ct * sp - sf * cp, cf * st_),
        (sf * ct * cp + cf * sp, -sf * ct * sp + cf * cp, sf * st_),
        (-st_ * cp, st_ * sp, ct),
    )


@every_row(
    "solve, made, degeneracy",
    [
        (solve_rpy, RPY(0.3, math.pi / 2, 0.1), Degeneracy.X_AXIS_DOWN),
        (solve_rpy, RPY(0.3, -math.pi / 2, 0.1), Degeneracy.X_AXIS_UP),
        (solve_rpy, RPY(0.3, math.pi / 2 - 1e-10, 0.1), Degeneracy.X_AXIS_DOWN),
        (solve_euler, EulerZYZ(0.3, 0.0, 0.1), Degeneracy.NO_TILT),
        (solve_euler, EulerZYZ(0.3, math.pi, 0.1), Degeneracy.FULL_TILT),
        (solve_euler, EulerZYZ(0.3, -1e-10, 0.1), Degeneracy.NO_TILT),
    ],
)
def test_degenerate_angles_are_named_and_the_held_one_is_kept(solve, made, degeneracy):
    matrix = made.rotation()
    for held in (0.0, 0.3, -2.0):
        solved = solve(matrix, held)
        assert solved.degeneracy is degeneracy
        assert solved.second is None
        assert solved.first.phi_rad == held
        assert gap(solved.first.rotation(), matrix) < 1e-9


@given(directed, st.floats(1e-6, math.pi - 1e-6))
def test_axis_and_angle_come_back(axis, angle):
    made = AxisAngle(axis, angle)
    solved = solve_axis_angle(made.rotation())
    assert abs(solved.first.angle_rad - angle) < 1e-9
    assert gap(solved.first.axis, made.axis) < 1e-9
    assert solved.second.angle_rad == -solved.first.angle_rad
    assert gap(solved.second.axis, scale(-1.0, solved.first.axis)) < 1e-15
    assert gap(rotation_vector(made.rotation()), scale(angle, made.axis)) < 1e-8


@every_row("off", [0.0, 1e-12, 1e-9, 1e-6])
def test_half_a_turn_keeps_its_axis(off):
    made = AxisAngle((1.0, 2.0, 3.0), math.pi - off)
    vector = rotation_vector(made.rotation())
    assert norm(vector) == pytest.approx(math.pi, abs=2e-6)
    assert norm(cross(vector, made.axis)) < 1e-6


@given(rotations, rotations)
def test_quaternions_multiply_and_turn_like_their_matrices(a, b):
    p, q = quaternion_of(a), quaternion_of(b)
    assert gap((p * q).rotation(), multiply(a, b)) < 1e-14
    assert gap(p.inverse().rotation(), transpose(a)) < 1e-14
    assert gap((-p).rotation(), a) < 1e-14


@given(rotations, directed, st.floats(0.0, math.pi))
def test_the_turn_between_two_rotations_is_the_one_that_was_made(m, axis, angle):
    turned = multiply(m, AxisAngle(axis, angle).rotation())
    assert abs(turn_between(m, turned) - angle) < 1e-8
    assert abs(turn_between(turned, m) - angle) < 1e-8


# Functions of numbers of any kind, and formulas on dual numbers, which give derivatives.


@every_row("quarters", range(-5, 6))
@every_row("off", [0.0, QUARTER_TOLERANCE_RAD / 2, -QUARTER_TOLERANCE_RAD / 2])
def test_whole_quarter_turns_are_exact(quarters, off):
    cosine, sine = cos_sin(quarters * math.pi / 2 + off)
    assert {abs(cosine), abs(sine)} == {0.0, 1.0}
    assert (cosine, sine) == pytest.approx(
        (math.cos(quarters * math.pi / 2), math.sin(quarters * math.pi / 2)), abs=1e-12
    )
