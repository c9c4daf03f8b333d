"""The URDF text of an arm means the same arm, to its own reader and to other tools."""

import math
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from kinematics_cases import TEACHMOVER, postures

from kinematics.chains.chain import Chain
from kinematics.chains.links import Convention, DHLink, JointKind
from kinematics.chains.urdf import urdf_of_chain
from kinematics.errors import KinematicsError
from kinematics.frames.rotations import multiply, rot_x, rot_y, rot_z
from kinematics.frames.transforms import compose, transform
from kinematics.textbook.efficiency import Ledger
from kinematics.textbook.systems import SYSTEMS
from kinematics.textbook.systems.mini_movers import urdf_of_arm

SLIDE = {"kind": JointKind.PRISMATIC, "low": -200.0, "high": 200.0}


def numbers(text):
    return [float(word) for word in text.split()]


def fk_of_urdf(text, values):
    """Read a URDF chain as its specification says: origin first, then the joint's motion."""
    robot = ET.fromstring(text)
    frame, parent = transform(rot_x(0.0), (0.0, 0.0, 0.0)), "base_link"
    joints = {joint.find("parent").get("link"): joint for joint in robot.findall("joint")}
    rest = list(values)
    while parent in joints:
        joint = joints[parent]
        origin = joint.find("origin")
        if origin is not None:
            roll, pitch, yaw = numbers(origin.get("rpy"))
            place = tuple(1000.0 * one for one in numbers(origin.get("xyz")))
            turn = multiply(rot_z(yaw), rot_y(pitch), rot_x(roll))
            frame = compose(frame, transform(turn, place))
        if joint.get("type") == "prismatic":
            frame = compose(frame, transform(rot_x(0.0), (0.0, 0.0, rest.pop(0))))
        elif joint.get("type") != "fixed":
            frame = compose(frame, transform(rot_z(rest.pop(0)), (0.0, 0.0, 0.0)))
        parent = joint.find("child").get("link")
    assert parent == "tool"
    assert not rest
    return frame


def assert_same(frame, expected, mm=1e-6):
    for ours, theirs in zip(frame, expected, strict=True):
        assert ours == pytest.approx(theirs, abs=mm)


quarter = st.sampled_from((-math.pi / 2, 0.0, math.pi / 2)) | st.floats(-3.0, 3.0)
link_rows = st.builds(
    lambda theta, d, a, alpha, extra: DHLink(theta, d, a, alpha, **extra),
    quarter,
    st.floats(-300.0, 300.0),
    st.floats(-300.0, 300.0),
    quarter,
    st.sampled_from(({}, {"low": -2.0, "high": 1.0, "offset": 0.3}, SLIDE)),
)


@given(st.lists(link_rows, min_size=1, max_size=6), st.sampled_from(Convention), st.data())
def test_any_chain_s_text_holds_its_forward_kinematics(links, convention, data):
    stand = transform(multiply(rot_z(0.4), rot_y(-math.pi / 2)), (10.0, -20.0, 30.0))
    chain = Chain(tuple(links), convention, base=stand, tool=transform(rot_x(1.1), (5.0, 0.0, 7.0)))
    values = data.draw(st.tuples(*[st.floats(-3.0, 3.0)] * len(links)))
    assert_same(fk_of_urdf(urdf_of_chain(chain), values), chain.fk(values), mm=1e-5)


@given(postures(TEACHMOVER))
def test_an_arm_s_text_holds_its_hand_s_frame(joints):
    text = urdf_of_arm(TEACHMOVER)
    assert_same(fk_of_urdf(text, joints), TEACHMOVER.transform(joints))


def test_limits_and_names_are_written():
    robot = ET.fromstring(urdf_of_arm(TEACHMOVER, name="a & b", speeds_rad_s=(0.37,) * 5))
    assert robot.get("name") == "a & b"
    elbow = robot.find("joint[@name='elbow']")
    limit = elbow.find("limit")
    assert elbow.get("type") == "revolute"
    assert math.degrees(float(limit.get("lower"))) == pytest.approx(-149)
    assert (float(limit.get("upper")), float(limit.get("velocity"))) == (0.0, 0.37)
    assert [link.get("name") for link in robot.findall("link")] == [
        "base_link",
        *(f"link_{number}" for number in range(1, 6)),
        "tool",
    ]


def test_a_sliding_joint_is_in_metres_and_an_endless_one_turns_for_ever():
    chain = Chain((DHLink(**SLIDE), DHLink(a_mm=100.0)), joint_names=("rail", "spin"))
    robot = ET.fromstring(urdf_of_chain(chain))
    limit = robot.find("joint[@name='rail']/limit")
    assert (float(limit.get("lower")), float(limit.get("velocity"))) == (-0.2, 0.1)
    assert robot.find("joint[@name='spin']").get("type") == "continuous"
    assert robot.find("joint[@name='spin']/limit") is None


def test_what_urdf_cannot_say_is_refused():
    with pytest.raises(KinematicsError, match="slides without limits"):
        urdf_of_chain(Chain((DHLink(kind=JointKind.PRISMATIC),)))
    with pytest.raises(KinematicsError, match="fixed joint of the tool"):
        urdf_of_chain(Chain((DHLink(),), joint_names=("tool_joint",)))
    with pytest.raises(KinematicsError, match="not of symbols"):
        urdf_of_chain(Chain((DHLink(theta_rad=Ledger().number(0.1)),)))


def test_links_are_drawn_to_the_next_joint():
    robot = ET.fromstring(urdf_of_arm(TEACHMOVER))
    drawn = {
        link.get("name"): float(link.find("visual/geometry/cylinder").get("length"))
        for link in robot.findall("link")
        if link.find("visual") is not None
    }
    assert sorted(drawn.values()) == pytest.approx([0.0965, 0.1778, 0.1778, 0.1937])


@pytest.mark.parametrize("name", ["minimover5", "alpha2-lecture", "puma"])
def test_pinocchio_reads_the_same_arm(name):
    pinocchio = pytest.importorskip("pinocchio", reason="pinocchio (pip install pin) is not here")
    chain = SYSTEMS[name].chain()
    model = pinocchio.buildModelFromXML(urdf_of_chain(chain))
    data = model.createData()
    values = [0.3, 0.5, -0.7, 0.2, -0.4, 0.6][: len(chain)]
    pinocchio.framesForwardKinematics(model, data, np.array(values))
    found = data.oMf[model.getFrameId("tool")].homogeneous
    found[:3, 3] *= 1000.0
    assert_same(found.tolist(), chain.fk(values))


@pytest.mark.parametrize("name", ["minimover5", "puma"])
def test_yourdfpy_reads_the_same_arm(name, tmp_path):
    yourdfpy = pytest.importorskip("yourdfpy", reason="yourdfpy is not installed")
    chain = SYSTEMS[name].chain()
    path = tmp_path / "arm.urdf"
    path.write_text(urdf_of_chain(chain), encoding="utf-8")
    values = [0.3, 0.5, -0.7, 0.2, -0.4, 0.6][: len(chain)]
    robot = yourdfpy.URDF.load(str(path), build_scene_graph=True, load_meshes=False)
    robot.update_cfg(dict(zip(chain.joint_names, values, strict=True)))
    found = np.array(robot.get_transform("tool", "base_link"))
    found[:3, 3] *= 1000.0
    assert_same(found.tolist(), chain.fk(values))
