"""`armdrive config new` as a command: from a pipe, from a file of answers, interrupted."""

import contextlib
import io
import re
import tomllib
from dataclasses import replace

import pytest
from amounts import every_row
from chain_files import NAMES, shown_files, six_arm, six_links
from cli_calls import typed, write_arm_file, write_bench
from pages import blocks, page

from armdrive import Arm
from armdrive.cli.set_up import arm_trials
from armdrive.cli.set_up.arguments import CONFIG_ACTIONS
from armdrive.cli.set_up.arm_trials import Attendance
from armdrive.connect.parts import connect_simulated
from armdrive.registry import simulate
from armdrive.registry.arm_files import load_arm, parse_arm
from armdrive.setup.questions import ROWS
from armdrive.setup.templates import TEMPLATES
from armdrive.storage import files as places
from armdrive.storage.files import StateFiles

PLAIN = 'model = "teachmover"\n[connection]\nport = "/dev/ttyNOWHERE"\n'


def arm_path(name):
    return places.arm_files() / f"{name}.toml"


def written():
    folder = places.arm_files().parent
    return [path for path in folder.rglob("*") if path.is_file()] if folder.exists() else []


# title, dialect, port, baud, motors, park
DEFAULTS = [""] * 6


def test_a_folder_that_takes_no_file_is_named_before_the_first_question(call, typing, monkeypatch):
    home = places.arm_files().parent.parent / "taken"
    home.parent.mkdir(parents=True, exist_ok=True)
    home.touch()
    monkeypatch.setenv("ARMDRIVE_HOME", str(home))
    said = call("config", "new", code=1)
    assert str(places.arm_files()) in said.err
    assert "make its folder writable" in said.err
    assert "What is the arm called" not in said.out


def test_an_interview_by_a_pipe_writes_a_file_that_drives_the_twin(call, typing, monkeypatch):
    typing(
        "my arm!", "bench", "robko01", "back", "teachmover", "?", "The one", *DEFAULTS[1:], "yes"
    )
    said = call("config", "new", code=0)
    assert "cannot name a file" in said.out
    assert "Shown wherever the arm is named." in said.out
    assert re.search(r"A title\?.* The one\n", said.out)  # what came by the pipe is shown
    assert f"written: {arm_path('bench')}" in said.out
    assert "armdrive config check bench" in said.out
    assert load_arm(arm_path("bench")).title == "The one"
    monkeypatch.setenv("ARMDRIVE_FORCE_SIM", "1")
    call("home", "--arm", "bench", code=0)
    moved = call("move", "--arm", "bench", "--x", "250", "--z", "120", "--json", code=0).json
    assert moved["pose"]["x_mm"] == pytest.approx(250, abs=0.5)


@every_row("name", ["Lab", "a.b", "-x", "../x"])
def test_a_name_that_commands_or_file_systems_could_misread_is_refused(call, name):
    words = ("config", "new", "--template", "teachmover", "--yes", "--", name)
    assert "begin with a letter or a digit" in call.refused(*words, code=2)
    assert not written()


class Interrupted(io.StringIO):
    """A person who presses Ctrl-C at the end."""

    def readline(self, *_):
        line = super().readline()
        if not line:
            raise KeyboardInterrupt
        return line


@pytest.mark.parametrize(
    ("kind", "lines", "code", "said"),
    [
        (io.StringIO, ["bench", "teachmover"], 2, "A title?"),  # the input ends
        (Interrupted, ["bench", "teachmover", *DEFAULTS], 130, "interrupted"),
        (io.StringIO, ["bench", "teachmover", *DEFAULTS, "no"], 1, "nothing is written"),
    ],
)
def test_an_interview_that_does_not_end_with_a_yes_leaves_nothing_behind(
    call, monkeypatch, kind, lines, code, said
):
    monkeypatch.setattr("sys.stdin", kind(typed(*lines)))
    called = call("config", "new", code=code)
    assert said in called.err + called.out
    assert written() == []


