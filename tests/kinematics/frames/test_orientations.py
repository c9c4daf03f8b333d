"""Three angles, axis and angle, quaternions: each both ways, and every degenerate case by name."""

import math

import pytest
from amounts import every_row
from chain_cases import gap, turn_gap
from frame_cases import any_angle, directed, rotations
from hypothesis import given
from hypothesis import strategies as st

from kinematics import (
    RPY,
    AxisAngle,
    Degeneracy,
    EulerZYZ,
    Quaternion,
    ZeroVector,
    rotation_vector,
    solve_axis_angle,
    solve_euler,
    solve_quaternion,
    solve_rpy,
    turn_between,
)
from kinematics.frames.orientations import quaternion_of
from kinematics.frames.rotations import multiply, transpose
from kinematics.frames.vectors import scale

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
    assert min(turn_gap(angles(answer), angles(made)) for answer in answers) < 1e-8


def angles(answer):
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


@given(st.floats(1e-8, 1e-3), any_angle, any_angle)
def test_close_to_degenerate_the_matrix_is_still_made_again(off, phi, psi):
    for solve, made in (
        (solve_rpy, RPY(phi, math.pi / 2 - off, psi)),
        (solve_euler, EulerZYZ(phi, off, psi)),
    ):
        solved = solve(made.rotation())
        assert solved.degeneracy is None
        assert gap(solved.first.rotation(), made.rotation()) < 1e-14


@given(directed, st.floats(1e-6, math.pi - 1e-6))
def test_axis_and_angle_come_back(axis, angle):
    made = AxisAngle(axis, angle)
    solved = solve_axis_angle(made.rotation())
    assert abs(solved.first.angle_rad - angle) < 1e-9
    assert gap(solved.first.axis, made.axis) < 1e-9
    assert solved.second.angle_rad == -solved.first.angle_rad
    assert gap(solved.second.axis, scale(-1.0, solved.first.axis)) < 1e-15
    assert gap(rotation_vector(made.rotation()), scale(angle, made.axis)) < 1e-8


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


def test_four_numbers_of_any_length_make_a_quaternion_of_length_1_but_for_zeros():
    assert Quaternion(2.0, 0.0, 0.0, 0.0) == Quaternion(1.0, 0.0, 0.0, 0.0)
    with pytest.raises(ZeroVector):
        Quaternion(0.0, 0.0, 0.0, 0.0)
    with pytest.raises(ZeroVector):
        AxisAngle((0.0, 0.0, 0.0), 1.0)
