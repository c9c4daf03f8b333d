"""The model file: a link table or joint axes become a chain, and what is wrong is named."""

import math
import re
import tomllib
from dataclasses import replace

import pytest
from amounts import every_row
from chain_files import (
    five_joints,
    shown_files,
    shown_links,
    six_arm,
    six_joints,
    six_links,
    written,
)
from hypothesis import given
from hypothesis import strategies as st
from pages import blocks, page

from armdrive.arm import Arm
from armdrive.config.arm import remarks_on
from armdrive.config.link_model import parse_model, read_model
from armdrive.config.sections import Connection
from armdrive.connect.parts import connect_simulated
from armdrive.errors import ArmFileError, Refused
from armdrive.registry.arm_files import arm_problems, load_arm
from armdrive.text.reading import parse_toml
from armdrive.trace.files import Recording, header_of
from armdrive.trace.replay import config_of
from kinematics import preset
from kinematics.chains.arm import ChainArm
from kinematics.chains.chain import rows_of
from kinematics.chains.links import Convention, JointKind
from kinematics.frames.transforms import position_of, translation
from kinematics.spaces import Joints
from kinematics.textbook.systems import system


def test_the_shown_file_is_the_alpha_ii_on_a_plinth_with_a_pen():
    model = parse_model(tomllib.loads(shown_links()))
    assert model.name == "alpha2-with-pen"
    assert model.title == "Alpha II with a pen"
    assert model.source == "Asokan, Introduction to Robotics, lecture 2.7"
    assert model.chain.base == translation(0.0, 0.0, 20.0)
    assert model.chain.tool == translation(0.0, 0.0, 35.0)
    theirs = system("alpha2-lecture").chain()
    assert model.chain.joint_names == theirs.joint_names
    for link, other in zip(model.chain.links, theirs.links, strict=True):
        assert (link.d_mm, link.a_mm) == (other.d_mm, other.a_mm)
        assert math.isclose(link.alpha_rad, other.alpha_rad)


def test_omitted_values_are_zero_unlimited_and_named_by_the_file(tmp_path):
    path = tmp_path / "little.toml"
    path.write_text("[[links]]\na_mm = 10\n", encoding="utf-8")
    model = read_model(path)
    assert (model.name, model.title, model.source) == ("little", "little", "")
    assert model.chain.convention is Convention.STANDARD
    assert model.chain.kinds == (JointKind.REVOLUTE,)
    assert model.chain.limits == ((-math.inf, math.inf),)
    assert position_of(model.chain.fk([0.0])) == (10.0, 0.0, 0.0)


@given(
    angles=st.tuples(*[st.floats(-180.0, 180.0)] * 2),
    lengths=st.tuples(*[st.floats(-500.0, 500.0)] * 2),
    convention=st.sampled_from(Convention),
    kind=st.sampled_from(JointKind),
    ends=st.tuples(*[st.floats(0.0, 90.0)] * 3),
)
def test_a_chains_own_rows_make_the_chain_again(angles, lengths, convention, kind, ends):
    row = {"theta_deg": angles[0], "alpha_deg": angles[1], "d_mm": lengths[0], "a_mm": lengths[1]}
    unit = "deg" if kind is JointKind.REVOLUTE else "mm"
    row |= {f"low_{unit}": -ends[0], f"high_{unit}": ends[1], f"offset_{unit}": ends[2]}
    document = {"convention": convention.value, "links": [{**row, "kind": kind.value}]}
    chain = parse_model(document).chain
    again = parse_model({"convention": convention.value, "links": list(rows_of(chain))}).chain
    assert chain.links[0].kind is kind
    assert again.limits[0] == pytest.approx(chain.limits[0], abs=1e-9)
    low, high = (math.degrees(end) if unit == "deg" else end for end in chain.limits[0])
    assert (low, high) == pytest.approx((-ends[0], ends[1]), abs=1e-9)
    for one, other in zip(chain.fk([0.5]), again.fk([0.5]), strict=True):
        assert one == pytest.approx(other, abs=1e-9)


def test_a_base_turned_by_quarters_has_exact_entries():
    document = {"base": {"phi_deg": 90, "psi_deg": -90}, "links": [{"a_mm": 1}]}
    rotation = [row[:3] for row in parse_model(document).chain.base[:3]]
    assert rotation == [(0.0, 0.0, -1.0), (1.0, 0.0, 0.0), (0.0, -1.0, 0.0)]


