"""The points screen: places are named, gone to after two presses, and sequences stepped through."""

import pytest
from desk_planner import PlannerArm, settled
from desk_session import Session

from armdrive.storage.points import Point, Step, StepList, Taught
from kinematics import Joints
from tui.app import action_call
from tui.keys.table import POINT_KEYS
from tui.points.list import PointList

LEFT = Point(Joints.of(30.0, 60.0, -80.0, -60.0, 0.0), 20.0, "by the wall")
RIGHT = Point(Joints.of(-20.0, 60.0, -80.0, -60.0, 0.0))
UP = Point(Joints.of(-20.0, 80.0, -80.0, -60.0, 0.0))
BEYOND = Point(Joints.of(0.0, 300.0, -80.0, -60.0, 0.0))
STACK = StepList((Step("left"), Step(gripper="open"), Step("right", "line", 0.25), Step("up")))


def taught_arm():
    arm = PlannerArm()
    for name, point in {"left": LEFT, "right": RIGHT, "up": UP}.items():
        arm.points[name] = point
    arm.points.put_sequence("stack", STACK, instead_of=None)
    return arm


class PointSession(Session):
    """A desk at its points screen, with an arm that has been taught."""

    def __init__(self, arm=None, **more):
        super().__init__(arm or taught_arm(), **more)

    async def __aenter__(self):
        await super().__aenter__()
        await self.press("f4")
        await self.settle()
        return self

    @property
    def screen(self):
        return self.desk.screens.current

    async def choose(self, name):
        for _ in range(10):
            if self.screen.selection.listed.name == name:
                return
            await self.press("down")
        await self.settle()

    async def twice(self, key):
        await self.press(key)
        await self.press(key, after_s=0.2)
        self.clock.now_s += 0.5
        await self.settle()
        await self.settle()

    async def step(self, key):
        await self.press(key, after_s=1.0)
        await self.settle()
        await self.settle()

    def stands_at(self, point):
        joints = self.arm.status.joints.angles_rad
        return joints == pytest.approx(point.joints.angles_rad, abs=1e-6)

    def point(self, name):
        return self.arm.points[name]


async def test_the_list_shows_points_and_sequences_and_what_is_chosen():
    async with PointSession() as session:
        listed = session.text("list")
        for name in ("> left", "right", "up", "stack"):
            assert name in listed
        assert "sequence, 4 steps" in listed
        assert "base 30.0°" in session.text("chosen")
        assert "by the wall" in session.text("chosen")
        assert "takes" in session.text("ahead")
        await session.press("up")
        await session.settle()
        assert "> stack" in session.text("list")
        assert ">   1 to left" in session.text("chosen")


async def test_a_point_is_gone_to_after_two_presses_and_no_held_key():
    async with PointSession() as session:
        await session.choose("right")
        await session.press("l", "greater_than_sign")
        await session.settle()
        await session.press("enter", "enter", "enter", after_s=0.03)
        session.clock.now_s += 1.0
        await session.settle()
        assert session.arm.asked_for == []
        await session.twice("enter")
        (move,) = session.arm.asked_for
        assert move.goal.names == RIGHT.joints.names
        assert move.speed == 1.0
        assert session.arm.status.pose.x_mm == pytest.approx(
            session.arm.model.arm.fk(session.point("right").joints).x_mm
        )


async def test_a_click_chooses_a_point_and_takes_a_first_press_back():
    async with PointSession(size=(120, 40)) as session:
        await session.press("enter")
        assert session.desk.confirmation.effect
        await session.pilot.click("#list", offset=(4, 2))
        await session.settle()
        assert session.screen.selection.listed.name == "right"
        assert not session.desk.confirmation.effect


async def test_a_point_that_cannot_be_gone_to_says_why():
    arm = taught_arm()
    arm.points["beyond"] = BEYOND
    async with PointSession(arm) as session:
        await session.choose("beyond")
        await session.settle()
        assert "REFUSED: the shoulder" in session.text("ahead")
        await session.twice("enter")
        assert session.arm.asked_for == []


