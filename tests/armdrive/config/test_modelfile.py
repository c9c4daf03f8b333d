"""The model file: a link table in TOML becomes a chain, and what is wrong in it is named."""

from __future__ import annotations

import math
import re
import tomllib

import pytest
from chain_files import shown_links
from hypothesis import given
from hypothesis import strategies as st

from armdrive.config.link_model import parse_model, read_model
from armdrive.config.sections import is_model_file
from armdrive.errors import ArmFileError
from kinematics.chains.chain import rows_of
from kinematics.chains.links import Convention, JointKind
from kinematics.frames.transforms import position_of, translation
from kinematics.textbook.systems import system


def shown_text():
    return shown_links()


def test_the_shown_file_is_the_alpha_ii_on_a_plinth_with_a_pen():
    model = parse_model(tomllib.loads(shown_text()))
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
    shown = tomllib.loads(shown_text())
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
    ],
)
def test_what_is_wrong_in_a_file_is_named(document, said):
    with pytest.raises(ArmFileError, match=re.escape(said)):
        parse_model(document)


@pytest.mark.parametrize(
    ("row", "said"),
    [
        ({"theta": 0}, "unknown key 'theta' in [links[1]]; did you mean 'theta_deg'?"),
        ({"kind": "spherical"}, "links[1].kind is one of revolute, prismatic, not 'spherical'"),
        ({"a_mm": "long"}, "links[1].a_mm must be a finite number"),
        ({"low_mm": 1}, "links[1]: a revolute joint has no 'low_mm'"),
        ({"low_deg": 10, "high_deg": -10}, "must not lie above"),
    ],
)
def test_a_wrong_row_is_named(row, said):
    with pytest.raises(ArmFileError, match=re.escape(said)):
        parse_model({"links": [row]})


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
