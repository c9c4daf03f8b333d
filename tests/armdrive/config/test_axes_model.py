"""A model file with joint axes instead of links: what it makes, and each error named."""

from __future__ import annotations

import math
import re

import pytest
from pages import blocks, page

from armdrive.config.link_model import parse_model, read_model
from armdrive.errors import ArmFileError
from armdrive.text.reading import parse_toml
from kinematics.chains.chain import rows_of
from kinematics.chains.links import Convention, JointKind
from kinematics.frames.transforms import position_of

UP = {"point_mm": [0, 0, 0], "direction": [0, 0, 1]}
SLIDE = {**UP, "kind": "prismatic"}
TIP = {"point_mm": [150, 0, 0]}


def shown_text():
    (found,) = [text for text in blocks(page("textbook"), "toml") if "[[axes]]" in text]
    return found


def model(*axes, tip=TIP, **more):
    return parse_model({"axes": list(axes), "tip": tip, **more})


def test_the_file_of_the_page_is_the_alpha_ii():
    made = parse_model(parse_toml(shown_text(), ArmFileError))
    assert made.title == "Alpha II by its axes"
    rows = rows_of(made.chain)
    assert [(row["d_mm"], row["a_mm"], row["alpha_deg"]) for row in rows] == [
        (215.0, 0.0, -90.0), (0.0, 177.8, 0.0), (0.0, pytest.approx(177.8), 0.0),
        (0.0, 0.0, -90.0), (129.5, 0.0, 0.0),
    ]  # fmt: skip
    assert (rows[0]["low_deg"], rows[0]["high_deg"]) == (-155.0, 155.0)
    assert [axis.name for axis in made.zero.axes] == list(made.chain.joint_names)


def test_what_is_left_out_is_revolute_named_by_its_number_and_without_limits(tmp_path):
    path = tmp_path / "little.toml"
    path.write_text(
        "[[axes]]\npoint_mm = [0, 0, 0]\ndirection = [0, 0, 3]\n[tip]\npoint_mm = [10, 0, 0]\n",
        encoding="utf-8",
    )
    made = read_model(path)
    assert (made.name, made.chain.joint_names) == ("little", ("joint_1",))
    assert made.chain.kinds == (JointKind.REVOLUTE,)
    assert made.chain.limits == ((-math.inf, math.inf),)
    assert made.chain.convention is Convention.STANDARD
    assert position_of(made.chain.fk([math.pi / 2])) == pytest.approx((0.0, 10.0, 0.0))


def test_a_slide_has_limits_in_mm_and_craig_s_frames_are_made():
    made = model(UP, {**SLIDE, "low_mm": 5, "high_mm": 40}, convention="craig")
    assert made.chain.convention is Convention.CRAIG
    assert made.chain.limits[1] == (5.0, 40.0)
    assert position_of(made.chain.fk([0.0, 30.0])) == (150.0, 0.0, 30.0)


@pytest.mark.parametrize(
    ("document", "said"),
    [
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
        ({"axes": [UP], "tip": TIP, "convention": "paul"}, "convention is one of standard, craig"),
    ],
)
def test_what_is_wrong_in_a_file_is_named(document, said):
    with pytest.raises(ArmFileError, match=re.escape(said)):
        parse_model(document)


@pytest.mark.parametrize(
    ("row", "said"),
    [
        ({"point_mm": [0, 0, 0]}, "[axes[2]] is missing direction"),
        ({**UP, "direction": [0, 0, 0]}, "axes[2].direction: the zero vector has no direction"),
        ({**UP, "point_mm": [0, "far", 0]}, "axes[2].point_mm[1] must be a finite number"),
        ({**UP, "point_mm": [0, math.nan, 0]}, "axes[2].point_mm[1] must be a finite number"),
        ({**UP, "kind": "spherical"}, "axes[2].kind is one of revolute, prismatic"),
        ({**UP, "low_mm": 3}, "axes[2]: a revolute joint has low_deg, not low_mm"),
        ({**SLIDE, "high_deg": 3}, "axes[2]: a prismatic joint has high_mm, not high_deg"),
        ({**UP, "low_deg": 9, "high_deg": 3}, "must not lie above"),
        ({**UP, "name": "base"}, "unknown key 'name' in [axes[2]]"),
        ({**UP, "joint": "joint_1"}, "2 different joint names"),
    ],
)
def test_a_wrong_axis_is_named(row, said):
    with pytest.raises(ArmFileError, match=re.escape(said)):
        model(UP, row)
