"""Watching somebody else's arm: with a fake holder, then with an arm that is really held."""

from functools import partial
from types import SimpleNamespace

import pytest
from desk_fake import END, MODEL, FakeArm, FakeHolder, unknown_position
from desk_session import AppSession
from waiting import until_seen

from armdrive import Arm
from armdrive.cli.chosen_arm import connect_remembered
from armdrive.connect.target import find
from armdrive.errors import ArmError, HolderError
from armdrive.status import State, status_view
from armdrive.storage.lock_client import ask_holder, watch_holder
from tui.app import POLL_S
from tui.keys.presses import QUIET_S, Confirmation
from tui.safety import SafetyPanel
from tui.watch import Watching


class Session(AppSession):
    """A watching app on a headless terminal."""

    def __init__(self, holder, **more):
        self.holder = holder
        self.now_s = 100.0
        app = Watching("sim", MODEL, holder.views(), holder.ask, braille=True, **more)
        app.confirmation = Confirmation(lambda: self.now_s)
        super().__init__(app, size=(100, 30))

    async def __aenter__(self):
        await super().__aenter__()
        await self.seen(lambda: self.text("title"))
        return self

    async def __aexit__(self, *error):
        if isinstance(self.holder, FakeHolder):
            self.holder.said.put(END)
        await super().__aexit__(*error)

    async def seen(self, happened):
        """Wait until the app has heard of something: another thread tells it."""
        await until_seen(happened, self.pilot.pause)
        self.app.poll()
        await self.pilot.pause()

    async def hear(self, view):
        self.holder.said.put(view)
        await self.seen(lambda: self.app.view == view)

    async def press(self, key):
        await super().press(key)
        await self.look()

    async def look(self):
        self.app.poll()
        await self.app.workers.wait_for_complete()
        await self.pilot.pause()

    @property
    def everything(self):
        return "\n".join(self.text(name) for name in ("state", "trust", "stopping", "watched"))

    def text(self, name):
        if name == "title":
            return self.app.screen.query_one(SafetyPanel).arm
        return super().text(name)


async def test_what_the_holder_says_is_shown_and_that_it_is_only_watched():
    async with Session(FakeHolder()) as session:
        assert "WATCHING sim" in session.text("title")
        view = status_view(FakeArm().status)
        await session.hear(view)
        assert session.text("title").startswith("SIMULATED, WATCHED: sim (TeachMover)")
        shown = session.everything
        for word in ("READY", "shoulder", "60.0°", "referenced", "38.0 mm open", "14 mm, 0.21 s"):
            assert word in shown
        assert session.text("footer").startswith("space STOP")
        await session.hear({**view, "program": {"file": "stack", "line": 7, "text": "grip 20"}})
        assert session.text("program") == "7  grip 20"
        worse = status_view(FakeArm(error="the elbow slipped", notice="it is warm").status)
        await session.hear({**worse, "program": {"file": "stack.arm", "line": 12}})
        # above what a small terminal cuts off
        assert session.text("watched").splitlines()[:5] == [
            "speed     100%",
            "program   stack.arm, line 12: ",
            "notice    it is warm",
            "error     the elbow slipped",
            "motors    on: they hold the arm",
        ]
        await session.hear({**view, "program": {}})
        assert "program" not in session.text("watched")
        assert not session.app.screen.query_one("#program").display
        await session.hear(status_view(FakeArm(state=State.DISCONNECTED).status))
        assert "NO STOP REACHES IT" in session.text("stopping")
        await session.hear(status_view(FakeArm(**unknown_position()).status))
        assert session.text("trust").endswith("unknown: no position of this arm has been saved")
        assert "joints" not in session.text("watched")
        await session.press("ctrl+q")
    assert session.app.return_value == 0
    assert session.holder.asked == [], "leaving stops nothing"


ASKED = [
    ("space", ("stop", {})),
    ("escape", ("stop", {})),
    ("p", ("pause", {})),
    ("r", ("resume", {})),
    ("minus", ("slow", {"percent": 75})),
]


async def test_every_key_asks_for_its_own_and_says_what_was_refused_or_not_received():
    async with Session(FakeHolder()) as session:
        for key, request in ASKED:
            session.holder.asked.clear()
            await session.press(key)
            if key == "r":
                assert session.holder.asked == [], "not before no other key can have come with it"
                session.now_s += QUIET_S + 0.1
                await session.look()
            assert session.holder.asked == [request]
        session.holder.answer = {"error": "nothing is paused"}
        await session.press("p")
        assert "nothing is paused" in session.text("messages")
        session.holder.answer = ArmError("the program does not answer")
        await session.press("space")
        assert "STOP WAS NOT RECEIVED: the program does not answer" in session.text("messages")
        assert "switch" in session.text("messages")
        session.holder.asked.clear()
        await session.hear(status_view(FakeArm(speed_override=0.5).status))
        await session.press("plus")
        await session.press("minus")
        assert [words["percent"] for _, words in session.holder.asked] == [75, 25]


ENDS = [
    (END, "released the arm"),
    (ArmError("it fell silent"), "it fell silent"),
    (HolderError("16 programs watch"), "16 programs watch"),
    ({"state": "moving"}, "another version of armdrive"),
]


@pytest.mark.parametrize(("last", "why"), ENDS)
async def test_the_end_of_watching_is_said_over_the_last_picture(last, why):
    async with Session(FakeHolder()) as session:
        await session.hear(status_view(FakeArm().status))
        session.holder.said.put(last)
        await session.seen(lambda: session.app.ended)
        assert why in session.text("state")
        assert "NOT WATCHED" in session.text("state")
        assert "no stop reaches the arm" in session.text("stopping")
        assert "shoulder" in session.text("watched")
        assert session.text("footer").strip() == "^q quit"
        assert session.text("messages") == ""
        await session.press("minus")
        assert session.text("messages").startswith("no key but ctrl+q does anything: ")
        assert session.holder.asked == []
        await session.press("space")
        assert session.holder.asked == [("stop", {})]


async def test_an_arm_that_is_really_held_is_watched_and_stopped():
    config = find("sim:teachmover").config
    with connect_remembered(config) as arm:
        assert isinstance(arm, Arm)
        held = SimpleNamespace(
            views=partial(watch_holder, config.name, POLL_S), ask=partial(ask_holder, config.name)
        )
        async with Session(held) as session:
            await session.seen(lambda: session.app.view)
            assert "READY" in session.text("state")
            before = arm.stops
            await session.press("space")
            assert arm.stops == before + 1
            await session.press("minus")
            assert arm.status.speed_override == 0.75
            await session.seen(lambda: session.app.view["speed_override"] == 0.75)
            assert "speed     75%" in session.text("watched")


# What is said of an arm that another program drives.
