"""The program screen: programs are checked, rehearsed, run by two presses, paused and stopped."""

import threading
from dataclasses import replace

import pytest
from amounts import THOROUGH
from desk_planner import at_rest
from desk_session import AGAIN_S, Session
from textual import events
from waiting import until_seen

from armdrive import Arm
from armdrive.errors import Refused
from armdrive.programs.journal import interrupted, journal_file
from armdrive.status import State

WAVE = """\
type "hello"
draw 0, 20, 0
draw 0, -20, 0
type "bye"
"""
WAITS = """\
draw 0, 20, 0
wait_input 2
draw 0, -20, 0
"""
WRONG = """\
type "ok"
mov wrist_pitch
"""
REFUSED = """\
type "off we go"
draw 5000, 0, 0
"""
HOLDS = """\
hold "put a part in"
draw 0, 20, 0
"""


@pytest.fixture
def arm(own_home):
    with Arm.connect("sim:teachmover") as found:
        world = found.twin.world
        found.reference.declare(world.joints, opening_mm=world.opening_mm)
        found.move_j(shoulder_deg=50, elbow_deg=-90)
        yield found


class Gate:
    """Keeps motions of an arm from ending until the test lets them."""

    def __init__(self, arm):
        self.began, self.may_end = threading.Event(), threading.Event()
        self.moves = []
        self._start, arm.start = arm.start, self.start

    def start(self, move, **more):
        self.moves.append(move)
        self.handle = self._start(move, **more)
        return self

    def wait(self):
        self.began.set()
        assert self.may_end.wait(60.0)
        return self.handle.wait()


class ProgramSession(Session):
    """A desk at its program screen, in a folder with these programs."""

    first = "program"

    def __init__(self, arm, folder, *, named=None, size=(120, 40), **programs):
        super().__init__(arm, size=size, program=named)
        self.folder = folder / "programs"
        self.folder.mkdir(exist_ok=True)
        for name, text in programs.items():
            (self.folder / f"{name}.arm").write_text(text)
        self.desk.programs = self.folder

    async def __aexit__(self, *error):
        self.arm.request_stop()
        await super().__aexit__(*error)

    async def keys(self, line):
        await self.press(*line.split())
        await at_rest(self.pilot)

    async def begin(self):
        """Rehearse the program, and press twice."""
        await self.keys("r")
        await self.press("enter")
        await self.press("enter", after_s=AGAIN_S)
        self.clock.now_s += 0.5
        await self.poll()

    async def until(self, happened):
        """Wait until the program has come to something, as its thread does."""

        def seen():
            self.desk.poll()
            return happened()

        await until_seen(seen, self.pilot.pause)
        await self.poll()

    async def at_line(self, line):
        await self.until(lambda: self.screen.run.busy and self.screen.run.line == line)

    async def ended(self):
        await self.until(lambda: not self.screen.run.busy)
        await at_rest(self.pilot)


async def test_the_programs_of_the_folder_are_listed_and_the_chosen_one_is_shown(arm, tmp_path):
    named = tmp_path / "elsewhere.arm"
    named.write_text(WRONG)
    async with ProgramSession(arm, tmp_path, named=named, wave=WAVE, waits=WAITS) as session:
        assert session.text("programs").splitlines() == [
            f"> {named}", "  waits.arm", "  wave.arm"
        ]  # fmt: skip
        assert "line 2, column 1: there is no word 'mov'" in session.text("run")
        session.shows("mistakes", run="    mov wrist_pitch", not_footer="go (twice)")
        session.shows("mistakes", not_footer="rehearse")
        await session.follow([("enter", {"messages": "correct its file first"})])
        assert ">   2  mov wrist_pitch" in session.text("program")
        await session.press("up")
        await at_rest(session.pilot)
        assert "> wave.arm" in session.text("programs")
        assert "    2  draw 0, 20, 0" in session.text("program")
        assert "checked: no mistakes" in session.text("run")
        await session.pilot.click("#programs", offset=(4, 1))
        await at_rest(session.pilot)
        session.shows("a click", programs=f"> {named}")


async def test_a_folder_without_programs_says_how_one_is_named_and_a_refusal_names_the_line(
    arm, tmp_path
):
    async with ProgramSession(arm, tmp_path) as session:
        session.shows("none", run="armdrive jog --program FILE", not_footer="rehearse")
        await session.press("down", "enter", "pagedown", "r")
        session.shows("enter", messages="there is no program to run")
        (session.folder / "refused.arm").write_text(REFUSED)
        await session.keys("f2 f8")
        await session.begin()
        session.shows("refused", run="REFUSED IN LINE 2")
        assert not session.screen.run.busy


