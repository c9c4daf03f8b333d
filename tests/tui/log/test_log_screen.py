"""The log screen: what has come is shown in words, sieved, held, opened and saved."""

from desk_fake import LoggedArm, busy_arm
from desk_planner import laid_out
from desk_session import Session

from armdrive.trace.entries import EntryKind
from armdrive.trace.log import LogLine, Topic
from tui.log import in_sight, index_of


class LogSession(Session):
    """A desk at its log screen."""

    first = "log"

    def __init__(self, arm=None, **more):
        super().__init__(arm or busy_arm(), **({"size": (120, 46)} | more))

    async def press(self, *keys, **more):
        await super().press(*keys, **more)
        await self.pilot.pause()  # dialogs fill in their text when their size is known
        await self.pilot.pause()
        await laid_out(self.pilot)

    @property
    def shown(self):
        return self.text("log-lines")

    @property
    def rows(self):
        return self.shown.splitlines()

    @property
    def dialog(self):
        return self.desk.screen.query_one("#dialog-text").shown

    @property
    def open(self):
        return len(self.desk.screen_stack) > 1


async def test_bytes_are_shown_with_what_they_mean_and_a_recording_is_saved():
    async with LogSession() as session:
        for words in (
            "-> @STEP 214,37,0,-4,0,0,0",
            "step at speed 214: base +37, elbow -4",
            "<- 1\\r",
            "call: move_j shoulder 40",
            "[E502]",
        ):
            assert words in session.shown
        assert session.rows[-1].startswith("!")
        await session.keys("s")
        session.shows("s", messages=f"written: {session.arm.saved}")
        session.arm.saved = None
        await session.keys("s")
        session.shows("s again", messages="the disk is full")


def poll_at_rest(arm, steps="383 370"):
    arm.pass_by(EntryKind.REQUEST, "ReadPosition()")
    arm.pass_by(EntryKind.SENT, b"@READ\r")
    arm.pass_by(EntryKind.RECEIVED, f"1\r{steps.replace(' ', ',')}\r".encode())
    arm.pass_by(EntryKind.REGISTERS, steps)


async def test_idle_polling_is_folded_into_one_line_that_says_how_much_it_stands_for():
    arm = LoggedArm()
    async with LogSession(arm) as session:
        for _ in range(20):
            poll_at_rest(arm)
        await session.poll()
        assert len(session.rows) == 5
        assert "76 lines of idle polling, the same as above" in session.rows[-1]
        poll_at_rest(arm)
        await session.poll()
        assert "80 lines of idle polling" in session.rows[-1]
        arm.move()
        poll_at_rest(arm, "420 370")
        await session.poll()
        assert len(session.rows) == 5 + 4 + 4, "what moves the arm, and what it led to, is shown"
        assert len(session.screen._all) == 92
        for number in range(6):
            poll_at_rest(arm, f"{number} 370")
        await session.poll()
        differing = session.rows[-24:]
        assert not any("idle polling" in row for row in differing), "answers that differ"


async def test_topics_are_left_out_and_shown_again_each_by_its_key():
    marks = {
        Topic.BYTES: "@STEP 214,38",
        Topic.REQUESTS: "request: move by",
        Topic.CALLS: "call: move_j",
        Topic.STATES: "state: moving",
        Topic.ERRORS: "raised: NoAnswer",
    }
    async with LogSession() as session:
        for number, (topic, mark) in enumerate(marks.items(), 1):
            session.shows(topic, log_head=f"{number} [x] {topic.value}")
            await session.press(str(number))
            session.shows(topic, log_head=f"{number} [ ] {topic.value}", not_log_lines=mark)
        assert session.shown.startswith("no line (left out: bytes, requests")
        await session.press("a")
        assert all(mark in session.shown for mark in marks.values())
        await session.press("p")
        before = session.rows
        session.shows("p", log_head="HELD STILL")
        session.arm.move("99,0,0,0,0,0")
        await session.poll()
        assert session.rows[: len(before)] == before
        await session.press("p")
        await session.poll()
        session.shows("p again: no line was lost", log_lines="base +99")


async def test_a_text_is_typed_and_the_log_follows_it():
    async with LogSession() as session:
        await session.press("slash", *"BASEX", "backspace", "comma", "3", "9")
        assert session.open
        assert session.rows == [each for each in session.rows if "base +39" in each]
        assert len(session.rows) == 1
        assert "BASE,39_" in session.dialog
        await session.press("enter")
        assert not session.open
        assert "find: BASE,39" in session.text("log-head")
        await session.press("slash", "delete", "z", "z")
        assert "only with: zz" in session.shown
        await session.press("enter", "a")
        assert len(session.rows) > 10
        await session.press("slash", "a", "space")
        assert session.arm.asked("stop"), "a space is a stop, and is not typed"
        assert not session.open


async def test_the_arrows_and_pages_choose_a_line_and_what_is_looked_at_stays():
    async with LogSession(size=(80, 24)) as session:
        await session.press("up", "up")
        (chosen,) = [each for each in session.rows if each.startswith(">")]
        assert "HELD STILL" in session.text("log-head")
        at = session.rows.index(chosen)
        session.arm.move("99,0,0,0,0,0")
        await session.poll()
        assert session.rows[at] == chosen
        await session.press("down", "up")
        assert session.rows[at] == chosen
        await session.press("end")
        session.shows("end", log_head="newest last")
        assert "done" in session.rows[-1]
        await session.press("home")
        assert session.rows[0].startswith("> ")
        assert "call: move_j" in session.rows[0]
        await session.press("pagedown")
        assert session.rows[-1].startswith("> ")
        await session.press("pageup")
        assert session.rows[0].startswith("> ")


async def test_a_line_is_opened_whole_and_an_error_with_its_cause_and_remedy():
    async with LogSession(size=(80, 24)) as session:
        await session.press("enter")
        text = session.dialog
        for words in ("NoAnswer: no answer to", "E502: the controller does not answer"):
            assert words in text
        assert "cause" in text
        assert "remedy" in text
        await session.press("enter")
        assert not session.open
        await session.press("end", "enter", "n")
        assert not session.open
        await session.press("slash", *"base,42", "enter", "enter")
        text = session.dialog
        assert "to the arm" in text
        assert "@STEP 214,42,0,-4,0,0,0\\r" in text
        assert "step at speed 214: base +42, elbow -4" in text


async def test_nothing_can_be_opened_where_there_is_nothing():
    async with LogSession(LoggedArm()) as session:
        assert session.shown == "nothing recorded yet"
        await session.press("up", "home", "pagedown", "enter")
        assert not session.open
        assert "no line to open" in session.text("messages")


# -- the words alone --------------------------------------------------------------------------


def line(number, kind=EntryKind.REPLY, words="done", **more):
    return LogLine(number, float(number), kind, **({"shown": "", "words": words} | more))


def test_the_chosen_line_is_in_sight_whatever_comes_and_goes():
    lines = [line(number) for number in range(100)]
    assert index_of(lines, None) == 99
    assert in_sight(lines, 99, 10) == lines[90:]
    assert in_sight(lines, 79, 10) == in_sight([*lines, line(100)], 79, 10) == lines[70:80]
    assert index_of(lines[85:], 79) == 0, "it was dropped"
    assert in_sight([], -1, 10) == in_sight(lines, 3, 0) == []