async def test_the_present_place_is_named_and_the_name_typed():
    async with PointSession() as session:
        await session.press("t")
        assert "name of this place: p4_" in session.text("begin")
        await session.press("backspace", "backspace", "r", "t", "2", "minus", "x", "enter")
        await session.settle()
        assert session.screen.selection.listed.name == "rt2-x"
        assert session.point("rt2-x").joints.deg["base"] == pytest.approx(20.0)
        assert "rt2-x is here" in session.text("messages")


async def test_the_first_letter_takes_the_place_of_a_name_that_was_only_offered():
    async with PointSession() as session:
        await session.press("t")
        assert "name of this place: p4_  (or type another)" in session.text("begin")
        await session.press("u", "2")
        assert "name of this place: u2_\n" in session.text("begin")
        await session.press("space")
        await session.choose("up")
        await session.press("r")
        assert "new name: up_\n" in session.text("begin"), "a rename mends what is there"


async def test_letters_of_a_name_are_no_keys_and_space_is_still_the_stop():
    async with PointSession() as session:
        await session.press("t", "backspace", "backspace", "H", "X", "L", "s", "p")
        assert "name of this place: HXLsp_" in session.text("begin")
        assert not session.arm.asked("estop")
        await session.press("space")
        assert session.arm.asked("stop")
        assert session.screen.typing is None
        assert list(session.arm.points) == ["left", "right", "up"]


async def test_a_name_that_is_taken_or_none_is_refused():
    async with PointSession() as session:
        await session.press("t", "backspace", "backspace", "u", "p", "enter")
        assert "already" in session.text("messages")
        await session.press("t", "backspace", "backspace", "enter")
        assert "is not a valid name" in session.text("messages")
        assert session.point("up").joints.deg["shoulder"] == pytest.approx(80.0)


async def test_teaching_again_and_deleting_take_two_presses():
    async with PointSession() as session:
        await session.choose("left")
        await session.press("U")
        await session.poll()
        assert "AGAIN moves left" in session.text("begin")
        session.clock.now_s += 20.0
        await session.settle()
        await session.settle()
        assert session.point("left").joints.deg["base"] == pytest.approx(30.0)
        assert "AGAIN" not in session.text("begin")
        await session.twice("U")
        assert session.point("left").joints.deg["base"] == pytest.approx(20.0)
        assert session.point("left").note == "by the wall"
        await session.twice("delete")
        assert "used by stack" in session.text("messages")
        await session.choose("stack")
        await session.twice("delete")
        assert not session.arm.points.sequences
        await session.choose("left")
        await session.twice("delete")
        assert list(session.arm.points) == ["right", "up"]


async def test_two_different_keys_are_no_confirmation():
    async with PointSession() as session:
        await session.choose("up")
        await session.press("U")
        await session.press("delete", after_s=0.2)
        session.clock.now_s += 1.0
        await session.settle()
        assert "up" in session.arm.points
        assert session.point("up").joints.deg["base"] == pytest.approx(-20.0)


async def test_renaming_reaches_the_sequence():
    async with PointSession() as session:
        await session.choose("up")
        await session.press("r", "p", "enter")
        await session.settle()
        assert session.arm.points.sequence("stack").points == ("left", "right", "upp")
        assert session.screen.selection.listed.name == "upp"


async def test_what_somebody_else_changes_is_shown_and_not_overwritten():
    async with PointSession() as session:
        await session.choose("up")
        await session.press("delete")
        session.arm.points["up"] = LEFT
        await session.poll()
        await session.press("delete", after_s=0.2)
        session.clock.now_s += 1.0
        await session.settle()
        await session.settle()
        assert "up" in session.arm.points
        assert "AGAIN deletes up" in session.text("begin")  # the second press was a first one
        assert "base 30.0°" in session.text("chosen")
        session.arm.points["new"] = UP
        await session.settle()
        assert "new" in session.text("list")
        session.arm.points.path.write_text("[points\n", encoding="utf-8")
        await session.settle()
        await session.settle()
        assert "line 1" in session.text("messages")
        assert "new" in session.text("list")


