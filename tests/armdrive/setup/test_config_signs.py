"""Directions found by looking: on twins whose motors really count the other way."""

import math
import tomllib
from dataclasses import replace

import pytest
from amounts import every_row
from cli_calls import write_bench
from hypothesis import given, settings
from hypothesis import strategies as st

from armdrive import Arm
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import simulated_config
from armdrive.dialog import Dialog, WrongAnswer
from armdrive.errors import ArmFileError, BadRequest
from armdrive.registry import simulate
from armdrive.registry.arm_files import load_arm
from armdrive.setup import arm_checks as finding_signs
from armdrive.setup.arm_checks import find_signs
from armdrive.setup.directions import (
    NOTHING,
    OTHER,
    DirectionCheck,
    SawMotion,
    Signs,
    ask_share,
    changes,
    conclude,
    roll_joint,
    sight,
    trials,
)
from armdrive.setup.draft import Surroundings
from armdrive.setup.filing import files_of, propose, propose_keys, write
from armdrive.setup.interview import Interview
from armdrive.setup.simulated_person import SimulatedPerson
from armdrive.sim.world.body import found_posture
from armdrive.text.toml_amend import Change, amended
from kinematics import Joints, preset

MODEL = preset("teachmover")
POSTURE = found_posture(MODEL.arm)
MOTORS = [motor.name for motor in MODEL.transmission.motors]


def really(config, motors=(1,) * 6, joints=(1,) * 6):
    """The arm as it really is, where its file believes the preset's directions."""
    transmission = config.model.transmission.with_signs(motors, joints)
    return replace(config, model=replace(config.model, transmission=transmission))


def seen_on(arm):
    """Find the directions of a simulated arm, watched by its simulated person."""
    return find_signs(Dialog(SimulatedPerson(arm.twin, lambda _line: None)), arm)


def reversed_of(names, signs):
    return tuple(sorted(name for name, sign in zip(names, signs, strict=True) if sign < 0))


@pytest.mark.parametrize(
    ("dialect", "motors", "roll"),
    [
        ("teachmover", (1, 1, 1, 1, 1, 1), 1),
        ("teachmover", (-1, 1, -1, 1, 1, -1), -1),
    ],
)
def test_reversed_motors_are_found_on_the_twin(dialect, motors, roll):
    config = simulated_config(dialect)
    twin = simulate(really(config, motors, (1, 1, 1, 1, roll, 1)))
    with Arm(connect_simulated(config, twin=twin)) as arm:
        before = twin.world.joints
        found = seen_on(arm)
        assert tuple(twin.world.joints) == pytest.approx(tuple(before), abs=1e-9)
    names = [motor.name for motor in config.model.transmission.motors]
    assert tuple(sorted(found.motors)) == reversed_of(names, motors)
    assert found.joints == (("wrist_roll",) if roll < 0 else ())
    assert found.unclear == ()


def looked(trial, motors, joints):
    """What somebody sees of an arm with these directions, worked out from its geometry."""
    truth = MODEL.transmission.with_signs(motors, joints)
    here = truth.to_motors(POSTURE, 20.0)
    there = list(here)
    there[trial.motor] += trial.steps
    (before, open0), (after, open1) = truth.to_joints(here), truth.to_joints(there)
    seen = sight(MODEL.arm, before, after, open1 - open0)
    way = next(way for way in seen.visible() if way in trial.ways)
    return trial.seen(seen.word(way), seen.word("roll"))


@settings(max_examples=20)
@given(st.tuples(*[st.sampled_from((1, -1))] * 6), st.sampled_from((1, -1)))
def test_every_combination_of_directions_is_told_apart(motors, roll):
    signs = (1, 1, 1, 1, roll, 1)
    made = trials(MODEL.arm, MODEL.transmission, POSTURE)
    found = conclude((looked(trial, motors, signs) for trial in made), "wrist_roll")
    assert tuple(sorted(found.motors)) == reversed_of(MOTORS, motors)
    assert found.joints == (("wrist_roll",) if roll < 0 else ())


class Measures:
    """A person who answers every question about a distance."""

    def __init__(self, moved):
        self.moved = moved

    def answer(self, asked):
        return asked.question.read(self.moved)


@every_row("moved, share", [("2", 1.0), ("2.3", 1.0), ("1.7", 1.0), ("3", 1.5), ("0.5", 0.25)])
def test_a_distance_by_eye_that_is_off_by_a_fifth_corrects_nothing(moved, share):
    base = trials(MODEL.arm, MODEL.transmission, POSTURE)[1]
    assert ask_share(Dialog(Measures(moved)), base, 2.0) == pytest.approx(share)


def test_the_gripper_makes_room_before_the_elbow_pulls_its_cable():
    names = [trial.name for trial in trials(MODEL.arm, MODEL.transmission, POSTURE)]
    assert names[0] == "gripper"
    assert sorted(names) == sorted(MOTORS)


def test_trials_are_small():
    for trial in trials(MODEL.arm, MODEL.transmission, POSTURE):
        joints, opening_mm = MODEL.transmission.to_joints(
            [trial.steps if motor == trial.motor else 0 for motor in range(6)]
        )
        assert max(map(abs, joints)) < 0.1
        assert abs(opening_mm) < 4.0
        assert 1.0 < trial.expected.strongest_mm < 12.0


def test_only_the_wrist_turns_the_hand_and_the_other_way():
    asked = {t.name for t in trials(MODEL.arm, MODEL.transmission, POSTURE) if t.turns_hand}
    assert asked == {"right wrist", "left wrist"}
    assert roll_joint(MODEL.arm, POSTURE) == "wrist_roll"


