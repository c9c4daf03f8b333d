"""The set-up screen turns each motor a little, and corrects the arm file by what was seen."""

import math
from dataclasses import replace

import pytest
from setup_session import FILE, SetupSession, written

from armdrive.connect.target import simulated_config
from armdrive.registry.arm_files import load_arm
from armdrive.setup.directions import TRIAL_SPEED
from armdrive.status import State
from tui.setup import Steps
from tui.setup.motors import MotorsStage
from tui.setup.stages import Correction

pytestmark = pytest.mark.usefixtures("own_home")


async def test_the_motors_are_checked_and_the_file_is_corrected_after_its_difference_is_seen():
    path = written()
    async with SetupSession(load_arm(path)) as session:
        assert str(path) in session.words
        await session.choose("4 check")
        assert isinstance(session.stage, MotorsStage)
        await session.go_through({"elbow": "r", "base": "d", "shoulder": "n"})
        assert {speed for _, speed in session.simulated.asked} == {TRIAL_SPEED}
        assert session.simulated.turned == [0] * 6
        assert "counts the other way: elbow" in session.words
        await session.press("enter")
        assert isinstance(session.stage, Correction)
        assert "+elbow = -1" in session.words
        assert "unclear: shoulder" in session.words
        assert path.read_text(encoding="utf-8") == FILE
        await session.twice("enter")
        assert "elbow = -1" in path.read_text(encoding="utf-8")
        assert path.read_text(encoding="utf-8").startswith(FILE)
        assert "when it is next connected" in session.words
        await session.press("enter")
        await session.choose("4 check")
        assert "was changed" in session.text("messages")


async def look_and_answer(session):
    """Turn every motor, and say of each what the real arm did."""
    world = session.simulated.arm.twin.world
    while (trial := session.stage.check.trial) is not None:
        before = (world.joints, world.opening_mm)
        await session.turn()
        seen = session.simulated.seen(before)
        right = seen.word(trial.ways[0]) == trial.expected.word(trial.ways[0])
        await session.press("y" if right else "r")
        if session.stage.check.asks_hand:
            rolled = seen.word("roll") == trial.expected.word("roll")
            await session.press("y" if rolled else "r")
        await session.turn()


async def test_an_arm_whose_motors_count_otherwise_is_right_after_its_file_was_corrected():
    path, signs = written(), (1, -1, 1, 1, 1, -1)
    async with SetupSession(load_arm(path), signs) as session:
        await session.choose("4 check")
        await look_and_answer(session)
        await session.press("enter")
        await session.twice("enter")
    config = load_arm(path)
    model = simulated_config("teachmover").model
    truth = model.transmission.with_signs(signs, (1,) * len(signs))
    assert config.model.transmission == truth
    async with SetupSession(config) as session:
        await session.choose("4 check")
        await look_and_answer(session)
        assert "all moved as shown" in session.words
        await session.press("enter")
        assert "left as it is" in session.words


async def test_a_key_that_is_held_turns_once_and_nothing_else_turns_at_all():
    async with SetupSession() as session:
        await session.press("t")
        assert "choose that step first" in session.text("messages")
        await session.choose("4 check")
        await session.press("y", "r", "d", "h", "a", "enter", "up", "down", "left")
        assert isinstance(session.stage, Steps)
        await session.choose("4 check")
        assert session.simulated.asked == []
        await session.turn()  # the first repeat of a held key comes after half a second
        assert len(session.simulated.asked) == 1
        for _ in range(20):
            await session.press("t", after_s=0.04)
        session.clock.now_s += 0.5
        await session.settle()
        await session.settle()
        assert len(session.simulated.asked) == 1


async def test_the_first_letter_of_a_paste_that_nothing_marks_turns_no_motor():
    async with SetupSession() as session:
        await session.choose("4 check")
        session.desk.input.person_s = math.inf  # all comes at once
        for letters in ("tw", "tt", "ty", "twy"):
            await session.press(*letters)
            for _ in range(2):
                session.clock.now_s += 20.0
                await session.settle()
            assert session.simulated.asked == [], letters
    async with SetupSession() as session:
        await session.choose("4 check")
        await session.turn()
        assert len(session.simulated.asked) == 1, "a person presses it"


async def test_a_stop_leaves_the_step_and_what_was_answered_is_kept():
    async with SetupSession() as session:
        await session.choose("4 check")
        await session.turn()
        await session.press("y")
        await session.press("space")
        assert isinstance(session.stage, Steps)
        assert session.simulated.arm.stops == 1
        await session.choose("4 check")
        assert "bring it back" in session.words
        await session.turn()
        assert "1 answered" in session.words
        assert session.simulated.turned == [0] * 6


async def test_a_stop_that_comes_before_the_motor_keeps_it_standing():
    async with SetupSession() as session:
        session.simulated.before = session.simulated.arm.request_stop
        await session.choose("4 check")
        before = session.simulated.arm.twin.world.opening_mm
        await session.turn()
        assert session.simulated.arm.twin.world.opening_mm == before
        assert not session.stage.check.away
        assert "stop" in session.text("messages")


@pytest.mark.parametrize(
    ("state", "why"),
    [(State.DISABLED, "the motors are off"), (State.ERROR_STOP, "the arm is in error-stop")],
)
async def test_no_motor_is_turned_in_a_state_in_which_it_should_not(state, why):
    async with SetupSession() as session:
        arm = session.simulated.arm
        if state is State.ERROR_STOP:
            arm.estop()
        await session.choose("4 check")
        if state is State.DISABLED:
            session.desk.link.status = replace(session.desk.link.status, state=state)
            with session.desk.calls.acting():
                session.stage.turn()
        else:
            await session.turn()
        assert session.simulated.asked == []
        assert why in session.desk.message


async def test_motors_that_changed_places_are_named_by_choosing_them():
    path = written()
    async with SetupSession(load_arm(path)) as session:
        await session.choose("4 check")
        for meant, really in (("base", "elbow"), ("elbow", "base")):
            while session.stage.check.trial.name != meant:
                await session.go_through_one()
            await session.turn()
            await session.press("a")
            assert "Which motor" in session.words
            while session.stage.others[session.stage.marked] != really:
                await session.press("down")
            await session.press("enter")
            await session.turn()
        await session.go_through({})
        assert "moved another motor's part: base, elbow" in session.words
        await session.press("enter")
        assert "swap their plugs" in session.words
        await session.press("enter")
        assert isinstance(session.stage, Steps)


async def test_a_check_without_a_file_says_why_nothing_is_written():
    async with SetupSession() as session:
        await session.choose("4 check")
        await session.go_through({"base": "h"})
        await session.press("enter")
        assert "no file to write it into" in session.text("messages")
