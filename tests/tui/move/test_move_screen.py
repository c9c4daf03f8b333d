"""The move screen: what is typed is foreseen, what is seen is confirmed, and then it moves."""

import pytest
from desk_planner import PlannerArm
from desk_session import AGAIN_S, Session

from armdrive.errors import WrongState
from armdrive.moves import JointMove, LineMove, PoseMove
from armdrive.status import State, Trust
from kinematics import JOINT_NAMES
from tui.move.form import GoalForm
from tui.settings import MoveSettings


class MoveSession(Session):
    """A desk at its move screen, with an arm that plans."""

    first = "move"

    def __init__(self, arm=None, **more):
        super().__init__(arm or PlannerArm(), **more)

    def field(self, name):
        return self.screen.form.field(name).text

    async def wait(self, time_s):
        self.clock.now_s += time_s
        await self.settle()

    @property
    def goal(self):
        """The one motion that was asked for."""
        (move,) = self.arm.asked_for
        return move


async def test_fields_are_chosen_by_keys_or_a_click_and_typed_over():
    async with MoveSession(size=(120, 40)) as session:
        await session.keys("'250 enter")
        assert session.desk.confirmation.effect
        await session.pilot.click("#fields", offset=(4, 2))
        await session.settle()
        session.shows("a click", fields="> z")
        assert not session.desk.confirmation.effect, "a first press is taken back"
        await session.burst("'120 up '80 up '3 '1")
        assert [session.field(name) for name in "xyz"] == ["31", "80", "120"]
        await session.keys("down backspace")
        assert session.field("y") == ""


async def test_a_pose_is_typed_foreseen_confirmed_and_gone_to():
    async with MoveSession() as session:
        await session.keys("'250")
        for words in ("* base front, elbow up: taken", "takes", "table:"):
            session.shows("a goal", foreseen=words)
        session.shows("a goal", fields="> x")
        session.shows("a goal", fields="250_")
        before = session.arm.previews
        for _ in range(10):
            await session.settle()
        assert session.arm.previews == before, "nothing has changed"
        assert session.arm.asked_for == []
        await session.twice("enter")
        assert isinstance(session.goal, PoseMove)
        assert session.goal.goal.x_mm == 250.0
        assert session.goal.speed == 0.5
        assert session.arm.status.pose.x_mm == pytest.approx(250.0)
        session.shows("the end", messages="arrived")


async def test_one_press_moves_nothing_and_another_key_takes_it_back():
    async with MoveSession() as session:
        await session.follow([("'250 enter", {"going": "AGAIN MOVES"})])
        await session.press("down", "enter")
        await session.wait(1.0)
        session.shows("a new first press", going="AGAIN MOVES")
        await session.wait(20.0)
        session.shows("a press long ago", not_going="AGAIN")
        await session.press("enter")
        await session.wait(1.0)
        await session.keys("f2 f3")
        session.shows("a screen that was left", not_going="AGAIN")
        assert session.field("x") == "250"
        await session.keys("enter space")
        await session.wait(1.0)
        session.shows("a stop", not_going="AGAIN")
        assert session.arm.asked("stop")
        await session.press("enter")
        await session.wait(1.0)
        assert session.field("x") == "250"
        assert session.arm.asked_for == []


async def test_a_held_enter_moves_nothing_however_late_its_repeats_begin():
    async with MoveSession() as session:
        await session.keys("'250")
        for presses in (2, 3, 4, 5, 20):
            await session.press("enter")
            await session.press(*["enter"] * (presses - 1), after_s=0.033)
            await session.wait(1.0)
            assert session.arm.asked_for == [], presses
        await session.wait(20.0)
        await session.press("enter")
        await session.press("enter", after_s=0.5)
        await session.poll()
        assert session.arm.asked_for == []
        for _ in range(10):
            await session.press("enter", after_s=0.04)
            await session.poll()
        await session.wait(1.0)
        assert session.arm.asked_for == []


async def test_a_refusal_says_why_and_one_key_asks_for_the_nearest():
    async with MoveSession() as session:
        await session.keys("'900")
        session.shows("out of reach", foreseen="REFUSED", footer="n nearest")
        session.shows("out of reach", foreseen="n: possible instead", not_footer="go (twice)")
        await session.twice("enter")
        assert session.arm.asked_for == []
        session.shows("confirmed all the same", messages="refused, for the reason shown")
        await session.keys("n")
        session.shows("n", not_foreseen="REFUSED")
        session.shows("n", foreseen="takes", footer="go (twice)")
        await session.twice("enter")
        assert len(session.arm.asked_for) == 1


async def test_joints_are_typed_in_the_other_mode_and_their_nearest_too():
    async with MoveSession() as session:
        await session.follow(
            [
                ("m down '300", {"goal": "JOINTS", "foreseen": "REFUSED"}),
                ("n", {"not_foreseen": "REFUSED"}),
            ]
        )
        await session.burst("delete '-15.5")
        session.shows("typed", fields="-15.5_")
        await session.twice("enter")
        assert isinstance(session.goal, JointMove)
        assert session.goal.goal == {"base_deg": -15.5}


