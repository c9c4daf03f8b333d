"""The laws judge the physical arm, and excuse only what no driver can know or prevent.

`tests/campaign/test_campaign.py` checks that every law finds drivers that break it.
"""

import math
import random

import pytest
from amounts import every_row

from armdrive.connect.target import simulated_config
from armdrive.errors import WrongState
from armdrive.runtime.overrides import LONGEST_SIMULATED_WAIT_S
from armdrive.status import State
from kinematics import Motors
from tests.conformance.observation import Broken

from .actions import connect, move_j
from .goals import joints_reached, pose_reached
from .happenings import HAPPENINGS, Happening
from .laws import LONGEST_S, call, check_trust
from .stage import Stage
from .watch import Bound, Command, Excuse

DRAW = random.Random(1)


def a_stage(dialect: str = "teachmover") -> Stage:
    return Stage(simulated_config(dialect))


def steps(**counts: int) -> Motors:
    names = ("base", "shoulder", "elbow", "right", "left", "fingers")
    return Motors(counts.get(name, 0) for name in names)


def happening(name: str) -> Happening:
    return next(each for each in HAPPENINGS if each.name == name)


def at_rest(dialect: str) -> Stage:
    """Return an arm whose last command ended long ago."""
    stage = a_stage(dialect)
    stage.watch.begin(Command("move_j", position_known=True))
    stage.watch.end(1.0, 0.0)
    return stage


# -- What is excused, and until when --------------------------------------------------------------


@every_row(
    "dialect, name, excuse, hidden",
    [
        ("teachmover", "a byte to the device is changed", Excuse.MOTION, False),
        ("robko01", "a byte to the device is changed", Excuse.NOTHING, False),
        ("mks", "a byte to the device is changed", Excuse.NOTHING, False),
        ("mks", "a noisy line to the device", Excuse.PATH, False),
        ("mks", "a noisy line from the device", Excuse.NOTHING, False),
        ("teachmover", "a message to the device is late", Excuse.PATH, False),
        ("teachmover", "a message to the device arrives twice", Excuse.MOTION, False),
        ("grbl", "a motor loses steps", Excuse.PATH, True),
        ("mks", "a motor loses steps", Excuse.MOTION, False),
        ("teachmover", "the device goes mute", Excuse.NOTHING, False),
        ("teachmover", "the power fails and comes back", Excuse.PATH, True),  # at zero
    ],
)
def test_a_fault_excuses_what_no_driver_can_know(dialect, name, excuse, hidden):
    stage = a_stage(dialect)
    connect(stage, DRAW)
    stage.strike(happening(name), DRAW)
    assert (stage.watch.excuse, stage.watch.hidden) == (excuse, hidden)


def test_every_law_holds_again_once_the_position_is_right_and_no_fault_at_work():
    stage = a_stage("grbl")
    stage.ready()
    stage.world.lose(0, 20)
    stage.strike(happening("a motor loses steps"), DRAW)
    stage.twin.faults.end()
    stage.forget_excuses()
    assert stage.watch.hidden is False
    with stage.world.by_itself():
        stage.world.force(steps(base=20))
    stage.watch.hidden = True
    stage.forget_excuses()
    assert stage.watch.excuse is Excuse.PATH
    joints, opening_mm = stage.posture()
    stage.arm.reference.declare(joints, opening_mm=opening_mm)
    stage.forget_excuses()
    assert (stage.watch.excuse, stage.watch.hidden) == (Excuse.NOTHING, False)


def test_a_trusted_position_has_to_be_right_once_the_driver_can_know():
    stage = a_stage("grbl")
    stage.ready()
    with stage.world.by_itself():
        stage.world.force(steps(base=20))
    with pytest.raises(Broken, match="but the motors stand at"):
        check_trust(stage)
    stage.note_change()
    check_trust(stage)
    stage.watch.evident_s, stage.watch.hidden = -math.inf, True
    check_trust(stage)


@every_row(
    "dialect, way, moves",
    [("mks", 8, False), ("mks", 9, True), ("teachmover", 1, True)],
)
def test_only_drives_that_hold_may_turn_without_a_command_and_only_in_their_rest_window(
    dialect, way, moves
):
    stage = at_rest(dialect)
    for count in (way, -way, way):
        stage.world.drive(steps(right=count, left=count), 3.0)
    assert any("without a command" in each for each in stage.watch.broken) is moves