def test_an_arm_file_is_not_overwritten_unasked(call, typing):
    path = write_arm_file("bench", PLAIN)
    assert "--force" in call.refused("config", "new", "bench", "--yes", "--template", "own", code=2)
    typing("bench", "teachmover", *DEFAULTS, "")
    called = call("config", "new", code=1)
    assert called.out.index(f"{path} exists") < called.out.index("Which template")
    assert path.read_text() == PLAIN
    call("config", "new", "bench", "--template", "teachmover", "--yes", "--force", code=0)
    assert path.read_text() != PLAIN


@every_row(
    "text, said",
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


AT_A_REAL_ARM = Attendance(simulated=False, alone=False, tell=print)


def test_a_reversed_motor_is_shown_as_a_change_and_written_only_for_a_real_arm(
    call, typing, monkeypatch
):
    path = write_arm_file("bench", PLAIN)

    @contextlib.contextmanager
    def connected(config, **_):
        truth = config.model.transmission.with_signs((1, 1, -1, 1, 1, 1))
        twin = simulate(replace(config, model=replace(config.model, transmission=truth)))
        with Arm(connect_simulated(config, twin=twin)) as arm:
            yield arm

    monkeypatch.setattr(arm_trials, "trial_arm", connected)
    found = call("config", "signs", "bench", "--sim", "--json", code=0).json
    assert found["reversed_motors"] == ["elbow"]
    assert any(line.startswith("+elbow = -1") for line in found["lines"])
    assert path.read_text(encoding="utf-8") == PLAIN
    monkeypatch.setattr(arm_trials, "attendance", lambda *_: AT_A_REAL_ARM)
    # of each motor: now?, the small motion, which way, how far; of the wrists also the roll
    motors = [""] * (4 * 4 + 2 * 5)
    typing("yes", *motors, "yes")
    assert f"written: {path}" in call("config", "signs", "bench", code=0).out
    assert tomllib.loads(path.read_text(encoding="utf-8"))["motor_signs"] == {"elbow": -1}


@pytest.mark.parametrize("words", [("config", "signs"), ("config", "limits")])
def test_nothing_is_connected_for_a_file_that_cannot_be_written(call, monkeypatch, words):
    path = write_arm_file("bench", PLAIN)
    monkeypatch.setattr(StateFiles, "may_change", lambda files, folder: False)
    monkeypatch.setattr(arm_trials, "switches_of", lambda config: ())
    monkeypatch.setattr(arm_trials, "trial_arm", None)
    said = call.refused(*words, "bench", code=1)
    assert said.startswith(f"armdrive: [E002] {path.parent} cannot be used (it is not writable)")


def test_the_directions_of_a_file_are_looked_at_later(call):
    write_arm_file("bench", PLAIN)
    assert "every direction" in call("config", "signs", "bench", "--sim", "--yes", code=0).out
    found = call("config", "signs", "bench", "--sim", "--json", code=0).json
    assert found["reversed_motors"] == found["unclear"] == []
    assert "you have to watch" in call.refused("config", "signs", "bench", "--yes", code=3)


# The page about arm files names every action, template and answer.

PAGE = page("describing-the-arm")


def test_every_action_template_length_and_answer_is_on_the_page():
    for action in CONFIG_ACTIONS:
        assert f"armdrive config {action}" in PAGE
    for name in (*TEMPLATES, *TEMPLATES["printed-six"].lengths):
        assert f"| `{name}` |" in PAGE
    for row in ROWS:
        stem = row.key.replace(".{one}", ".")
        assert re.search(rf"(?m)(^|`|\[){re.escape(stem.rstrip('.'))}", PAGE), row.key


def test_the_answers_of_the_page_make_an_arm(call, tmp_path):
    shown = next(b for b in re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL) if "lab3" in b)
    answers = tmp_path / "answers.toml"
    answers.write_text(shown, encoding="utf-8")
    said = call("config", "new", "--answers", str(answers), "--json", code=0).json
    path = arm_path("lab3")
    assert said["file"] == str(path)
    assert load_arm(path).park.x_mm == 200
    table = tomllib.loads(path.read_text())
    assert table["steps_per_turn"]["base"] == 32000
    assert table["steps_per_turn"]["shoulder"] == 54000
    assert table["steps_per_mm"] == 160
    assert table["limits_deg"] == {"base": [-80, 85]}
    assert table["lengths"] == {"hand_mm": 97.5}