async def test_points_of_a_newer_format_are_said_and_no_key_writes_them():
    async with PointSession() as session:
        path = session.arm.points.path
        text = path.read_text(encoding="utf-8")
        path.write_text(text.replace("format = 1", "format = 2"), encoding="utf-8")
        before = path.read_bytes()
        await session.settle()
        await session.settle()
        assert "Update armdrive" in session.text("messages")
        await session.choose("up")
        for keys in (["t", "n", "enter"], ["r", "p", "enter"], ["l", "a", "enter"]):
            await session.press(*keys)
            await session.settle()
            assert path.read_bytes() == before, keys
        for key in ("U", "delete"):
            await session.twice(key)
            assert path.read_bytes() == before, key
        await session.choose("stack")
        for keys in (["pagedown", "K"], ["W", "1", "enter"], ["backspace"]):
            await session.press(*keys)
            await session.settle()
            assert path.read_bytes() == before, keys
        for key in ("D", "delete"):
            await session.twice(key)
            assert path.read_bytes() == before, key
        assert session.arm.asked_for == []


async def test_points_are_put_into_a_sequence_and_taken_out():
    async with PointSession() as session:
        await session.choose("up")
        await session.press("l", "a", "enter")
        await session.settle()
        assert session.arm.points.sequence("sequence").steps == (Step("up", "line", 0.5),)
        await session.press("a", "enter")
        assert len(session.arm.points.sequence("sequence").steps) == 2
        await session.settle()
        await session.choose("sequence")
        await session.press("backspace")
        await session.settle()
        assert len(session.arm.points.sequence("sequence").steps) == 1
        await session.press("backspace", "backspace")
        assert "has steps" in session.text("messages")


async def test_a_marked_step_is_taken_out_and_changes_places():
    async with PointSession() as session:
        await session.choose("up")
        await session.press("pagedown")
        assert "has steps" in session.text("messages")
        await session.choose("stack")
        await session.press("D")
        assert "mark a step" in session.text("messages")
        await session.press("pagedown", "pagedown", "pagedown", "K")
        await session.settle()
        left, open_, right, up = STACK.steps
        assert session.arm.points.sequence("stack").steps == (left, right, open_, up)
        assert " *  2 to right" in session.text("chosen")
        await session.press("J")
        await session.settle()
        assert session.arm.points.sequence("stack") == STACK
        await session.press("pageup", "D")
        session.clock.now_s += 0.5
        await session.settle()
        assert session.arm.points.sequence("stack") == STACK, "one press takes nothing out"
        assert "AGAIN takes step 2 (gripper open) out of stack" in session.text("begin")
        await session.press("pageup")
        await session.twice("D")
        assert session.arm.points.sequence("stack").steps == (open_, right, up)
        assert session.arm.asked_for == []


async def test_a_marked_step_stays_within_the_sequence_and_marks_go_round():
    async with PointSession() as session:
        await session.choose("stack")
        await session.press("pageup", "J")
        assert "the last step of stack" in session.text("messages")
        await session.press("pagedown", "K")
        assert "the first step of stack" in session.text("messages")
        assert session.arm.points.sequence("stack") == STACK
        await session.press("up", "down")
        assert session.screen.selection.marked is None


async def test_steps_that_somebody_else_has_changed_are_not_overwritten():
    async with PointSession() as session:
        await session.choose("stack")
        await session.press("pagedown", "pagedown")
        other = StepList((Step("up"), Step("left")))
        session.arm.points.put_sequence("stack", other, instead_of=STACK)
        await session.press("K")
        assert session.arm.points.sequence("stack") == other
        await session.settle()
        assert session.screen.selection.marked is None, "what was marked is another step by now"
        session.screen.sequence.busy = True
        await session.press("pagedown", "J")
        assert "under way" in session.text("messages")
        assert session.arm.points.sequence("stack") == other


async def test_fingers_and_waits_are_put_into_a_sequence():
    async with PointSession() as session:
        await session.choose("up")
        await session.press("g")
        assert "choose a sequence" in session.text("messages")
        await session.choose("stack")
        await session.press("g")
        assert "fingers: open, close, grasp, here, point, or mm: open_" in session.text("begin")
        await session.press("enter")
        await session.settle()
        await session.press("W", "1", "full_stop", "5", "enter")
        await session.settle()
        steps = session.arm.points.sequence("stack").steps
        assert steps == (*STACK.steps, Step(gripper="open"), Step(wait_s=1.5))
        await session.press("g", *"here", "enter")
        await session.settle()
        assert session.arm.points.sequence("stack").steps[-1] == Step(gripper=38.0)
        assert "stack: step 7 is gripper 38 mm" in session.text("messages")
        assert session.arm.asked_for == []
        assert not session.arm.asked("open")


