"""Anything that is not a frame, a number or an angle is refused, in the same words everywhere."""

import math
from dataclasses import replace

import pytest
from amounts import every_row
from chain_cases import gap
from hypothesis import example, given
from hypothesis import strategies as st
from kinematics_cases import MINI, TEACHMOVER

from kinematics import (
    SYSTEMS,
    BadNumber,
    Chain,
    DHLink,
    Guards,
    JointAxis,
    Joints,
    KinematicsError,
    Motors,
    NotARotation,
    Pose,
    a_matrix,
    assign_frames,
    check_transform,
    condition,
    frame_goal,
    invert,
    preset,
    rot_x,
    rot_y,
    rot_z,
    solve_euler,
    solve_frame_ik,
    solve_rpy,
    subject_of_chain,
    system,
    transform,
    translation,
    urdf_of_chain,
    work,
)
from kinematics.chains.arm import ChainArm
from kinematics.chains.inverse import solve_goal
from kinematics.chains.links import JointKind
from kinematics.chains.urdf import read_urdf
from kinematics.frames.orientations import RPY
from kinematics.frames.rotations import IDENTITY
from kinematics.frames.transforms import IN_PLACE, position_of
from kinematics.frames.user_frame import UserFrame
from kinematics.guards.shapes import Box
from kinematics.limits import wrap
from kinematics.textbook.efficiency import Ledger
from kinematics.textbook.systems import MODEL_NAMES
from kinematics.textbook.systems.mini_movers import arm_of
from kinematics.textbook.worked_example import example_posture

LINKS = (DHLink(a_mm=100.0), DHLink(a_mm=80.0))
OWN = subject_of_chain("", "", "", Chain(LINKS))
SLIDE = DHLink(kind=JointKind.PRISMATIC)
HOME = Joints.of(0, 40, -60, -70, 0)
A_POSE = Pose.of(x_mm=250, y_mm=0, z_mm=120, pitch_deg=-90)
AT_HOME = TEACHMOVER.fk(HOME)
ORIGIN = (0.0, 0.0, 0.0)
CABLES = preset("teachmover").transmission
TURNED_ROUND = Joints(HOME.angles_rad[::-1], HOME.names[::-1])
"""The same posture with its joints in another order."""


AXES = (JointAxis((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)),)

TAKE_A_FRAME = {
    "check_transform": check_transform,
    "invert": invert,
    "transform": lambda frame: transform(*parts_of(frame)),
    "Chain.base": lambda frame: Chain(LINKS, base=frame),
    "Chain.tool": lambda frame: Chain(LINKS, tool=frame),
    "assign_frames": lambda frame: assign_frames(AXES, frame),
    "frame_goal": frame_goal,
    "solve_frame_ik": lambda frame: solve_frame_ik(Chain(LINKS), frame),
    **{f"goal_of of {name}": one.goal_of for name, one in SYSTEMS.items()},
}


def parts_of(frame):
    """Rotation and position as `transform` takes them; of another shape, the thing itself."""
    rows = frame[:3] if isinstance(frame, tuple) and len(frame) == 4 else ()
    if not rows or frame[3] != IN_PLACE[3] or any(len(row) != 4 for row in rows):
        check_transform(frame)
    return tuple(row[:3] for row in rows), tuple(row[3] for row in rows)


def placed(*entries, x=0.0):
    """The frame in place with some entries (row, column, value) changed."""
    rows = [list(row) for row in IN_PLACE]
    rows[0][3] = x
    for row, column, value in entries:
        rows[row][column] = value
    return tuple(map(tuple, rows))


