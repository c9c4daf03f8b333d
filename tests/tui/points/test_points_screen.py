"""The points screen: places are named, gone to after two presses, and sequences stepped through."""

import pytest
from desk_planner import PlannerArm, at_rest
from desk_session import AGAIN_S, Session

from armdrive.status import State
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
TO_LEFT, OPEN, TO_RIGHT, TO_UP = STACK.steps


def taught_arm():
    arm = PlannerArm()
    for name, point in {"left": LEFT, "right": RIGHT, "up": UP}.items():
        arm.points[name] = point
    arm.points.put_sequence("stack", STACK, instead_of=None)
    return arm


class PointSession(Session):
    """A desk at its points screen, with an arm that has been taught."""

    opens_with = "f4"

    def __init__(self, arm=None, **more):
        super().__init__(arm or taught_arm(), **more)

    async def choose(self, name):
        for _ in range(10):
            if self.screen.selection.listed.name == name:
                return
            await self.press("down")
        await self.settle()

    def stands_at(self, point):
        joints = self.arm.status.joints.angles_rad
        return joints == pytest.approx(point.joints.angles_rad, abs=1e-6)

    def point(self, name):
        return self.arm.points[name]

    def base_deg(self, name):
        return self.point(name).joints.deg["base"]

    def steps(self, name="stack"):
        return self.arm.points.sequence(name).steps


async def test_the_list_shows_points_and_sequences_and_what_is_chosen():
    async with PointSession() as session:
        assert session.text("list").split("\n")[0].startswith("> left")
        for name in ("right", "up", "stack", "sequence, 4 steps"):
            session.shows(name, list=name)
        session.shows("a point", chosen="base 30.0°", ahead="takes")
        session.shows("its note", chosen="by the wall")
        await session.follow([("up", {"list": "> stack", "chosen": ">   1 to left"})])


async def test_a_point_is_gone_to_after_two_presses_and_no_held_key():
    async with PointSession() as session:
        await session.choose("right")
        await session.keys("l greater_than_sign")
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
        session.arm.points["beyond"] = BEYOND
        await session.settle()
        await session.choose("beyond")
        await session.settle()
        session.shows("a point that cannot be gone to", ahead="REFUSED: the shoulder")
        await session.twice("enter")
        assert len(session.arm.asked_for) == 1


async def test_a_click_chooses_a_point_and_takes_a_first_press_back():
    async with PointSession(size=(120, 40)) as session:
        await session.press("enter")
        assert session.desk.confirmation.effect
        await session.pilot.click("#list", offset=(4, 2))
        await session.settle()
        assert session.screen.selection.listed.name == "right"
        assert not session.desk.confirmation.effect


NAMING = [
    ("t", {"begin": "name of this place: p4_  (or type another)"}),
    ("u 2", {"begin": "name of this place: u2_\n"}),  # the first letter replaced what was offered
    ("backspace backspace H X L s p", {"begin": "name of this place: HXLsp_"}),  # and no keys
    ("space", {"messages": "STOP requested", "not_begin": "name of this place"}),
    ("t backspace 'up enter", {"messages": "already"}),
    ("t backspace enter", {"messages": "is not a valid name"}),
    ("t backspace r t 2 minus x enter", {"messages": "rt2-x is saved", "list": "> rt2-x"}),
    ("r", {"begin": "new name: rt2-x_\n"}),  # a rename corrects what is there
    ("a enter", {"messages": "rt2-x is called rt2-xa now", "list": "> rt2-xa"}),
]


async def test_names_are_typed_taken_and_refused():
    async with PointSession() as session:
        await session.follow(NAMING)
        assert session.arm.asked("stop")
        assert not session.arm.asked("estop")
        assert list(session.arm.points) == ["left", "right", "up", "rt2-xa"]
        assert session.base_deg("rt2-xa") == pytest.approx(20.0)
        assert session.point("up").joints.deg["shoulder"] == pytest.approx(80.0)
        await session.choose("up")
        await session.keys("r p enter")
        assert session.arm.points.sequence("stack").points == ("left", "right", "upp")
        assert session.screen.selection.listed.name == "upp"


async def test_no_point_is_taught_while_the_arm_moves():
    async with PointSession() as session:
        await session.choose("left")
        session.arm.set(state=State.MOVING)
        await session.twice("U")
        session.shows("again", messages="the arm is moving: wait until it stands")
        await session.keys("t n enter")
        session.shows("a new one", messages="the arm is moving", begin="name of this place: n_")
        assert list(session.arm.points) == ["left", "right", "up"]
        assert session.point("left") == LEFT
        session.arm.set(state=State.STANDBY)
        await session.poll()
        await session.keys("enter")
        assert session.base_deg("n") == pytest.approx(20.0)
        session.arm.set(state=State.MOVING, paused=True)
        await session.poll()
        await session.keys("t p enter")
        assert "p" in session.arm.points, "a paused arm stands"


