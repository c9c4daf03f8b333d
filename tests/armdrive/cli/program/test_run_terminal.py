"""`armdrive run` in a process of its own: Ctrl-C, Enter, and what other terminals may ask of it."""

import json
import signal
import sys

import pytest
from amounts import THOROUGH
from command_host import HostedCommand
from waiting import LONG_S

from armdrive.programs.journal import journal_file

if sys.platform == "win32":
    pytest.skip("Windows interrupts a console, not a process", allow_module_level=True)

ARM = "sim:teachmover"
TOUR = """\
move at(250, 0, 120, -90)
speed 20%
move at(250, 150, 120, -90)
move at(250, -150, 120, -90)
ready
"""
FAST, SLOW = "40", "0.05"


class Program:
    """A running `armdrive run`, by default with `--json`."""

    def __init__(self, *words, form=("--json",)):
        self.process = HostedCommand("run", *words, *form)
        self.events = []

    def until(self, event, line=None):
        for text in self.process.stdout:
            self.events.append(json.loads(text))
            seen = self.events[-1]
            if seen["event"] == event and line in (None, seen.get("line")):
                return seen
        raise AssertionError((event, self.events, self.process.stderr.read()))

    def interrupt(self):
        self.process.send_signal(signal.SIGINT)

    def press_enter(self):
        self.process.stdin.write("\n")
        self.process.stdin.flush()

    def end(self):
        out, err = self.process.communicate(timeout=LONG_S)
        self.events += [json.loads(text) for text in (out or "").splitlines()]
        return self.process.returncode, err


@pytest.fixture
def begin(call, tmp_path):
    """Begin a program on the remembered arm, which has a reference."""
    call("home", code=0)
    begun = []

    def start(text, *words, name="t.arm", **form):
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        begun.append(Program(str(path), *words, **form))
        return begun[-1]

    yield start
    for program in begun:
        program.process.kill()
        program.process.communicate()


@pytest.mark.parametrize("name", ["t.arm", "t.py"])
def test_an_interrupt_stops_the_arm_and_a_program_file_goes_on_from_there(begin, call, name):
    text = TOUR if name == "t.arm" else SCRIPT
    program = begin(text, "--pace", FAST, name=name)
    program.until("act", 3)
    program.interrupt()
    code, err = program.end()
    assert code == 130
    assert json.loads(err)["code"] == "E003", "one document, and no words before it"
    failed = program.events[-1]
    assert (failed["event"], failed["line"]) == ("failed", 3)
    seen = call("status", "--json", code=0).json
    assert seen["trust"] == "restored"
    if name == "t.arm":
        path = failed["resume"].split()[2]
        assert "line 1" not in call("run", path, "--resume", code=0).out
        assert call("status", "--json", code=0).json["pose"]["z_mm"] == pytest.approx(30, abs=0.5)
        assert not journal_file(ARM).exists()


SCRIPT = """\
from armdrive import Arm
arm = Arm.connect()
arm.move_j(shoulder_deg=40, elbow_deg=-60, base_deg=80, speed=0.3)
"""


def test_a_second_interrupt_leaves_at_once(begin):
    program = begin(TOUR, "--pace", SLOW, form=())
    next(line for line in program.process.stdout if "line 1" in line)
    program.interrupt()
    assert any("stopping" in line for line in program.process.stderr)
    program.interrupt()
    _, err = program.process.communicate(timeout=LONG_S)  # the output may end with words
    assert program.process.returncode == 130
    assert "left: the arm may move for another" in err
    assert journal_file(ARM).exists()


def test_another_terminal_can_watch_pause_resume_and_stop_the_run(begin, call):
    program = begin(f'repeat 2\nhold "turn the part"\nend\n{TOUR}', "--pace", FAST)
    for how in ("enter", "resume"):
        assert program.until("hold")["text"] == "turn the part"
        program.press_enter() if how == "enter" else call(how, code=0)
    program.until("act", 6)
    call("pause", code=0)
    paused = program.until("paused")
    view = call("status", "--json", code=0).json
    assert view["paused"] is True
    assert view["program"]["line"] == paused["line"]
    assert 0 < view["program"]["percent"] < 100
    assert f"line {paused['line']}" in call("status", code=0).out
    call("resume", code=0)
    program.until("going-on")
    call("slow", "5%", code=0)
    call("stop", code=0)
    code, err = program.end()
    assert code == 5
    assert json.loads(err)["code"] == "E301"
    assert program.events[-1]["event"] == "failed"
    assert [each["line"] for each in program.events if each["event"] == "done"][:2] == [2, 2]


@pytest.mark.skipif(not THOROUGH, reason="one program that waits for a person is enough every day")
def test_each_motion_waits_for_enter_and_the_end_of_input_is_no_answer(begin, call):
    program = begin(TOUR, "--pace", FAST, "--step")
    for line in (1, 3):
        assert f"line {line}:" in program.until("hold")["text"]
        program.press_enter()
    program.until("hold")
    program.process.stdin.close()
    program.process.stdin = None
    call("stop", code=0)
    code, _ = program.end()
    assert code == 5
    assert [each["line"] for each in program.events if each["event"] == "done"] == [1, 3]


# Ctrl-C while a program runs, twice, at the worst moment: while what it says is written.


def test_a_reader_that_has_gone_ends_the_program_and_not_well(begin):
    program = begin(TOUR, "--pace", FAST)
    program.until("act", 1)
    program.process.stdout.close()
    program.process.stdout = None
    code, err = program.end()
    assert code == 5
    assert "its output was closed" in json.loads(err)["message"]
    assert journal_file(ARM).exists()
