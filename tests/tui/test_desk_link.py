"""The desk while the link is lost, and when it is back: with a fake arm, then a simulated one."""

from itertools import product

import pytest
from desk_fake import FakeArm
from desk_session import Session

from armdrive import Arm
from armdrive.status import Current, State, Trust

PULLED = {"state": State.DISCONNECTED, "error": "the cable was pulled"}


async def test_a_lost_link_disarms_closes_a_question_and_refuses_every_key_until_it_is_back():
    """It says how to get the arm back, and once."""
    async with Session(FakeArm(simulated=False, trust=Trust.RESTORED)) as session:
        await session.keys("H")
        session.desk.confirmation.press("moves it", session.arm.home)
        session.arm.set(**PULLED)
        await session.poll()
        assert session.desk.confirmation.effect == ""
        assert len(session.desk.screen_stack) == 1
        session.arm.set(state=State.STANDBY, error="", trust=Trust.SUSPECT)
        await session.poll()
        await session.arm_keys()
        session.arm.set(**PULLED)
        await session.poll()
        session.shows("lost", state="LINK LOST  the cable was pulled. Press L. ctrl+q leaves.")
        session.shows("lost", not_messages="let go of a key")
        assert not session.screen.query_one("#near").display, "an empty panel"
        assert not session.screen.armed
        session.arm.calls.clear()
        for key in ("H", "C", "P", "R", "enter", *["q"] * 5):
            session.desk.message = ""
            await session.press(key, after_s=5.0)
            await session.settle()
            session.shows(key, messages="press L")
            assert len(session.desk.screen_stack) == 1
        assert session.arm.calls == []
        session.arm.set(error="the cable is unplugged: plug it in and call `reconnect()`")
        await session.poll()
        said = "LINK LOST  the cable is unplugged: plug it in and press L. ctrl+q leaves."
        session.shows("with its own remedy", state=said)
        await session.press("L")
        await session.settle()
        session.shows("L", state="ERROR  [E409]", messages="nothing was moved", footer="R reset")
        session.shows("L", state="look at the arm, then press R. That moves nothing.")
        assert session.text("trust").endswith("position restored")
        await session.press("q", after_s=5.0)
        assert session.arm.asked("nudge") == []
        await session.press("ctrl+q")
    assert session.desk.return_value == session.desk.return_code == 0


def stop_elsewhere(arm):
    """Have another program stop the arm, which then says so."""
    arm.stops += 1
    arm.set(notice="the arm was stopped: another program asked for it")


async def test_a_stop_by_another_program_disarms_and_takes_back_a_first_press():
    async with Session() as session:
        await session.arm_keys()
        session.desk.confirmation.press("parks", session.arm.home)
        stop_elsewhere(session.arm)
        await session.poll()
        assert not session.desk.current.armed
        assert session.text("messages") == "the arm was stopped: another program asked for it"
        session.desk.confirmation.press("parks", session.arm.home)
        session.clock.now_s += 10.0
        await session.poll()
        assert session.arm.asked("home") == []
        # what is typed into a search would else fall on the keys of the screen
        await session.press("question_mark")
        stop_elsewhere(session.arm)
        await session.poll()
        assert len(session.desk.screen_stack) == 2


async def test_a_stop_by_another_program_makes_a_question_void():
    """A yes counts for nothing, even if it comes before the desk has seen the stop."""
    async with Session(FakeArm(simulated=False)) as session:
        for key, seen in product("HP", (True, False)):
            await session.press(key)
            assert len(session.desk.screen_stack) == 2, (key, seen)
            stop_elsewhere(session.arm)
            if seen:
                await session.poll()
                assert "the arm was stopped" in session.text("messages")
                assert len(session.desk.screen_stack) == 1
                await session.keys("y")
            else:
                session.desk.screen.dismiss(True)
                await session.settle()
            assert session.arm.calls == [], (key, seen)
            assert len(session.desk.screen_stack) == 1
            assert seen or "the arm was stopped" in session.text("messages")


ENDED_HERE = "the jog ended here: further on, the elbow is beyond its limit"


async def test_the_latest_message_is_shown_until_the_next_key_or_screen_or_until_it_is_taken_back():
    async with Session() as session:

        async def hear(notice):
            session.arm.set(notice=notice)
            await session.poll()

        for key in ("v", "right_square_bracket", "f3", "f2"):
            await hear(ENDED_HERE)
            assert session.text("messages") == ENDED_HERE
            await session.press(key)
            await session.poll()
            assert ENDED_HERE not in session.text("messages"), key
        await hear(ENDED_HERE)
        await hear("")
        assert ENDED_HERE not in session.text("messages")
        session.desk.say("STOP requested")
        await hear("the jog was stopped")
        assert session.text("messages") == "the jog was stopped"
        session.desk.say("armed")
        await hear("")
        assert session.text("messages") == "armed"
        # a jog that is refused again says so again, and one that begins does not
        await hear(ENDED_HERE)
        await session.arm_keys()
        await session.tap("w", after_s=3.0)
        await session.poll()
        assert "armed" in session.text("messages")
        await hear(ENDED_HERE)
        assert session.text("messages") == ENDED_HERE


QUICKER = [
    # a screen, a dialect, what stops its arm sooner than the desk
    ("f2", "teachmover", "The pendant's STOP key stops faster"),
    ("f3", "mks", "The motors' power switch stops faster; the arm then sags."),
]