async def test_teaching_again_and_deleting_take_two_presses_of_one_key():
    async with PointSession() as session:
        await session.choose("up")
        await session.press("U")
        await session.press("delete", after_s=AGAIN_S)
        session.clock.now_s += 1.0
        await session.settle()
        assert session.base_deg("up") == pytest.approx(-20.0)
        await session.choose("left")
        await session.keys("U")
        session.shows("one press", begin="AGAIN moves left")
        session.clock.now_s += 20.0
        await session.settle()
        await session.settle()
        session.shows("a press long ago", not_begin="AGAIN")
        assert session.base_deg("left") == pytest.approx(30.0)
        await session.twice("U")
        assert session.base_deg("left") == pytest.approx(20.0)
        assert session.point("left").note == "by the wall"
        await session.twice("delete")
        session.shows("a point of a sequence", messages="used by stack")
        await session.choose("stack")
        await session.twice("delete")
        assert not session.arm.points.sequences
        await session.choose("left")
        await session.twice("delete")
        assert list(session.arm.points) == ["right", "up"]


async def test_what_another_program_changes_is_shown_and_not_overwritten():
    async with PointSession() as session:
        await session.choose("up")
        await session.press("delete")
        session.arm.points["up"] = LEFT
        await session.poll()
        await session.press("delete", after_s=AGAIN_S)
        session.clock.now_s += 1.0
        await session.settle()
        await session.settle()
        assert "up" in session.arm.points
        session.shows("a first press again", begin="delete AGAIN deletes up", chosen="base 30.0°")
        session.arm.points["new"] = UP
        await session.settle()
        session.shows("a new point", list="new")
        session.arm.points.path.write_text("[points\n", encoding="utf-8")
        await session.settle()
        await session.settle()
        session.shows("a damaged file", messages="line 1", list="new")


async def test_steps_that_another_program_has_changed_are_not_overwritten():
    async with PointSession() as session:
        await session.choose("stack")
        await session.press("pagedown", "pagedown")
        other = StepList((Step("up"), Step("left")))
        session.arm.points.put_sequence("stack", other, instead_of=STACK)
        await session.press("K")
        assert session.arm.points.sequence("stack") == other
        await session.settle()
        assert session.screen.selection.marked is None, "what was marked is another step by now"
        session.screen.sequence.going.busy = True
        await session.press("pagedown", "J")
        session.shows("under way", messages="the arm is moving")
        assert session.arm.points.sequence("stack") == other


async def test_points_of_a_newer_format_are_said_and_no_key_writes_them():
    async with PointSession() as session:
        path = session.arm.points.path
        text = path.read_text(encoding="utf-8")
        path.write_text(text.replace("format = 1", "format = 2"), encoding="utf-8")
        before = path.read_bytes()
        await session.settle()
        await session.settle()
        session.shows("a newer format", messages="Update armdrive")
        for row, lines, confirmed in (
            ("up", ("t n enter", "r p enter", "l a enter"), ("U", "delete")),
            ("stack", ("pagedown K", "W 1 enter", "backspace"), ("D", "delete")),
        ):
            await session.choose(row)
            for line in lines:
                await session.keys(line)
                assert path.read_bytes() == before, line
            for key in confirmed:
                await session.twice(key)
                assert path.read_bytes() == before, key
        assert session.arm.asked_for == []


async def test_points_are_put_into_a_sequence_and_taken_out():
    async with PointSession() as session:
        await session.choose("up")
        await session.keys("l a enter")
        assert session.steps("sequence") == (Step("up", "line", 0.5),)
        await session.keys("a enter")
        assert len(session.steps("sequence")) == 2
        await session.choose("sequence")
        await session.keys("backspace")
        assert len(session.steps("sequence")) == 1
        await session.press("backspace", "backspace")
        session.shows("no step left", messages="has steps")
        await session.settle()
        session.shows(
            "an empty sequence",
            list="sequence, 0 steps",
            chosen="no steps yet: a on a point appends it",
        )


