"""The move screen: what is typed is foreseen, what is seen is confirmed, and then it moves."""

import pytest
from desk_planner import PlannerArm, settled
from desk_session import Session
from textual import events

from armdrive.errors import WrongState
from armdrive.moves import JointMove, LineMove, PoseMove
from armdrive.status import State
from kinematics import JOINT_NAMES
from tui.app import action_call
from tui.keys.table import MOVE_KEYS
from tui.move.form import STEPS, GoalForm
from tui.settings import SPEEDS, MoveSettings


class MoveSession(Session):
    """A desk at its move screen, with an arm that plans."""

    def __init__(self, arm=None, **more):
        super().__init__(arm or PlannerArm(), **more)

    async def __aenter__(self):
        await super().__aenter__()
        await self.press("f3")
        await self.settle()
        return self

    @property
    def screen(self):
        return self.desk.screens.current

    async def typed(self, text):
        await self.press(*({".": "full_stop", "-": "minus"}.get(each, each) for each in text))
        await self.settle()

    async def confirm(self):
        """Press enter twice, and let the pause behind it pass."""
        await self.press("enter")
        await self.press("enter", after_s=0.2)
        self.clock.now_s += 0.5
        await self.settle()
        await self.settle()


async def test_a_click_chooses_a_field_and_takes_a_first_press_back():
    async with MoveSession(size=(120, 40)) as session:
        await session.typed("250")
        await session.press("enter")
        assert session.desk.confirmation.effect
        await session.pilot.click("#fields", offset=(4, 3))
        await session.settle()
        assert "> z" in session.text("fields")
        assert not session.desk.confirmation.effect
        await session.typed("120")
        assert [session.screen.form.field(name).text for name in "xyz"] == ["250", "", "120"]


async def test_a_pose_is_typed_foreseen_confirmed_and_gone_to():
    async with MoveSession() as session:
        await session.typed("250")
        assert "> x" in session.text("fields")
        assert "250_" in session.text("fields")
        assert "* elbow up, base front: taken" in session.text("foreseen")
        assert "takes" in session.text("foreseen")
        assert "table:" in session.text("foreseen")
        assert session.arm.asked_for == []
        await session.confirm()
        (move,) = session.arm.asked_for
        assert isinstance(move, PoseMove)
        assert move.goal.x_mm == 250.0
        assert move.speed == 0.5
        assert session.arm.status.pose.x_mm == pytest.approx(250.0)
        assert "arrived" in session.text("messages")


async def test_one_press_moves_nothing_and_a_change_takes_it_back():
    async with MoveSession() as session:
        await session.typed("250")
        await session.press("enter")
        await session.settle()
        assert "AGAIN MOVES" in session.text("going")
        await session.press("down", "enter")
        session.clock.now_s += 1.0
        await session.settle()
        assert "AGAIN MOVES" in session.text("going")
        assert session.arm.asked_for == []
        session.clock.now_s += 20.0
        await session.settle()
        assert "AGAIN" not in session.text("going")
        await session.press("enter")
        session.clock.now_s += 1.0
        await session.settle()
        assert session.arm.asked_for == []


@pytest.mark.parametrize("presses", [3, 4, 5, 20])
async def test_a_held_enter_moves_nothing(presses):
    async with MoveSession() as session:
        await session.typed("250")
        await session.press("enter")
        await session.press(*["enter"] * (presses - 1), after_s=0.033)
        session.clock.now_s += 1.0
        await session.settle()
        assert session.arm.asked_for == []


async def test_the_key_repeat_of_a_held_enter_is_not_two_presses_when_it_begins_late():
    async with MoveSession() as session:
        await session.typed("250")
        await session.press("enter")
        await session.press("enter", after_s=0.5)
        await session.poll()
        assert session.arm.asked_for == []
        for _ in range(10):
            await session.press("enter", after_s=0.04)
            await session.poll()
        session.clock.now_s += 1.0
        await session.settle()
        assert session.arm.asked_for == []