NO_FRAMES = {
    "nothing": (None, KinematicsError, "4 rows of 4 numbers are needed, not None"),
    "text": ("none", KinematicsError, "4 rows of 4 numbers are needed, not 'none'"),
    "short rows": (tuple(row[:3] for row in IN_PLACE), KinematicsError, "4 rows of 4 numbers"),
    "another last row": (placed((3, 3, 2.0)), KinematicsError, "last row of a homogeneous"),
    "text in a row": (placed((0, 0, "1")), BadNumber, "row 1, x must be a finite number, not '1'"),
    "infinite": (placed((2, 2, math.inf)), BadNumber, "row 3, z must be a finite number, not inf"),
    "no position": (placed((1, 3, math.nan)), BadNumber, "y_mm of a position must be a finite"),
    "stretched": (placed((2, 2, 2.0)), NotARotation, "column z has length 2 instead of 1"),
    "slanted": (
        placed((0, 1, 0.6), (1, 1, 0.8)),
        NotARotation,
        "columns x and y stand at 53.1301024° instead of 90°",
    ),
    "mirrored": (placed((2, 2, -1.0)), NotARotation, "the determinant is -1 instead of 1"),
}


@every_row("name", TAKE_A_FRAME)
def test_what_is_no_frame_is_refused_in_the_same_words(name):
    for kind, (frame, error, says) in NO_FRAMES.items():
        with pytest.raises(KinematicsError) as caught:
            TAKE_A_FRAME[name](frame)
        assert type(caught.value) is error, kind
        assert says in str(caught.value), kind


PUMA = SYSTEMS["puma"]


MADE_OF_A_NUMBER = {
    "rot_x": rot_x,
    "rot_y": rot_y,
    "rot_z": rot_z,
    "a_matrix, theta": lambda value: a_matrix(value, 0.0, 0.0, 0.0),
    "a_matrix, d": lambda value: a_matrix(0.0, value, 0.0, 0.0),
    "a_matrix, a": lambda value: a_matrix(0.0, 0.0, value, 0.0),
    "a_matrix, alpha": lambda value: a_matrix(0.0, 0.0, 0.0, value),
    "a turning link": DHLink().matrix,
    "a sliding link": DHLink(kind=JointKind.PRISMATIC).matrix,
    "translation": lambda value: translation(0.0, value, 0.0),
    "a frame on the bench": lambda value: UserFrame.turned((0.0, 0.0, 0.0), value),
    "phi held in RPY": lambda value: solve_rpy(IDENTITY, value),
    "phi held in Euler's angles": lambda value: solve_euler(IDENTITY, value),
}


@every_row("make", MADE_OF_A_NUMBER.values(), ids=MADE_OF_A_NUMBER)
@every_row("value", [math.nan, math.inf, "1", None, True])
def test_no_matrix_is_made_of_what_is_no_finite_number(make, value):
    with pytest.raises(BadNumber, match="must be a finite number"):
        make(value)