async def test_a_file_or_an_arm_that_changes_has_to_be_rehearsed_again(arm, tmp_path):
    async with ProgramSession(arm, tmp_path, wave=WAVE) as session:
        await session.follow([("r", {"run": "rehearsed:"})])
        (session.folder / "wave.arm").write_text(WAVE + 'type "more"\n')
        await at_rest(session.pilot)
        session.shows("another text", program='type "more"', run="checked: no mistakes")
        await session.keys("r")
        await session.press("enter", "enter", "enter", after_s=0.03)
        session.clock.now_s += 1.0
        await session.poll()
        assert not session.screen.run.busy, "a held key runs nothing"
        arm.move_j(base_deg=20)
        await session.poll()
        session.shows("an arm that has moved", not_run="rehearsed:")
        await session.follow([("enter", {"messages": "it is rehearsed first"})])
        await session.press("enter", after_s=1.0)
        await session.press("enter", after_s=AGAIN_S)
        arm.move_j(base_deg=0)  # between the presses and the run
        session.clock.now_s += 0.5
        await at_rest(session.pilot)
        assert not session.screen.run.busy
        session.shows("at the last moment", messages="the program or the arm has changed")


async def test_a_program_is_rehearsed_then_run_by_two_presses_and_says_what_it_prints(
    arm, tmp_path
):
    async with ProgramSession(arm, tmp_path, wave=WAVE) as session:
        before = arm.joints
        await session.press("enter")
        await at_rest(session.pilot)
        assert "it is rehearsed first" in session.text("messages")
        assert "rehearsed:" in session.text("run")
        assert "enter twice runs it: THE ARM MOVES" in session.text("run")
        session.clock.now_s += 5.0
        await session.press("enter")
        await session.poll()
        assert "enter AGAIN RUNS IT" in session.text("run")
        assert arm.joints == before
        await session.press("enter", after_s=AGAIN_S)
        session.clock.now_s += 0.5
        await session.poll()
        await session.ended()
        assert "DONE: 6 acts" in session.text("run")
        assert session.text("printed").splitlines() == ["hello", "bye"]
        assert "the program is done" in session.text("messages")
        assert arm.program is None
        assert not journal_file(arm.config.name).exists()


NOT_READY = [
    (State.DISABLED, "press P to switch the motors on"),
    (State.ERROR_STOP, "the arm is in error-stop"),
    (State.DISCONNECTED, "there is no link to the arm"),
]


async def test_nothing_runs_on_an_arm_that_is_not_ready(arm, tmp_path):
    async with ProgramSession(arm, tmp_path, wave=WAVE) as session:
        await session.keys("r")
        for state, words in NOT_READY:
            session.desk.link.status = replace(arm.status, state=state)
            await session.press("enter")
            session.shows(state, messages=words)
            assert not session.desk.confirmation.effect
        session.desk.link.status = replace(arm.status, state=State.MOVING)
        await session.press("enter")
        assert "wait until it stands" in session.text("messages")
        await session.keys("m r")
        assert not session.screen.rehearsal.job.busy, "the arm will be elsewhere"
        assert "wait until it stands" in session.text("messages")
        session.desk.link.status = arm.status
        await session.press("enter", "enter", after_s=0.03)
        session.clock.now_s += 0.5
        await session.poll()
        assert not session.screen.run.busy, "the key was still held when the arm stood"


async def test_a_wait_is_shown_with_its_line_and_to_other_programs(arm, tmp_path):
    async with ProgramSession(arm, tmp_path, size=(80, 24), waits=WAITS) as session:
        await session.begin()
        await session.at_line(2)
        painted = "\n".join(session.painted)
        assert ">   2  wait_input 2" in painted, "on a small terminal too"
        assert "waiting until input 2 is on" in painted
        assert "waiting until input 2 is on (" in session.text("run")
        assert ">   2  wait_input 2" in session.text("program")
        assert arm.program()["waiting"] == "waiting until input 2 is on"
        assert "waits.arm" in session.text("title")
        await session.press("down", "r", "enter")
        assert "the program is running" in session.text("messages")
        await session.press("space")
        await session.ended()
        assert "ENDED IN LINE 2, after 2 acts: stopped" in session.text("run")
        assert "!   2  wait_input 2" not in session.text("program")
        assert ">   2  wait_input 2" in session.text("program")
        assert "`armdrive run waits.arm --resume`" in session.text("run")
        assert interrupted(arm.config.name).line == 2


async def test_a_pause_and_a_wait_for_the_person_last_until_the_key_is_pressed(arm, tmp_path):
    async with ProgramSession(arm, tmp_path, holds=HOLDS + "wait_input 2\n") as session:
        await session.press("p")
        session.shows("p", messages="nothing moves")
        await session.begin()
        await session.until(lambda: session.screen.run.asks)
        session.shows("a hold", run="WAITS FOR YOU: put a part in")
        await session.press("p", after_s=1.0)
        session.clock.now_s += 0.5
        await session.poll()
        await session.at_line(3)
        await session.press("p")
        await session.until(lambda: arm.status.paused)
        session.shows("p", run="PAUSED", banner="PAUSED  p resumes it")
        await session.press("p", after_s=1.0)
        session.clock.now_s += 0.5
        await session.poll()
        assert not arm.status.paused