UP = {"point_mm": [0, 0, 0], "direction": [0, 0, 1]}
SLIDE = {**UP, "kind": "prismatic"}
TIP = {"point_mm": [150, 0, 0]}


def two_axes(**wrong):
    return {"axes": [UP, wrong], "tip": TIP}


@every_row(
    "document, said",
    [
        ({}, "at least one link"),
        ({"links": "many"}, "at least one link"),
        ({"links": [3]}, "links[1] must be a table"),
        ({"links": [{}] * 101}, "at most 100 links, not 101"),
        ({"link": [{}]}, "did you mean 'links'"),
        ({"links": [{}], "convention": "other"}, "convention is one of standard, craig"),
        ({"links": [{}], "name": 5}, "name must be text"),
        ({"links": [{}], "base": {"xmm": 5}}, "did you mean 'x_mm'"),
        ({"links": [{}], "base": {"x_mm": "far"}}, "base.x_mm must be a finite number"),
        ({"links": [{}], "tool": 5}, "tool must be a table"),
        ({"links": [{"theta": 0}]}, "unknown key 'theta' in [links[1]]; did you mean 'theta_deg'?"),
        ({"links": [{"kind": "round"}]}, "links[1].kind is one of revolute, prismatic, not 'round"),
        ({"links": [{"a_mm": "long"}]}, "links[1].a_mm must be a finite number"),
        ({"links": [{"low_mm": 1}]}, "links[1]: a revolute joint has low_deg, not low_mm"),
        ({"links": [{"low_deg": 10, "high_deg": -10}]}, "must not lie above"),
        ({"axes": [], "tip": TIP}, "at least one axis"),
        ({"axes": 3, "tip": TIP}, "axes must be a list"),
        ({"axes": [3], "tip": TIP}, "axes[1] must be a table"),
        ({"axes": [UP] * 101, "tip": TIP}, "at most 100 axes, not 101"),
        ({"axes": [UP]}, "[tip] is missing"),
        ({"tip": TIP}, "at least one axis"),
        ({"axes": [UP], "tip": {}}, "[tip] is missing point_mm"),
        ({"axes": [UP], "tip": {"point_mm": [1, 2]}}, "tip.point_mm must have 3 entries, not 2"),
        ({"axes": [UP], "tip": {**TIP, "aproach": [0, 0, 1]}}, "did you mean 'approach'"),
        ({"axes": [UP], "tip": {**TIP, "approach": [0, 0, 0]}}, "tip: the zero vector"),
        ({"axes": [UP], "tip": {**TIP, "normal": [0, 1, 1]}}, "not at 45°"),
        ({"axes": [UP], "tip": TIP, "links": [{}]}, "a model with [[axes]] has no links"),
        ({"axes": [UP], "tip": TIP, "base": {}}, "a model with [[axes]] has no base"),
        (two_axes(point_mm=[0, 0, 0]), "[axes[2]] is missing direction"),
        (two_axes(**UP | {"direction": [0, 0, 0]}), "axes[2].direction: the zero vector has no"),
        (two_axes(**UP | {"point_mm": [0, "far", 0]}), "axes[2].point_mm[1] must be a finite"),
        (two_axes(**UP | {"point_mm": [0, math.nan, 0]}), "axes[2].point_mm[1] must be a finite"),
        (two_axes(**UP, kind="spherical"), "axes[2].kind is one of revolute, prismatic"),
        (two_axes(**UP, low_mm=3), "axes[2]: a revolute joint has low_deg, not low_mm"),
        (two_axes(**SLIDE, high_deg=3), "axes[2]: a prismatic joint has high_mm, not high_deg"),
        (two_axes(**UP, low_deg=9, high_deg=3), "must not lie above"),
        (two_axes(**UP, name="base"), "unknown key 'name' in [axes[2]]"),
        (two_axes(**UP, joint="joint_1"), "2 different joint names"),
    ],
)
def test_mistakes_in_a_model_file_are_named(document, said):
    with pytest.raises(ArmFileError, match=re.escape(said)):
        parse_model(document)


# A file with joint axes instead of links.


def axes_text():
    (found,) = [text for text in blocks(page("textbook"), "toml") if "[[axes]]" in text]
    return found


