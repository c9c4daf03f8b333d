"""The points screen: places are named, gone to after two presses, and written into a program."""

import pytest
from desk_planner import PlannerArm
from desk_session import AGAIN_S, Session

from armdrive.status import State
from armdrive.storage.points import Point
from kinematics import Joints
from tui.keys.table import POINT_KEYS
from tui.points.edit import PointSelection

LEFT = Point(Joints.of(30.0, 60.0, -80.0, -60.0, 0.0), 20.0, "by the wall")
RIGHT = Point(Joints.of(-20.0, 60.0, -80.0, -60.0, 0.0))
UP = Point(Joints.of(-20.0, 80.0, -80.0, -60.0, 0.0))
BEYOND = Point(Joints.of(0.0, 300.0, -80.0, -60.0, 0.0))


def taught_arm():
    arm = PlannerArm()
    for name, point in {"left": LEFT, "right": RIGHT, "up": UP}.items():
        arm.points[name] = point
    return arm


class PointSession(Session):
    """A desk at its points screen, with an arm that has been taught."""

    first = "points"

    def __init__(self, arm=None, **more):
        super().__init__(arm or taught_arm(), **more)

    async def choose(self, name):
        for _ in range(10):
            if self.screen.selection.name == name:
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


async def test_the_list_shows_points_and_a_click_or_a_key_chooses_one():
    async with PointSession(size=(120, 40)) as session:
        assert session.text("list").split("\n")[0].startswith("> left")
        session.shows("a point", list="right", chosen="base 30.0°", ahead="takes")
        session.shows("its note", chosen="by the wall")
        await session.press("enter")
        assert session.desk.confirmation.effect
        await session.pilot.click("#list", offset=(4, 2))
        await session.settle()
        assert session.screen.selection.name == "right"
        assert not session.desk.confirmation.effect, "a first press is taken back"
        await session.follow([("down", {"list": "> up", "chosen": "base -20.0°"})])


async def test_points_are_renamed_and_deleted_while_the_link_is_lost():
    async with PointSession() as session:
        session.arm.set(state=State.DISCONNECTED, error="the cable was pulled")
        await session.poll()
        await session.keys("r 'ab enter")
        assert set(session.arm.points) == {"leftab", "right", "up"}
        await session.twice("delete")
        assert set(session.arm.points) == {"right", "up"}


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
        assert session.screen.selection.name == "upp"


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


# -- a program of points ------------------------------------------------------------------------


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """The current folder, where programs are."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


APPENDED = [
    # keys; the lines that they append to the program, what the screen shows
    ("a enter", ["speed 50%", "move up"], {"messages": "taught.arm, line 2: speed 50% / move up"}),
    ("g", [], {"begin": "fingers: open, close, grasp, here, or mm: grasp_"}),
    ("enter", ["grasp"], {"program": "grasp"}),
    ("W '1.5 enter", ["delay 1.5"], {}),
    ("g 'here enter", ["open_now 38"], {}),
    ("l greater_than_sign a enter", ["speed 100%", "move_line up"], {}),
    # what is no line can be corrected
    ("g 'wide enter", [], {"messages": "'wide' is not a number", "begin": "wide_"}),
    ("escape g '1000 enter", [],
     {"messages": "the gripper opens from 0 to 76 mm, not to 1000 mm", "begin": "1000_"}),
    ("space a backspace enter", [], {"messages": "is not a valid name"}),
    ("space W 'soon enter", [], {"messages": "'soon' is not a number", "begin": "soon_"}),
    ("space", [], {"not_begin": "seconds"}),
]  # fmt: skip


async def test_points_fingers_and_waits_are_appended_to_a_program(folder):
    async with PointSession() as session:
        await session.choose("up")
        for key, said in (("g", "a on a point begins"), ("backspace", "no line to take back")):
            await session.keys(key)
            session.shows(key, messages=said)
        expected = []
        for line, lines, shown in APPENDED:
            await session.burst(line)
            expected += lines
            path = folder / "taught.arm"
            assert path.read_text(encoding="utf-8").splitlines() == expected, line
            session.shows(line, **shown)
        await session.keys("backspace")
        assert path.read_text(encoding="utf-8").splitlines() == expected[:-2]
        await session.keys("backspace")
        session.shows("a second one", messages="no line to take back")
        assert session.arm.asked_for == session.arm.asked("open") == []


async def test_a_program_that_a_person_edits_meanwhile_is_followed_and_not_overwritten(folder):
    async with PointSession() as session:
        await session.choose("up")
        await session.burst("a 'stack enter")
        path = folder / "stack.arm"
        path.write_text("# mine\nspeed 25%", encoding="utf-8")
        await session.keys("backspace")
        session.shows("backspace", messages="has changed meanwhile", program="mine")
        await session.keys("a enter")
        assert path.read_text(encoding="utf-8") == "# mine\nspeed 25%\nspeed 50%\nmove up\n"
        path.write_bytes(b"# caf\xe9 \n")
        await session.settle()
        await session.settle()
        session.shows("a file that cannot be read", messages="is not UTF-8 text", program="move up")
        path.write_bytes(b"# \x1b[31mred\n")
        await session.settle()
        session.shows("hostile text", program="# \\x1b[31mred")
        path.write_text("mov up\n", encoding="utf-8")
        await session.keys("a enter")
        session.shows("a mistake", messages="'mov'")
        assert path.read_text(encoding="utf-8") == "mov up\n"


async def test_a_motion_is_paused_and_goes_on_and_a_held_key_does_not_count():
    async with PointSession() as session:
        await session.keys("p")
        session.shows("an arm that stands", messages="nothing moves")
        session.arm.set(state=State.MOVING)
        await session.poll()
        session.shows("moving", footer="p pause", not_footer="go")
        await session.once("p")
        here = "PAUSED  p resumes it"
        session.shows("p", banner=here)
        for gap_s in (0.5, 0.03, 0.03, 0.5, 0.6):
            await session.press("p", after_s=gap_s)
            await session.poll()
        session.shows("a key that is held", banner=here)
        await session.once("p")
        session.arm.set(state=State.STANDBY)
        asked = [call[0] for call in session.arm.calls if call[0] in ("pause", "resume")]
        assert asked == ["pause", "resume"]


async def test_an_empty_list_says_how_a_point_is_made_and_every_key_is_harmless():
    async with PointSession(PlannerArm()) as session:
        session.shows("no points", list="no points yet: t names")
        for row in POINT_KEYS:
            await session.press(row.keys[0], "escape")
            await session.settle()
        assert session.arm.asked_for == []
        assert not session.arm.points


# -- the list alone ---------------------------------------------------------------------------


def selection(*names):
    found = PointSelection(None, lambda: None)
    found.points = dict.fromkeys(names, LEFT)
    return found


def test_what_is_chosen_stays_chosen_while_the_file_changes_around_it():
    listed = selection("a", "b")
    listed.move(1)
    for names, chosen in ((("aa", "a", "b"), "b"), (("a",), "a"), ((), "")):
        listed.points = selection(*names).points
        assert listed.name == chosen
        listed.choose(chosen)
    listed.move(1)
    assert listed.name == ""
