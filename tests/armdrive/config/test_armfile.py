"""Arm files: every section, what is wrong with one in words, and nothing but those words."""

import contextlib
import math
import tomllib

import pytest
from amounts import amount
from chain_files import shown_files, six_arm, six_links, written
from hypothesis import given, settings
from hypothesis import strategies as st

from armdrive.arm import Arm
from armdrive.connect.parts import assemble, connect_simulated
from armdrive.errors import ArmFileError, Refused
from armdrive.registry import simulate
from armdrive.registry.arm_files import arm_problems, load_arm, parse_arm, preset_arm
from armdrive.runtime.clock import SimulatedPace
from kinematics import KinematicsError, preset
from kinematics.spaces import Joints

WHOLE = """
model = "teachmover"
title = "The one by the window"
steps_per_mm = 15.0
[connection]
dialect = "teachmover"
port = "/dev/ttyUSB3"
baud = 4800
raise_dtr = true
[motion]
jog_burst_s = 0.1
planned_burst_s = 1.5
line_tolerance_mm = 0.25
tip_speed_mm_s = 50
unreferenced_speed = 0.1
idle_poll_s = 2
[gripper]
trip_force_n = 3
max_force_n = 20
approach_steps = 8
[teachmover]
speed_table = [[0, 25], [120, 140.5], [240, 500]]
speed_doubt = 1.5
grip_bit = 1
answer_margin_s = 0.8
[park]
x_mm = 200
y_mm = 10
z_mm = 150
pitch_deg = -80
roll_deg = 5
[reference]
x_mm = 130
y_mm = 0
z_mm = 0
pitch_deg = -90
[lengths]
base_height_mm = 194.5
upper_arm_mm = 178
forearm_mm = 177
hand_mm = 97
[limits_deg]
base = [-80, 85]
elbow = [-140, -1]
[speeds_deg_s]
shoulder = 7
[steps_per_turn]
base = 7100
"right wrist" = 1540
[motor_signs]
elbow = -1
base = 1
[joint_signs]
wrist_roll = -1
[guards]
tolerance_mm = 2
inner_radius_mm = 60
"""


def test_every_section_is_taken_over():
    config = parse_arm(tomllib.loads(WHOLE), name="window")
    assert (config.name, config.title) == ("window", "The one by the window")
    assert (config.connection.port, config.connection.baud) == ("/dev/ttyUSB3", 4800)
    assert config.connection.raise_dtr is True
    assert config.motion.planned_burst_s == 1.5
    assert config.motion.tip_speed_mm_s == 50.0
    assert config.gripper.approach_steps == 8
    assert config.device.speed_table == ((0, 25.0), (120, 140.5), (240, 500.0))
    assert (config.park.x_mm, round(config.park.pitch_deg, 6)) == (200.0, -80.0)
    assert config.model.reference.pose.x_mm == 130.0
    assert config.model.arm.lengths == (194.5, 178.0, 177.0, 97.0)
    assert config.model.arm.limits[0].low_rad == pytest.approx(math.radians(-80))
    assert config.model.arm.limits[1] == preset("teachmover").arm.limits[1]
    assert config.model.joint_speeds_rad_s[1] == pytest.approx(math.radians(7))
    motors = config.model.transmission.motors
    assert motors[0].steps_per_unit == pytest.approx(7100 / math.tau)
    assert motors[3].steps_per_unit == pytest.approx(1540 / math.tau)
    assert motors[5].steps_per_unit == pytest.approx(15.0)
    assert config.model.guards.inner_radius_mm == 60.0
    rolled = Joints.of(0, 40, -80, 0, 90)
    plain = preset("teachmover").transmission.to_motors(rolled)
    mine = config.model.transmission.to_motors(rolled)
    assert (mine[4] - mine[3]) * (plain[4] - plain[3]) < 0


