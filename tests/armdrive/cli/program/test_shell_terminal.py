"""`armdrive shell` on a terminal: the prompt, Ctrl-C, other terminals, a wire that is cut."""

import sys

import pytest

if sys.platform == "win32":
    pytest.skip("Windows has no pseudo-terminals", allow_module_level=True)

from served import Served
from shell_bench import CTRL_D, MORE, Prompt

FAST = "20"
LONG_WAY = "move at(250, -150, 120, -90)"


@pytest.fixture
def begin(call):
    """Begin shells; `call` is another terminal."""
    begun = []

    def start(*words, **named):
        begun.append(Prompt(*words, **named))
        begun[-1].until()
        return begun[-1]

    yield start
    for prompt in begun:
        prompt.close()


def moving(prompt):
    """Have the arm go a long way, slowly."""
    prompt.enter("move at(250, 150, 120, -90)")
    prompt.enter("speed 20%")
    prompt.type(f"{LONG_WAY}\r")
    prompt.until(f"line 1: {LONG_WAY}")


def test_lines_run_as_typed_and_can_be_recalled(begin):
    prompt = begin()
    assert "type `home`" in prompt.enter("ready")
    assert "armdrive" not in prompt.enter("home")
    assert "\n6\n" in prompt.enter("type 2 * 3")
    assert "    redy\n    ^\n" in prompt.enter("redy")
    prompt.enter("repeat 2 as n", until=MORE)
    assert "the line was not taken" in prompt.enter("tpye n", until=MORE)
    prompt.enter("type n", until=MORE)
    assert "\n1\n2\n" in prompt.enter("end")
    prompt.enter("repeat 2", until=MORE)
    prompt.type(CTRL_D)
    prompt.until()
    assert "\nrepeat 2 as n\n" in prompt.enter("list")
    prompt.enter("elevation = 7")
    assert "\n7\n" in prompt.enter("type elev\t")
    prompt.type("quit\r")
    assert prompt.end() == 0
    prompt = begin(columns=44)
    refused = prompt.enter("move at(9999, 0, 0, 0)")
    assert "\n  " in refused  # folded between words
    assert all(len(line) <= 44 for line in refused.split("\n"))
    prompt.type("\x1b[A")  # a line up
    assert "9999" in prompt.until("9999")
    prompt.interrupt()  # clears the line
    prompt.until()
    prompt.enter("repeat 2", until=MORE)
    prompt.interrupt()  # clears the block
    prompt.until()
    prompt.interrupt()  # there is nothing to clear
    prompt.until()
    prompt.type(CTRL_D)
    assert prompt.end() == 0


def test_ctrl_c_and_another_terminal_end_what_moves_and_the_prompt_comes_back(begin, call):
    call("home", code=0)
    prompt = begin("--pace", FAST)
    call("stop", code=0)  # nothing moves yet
    moving(prompt)
    prompt.interrupt()
    shown = prompt.until()
    assert "stopping the arm" in shown
    assert "[E301]" in shown
    y_mm = call("status", "--json", code=0).json["pose"]["y_mm"]
    assert -150 < y_mm < 150
    assert "armdrive" not in prompt.enter("draw 0, 0, 10")
    assert LONG_WAY not in prompt.enter("list")
    moving(prompt)
    call("stop", code=0)
    assert "[E301]" in prompt.until()
    assert "armdrive" not in prompt.enter("draw 0, 0, 10")


def test_a_pause_and_a_hold_wait_for_the_person_and_take_no_entry_away(begin, call):
    call("home", code=0)
    prompt = begin()
    call("pause", code=0)
    prompt.type("ready\r")
    prompt.until("paused")
    call("resume", code=0)
    assert "armdrive" not in prompt.until()
    prompt.type("\x1b[200~n = 3\nx = 1 / 0\nready\nn = 4\n\x1b[201~\r")  # a paste, in one go
    assert "divides by zero" in prompt.until()
    assert "\n3\n" in prompt.enter("type n")
    for how in ("enter", "resume", "interrupt"):
        prompt.type('hold "turn the part"\r')
        prompt.until("turn the part: press Enter")
        if how == "resume":
            call("resume", code=0)
        else:
            prompt.type("\r") if how == "enter" else prompt.interrupt()
        assert ("[E301]" in prompt.until()) == (how == "interrupt")
        assert "\n6\n" in prompt.enter("type 2 * 3")


def test_a_real_arm_asks_at_the_prompt_and_one_that_is_gone_leaves_the_program(begin, tmp_path):
    path = tmp_path / "typed.arm"
    sim = Served("teachmover", pty=tmp_path / "arm")
    prompt = begin("--port", sim.port, "--dialect", "teachmover")
    prompt.enter("home", until="Type yes: ")
    prompt.interrupt()
    assert "not confirmed" in prompt.until()
    prompt.enter("home", until="Type yes: ")
    assert "armdrive" not in prompt.enter("yes")
    assert "armdrive" not in prompt.enter("delay 0")
    sim.end()
    said = prompt.enter("draw 0, 0, 20")
    assert "type `reconnect`" in said
    assert "the arm is disconnected: " in said
    assert "armdrive: [E4" in prompt.enter("reconnect")
    assert "are in" in prompt.enter(f"save {path}")
    assert path.read_text(encoding="utf-8") == "home\ndelay 0\n"
    prompt.type(CTRL_D)
    assert prompt.end() == 0