def test_the_file_with_axes_of_the_page_is_the_alpha_ii():
    made = parse_model(parse_toml(axes_text(), ArmFileError))
    assert made.title == "Alpha II by its axes"
    rows = rows_of(made.chain)
    assert [(row["d_mm"], row["a_mm"], row["alpha_deg"]) for row in rows] == [
        (215.0, 0.0, -90.0), (0.0, 177.8, 0.0), (0.0, pytest.approx(177.8), 0.0),
        (0.0, 0.0, -90.0), (129.5, 0.0, 0.0),
    ]  # fmt: skip
    assert (rows[0]["low_deg"], rows[0]["high_deg"]) == (-155.0, 155.0)
    assert [axis.name for axis in made.zero.axes] == list(made.chain.joint_names)
    made = parse_model(two_axes(**SLIDE, low_mm=5, high_mm=40) | {"convention": "craig"})
    assert made.chain.convention is Convention.CRAIG
    assert made.chain.joint_names == ("joint_1", "joint_2")
    assert made.chain.limits == ((-math.inf, math.inf), (5.0, 40.0))
    assert position_of(made.chain.fk([0.0, 30.0])) == (150.0, 0.0, 30.0)


# An arm file that names a model file: what it needs, what it means, and what is wrong in it.


def test_the_shown_files_are_the_teachmover(tmp_path):
    config = five_joints(tmp_path)
    theirs = preset("teachmover")
    assert config.title == "TeachMover by its link table"
    assert config.connection == Connection("teachmover", port="/dev/ttyUSB0")
    arm = config.model.arm
    assert isinstance(arm, ChainArm)
    assert arm.joint_names == theirs.arm.joint_names
    for ours, other in zip(arm.limits, theirs.arm.limits, strict=True):
        assert ours.low_rad == pytest.approx(other.low_rad)
        assert ours.high_rad == pytest.approx(other.high_rad)
    assert config.model.reference == theirs.reference
    assert config.model.gripper_range_mm == theirs.gripper_range_mm
    assert config.model.grip_steps_per_n == pytest.approx(theirs.grip_steps_per_n, rel=1e-3)
    for ours, other in zip(
        config.model.transmission.motors, theirs.transmission.motors, strict=True
    ):
        assert ours.steps_per_unit == pytest.approx(other.steps_per_unit)
        assert (ours.name, ours.sees, ours.follows) == (other.name, other.sees, other.follows)


def test_six_joints_home_and_park_with_the_simulated_operator(tmp_path):
    posture = "x_mm = 500\ny_mm = 100\nz_mm = 400\npitch_deg = -80\nyaw_deg = 15\n"
    config = six_joints(tmp_path, f"[reference]\n{posture}")
    with Arm(
        connect_simulated(replace(config, motion=replace(config.motion, planned_burst_s=2.0)))
    ) as arm:
        assert isinstance(arm, Arm)
        arm.home()
        arm.move_j(waist_deg=30)
        arm.park()
        assert math.dist(arm.twin.world.tip, (500, 100, 430)) < 1.0


def test_the_dimensions_behind_the_steps_change_the_fingerprint(tmp_path):
    first = six_joints(tmp_path)
    assert first.calibration == six_joints(tmp_path).calibration
    assert first.calibration == six_joints(tmp_path, "[limits_deg]\nbend = [-90, 90]\n").calibration
    (tmp_path / "six.toml").write_text(six_links(base_height=661.0), encoding="utf-8")
    assert written(tmp_path, six_arm()).calibration != first.calibration


FIRST = '[[motors]]\nname = "waist"\nsteps_per_turn = 14400\nsees = { waist = 1 }\n'
SECOND = "sees = { shoulder = 1 }\n"


