"""A desk that was suspended: whatever was typed meanwhile, and however it comes, moves nothing."""

import math

import pytest
from amounts import amount
from desk_fake import FakeArm
from desk_planner import PlannerArm
from desk_session import Session
from hypothesis import given
from hypothesis import strategies as st
from textual import events
from textual._xterm_parser import XTermParser

from armdrive.motion.dead_man import GATE_S
from tui.app import POLL_S
from tui.arm_view import SpaceView
from tui.keys.presses import QUIET_S, SILENCE_S, STARVED_S, SUSPENDED_S, Freshness

RIGHT = "\x1b[C"
KEYBOARDS = {
    "one key": [(0.0, "w")],
    "two keys": [(0.0, "ww")],
    "three keys, and a pause": [(0.0, "www"), (0.4, "")],
    "four keys": [(0.0, "wwww")],
    "thirty keys": [(0.0, "w" * 30)],
    "one by one": [(0.02, "w")] * 8,
    "as a keyboard repeats": [(0.033, "w")] * 12,
    "slowly": [(0.1, "w")] * 5,
    "three, a pause, and more": [(0.0, "www"), (0.4, "w"), (0.03, "w"), (0.6, "ww")],
    "after a while": [(0.2, "w"), (0.7, "w")],
    "several keys": [(0.0, "wsqe"), (0.05, "d")],
    "an arrow": [(0.0, RIGHT)],
    "arrows": [(0.0, RIGHT * 3), (0.2, RIGHT)],
    "an arrow in two pieces": [(0.0, "\x1b"), (0.01, "[C")],
    "an arrow in three pieces": [(0.0, RIGHT + "\x1b"), (0.02, "["), (0.02, "C" + RIGHT)],
    "an arrow that is never whole": [(0.0, RIGHT + "\x1b[")],
    "arming": [(0.0, "\r"), (0.1, "w"), (0.1, "w")],
    "arming again and again": [(0.0, "\r"), (0.2, "\rw"), (0.25, "\rw"), (0.28, "\r"), (0.28, "w")],
}
"""What comes after a suspension: so long after what was before, these bytes."""

LENGTHS_S = {True: (0.02, 0.9, 4000.0), False: (0.31, 4000.0)}
"""By whether the system tells of it: a short one is known by that alone."""


class Suspended(Session):
    """A desk on the test's clock alone, with a keyboard that sends bytes."""

    def __init__(self, arm=None, **more):
        super().__init__(arm or FakeArm(), **more)
        desk = self.desk
        desk.input.monotonic_s, desk.input.busy_s = self.clock, lambda: 0.0
        desk.input.fresh.suspended_s, desk.input.fresh.starved_s = SUSPENDED_S, STARVED_S
        del desk.input.key_age_s  # it follows from when a key came, here too
        self._parser = XTermParser()

    async def type(self, text, came_s=None):
        for event in [*self._parser.feed(text)] if text else []:
            event.time = self.clock.now_s if came_s is None else came_s
            self.desk.post_message(event)
        await self.pilot.pause()

    async def type_goal(self):
        """Go to the move screen, and type a goal."""
        for text in ("\x1bOR", "250"):
            await self.type(text)
            await self.pass_by(1.0)
            await self.settle()

    async def pass_by(self, time_s):
        """Let time pass in which the desk looks about as often as it does."""
        end_s = self.clock.now_s + time_s
        while self.clock.now_s < end_s:
            self.clock.now_s = min(self.clock.now_s + POLL_S, end_s)
            self.desk.input.alive()
            if self.screen.hand is not None:
                self.tick()
        if self.screen.place != "jog":
            self.desk.poll()

    async def hold(self, key):
        """Hold a key until it moves the arm."""
        await self.type(key)
        await self.pass_by(0.4)
        for _ in range(2):
            await self.type(key)
            await self.pass_by(0.033)

    async def arm_again(self):
        await self.pass_by(2.5)
        await self.type("\r")
        await self.pass_by(2.5)
        assert self.screen.armed

    async def suspend(self, time_s, *, told):
        self.clock.now_s += time_s
        if told:
            self.desk.input.fresh.suspended()
        self.arm.calls.clear()

    @property
    def moved(self):
        return [call for call in self.arm.calls if call[0] in ("nudge", "hold", "grasp")]


async def nothing(session):
    """Do nothing before the suspension."""


async def holding(session):
    await session.hold("w")
    assert session.arm.asked("hold")


async def pressing(session):
    """Have a key wait to be told from backlog."""
    await session.type("w")
    await session.pass_by(1.0)
    await session.type("w")
    assert math.isfinite(session.screen.hand._deadman.next_s())


EVERY = amount(3, 1)
"""Of the keyboards each case tries as many; all cases together try all."""


def sampled(before, told):
    return (3 * told + [nothing, holding, pressing].index(before)) % EVERY


