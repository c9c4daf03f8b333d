"""URDF text of an arm means the same arm, here and to other tools; what cannot be used is told."""

import math
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from amounts import every_row
from chain_cases import gap
from hypothesis import assume, given
from hypothesis import strategies as st

from kinematics.chains.chain import Chain
from kinematics.chains.links import Convention, DHLink, JointKind
from kinematics.chains.urdf import (
    MOST_CHARACTERS,
    MOST_JOINTS,
    STRAIGHT_RAD,
    read_urdf,
    urdf_of_chain,
)
from kinematics.errors import KinematicsError
from kinematics.frames.rotations import multiply, rot_x, rot_y, rot_z
from kinematics.frames.transforms import IN_PLACE, compose, position_of, transform, translation
from kinematics.textbook.systems import SYSTEMS

SLIDE = {"kind": JointKind.PRISMATIC, "low": -200.0, "high": 200.0}


def numbers(text, without="0 0 0"):
    return tuple(float(word) for word in (text or without).split())


def fk_of_urdf(text, values):
    """The tip's frame as the specification says: of each joint its origin, then its motion."""
    robot = ET.fromstring(text)
    joints = {joint.find("parent").get("link"): joint for joint in robot.findall("joint")}
    (parent,) = joints.keys() - {joint.find("child").get("link") for joint in joints.values()}
    frame, rest = IN_PLACE, list(values)
    while parent in joints:
        joint = joints[parent]
        parent = joint.find("child").get("link")
        for origin in joint.findall("origin"):
            roll, pitch, yaw = numbers(origin.get("rpy"))
            place = tuple(1000.0 * one for one in numbers(origin.get("xyz")))
            frame = compose(
                frame, transform(multiply(rot_z(yaw), rot_y(pitch), rot_x(roll)), place)
            )
        if joint.get("type") != "fixed":
            axis = np.array(numbers(joint.find("axis").get("xyz")))
            axis, value = axis / np.linalg.norm(axis), rest.pop(0)
            slides = joint.get("type") == "prismatic"
            motion = translation(*(value * axis)) if slides else about(axis, value)
            frame = compose(frame, motion)
    assert not rest
    return frame


def about(axis, angle):
    """Rodrigues' formula, in numpy."""
    x, y, z = axis
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turn = np.eye(3) + math.sin(angle) * skew + (1.0 - math.cos(angle)) * skew @ skew
    return transform(tuple(map(tuple, turn.tolist())), (0.0, 0.0, 0.0))


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
    assert gap(fk_of_urdf(urdf_of_chain(chain), values), chain.fk(values)) < 1e-5


def test_a_sliding_joint_is_in_metres_and_an_endless_one_turns_for_ever():
    chain = Chain((DHLink(**SLIDE), DHLink(a_mm=100.0)), joint_names=("rail", "spin"))
    robot = ET.fromstring(urdf_of_chain(chain))
    limit = robot.find("joint[@name='rail']/limit")
    assert (float(limit.get("lower")), float(limit.get("velocity"))) == (-0.2, 0.1)
    assert robot.find("joint[@name='spin']").get("type") == "continuous"
    assert robot.find("joint[@name='spin']/limit") is None


@every_row("name", ["minimover5", "alpha2-lecture", "puma"])
def test_pinocchio_reads_the_same_arm(name):
    pinocchio = pytest.importorskip("pinocchio", reason="pinocchio (pip install pin) is not here")
    chain = SYSTEMS[name].chain()
    model = pinocchio.buildModelFromXML(urdf_of_chain(chain))
    data = model.createData()
    values = [0.3, 0.5, -0.7, 0.2, -0.4, 0.6][: len(chain)]
    pinocchio.framesForwardKinematics(model, data, np.array(values))
    found = data.oMf[model.getFrameId("tool")].homogeneous
    found[:3, 3] *= 1000.0
    assert gap(found.tolist(), chain.fk(values)) < 1e-6


TURNS = '<limit lower="-2" upper="2"/>'


def joint(name, parent, child, kind="revolute", inside=TURNS):
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f"{inside}</joint>"
    )


def urdf(*joints, links="", more=""):
    """Return a document with these joints and the links a, b, c and d, or others."""
    made = "".join(f'<link name="{name}"/>' for name in links.split() or "abcd")
    return f'<robot name="test">{made}{"".join(joints)}{more}</robot>'