IN_ARM = [
    ("model", "lengths = {}\nmodel", "unknown key 'lengths'"),
    ('"six.toml"', '"five.toml"', "five.toml cannot be read"),
    ("waist = 30\n", "", r"speeds_deg_s\] is missing waist"),
    ("waist = 30\n", "waist = 0\n", "speeds_deg_s.waist must be from"),
    ("waist = 30\n", "base = 30\n", "unknown key 'base'"),
    (FIRST, "", "5 motors|needs 6|need 6"),
    (FIRST, FIRST.replace("{ waist = 1 }", "{ wast = 1 }"), "did you mean 'waist'"),
    (FIRST, FIRST.replace("sees = { waist = 1 }\n", ""), "sees no joint"),
    (FIRST, FIRST.replace("14400", "-14400"), "directions are signs in sees"),
    (FIRST, FIRST.replace("steps_per_turn", "steps_per_mm"), "must be the last"),
    (FIRST, FIRST.replace("steps_per_turn = 14400\n", ""), "needs steps_per_turn"),
    (FIRST, FIRST.replace('name = "waist"\n', ""), "needs a name"),
    (FIRST, FIRST.replace('"waist"', '"bend"'), "different names"),
    (FIRST, FIRST + "follows = { bend = 1 }\n", "unknown key 'bend'"),
    (SECOND, SECOND + "follows = { waist = 0.5 }\n", "whole number"),
    (FIRST, FIRST.replace("waist = 1 }", "shoulder = 1 }"), "follow from those of"),
    (FIRST, "[fingers]\nrange_mm = [0, 1]\nspeed_mm_s = 1\n" + FIRST, "no motor has steps_per"),
    (FIRST, "[park]\nx_mm = 1\n" + FIRST, "is missing y_mm"),
    (FIRST, "[guards]\ntable = 0\n" + FIRST, "unknown key 'table'"),
]
IN_MODEL = [
    ("low_deg = -160\n", "", "waist' has no limits"),
    ('joint = "waist"', 'joint = "my waist"', "cannot be called 'my waist'"),
    ('joint = "waist"', 'joint = "opening"', "cannot be called 'opening'"),
    (
        'joint = "waist"\n',
        'joint = "waist"\nkind = "prismatic"\n',
        "prismatic joint has low_mm, not low_deg",
    ),
]
IN_FINGERS = [
    ("[fingers]\nrange_mm = [0, 76]\nspeed_mm_s = 20\nsteps_per_n", "[park]\n#", "fingers"),
    ("range_mm = [0, 76]", "range_mm = [76, 0]", "below the second"),
    ("speed_mm_s = 20", "speed_mm_s = 0", "fingers.speed_mm_s must be"),
]
FILES = {"six": (six_links(), six_arm()), "five": shown_files()}


