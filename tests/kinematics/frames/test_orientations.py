"""Three angles, axis and angle, quaternions: each both ways, and every degenerate case by name."""

import math
from importlib import import_module
from importlib.util import find_spec

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
    NotARotation,
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
from kinematics.frames.rotations import IDENTITY, multiply, rot_x, rot_y, rot_z, rotate, transpose
from kinematics.frames.vectors import X_AXIS, Z_AXIS, norm, scale

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


@every_row("sign", [1, -1])
def test_the_named_sum_or_difference_is_what_remains_determined(sign):
    """The words of each degeneracy are true: the other combination changes nothing."""
    cases = {
        Degeneracy.X_AXIS_DOWN: (RPY, math.pi / 2, 1),
        Degeneracy.X_AXIS_UP: (RPY, -math.pi / 2, -1),
        Degeneracy.NO_TILT: (EulerZYZ, 0.0, -1),
        Degeneracy.FULL_TILT: (EulerZYZ, math.pi, 1),
    }
    for degeneracy, (kind, theta, free) in cases.items():
        first = kind(0.2, theta, 0.5).rotation()
        second = kind(0.2 + 0.7, theta, 0.5 + sign * 0.7).rotation()
        assert (gap(first, second) < 1e-15) == (sign == free)
        assert f"only phi {'-' if free == 1 else '+'} psi is" in degeneracy.value


def test_the_axis_points_where_the_names_say():
    assert rotate(rot_y(math.pi / 2), X_AXIS)[2] == -1.0
    assert rotate(rot_y(-math.pi / 2), X_AXIS)[2] == 1.0


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


@given(directed, any_angle)
def test_the_axis_stays_in_place(axis, angle):
    turn = AxisAngle(axis, angle)
    assert gap(rotate(turn.rotation(), turn.axis), turn.axis) < 1e-14


@pytest.mark.parametrize(
    ("rot", "axis"), [(rot_x, (1, 0, 0)), (rot_y, (0, 1, 0)), (rot_z, (0, 0, 1))]
)
@given(angle=any_angle)
def test_turns_about_the_three_axes_are_the_fundamental_rotations(rot, axis, angle):
    assert gap(AxisAngle(axis, angle).rotation(), rot(angle)) < 1e-15


@given(directed)
def test_half_a_turn_has_two_axes(axis):
    made = AxisAngle(axis, math.pi)
    solved = solve_axis_angle(made.rotation())
    assert solved.degeneracy is Degeneracy.HALF_TURN
    assert solved.first.angle_rad == solved.second.angle_rad == math.pi
    assert gap(solved.first.rotation(), made.rotation()) < 1e-9
    assert gap(solved.second.rotation(), made.rotation()) < 1e-9
    vector = rotation_vector(made.rotation())
    assert norm(vector) == pytest.approx(math.pi, abs=1e-8)
    assert gap(AxisAngle(vector, math.pi).rotation(), made.rotation()) < 1e-8
    assert min(gap(made.axis, solved.first.axis), gap(made.axis, solved.second.axis)) < 1e-9
    quaternions = solve_quaternion(made.rotation())
    assert quaternions.degeneracy is Degeneracy.HALF_TURN
    assert next(part for part in quaternions.first.vector if abs(part) > 1e-9) > 0.0


def test_no_turn_has_any_axis():
    solved = solve_axis_angle(IDENTITY)
    assert solved.degeneracy is Degeneracy.NO_TURN
    assert (solved.first, solved.second) == (AxisAngle(Z_AXIS, 0.0), None)
    assert rotation_vector(IDENTITY) == (0.0, 0.0, 0.0)


def test_the_smallest_turns_keep_their_digits():
    assert rotation_vector(rot_z(3e-12)) == pytest.approx((0.0, 0.0, 3e-12), abs=1e-25)


@given(rotations, rotations)
def test_quaternions_multiply_and_turn_like_their_matrices(a, b):
    p, q = quaternion_of(a), quaternion_of(b)
    assert gap((p * q).rotation(), multiply(a, b)) < 1e-14
    assert gap(p.inverse().rotation(), transpose(a)) < 1e-14
    assert gap((-p).rotation(), a) < 1e-14


@given(rotations)
def test_the_first_quaternion_has_no_negative_scalar(m):
    solved = solve_quaternion(m)
    assert solved.first.w >= -1e-9
    assert solved.second == -solved.first


@given(rotations, directed, st.floats(0.0, math.pi))
def test_the_turn_between_two_rotations_is_the_one_that_was_made(m, axis, angle):
    turned = multiply(m, AxisAngle(axis, angle).rotation())
    assert abs(turn_between(m, turned) - angle) < 1e-8
    assert abs(turn_between(turned, m) - angle) < 1e-8


def test_long_products_do_not_drift():
    step = quaternion_of(AxisAngle((1.0, 2.0, 3.0), 0.1).rotation())
    product = Quaternion(1.0, 0.0, 0.0, 0.0)
    for _ in range(2000):
        product *= step
    made = AxisAngle((1.0, 2.0, 3.0), 200.0)
    assert gap(product.rotation(), made.rotation()) < 1e-12


@every_solver
def test_what_is_no_rotation_is_not_solved(solve):
    with pytest.raises(NotARotation):
        solve(((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, -1.0)))


def test_four_numbers_of_any_length_make_a_quaternion_of_length_1_but_for_zeros():
    assert Quaternion(2.0, 0.0, 0.0, 0.0) == Quaternion(1.0, 0.0, 0.0, 0.0)
    with pytest.raises(ZeroVector):
        Quaternion(0.0, 0.0, 0.0, 0.0)
    with pytest.raises(ZeroVector):
        AxisAngle((0.0, 0.0, 0.0), 1.0)


@pytest.mark.skipif(find_spec("scipy") is None, reason="scipy, the oracle, is not installed")
@given(matrix=rotations)
def test_scipy_finds_the_same_answers(matrix):
    spatial = import_module("scipy.spatial.transform")
    theirs = spatial.Rotation.from_matrix(matrix)
    x, y, z, w = theirs.as_quat(canonical=True)
    ours = solve_quaternion(matrix)
    if ours.degeneracy is None:
        assert gap((ours.first.w, *ours.first.vector), (w, x, y, z)) < 1e-9
        assert gap(rotation_vector(matrix), tuple(theirs.as_rotvec())) < 1e-8
    rpy = solve_rpy(matrix)
    if rpy.degeneracy is None:
        psi, theta, phi = theirs.as_euler("xyz")
        assert gap(RPY(phi, theta, psi).rotation(), rpy.first.rotation()) < 1e-12