def test_a_drive_that_creeps_is_seen_to_move():
    stage = at_rest("mks")
    for number in range(9):
        stage.world.drive(steps(right=1), 3.0 + number)
    assert any("without a command" in each for each in stage.watch.broken)


@every_row(
    "excuse, slack_s, at_s, broken",
    [
        (Excuse.NOTHING, 0.0, 1.4, ["it went"]),
        (Excuse.NOTHING, 0.0, 2.0, ["it moved", "it went"]),
        (Excuse.PATH, 0.0, 1.4, []),
        (Excuse.PATH, 0.0, 2.0, ["it moved"]),
        (Excuse.PATH, 1.0, 2.0, []),
        (Excuse.MOTION, 0.0, 2.0, []),
    ],
)
def test_a_bound_holds_in_time_and_in_place_as_far_as_nothing_is_excused(
    excuse, slack_s, at_s, broken
):
    stage = a_stage("grbl")
    stage.watch.begin(Command("move_j"))
    stage.watch.add_bound(Bound("stop", 1.0, stage.world.tip, 0.5, 1.0))
    stage.watch.pardon(excuse, slack_s)
    stage.world.drive(steps(base=400), at_s)
    found = {"it moved" if "it moved" in each else "it went" for each in stage.watch.broken}
    assert found == set(broken)


@pytest.mark.parametrize(("at_s", "unasked"), [(90.0, False), (101.0, True)])
def test_what_an_earlier_command_has_sent_may_outlast_a_later_one(at_s, unasked):
    """A board homed on without its wire, after a jog that moved nothing."""
    stage = a_stage("grbl")
    for what, now_s, runs_on_s in (("home", 10.0, 90.0), ("a jog", 11.0, 0.2)):
        stage.watch.begin(Command(what))
        stage.watch.end(now_s, runs_on_s)
    stage.world.drive(steps(base=3), at_s)
    assert any("without a command" in each for each in stage.watch.broken) is unasked


# -- Goals ----------------------------------------------------------------------------------------


def test_a_goal_is_missed_by_more_than_rounding():
    stage = a_stage()
    world, arm = stage.world, stage.config.model.arm
    wanted = {"base": world.joints[0] + 0.2}
    reached, stays = joints_reached(stage, wanted), pose_reached(stage, arm.fk(world.joints))
    there = world.body.transmission.to_motors(world.joints.replace(**wanted), world.opening_mm)
    assert "base" in reached(world, None)
    assert not stays(world, None)
    world.drive(there - world.motors)
    assert not reached(world, None)
    assert "mm from" in stays(world, None)
    world.drive(steps(shoulder=6))
    assert "shoulder" in reached(world, None)


# -- Calls that hang ------------------------------------------------------------------------------


def moved(stage):
    """Move within the limits; return the error, if any."""
    while True:
        error = move_j(stage, DRAW)
        if error is None or isinstance(error, WrongState):
            return error


def test_a_motion_requested_in_a_pause_ends_and_says_how_to_resume(monkeypatch):
    monkeypatch.setattr("armdrive.runtime.overrides.time.sleep", lambda _: None)
    stage = a_stage()
    arm = stage.ready()
    arm.pause()
    began_s = stage.now_s
    error = moved(stage)
    assert "call `resume()`, or run `armdrive resume`" in str(error)
    assert stage.now_s - began_s >= LONGEST_SIMULATED_WAIT_S
    assert arm.status.paused
    assert arm.status.state is State.STANDBY
    arm.resume()
    assert moved(stage) is None


def test_a_late_call_is_reported_with_how_late_it_was_unless_its_program_was_suspended():
    stage = a_stage()
    arm = stage.ready()
    with pytest.raises(Broken, match=r"it lasted 2\d\.\d s"):
        call(stage, lambda: arm.sleep(LONGEST_S + 1.0))
    stage.timeline.at(stage.now_s + 1.0, lambda: stage.suspend(400.0))
    call(stage, lambda: arm.sleep(2.0))


# -- The table ------------------------------------------------------------------------------------


def test_every_happening_has_a_name_of_its_own_and_words_that_a_device_accepts():
    names = [each.name for each in HAPPENINGS]
    assert len(set(names)) == len(names)
    for dialect in ("grbl", "mks"):
        stage = a_stage(dialect)
        stage.connect()
        for each in HAPPENINGS:
            if isinstance(stage.twin.board, each.needs):
                drawn = each.draw(DRAW, 6).words
                for words in (*each.words, *(() if "drive-id" in drawn else (drawn,))):
                    assert stage.request(words) == words
        stage.twin.faults.end()