def two(inside=TURNS, kind="revolute"):
    """Return a document of two joints, the second of which is the one in question."""
    return urdf(joint("one", "a", "b"), joint("two", "b", "c", kind, inside), links="a b c")


# The same arm: against the specification, written out here, and against other readers.


def text_of(placed):
    words = [[" ".join(map(repr, part)) for part in (xyz, rpy, axis)] for xyz, rpy, axis in placed]
    links = " ".join(f"l{number}" for number in range(len(placed) + 1))
    return urdf(
        *(
            joint(
                f"j{number}",
                f"l{number}",
                f"l{number + 1}",
                inside=f'<origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="{axis}"/>{TURNS}',
            )
            for number, (xyz, rpy, axis) in enumerate(words)
        ),
        links=links,
    )


triples = st.tuples(*[st.floats(-1.0, 1.0)] * 3)
quarters = st.sampled_from((0.0, math.pi / 2, -math.pi / 2, math.pi))
directions = st.sampled_from(
    ((0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (0.0, 1.0, 0.0), (-1.0, 0.0, 0.0))
) | triples.filter(lambda axis: np.linalg.norm(axis) > 0.1)
placings = st.lists(
    st.tuples(
        triples, st.tuples(quarters, quarters, quarters) | st.tuples(*[st.floats(-3, 3)] * 3),
        directions,
    ),
    min_size=1,
    max_size=7,
)  # fmt: skip


@given(placings, st.data())
def test_the_chain_is_the_arm_of_the_specification(placed, data):
    arm = read_urdf(text_of(placed))
    values = data.draw(st.tuples(*[st.floats(-3.0, 3.0)] * len(placed)))
    assume(not any("parallel" in sentence for sentence in arm.unused))
    expected = fk_of_urdf(text_of(placed), values)
    assert gap(arm.chain.fk(values), expected) < 1e-5  # mm; axes may be kilometres apart


SIX = [
    ((0.0, 0.0, 0.12), (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
    ((0.04, 0.0, 0.06), (1.5708, 0.0, 0.0), (0.0, 0.0, -1.0)),
    ((0.0, 0.22, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, -1.0)),
    ((0.1, 0.0, 0.0), (0.0, 1.5708, 0.0), (0.0, 0.0, 1.0)),
    ((0.0, 0.0, 0.12), (0.0, -1.5708, 0.0), (0.0, 0.0, -1.0)),
    ((0.05, 0.0, 0.0), (0.0, 1.5708, 0.0), (0.0, 0.0, 1.0)),
]


@every_row(
    "word, degrees",
    [
        ("1.5708", 90.0),
        ("1.57079", 90.0),  # cut off
        ("1.57", 90.0),
        ("-3.14", -180.0),
        ("0.7854", 45.0),
        ("-0.5236", -30.0),
        ("1.58", math.degrees(1.58)),
        ("0.79", math.degrees(0.79)),  # too short to be sure
        ("1.5709", math.degrees(1.5709)),
        ("1.57e0", math.degrees(1.57)),
        ("0", 0.0),
    ],
)
def test_an_angle_is_read_as_the_one_that_it_rounds(word, degrees):
    arm = read_urdf(two(f'<origin rpy="0 0 {word}"/><axis xyz="0 0 1"/>{TURNS}'))
    frame = arm.chain.fk((0.0, 0.0))
    assert math.remainder(
        math.atan2(frame[1][0], frame[0][0]) - math.radians(degrees), math.tau
    ) == (pytest.approx(0.0, abs=1e-12))
    changed = abs(math.radians(degrees) - float(word)) > 1e-9
    assert any(f"{word} as {degrees:g}°" in sentence for sentence in arm.unused) == changed


@every_row("off", [1e-11, 1e-8, 1e-6, 1e-4, 0.9 * STRAIGHT_RAD])
def test_axes_that_are_meant_to_be_parallel_are_and_the_note_says_so(off):
    rpy = f"{off!r} 0.0 0.0"
    text = two(f'<origin xyz="0.2 0 0" rpy="{rpy}"/><axis xyz="0 0 1"/>{TURNS}').replace(
        TURNS, f'<axis xyz="0 0 1"/>{TURNS}', 1
    )
    arm = read_urdf(text)
    assert arm.chain.links[0].alpha_rad == 0.0
    assert arm.chain.links[0].a_mm == pytest.approx(200.0)
    assert any("taken as parallel" in sentence for sentence in arm.unused)


# Which part of a URDF is the arm.

GRIPPER = (
    joint("one", "a", "b"),
    joint("two", "b", "c"),
    joint("left", "c", "l", "prismatic", '<limit lower="0" upper="0.03"/>'),
    joint("right", "c", "r", "prismatic", '<mimic joint="left"/><limit lower="0" upper="0.03"/>'),
)


@every_row(
    "joints, links, tip, names",
    [
        (GRIPPER, "a b c l r", "c", ("one", "two")),
        ((*GRIPPER, joint("t", "c", "tool0", "fixed")), "a b c l r tool0", "tool0", ("one", "two")),
        ((joint("one", "a", "b"), joint("w", "b", "c", "fixed")), "a b c", "c", ("one",)),
        (
            (
                joint("one", "a", "b"),
                joint("x", "b", "cam", "fixed"),
                joint("y", "b", "f", "fixed"),
            ),
            "a b cam f", "b", ("one",),
        ),
        (
            (joint("x", "a", "cam", "fixed"), joint("one", "a", "b"), joint("two", "b", "c")),
            "a b c cam", "c", ("one", "two"),
        ),
        ((joint("w", "world", "a", "fixed"), joint("one", "a", "b")), "world a b", "b", ("one",)),
        ((joint("x", "a", "tool", "fixed"), joint("one", "a", "b")), "a b tool", "b", ("one",)),
    ],
)  # fmt: skip
def test_the_arm_ends_where_its_joints_branch_or_at_its_tool(joints, links, tip, names):
    arm = read_urdf(urdf(*joints, links=links))
    assert (arm.tip, arm.chain.joint_names) == (tip, names)


def test_another_end_and_another_beginning_can_be_named():
    text = urdf(*GRIPPER, links="a b c l r")
    arm = read_urdf(text, tip="l")
    assert arm.chain.joint_names == ("one", "two", "left")
    assert arm.chain.kinds[-1] is JointKind.PRISMATIC
    assert arm.chain.limits[-1] == (0.0, 30.0)
    assert position_of(arm.chain.fk((0.0, 0.0, 20.0))) == pytest.approx((20.0, 0.0, 0.0))
    assert "right" in arm.unused[0]
    assert read_urdf(text.replace('"c"', '"tool0"'), base="b").tip == "tool0"
    arm = read_urdf(text, base="b", tip="c")
    assert (arm.base, arm.chain.joint_names) == ("b", ("two",))


def test_names_are_made_words_that_calls_can_use():
    arm = read_urdf(
        urdf(joint("Revolute 1", "a", "b"), joint("Revolute-1", "b", "c"), joint("2", "c", "d"))
    )
    assert arm.chain.joint_names == ("Revolute_1", "Revolute_1_", "joint_2")
    assert "joint 'Revolute 1' is called Revolute_1 here" in arm.unused


@every_row(
    "text, said",
    [
        (two(""), "joint 'two' gives no limits"),
        (two('<limit lower="0" upper="0"/>'), "joint 'two' gives no limits"),
        (two('<limit effort="1"/>'), "joint 'two' gives no limits"),
        (two('<limit lower="-1" upper="1"/>', "continuous"), "continuous: URDF ignores its limits"),
        (urdf(*GRIPPER, links="a b c l r"), "joints that are not part of it: left, right"),
        (two(f"{TURNS}<dynamics damping='1'/><dynamics/>"), "<dynamics> (2)"),
        (two(f"{TURNS}<safety_controller/>"), "<safety_controller> (1)"),
        (urdf(joint("j", "a", "b"), links="a b", more="<transmission/>"), "transmissions (1)"),
        (urdf(joint("j", "a", "b"), links="a b", more="<gazebo/><gazebo/>"), "<gazebo> (2)"),
        (
            urdf(joint("j", "a", "b"), links="a b").replace(
                '<link name="a"/>',
                '<link name="a"><inertial/><collision/><visual><geometry><mesh '
                'filename="package://x/a.stl"/></geometry></visual></link>',
            ),
            "mesh files (1), named by package:// paths",
        ),
    ],
)  # fmt: skip
def test_what_is_not_used_is_named(text, said):
    arm = read_urdf(text)
    assert any(said in sentence for sentence in arm.unused)
    if "limits" in said:
        assert arm.chain.limits[1] == (-math.inf, math.inf)


# What is refused.

BOMB = """<!DOCTYPE robot [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">
<!ENTITY c "&b;&b;&b;&b;&b;&b;&b;&b;">]><robot name="&c;"/>"""


@every_row(
    "text, said",
    [
        ("", "not valid XML: no element found"),
        ("<robot>\ud800</robot>", "not valid XML"),
        ("<sdf/>", "outer element is <robot>, not <sdf>"),
        ("<robot/>", "no joint moves, and has none"),
        (BOMB, "declares a document type"),
        (" " * (MOST_CHARACTERS + 1), f"at most {MOST_CHARACTERS} characters"),
        (
            urdf(*(joint(f"j{n}", "a", "b", "fixed") for n in range(MOST_JOINTS + 1))),
            f"at most {MOST_JOINTS} joints",
        ),
        ('<robot xmlns:xacro="x"><xacro:macro name="arm"/></robot>', "is a xacro file"),
        (two('<limit lower="${-pi}" upper="1"/>'), "is a xacro file"),
        (urdf(joint("j", "a", "b", "hinge")), "is of the type 'hinge'"),
        (urdf(joint("", "a", "b")), "a joint without a name"),
        (urdf('<joint name="j" type="fixed"><parent link="a"/></joint>'), "a link '' as its child"),
        (urdf(joint("j", "a", "bb")), "'bb' as its child, which the URDF does not describe"),
        (urdf(joint("j", "a", "b"), joint("j", "b", "c")), "several joints named 'j'"),
        (urdf(links="a b b"), "several links named 'b'"),
        (urdf(joint("j", "a", "b")), "has a, c, d: name one link as base_link"),
        (urdf(joint("j", "a", "b"), joint("k", "a", "b"), links="a b"), "is moved by two joints"),
        (urdf(joint("j", "a", "b"), joint("k", "b", "a"), links="a b"), "and has none"),
        (urdf(joint("j", "a", "b", "fixed"), links="a b"), "no joint from 'a' on that moves"),
        (
            urdf(joint("j", "a", "b"), joint("k", "a", "c"), links="a b c"),
            "branches at link 'a', to 'b', 'c'",
        ),
        (two(kind="floating"), "'two' is floating: an arm's joints turn or slide"),
        (two(f'<mimic joint="one"/>{TURNS}'), "'two' follows joint 'one' (mimic)"),
        (two('<limit lower="2" upper="-2"/>'), "its lower limit 2 is above its upper one -2"),
        (two(f'<axis xyz="0 0 0"/>{TURNS}'), "axis xyz 0 0 0 has no direction"),
        (two(f'<axis xyz="0 1"/>{TURNS}'), "axis xyz has three numbers, not '0 1'"),
        (two(f'<origin xyz="nan 0 0"/>{TURNS}'), "'nan' is not a number"),
        (two(f'<origin xyz="1e400 0 0"/>{TURNS}'), "is not a number"),
        (two(f'<origin rpy="0 1_0 0"/>{TURNS}'), "'1_0' is not a number"),
    ],
    ids=lambda text: text[:24],
)  # fmt: skip
def test_what_describes_no_chain_is_refused_in_a_sentence(text, said):
    with pytest.raises(KinematicsError) as caught:
        read_urdf(text)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


@every_row(
    "named, said",
    [
        ({"tip": "cc"}, "no link 'cc' for tip_link"),
        ({"base": "x"}, "no link 'x' for base_link"),
        ({"base": "c", "tip": "a"}, "no joints lead from link 'c' to link 'a'"),
        ({"base": "a", "tip": "a"}, "no joint between 'a' and 'a' that moves"),
    ],
)
def test_a_link_that_is_not_there_is_named(named, said):
    with pytest.raises(KinematicsError) as caught:
        read_urdf(two(), **named)
    assert said in str(caught.value)


@given(st.data())
def test_a_damaged_document_is_read_or_refused(data):
    text = text_of(SIX)
    start = data.draw(st.integers(0, len(text)))
    end = min(start + data.draw(st.integers(0, 30)), len(text))
    damaged = text[:start] + data.draw(st.text("<>/=\"' az019.e-", max_size=8)) + text[end:]
    try:
        chain = read_urdf(damaged).chain
    except KinematicsError:
        return
    assert all(math.isfinite(entry) for row in chain.fk(chain.zero) for entry in row)
