"""`armdrive config` as one calls it: interviews from a pipe, files, lists, checks, the default."""

from __future__ import annotations

import io
import tomllib

import pytest
from chain_files import NAMES, shown_files, six_arm, six_links
from cli_calls import Caller, write_arm_file

from armdrive import places
from armdrive.armfile import load_arm_file, parse_arm_file
from armdrive.connecting import simulated_config
from armdrive.sim import twin as twins

PLAIN = 'model = "teachmover"\n[connection]\nport = "/dev/ttyNOWHERE"\n'


@pytest.fixture
def call(capsys):
    return Caller(capsys)


@pytest.fixture
def typing(monkeypatch):
    def types(*lines):
        monkeypatch.setattr("sys.stdin", io.StringIO("".join(f"{line}\n" for line in lines)))

    return types


def arm_path(name):
    return places.arm_files() / f"{name}.toml"


def written():
    folder = places.arm_files().parent
    return [path for path in folder.rglob("*") if path.is_file()] if folder.exists() else []


# title, dialect, port, baud, lengths, motors, limits, speeds, park, guards
DEFAULTS = [""] * 10


# -- new --------------------------------------------------------------------------------------


def test_an_interview_by_a_pipe_writes_a_file_that_drives_the_twin(call, typing, monkeypatch):
    typing("bench", "teachmover", "The one", *DEFAULTS[1:], "skip", "yes")
    said = call("config", "new", code=0)
    assert "Which port leads to it?" in said.out
    assert f"written: {arm_path('bench')}" in said.out
    assert "armdrive config check bench" in said.out
    assert load_arm_file(arm_path("bench")).title == "The one"
    monkeypatch.setenv("ARMDRIVE_FORCE_SIM", "1")
    call("home", "--arm", "bench", code=0)
    moved = call("move", "--arm", "bench", "--x", "250", "--z", "120", "--json", code=0).json
    assert moved["pose"]["x_mm"] == pytest.approx(250, abs=0.5)


def test_a_question_mark_explains_and_back_goes_back(call, typing):
    typing("bench", "robko01", "back", "teachmover", "?", *DEFAULTS, "skip", "yes")
    said = call("config", "new", code=0)
    assert "Shown wherever the arm is named." in said.out
    assert load_arm_file(arm_path("bench")).model.key == "teachmover"


def test_back_passes_over_what_was_given_beforehand(call, typing):
    typing("one", "back", "two", *DEFAULTS[1:], "skip", "yes")
    call("config", "new", "bench", "--template", "teachmover", code=0)
    assert load_arm_file(arm_path("bench")).title == "two"


def test_a_wrong_answer_is_named_and_asked_again(call, typing):
    typing("my arm!", "bench", "teachmover", *DEFAULTS[:3], "7", "", *DEFAULTS[4:], "", "yes")
    said = call("config", "new", code=0)
    assert "is no name for a file" in said.out
    assert "a number from 50 to 4e+06 is needed, not 7" in said.out


def test_answers_that_end_too_early_leave_nothing_behind(call, typing):
    typing("bench", "teachmover")
    assert "A title for people?" in call("config", "new", code=2).err
    assert written() == []


def test_ctrl_c_leaves_nothing_behind(call, monkeypatch):
    class Interrupted(io.StringIO):
        def readline(self, *_):
            line = super().readline()
            if not line:
                raise KeyboardInterrupt
            return line

    monkeypatch.setattr("sys.stdin", Interrupted("bench\nteachmover\n" + "\n" * 11))
    assert "interrupted" in call("config", "new", code=130).err
    assert written() == []


def test_a_no_at_the_end_writes_nothing(call, typing):
    typing("bench", "teachmover", *DEFAULTS, "skip", "no")
    assert "nothing is written" in call("config", "new", code=1).out
    assert written() == []


def test_an_arm_file_is_not_overwritten_unasked(call, typing):
    write_arm_file("bench", PLAIN)
    assert "--force" in call.refused("config", "new", "bench", "--yes", "--template", "own", code=2)
    typing(*DEFAULTS, "skip", "")
    call("config", "new", "bench", "--template", "teachmover", code=1)
    assert arm_path("bench").read_text() == PLAIN
    call("config", "new", "bench", "--template", "teachmover", "--yes", "--force", code=0)
    assert arm_path("bench").read_text() != PLAIN


