"""What was seen of each motor becomes the keys of the arm file that it contradicts."""

import tomllib

import pytest

from armdrive.errors import ArmFileError, BadRequest
from armdrive.registry.arm_files import load_arm
from armdrive.setup.directions import DirectionCheck, SawMotion, Signs, changes
from armdrive.setup.filing import propose
from armdrive.sim.world.body import found_posture
from armdrive.text.toml_amend import Change, amended
from kinematics import preset

PRESET = """\
# My own arm.
model = "teachmover"
title = "bench"        # on the left

[connection]
dialect = "teachmover"
port = ""
"""

SIX = """\
model = "models/six.toml"

[connection]
dialect = "grbl"
port = ""

# what the board drives
[[motors]]
name = "one"
steps_per_turn = 64000        # 200 x 16 x 20:1
sees = { one = 1 }

[[motors]]
name = "two"
steps_per_turn = 32000
sees = { two = -1 }
follows = { one = 1 }

[park]
x_mm = 1
"""


def arm_file(folder, text=PRESET):
    path = folder / "bench.toml"
    path.write_text(text, encoding="utf-8")
    return path


def checked(saw, **more):
    """Go through all motors of a TeachMover; `saw` names those that were not as shown."""
    model = preset("teachmover")
    check = DirectionCheck(model.arm, model.transmission, found_posture(model.arm))
    while (trial := check.trial) is not None:
        check.turned()
        check.saw(
            saw.get(trial.name, SawMotion.AS_SHOWN), more.get(trial.name.replace(" ", "_"), "")
        )
        if check.asks_hand:
            check.saw(SawMotion.AS_SHOWN)
        check.turned()
    return check.signs(), model.transmission


def test_an_arm_that_moves_as_shown_leaves_its_file_alone(tmp_path):
    signs, transmission = checked({})
    assert signs.right
    proposal = propose(arm_file(tmp_path), transmission, signs)
    assert not proposal.differs
    assert proposal.remarks == ()


def test_directions_and_gears_are_written_and_every_other_line_stays(tmp_path):
    signs, transmission = checked({"elbow": SawMotion.OTHER_WAY, "base": SawMotion.TWICE})
    proposal = propose(arm_file(tmp_path), transmission, signs)
    proposal.write()
    text = proposal.path.read_text(encoding="utf-8")
    for line in PRESET.splitlines():
        assert line in text
    before = transmission.motors[0].steps_per_unit
    after = load_arm(proposal.path).model.transmission
    assert after.motors[0].steps_per_unit == pytest.approx(before / 2.0)
    assert tomllib.loads(text)["motor_signs"] == {"elbow": -1}
    assert any(line.startswith("+elbow = -1") for line in proposal.difference)


def test_checked_once_more_the_direction_goes_back(tmp_path):
    signs, transmission = checked({"elbow": SawMotion.OTHER_WAY})
    path = arm_file(tmp_path)
    propose(path, transmission, signs).write()
    propose(path, transmission, signs).write()
    assert tomllib.loads(path.read_text(encoding="utf-8"))["motor_signs"] == {"elbow": 1}


def test_half_as_far_at_the_fingers_is_of_their_own_key(tmp_path):
    signs, transmission = checked({"gripper": SawMotion.HALF})
    path = arm_file(tmp_path)
    propose(path, transmission, signs).write()
    after = load_arm(path).model.transmission.motors[-1].steps_per_unit
    assert abs(after) == pytest.approx(2.0 * abs(transmission.motors[-1].steps_per_unit))


def test_motors_of_a_preset_that_changed_places_are_a_matter_of_plugs(tmp_path):
    signs, transmission = checked(
        {"base": SawMotion.ANOTHER, "elbow": SawMotion.ANOTHER}, base="elbow", elbow="base"
    )
    proposal = propose(arm_file(tmp_path), transmission, signs)
    assert not proposal.differs
    assert "swap their plugs" in proposal.remarks[0]
    assert signs.unclear == ()


def test_a_motor_that_moved_nothing_is_named(tmp_path):
    signs, transmission = checked({"shoulder": SawMotion.NOT_AT_ALL})
    remarks = propose(arm_file(tmp_path), transmission, signs).remarks
    assert remarks == ("unclear: shoulder. Check plugs and drivers, then check again",)


def test_a_file_that_was_changed_meanwhile_is_left_alone(tmp_path):
    signs, transmission = checked({"elbow": SawMotion.OTHER_WAY})
    path = arm_file(tmp_path)
    proposal = propose(path, transmission, signs)
    path.write_text(PRESET + "# somebody's own\n", encoding="utf-8")
    with pytest.raises(ArmFileError, match="has changed in the meantime"):
        proposal.write()
    assert path.read_text(encoding="utf-8").endswith("# somebody's own\n")


