"""The [guards] of an arm file: what is taken over, and what is refused with the key's name."""

import math
import re
import tomllib

import pytest
from chain_files import six_joints
from pages import page_path

from armdrive.config.sections import guard_table, guards_of
from armdrive.errors import ArmFileError
from armdrive.registry.arm_files import parse_arm
from armdrive.text.toml import Problems, TomlTable, value
from kinematics import Guards, preset
from kinematics.guards.shapes import Box

WHOLE = """
model = "teachmover"
[guards]
tolerance_mm = 0.5
radii_mm = [35, 30, 25]
base_radius_mm = 40
base_top_mm = 120
forearm_elevation_deg = [-110, 45]
[[guards.boxes]]
name = "vice"
min_mm = [150, -60, 0]
max_mm = [230, 60, 60]
[[guards.sums]]
name = "cable"
joints = { base = 1, wrist_roll = -0.5 }
range_deg = [-200, 200]
"""
BOX = 'name = "vice"\nmin_mm = [150, -60, 0]\nmax_mm = [230, 60, 60]\n'


def guards(text):
    return parse_arm(tomllib.loads(text), name="bench").model.guards


def read_guards(table, arm, known):
    problems = Problems()
    found = guards_of(TomlTable(table, "guards", problems), arm, known)
    problems.require_none()
    return found


def test_boxes_radii_the_base_and_sums_are_taken_over():
    found = guards(WHOLE)
    assert (found.tolerance_mm, found.radii_mm) == (0.5, (35.0, 30.0, 25.0))
    assert (found.base_radius_mm, found.base_top_mm) == (40.0, 120.0)
    assert found.boxes == (Box("vice", (150.0, -60.0, 0.0), (230.0, 60.0, 60.0)),)
    forearm, cable = found.sums
    assert forearm.shares == (("shoulder", 1.0), ("elbow", 1.0))
    assert math.degrees(forearm.low_rad) == pytest.approx(-110)
    assert (cable.name, cable.shares) == ("cable", (("base", 1.0), ("wrist_roll", -0.5)))
    assert found.inner_radius_mm == preset("teachmover").guards.inner_radius_mm


def test_a_file_that_says_nothing_has_the_presets_guards():
    assert guards('model = "teachmover"') == preset("teachmover").guards
    empty = "[guards]\nradii_mm = []\nboxes = []\nsums = []\n"
    assert guards('model = "teachmover"\n' + empty) == preset("teachmover").guards


def test_a_sum_without_a_name_is_called_after_its_joints():
    sums = "[[guards.sums]]\njoints = { elbow = 1, wrist_pitch = 1 }\nrange_deg = [-90, 90]\n"
    assert guards('model = "teachmover"\n' + sums).sums[0].name == "elbow + wrist_pitch"


def test_what_is_written_out_means_the_same_guards():
    found = guards(WHOLE)
    table = tomllib.loads(
        "\n".join(f"{key} = {value(one)}" for key, one in guard_table(found).items())
    )
    again = read_guards(table, preset("teachmover").arm, Guards(inner_radius_mm=None))
    assert again.boxes == found.boxes
    assert again.radii_mm == found.radii_mm
    assert again.inner_radius_mm == found.inner_radius_mm
    for one, other in zip(again.sums, found.sums, strict=True):
        assert (one.name, one.shares) == (other.name, other.shares)
        assert (one.low_rad, one.high_rad) == pytest.approx((other.low_rad, other.high_rad))
    nothing = guard_table(Guards(inner_radius_mm=None))
    assert "inner_radius_mm" not in nothing
    assert not {"radii_mm", "boxes", "sums"} & nothing.keys()


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


def test_the_forearms_elevation_is_for_arms_that_have_a_forearm(tmp_path):
    with pytest.raises(ArmFileError, match=r"write \[\[guards.sums\]\]"):
        read_guards({"forearm_elevation_deg": [0, 1]}, _Joints(), Guards())


class _Joints:
    joint_names = ("waist", "bend")


def test_the_page_about_guards_shows_a_file_that_is_read():
    page = page_path("guards-and-backlash")
    shown = re.search(r"```toml\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)[1]
    found = guards(shown)
    assert found.boxes[0].name == "vice"
    assert [one.name for one in found.sums] == ["forearm elevation", "cable of the hand"]
    arm = preset("teachmover")
    assert found.violations(arm.arm, arm.arm.ik(arm.reference.pose)) == ()
    assert set(tomllib.loads(shown)["guards"]) >= {"radii_mm", "base_top_mm", "boxes", "sums"}