async def test_further_steps_go_behind_the_marked_one_one_after_the_other():
    async with PointSession() as session:
        await session.choose("stack")
        await session.press("pagedown", "W", "2", "enter")
        await session.settle()
        await session.press("g", *"close", "enter")
        await session.settle()
        left, *others = STACK.steps
        assert session.arm.points.sequence("stack").steps == (
            left,
            Step(wait_s=2.0),
            Step(gripper="close"),
            *others,
        )
        assert session.screen.selection.marked == 2


@pytest.mark.parametrize(
    ("at", "typed", "step"),
    [
        (1, "here", Step(gripper=38.0)),
        (1, "12.5", Step(gripper=12.5)),
        (2, "up", Step("up", "line", 0.25)),
    ],
)
async def test_a_marked_step_is_changed(at, typed, step):
    async with PointSession() as session:
        await session.choose("stack")
        await session.press(*["pagedown"] * (at + 1), "E", *["backspace"] * 8)
        await session.press(*(each if each != "." else "full_stop" for each in typed), "enter")
        await session.settle()
        assert session.arm.points.sequence("stack").steps[at] == step
        assert len(session.arm.points.sequence("stack").steps) == 4


async def test_the_way_and_the_speed_of_a_marked_step_are_changed_and_not_those_of_points():
    async with PointSession() as session:
        await session.choose("stack")
        await session.press("pagedown", "l", "less_than_sign")
        await session.settle()
        assert session.arm.points.sequence("stack").steps[0] == Step("left", "line", 0.5)
        await session.press("greater_than_sign", "greater_than_sign")
        await session.settle()
        assert session.arm.points.sequence("stack").steps[0].speed == 1.0
        await session.press("pagedown", "l")
        assert "how belongs to a step that leads to a point" in session.text("messages")
        assert (session.screen.motion.line, session.screen.motion.speed) == (False, 0.5)


@pytest.mark.parametrize(
    ("key", "typed", "said"),
    [
        ("g", "wide", "'wide' is no opening: type open, close, grasp, here, point, or mm"),
        ("W", "-1", "wait_s is from 0"),
        ("W", "soon", "'soon' is no time: type seconds"),
        ("E", "nowhere", "which does not exist"),
    ],
)
async def test_what_is_no_step_is_refused_and_can_be_mended(key, typed, said):
    async with PointSession() as session:
        await session.choose("stack")
        await session.press("pagedown", key, *["backspace"] * 8)
        await session.press(*(each if each != "-" else "minus" for each in typed), "enter")
        assert said in session.text("messages")
        assert session.arm.points.sequence("stack") == STACK
        await session.press("space")
        assert session.screen.typing is None
        assert session.arm.asked("stop")


# -- sequences --------------------------------------------------------------------------------


async def test_stepping_forwards_and_backwards():
    async with PointSession() as session:
        await session.choose("stack")
        await session.step("right")
        assert session.arm.asked_for == []
        assert "lets this key move" in session.text("messages")
        await session.press("s")
        await session.poll()
        assert "STEPPING" in session.text("chosen")
        await session.step("right")
        assert session.stands_at(session.point("left"))
        assert "next: gripper open" in session.text("messages")
        await session.step("right")
        assert session.arm.asked("open")
        await session.step("right")
        assert session.stands_at(session.point("right"))
        assert "back to left" in session.text("chosen")
        await session.step("left")
        assert session.stands_at(session.point("left"))
        await session.press("home")
        assert session.screen.sequence.stepper.at == 0
        await session.press("s")
        await session.step("right")
        assert session.screen.sequence.stepper.at == 0


async def test_a_held_step_key_makes_one_step():
    async with PointSession() as session:
        await session.choose("stack")
        await session.press("s")
        await session.step("right")
        for _ in range(20):
            await session.press("right", after_s=0.04)
            await session.settle()
        assert session.screen.sequence.stepper.at == 1