async def test_the_arrows_step_a_field_and_lines_frames_and_speeds_are_chosen():
    async with MoveSession() as session:
        x_mm = session.arm.status.pose.x_mm  # from where the arm is
        await session.burst("right right left right_square_bracket right")
        assert float(session.field("x")) == pytest.approx(x_mm + 6.0, abs=0.01)
        await session.keys("backspace")
        assert session.field("x") == ""
        assert session.screen.planned.preview is None
        await session.burst("l '5 F down down '-30 greater_than_sign")  # F empties the fields
        session.shows("a change along a line", goal="straight line")
        session.shows("a change along a line", goal="frame tool (a change)")
        await session.twice("enter")
        move = session.goal
        assert isinstance(move, LineMove)
        assert (move.frame, move.goal.z_mm, move.goal.x_mm) == ("tool", -30.0, 0.0)
        assert move.speed == 1.0


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
        await session.keys("'250")
        await session.twice("enter")
        assert seen == []
        session.shows("a stop", messages="a stop was requested")


async def test_what_is_seen_is_what_moves_or_nothing_does():
    """The arm was moved by something else between the two presses and the motion."""
    async with MoveSession() as session:
        await session.keys("'250 enter")
        session.arm.stand_at(session.arm.status.joints.replace(base=0.1))
        await session.press("enter", after_s=AGAIN_S)
        await session.wait(1.0)
        assert session.arm.asked_for == []
        await session.press("enter")
        await session.press("enter", after_s=AGAIN_S)
        session.arm.stand_at(session.arm.status.joints.replace(base=0.2))
        session.desk.link.take(session.arm.status)
        with session.desk.calls.acting():
            session.screen.planned._go()
        assert session.arm.asked_for == []
        session.shows("a change at the last moment", messages="the motion has changed")


async def test_a_motion_under_way_says_how_it_is_paused_and_stopped():
    arm = PlannerArm()
    async with MoveSession(arm) as session:
        await session.keys("'250")
        shown = []

        def during(_):
            for paused in (False, True):
                arm.set(state=State.MOVING, paused=paused)
                session.desk.call_from_thread(session.desk.poll)
                session.desk.call_from_thread(lambda: shown.append(session.text("going")))

        arm.during = during
        await session.twice("enter")
        assert shown == [
            "UNDER WAY: p pauses, space stops", "PAUSED: p resumes, space stops"
        ]  # fmt: skip
        session.shows("the end", going="enter twice")


async def test_an_arm_that_may_not_move_now_shows_the_plan_and_says_why():
    arm = PlannerArm()
    arm.hindrance = WrongState("the motors are off: enable them first")
    async with MoveSession(arm) as session:
        await session.keys("'250")
        session.shows("motors off", foreseen="takes")
        session.shows("motors off", foreseen="REFUSED: the motors are off")
        await session.twice("enter")
        assert session.arm.asked_for == []
        arm.set(state=State.ERROR_STOP, error="the elbow slipped")
        await session.keys("n")
        session.shows("the panel on top says why", foreseen="takes", not_foreseen="REFUSED")
        arm.set(state=State.STANDBY, error="", trust=Trust.SUSPECT, trust_reason="it slipped")
        await session.poll()
        await session.keys("enter")
        session.shows("suspect", messages="trusted: press H first", not_foreseen="REFUSED")


USELESS = [
    ("n", {"messages": "no nearest possible goal"}),
    ("b", {"messages": "no other allowed posture"}),
    ("m l", {"messages": "a straight line leads to a pose"}),
    ("F", {"messages": "joint angles have no frame"}),
    ("less_than_sign left_square_bracket", {"goal": "< >: speed 25%   [ ]: step 0.1"}),
    ("'1.2.3", {"foreseen": "'1.2.3' is no number"}),
    ("enter", {"messages": "nothing to confirm"}),
]


async def test_keys_without_a_use_and_what_is_no_number_say_so():
    async with MoveSession() as session:
        await session.follow(USELESS)
        assert session.arm.asked_for == []


# -- the form alone ---------------------------------------------------------------------------


def form_of(present=None, *, has_yaw=False):
    settings = MoveSettings()
    return GoalForm(JOINT_NAMES, ("base", "tool"), settings, lambda: present or {}, has_yaw=has_yaw)


@pytest.mark.parametrize(("has_yaw", "last"), [(False, "roll"), (True, "yaw")])
def test_fields_go_round_and_a_yaw_is_one_where_the_arm_has_it(has_yaw, last):
    form = form_of(has_yaw=has_yaw)
    form.move_to_field(-1)
    assert form.name == last


def test_what_was_filled_in_from_elsewhere_is_typed_over():
    pose = PlannerArm().status.pose
    for key, left in (("type", "7"), ("erase", ""), ("clear", "")):
        form = form_of()
        form.take_pose(pose)
        assert form.goal().goal == pose
        assert form.shown("x") == f"{pose.x_mm:.2f}"
        getattr(form.field("x"), key)(*(left if key == "type" else ()))
        assert form.field("x").text == left
