"""One reading finds every problem: in each section of an arm file, and in its model file."""

import tomllib

import pytest

from armdrive.registry.arm_files import arm_problems

SECTIONS = {
    "": ("tittle = 'x'\nsteps_per_mm = -3\nbacklash_mm = 99",
         ["did you mean 'title'?", "steps_per_mm", "backlash_mm must be from 0 to 5"]),
    "connection": ("dialect = 'grbl'\nport = 7\nbaud = 10\nspeed = 9", ["connection.port",
                   "connection.baud must be from 50 to 4000000, not 10", "'speed'"]),
    "motion": ("jog_burst_s = 9\nplanned_burst_s = 'fast'", [
               "motion.jog_burst_s must be from 0.02 to 0.5, not 9", "motion.planned_burst_s"]),
    "gripper": ("kind = 'vacuum'\ntrip_force_n = 50\nmax_force_n = 10", ["gripper.kind",
                "gripper.max_force_n"]),
    "grbl": (("axes = 'XXZ'\nunit = 'inch'\nrates = [0.0, 5]\nservo = 'M9'\noutputs = ['foo']\n"
              "mute_s = 100\nhard_limits_checked = 'yesterday'\nwrong = 1"),
             ["grbl.axes", "grbl.unit", "grbl.rates[0]", "grbl.servo", "grbl.outputs",
              "grbl.mute_s", "grbl.hard_limits_checked", "'wrong'"]),
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


def test_one_reading_names_the_problems_of_every_section(tmp_path):
    found = problems_of(text_of(SECTIONS), tmp_path)
    wanted = [place for _, places in SECTIONS.values() for place in places]
    for place in wanted:
        assert any(place in sentence for sentence in found), place
    assert len(found) == len(wanted)


BOX = 'name = "vice"\nmin_mm = [150, -60, 0]\nmax_mm = [230, 60, 60]\n'
SUM = "[[guards.sums]]\njoints = { elbow = 1 }\nrange_deg = [0, 1]\n"
PROBLEMS = [
    ("[motion]\njog_burst = 0.1", ["did you mean 'jog_burst_s'"]),
    ("[motion]\njog_burst_s = nan", ["motion.jog_burst_s"]),
    ("motion = 3\ngripper = 4", ["motion must be a table", "gripper must be a table"]),
    ("[connection]\nbaud = 9600.0\nraise_dtr = 1", ["must be a whole number", "true or false"]),
    ("[gripper]\napproach_steps = 0\nmax_force_n = 1", ["approach_steps", "max_force_n"]),
    ('[gripper]\nkind = "claw"\nmax_force_n = 201', ["gripper.kind", "max_force_n"]),
    ("[teachmover]\nspeed_doubt = 0\ngrip_bit = 8", ["speed_doubt", "grip_bit"]),
    ("[teachmover]\nspeed_table = [[0, 30]]", ["two or more pairs"]),
    ("[teachmover]\nspeed_table = [[0, 30], [300, 40]]", ["0 to 245"]),
    ("[teachmover]\nspeed_table = [[0, 30], [9, 20]]", ["rising"]),
    ("[limits_deg]\nbase = [90, -90]\nelbow = 90", ["below the second", "elbow must be a pair of"]),
    ("[limits_deg]\nknee = [1, 2]", ["unknown key 'knee'"]),
    ("[park]\nx_mm = 1\nz = 3", ["'z'", "missing y_mm, z_mm, pitch_deg"]),
    ("park = 3\nhoming.joints_deg = 4", ["homing.joints_deg must be", "park must be"]),
    ("[lengths]\nhand = 1\nupper_arm_mm = 1e9", ["hand_mm", "upper_arm_mm"]),
    ("[steps_per_turn]\nbase = -1\nelbow = 0", ["steps_per_turn.base", "steps_per_turn.elbow"]),
    ("[steps_per_turn]\ngripper = 10", ["gripper"]),
    ("[homing]\ngroups = [[9]]\n[homing.joints_deg]\nbase = 1\nknee = 2",
     ["'knee'", "missing shoulder", "homing.groups"]),
    *((f"[homing]\ngroups = {groups}", ["joints_deg] is missing", "by number, 1 to 6, in"])
      for groups in ("[[0]]", "[[7]]", "[[]]", "[[1], [-2]]")),
    ("[homing]\ngroups = [[1, 2], [3, 2]]", ["joints_deg] is missing", "listed twice"]),
    ("[homing]\ngroups = [[3], [1, 5, 6]]",
     ["joints_deg] is missing", "2, 4 would seek no switch"]),
    ("frames.tool.x_mm = 1\nframes.a.x = 1\ntool.along_mm = 1e9", ["along", "tool:", "'x'"]),
    # backlash
    ("[backlash_deg]\nbase = -1\nwrist = 1", ["'wrist'", "base must be from 0 to 10, not -1"]),
    ('[backlash_deg]\nbase = "much"\ngripper = 1', ["'gripper'", "backlash_deg.base"]),
    ('backlash_mm = 1\n[gripper]\nkind = "servo"', ["this arm has none"]),
    ("backlash_deg = 3\nbacklash = 3", ["backlash_mm", "backlash_deg must be a table"]),
    # guards
    ("[guards]\nbase_radius_mm = 60", ["radii_mm = [30, 30, 30] for upper arm, forearm"]),
    ("[[guards.boxes]]\n" + BOX, ["how thick the links are"]),
    ("[guards]\nradii_mm = [30, 30]", ["guards.radii_mm: a radius is needed for each of upper"]),
    ("[guards]\nradii_mm = [30, -1, 30]", ["guards.radii_mm[1] must be from 0 to 1000"]),
    ("[guards]\nradii_mm = 1\nboxes = 3", ["radii_mm must be a list", "boxes must be a list"]),
    ("[guards]\ntolerance_mm = -1", ["guards.tolerance_mm must be from 0 to 50"]),
    ("[guards]\nradius_mm = 30", ["unknown key 'radius_mm' in [guards]; did you mean"]),
    ("[[guards.boxes]]\nmin_mm = 3\n[[guards.boxes]]\nsize = 1\n",
     ["boxes[1].min_mm", "boxes[1]] is missing name, max_mm", "'size'",
      "boxes[2]] is missing name, min_mm, max_mm"]),
    ("[[guards.boxes]]\n" + BOX.replace("-60, 0]", "-60]"),
     ["boxes[1].min_mm must have 3 entries, not 2"]),
    ("[[guards.boxes]]\n" + BOX.replace("230", "150"), ["needs a x of min_mm below"]),
    (("[[guards.boxes]]\n" + BOX) * 2, ["different names, not vice, vice"]),
    ("[guards]\nforearm_elevation_deg = [10, 0]", ["must be below the second"]),
    ("[[guards.sums]]\njoints = { elbow = 1 }", ["sums[1].range_deg must be a pair"]),
    ("[[guards.sums]]\nrange_deg = [0, 1]", ["guards.sums[1] needs joints"]),
    (SUM.replace("elbow", "ellbow"), ["did you mean 'elbow'", "needs joints"]),
    (SUM + "name = 3", ["name must be"]),
    (SUM * 2, ["different names, not elbow, elbow"]),
]  # fmt: skip


@pytest.mark.parametrize(("text", "wanted"), PROBLEMS)
def test_one_reading_finds_everything_that_is_wrong(tmp_path, text, wanted):
    found = problems_of(f'model = "teachmover"\n{text}', tmp_path)
    assert len(found) == len(wanted), found
    for place, sentence in zip(wanted, found, strict=True):
        assert place in sentence


@pytest.mark.parametrize(
    ("model", "dialect", "unknown"),
    [
        ("minmover5", "grbl", ["minmover5"]),
        ("minimover5", "grlb", ["cia402; did you mean 'grbl'?"]),
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
[limits_deg]
one = [2, 1]
[speeds_deg_s]
one = 0
[[motors]]
name = "one"
steps_per_turn = 0
colour = "red"
[fingers]
speed_mm_s = 0
[park]
x_mm = 1
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
    for place in (
        "mks.ids", "mks.microsteps", "mks.segment_s", "limits_deg.one", "speeds_deg_s.one",
        "motors[1].steps_per_turn", "unknown key 'colour'", "fingers.speed_mm_s",
        "[fingers] is missing range_mm", "[park] is missing",
    ):  # fmt: skip
        assert any(place in each for each in in_file), place