# `armdrive config` as a command: list, show, check and set-default.


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


@every_row("name", ["bnech", "bench.toml", "sim:gcode", "broken"])
def test_an_unknown_arm_cannot_be_the_default(call, name):
    write_arm_file("bench", PLAIN)
    write_arm_file("broken", "model = 3\n")
    call.refused("config", "set-default", name, code=2)


def test_an_arm_is_shown_as_it_is_understood(call):
    write_arm_file("bench", PLAIN + "[motor_signs]\nelbow = -1\n[lengths]\nhand_mm = 97\n")
    said = call("config", "show", "bench", code=0).out
    assert "\n# a stop while jogging takes at most" in said
    view = call("config", "show", "bench", "--json", code=0).json
    table = tomllib.loads(view["toml"])
    assert (table["lengths"]["hand_mm"], table["motor_signs"]["elbow"]) == (97, -1)
    assert table["limits_deg"]["elbow"] == [-149, 0]
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
    whole = call("config", "show", "bench", code=0).out
    ours, again = (
        load_arm(path),
        parse_arm(tomllib.loads(whole), name="bench", folder=path.parent),
    )
    assert again == ours
    assert again.calibration == ours.calibration


PARK = PLAIN + "[park]\nx_mm = {}\ny_mm = 0\nz_mm = {}\npitch_deg = -90\n"
HOMING = PLAIN + "[homing.joints_deg]\nbase = 0\nshoulder = 170\nelbow = 0\nwrist_pitch = 0\n"
ON = '[connection]\ndialect = "{}"\nport = "{}"\n'
MISSPELT = 'model = "teachmover"\nspede = 1\n[connection]\nbuad = 9600\nport = "COM1"\n'
CHECKED = [
    # an arm file, the exit code of its check, and what is said
    ('model = "teachmover"\n', 0, "bench: fine", "only be simulated"),
    (MISSPELT, 2, "2 problems", "'spede'", "'buad'"),
    ('model = "minimover5-mks"\n' + ON.format("mks", "can:slcan:/dev/x?bitrate500000"), 2,
     "write options as ?bitrate=500000"),
    ('model = "teachmover"\n' + ON.format("teachmover", "can:socketcan:can0"), 2,
     "is not on a bus: correct the port or the dialect"),
    (PARK.format(900, 0), 2, "[park]", "1 problem"),
    (PARK.format(100, -40), 2, "below the table"),
    ('model = "alpha2"\n', 2, "motor steps of the"),
    (PLAIN + '[gripper]\nkind = "none"\n', 2, "has 5 motors"),
    (HOMING + "wrist_roll = 0\n", 2, "homing.joints_deg.shoulder is 170"),
    ("model = ", 2, "not valid TOML"),
]  # fmt: skip


@every_row("row", CHECKED, ids=lambda row: row[0])
def test_a_check_names_every_problem_with_its_key_and_remedy(call, row):
    text, code, *said = row
    write_arm_file("bench", text)
    shown = call("config", "check", "bench", code=code).out
    assert [words for words in said if words not in shown] == []
    view = call("config", "check", "bench", "--json", code=code).json
    assert (view["ok"], bool(view["problems"])) == (code == 0, code != 0)


def test_an_arm_whose_adapter_is_known_by_its_number_has_a_port(call):
    write_bench("", usb_serial="A50285BI")
    for words in (("list",), ("show", "bench"), ("check", "bench")):
        said = call("config", *words, code=0).out
        assert "no port" not in said
        assert words == ("check", "bench") or "A50285BI" in said


def test_a_missing_arm_file_is_reported_as_in_the_list(call):
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