@every_row(
    "make, says",
    [
        (lambda: Chain(()), "at least one link"),
        (lambda: Chain((1.0,)), "a link must be of the class DHLink, not 1.0"),
        (lambda: Chain(LINKS, "craig"), "convention must be of the class Convention"),
        (lambda: assign_frames(()), "at least one joint axis"),
        (lambda: assign_frames(((0.0, 0.0, 1.0),)), "an axis must be of the class JointAxis"),
        (lambda: DHLink(a_mm="1"), "a_mm must be a finite number"),
        (lambda: Chain(LINKS).within(((0.0, 1.0),)), "2 pairs, lowest and highest value"),
        (lambda: PUMA.sized(1.0), "the lengths of puma are d1, a1"),
        (lambda: PUMA.sized(height=3.0), "the lengths of puma are d1, a1"),
        (lambda: PUMA.ik((1.0,) * 7), r"6 numbers \(x"),
        (lambda: PUMA.ik((*(1.0,) * 5, math.nan)), "psi.* must be a finite number"),
        (lambda: SYSTEMS["minimover5"].ik((250, 0, 120, -90.0, 0)),
         r"pitch_rad of a goal of minimover5 must be within two turns.*math.radians\(-90\)"),
        (lambda: system([]), "no system is named"),
        (lambda: Joints(None), "joint angles are a list of numbers, not None"),
        (lambda: Joints.of(0, 40, "x", 0, 0), r"angles_deg\[2\] must be a finite number"),
        (lambda: HOME.replace(base_degrees=3), "no joint is named 'base_degrees'.*'base_deg'"),
        (lambda: HOME.replace(sholder_deg=3), r"did you mean 'shoulder_deg'\?$"),
        (lambda: A_POSE.replace(z=3), "no coordinate is named 'z'; a pose has x_mm, .*'z_mm'"),
        (lambda: A_POSE.replace(pitch_rad=3), r"; write pitch_deg=math.degrees\(\.\.\.\)"),
        (lambda: A_POSE.replace(roll_deg=999), "roll_deg must be within two turns, 720° either"),
        (lambda: HOME["sholder"], r"did you mean 'shoulder'\?$"),
        (lambda: TEACHMOVER.fk(TURNED_ROUND), "joints of this arm are base, .* not wrist_roll, "),
        (lambda: Motors((1, 2.0)), "motor 2 steps must be a whole number, not 2.0"),
        (lambda: TEACHMOVER.fk((0.0,) * 5), "joints must be of the class Joints"),
        (lambda: TEACHMOVER.ik(None), "a pose must be of the class Pose"),
        (lambda: TEACHMOVER.ik(replace(AT_HOME, yaw_rad=0.1)), "cannot take a yaw"),
        (lambda: MINI.ik(replace(AT_HOME, yaw_rad=0.1)), "cannot take a yaw"),
        (lambda: ChainArm(PUMA.chain()).ik(AT_HOME), "need a yaw: yaw_deg in Python, --yaw"),
        (lambda: ChainArm(None), "a chain must be of the class Chain"),
        (lambda: ChainArm(Chain(MINI.chain.links[:4])), "five or six joints, not 4"),
        (lambda: ChainArm(Chain((DHLink(),) * 5)), "no limits"),
        (lambda: solve_goal(Chain(LINKS), IN_PLACE), "a goal must be of the class Goal"),
        (lambda: solve_goal(LINKS, frame_goal(IN_PLACE)), "a chain must be of the class Chain"),
        (lambda: RPY("1", 0.0, 0.0), "phi_rad must be a finite number"),
        (lambda: work(OWN, goal=1.0), "a goal is x, y, z, or"),
        (lambda: read_urdf(b"<robot/>"), "the URDF must be of the class str"),
        (lambda: urdf_of_chain(Chain((SLIDE,))), "slides without limits"),
        (lambda: urdf_of_chain(Chain((DHLink(),), joint_names=("tool_joint",))), "fixed joint of"),
        (lambda: urdf_of_chain(Chain((DHLink(Ledger().number(0.1)),))), "not of symbols"),
        (lambda: replace(SLIDE, low=3.0, high=2.0), r"low limit \(3 mm\).*\(2 mm\)"),
        (lambda: Chain(LINKS, joint_names=("a", "a")), "2 different joint names"),
        (lambda: condition(Chain(LINKS), (0.1, 0.2), rows=(0, 6)), "numbered 0 to 5"),
        (lambda: frame_goal(IN_PLACE, frozenset()), "asks at least one of position, heading"),
        (lambda: replace(TEACHMOVER, upper_arm_mm=0), "longer than 0"),
        (lambda: replace(TEACHMOVER, limits=TEACHMOVER.limits[:4]), "4 were given"),
        (lambda: CABLES.to_joints(Motors((0,) * 5)), "6 motors were expected, not 5"),
        (lambda: CABLES.with_signs(motors=(1, 0, 1, 1, 1, 1)), "6 motor signs"),
        (lambda: assign_frames([JointAxis((0, 1e300, 0), (0, 0, 1))]),
         r"\(0.0, 1e\+300, 0.0\) is no point of an arm"),
        (lambda: assign_frames([JointAxis((math.nan, 0, 0), (0, 0, 1))]),
         "an axis' point.* must be a finite number"),
        (lambda: UserFrame.through(ORIGIN, (9.0, 0.0, 0.0), (90.0, 0.0, 0.0)), "three points"),
        (lambda: Guards(radii_mm=(30.0, 20.0)).violations(TEACHMOVER, HOME),
         "each of upper arm, forearm, hand: 3, not 2"),
        (lambda: Box("vice", (0, 0, 5), (1, 1, 5)), "needs a z of min_mm below"),
        (lambda: arm_of(PUMA), "puma is no arm of the Mini-mover's build"),
    ],
)  # fmt: skip
def test_what_cannot_be_meant_is_refused_in_words(make, says):
    with pytest.raises(KinematicsError, match=says) as refusal:
        make()
    if "must be a finite number" in says:
        assert isinstance(refusal.value, BadNumber)


