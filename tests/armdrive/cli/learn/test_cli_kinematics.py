"""`armdrive fk` and `ik`: of a built-in arm, a model of the reader's own, or a named system."""

import sys

import numpy as np
import pytest
from amounts import every_row

from armdrive.cli.learn.models import find_subject, given_joints, shown_joints
from armdrive.config.preset import corrected
from armdrive.registry.arm_files import load_arm
from armdrive.status import joints_view, pose_view
from armdrive.text.toml import Problems, TomlTable
from kinematics import PRESETS, Joints, preset
from kinematics.frames.transforms import position_of
from kinematics.textbook.study import example_posture
from kinematics.textbook.systems import MODEL_NAMES, SYSTEMS, system

GOAL = ("--x", "250", "--y", "0", "--z", "120", "--pitch", "-90")


def test_fk_gives_the_pose_of_a_posture_and_the_limits_that_it_passes(call):
    found = call("fk", "0", "40", "-60", "-70", "0", "--json", code=0).json
    expected = preset("teachmover").arm.fk(Joints.of(0, 40, -60, -70, 0))
    assert found["pose"] == pose_view(expected)
    explained = call("explain", "teachmover", "0", "40", "-60", "-70", "0", "--json", code=0).json
    for key in ("position_mm", "frame"):
        assert np.array(found[key]) == pytest.approx(np.array(explained[key]), abs=1e-9)
    assert found["model"] == "teachmover"
    assert found["violations"] == []
    called = call("fk", "120", "40", "-60", "-70", "0", code=0)
    assert "but: base 30.0° beyond its limit of 90.0°" in called.out
    assert "but: the tip would be" in call("fk", "0", "0", "-90", "0", "0", code=0).out


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
    found = call("ik", *GOAL, "--json", code=0).json
    used = [branch for branch in found["branches"] if branch["joints"] == found["joints"]]
    assert found["ok"]
    assert [branch["name"] for branch in used] == ["base front, elbow up"]
    rows = [line for line in called.out.splitlines() if line.startswith("  ")]
    assert len({line.find("°") for line in rows[1:]}) == 1  # angles stand below each other


def test_ik_says_that_a_guard_forbids_a_posture(call):
    called = call("ik", "--x", "200", "--y", "0", "--z", "-20", "--pitch", "-90", code=0)
    assert "but: " in called.out
    assert "table" in called.out
    words = ("--x", "200", "--y", "0", "--z", "-20", "--pitch", "-90", "--json")
    assert "table" in call("ik", *words, code=0).json["violations"][0]


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
    branches = call("ik", *words, "--json", code=3).json["branches"]
    assert bool(branches) == ("900" not in words)  # no length of the arm leads there
    assert not any(branch["within_limits"] for branch in branches)


# Of a model file, or of a named system.


def test_fk_of_a_model_file(call, own):
    said = call("fk", "--model", own, "0", "-40", "60", "-110", "0", code=0).out
    assert said.startswith("Alpha II with a pen: base 0°, shoulder -40°")
    assert "tip x 467.78 mm, y 0 mm, z 288.48 mm" in said
    found = call("fk", "--model", own, "0", "-40", "60", "-110", "0", "--json", code=0).json
    assert found["position_mm"] == pytest.approx([467.78, 0.0, 288.48], abs=0.01)
    assert found["violations"] == []
    said = call("fk", "--model", own, "120", "-40", "60", "-110", "0", code=0).out
    assert "but: base 30.0° beyond its limit of 90.0°" in said


def test_ik_of_a_model_file_undoes_fk_or_prints_the_nearest(call, own):
    words = ("--x", "300", "--y", "40", "--z", "150", "--pitch", "-60", "--roll", "10")
    found = call("ik", "--model", own, *words, "--json", code=0).json
    assert found["ok"]
    joints = [str(value) for value in found["joints"].values()]
    again = call("fk", "--model", own, *joints, "--json", code=0).json
    assert again["position_mm"] == pytest.approx([300.0, 40.0, 150.0], abs=1e-3)
    assert "the goal is met" in call("ik", "--model", own, *words, code=0).out
    called = call("ik", "--model", own, "--x", "3000", "--y", "0", "--z", "0", code=3)
    assert "nearest: base" in called.out
    assert "missed: position" in called.err


def test_ik_says_what_each_solution_loses(call, own):
    on_the_axis = call("ik", "--model", "cylindrical", "--x", "0", "--y", "0", "--z", "100", code=0)
    assert "reaching forward: the tip is on the base axis: the base is free" in on_the_axis.out
    stretched = call("fk", "--model", own, "0", "-40", "0", "-60", "0", "--json", code=0).json
    x, y, z = stretched["position_mm"]
    place = ("--x", f"{x + 0.77e-6}", "--y", f"{y}", "--z", f"{z + 0.64e-6}")  # just beyond it
    said = call("ik", "--model", own, *place, "--pitch", "10", "--roll", "0", code=0).out
    assert "solution 1: singular: moving 0.41 shoulder" in said


# One name, one model: whatever takes the name of a model takes the same joint values for it.