async def test_stepping_waits_before_each_motion_and_a_held_key_makes_one_step(arm, tmp_path):
    async with ProgramSession(arm, tmp_path, wave=WAVE) as session:
        gate = Gate(arm)
        gate.may_end.set()
        await session.press("s")
        assert "STEPPING" in session.text("run")
        await session.begin()
        await session.until(lambda: session.screen.run.asks)
        assert "WAITS FOR YOU: next, line 2: draw 0, 20, 0" in session.text("run")
        assert gate.moves == []
        await session.press("right", after_s=1.0)
        session.clock.now_s += 0.5
        await session.until(lambda: len(gate.moves) == 1)
        await session.until(lambda: session.screen.run.asks)
        assert session.screen.run.line == 3
        asks, session.screen.run.asks = session.screen.run.asks, ""
        await session.press("right", after_s=1.0)  # held since before the program waits
        session.screen.run.asks = asks
        await session.press("right", after_s=0.05)
        session.clock.now_s += 0.5
        await session.poll()
        assert len(gate.moves) == 1
        await session.press("right", "right", after_s=0.03)
        session.clock.now_s += 0.5
        await session.poll()
        assert len(gate.moves) == 1
        await session.press("right", after_s=1.0)
        session.clock.now_s += 0.5
        await session.ended()
        assert len(gate.moves) == 2
        await session.press("right", after_s=1.0)
        assert "does not wait for you" in session.text("messages")


LEAVING = {
    "another screen": lambda session: session.press("f7"),
    "a dialog": lambda session: session.press("question_mark"),
    "the focus is lost": lambda session: session.send(events.AppBlur()),
    "pasted text": lambda session: session.send(events.Paste("r")),
    "a suspension": lambda session: session.desk.disarm("this program was suspended for 3.0 s"),
    "a lost link": lambda session: session.desk.link.take(
        replace(session.arm.status, state=State.DISCONNECTED)
    ),
}


def sample(first):
    """Return ways to leave: in everyday tests every third one, from this one on."""
    return [*LEAVING] if THOROUGH else [*LEAVING][first::3]


async def left_and_back(session, how, run, ends):
    """Leave the screen or lose the arm in one of these ways; see `run` end by itself; come back."""
    if (done := LEAVING[how](session)) is not None:
        await done
    ends()
    await session.until(lambda: not run.busy)
    session.desk.close_dialogs()
    await session.keys("f8")


async def test_leaving_lets_a_motion_end_and_begins_no_other_one(arm, tmp_path):
    async with ProgramSession(arm, tmp_path, wave=WAVE) as session:
        start, run, gate = arm.joints, session.screen.run, Gate(arm)
        for how in sample(0):
            gate.began.clear()
            gate.may_end.clear()
            gate.moves.clear()
            await session.begin()
            await session.until(gate.began.is_set)
            stops = arm.stops

            def ends(how=how, stops=stops):
                assert arm.stops == stops, f"{how}: the motion ends as one of the points screen"
                gate.may_end.set()

            await left_and_back(session, how, run, ends)
            assert len(gate.moves) == 1, how
            assert run.failed_in == 3, how
            assert interrupted(arm.config.name).line == 3, how
            arm.move_j(start)
            await session.poll()


@pytest.mark.parametrize("program", [WAITS, HOLDS], ids=["an input", "a person"])
async def test_leaving_ends_a_wait_for_an_input_or_for_a_person(arm, tmp_path, program):
    async with ProgramSession(arm, tmp_path, waits=program) as session:
        start, run = arm.joints, session.screen.run
        for how in sample(1 if program is HOLDS else 2):
            await session.begin()
            if program is HOLDS:
                await session.until(lambda: run.asks)
            else:
                await session.at_line(2)
            await left_and_back(session, how, run, lambda: None)
            assert run.failed, how
            arm.sleep(0.1)  # simulated time passes only while somebody waits
            assert not arm.status.paused, f"{how}: a stop ends a pause, too"
            arm.move_j(start)
            await session.poll()


async def test_a_pulled_cable_ends_a_program_and_leaves_room_to_say_how_it_goes_on(arm, tmp_path):
    async with ProgramSession(arm, tmp_path, size=(80, 24), waits=WAITS) as session:
        await session.begin()
        await session.at_line(2)
        arm.twin.faults.add("unplug")
        await session.ended()
        session.shows("pulled", run="ENDED IN LINE 2, after 2 acts: the link ")
        assert "--resume`" in session.painted_words("run")
        session.shows("pulled", banner="[E407]")


async def test_a_stop_ends_a_motion_at_once(arm, tmp_path):
    async with ProgramSession(arm, tmp_path, wave=WAVE) as session:
        gate = Gate(arm)
        await session.begin()
        await session.until(gate.began.is_set)
        stops = arm.stops
        await session.press("space")
        assert arm.stops > stops
        gate.may_end.set()
        await session.ended()
        assert session.screen.run.failed_in == 2
        assert len(gate.moves) == 1


async def test_a_journal_that_cannot_be_written_lets_nothing_move(arm, tmp_path, monkeypatch):
    def refuse(*words):
        raise Refused("the disk is full")

    monkeypatch.setattr("armdrive.programs.journal.Journal.begins", refuse)
    async with ProgramSession(arm, tmp_path, wave=WAVE) as session:
        gate = Gate(arm)
        await session.begin()
        await session.ended()
        assert "the disk is full" in session.text("run")
        assert gate.moves == []
