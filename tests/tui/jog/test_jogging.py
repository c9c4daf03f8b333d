"""On-screen buttons: pressed is held, and whatever ends that ends it; grasping; the wire's load."""

from dataclasses import replace

import pytest
from amounts import every_row
from desk_fake import MODEL, Clock, FakeArm, unknown_position
from desk_planner import PlannerArm
from desk_session import Session
from textual import events

from armdrive.errors import Refused, Stopped
from armdrive.motion.dead_man import GATE_S, HOLD_LONGEST_S
from armdrive.moves import Jog, ParkMove
from armdrive.status import IN_MOTION, State, Trust
from kinematics.guards.shapes import Box
from tui.axes import AxisRow, AxisTable
from tui.jog import panels as tables
from tui.jog.jogging import MOUSE_HOLDS_S, MOUSE_RENEWS_S, DeskJogging
from tui.safety import stopping_text
from tui.settings import JogSettings


@pytest.fixture
def held():
    """A hand with its arm and clock, holding the button of the shoulder."""
    arm, clock, said = FakeArm(), Clock(), []
    hand = DeskJogging(arm, clock=clock, say=said.append, settings=JogSettings())
    clock.now_s += 10.0
    assert hand.arm_keys()
    clock.now_s += 10.0
    hand.push("w")
    return hand, arm, clock, said


def test_it_is_renewed_before_it_ends_and_let_go_when_the_button_is(held):
    hand, arm, clock, _ = held
    for _ in range(5):
        clock.now_s += MOUSE_RENEWS_S
        hand.tick()
    assert len(arm.asked("hold")) == 6
    assert MOUSE_RENEWS_S < HOLD_LONGEST_S
    hand.lift()
    assert arm.calls[-1] == ("release",)
    arm.calls.clear()
    clock.now_s += 1.0
    hand.tick()
    assert arm.calls == []


def test_a_mouse_that_is_heard_of_no_more_holds_nothing_after_its_time(held):
    hand, arm, clock, said = held
    began_s = clock.now_s
    while hand.held_button and clock.now_s <= began_s + MOUSE_HOLDS_S + 1.0:
        clock.now_s += 0.01
        hand.tick()
    assert clock.now_s - began_s <= MOUSE_HOLDS_S + 0.011
    assert arm.calls[-1] == ("release",)
    assert "the mouse sent nothing" in said[-1]
    last = arm.asked("hold")[-1]
    assert last[3] <= HOLD_LONGEST_S


def test_a_stop_by_another_program_ends_what_is_held_and_disarms(held):
    hand, arm, clock, said = held
    arm.calls.clear()
    arm.stops += 1
    for _ in range(5):
        clock.now_s += MOUSE_RENEWS_S
        hand.tick()
    assert arm.asked("hold") == []
    assert not hand.armed
    assert said == ["keys disarmed: the arm was stopped"]


def test_a_key_that_repeats_after_a_stop_by_another_program_moves_nothing():
    """Also before the desk has looked at the arm again."""
    arm, clock, said = FakeArm(), Clock(), []
    hand = DeskJogging(arm, clock=clock, say=said.append, settings=JogSettings())
    clock.now_s += 10.0
    hand.arm_keys()
    clock.now_s += 10.0
    hand.press("w")
    clock.now_s += GATE_S
    hand.tick()
    assert len(arm.asked("nudge")) == 1
    arm.stops += 1
    for _ in range(20):
        clock.now_s += 0.1
        hand.press("w")
        hand.tick()
    assert arm.asked("hold") == []
    assert len(arm.asked("nudge")) == 1
    assert said == ["keys disarmed: the arm was stopped"]
    clock.now_s += 10.0
    assert hand.arm_keys()
    clock.now_s += 10.0
    hand.press("w")
    clock.now_s += GATE_S
    hand.tick()
    assert len(arm.asked("nudge")) == 2


def test_a_nudge_of_the_mouse_goes_on(held):
    hand, _, clock, _ = held
    clock.now_s += MOUSE_HOLDS_S - 0.05
    hand.moved()
    clock.now_s += MOUSE_HOLDS_S - 0.05
    hand.tick()
    assert hand.held_button == "w"


@pytest.mark.parametrize(
    "end", [lambda h: h.disarm("x"), lambda h: h.release(), lambda h: h.press("e")]
)
def test_disarming_other_settings_and_a_key_let_go_of_the_button(held, end):
    hand, arm, _, _ = held
    end(hand)
    assert hand.held_button == ""
    assert ("release",) in arm.calls


