"""Arm files: every section, what is wrong with one in words, and nothing but those words."""

import contextlib
import math
import re
import tomllib

import pytest
from amounts import amount, every_row
from chain_files import shown_files, six_arm, six_joints, six_links, written
from hypothesis import given, settings
from hypothesis import strategies as st
from pages import page_path

from armdrive.arm import Arm
from armdrive.config.arm import remarks_on
from armdrive.connect.parts import assemble
from armdrive.errors import ArmFileError, Refused
from armdrive.registry import DIALECTS, simulate
from armdrive.registry.arm_files import arm_problems, load_arm, parse_arm, preset_arm
from armdrive.runtime.clock import SimulatedPace
from kinematics import KinematicsError, preset
from kinematics.guards.shapes import Box
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
speed_margin = 1.5
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


@every_row(
    "text, words",
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


VALUES = st.one_of(
    st.integers(),
    st.floats(),
    st.booleans(),
    st.text(max_size=5),
    st.sampled_from(["teachmover", "robko01", "minimover5", "alpha2", 10**400, -(2**70)]),
    st.lists(st.one_of(st.integers(-300, 300), st.floats(), st.text(max_size=2)), max_size=4),
    st.lists(st.lists(st.integers(-5, 500), max_size=3), max_size=4),
)


def parse_or_refuse(table):
    with contextlib.suppress(ArmFileError, KinematicsError):
        assert parse_arm(table, name="fuzz").calibration


SECTIONS = sorted(line.strip("[]") for line in WHOLE.splitlines() if line.startswith("["))


@settings(max_examples=amount(100, 2500))
@given(st.data())
def test_any_section_gives_an_arm_or_one_sentence(data):
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
    backlash = [of(backlash_deg={"base": deg}) for deg in (0.5, 1.0)]
    assert len({of(backlash_deg={}), of(), *backlash}) == 3
    connection = parse_arm({"model": "teachmover"}, name="a").connection
    assert of() == preset_arm("b", connection).calibration


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
    arm.reference.declare(here)
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


def test_an_arm_of_a_model_file_gives_backlash_with_its_motors(tmp_path):
    (tmp_path / "six.toml").write_text(six_links(), encoding="utf-8")
    text = six_arm().replace("sees = { elbow = 1 }", "sees = { elbow = 1 }\nbacklash_deg = 0.5")
    config = written(tmp_path, text)
    assert config.backlash_steps == (0, 0, 20, 0, 0, 0)
    assert simulate(config).world.play.widths == config.backlash_steps
    with pytest.raises(ArmFileError, match=r"the backlash of motor '\w+' is backlash_deg"):
        written(tmp_path, text.replace("backlash_deg", "backlash_mm"))


# One reading finds every problem: in each section of an arm file, and in its model file.


MISTAKES = {
    "": ("tittle = 'x'\nsteps_per_mm = -3\nbacklash_mm = 99",
         ["did you mean 'title'?", "steps_per_mm", "backlash_mm must be from 0 to 5"]),
    "connection": ("dialect = 'grbl'\nport = 7\nbaud = 10\nspeed = 9", ["connection.port",
                   "connection.baud must be from 50 to 4000000, not 10", "'speed'"]),
    "motion": ("jog_burst_s = 9\nplanned_burst_s = 'fast'", [
               "motion.jog_burst_s must be from 0.02 to 0.5, not 9", "motion.planned_burst_s"]),
    "gripper": ("kind = 'vacuum'\ntrip_force_n = 50\nmax_force_n = 10", ["gripper.kind",
                "gripper.max_force_n"]),
    "grbl": (("axes = 'XXZ'\nunit = 'inch'\ntravel = [0.0, 5]\nservo = 'M9'\noutputs = ['foo']\n"
              "report_timeout_s = 100\nhard_limits_checked = 'yesterday'\nwrong = 1"),
             ["grbl.axes", "grbl.unit", "grbl.travel[0]", "grbl.servo", "grbl.outputs",
              "grbl.report_timeout_s", "grbl.hard_limits_checked", "'wrong'"]),
    "lengths": ("base_height_mm = 'tall'\nupper_arm = 3", ["lengths.base_height_mm",
                "'upper_arm'"]),
    "limits_deg": ("base = [10, -10]\nfoo = [1, 2]", ["limits_deg.base", "'foo'"]),
    "speeds_deg_s": ("base = 0", ["speeds_deg_s.base must be from 0.01 to 3600, not 0"]),
    "accelerations_deg_s2": ("base = -1", ["accelerations_deg_s2.base"]),
    "steps_per_turn": ("base = 0", ["steps_per_turn.base"]),
    "motor_signs": ("elbow = 2", ["motor_signs.elbow must be 1 or -1"]),
    "backlash_deg": ("base = 100", ["backlash_deg.base must be from 0 to 10"]),
    "reference": ("x_mm = 1\ny_mm = 'no'", ["reference.y_mm", "[reference] is missing z_mm"]),
    "park": ("x_mm = 100", ["[park] is missing y_mm"]),
    "homing": ("opening_mm = 'x'\ngroups = [1]", ["homing.opening_mm", "homing.groups",
               "[homing.joints_deg] is missing"]),
    "frames.base": ("x_mm = 1", ["frames.base"]),
    "frames.board": ("x_mm = 'a'", ["frames.board.x_mm"]),
    "tool": ("z_mm = 1", ["[tool]"]),
    "guards": ("tolerance_mm = 100\nradii_mm = 3", ["guards.tolerance_mm", "guards.radii_mm"]),
}  # fmt: skip
"""Each section with everything wrong that its keys can have, and what names the problems."""


def problems_of(text, folder):
    return arm_problems(tomllib.loads(text), "bench", folder)


def text_of(sections):
    rest = "\n".join(f"[{name}]\n{text}" for name, (text, _) in sections.items() if name)
    return f'model = "minimover5"\n{sections[""][0]}\n{rest}'


@every_row(
    "groups, named",
    [
        ("[[2], [3], [1, 4, 5]]", []),
        ("[[1], [2, 3, 4, 5, 6]]", []),
        # the elbow's cable passes over the shoulder, those of the hand over both
        ("[[3], [2], [1, 4, 5]]", ["motor 3 (elbow) passes over the shoulder"]),
        (
            "[[2], [6], [4, 5, 1], [3]]",
            [
                "motor 6 (gripper) passes over the elbow",
                "motor 4 (right wrist) passes over the elbow",
                "motor 5 (left wrist) passes over the elbow",
            ],
        ),
    ],
)
def test_a_motor_that_homes_before_a_joint_that_it_passes_over_is_remarked(groups, named):
    angles = "base = 80\nshoulder = 80\nelbow = 0\nwrist_pitch = 0\nwrist_roll = 0"
    text = f'model = "minimover5"\n[homing]\ngroups = {groups}\n[homing.joints_deg]\n{angles}'
    remarks = [
        each for each in remarks_on(parse_arm(tomllib.loads(text), name="a")) if "homing" in each
    ]
    assert [each.partition(": ")[2].partition(",")[0] for each in remarks] == named


def test_one_reading_names_the_problems_of_every_section(tmp_path):
    found = problems_of(text_of(MISTAKES), tmp_path)
    wanted = [place for _, places in MISTAKES.values() for place in places]
    for place in wanted:
        assert any(place in sentence for sentence in found), place
    assert len(found) == len(wanted)


BOX = 'name = "vice"\nmin_mm = [150, -60, 0]\nmax_mm = [230, 60, 60]\n'
SUM = "[[guards.sums]]\njoints = { elbow = 1 }\nrange_deg = [0, 1]\n"
PROBLEMS = [
    ("[motion]\njog_burst = 0.1", ["did you mean 'jog_burst_s'"]),
    ("[motion]\njog_burst_s = nan\nidle_poll_s = 0.01",
     ["motion.jog_burst_s", "motion.idle_poll_s must be 0, or from 0.05"]),
    ("motion = 3\ngripper = 4", ["motion must be a table", "gripper must be a table"]),
    (f"[connection]\nbaud = {10**400}", ["connection.baud must be a finite number"]),
    ("[connection]\nbaud = 9600.0\nraise_dtr = 1", ["must be a whole number", "true or false"]),
    ("[teachmover]\nspeed_margin = 0\ngrip_bit = 8", ["speed_margin", "grip_bit"]),
    ("[teachmover]\nspeed_table = [[0, 30]]", ["two or more pairs"]),
    ("[limits_deg]\nbase = [90, -90]\nelbow = 90", ["below the second", "elbow must be a pair of"]),
    ("park = 3\nhoming.joints_deg = 4",
     ["homing.joints_deg must be", "is missing base", "park must be", "is missing x_mm"]),
    ("[steps_per_turn]\ngripper = 10", ["gripper"]),
    ("[homing]\ngroups = [[9]]\n[homing.joints_deg]\nbase = 1\nknee = 2",
     ["'knee'", "missing shoulder", "homing.groups"]),
    *((f"[homing]\ngroups = {groups}", ["joints_deg] is missing", "by number, 1 to 6, in"])
      for groups in ("[[0]]", "[[7]]", "[[]]", "[[1], [-2]]")),
    ("[homing]\ngroups = [[1, 2], [3, 2]]", ["joints_deg] is missing", "listed twice"]),
    ("[homing]\ngroups = [[3], [1, 5, 6]]",
     ["joints_deg] is missing", "2, 4 would seek no switch"]),
    ("frames.tool.x_mm = 1\nframes.a.x = 1\ntool.along_mm = 1e9", ["along", "tool:", "'x'"]),
    ('frames."two words".x_mm = 1', ["one word"]),
    # backlash
    ("[backlash_deg]\nbase = -1\nwrist = 1", ["'wrist'", "base must be from 0 to 10, not -1"]),
    ('backlash_mm = 1\n[gripper]\nkind = "servo"', ["this arm has none"]),
    ("backlash_deg = 3\nbacklash = 3", ["backlash_mm", "backlash_deg must be a table"]),
    # guards
    ("[guards]\nbase_radius_mm = 60", ["radii_mm = [30, 30, 30] for upper arm, forearm"]),
    ("[[guards.boxes]]\n" + BOX, ["how thick the links are"]),
    ("[guards]\nradii_mm = [30, 30]", ["guards.radii_mm: a radius is needed for each of upper"]),
    ("[[guards.boxes]]\nmin_mm = 3\n[[guards.boxes]]\nsize = 1\n",
     ["boxes[1].min_mm", "boxes[1]] is missing name, max_mm", "'size'",
      "boxes[2]] is missing name, min_mm, max_mm"]),
    ("[[guards.boxes]]\n" + BOX.replace("-60, 0]", "-60]"),
     ["boxes[1].min_mm must have 3 entries, not 2"]),
    ("[[guards.boxes]]\n" + BOX.replace("230", "150"), ["needs a x of min_mm below"]),
    (("[[guards.boxes]]\n" + BOX) * 2, ["different names, not vice, vice"]),
    (SUM.replace("[0, 1]", "[10, 0]"), ["must be below the second"]),
    ("[[guards.sums]]\njoints = { elbow = 1 }", ["sums[1].range_deg must be a pair"]),
    ("[[guards.sums]]\nrange_deg = [0, 1]", ["guards.sums[1] needs joints"]),
    (SUM.replace("elbow", "ellbow"), ["did you mean 'elbow'", "needs joints"]),
    (SUM + "name = 3", ["name must be"]),
    (SUM * 2, ["different names, not elbow, elbow"]),
]  # fmt: skip


@every_row("text, wanted", PROBLEMS)
def test_all_mistakes_of_a_file_are_found_at_once(tmp_path, text, wanted):
    found = problems_of(f'model = "teachmover"\n{text}', tmp_path)
    assert len(found) == len(wanted), found
    for place, sentence in zip(wanted, found, strict=True):
        assert place in sentence


@every_row(
    "model, dialect, unknown",
    [
        ("minmover5", "grbl", ["minmover5"]),
        ("minimover5", "grlb", [f"{list(DIALECTS)[-1]}; did you mean 'grbl'?"]),
        ("minmover5", "grlb", ["minmover5", "no dialect is named 'grlb'"]),
    ],
)
def test_an_unknown_model_or_dialect_hides_no_other_problem(tmp_path, model, dialect, unknown):
    text = f"""
        model = "{model}"
        title = 3
        tittle = "x"
        [connection]
        dialect = "{dialect}"
        baud = 10
        [motion]
        jog_burst_s = 9
        [grbl]
        unit = "steps"
        """
    found = problems_of(text, tmp_path)
    wanted = [*unknown, "title must be text", "connection.baud", "motion.jog_burst_s"]
    if model == "minimover5":  # the keys at the top depend on the model
        wanted.append("unknown key 'tittle'")
    for place in wanted:
        assert any(place in sentence for sentence in found), place
    assert len(found) == len(wanted)


LINKED = """\
model = "six.toml"
[connection]
dialect = "mks"
[mks]
ids = [1, 1, 5]
microsteps = 5
segment_s = 0.001
"""
SIX = """\
name = 3
convention = "other"
[base]
x_mm = "far"
[[links]]
joint = "one"
d_mm = "long"
theta = 1
[[links]]
kind = "round"
[[links]]
low_deg = 5
high_deg = -5
"""


def test_the_problems_of_a_model_file_hide_none_of_the_arm_file(tmp_path):
    path = tmp_path / "six.toml"
    path.write_text(SIX, encoding="utf-8")
    found = problems_of(LINKED, tmp_path)
    in_model = [each.removeprefix(f"{path}: ") for each in found if each.startswith(str(path))]
    for place in (
        "name must be text", "convention is one of", "base.x_mm", "links[1].d_mm",
        "unknown key 'theta' in [links[1]]", "links[2].kind", "links[3]: a joint's low limit",
    ):  # fmt: skip
        assert any(each.startswith(place) for each in in_model), place
    in_file = [each for each in found if not each.startswith(str(path))]
    for place in ("mks.ids", "mks.microsteps", "mks.segment_s"):
        assert any(place in each for each in in_file), place


# The [guards] of an arm file: what is taken over, and what is refused with the key's name.


GUARDS = """
model = "teachmover"
[guards]
tolerance_mm = 0.5
radii_mm = [35, 30, 25]
base_radius_mm = 40
base_top_mm = 120
[[guards.boxes]]
name = "vice"
min_mm = [150, -60, 0]
max_mm = [230, 60, 60]
[[guards.sums]]
name = "forearm elevation"
joints = { shoulder = 1, elbow = 1 }
range_deg = [-110, 45]
[[guards.sums]]
name = "cable"
joints = { base = 1, wrist_roll = -0.5 }
range_deg = [-200, 200]
"""


def guards(text):
    return parse_arm(tomllib.loads(text), name="bench").model.guards


def test_boxes_radii_the_base_and_sums_are_taken_over():
    found = guards(GUARDS)
    assert (found.tolerance_mm, found.radii_mm) == (0.5, (35.0, 30.0, 25.0))
    assert (found.base_radius_mm, found.base_top_mm) == (40.0, 120.0)
    assert found.boxes == (Box("vice", (150.0, -60.0, 0.0), (230.0, 60.0, 60.0)),)
    forearm, cable = found.sums
    assert forearm.shares == (("shoulder", 1.0), ("elbow", 1.0))
    assert math.degrees(forearm.low_rad) == pytest.approx(-110)
    assert (cable.name, cable.shares) == ("cable", (("base", 1.0), ("wrist_roll", -0.5)))
    known = preset("teachmover").guards
    assert found.inner_radius_mm == known.inner_radius_mm
    assert guards('model = "teachmover"') == known
    empty = "[guards]\nradii_mm = []\nboxes = []\nsums = []\n"
    assert guards('model = "teachmover"\n' + empty) == known


def test_an_arm_of_a_model_file_has_boxes_and_sums_of_its_own_joints(tmp_path):
    config = six_joints(
        tmp_path,
        "[guards]\nradii_mm = [60, 60, 60]\n[[guards.boxes]]\n"
        + BOX
        + "[[guards.sums]]\njoints = { shoulder = 1, elbow = -1 }\nrange_deg = [-250, 250]\n",
    )
    assert config.model.guards.boxes[0].name == "vice"
    assert config.model.guards.sums[0].name == "shoulder + elbow"
    assert config.model.guards.inner_radius_mm is None


def test_the_page_about_guards_shows_a_file_that_is_read():
    page = page_path("guards-and-backlash")
    shown = re.search(r"```toml\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)[1]
    found = guards(shown)
    assert found.boxes[0].name == "vice"
    assert [one.name for one in found.sums] == ["forearm elevation", "cable of the hand"]
    arm = preset("teachmover")
    assert found.violations(arm.arm, arm.arm.ik(arm.reference.pose)) == ()
    assert set(tomllib.loads(shown)["guards"]) >= {"radii_mm", "base_top_mm", "boxes", "sums"}