SLOW_LEFT, FAST_LEFT = Step("left", "line", 0.5), Step("left", "line", 1.0)
EDITS = [
    # keys; the steps of the stack then; what the screen shows
    ("D", STACK.steps, {"messages": "mark a step"}),
    ("pagedown pagedown pagedown K", (TO_LEFT, TO_RIGHT, OPEN, TO_UP),
     {"chosen": " *  2 to right"}),
    ("pagedown pagedown pagedown K J", STACK.steps, {"chosen": " *  3 to right"}),
    ("pageup J", STACK.steps, {"messages": "the last step of stack"}),
    ("pagedown K", STACK.steps, {"messages": "the first step of stack"}),
    ("g", STACK.steps, {"begin": "fingers: open, close, grasp, here, point, or mm: open_"}),
    ("g enter W '1.5 enter", (*STACK.steps, OPEN, Step(wait_s=1.5)), {}),
    ("g 'here enter", (*STACK.steps, Step(gripper=38.0)),
     {"messages": "stack: step 5 is gripper 38 mm"}),
    ("pagedown W 2 enter g 'close enter",
     (TO_LEFT, Step(wait_s=2.0), Step(gripper="close"), *STACK.steps[1:]),
     {"chosen": " *  3 gripper close"}),
    ("pagedown pagedown E 'here enter", (TO_LEFT, Step(gripper=38.0), TO_RIGHT, TO_UP), {}),
    ("pagedown pagedown E '12.5 enter", (TO_LEFT, Step(gripper=12.5), TO_RIGHT, TO_UP), {}),
    ("pageup pageup E backspace backspace backspace backspace backspace 'up enter",
     (TO_LEFT, OPEN, Step("up", "line", 0.25), TO_UP), {}),
    ("pagedown l less_than_sign", (SLOW_LEFT, *STACK.steps[1:]), {}),
    ("pagedown l less_than_sign greater_than_sign greater_than_sign",
     (FAST_LEFT, *STACK.steps[1:]), {}),
    ("pagedown pagedown l", STACK.steps,
     {"messages": "how belongs to a step that leads to a point"}),
    # what is no step can be corrected
    ("pagedown g 'wide enter", STACK.steps,
     {"messages": "'wide' is not an opening: type open, close, grasp, here, point, or mm"}),
    ("pagedown g '1000 enter", STACK.steps,
     {"messages": "the gripper opens from 0 to 76 mm, not to 1000 mm", "begin": "1000_"}),
    ("pagedown W '-1 enter", STACK.steps, {"messages": "wait_s is from 0", "begin": "-1_"}),
    ("pagedown W 'soon enter", STACK.steps, {"messages": "'soon' is not a time: type seconds"}),
    ("pagedown E backspace backspace backspace backspace 'nowhere enter", STACK.steps,
     {"messages": "which does not exist"}),
]  # fmt: skip


async def test_the_steps_of_a_sequence_are_changed():
    async with PointSession() as session:
        await session.choose("up")
        for key, said in (("pagedown", "has steps"), ("g", "choose a sequence")):
            await session.keys(key)
            session.shows(key, messages=said)
        await session.choose("stack")
        for line, steps, shown in EDITS:
            await session.burst(line)
            assert session.steps() == steps, line
            session.shows(line, **shown)
            now = session.arm.points.sequence("stack")
            session.arm.points.put_sequence("stack", STACK, instead_of=now)
            await session.burst("space up down")
            assert session.screen.typing is None, line
            assert session.screen.selection.marked is None, line
        assert session.arm.asked("stop")
        assert session.arm.asked_for == session.arm.asked("open") == []
        assert (session.screen.motion.line, session.screen.motion.speed) == (False, 0.5)


async def test_planned_moves_have_one_speed_on_both_screens_a_low_one_on_a_new_real_arm():
    arm = taught_arm()
    arm.set(simulated=False)
    async with PointSession(arm) as session:
        await session.choose("up")
        session.shows("a new real arm", how="speed 25%")
        await session.keys("greater_than_sign")
        session.shows("faster", how="speed 50%")
        await session.keys("f3")
        session.shows("the move screen", goal="speed 50%")


async def test_a_marked_step_is_taken_out_by_two_presses():
    async with PointSession() as session:
        await session.choose("stack")
        await session.press("pagedown", "pagedown", "D")
        session.clock.now_s += 0.5
        await session.settle()
        assert session.steps() == STACK.steps, "one press takes nothing out"
        session.shows("D", begin="D AGAIN removes step 2 (gripper open) from stack")
        await session.press("pageup")
        await session.twice("D")
        assert session.steps() == STACK.steps[1:]
        assert session.arm.asked_for == []


# -- sequences --------------------------------------------------------------------------------


