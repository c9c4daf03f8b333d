"""`armdrive run` in a process of its own: Ctrl-C, Enter, and what other terminals may ask of it."""

import io
import json
import os
import signal
import sys

import pytest
from command_host import HostedCommand
from waiting import LONG_S

from armdrive.cli.program.run_person import INTERRUPTED, stopped_by_interrupt
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
    code, err = program.end()
    assert code == 130
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


def test_a_reader_that_has_gone_ends_the_program_and_not_well(begin):
    program = begin(TOUR, "--pace", FAST)
    program.until("act", 1)
    program.process.stdout.close()
    program.process.stdout = None
    code, err = program.end()
    assert code == 5
    assert "its output was closed" in json.loads(err)["message"]
    assert journal_file(ARM).exists()


# Ctrl-C while a program runs, twice, at the worst moment: while what it says is written.


class Pressed(io.FileIO):
    """An error stream in the middle of whose writing a person presses Ctrl-C."""

    times = 0

    def write(self, text):
        while self.times:
            self.times -= 1
            signal.raise_signal(signal.SIGINT)
        return super().write(text)


class Arm:
    """What is asked of an arm by a signal."""

    stops = 0

    @property
    def parts(self):
        return self

    core = parts

    def request_stop(self):
        self.stops += 1

    def stop_bound(self):
        return self

    silent_time_s = 1.25


class Left(BaseException):
    """The program is left at once."""


@pytest.fixture
def terminal():
    """Give an error stream as Python makes it, what is below it, and what was written to it."""
    ours, theirs = os.pipe()
    raw = Pressed(theirs, "w")
    stream = io.TextIOWrapper(io.BufferedWriter(raw), "utf-8", line_buffering=True)
    yield stream, raw, lambda: os.read(ours, 4096).decode()
    raw.times = 0
    stream.close()
    os.close(ours)


def speak(raw, times):
    """Say something, with one press meanwhile and the others right after it."""
    raw.times = 1
    try:
        sys.stderr.write("act 1\n")
    finally:
        for _ in range(times - 1):
            signal.raise_signal(signal.SIGINT)


@pytest.mark.parametrize("as_json", [False, True])
@pytest.mark.parametrize(("times", "ends"), [(1, KeyboardInterrupt), (2, Left)])
def test_an_interrupt_during_output_is_not_lost(monkeypatch, terminal, times, ends, as_json):
    def leave(code):
        assert code == INTERRUPTED
        raise Left

    monkeypatch.setattr(os, "_exit", leave)
    stream, raw, read = terminal
    monkeypatch.setattr(sys, "stderr", stream)
    arm = Arm()
    with pytest.raises(ends), stopped_by_interrupt(lambda: (arm,), as_json=as_json):
        speak(raw, times)
    assert arm.stops == 1
    sys.stderr.flush()
    said = read()
    assert said.startswith("\nstopping the arm; Ctrl-C again leaves at once\n") is not as_json
    assert ("left: the arm may move for another 1.2 s" in said) == (times == 2)
    if as_json and times == 2:
        assert json.loads(said.partition("\n")[0])["event"] == "left"
