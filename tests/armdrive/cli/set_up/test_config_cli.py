"""`armdrive config` as a command: list, show, check and set-default."""

from __future__ import annotations

import tomllib

import pytest
from chain_files import NAMES, shown_files, six_arm, six_links
from cli_calls import write_arm_file
from pages import blocks, page

from armdrive.registry.arm_files import load_arm, parse_arm
from armdrive.storage import files as places

PLAIN = 'model = "teachmover"\n[connection]\nport = "/dev/ttyNOWHERE"\n'


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


@pytest.mark.parametrize("name", ["bnech", "bench.toml", "sim:gcode", "broken"])
def test_an_unknown_arm_cannot_be_the_default(call, name):
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


FURNISHED_ARM = """
model = "teachmover"
backlash_mm = 0.4
[backlash_deg]
elbow = 0.7
"left wrist" = 3.3
[tool]
along_mm = 40.0
up_mm = 10.0
radius_mm = 8.0
[frames.board]
x_mm = 180.0
yaw_deg = 30.0
[guards]
radii_mm = [35, 30, 25]
[[guards.boxes]]
name = "camera"
min_mm = [100, -300, 0]
max_mm = [200, -250, 400]
[[guards.sums]]
name = "forearm"
joints = { shoulder = 1, elbow = 1 }
range_deg = [-80, 60]
"""


@pytest.mark.parametrize(
    "text",
    [
        pytest.param(PLAIN, id="a preset"),
        pytest.param(PRESET_ARM, id="a preset with its own numbers"),
        pytest.param(FURNISHED_ARM, id="backlash, a tool, a frame and guards"),
        pytest.param('model = "alpha2"', id="a template"),
        pytest.param("five", id="a link table of five joints"),
        pytest.param("six", id="a link table of six joints"),
        pytest.param("urdf", id="a URDF"),
    ],
)
def test_the_complete_file_is_the_same_arm_to_the_last_bit(call, text):
    write_arm_file("minilinks", shown_files()[0])
    write_arm_file("six", six_links())
    (urdf,), (urdf_arm,) = (blocks(page("urdf"), kind) for kind in ("xml", "toml"))
    (places.arm_files() / "six.urdf").write_text(urdf, encoding="utf-8")
    yaw = "[park]\nx_mm = 500\ny_mm = 0\nz_mm = 400\npitch_deg = -80\nyaw_deg = 15\n"
    joints = "".join(f"{name} = 1.5\n" for name in NAMES)
    homing = f"[homing]\ngroups = [[2], [1, 3], [4, 5, 6]]\n[homing.joints_deg]\n{joints}"
    six = six_arm().replace("sees = { elbow = 1 }", "sees = { elbow = 1 }\nbacklash_deg = 0.5")
    text = {"five": shown_files()[1], "six": six + yaw + homing, "urdf": urdf_arm}.get(text, text)
    path = write_arm_file("bench", text)
    whole = call("config", "show", "bench", "--toml", code=0).out
    ours, again = (
        load_arm(path),
        parse_arm(tomllib.loads(whole), name="bench", folder=path.parent),
    )
    assert again == ours
    assert again.calibration == ours.calibration


def test_all_problems_are_reported_at_once(call):
    write_arm_file(
        "bench",
        'model = "teachmover"\nspede = 1\n[connection]\nbuad = 9600\nport = "COM1"\n',
    )
    said = call("config", "check", "bench", "--json", code=2).json
    assert not said["ok"]
    assert ["spede" in said["problems"][0], "baud" in said["problems"][1]] == [True, True]
    assert "2 problems" in call("config", "check", code=2).out


def test_what_is_no_file_is_said_as_in_the_list(call):
    write_arm_file("bench", PLAIN)
    folder = places.arm_files()
    (folder / "folder.toml").mkdir()
    (folder / "dangling.toml").symlink_to("nowhere")
    said = call("config", "check", code=2).out
    assert f"{folder / 'folder.toml'} cannot be read: it is not a regular file" in said
    assert f"{folder / 'dangling.toml'} cannot be read: No such file" in said
    for missing in ("benhc", "benhc.toml"):
        assert "did you mean 'bench'" in call.refused("config", "show", missing, code=2)
    assert "did you mean 'bench'" in call("config", "check", "benhc", code=2).out


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (PLAIN + "[park]\nx_mm = 900\ny_mm = 0\nz_mm = 0\npitch_deg = -90\n", "[park]"),
        (PLAIN + "[park]\nx_mm = 100\ny_mm = 0\nz_mm = -40\npitch_deg = -90\n", "below the table"),
        ('model = "alpha2"\n', "motor steps of the"),
        (PLAIN + '[gripper]\nkind = "none"\n', "has 5 motors"),
        (
            PLAIN + "[homing.joints_deg]\nbase = 0\nshoulder = 170\nelbow = 0\nwrist_pitch = 0\n"
            "wrist_roll = 0\n",
            "homing.joints_deg.shoulder is 170",
        ),
        ("model = ", "not valid TOML"),
    ],
)
def test_a_problem_names_the_key_and_the_remedy(call, text, said):
    path = write_arm_file("bench", text)
    called = call("config", "check", str(path), code=2)
    assert said in called.out
    assert "1 problem" in called.out


def test_a_right_file_is_fine_with_remarks(call):
    write_arm_file("bench", 'model = "teachmover"\n')
    said = call("config", "check", "bench", code=0).out
    assert "bench: fine" in said
    assert "only be simulated" in said