async def test_stepping_forwards_and_backwards():
    async with PointSession() as session:
        await session.choose("stack")
        await session.once("right")
        assert session.arm.asked_for == []
        session.shows("not stepping", messages="lets this key move")
        await session.keys("s")
        session.shows("s", chosen="STEPPING")
        await session.once("right")
        assert session.stands_at(session.point("left"))
        session.shows("a step", messages="next: gripper open")
        for _ in range(20):
            await session.press("right", after_s=0.04)
            await session.settle()
        assert session.screen.sequence.stepper.at == 1, "a held key makes one step"
        await session.once("right")
        assert session.arm.asked("open")
        await session.once("right")
        assert session.stands_at(session.point("right"))
        session.shows("a way back", chosen="back to left")
        await session.once("left")
        assert session.stands_at(session.point("left"))
        await session.press("home")
        assert session.screen.sequence.stepper.at == 0
        await session.press("s")
        await session.once("right")
        assert session.screen.sequence.stepper.at == 0


async def test_a_sequence_is_run_after_two_presses_and_named_in_the_title_meanwhile():
    arm, seen = taught_arm(), []
    async with PointSession(arm) as session:

        def look(_):
            session.desk.call_from_thread(session.desk.poll)
            seen.append((session.text("title").split()[-2:], arm.program()["text"]))

        arm.during = look
        await session.choose("stack")
        await session.press("enter")
        session.clock.now_s += 1.0
        await session.settle()
        assert session.arm.asked_for == []
        session.shows("one press", begin="AGAIN RUNS THE REMAINING")
        await session.press("enter")
        session.clock.now_s += 1.0
        await session.settle()
        await session.settle()
        assert session.stands_at(session.point("up"))
        session.shows("the end", messages="at its end", not_title="stack")
        assert [move.speed for move in session.arm.asked_for] == [1.0, 0.25, 1.0]
        assert seen == [
            (["stack", "1/4"], "to left"),
            (["stack", "3/4"], "to right along a line at 25%"),
            (["stack", "4/4"], "to up"),
        ]
        assert arm.program is None


async def test_a_stop_ends_a_run_and_the_step_is_the_next_one_again():
    arm = taught_arm()
    arm.during = lambda going: (arm.request_stop(), going.cancel())
    async with PointSession(arm) as session:
        await session.choose("stack")
        await session.twice("enter")
        session.shows("a stop", messages="stopped")
        assert session.screen.sequence.stepper.at == 0
        assert not session.screen.sequence.going.busy
        assert len(arm.asked_for) == 1


async def test_leaving_the_screen_ends_a_run_after_its_step_and_the_stepping():
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


async def test_pausing_and_going_on_and_a_change_on_the_move_screen():
    async with PointSession() as session:
        await session.keys("p")
        session.shows("an arm that stands", messages="nothing moves")
        session.arm.set(state=State.MOVING)
        await session.poll()
        session.shows("moving", footer="p pause", not_footer="go")
        await session.once("p")
        here = "PAUSED  paused at this desk: p on the points screen"
        session.shows("p", banner=here)
        for gap_s in (0.5, 0.03, 0.03, 0.5, 0.6):
            await session.press("p", after_s=gap_s)
            await session.poll()
        session.shows("a key that is held", banner=here)
        await session.once("p")
        session.arm.set(paused=True, state=State.STANDBY)
        await session.poll()
        session.shows("another program", banner="PAUSED  paused from outside")
        session.arm.set(paused=False)
        asked = [call[0] for call in session.arm.calls if call[0] in ("pause", "resume")]
        assert asked == ["pause", "resume"]
        await session.choose("right")
        await session.keys("e")
        assert session.screen.place == "move"
        assert float(session.screen.form.field("base").text) == pytest.approx(-20.0)


async def test_an_empty_list_says_how_a_point_is_made_and_every_key_is_harmless():
    async with PointSession(PlannerArm()) as session:
        session.shows("no points", list="no points yet: t names")
        for row in POINT_KEYS:
            assert action_call(row.action, session.screen), row.id
            await session.press(row.keys[0], "escape")
            await session.settle()
        assert session.arm.asked_for == []
        assert not session.arm.points


def test_the_points_screen(snap_compare):
    session = Session(taught_arm())

    assert snap_compare(
        session.desk, press=["f4", "up", "s"], terminal_size=(80, 24), run_before=at_rest
    )


# -- the list alone ---------------------------------------------------------------------------


def test_what_is_chosen_stays_chosen_while_the_file_changes_around_it():
    listed = PointList(Taught({"a": LEFT, "b": UP})).moved(1)
    assert listed.with_taught(Taught({"aa": LEFT, "a": LEFT, "b": UP})).name == "b"
    assert listed.with_taught(Taught({"a": LEFT})).name == "a"
    assert PointList().moved(1).name == ""


@pytest.mark.parametrize(
    ("names", "free"), [(("p2", "p3"), "p4"), (("p1",), "p2"), (("x", "p2"), "p3")]
)
def test_a_free_name_is_free(names, free):
    assert PointList(Taught(dict.fromkeys(names, LEFT))).free_name() == free