def test_a_button_moves_nothing_until_the_keys_are_armed():
    arm, said = FakeArm(), []
    hand = DeskJogging(arm, clock=Clock(), say=said.append, settings=JogSettings())
    hand.push("w")
    assert arm.calls == []
    assert said == ["jog keys move nothing before they are armed"]


def button(session, table, row, *, plus):
    """Return the place of a button on the screen."""
    inner = session.screen.query_one(f"#{table}", AxisTable).content_region
    return inner.x + (1 if plus else 4), inner.y + row


async def mouse(session, kind, place):
    x, y = place
    event = kind(None, x, y, 0, 0, 1, False, False, False, screen_x=x, screen_y=y)
    await session.send(event)


async def test_the_mouse_holds_a_button_on_the_screen_and_letting_go_or_leaving_it_ends_that():
    async with Session() as session:
        await session.arm_keys()
        place = button(session, "joints", 1, plus=False)
        await mouse(session, events.MouseDown, place)
        assert session.arm.calls[-1][:2] == ("hold", Jog.joint(shoulder=-1.0))
        await mouse(session, events.MouseUp, place)
        assert session.arm.calls[-1] == ("release",)
        assert session.screen.armed
        session.arm.calls.clear()
        x, y = button(session, "joints", 0, plus=True)
        await mouse(session, events.MouseDown, (x, y))
        await mouse(session, events.MouseMove, (x + 1, y))
        assert session.arm.asked("release") == []
        await mouse(session, events.MouseMove, (x, y + 1))
        assert session.arm.calls[-1] == ("release",)


async def lose_the_link(session):
    session.arm.set(state=State.DISCONNECTED, error="the cable was pulled")
    await session.poll()
    assert not session.screen.armed


async def test_what_takes_the_screen_or_the_arm_away_lets_go_of_a_button():
    async with Session() as session:
        for end in ("T", "question_mark", "f3", lose_the_link):
            await session.keys("space f2")
            await session.arm_keys()
            await mouse(session, events.MouseDown, button(session, "joints", 0, plus=True))
            await (session.press(end) if isinstance(end, str) else end(session))
            held = end == "T"  # other colours take nothing away
            assert (session.arm.calls[-1][0] == "hold") == held, end


async def test_limits_are_shown_only_where_they_end_a_jog():
    arm = FakeArm()
    known = arm.status
    async with Session(arm) as session:
        for trust in Trust:
            arm.status = replace(known, trust=trust)
            if trust is Trust.UNKNOWN:
                arm.set(**unknown_position())
            await session.arm_keys()
            await session.poll()
            hold = trust is Trust.REFERENCED
            parts = {"state": "NO LIMITS", "near": "NO LIMITS", "not_near": "from its limit"}
            swap = {"state": "not_state", "near": "not_near", "not_near": "near"}
            session.shows(trust, **{swap[at] if hold else at: text for at, text in parts.items()})
            await session.press("m")
            assert (session.screen.query_one("#tip", AxisTable).at(1, 0) == "q") == hold
            said = "tap a key" if hold else "the tip needs a reference first"
            session.shows("the tip", state=said)
            await session.press("m")


async def test_keys_are_not_armed_while_something_else_moves_the_arm():
    """A key that is still held when the arm stands would begin a jog then."""
    async with Session() as session:
        for state in IN_MOTION:
            session.arm.set(state=state)
            await session.poll()
            await session.press("enter")
            assert not session.screen.armed
            session.shows(state, messages=f"the arm is {state.value}: wait until it stands")
            session.shows(state, not_footer="enter arm")
        session.arm.set(state=State.STANDBY)
        await session.poll()
        session.shows("it stands", footer="enter arm")
        await session.hold()
        session.arm.set(state=State.MOVING)
        await session.poll()
        await session.press("enter", after_s=1.0)
        assert session.screen.armed, "what moves is a jog of these keys"


async def test_grasping_is_armed_first_then_says_what_the_fingers_found():
    async with Session() as session:
        await session.press("G")
        assert session.arm.asked("grasp") == []
        assert "enter arms the keys first" in session.text("messages")
        await session.arm_keys()
        await session.once("G")
        assert session.arm.asked("grasp") == [("grasp",)]
        assert not session.screen.armed
        assert "grasped: 30.0 mm wide, pressed with 8.9 N" in session.text("messages")
        assert "pressing 8.9 N" in session.text("gripper")