@pytest.mark.parametrize("told", [True, False])
@pytest.mark.parametrize("before", [nothing, holding, pressing])
async def test_nothing_that_was_typed_into_a_suspended_desk_moves_the_arm(before, told):
    async with Suspended() as session:
        session.desk.show = lambda: None  # what is painted is not looked at
        for time_s in LENGTHS_S[told]:
            for how, pieces in [*KEYBOARDS.items()][sampled(before, told) :: EVERY]:
                await session.arm_again()
                await before(session)
                await session.suspend(time_s, told=told)
                for later_s, text in pieces:
                    await session.pass_by(later_s)
                    await session.type(text)
                await session.pass_by(1.0)
                assert session.moved == [], (how, time_s)
                await session.type("C")  # what an arrow has begun is at an end


async def test_a_key_behind_a_suspension_or_a_wait_disarms_and_the_desk_says_why():
    async with Suspended() as session:
        await session.arm_again()
        await session.suspend(0.2, told=True)
        await session.type("w")
        assert "this program was suspended for 0.2 s" in session.text("messages")
        assert not session.screen.armed
        await session.arm_again()
        await session.suspend(2.0, told=False)
        await session.pass_by(2.0)
        assert not session.screen.armed, "also without a key"
        await session.arm_again()
        await pressing(session)
        await session.suspend(2.0, told=False)
        session.screen.hand.alarm._ring()  # before anything else
        await session.pilot.pause()
        assert session.moved == []
        await session.arm_again()
        await session.type("w")
        await session.pass_by(POLL_S)
        assert len(session.arm.asked("nudge")) == 1
        await holding(session)
        await session.suspend(0.5, told=False)
        session.desk.input.alive()
        assert session.arm.calls == [("release",)], "what was held ends, whatever comes next"
        session.desk.screen.call_later = lambda *_: None  # at once, not only after other keys
        await session.type("w")
        assert "kept waiting for 0.5 s" in session.text("messages")
        assert not session.screen.armed


async def test_keys_that_a_busy_desk_acts_on_late_are_judged_by_when_they_came():
    """Repeats that come at once, and are acted on one by one, are backlog all the same."""
    async with Suspended() as session:
        await session.arm_again()
        await session.hold("w")
        await session.pass_by(0.9)
        session.arm.calls.clear()
        came_s = session.clock.now_s
        for _ in range(5):
            session.clock.now_s += 0.2
            await session.type("w", came_s)
        assert session.moved == []
        assert not session.screen.armed


async def test_a_key_that_is_dropped_is_said_and_a_stop_is_never_dropped():
    async with Suspended() as session:
        await session.suspend(2.0, told=False)
        await session.type("\r")
        await session.pass_by(0.1)
        await session.poll()
        assert not session.screen.armed
        assert "a key was dropped" in session.text("messages")
        await session.pass_by(1.0)
        await session.type("\r")
        assert session.screen.armed
        await session.suspend(3.0, told=True)
        await session.type("ww ")
        assert session.arm.asked("stop")


async def test_a_desk_that_took_long_to_start_takes_the_first_key():
    async with Suspended() as session:
        session.desk.input.alive()
        session.clock.now_s += 5.0  # the rest of its start, for which another thread was needed
        session.desk.input.fresh.begin()
        await session.type("\r")
        assert session.screen.armed


async def test_no_goal_is_confirmed_by_what_was_typed_meanwhile():
    async with Suspended(PlannerArm()) as session:
        await session.type_goal()
        assert "twice moves the arm" in session.text("going")
        for told in (True, False):
            await session.suspend(2.0, told=told)
            await session.type("\r")
            await session.pass_by(0.1)
            await session.type("\r")
            await session.pass_by(2.0)
            await session.settle()
            assert session.arm.asked_for == []
            await session.pass_by(20.0)
        await session.type("\r")
        await session.pass_by(0.2)
        await session.suspend(0.2, told=True)
        await session.type("\r")
        await session.pass_by(2.0)
        await session.settle()
        assert session.arm.asked_for == []


async def test_no_question_is_answered_by_what_was_typed_meanwhile():
    async with Suspended(FakeArm(simulated=False)) as session:
        await session.type("H")
        await session.pass_by(0.1)
        await session.suspend(0.4, told=True)
        await session.type("y")
        await session.pass_by(1.0)
        assert session.arm.calls == []
        assert len(session.desk.screen_stack) == 2
        await session.type("y")
        await session.pass_by(QUIET_S + 0.1)
        await session.settle()
        assert session.arm.asked("reference")


async def mouse(session, kind, x, y):
    event = kind(None, x, y, 0, 0, 1, False, False, False, screen_x=x, screen_y=y)
    event.time = session.clock.now_s
    await session.send(event)


@pytest.mark.parametrize("time_s", [STARVED_S + 0.1, SUSPENDED_S + 0.1])
async def test_what_the_mouse_held_before_is_let_go_though_its_release_is_dropped(time_s):
    async with Suspended(size=(120, 40)) as session:
        view = session.screen.query_one(SpaceView)
        x, y = view.region.x + 5, view.region.y + 5
        await mouse(session, events.MouseDown, x, y)
        await mouse(session, events.MouseMove, x + 1, y)
        turned = view.camera
        await session.suspend(time_s, told=False)
        await mouse(session, events.MouseUp, x + 1, y)
        await session.pass_by(1.0)
        await mouse(session, events.MouseMove, x + 9, y)
        assert view.camera == turned
        assert session.desk.mouse_captured is None