def example_of(name):
    chain = find_subject(name).chain
    values = example_posture(chain)
    return values, [str(value) for value in shown_joints(chain, values).values()]


@every_row("name", MODEL_NAMES)
def test_every_command_takes_the_same_joint_values_for_a_name(call, name):
    values, typed = example_of(name)
    fk = call("fk", "--model", name, *typed, "--json", code=0).json
    explained = call("explain", name, *typed, "--json", code=0).json
    tip = fk["position_mm"] if "position_mm" in fk else [fk["pose"][f"{a}_mm"] for a in "xyz"]
    assert explained["position_mm"] == pytest.approx(tip, abs=0.01)
    assert position_of(find_subject(name).chain.fk(values)) == pytest.approx(tip, abs=0.01)
    assert position_of(system(name).fk(values)) == pytest.approx(tip, abs=0.01)
    assert explained["joints"] == pytest.approx(
        dict(zip(explained["joints"], map(float, typed), strict=True)), abs=1e-9
    )


@every_row("key", PRESETS)
def test_an_arm_file_takes_the_same_joint_values_for_a_preset(key):
    values = example_posture(system(key).chain())
    problems = Problems()
    arm = corrected(preset(key), TomlTable({"model": key}, "", problems)).arm
    assert not problems.found
    assert arm.points(Joints(values))[-1] == pytest.approx(position_of(system(key).fk(values)))


@every_row("name", [name for name in SYSTEMS if name not in PRESETS])
def test_ik_prints_every_solution_of_a_named_system(call, name):
    _, typed = example_of(name)
    fk = call("fk", "--model", name, *typed, "--json", code=0).json
    x, y, z = map(str, fk["position_mm"])
    found = call("ik", "--model", name, "--x", x, "--y", y, "--z", z, "--json", code=0).json
    chain = find_subject(name).chain
    assert any(
        branch["joints"] == pytest.approx(found["joints"], abs=1e-3) for branch in found["branches"]
    )
    assert len(found["branches"]) == len(system(name).signs)
    for branch in found["branches"]:
        joints = given_joints(chain, list(branch["joints"].values()))
        assert position_of(chain.fk(joints)) == pytest.approx(fk["position_mm"], abs=1e-5)
        assert branch["within_limits"] == (not branch["violations"])


ARM = """model = "alpha2"
steps_per_mm = 15
[steps_per_turn]
base = 7000
shoulder = 7000
elbow = 4000
"right wrist" = 1500
"left wrist" = 1500
[lengths]
hand_mm = 150.0
[tool]
along_mm = 20.0
up_mm = 5.0
"""


def test_an_arm_file_is_a_model_with_its_corrections_and_its_tool(call, tmp_path):
    path = tmp_path / "lab.toml"
    path.write_text(ARM, encoding="utf-8")
    joints = (10.0, 40.0, -60.0, -30.0, 20.0)
    arm = load_arm(path).model.arm
    expected = arm.fk(Joints.of(*joints))
    typed = [str(value) for value in joints]
    for found in (
        call("fk", "--model", str(path), *typed, "--json", code=0).json,
        call("explain", str(path), *typed, "--json", code=0).json,
    ):
        assert found["position_mm"] == pytest.approx(
            (expected.x_mm, expected.y_mm, expected.z_mm), abs=1e-6
        )
    assert "up is positive" in call("explain", str(path), code=0).out.splitlines()[2]
    goal = (f"--{axis}={getattr(expected, f'{axis}_mm')}" for axis in "xyz")
    pitch = f"--pitch={expected.pitch_deg}"
    found = call("ik", "--model", str(path), *goal, pitch, "--json", code=0).json
    assert found["ok"]
    assert find_subject(str(path)).chain.joint_names == arm.joint_names
    assert call("plot", "--model", str(path), "--ascii", code=0).out


# `armdrive plot`: what an arm reaches, in characters and in files.


@every_row("key", PRESETS)
def test_every_arm_is_drawn(call, key):
    said = call("plot", "--model", key, "--ascii", code=0).out
    assert said.isascii()
    lines = said.splitlines()
    assert "reach of the finger tips at pitch -90 deg" in lines[0]
    assert "distance from the base axis across" in lines[-1]
    assert set("".join(lines[1:-1])) & set("-|/\\")


@every_row("name", ["two-link-2", "cartesian", "puma"])
def test_another_system_is_drawn_from_two_sides(call, name):
    lines = call("plot", "--model", name, "--ascii", code=0).out.splitlines()
    assert lines[0].endswith("positions that the tool reached")
    assert lines[-2].startswith("x across")
    assert "z up" in lines[-2]
    assert "y up" in lines[-1]
    assert sum(line.count(".") for line in lines[1:-2]) > 10
    (plane,) = call("plot", "--model", "two-link-1", "--json", code=0).json["views"]
    assert (plane["across"], plane["up"]) == ("x", "y")


def test_without_matplotlib_the_extra_is_named(call, monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    said = call.refused("plot", "--output", str(tmp_path / "reach.png"), code=2)
    assert "pip install 'armdrive[plot]'" in said