async def test_a_refusal_says_why_and_one_key_asks_for_the_nearest():
    async with MoveSession() as session:
        await session.typed("900")
        assert "REFUSED" in session.text("foreseen")
        assert "possible instead" in session.text("foreseen")
        await session.confirm()
        assert session.arm.asked_for == []
        assert "out of reach" in session.text("messages")
        await session.press("n")
        await session.settle()
        assert "REFUSED" not in session.text("foreseen")
        assert "takes" in session.text("foreseen")
        await session.confirm()
        assert len(session.arm.asked_for) == 1


async def test_joints_are_typed_in_the_other_mode_and_their_nearest_too():
    async with MoveSession() as session:
        await session.press("m", "down")
        await session.typed("300")
        assert "JOINTS" in session.text("goal")
        assert "REFUSED" in session.text("foreseen")
        await session.press("n")
        await session.settle()
        assert "REFUSED" not in session.text("foreseen")
        await session.press("delete")
        await session.typed("-15.5")
        await session.confirm()
        (move,) = session.arm.asked_for
        assert isinstance(move, JointMove)
        assert move.goal == {"base_deg": -15.5}


async def test_lines_frames_and_speeds():
    async with MoveSession() as session:
        await session.press("l", "F", "down", "down")
        await session.typed("-30")
        await session.press("greater_than_sign")
        await session.settle()
        assert "straight line" in session.text("goal")
        assert "frame tool (a change)" in session.text("goal")
        await session.confirm()
        (move,) = session.arm.asked_for
        assert isinstance(move, LineMove)
        assert (move.frame, move.goal.z_mm, move.goal.x_mm) == ("tool", -30.0, 0.0)
        assert move.speed == 1.0


async def test_the_arrows_step_a_field_from_where_the_arm_is():
    async with MoveSession() as session:
        x_mm = session.arm.status.pose.x_mm
        await session.press("right", "right", "left", "right_square_bracket", "right")
        await session.settle()
        assert float(session.screen.form.field("x").text) == pytest.approx(x_mm + 6.0, abs=0.01)
        await session.press("backspace")
        await session.settle()
        assert session.screen.form.field("x").text == ""
        assert session.screen.planned.preview is None


async def test_what_is_no_number_is_said_and_not_gone_to():
    async with MoveSession() as session:
        await session.typed("1.2.3")
        assert "'1.2.3' is no number" in session.text("foreseen")
        await session.confirm()
        assert session.arm.asked_for == []
        assert "nothing to confirm" in session.text("messages")


async def test_space_stops_while_a_goal_is_typed_and_takes_the_confirmation_back():
    async with MoveSession() as session:
        await session.typed("250")
        await session.press("enter", "space")
        session.clock.now_s += 1.0
        await session.settle()
        assert session.arm.asked("stop")
        assert "AGAIN" not in session.text("going")
        await session.press("enter")
        session.clock.now_s += 1.0
        await session.settle()
        assert session.arm.asked_for == []
        assert session.screen.form.field("x").text == "250"


async def test_a_stop_on_the_way_to_the_arm_ends_the_motion():
    arm = PlannerArm()
    seen = []
    arm.during = seen.append
    begin = arm.start

    def late(*words, **named):
        arm.request_stop()
        return begin(*words, **named)

    arm.start = late
    async with MoveSession(arm) as session:
        await session.typed("250")
        await session.confirm()
        assert seen == []
        assert "a stop was requested" in session.text("messages")


async def test_what_is_seen_is_what_moves_or_nothing_does():
    """The arm was moved by something else between the two presses and the motion."""
    async with MoveSession() as session:
        await session.typed("250")
        await session.press("enter")
        session.arm.stand_at(session.arm.status.joints.replace(base=0.1))
        await session.press("enter", after_s=0.2)
        session.clock.now_s += 1.0
        await session.settle()
        assert session.arm.asked_for == []