async def test_a_lost_link_promises_no_stop_and_says_how_the_arm_ends():
    async with Session(FakeArm(simulated=False)) as session:
        for screen, dialect, sooner in QUICKER:
            await session.press(screen)
            session.arm.set(
                **PULLED, dialect=dialect, silent_time_s=0.312, silent_distance_mm=20.1,
                trust=Trust.SUSPECT, trust_reason="it was moving",
            )  # fmt: skip
            await session.poll()
            for key in ("", "space"):
                await session.keys(key)
                said = session.text("messages")
                assert said.startswith(sooner)
                assert said.count(" stops faster") == 1
                assert "at any time" not in said
                assert "asked for" not in said
                session.shows(key, not_footer="space", trust="position suspect: it was moving")
                session.shows(
                    key, stopping="NO STOP REACHES IT; it ends by itself within 21 mm, 0.32 s"
                )
            assert session.arm.asked("stop"), "and yet the driver is told"
            session.arm.calls.clear()
            session.arm.set(state=State.STANDBY, error="")
            await session.poll()
            session.shows("back", stopping="a stop takes up to 14 mm, 0.21 s", footer="space")


IMMOBILE_FOR = [
    (State.ERROR_STOP, "held", "the arm is in error-stop: look at the arm, then press R"),
    (State.DISABLED, "off", "the motors are off: press P to switch the motors on"),
    (State.DISABLED, "unknown", "hold the arm all the same: press P to switch the motors on"),
]


async def test_a_state_in_which_nothing_can_move_disarms_and_says_how_to_leave_it():
    async with Session(FakeArm(simulated=False)) as session:
        for state, current, why in IMMOBILE_FOR:
            session.arm.calls.clear()
            await session.hold("q")
            session.arm.set(state=state, current=Current(current))
            await session.poll()
            assert "keys disarmed: the" in session.text("messages")
            assert why in session.text("messages")
            assert "enter arm" not in session.text("footer")
            session.arm.calls.clear()
            for key in ("enter", "q", "1", "H", "K"):
                session.desk.message = ""
                await session.press(key, after_s=5.0)
                await session.settle()
                assert why in session.text("messages"), key
                assert len(session.desk.screen_stack) == 1
            assert session.arm.calls == []
            session.arm.set(state=State.STANDBY)
            await session.poll()
            await session.press("q", after_s=5.0)
            assert session.arm.calls == []


ENDED_IN = {
    "R reset": {"trust": Trust.SUSPECT, "trust_reason": "lost"},
    "P motors": {"state": State.DISABLED, "error": ""},
}


async def test_a_link_that_is_looked_for_by_itself_says_so_and_what_it_ended_in():
    async with Session(FakeArm(simulated=False)) as session:
        session.arm.reconnects = True
        for next_key, ended_in in ENDED_IN.items():
            session.arm.set(state=State.DISCONNECTED, error="the cable was pulled.")
            await session.poll()
            trying = "the cable was pulled. The desk keeps trying to reconnect"
            assert trying in session.text("banner")
            session.arm.set(state=State.STANDBY)  # it is there, and is still being asked
            await session.poll()
            assert "is back" not in session.text("messages")
            session.arm.come_back(**ended_in)
            await session.poll()
            assert session.text("messages") == "the link is back: nothing was moved"
            assert next_key in session.text("footer")


# With an arm whose wire really breaks, on simulated time.


@pytest.fixture
def arm():
    """A simulated arm that stands, referenced."""
    with Arm.connect("sim:teachmover") as arm:
        arm.reference.declare(arm.twin.world.joints, opening_mm=arm.twin.world.opening_mm)
        yield arm


def unplug(arm):
    arm.twin.faults.add("unplug")
    arm.sleep(0.5)


def replug(arm):
    arm.twin.faults.end()
    arm.twin.link.replug("elsewhere")


async def test_an_arm_that_is_unplugged_in_a_jog_comes_back_standing(arm):
    async with Session(arm) as session:
        await session.arm_keys()
        await session.tap("w")
        arm.sleep(0.05)
        assert arm.status.state is State.MOVING
        unplug(arm)
        await session.poll()
        assert "LINK LOST  [E407]" in session.text("banner")
        await session.press("L")
        await session.settle()
        assert "plug it in" in session.text("messages")
        arm.twin.link.line.advance(
            arm.parts.pace.now_s() + 3.0
        )  # what was sent before is carried out
        replug(arm)
        stood = arm.twin.world.motors
        await session.press("L")
        await session.settle()
        assert "elsewhere" in arm.status.link
        assert session.text("trust").endswith("position suspect")
        await session.press("w", "enter", "w", after_s=5.0)
        await session.press("R")
        await session.settle()
        assert arm.status.state is State.STANDBY
        arm.sleep(3.0)
        assert arm.twin.world.motors == stood


async def test_an_emergency_stop_that_cannot_reach_the_arm_says_so(arm):
    async with Session(arm) as session:
        await session.arm_keys()
        unplug(arm)
        await session.press("X")
        assert "the stop did not reach the arm" in session.text("messages")
        assert not session.desk.hand.armed
        arm.request_stop()  # by another program
        await session.poll()
        assert "the arm was stopped" not in session.text("messages")