def test_a_turned_motor_keeps_the_fingers_still_while_the_elbow_moves():
    config = parse_arm({"model": "teachmover", "motor_signs": {"elbow": -1}}, name="a")
    plain = preset("teachmover").transmission
    for elbow in (-20.0, -90.0):
        joints = Joints.of(0, 40, elbow, 0, 0)
        turned, straight = (
            one.to_motors(joints, 30.0) for one in (config.model.transmission, plain)
        )
        assert turned[2] == pytest.approx(-straight[2], abs=1)
        assert turned[5] == pytest.approx(straight[5], abs=1)


def test_two_lines_are_enough_and_the_arm_can_be_driven(tmp_path):
    path = tmp_path / "lab.toml"
    path.write_text('model = "teachmover"\nconnection.port = "/dev/ttyS0"\n', encoding="utf-8")
    config = load_arm(path)
    assert config.name == "lab"
    with Arm(connect_simulated(config)) as arm:
        arm.home()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "key model is missing"),
        ("model = 3", "key model is missing"),
        ('model = "teachmove"', "did you mean 'teachmover'"),
        ('model = "alpha2"\n[motor_signs]\nbase = 1', "motor steps of the"),
        ("model = ", "not valid TOML"),
    ],
)
def test_an_error_names_the_file_and_the_key(tmp_path, text, words):
    path = tmp_path / "bad.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ArmFileError) as refusal:
        load_arm(path)
    assert words in str(refusal.value)
    assert "bad.toml" in str(refusal.value)


@pytest.mark.parametrize("text", ['model = "teachmover"\n', "five"])
def test_of_endless_faults_fifty_are_reported(tmp_path, text):
    (tmp_path / "minilinks.toml").write_text(shown_files()[0], encoding="utf-8")
    table = tomllib.loads(shown_files()[1] if text == "five" else text)
    table |= {f"key{number}": 1 for number in range(20_000)}
    table["speeds_deg_s"] = {"base": 0}
    table["motors"] = [{"name": "base", "key": 1}] * 10_000
    assert len(arm_problems(table, "bench", tmp_path)) == 50