def test_a_motion_that_nobody_saw_stays_unclear():
    made = trials(MODEL.arm, MODEL.transmission, POSTURE)
    found = conclude([made[0].seen(NOTHING), made[1].seen(OTHER)], "wrist_roll")
    assert found.unclear == ("gripper", "base")
    assert found.motors == ()


def test_wrist_motors_that_contradict_each_other_are_unclear():
    made = {trial.name: trial for trial in trials(MODEL.arm, MODEL.transmission, POSTURE)}
    right, left = made["right wrist"], made["left wrist"]
    seen = [
        right.seen(right.expected.word(right.ways[0]), right.expected.word("roll")),
        left.seen(left.expected.word(left.ways[0]), right.expected.word("roll")),
    ]
    assert conclude(seen, "wrist_roll").unclear == ("wrist_roll",)


def test_a_direction_that_this_motor_cannot_move_is_refused():
    base = trials(MODEL.arm, MODEL.transmission, POSTURE)[1]
    assert base.seen("left").saw is SawMotion.AS_SHOWN
    with pytest.raises(WrongAnswer, match="left or right"):
        base.seen("up")


@every_row(
    "joint, word",
    zip(range(5), ("left 39", "up", "up", "up", "clockwise"), strict=True),
)
def test_positive_joints_are_seen_as_the_docs_say(joint, word):
    angles = [angle + (0.1 if at == joint else 0.0) for at, angle in enumerate(POSTURE)]
    seen = sight(MODEL.arm, POSTURE, Joints(tuple(angles)))
    assert word.split()[0] in str(seen)
    assert not {"right", "down", "counter-clockwise"} & set(str(seen).split())


def six_axis(folder):
    interview = Interview(Surroundings())
    for line in ("bench", "printed-six"):
        interview.answer(line)
    while interview.question is not None:
        interview.answer("")
    write(files_of(interview.draft), folder / "bench.toml")
    return load_arm(folder / "bench.toml")


def test_a_six_axis_board_that_is_locked_until_it_homes_is_looked_at_too(tmp_path):
    config = six_axis(tmp_path)
    truth = config.model.transmission.with_signs((-1, 1, -1, -1, 1, -1))
    twin = simulate(replace(config, model=replace(config.model, transmission=truth)))
    with Arm(connect_simulated(config, twin=twin)) as arm:
        found = seen_on(arm)
    assert found.motors == ("base", "elbow", "forearm_roll", "wrist_roll")
    assert found.joints == found.unclear == ()


def test_ctrl_c_while_a_motor_turns_writes_nothing(monkeypatch, call):
    def interrupted(*_):
        raise KeyboardInterrupt

    path = write_bench()
    before = path.read_text(encoding="utf-8")
    monkeypatch.setattr(finding_signs, "_turn", interrupted)
    call("config", "signs", "bench", "--sim", "--yes", code=130)
    assert path.read_text(encoding="utf-8") == before


@pytest.mark.parametrize(("share", "most_deg"), [(2.0, 12.0), (10.0, 8.0)])
def test_a_motor_that_turns_farther_than_its_file_says_is_corrected(tmp_path, share, most_deg):
    """A gear that is very wrong shows at the small motion, and no larger one follows."""
    path = arm_file(tmp_path)
    config = load_arm(path)
    model = config.model
    motors = [
        replace(motor, steps_per_unit=motor.steps_per_unit / (share if each == 1 else 1.0))
        for each, motor in enumerate(model.transmission.motors)
    ]
    truth = replace(model, transmission=replace(model.transmission, motors=tuple(motors)))
    twin = simulate(replace(config, model=truth))
    with Arm(connect_simulated(config, twin=twin)) as arm:
        start, most = twin.world.joints[1], [0.0]
        person = SimulatedPerson(twin, lambda _line: None)
        look = person.look

        def watched(*, moved):
            most.append(abs(twin.world.joints[1] - start))
            look(moved=moved)

        person.look = watched
        found = find_signs(Dialog(person), arm)
    assert found.farther == {"shoulder": pytest.approx(share, rel=0.05)}
    assert found.motors == found.joints == found.unclear == ()
    assert math.degrees(max(most)) < most_deg
    propose(path, model.transmission, found).write()
    after = load_arm(path).model.transmission.motors[1].steps_per_unit
    assert after == pytest.approx(truth.transmission.motors[1].steps_per_unit, rel=0.05)


# What was seen of each motor becomes the keys of the arm file that it contradicts.


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
    assert signs == Signs()
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


def test_a_change_may_leave_a_problem_of_the_file_but_adds_none(tmp_path):
    path = arm_file(tmp_path)
    with pytest.raises(ArmFileError, match=r"with these changes .* used: gripper.kind is one of"):
        propose_keys(path, "gripper", {"kind": "hand"}, "seen")
    path.write_text(f"{PRESET}\n[gripper]\nkind = 'hand'\n", encoding="utf-8")
    assert propose_keys(path, "gripper", {"approach_steps": 8}, "seen").differs


def test_a_file_that_was_changed_meanwhile_is_left_alone(tmp_path):
    signs, transmission = checked({"elbow": SawMotion.OTHER_WAY})
    path = arm_file(tmp_path)
    proposal = propose(path, transmission, signs)
    path.write_text(PRESET + "# somebody's own\n", encoding="utf-8")
    with pytest.raises(ArmFileError, match="has changed in the meantime"):
        proposal.write()
    assert path.read_text(encoding="utf-8").endswith("# somebody's own\n")


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


@every_row(
    "change, old, new",
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


def test_a_following_motor_keeps_the_direction_and_gear_of_its_leader():
    table = tomllib.loads(SIX)
    signs = Signs(motors=("one",), farther={"one": 2.0})
    found = {each.name: each.value for each in changes(table, None, signs)}
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