# Angles of many turns.

PI_DIGITS = 3_141592653589793238462643383279502884197169399375105820974944592307816406286
"""Pi with 75 decimals, as a whole number."""


def exactly_wrapped(angle):
    """The rest of an angle after whole turns, by whole numbers of 75 decimals."""
    scale = 10**75
    over, under = angle.as_integer_ratio()
    turn = 2 * PI_DIGITS
    rest = (over * scale // under + turn // 2) % turn - turn // 2
    return rest / scale


@given(st.floats(-1e15, 1e15))
@example(math.pi)
@example(-math.pi)
@example(3 * math.pi)
def test_an_angle_of_any_turns_is_wrapped_to_the_last_digit(angle):
    wrapped = wrap(angle)
    assert -math.pi < wrapped <= math.pi
    assert abs(math.remainder(wrapped - exactly_wrapped(angle), math.tau)) < 1e-15
    assert math.sin(wrapped) == pytest.approx(math.sin(angle), abs=1e-15)
    assert math.cos(wrapped) == pytest.approx(math.cos(angle), abs=1e-15)


@every_row("name", MODEL_NAMES)
@every_row("turns", [1e3, 1e8, -1e12])
def test_joint_values_of_many_turns_lose_no_digits(name, turns):
    """The tip stands where the angle's exact rest puts it, and is found again near such a seed."""
    one = system(name)
    kinds = one.chain().kinds
    plain = example_posture(one.chain())
    turned = tuple(
        value + turns * math.tau if kind is JointKind.REVOLUTE else value
        for value, kind in zip(plain, kinds, strict=True)
    )
    exact = tuple(
        exactly_wrapped(value) if kind is JointKind.REVOLUTE else value
        for value, kind in zip(turned, kinds, strict=True)
    )
    assert gap(one.fk(turned), one.fk(exact)) < 1e-9
    goal = one.goal_of(one.fk(plain))
    for branch in one.ik(goal, turned):
        assert one.goal_of(one.fk(branch.joints)) == pytest.approx(goal, abs=1e-6)


# The base axis.


ON_THE_AXIS = {
    "minimover5": (550.0, 1.0, 0.2),
    "alpha2": (600.0, 1.0, 0.2),
    "alpha2-lecture": (600.0, 1.0, 0.2),
    "cylindrical": (90.0,),
    "spherical": (50.0,),
    "revolute": (450.0,),
    "two-link-2": (350.0,),
    "two-link-3": (),
}
"""Systems whose tip can be over the base, and the rest of such a goal."""


@every_row(
    "name, off_mm",
    [
        (name, off_mm)
        for name in ON_THE_AXIS
        for off_mm in (0.0, 1e-9, -9e-7, 2e-6, 1e-3)
        if name != "two-link-2" or off_mm < 1e-3  # there its tip would leave the sphere
    ],
)
def test_every_system_reaches_over_its_base_whatever_rounding_leaves_beside_it(name, off_mm):
    one = system(name)
    for x_mm, y_mm in ((off_mm, 0.0), (0.0, off_mm)):
        goal = (x_mm, y_mm, *ON_THE_AXIS[name])
        found = one.ik(goal)
        assert found
        for branch in found:
            x, y, z = position_of(one.fk(branch.joints))
            assert math.hypot(x - x_mm, y - y_mm) < 2e-6
            assert z == pytest.approx((*ON_THE_AXIS[name], z)[0], abs=1e-6)


def test_a_joint_of_any_unit_is_the_same_joint():
    turned = HOME.replace(base_deg=3)
    assert turned == HOME.replace(base=math.radians(3)) == HOME.replace(base_rad=math.radians(3))
    assert turned == Joints.of(3, 40, -60, -70, 0)
    assert turned["base"] == turned["base_rad"] == turned.base_rad == turned[0]
    assert turned["base_deg"] == turned.base_deg == pytest.approx(3.0)
    assert A_POSE.replace(pitch_deg=-45.0, z_mm=80.0).pitch_rad == pytest.approx(-math.pi / 4)