def test_a_missing_or_binary_file_is_reported(tmp_path):
    with pytest.raises(ArmFileError, match="cannot be read"):
        load_arm(tmp_path / "none.toml")
    (tmp_path / "bin.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ArmFileError, match="not UTF-8 text"):
        load_arm(tmp_path / "bin.toml")


KEYS = st.sampled_from(
    [line.partition("=")[0].strip().strip('"') for line in WHOLE.splitlines() if "=" in line]
    + [line.strip("[]") for line in WHOLE.splitlines() if line.startswith("[")]
    + ["knee", "", "shoulder", "wrist_roll", "gripper"]
)
VALUES = st.one_of(
    st.integers(),
    st.floats(),
    st.booleans(),
    st.text(max_size=5),
    st.sampled_from(["teachmover", "robko01", "minimover5", "alpha2", 10**400, -(2**70)]),
    st.lists(st.one_of(st.integers(-300, 300), st.floats(), st.text(max_size=2)), max_size=4),
    st.lists(st.lists(st.integers(-5, 500), max_size=3), max_size=4),
)
TABLES = st.dictionaries(KEYS, st.one_of(VALUES, st.dictionaries(KEYS, VALUES)))


def parse_or_refuse(table):
    with contextlib.suppress(ArmFileError, KinematicsError):
        assert parse_arm(table, name="fuzz").calibration


@settings(max_examples=amount(40, 1000))
@given(TABLES, st.sampled_from(["teachmover", "robko01", "alpha2", "minimover5"]))
def test_whatever_a_file_says_the_answer_is_an_arm_or_a_sentence(table, model):
    parse_or_refuse({**table, "model": table.get("model", model)})


SECTIONS = sorted(line.strip("[]") for line in WHOLE.splitlines() if line.startswith("["))


@settings(max_examples=amount(100, 2500))
@given(st.data())
def test_whatever_stands_in_a_section_the_answer_is_an_arm_or_a_sentence(data):
    table = tomllib.loads(WHOLE)
    section = data.draw(st.sampled_from(SECTIONS))
    key = data.draw(st.sampled_from(sorted(table[section])))
    table[section][key] = data.draw(VALUES)
    parse_or_refuse(table)


def test_the_calibration_changes_with_what_gives_steps_their_meaning_and_only_with_that():
    def of(**changes):
        return parse_arm({"model": "teachmover", **changes}, name="a").calibration

    assert of() == of(motion={"jog_burst_s": 0.1}) == of(limits_deg={"base": [-80, 80]})
    assert len({of(), of(lengths={"hand_mm": 97}), of(motor_signs={"base": -1})}) == 3
    wire = parse_arm({"model": "teachmover"}, name="a").connection
    assert of() == preset_arm("teachmover", name="b", connection=wire).calibration


ALPHA_STEPS = """
model = "alpha2"
steps_per_mm = 14.6
[steps_per_turn]
base = 7072
shoulder = 7072
elbow = 4158
"right wrist" = 1536
"left wrist" = 1536
"""
ALPHA_LENGTHS = """
[lengths]
base_height_mm = 215
upper_arm_mm = 177.8
forearm_mm = 177.8
hand_mm = 129.5
"""


def test_a_template_becomes_an_arm_when_every_number_is_filled_in():
    half = parse_arm(tomllib.loads(ALPHA_STEPS), name="half")
    assert len(half.model.transmission.motors) == 6
    assert not half.model.verified
    whole = parse_arm(tomllib.loads(ALPHA_STEPS + ALPHA_LENGTHS), name="whole")
    assert whole.model.verified


def test_a_real_template_refuses_cartesian_goals_and_moves_joints():
    config = parse_arm(tomllib.loads(ALPHA_STEPS), name="half")
    twin = simulate(config)
    arm = Arm(assemble(config, twin.link, SimulatedPace(), simulated=False))
    here = twin.world.joints
    arm.declare_posture(here)
    arm.move_j(base_deg=5)
    for call in (
        lambda: arm.move_to(arm.pose),
        lambda: arm.move_l(arm.pose),
        lambda: arm.jog_l(z_mm=2),
    ):
        with pytest.raises(Refused, match=r"unverified template values.*config show NAME"):
            call()
    assert arm.jog_j(shoulder_deg=1).note == ""
    arm.close()


# -- backlash -------------------------------------------------------------------------------------


def of(text):
    return parse_arm(tomllib.loads(text), name="lab")


TEACHMOVER = 'model = "teachmover"\n'


def test_the_arm_file_gives_backlash_in_degrees_of_what_the_motor_turns():
    text = '[backlash_deg]\nbase = 0.5\n"right wrist" = 1.0\n'
    config = of(TEACHMOVER + "backlash_mm = 0.5\n" + text)
    assert config.backlash_steps == (10, 0, 0, 4, 0, 7)
    assert of(TEACHMOVER + "[backlash_deg]\nbase = 0\n").backlash_steps == ()


def test_backlash_makes_another_calibration_and_none_makes_none():
    plain = of(TEACHMOVER)
    some, more = (of(f"{TEACHMOVER}[backlash_deg]\nbase = {deg}\n") for deg in (0.5, 1.0))
    assert len({plain.calibration, some.calibration, more.calibration}) == 3
    assert of(TEACHMOVER + "[backlash_deg]\n").calibration == plain.calibration


def test_an_arm_of_a_model_file_gives_backlash_with_its_motors(tmp_path):
    (tmp_path / "six.toml").write_text(six_links(), encoding="utf-8")
    text = six_arm().replace("sees = { elbow = 1 }", "sees = { elbow = 1 }\nbacklash_deg = 0.5")
    config = written(tmp_path, text)
    assert config.backlash_steps == (0, 0, 20, 0, 0, 0)
    assert simulate(config).world.play.widths == config.backlash_steps