def test_answers_from_a_file_ask_nothing(call, tmp_path):
    answers = tmp_path / "answers.toml"
    answers.write_text(
        'template = "teachmover"\nfull_steps = 200\nmicrosteps = 8\n'
        'connection = { port = "/dev/ttyUSB7" }\nlimits = { base = [-80, 85] }\n'
        'fingers.mm_per_turn = 10\npark = [200, 0, 150, -80, 0]\nreversed = { motors = ["base"] }\n'
        '[gear]\nbase = "20:1"\nshoulder = "60/16 * 9:1"\nelbow = 12\n'
        '"right wrist" = "5:1"\n"left wrist" = "5:1"\n'
        '[lengths]\nhand_mm = 97.5\n'
    )  # fmt: skip
    said = call("config", "new", "bench", "--answers", str(answers), "--json", code=0).json
    assert said["file"] == str(arm_path("bench"))
    table = tomllib.loads(arm_path("bench").read_text())
    assert table["steps_per_turn"]["base"] == 32000
    assert table["steps_per_turn"]["shoulder"] == 54000
    assert table["steps_per_mm"] == 160
    assert table["limits_deg"]["base"] == [-80, 85]
    assert table["lengths"]["hand_mm"] == 97.5
    assert table["motor_signs"] == {"base": -1}
    assert table["connection"]["port"] == "/dev/ttyUSB7"
    assert load_arm_file(arm_path("bench")).park.x_mm == 200


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('template = "teachmover"\ntitel = 3', "did you mean"),
        ('template = "teachmover"\nconnection.baud = "fast"', "connection.baud"),
        ("template = ", "not valid TOML"),
        ('template = "own"\nlinks.file = "/nowhere.toml"', "/nowhere.toml"),
        ('template = "own"', "links.file"),
    ],
)
def test_answers_that_cannot_be_used_are_named(call, tmp_path, text, said):
    answers = tmp_path / "answers.toml"
    answers.write_text(text)
    assert said in call.refused("config", "new", "bench", "--answers", str(answers), code=2)
    assert written() == []


def test_directions_are_found_on_a_twin_whose_motors_are_reversed(call, typing, monkeypatch):
    truth = simulated_config("teachmover").model.transmission.with_signs((1, 1, -1, 1, 1, -1))
    of_preset = twins.ArmBody.of_preset

    def body(model):
        from dataclasses import replace

        return replace(of_preset(model), transmission=truth)

    monkeypatch.setattr(twins.ArmBody, "of_preset", body)
    # each motor: now?, what was seen (what the simulated arm shows), the wrists: and the roll
    motors = ["", ""] * 4 + ["", "", ""] * 2
    typing("bench", "teachmover", *DEFAULTS, "find", "yes", *motors, "yes")
    said = call("config", "new", "--sim", code=0)
    assert "seen on the simulated arm: up" in said.out
    assert tomllib.loads(arm_path("bench").read_text())["motor_signs"] == {
        "gripper": -1,
        "elbow": -1,
    }


def test_the_directions_of_a_file_are_looked_at_later(call):
    write_arm_file("bench", PLAIN)
    assert "every direction" in call("config", "signs", "bench", "--sim", "--yes", code=0).out
    found = call("config", "signs", "bench", "--sim", "--json", code=0).json
    assert found["reversed_motors"] == found["unclear"] == []
    assert "somebody has to watch" in call.refused("config", "signs", "bench", "--yes", code=3)


# -- list, show, check, set-default -----------------------------------------------------------


def test_arms_are_listed_with_the_default_and_what_is_broken(call):
    assert "armdrive config new" in call("config", "list", code=0).out
    write_arm_file("bench", PLAIN)
    write_arm_file("broken", 'model = "teachmoover"\n')
    write_arm_file("links", shown_files()[0])  # a model file is no arm
    call("config", "set-default", "bench", code=0)
    listed = call("config", "list", "--json", code=0).json
    assert listed["default"] == "bench"
    assert [arm["name"] for arm in listed["arms"]] == ["bench", "broken"]
    assert listed["arms"][0]["port"] == "/dev/ttyNOWHERE"
    assert "did you mean 'teachmover'" in listed["arms"][1]["error"]
    assert "* bench" in call("config", "list", code=0).out


def test_the_default_is_used_where_no_arm_is_named(call, monkeypatch):
    write_arm_file("bench", PLAIN)
    call("config", "set-default", "bench", code=0)
    assert "/dev/ttyNOWHERE" in call.refused("status", code=4)
    monkeypatch.setenv("ARMDRIVE_ARM", "sim:teachmover")
    assert "ARMDRIVE_ARM" in call("config", "set-default", "bench", code=0).out
    assert call("status", "--json", code=0).json["simulated"]
    monkeypatch.delenv("ARMDRIVE_ARM")
    call("config", "set-default", "sim:teachmover", code=0)
    assert call("status", "--json", code=0).json["arm"] == "sim:teachmover"
    assert (
        call("config", "set-default", "--none", "--json", code=0).json["default"].startswith("sim")
    )


@pytest.mark.parametrize("name", ["bnech", "bench.toml", "sim:gcode", "broken"])
def test_what_is_no_arm_cannot_be_the_default(call, name):
    write_arm_file("bench", PLAIN)
    write_arm_file("broken", "model = 3\n")
    call.refused("config", "set-default", name, code=2)


