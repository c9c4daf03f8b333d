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
from armdrive.dialog import Dialog
from armdrive.errors import ArmFileError, BadRequest
from armdrive.registry import simulate
from armdrive.registry.arm_files import load_arm
from armdrive.setup import arm_checks
from armdrive.setup.arm_checks import find_signs
from armdrive.setup.directions import (
    TRIAL_SPEED,
    DirectionCheck,
    SawMotion,
    SeenMotion,
    Signs,
    changes,
    conclude,
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
TRIALS = trials(MODEL.arm, MODEL.transmission, POSTURE)

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


# -- The dialog with a connected arm -----------------------------------------------------------


def seen_on(config, transmission, look=lambda twin: None, ask=None):
    """Find the directions of an arm that really has this transmission; the model may be wrong.

    Its simulated person watches it; `look` is called whenever that person looks. With `ask`
    somebody else answers.
    """
    twin = simulate(replace(config, model=replace(config.model, transmission=transmission)))
    person = SimulatedPerson(twin, lambda _line: None, ask)
    watch = person.look

    def watched(*, moved):
        look(twin)
        watch(moved=moved)

    person.look = watched
    with Arm(connect_simulated(config, twin=twin)) as arm:
        before = twin.world.joints
        found = find_signs(Dialog(person), arm)
        assert tuple(twin.world.joints) == pytest.approx(tuple(before), abs=1e-9)
    return found


def reversed_of(names, signs):
    return tuple(sorted(name for name, sign in zip(names, signs, strict=True) if sign < 0))


@pytest.mark.parametrize(("motors", "roll"), [((1,) * 6, 1), ((-1, 1, -1, 1, 1, -1), -1)])
def test_reversed_motors_are_found_on_the_twin(motors, roll):
    config = simulated_config("teachmover")
    truth = config.model.transmission.with_signs(motors, (1, 1, 1, 1, roll, 1))
    found = seen_on(config, truth)
    assert tuple(sorted(found.motors)) == reversed_of(MOTORS, motors)
    assert found.joints == (("wrist_roll",) if roll < 0 else ())
    assert found.unclear == ()
    assert found.farther == {}


def test_a_six_axis_board_that_is_locked_until_it_homes_is_looked_at_too(tmp_path):
    interview = Interview(Surroundings())
    for line in ("bench", "printed-six"):
        interview.answer(line)
    while interview.question is not None:
        interview.answer("")
    write(files_of(interview.draft), tmp_path / "bench.toml")
    config = load_arm(tmp_path / "bench.toml")
    found = seen_on(config, config.model.transmission.with_signs((-1, 1, -1, -1, 1, -1)))
    assert found.motors == ("base", "elbow", "forearm_roll", "wrist_roll")
    assert found.joints == found.unclear == ()


@pytest.mark.parametrize(("share", "most_deg"), [(2.0, 12.0), (10.0, 8.0)])
def test_a_motor_that_turns_farther_than_its_file_says_is_corrected(tmp_path, share, most_deg):
    """A gear that is very wrong shows at the small motion, and no larger one follows."""
    path = arm_file(tmp_path)
    config = load_arm(path)
    transmission = config.model.transmission
    motors = list(transmission.motors)
    motors[1] = replace(motors[1], steps_per_unit=motors[1].steps_per_unit / share)
    angles = []
    found = seen_on(
        config,
        replace(transmission, motors=tuple(motors)),
        look=lambda twin: angles.append(twin.world.joints[1]),
    )
    assert found.farther == {"shoulder": pytest.approx(share, rel=0.05)}
    assert found.motors == found.joints == found.unclear == ()
    assert math.degrees(max(abs(each - angles[0]) for each in angles)) < most_deg
    propose(path, transmission, found).write()
    after = load_arm(path).model.transmission.motors[1].steps_per_unit
    assert after == pytest.approx(motors[1].steps_per_unit, rel=0.05)


@every_row(
    "part, words, looks, unclear",
    [
        ("Switch the motors on", ("no",), 0, MOTORS),
        ("(shoulder) will turn", ("no",), 5, ["shoulder"]),
        ("Which way did it go? up", ("again", "nothing"), 7, ["elbow"]),
        ("Which way did it go? up", ("other",), 6, ["elbow"]),
    ],
)
def test_a_motor_turns_slowly_after_a_yes_and_what_nobody_saw_is_unclear(
    monkeypatch, part, words, looks, unclear
):
    answers, looked, turn = iter(words), [], Arm.move_motors

    def slowly(arm, *steps, speed):
        assert speed == TRIAL_SPEED
        turn(arm, *steps, speed=speed)

    monkeypatch.setattr(Arm, "move_motors", slowly)

    def ask(question):
        asked = part in question.words
        word = next(answers, None) if asked else None
        return question.read(word or question.default or "yes")

    config = simulated_config("teachmover")
    found = seen_on(config, config.model.transmission, looked.append, ask)
    assert list(found.unclear) == unclear
    assert len(looked) == 4 * looks
    assert found.motors == found.joints == ()


class Measures:
    """A person who answers every question about a distance."""

    def __init__(self, moved):
        self.moved = moved

    def answer(self, question):
        return question.read(self.moved)


@every_row("moved, share", [("2", 1.0), ("2.3", 1.0), ("1.7", 1.0), ("3", 1.5), ("0.5", 0.25)])
def test_a_distance_by_eye_that_is_off_by_a_fifth_corrects_nothing(moved, share):
    found = arm_checks._ask_share(Dialog(Measures(moved)), TRIALS[1], 2.0)
    assert found == pytest.approx(share)


def test_ctrl_c_while_a_motor_turns_writes_nothing(monkeypatch, call):
    def interrupted(*_):
        raise KeyboardInterrupt

    path = write_bench()
    before = path.read_text(encoding="utf-8")
    monkeypatch.setattr(arm_checks, "_turn", interrupted)
    call("config", "signs", "bench", "--sim", "--yes", code=130)
    assert path.read_text(encoding="utf-8") == before


# -- Trials and what is concluded from them ----------------------------------------------------


def looked(trial, motors, joints):
    """What somebody sees of an arm with these directions, worked out from its geometry."""
    truth = MODEL.transmission.with_signs(motors, joints)
    here = truth.to_motors(POSTURE, 20.0)
    there = list(here)
    there[trial.motor] += trial.steps
    (before, open0), (after, open1) = truth.to_joints(here), truth.to_joints(there)
    seen = sight(MODEL.arm, before, after, open1 - open0)
    way = next(way for way in seen.visible() if way in trial.ways)
    saw = SawMotion.AS_SHOWN if trial.expects(seen.word(way)) else SawMotion.OTHER_WAY
    return SeenMotion(trial, saw, trial.expects(seen.word("roll")))


@settings(max_examples=20)
@given(st.tuples(*[st.sampled_from((1, -1))] * 6), st.sampled_from((1, -1)))
def test_every_combination_of_directions_is_told_apart(motors, roll):
    signs = (1, 1, 1, 1, roll, 1)
    found = conclude((looked(trial, motors, signs) for trial in TRIALS), "wrist_roll")
    assert tuple(sorted(found.motors)) == reversed_of(MOTORS, motors)
    assert found.joints == (("wrist_roll",) if roll < 0 else ())


def test_trials_are_small_and_the_gripper_makes_room_before_the_elbow_pulls_its_cable():
    assert TRIALS[0].name == "gripper"
    assert sorted(trial.name for trial in TRIALS) == sorted(MOTORS)
    for trial in TRIALS:
        joints, opening_mm = MODEL.transmission.to_joints(
            [trial.steps if motor == trial.motor else 0 for motor in range(6)]
        )
        assert max(map(abs, joints)) < 0.1
        assert abs(opening_mm) < 4.0
        assert 1.0 < trial.expected.strongest_mm < 12.0
    assert {t.name for t in TRIALS if t.turns_hand} == {"right wrist", "left wrist"}


@every_row(
    "joint, word",
    zip(range(5), ("left 39", "up", "up", "up", "clockwise"), strict=True),
)
def test_positive_joints_are_seen_as_the_docs_say(joint, word):
    angles = [angle + (0.1 if at == joint else 0.0) for at, angle in enumerate(POSTURE)]
    seen = sight(MODEL.arm, POSTURE, Joints(tuple(angles)))
    assert word.split()[0] in str(seen)
    assert not {"right", "down", "counter-clockwise"} & set(str(seen).split())


# -- The check, motor by motor -----------------------------------------------------------------


def begun():
    return DirectionCheck(MODEL.arm, MODEL.transmission, POSTURE)


def checked(saw, hand=SawMotion.AS_SHOWN, **more):
    """Go through all motors of a TeachMover; `saw` names those that were not as shown."""
    check = begun()
    while (trial := check.trial) is not None:
        check.turned()
        check.turned()
        check.saw(
            saw.get(trial.name, SawMotion.AS_SHOWN), more.get(trial.name.replace(" ", "_"), "")
        )
        if check.asks_hand:
            check.saw(hand)
    assert check.after is None
    return check.signs()


def test_nothing_is_said_of_a_motor_that_was_not_turned_or_is_not_back():
    check = begun()
    with pytest.raises(BadRequest, match="turn it first"):
        check.saw(SawMotion.AS_SHOWN)
    assert check.steps(6)[5] == check.trial.steps
    check.turned()
    assert check.steps(6)[5] == -check.trial.steps
    with pytest.raises(BadRequest, match="bring it back"):
        check.saw(SawMotion.AS_SHOWN)
    check.turned()
    assert check.trial.name == "gripper"
    check.saw(SawMotion.AS_SHOWN)
    assert check.trial.name == "base"
    check.saw(SawMotion.NOT_AT_ALL)  # left out
    assert check.signs().unclear == ("base",)


def test_a_reversed_wrist_is_told_from_a_reversed_roll():
    signs = checked({}, hand=SawMotion.OTHER_WAY)
    assert (signs.motors, signs.joints, signs.unclear) == ((), ("wrist_roll",), ())
    assert checked({}) == Signs()
    contradicting = checked({"left wrist": SawMotion.OTHER_WAY})
    assert contradicting.unclear == ("wrist_roll",)
    with pytest.raises(BadRequest, match="only which way the hand turned"):
        checked({}, hand=SawMotion.TWICE)


# -- What was seen of each motor becomes the keys of the arm file that it contradicts ----------


@every_row(
    "saw, instead, keys, remark",
    [
        ({}, {}, {}, ""),
        ({"elbow": SawMotion.OTHER_WAY}, {}, {"motor_signs": {"elbow": -1}}, ""),
        ({"base": SawMotion.TWICE}, {}, {"steps_per_turn": {"base": 3536}}, ""),
        ({"gripper": SawMotion.HALF}, {}, {"steps_per_mm": 29.2125984}, ""),
        ({"shoulder": SawMotion.NOT_AT_ALL}, {}, {}, "unclear: shoulder. Check plugs and drivers"),
        (
            {"base": SawMotion.ANOTHER, "elbow": SawMotion.ANOTHER},
            {"base": "elbow", "elbow": "base"},
            {},
            "swap their plugs",
        ),
    ],
)
def test_an_arm_file_is_corrected_by_what_was_seen_and_every_other_line_stays(
    tmp_path, saw, instead, keys, remark
):
    proposal = propose(arm_file(tmp_path), MODEL.transmission, checked(saw, **instead))
    assert proposal.differs == bool(keys)
    proposal.write()
    text = proposal.path.read_text(encoding="utf-8")
    assert all(line in text for line in PRESET.splitlines())
    assert tomllib.loads(text) == tomllib.loads(PRESET) | keys
    assert remark in "".join(proposal.remarks)
    assert bool(remark) == bool(proposal.remarks)


def test_checked_once_more_the_direction_goes_back(tmp_path):
    signs, path = Signs(motors=("elbow",)), arm_file(tmp_path)
    propose(path, MODEL.transmission, signs).write()
    again = propose(path, MODEL.transmission, signs)
    path.write_text(path.read_text(encoding="utf-8") + "# somebody's own\n", encoding="utf-8")
    with pytest.raises(ArmFileError, match="has changed in the meantime"):
        again.write()
    propose(path, MODEL.transmission, signs).write()
    assert tomllib.loads(path.read_text(encoding="utf-8"))["motor_signs"] == {"elbow": 1}


def test_a_following_motor_keeps_the_direction_of_its_leader(tmp_path):
    table = tomllib.loads(SIX)
    motors = tuple(
        replace(MODEL.transmission.motors[0], name=row["name"], steps_per_unit=5.0, sees=sees)
        for row, sees in zip(table["motors"], ((1.0, 0.0), (0.0, 1.0)), strict=True)
    )
    transmission = replace(MODEL.transmission, motors=motors, joint_names=("one", "two"))
    signs = Signs(motors=("one",), farther={"one": 2.0})
    found = {each.name: each.value for each in changes(table, transmission, signs)}
    assert found == {
        "motors.0.steps_per_turn": pytest.approx(5.0 * math.pi),
        "motors.0.sees": {"one": -1},
        "motors.1.follows": {"one": -1},
    }


def test_a_change_may_leave_a_problem_of_the_file_but_adds_none(tmp_path):
    path = arm_file(tmp_path)
    with pytest.raises(ArmFileError, match=r"with these changes .* used: gripper.kind is one of"):
        propose_keys(path, "gripper", {"kind": "hand"}, "seen")
    path.write_text(f"{PRESET}\n[gripper]\nkind = 'hand'\n", encoding="utf-8")
    assert propose_keys(path, "gripper", {"approach_steps": 8}, "seen").differs


# -- Editing a file that a person keeps --------------------------------------------------------

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


@every_row("line", ["motor_signs = { elbow = 1 }", "motor_signs.elbow = 1"])
def test_a_key_is_changed_however_its_table_is_written(line):
    change = Change(("motor_signs", "elbow"), -1, "seen")
    assert amended(f"{line}  # mine\n{PRESET}", [change]) == (
        f"{line.replace('1', '-1')}  # mine\n{PRESET}"
    )
    with pytest.raises(ArmFileError, match=r"by hand.*motor_signs\.elbow = -1"):
        amended(f"motor_signs = 3\n{PRESET}", [change])


def test_a_key_of_one_motor_of_several_is_changed():
    after = amended(SIX, [Change(("motors", 1, "sees"), {"two": 1}, "seen")])
    assert tomllib.loads(after) == tomllib.loads(SIX.replace("two = -1", "two = 1"))