@pytest.mark.parametrize("key", ["G", "1"])
async def test_a_stop_after_the_press_lets_the_fingers_begin_nothing(key):
    async with Session() as session:
        await session.arm_keys()
        session.desk.calls.make = lambda call: (session.arm.request_stop(), begun.append(call))
        begun = []
        await session.once(key)
        with pytest.raises(Stopped):
            begun[0]()
        assert session.arm.asked("grasp") == session.arm.asked("open") == []


async def test_the_pose_is_shown_in_the_frame_that_is_jogged():
    async with Session() as session:
        await session.press("m")
        assert "256.3mm" in session.text("tip")
        await session.press("F", "F")
        assert session.title("tip") == "Tip: board frame"
        assert "156.3mm" in session.text("tip")


@every_row("distance_mm, shown", [(0.0, "0 mm"), (0.3, "1 mm"), (50.0, "50 mm"), (119.2, "120 mm")])
def test_the_stopping_distance_is_never_shown_shorter_than_it_is(distance_mm, shown):
    text = stopping_text(FakeArm(state=State.MOVING, stop_distance_mm=distance_mm).status)
    assert text == f"a stop takes up to {shown}, 0.21 s"


def test_digital_lines_are_told_apart_by_their_numbers():
    status = FakeArm(inputs=0b101, outputs=0b10).status
    lines = tables.detail_lines(status)
    assert "inputs 1 . 3 . . . .  outputs . 2 . . . . . ." in lines


async def test_a_gripper_preset_moves_the_fingers_once_the_keys_are_armed():
    async with Session(PlannerArm()) as session:
        for key, opening_mm in (("1", 76.0), ("2", 38.0), ("3", 0.0)):
            session.arm.calls.clear()
            await session.keys(key)
            assert session.arm.asked("open") == []
            session.shows(key, messages="enter arms the keys first")
            await session.arm_keys()
            await session.once(key)
            assert session.arm.asked("open") == [("open", opening_mm, 0.25)]
            assert not session.screen.armed
        await session.arm_keys()
        await session.press("1")
        session.screen.hand.disarm("the arm is in error-stop")
        session.clock.now_s += 1.0
        await session.settle()
        assert len(session.arm.asked("open")) == 1, "the keys were disarmed meanwhile"


async def test_the_arm_is_parked_only_after_a_yes():
    arm = PlannerArm()
    async with Session(arm) as session:
        for answer, asked_for in (("n", []), ("y", [ParkMove(0.25)])):
            await session.keys("K")
            assert "THE ARM WILL MOVE" in session.desk.screen.query_one("#posture-text").shown
            await session.keys("enter")
            assert arm.asked_for == [], "enter is neither yes nor no"
            await session.keys(answer)
            assert arm.asked_for == asked_for
        arm.hindrance = Refused("the position is only restored")
        await session.follow([("K", {"messages": "the position is only restored"})])
        assert len(session.desk.screen_stack) == 1


def near(arm):
    """Return what is said to be near an arm, with a vice at 290 mm along x."""
    return "\n".join(text for text, _ in tables.near_lines(arm.status, arm.model, (), ""))


@every_row(
    "z_mm, said",
    [(4.6, "table: 5 mm (tip z)"), (-0.4, "table: 0 mm (tip z)"), (-0.9, "table: -1 mm (tip z)")],
)
def test_the_table_is_always_among_what_is_near(z_mm, said):
    arm = FakeArm()
    arm.set(joints=MODEL.arm.ik(replace(arm.status.pose, z_mm=z_mm)))
    assert said in near(arm)


@every_row("x_mm, said", [(290.0, "9 mm (hand)"), (262.0, "-19 mm (hand)"), (340.0, None)])
def test_a_box_that_a_link_is_near_to_or_inside_of_is_named(x_mm, said):
    arm = FakeArm()
    box = Box("vice", (x_mm, 50.0, 100.0), (400.0, 140.0, 230.0))
    guards = replace(arm.model.guards, radii_mm=(35.0, 30.0, 25.0), boxes=(box,))
    arm.model = replace(arm.model, guards=guards)
    assert (f"box vice: {said}" in near(arm)) if said else ("box vice" not in near(arm))


@every_row("value, sign", [(0.0, "!!"), (-91.0, "!!"), (85.0, ""), (-89.0, "!!"), (-84.0, "!")])
def test_a_value_near_its_limit_has_a_sign_as_well_as_a_colour(value, sign):
    limits = (-89.0, 120.0) if value == -89.0 else (-90.0, 120.0)
    limits = (0.0, 120.0) if value == 0.0 else limits
    assert AxisRow("base", value, "", limits).sign == sign