async def test_a_sequence_is_run_after_two_presses():
    async with PointSession() as session:
        await session.choose("stack")
        await session.press("enter")
        session.clock.now_s += 1.0
        await session.settle()
        assert session.arm.asked_for == []
        assert "AGAIN CARRIES OUT" in session.text("begin")
        await session.press("enter")
        session.clock.now_s += 1.0
        await session.settle()
        await session.settle()
        assert session.stands_at(session.point("up"))
        assert "at its end" in session.text("messages")
        assert [move.speed for move in session.arm.asked_for] == [1.0, 0.25, 1.0]


async def test_a_sequence_under_way_is_named_in_the_title_and_to_other_programs():
    arm, seen = taught_arm(), []
    async with PointSession(arm) as session:

        def look(_):
            session.desk.call_from_thread(session.desk.poll)
            seen.append((session.text("title").split()[-2:], arm.program()["text"]))

        arm.during = look
        await session.choose("stack")
        await session.twice("enter")
        assert seen == [
            (["stack", "1/4"], "to left"),
            (["stack", "3/4"], "to right along a line at 25%"),
            (["stack", "4/4"], "to up"),
        ]
        assert arm.program is None
        await session.poll()
        assert "stack" not in session.text("title")


async def test_a_stop_ends_a_run_and_the_step_is_the_next_one_again():
    arm = taught_arm()
    arm.during = lambda going: (arm.request_stop(), going.cancel())
    async with PointSession(arm) as session:
        await session.choose("stack")
        await session.twice("enter")
        assert "stopped" in session.text("messages")
        assert session.screen.sequence.stepper.at == 0
        assert not session.screen.sequence.busy
        assert len(arm.asked_for) == 1


async def test_leaving_the_screen_ends_a_run_behind_its_step_and_the_stepping():
    arm = taught_arm()
    async with PointSession(arm) as session:
        arm.during = lambda _: session.desk.call_from_thread(session.desk.screens.show, "jog")
        await session.choose("stack")
        await session.press("s")
        screen = session.screen
        await session.twice("enter")
        arm.during = lambda _: None
        await session.settle()
        assert screen.sequence.stepper.at == 1
        assert len(arm.asked_for) == 1
        assert not screen.sequence.stepping


async def test_pausing_and_going_on():
    async with PointSession() as session:
        await session.press("p")
        await session.poll()
        assert "PAUSED  paused at this desk: p on the points screen" in session.text("banner")
        await session.press("p")
        await session.poll()
        session.arm.set(paused=True)
        await session.poll()
        assert "PAUSED  paused from outside" in session.text("banner")
        session.arm.set(paused=False)
        assert [call[0] for call in session.arm.calls if call[0] in ("pause", "resume")] == [
            "pause",
            "resume",
        ]


async def test_a_point_is_changed_on_the_move_screen():
    async with PointSession() as session:
        await session.choose("right")
        await session.press("e")
        await session.settle()
        assert session.desk.screens.current.place == "move"
        assert float(session.screen.form.field("base").text) == pytest.approx(-20.0)


async def test_an_empty_list_says_how_a_point_is_made_and_every_key_is_harmless():
    async with PointSession(PlannerArm()) as session:
        assert "no points yet: t names" in session.text("list")
        for row in POINT_KEYS:
            assert action_call(row.action, session.screen), row.id
            await session.press(row.keys[0], "escape")
            await session.settle()
        assert session.arm.asked_for == []
        assert not session.arm.points


def test_the_points_screen(snap_compare):
    session = Session(taught_arm())

    assert snap_compare(
        session.desk, press=["f4", "up", "s"], terminal_size=(80, 24), run_before=settled
    )


# -- the list alone ---------------------------------------------------------------------------


def test_what_is_chosen_stays_chosen_while_the_file_changes_around_it():
    listed = PointList(Taught({"a": LEFT, "b": UP})).moved(1)
    assert listed.with_taught(Taught({"aa": LEFT, "a": LEFT, "b": UP})).name == "b"
    assert listed.with_taught(Taught({"a": LEFT})).name == "a"
    assert PointList().moved(1).name == ""


def test_a_free_name_is_free():
    listed = PointList(Taught({"p2": LEFT, "p3": LEFT}))
    assert listed.free_name() == "p4"
    assert PointList(Taught({"p1": LEFT})).free_name() == "p2"
    assert PointList(Taught({"x": LEFT, "p2": UP})).free_name() == "p3"
