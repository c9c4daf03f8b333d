"""The command line with arms of model files, and a hand that has a heading."""

import pytest
from chain_files import shown_files, six_arm, six_links
from cli_calls import Caller

from armdrive.storage import files as places


@pytest.fixture
def call(capsys, tmp_path, monkeypatch):
    monkeypatch.setenv("ARMDRIVE_HOME", str(tmp_path))
    monkeypatch.setenv("ARMDRIVE_FORCE_SIM", "1")
    folder = places.arm_files()
    folder.mkdir(parents=True)
    links, arm = shown_files()
    posture = "[reference]\nx_mm = 500\ny_mm = 100\nz_mm = 400\npitch_deg = -80\nyaw_deg = 15\n"
    for name, text in (
        ("minilinks", links),
        ("five", arm),
        ("six", six_links()),
        ("bench", six_arm() + posture),
    ):
        (folder / f"{name}.toml").write_text(text, encoding="utf-8")
    return Caller(capsys)


def test_five_joints_home_and_move_by_their_names(call):
    call("home", "--arm", "five", code=0)
    call("move", "--arm", "five", "--joint", "shoulder=50", "--joint", "elbow=-70", code=0)
    joints = call("status", "--arm", "five", "--json", code=0).json["joints"]
    assert joints["shoulder_deg"] == pytest.approx(50, abs=0.1)
    assert joints["elbow_deg"] == pytest.approx(-70, abs=0.1)
    moved = call("move", "--arm", "five", "--x", "260", "--y", "30", "--json", code=0).json
    assert moved["pose"]["x_mm"] == pytest.approx(260, abs=0.5)
    assert "yaw_deg" not in moved["pose"]


def test_six_joints_take_a_yaw_and_keep_what_is_not_named(call):
    call("home", "--arm", "bench", code=0)
    moved = call("move", "--arm", "bench", "--yaw", "40", "--z", "450", "--json", code=0).json
    assert moved["pose"]["yaw_deg"] == pytest.approx(40, abs=0.3)
    assert moved["pose"]["pitch_deg"] == pytest.approx(-80, abs=0.2)
    assert moved["pose"]["x_mm"] == pytest.approx(500, abs=0.5)
    assert moved["gripper_mm"] is None
    assert "yaw 40" in call("status", "--arm", "bench", code=0).out


def test_a_yaw_is_refused_where_no_hand_has_one(call):
    call("home", "--arm", "five", code=0)
    said = call("move", "--arm", "five", "--yaw", "20")
    assert said.code != 0
    assert "cannot take a yaw" in said.err


def test_a_joint_is_written_with_its_angle(call):
    assert "shoulder=40" in call("move", "--arm", "five", "--joint", "shoulder", code=2).err


def test_ik_of_a_six_joint_model_takes_a_yaw(call):
    model = str(places.arm_files() / "six.toml")
    goal = ("--x", "450", "--y", "200", "--z", "500", "--pitch", "-60", "--roll", "10")
    found = call("ik", "--model", model, *goal, "--yaw", "50", "--json", code=0).json
    assert found["ok"]
    assert found["met"] == ["heading", "pitch", "position", "roll"]
    free = call("ik", "--model", model, *goal[:6], "--yaw", "50", "--json", code=0).json
    assert free["met"] == ["heading", "position"]


def test_ik_of_a_five_joint_preset_takes_no_yaw(call):
    goal = ("--x", "250", "--y", "0", "--z", "100", "--pitch", "-60", "--yaw", "5")
    assert "six joints" in call("ik", *goal, code=2).err