def test_motors_of_a_list_change_places_with_all_that_is_said_of_them():
    after = amended(SIX, (), {"one": "two", "two": "one"})
    motors = tomllib.loads(after)["motors"]
    assert [each["name"] for each in motors] == ["two", "one"]
    assert motors[1]["steps_per_turn"] == 64000
    assert "# 200 x 16 x 20:1" in after
    assert after.index("# what the board drives") < after.index("[[motors]]")


def test_a_key_of_one_motor_of_several_is_changed():
    after = amended(SIX, [Change(("motors", 1, "sees"), {"two": 1}, "seen")])
    assert tomllib.loads(after)["motors"][1]["sees"] == {"two": 1}
    assert tomllib.loads(after)["motors"][0]["sees"] == {"one": 1}


@pytest.mark.parametrize("line", ["motor_signs = { elbow = 1 }", "motor_signs.elbow = 1"])
def test_a_key_is_changed_however_its_table_is_written(line):
    after = amended(f"{line}  # mine\n{PRESET}", [Change(("motor_signs", "elbow"), -1, "seen")])
    assert after == f"{line.replace('1', '-1')}  # mine\n{PRESET}"


def test_a_layout_that_cannot_be_changed_is_refused_with_what_to_write():
    with pytest.raises(ArmFileError, match=r"by hand.*motor_signs\.elbow = -1"):
        amended(f"motor_signs = 3\n{PRESET}", [Change(("motor_signs", "elbow"), -1, "seen")])


AROUND = """\
# heading

model = "teachmover"   # the left one
steps_per_mm = 15      # measured

# the wire
[connection]
port = ""   # none yet
  # indented

# what turns
[motor_signs]
"left wrist" = 1
"""


@pytest.mark.parametrize(
    ("change", "old", "new"),
    [
        (("steps_per_mm", 7.5), "steps_per_mm = 15 ", "steps_per_mm = 7.5 "),
        (("connection", "port", "COM1"), 'port = ""', 'port = "COM1"'),
        (("connection", "baud", 4800), "none yet\n", "none yet\nbaud = 4800\n"),
        (("title", "mine"), "measured\n", 'measured\ntitle = "mine"\n'),
        (("motor_signs", "base", -1), '"left wrist" = 1\n', '"left wrist" = 1\nbase = -1\n'),
        (("joint_signs", "base", -1), "= 1\n", "= 1\n\n[joint_signs]\nbase = -1\n"),
    ],
)
def test_comments_blank_lines_and_the_order_of_a_file_survive_a_change(change, old, new):
    *path, value = change
    assert old in AROUND
    assert amended(AROUND, [Change(tuple(path), value)]) == AROUND.replace(old, new)


def test_what_follows_a_motor_follows_its_direction_and_its_gear():
    table = tomllib.loads(SIX)
    signs = Signs(motors=("one",))
    found = {each.name: each.value for each in changes(table, None, signs, {"one": 32000.0})}
    assert found["motors.0.sees"] == {"one": -1}
    assert found["motors.0.steps_per_turn"] == 32000
    assert found["motors.1.follows"] == {"one": -2}


def test_nothing_is_said_of_a_motor_that_was_not_turned():
    model = preset("teachmover")
    check = DirectionCheck(model.arm, model.transmission, found_posture(model.arm))
    with pytest.raises(BadRequest, match="turn it first"):
        check.saw(SawMotion.AS_SHOWN)
    assert check.steps(6)[5] == check.trial.steps
    check.turned()
    assert check.steps(6)[5] == -check.trial.steps
    name = check.trial.name
    check.saw(SawMotion.AS_SHOWN)
    assert check.trial.name == name  # it has to come back before the next one's turn
    with pytest.raises(BadRequest, match="bring it back"):
        check.saw(SawMotion.AS_SHOWN)
    check.turned()
    assert check.trial.name != name


def test_a_reversed_wrist_is_told_from_a_reversed_roll():
    model = preset("teachmover")
    check = DirectionCheck(model.arm, model.transmission, found_posture(model.arm))
    while check.trial is not None:
        check.turned()
        check.saw(SawMotion.AS_SHOWN)
        if check.asks_hand:
            check.saw(SawMotion.OTHER_WAY)
        check.turned()
    assert check.signs().joints == ("wrist_roll",)
    assert check.after is None
    assert check.signs().motors == ()