async def test_progress_is_shown_until_the_end():
    arm = PlannerArm()
    async with MoveSession(arm) as session:
        await session.typed("250")
        shown = []

        def during(going):
            del going
            for index in (0, len(session.screen.planned.preview.postures) // 2):
                arm.set(joints=session.screen.planned.preview.postures[index], state=State.MOVING)
                session.desk.call_from_thread(session.desk.poll)
                session.desk.call_from_thread(lambda: shown.append(session.text("going")))

        arm.during = during
        await session.confirm()
        assert "MOVING" in shown[0]
        assert " 0%" in shown[0]
        assert 45 <= int(shown[1].split("%")[0].split()[-1]) <= 60
        assert "MOVING" not in session.text("going")


async def test_an_arm_that_may_not_move_now_shows_the_plan_and_says_why():
    arm = PlannerArm()
    arm.hindrance = WrongState("the motors are off: enable them first")
    async with MoveSession(arm) as session:
        await session.typed("250")
        assert "takes" in session.text("foreseen")
        assert "REFUSED: the motors are off" in session.text("foreseen")
        await session.confirm()
        assert session.arm.asked_for == []


async def test_nothing_is_worked_out_again_while_nothing_changes():
    async with MoveSession() as session:
        await session.typed("250")
        before = session.arm.previews
        for _ in range(10):
            await session.settle()
        assert session.arm.previews == before


async def test_leaving_the_screen_takes_a_first_press_back_and_keeps_what_was_typed():
    async with MoveSession() as session:
        await session.typed("250")
        await session.press("enter", "f2", "f3")
        await session.settle()
        assert "AGAIN" not in session.text("going")
        assert session.screen.form.field("x").text == "250"


async def test_keys_without_a_use_say_so():
    async with MoveSession() as session:
        await session.press("n")
        assert "nothing was refused" in session.text("messages")
        await session.press("b")
        assert "no other posture" in session.text("messages")
        await session.press("m", "l")
        assert "of a pose" in session.text("messages")
        await session.press("F")
        assert "of poses" in session.text("messages")
        await session.press("up", "less_than_sign", "left_square_bracket")
        assert session.screen.form.settings.speed == 0.25
        assert session.screen.form.step == 0.1


async def test_every_key_of_the_table_has_an_action():
    async with MoveSession() as session:
        for row in MOVE_KEYS:
            assert action_call(row.action, session.screen), row.id


def test_the_move_screen(snap_compare):
    session = Session(PlannerArm())
    keys = ["f3", "2", "6", "0", "down", "4", "0"]

    assert snap_compare(session.desk, press=keys, terminal_size=(80, 24), run_before=settled)


# -- the form alone ---------------------------------------------------------------------------


def form_of(present=None, *, has_yaw=False):
    settings = MoveSettings()
    return GoalForm(JOINT_NAMES, ("base", "tool"), settings, lambda: present or {}, has_yaw=has_yaw)


def test_steps_and_speeds_stay_in_their_tables():
    form = form_of()
    for by, end in ((1, -1), (-1, 0)):
        for _ in range(10):
            form.change_speed(by)
            form.change_step(by)
        assert (form.settings.speed, form.step) == (SPEEDS[end], STEPS[end])


@pytest.mark.parametrize(("has_yaw", "last"), [(False, "roll"), (True, "yaw")])
def test_fields_go_round_and_a_yaw_is_one_where_the_arm_has_it(has_yaw, last):
    form = form_of(has_yaw=has_yaw)
    form.move_to_field(-1)
    assert form.name == last


def test_an_empty_form_asks_for_nothing_and_an_unknown_place_for_no_pose():
    form = form_of()
    assert form.goal() is None
    form.field("x").type("5")
    assert form.goal() is None
    form.switch_mode()
    form.field("base").type("5")
    assert form.goal() == JointMove({"base_deg": 5.0}, 0.5)


def test_what_was_filled_in_from_elsewhere_is_typed_over():
    pose = PlannerArm().status.pose
    for key, left in (("type", "7"), ("erase", ""), ("clear", "")):
        form = form_of()
        form.take_pose(pose)
        assert form.goal().goal == pose
        assert form.shown("x") == f"{pose.x_mm:.2f}"
        getattr(form.field("x"), key)(*(left if key == "type" else ()))
        assert form.field("x").text == left


async def test_keys_that_come_in_one_burst_are_taken_in_their_order():
    """As a slow link delivers them: an arrow between two numbers leads to the next field."""
    async with MoveSession() as session:
        for key, character in (("2", "2"), ("5", "5"), ("down", None), ("down", None), ("9", "9")):
            session.desk.post_message(events.Key(key, character))
        await session.settle()
        await session.settle()
        form = session.screen.form
        assert (form.field("x").text, form.field("z").text) == ("25", "9")
