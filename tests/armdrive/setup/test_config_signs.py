"""Directions found by looking: on twins whose motors really count the other way."""

from __future__ import annotations

import io
from dataclasses import replace

import pytest
from cli_calls import Caller
from hypothesis import given, settings
from hypothesis import strategies as st

from armdrive import Arm
from armdrive.cli.set_up.config_new import write
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import simulated_config
from armdrive.dialog.conversation import Dialog, WrongAnswer
from armdrive.registry import simulate
from armdrive.registry.arm_files import load_arm
from armdrive.setup import arm_checks as finding_signs
from armdrive.setup.arm_checks import find_signs
from armdrive.setup.directions import (
    NOTHING,
    OTHER,
    SawMotion,
    conclude,
    roll_joint,
    sight,
    trials,
)
from armdrive.setup.draft import Surroundings
from armdrive.setup.filing import files_of
from armdrive.setup.interview import Interview
from armdrive.setup.simulated_person import SimulatedPerson
from armdrive.sim.world.body import found_posture
from armdrive.storage import files as places
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
        ("teachmover", (-1, 1, -1, 1, 1, 1), -1),
        ("robko01", (1, -1, 1, -1, 1, -1), -1),
    ],
)
def test_what_is_reversed_is_found_on_the_twin(dialect, motors, roll):
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


def test_what_nobody_saw_stays_unclear():
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


@pytest.mark.parametrize(
    ("joint", "word"),
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


def test_ctrl_c_while_a_motor_turns_stops_the_arm_and_writes_nothing(monkeypatch, capsys):
    def interrupted(arm, check):
        raise KeyboardInterrupt

    monkeypatch.setattr(finding_signs, "_turn", interrupted)
    words = ("config", "new", "bench", "--template", "teachmover", "--sim")
    monkeypatch.setattr("sys.stdin", io.StringIO("\n" * 10 + "find\nyes\n\n"))
    Caller(capsys)(*words, code=130)
    assert not (places.arm_files() / "bench.toml").exists()
