"""`armdrive fk` and `ik` with a model of the reader's own, or a named system."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from cli_calls import Caller

PAGE = Path(__file__).parents[4] / "docs" / "model-file.md"


@pytest.fixture
def call(capsys):
    return Caller(capsys)


@pytest.fixture
def own(tmp_path):
    shown = re.search(r"```toml\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)[1]
    path = tmp_path / "mine.toml"
    path.write_text(shown, encoding="utf-8")
    return str(path)


def test_fk_of_a_model_file(call, own):
    said = call("fk", "--model", own, "0", "-40", "60", "-110", "0", code=0).out
    assert said.startswith("Alpha II with a pen: base 0°, shoulder -40°")
    assert "tip x 467.78 mm, y 0 mm, z 288.48 mm" in said
    found = call("fk", "--model", own, "0", "-40", "60", "-110", "0", "--json", code=0).json
    assert found["position_mm"] == pytest.approx([467.78, 0.0, 288.48], abs=0.01)
    assert found["violations"] == []


def test_fk_says_which_limits_of_a_model_are_passed(call, own):
    said = call("fk", "--model", own, "120", "-40", "60", "-110", "0", code=0).out
    assert "but: base 30° beyond its limit of 90°" in said


def test_ik_of_a_model_file_undoes_fk(call, own):
    words = ("--x", "300", "--y", "40", "--z", "150", "--pitch", "-60", "--roll", "10")
    found = call("ik", "--model", own, *words, "--json", code=0).json
    assert found["ok"]
    joints = [str(value) for value in found["joints"].values()]
    again = call("fk", "--model", own, *joints, "--json", code=0).json
    assert again["position_mm"] == pytest.approx([300.0, 40.0, 150.0], abs=1e-3)
    assert "the goal is met" in call("ik", "--model", own, *words, code=0).out


def test_ik_leaves_pitch_and_roll_free_where_they_are_not_given(call):
    found = call("ik", "--model", "puma", "--x", "400", "--y", "100", "--z", "300", "--json")
    assert found.code == 0
    assert "pitch" not in found.json["met"]
    assert "roll" not in found.json["met"]


def test_ik_out_of_reach_prints_the_nearest_and_ends_with_3(call, own):
    called = call("ik", "--model", own, "--x", "3000", "--y", "0", "--z", "0", code=3)
    assert "nearest: base" in called.out
    assert "missed: position" in called.err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("fk", "1", "2"), "5 joint angles are required"),
        (("fk", "--model", "puma", "1", "2"), "6 joint values are required"),
        (("fk", "--model", "pumo", "1"), "did you mean 'puma'"),
        (("ik", "--x", "1", "--y", "2", "--z", "3"), "--pitch is needed"),
        (("ik", "--model", "x.toml", "--x", "1", "--y", "2", "--z", "3"), "cannot be read"),
    ],
)
def test_a_wrong_word_is_named(call, words, said):
    assert said in call.refused(*words, code=2)
