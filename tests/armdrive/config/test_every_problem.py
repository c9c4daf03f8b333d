"""One reading finds every problem: in each section of an arm file, and in its model file."""

import tomllib

import pytest

from armdrive.registry.arm_files import arm_problems

SECTIONS = {
    "": ("tittle = 'x'\nsteps_per_mm = -3\nbacklash_mm = 99", ["tittle", "steps_per_mm",
         "backlash_mm"]),
    "connection": ("dialect = 'grbl'\nport = 7\nbaud = 10\nspeed = 9", ["connection.port",
                   "connection.baud must be from 50 to 4000000, not 10", "'speed'"]),
    "motion": ("jog_burst_s = 9\nplanned_burst_s = 'fast'", ["motion.jog_burst_s",
               "motion.planned_burst_s"]),
    "gripper": ("kind = 'vacuum'\ntrip_force_n = 50\nmax_force_n = 10", ["gripper.kind",
                "gripper.max_force_n"]),
    "grbl": (("axes = 'XXZ'\nunit = 'inch'\nrates = [0.0, 5]\nservo = 'M9'\noutputs = ['foo']\n"
              "mute_s = 100\nhard_limits_checked = 'yesterday'\nwrong = 1"),
             ["grbl.axes", "grbl.unit", "grbl.rates[0]", "grbl.servo", "grbl.outputs",
              "grbl.mute_s", "grbl.hard_limits_checked", "'wrong'"]),
    "lengths": ("base_height_mm = 'tall'\nupper_arm = 3", ["lengths.base_height_mm",
                "'upper_arm'"]),
    "limits_deg": ("base = [10, -10]\nfoo = [1, 2]", ["limits_deg.base", "'foo'"]),
    "speeds_deg_s": ("base = 0", ["speeds_deg_s.base"]),
    "accelerations_deg_s2": ("base = -1", ["accelerations_deg_s2.base"]),
    "steps_per_turn": ("base = 0", ["steps_per_turn.base"]),
    "motor_signs": ("elbow = 2", ["motor_signs.elbow"]),
    "backlash_deg": ("base = 100", ["backlash_deg.base"]),
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


@pytest.mark.parametrize(
    ("model", "dialect", "unknown"),
    [
        ("minmover5", "grbl", ["minmover5"]),
        ("minimover5", "grlb", ["no dialect is named 'grlb'"]),
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
