"""`armdrive fk` and `ik`: of a built-in arm, a model of the reader's own, or a named system."""

from __future__ import annotations

import pytest

from armdrive.status import joints_view, pose_view
from kinematics import PRESETS, Joints, preset

GOAL = ("--x", "250", "--y", "0", "--z", "120", "--pitch", "-90")


def test_fk_gives_the_pose_of_a_posture(call):
    found = call("fk", "0", "40", "-60", "-70", "0", "--json", code=0).json
    expected = preset("teachmover").arm.fk(Joints.of(0, 40, -60, -70, 0))
    assert found["pose"] == pose_view(expected)
    assert found["model"] == "teachmover"
    assert found["violations"] == []


def test_fk_says_which_limits_a_posture_passes(call):
    called = call("fk", "120", "40", "-60", "-70", "0", code=0)
    assert "but: base 30.0° beyond its limit of 90.0°" in called.out


def test_ik_undoes_fk(call):
    pose = call("fk", "20", "50", "-70", "-60", "10", "--json", code=0).json["pose"]
    words = [f"--{key.partition('_')[0]}={value}" for key, value in pose.items()]
    found = call("ik", *words, "--json", code=0).json
    fitting = [branch["joints"] for branch in found["branches"] if branch["within_limits"]]
    wanted = joints_view(Joints.of(20, 50, -70, -60, 10))
    assert any(
        all(joints[name] == pytest.approx(wanted[name], abs=0.01) for name in wanted)
        for joints in fitting
    )


def test_ik_prints_every_branch_and_the_one_that_the_arm_would_use(call):
    called = call("ik", *GOAL, code=0)
    for base in ("front", "back"):
        for elbow in ("up", "down"):
            assert f"base {base}, elbow {elbow}" in called.out
    assert "the arm would use: base 0.0°" in called.out
    rows = [line for line in called.out.splitlines() if line.startswith("  ")]
    assert len({line.find("°") for line in rows[1:]}) == 1  # angles stand below each other


def test_ik_says_that_a_guard_forbids_a_posture(call):
    called = call("ik", "--x", "200", "--y", "0", "--z", "-20", "--pitch", "-90", code=0)
    assert "but: " in called.out
    assert "table" in called.out


@pytest.mark.parametrize("key", PRESETS)
def test_both_know_every_preset(call, key):
    assert call("fk", "0", "40", "-60", "-70", "0", "--model", key, "--json").json["model"] == key
    assert call("ik", *GOAL, "--model", key, "--json").json["model"] == key


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--x", "900", "--y", "0", "--z", "120", "--pitch", "0"), "nearest pose"),
        (("--x", "100", "--y", "0", "--z", "195", "--pitch", "0"), "nearest pose"),
        (("--x", "-250", "--y", "0", "--z", "120", "--pitch", "-90"), "beyond its limit"),
    ],
)
def test_a_goal_out_of_reach_is_refused_with_the_nearest_pose(call, words, said):
    called = call("ik", *words, code=3)
    assert said in called.err
    assert called.err.count("\n") == 1


def test_a_goal_out_of_reach_still_prints_its_branches_as_json(call):
    called = call("ik", "--x", "-250", "--y", "0", "--z", "120", "--pitch", "-90", "--json", code=3)
    assert called.json["branches"]
    assert not any(branch["within_limits"] for branch in called.json["branches"])


# Of a model file, or of a named system.


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