# Not every terminal marks what is pasted: then its letters come as keys, all at once.


class Pasted(Suspended):
    """A desk whose terminal does not mark pasted text."""

    def __init__(self, arm):
        super().__init__(arm)
        self.desk.input.fresh.person_s = GATE_S

    async def paste(self, text):
        await self.type(text)
        for _ in range(2):  # it is confirmed, and then done
            await self.pass_by(1.0)
            await self.settle()


async def test_two_pasted_line_ends_confirm_no_motion():
    async with Pasted(PlannerArm()) as session:
        await session.type_goal()
        for text in ("\r\r", "\r\rx", "\r\r\r\r"):
            await session.paste(text)
            assert session.arm.asked_for == [], repr(text)
            assert session.desk.confirmation.effect == ""
        for _ in range(2):
            await session.type("\r")
            await session.pass_by(1.0)
        await session.paste("")
        assert len(session.arm.asked_for) == 1, "a person presses it twice"


async def test_pasted_lines_neither_leave_the_keys_armed_nor_move_the_fingers():
    async with Pasted(PlannerArm()) as session:
        for text in ("\r123", "a\rqqqq", "x\r1\rG\r"):
            session.arm.calls.clear()
            await session.paste(text)
            assert session.moved == session.arm.asked("open") == [], repr(text)
            assert not session.screen.armed
            assert "as fast as pasted text" in session.text("messages")
            await session.type("\r")
            assert session.screen.armed
            await session.pass_by(1.0)
            await session.paste("12")
            assert session.arm.asked("open") == [], "the first letter of a paste is no press"
            assert not session.screen.armed
        for key in ("\r", "1"):
            await session.paste(key)
        assert session.arm.asked("open"), "a person arms the keys and opens the fingers"


async def test_a_pasted_word_answers_no_question_that_it_asks():
    async with Pasted(PlannerArm()) as session:
        for text in ("Ky", "Kilroy"):
            await session.paste(text)
            assert session.arm.asked_for == [], text
            await session.paste(" ")
        await session.paste("K")
        for text in ("yx", "qy"):
            await session.paste(text)
            assert session.arm.asked_for == [], "neither its first letter nor one that jogs"
        await session.paste("y")
        assert len(session.arm.asked_for) == 1, "a person has read it"


ONE_KEY_ACTS = {
    # what a letter alone does, seen in what the screen says
    "]": ("stopping", "step [5"),
    "m": ("tip", "Tip, Cartesian"),
    "D": ("details", "position"),
    "T": ("messages", "look: light"),
}


async def test_no_letter_of_a_paste_but_the_first_does_anything_and_alone_each_does():
    async with Pasted(PlannerArm()) as session:
        for key, (part, said) in ONE_KEY_ACTS.items():
            show = session.title if part == "tip" else session.text
            for text in (f"x{key}", f"qq{key}q"):
                await session.paste(text)
                assert said not in show(part), text
            await session.paste(key)
            assert said in show(part), key


async def test_what_follows_a_paste_is_dropped_until_there_is_a_silence_and_no_held_key_is_one():
    async with Pasted(PlannerArm()) as session:
        await session.type("xy")
        for _ in range(4):
            await session.pass_by(SILENCE_S - 0.1)
            await session.type("m")
            assert session.title("tip") == "Tip"
            assert "press again" in session.text("messages")
        await session.pass_by(SILENCE_S + 0.1)
        for gap_s in (0.4, 0.015, 0.015):  # the fastest keyboards repeat as soon
            await session.type("]")
            await session.pass_by(gap_s)
        assert "step [20" in session.text("stopping")
        await session.type("m")
        assert session.title("tip") == "Tip, Cartesian"


async def test_letters_that_are_typed_may_come_at_once_and_a_line_end_with_them_takes_nothing():
    async with Pasted(PlannerArm()) as session:
        await session.type("\x1bOR")
        await session.pass_by(1.0)
        await session.settle()
        await session.type("250\r\r")
        assert session.screen.typing.text == "250"
        await session.paste("")
        assert session.arm.asked_for == []
        await session.type("\x10")
        await session.settle()
        await session.pass_by(1.0)
        await session.type("pa")
        assert session.desk.focused.value == "pa"


GAPS = st.lists(st.floats(0.0, SILENCE_S * 0.99), max_size=20)


@given(st.floats(0.0, 1e6), GAPS)
def test_all_is_old_until_there_is_a_silence(now_s, gaps_s):
    fresh = Freshness()
    fresh.expire(now_s, "suspended")
    came_s = now_s
    for gap_s in gaps_s:
        came_s += gap_s
        assert fresh.stale(came_s)
    assert not fresh.stale(came_s + SILENCE_S + 0.01)