def test_an_arm_is_shown_as_it_is_understood(call):
    write_arm_file("bench", PLAIN + "[motor_signs]\nelbow = -1\n[lengths]\nhand_mm = 97\n")
    said = call("config", "show", "bench", code=0).out
    assert "hand 97 mm" in said
    assert "4158 steps/turn, up for +shoulder, +elbow" in said
    assert "a stop while jogging takes at most" in said
    view = call("config", "show", "bench", "--json", code=0).json
    assert view["motors"][5]["follows"] == {"elbow": -1}
    assert view["limits_deg"]["elbow"] == [-149, 0]
    assert view["stopping"]["jog"]["time_s"] < 0.3


PRESET_ARM = """
model = "robko01"
title = "The one by the window"
steps_per_mm = 26.5
[connection]
dialect = "robko01"
port = "COM3"
[motion]
jog_burst_s = 0.1
[park]
x_mm = 200
y_mm = 10
z_mm = 150
pitch_deg = -80.3
[limits_deg]
base = [-80.7, 85.1]
[speeds_deg_s]
shoulder = 7.7
[steps_per_turn]
base = 7100.3
[motor_signs]
elbow = -1
gripper = -1
[joint_signs]
wrist_roll = -1
[guards]
tolerance_mm = 2
"""


@pytest.mark.parametrize(
    "text", [PLAIN, PRESET_ARM, 'model = "alpha2"', "five", "six"], ids=lambda text: text[:12]
)
def test_the_complete_file_is_the_same_arm_to_the_last_bit(call, text):
    write_arm_file("minilinks", shown_files()[0])
    write_arm_file("six", six_links())
    yaw = "[park]\nx_mm = 500\ny_mm = 0\nz_mm = 400\npitch_deg = -80\nyaw_deg = 15\n"
    joints = "".join(f"{name} = 1.5\n" for name in NAMES)
    homing = f"[homing]\ngroups = [[2], [1, 3]]\n[homing.joints_deg]\n{joints}"
    text = {"five": shown_files()[1], "six": six_arm() + yaw + homing}.get(text, text)
    path = write_arm_file("bench", text)
    whole = call("config", "show", "bench", "--toml", code=0).out
    ours, again = (
        load_arm_file(path),
        parse_arm_file(tomllib.loads(whole), name="bench", folder=path.parent),
    )
    assert again == ours
    assert again.calibration == ours.calibration


def test_everything_that_is_wrong_is_told_at_once(call):
    write_arm_file(
        "bench",
        'model = "teachmover"\nspede = 1\n[connection]\nbuad = 9600\nport = "COM1"\n'
        "[motion]\njog_burst_s = 9\ntip_speed_mm_s = 50\n[limits_deg]\nbase = [90, -90]\n"
        "[gripper]\ntrip_force_n = \"much\"\n[motor_signs]\nelbow = 2\n",
    )  # fmt: skip
    said = call("config", "check", "bench", "--json", code=2).json
    assert not said["ok"]
    for key in ("spede", "baud", "jog_burst_s", "limits_deg.base", "trip_force_n", "elbow"):
        assert sum(key in problem for problem in said["problems"]) == 1, key
    assert len(said["problems"]) == 6
    assert "6 to mend" in call("config", "check", code=2).out


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('model = "teachmoover"\ntitle = "a"\n', "did you mean 'teachmover'"),
        ('model = "teachmover"\n[connection]\ndialect = "gcode"\n', "gcode"),
        (PLAIN + "[park]\nx_mm = 900\ny_mm = 0\nz_mm = 0\npitch_deg = -90\n", "[park]"),
        (PLAIN + "[park]\nx_mm = 100\ny_mm = 0\nz_mm = -40\npitch_deg = -90\n", "below the table"),
        ('model = "alpha2"\n', "no motor steps"),
        (PLAIN + '[gripper]\nkind = "none"\n', "has 5 motors"),
        (
            PLAIN + "[homing.joints_deg]\nbase = 0\nshoulder = 170\nelbow = 0\nwrist_pitch = 0\n"
            "wrist_roll = 0\n",
            "homing.joints_deg.shoulder is 170",
        ),
        ("model = ", "not valid TOML"),
    ],
)
def test_what_is_wrong_comes_with_the_key_and_the_mend(call, text, said):
    path = write_arm_file("bench", text)
    called = call("config", "check", str(path), code=2)
    assert said in called.out
    assert "1 to mend" in called.out


def test_a_right_file_is_fine_with_remarks(call):
    write_arm_file("bench", 'model = "teachmover"\n')
    said = call("config", "check", "bench", code=0).out
    assert "bench: fine" in said
    assert "only simulated" in said


def test_an_arm_that_is_not_there_is_met_with_the_nearest_one(call):
    write_arm_file("bench", PLAIN)
    assert "did you mean 'bench'" in call.refused("config", "show", "benhc", code=2)
    assert "did you mean 'bench'" in call("config", "check", "benhc", code=2).out
