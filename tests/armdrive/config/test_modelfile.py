"""The model file: a link table or joint axes become a chain, and what is wrong is named."""

from __future__ import annotations

import math
import re
import tomllib

import pytest
from chain_files import shown_links
from hypothesis import given
from hypothesis import strategies as st
from pages import blocks, page

from armdrive.config.link_model import parse_model, read_model
from armdrive.config.sections import is_model_file
from armdrive.errors import ArmFileError
from armdrive.text.reading import parse_toml
from kinematics.chains.chain import rows_of
from kinematics.chains.links import Convention, JointKind
from kinematics.frames.transforms import position_of, translation
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


def test_the_shown_file_shows_every_key():
    shown = tomllib.loads(shown_links())
    assert set(shown) == {
        "format", "name", "title", "source", "verified", "convention", "base", "tool", "links",
    }  # fmt: skip
    assert set(shown["base"]) == {"x_mm", "y_mm", "z_mm", "phi_deg", "theta_deg", "psi_deg"}
    assert set(shown["links"][0]) == {
        "joint", "kind", "theta_deg", "d_mm", "a_mm", "alpha_deg", "offset_deg", "low_deg",
        "high_deg",
    }  # fmt: skip


def test_what_is_left_out_is_zero_without_limits_and_named_by_the_file(tmp_path):
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
)
def test_a_chains_own_rows_make_the_chain_again(angles, lengths, convention, kind):
    row = {"theta_deg": angles[0], "alpha_deg": angles[1], "d_mm": lengths[0], "a_mm": lengths[1]}
    document = {"convention": convention.value, "links": [{**row, "kind": kind.value}]}
    chain = parse_model(document).chain
    again = parse_model({"convention": convention.value, "links": list(rows_of(chain))}).chain
    assert chain.links[0].kind is kind
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


@pytest.mark.parametrize(
    ("document", "said"),
    [
        ({}, "at least one link"),
        ({"links": "many"}, "at least one link"),
        ({"links": [3]}, "links[1] must be a table"),
        ({"link": [{}]}, "did you mean 'links'"),
        ({"links": [{}], "convention": "other"}, "convention is one of standard, craig"),
        ({"links": [{}], "name": 5}, "name must be text"),
        ({"links": [{}], "base": {"xmm": 5}}, "did you mean 'x_mm'"),
        ({"links": [{}], "base": {"x_mm": "far"}}, "base.x_mm must be a finite number"),
        ({"links": [{}], "tool": 5}, "tool must be a table"),
        ({"links": [{"theta": 0}]}, "unknown key 'theta' in [links[1]]; did you mean 'theta_deg'?"),
        ({"links": [{"kind": "round"}]}, "links[1].kind is one of revolute, prismatic, not 'round"),
        ({"links": [{"a_mm": "long"}]}, "links[1].a_mm must be a finite number"),
        ({"links": [{"low_mm": 1}]}, "links[1]: a revolute joint has no 'low_mm'"),
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
def test_what_is_wrong_in_a_file_is_named(document, said):
    with pytest.raises(ArmFileError, match=re.escape(said)):
        parse_model(document)


def test_a_file_that_cannot_be_read_or_parsed_is_named(tmp_path):
    with pytest.raises(ArmFileError, match=r"nowhere\.toml cannot be read"):
        read_model(tmp_path / "nowhere.toml")
    broken = tmp_path / "broken.toml"
    broken.write_text("[[links]\n", encoding="utf-8")
    with pytest.raises(ArmFileError, match=r"broken\.toml is not valid TOML"):
        read_model(broken)
    broken.write_bytes(b"\xff\xfe")
    with pytest.raises(ArmFileError, match=r"broken\.toml is not UTF-8 text"):
        read_model(broken)
    broken.write_text("[[links]]\nalfa_deg = 3\n", encoding="utf-8")
    with pytest.raises(ArmFileError, match=r"broken.toml: .*links\[1\].*'alpha_deg'"):
        read_model(broken)


def test_files_are_told_from_names_by_their_ending():
    assert is_model_file("arm.toml")
    assert is_model_file("/home/me/ARM.TOML")
    assert not is_model_file("puma")


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


def test_what_is_left_out_of_an_axis_is_revolute_named_by_its_number_and_without_limits(tmp_path):
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
    made = parse_model(two_axes(**SLIDE, low_mm=5, high_mm=40) | {"convention": "craig"})
    assert made.chain.convention is Convention.CRAIG
    assert made.chain.limits[1] == (5.0, 40.0)
    assert position_of(made.chain.fk([0.0, 30.0])) == (150.0, 0.0, 30.0)