@every_row(
    "files, old, new, said",
    [("six", *row) for row in (*IN_ARM, *IN_MODEL)] + [("five", *row) for row in IN_FINGERS],
)
def test_mistakes_in_the_arm_file_or_the_urdf_are_named(tmp_path, files, old, new, said):
    links, arm = FILES[files]
    assert (old in links) != (old in arm), "a row changes one of the two files"
    for name in ("six.toml", "minilinks.toml"):
        (tmp_path / name).write_text(links.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(ArmFileError, match=said):
        written(tmp_path, arm.replace(old, new, 1))


def test_every_motor_of_the_controller_must_be_listed(tmp_path):
    links, arm = shown_files()
    (tmp_path / "minilinks.toml").write_text(links, encoding="utf-8")
    gripper = arm[arm.index('[[motors]]\nname = "gripper"') : arm.index("[speeds_deg_s]")]
    config = written(tmp_path, arm.replace(gripper, ""))
    assert not config.model.transmission.has_gripper
    with pytest.raises(Refused, match="5 motors, but its controller drives 6"):
        connect_simulated(config)


def test_a_servo_gripper_has_fingers_without_a_motor(tmp_path):
    fingers = "[fingers]\nrange_mm = [5, 60]\nspeed_mm_s = 40\n"
    config = six_joints(tmp_path, '[gripper]\nkind = "servo"\n' + fingers)
    assert config.model.gripper_range_mm == (5.0, 60.0)
    assert not config.model.transmission.has_gripper
    (tmp_path / "six.toml").write_text("verified = false\n" + six_links(), encoding="utf-8")
    more = "[limits_deg]\nbend = [-50, 60]\n[guards]\nouter_radius_mm = 700\n"
    model = written(tmp_path, six_arm() + more).model
    assert not model.verified
    assert model.arm.limits[4].high_rad == pytest.approx(math.radians(60))
    assert (model.guards.outer_radius_mm, model.guards.inner_radius_mm) == (700, None)


# An arm file that names a URDF: the arm of the how-to page, checked, driven and recorded.


NAMES = ("base", "shoulder", "elbow", "forearm_roll", "wrist_pitch", "wrist_roll")


def shown():
    """Return the URDF and the arm file of the page."""
    (urdf,), (arm,) = (blocks(page("urdf"), kind) for kind in ("xml", "toml"))
    return urdf, arm


@pytest.fixture
def write(tmp_path):
    def written(old="", new="", *, urdf=("", "")):
        """Write the page's files, with some text in the place of other text."""
        text, arm = shown()
        assert old in arm
        assert urdf[0] in text
        (tmp_path / "six.urdf").write_text(text.replace(*urdf, 1), encoding="utf-8")
        path = tmp_path / "six.toml"
        path.write_text(arm.replace(old, new, 1), encoding="utf-8")
        return path

    return written


def problems_of(path):
    return arm_problems(tomllib.loads(path.read_text(encoding="utf-8")), path.stem, path.parent)


def test_names_and_limits_come_from_the_urdf_and_the_arm_file_corrects_them(write):
    config = load_arm(write())
    arm = config.model.arm
    assert arm.joint_names == NAMES
    assert (arm.limits[0].low_rad, arm.limits[0].high_rad) == (-2.9, 2.9)
    assert math.degrees(arm.limits[5].high_rad) == pytest.approx(155)
    assert config.model.notes == "six.urdf, from link base_link to link tool0"
    assert config.title == "printed-six"
    zero = arm.fk(Joints((0.0,) * 6, NAMES))
    assert (zero.x_mm, zero.y_mm, zero.z_mm, zero.pitch_rad) == pytest.approx((390, 0, 400, 0))


def test_a_check_names_what_is_not_used(write):
    remarks = list(remarks_on(load_arm(write())))
    for said in ("fingers", "1.5708 as 90°", "collision shapes (1)", "package:// paths"):
        assert any(said in sentence for sentence in remarks)


def test_the_base_link_may_stand_above_the_table(write):
    plain = load_arm(write()).model.arm
    raised = load_arm(write('tip_link = "tool0"', "height_mm = 35.0")).model.arm
    joints = Joints((0.3, 0.2, -0.4, 0.1, 0.5, 0.0), NAMES)
    assert raised.fk(joints).z_mm == pytest.approx(plain.fk(joints).z_mm + 35.0)


def test_the_hand_s_frame_may_stand_elsewhere_in_its_link(write):
    plain = load_arm(write()).model.arm
    turned = load_arm(
        write('tip_link = "tool0"', 'tip_link = "hand"\nz_mm = 80\npsi_deg = 180')
    ).model.arm
    joints = Joints((0.3, 0.2, -0.4, 0.1, 0.5, 0.0), NAMES)
    one, other = plain.fk(joints), turned.fk(joints)
    assert (one.x_mm, one.y_mm, one.z_mm) == pytest.approx((other.x_mm, other.y_mm, other.z_mm))
    assert other.pitch_rad == pytest.approx(-one.pitch_rad)


@every_row(
    "old, new, said",
    [
        ('tip_link = "tool0"', 'tip_link = "tol0"', "did you mean 'tool0'?"),
        ('tip_link = "tool0"', "tip = 1", "did you mean 'tip_link'?"),
        ('tip_link = "tool0"', "tip_link = 1", "urdf.tip_link must be text"),
        ('tip_link = "tool0"', 'tip_link = "finger"', "joint 'fingers' slides"),
        ('tip_link = "tool0"', 'tip_link = "knuckle"', "'wrist_roll' in [limits_deg]"),
        ('model = "six.urdf"', 'model = "seven.urdf"', "seven.urdf cannot be read"),
        ('model = "six.urdf"', 'model = "six.urdf.xacro"', "six.urdf.xacro cannot be read"),
        ("wrist_roll = [-155, 155]", "", "joint 'wrist_roll' has no limits in its model"),
        ("wrist_roll = 40", "", "[speeds_deg_s] is missing wrist_roll"),
    ],
)
def test_a_wrong_key_is_named(write, old, new, said):
    found = problems_of(write(old, new))
    assert any(said in sentence for sentence in found), found


def test_a_bad_or_huge_urdf_is_one_problem(write):
    (problem,) = problems_of(write(urdf=("</robot>", "")))
    assert "six.urdf: the URDF is not valid XML: no element found" in problem
    path = write(urdf=("</robot>", f"<!-- {'x' * 3_000_000} --></robot>"))
    (problem,) = [each for each in problems_of(path) if "urdf" in each]
    assert "larger than" in problem


def test_a_recording_holds_the_urdf(write, tmp_path):
    config = load_arm(write())
    header = header_of(config, link="bench", why="test", began=(0.0, 0.0))
    (tmp_path / "six.urdf").unlink()
    assert "<robot" in header.model_file
    again = config_of(Recording(header, ()))
    assert again.calibration == config.calibration
    assert again.model.arm == config.model.arm
