"""`armdrive shell` with the lines of a pipe, on the simulated arm."""

import io
import sys

import pytest

from armdrive.programs.language.words import SPELLINGS
from armdrive.programs.shell import OWN_WORDS

FETCH = """\
home
point pick = at(250, 0, 15, -90)
define fetch(place)
  open 60
  approach place, 60
  move_line place
  grasp into width
  depart_line 60
end
fetch(pick)
"""


@pytest.fixture
def piped(call, monkeypatch):
    """Call the shell with lines."""

    def called(text, *words, code=0):
        monkeypatch.setattr(sys, "stdin", io.StringIO(text))
        return call("shell", *words, code=code)

    return called


@pytest.fixture
def homed(call, piped):
    call("home", code=0)
    return piped


def test_lines_are_carried_out_one_after_another_without_a_prompt(piped, call):
    shown = piped(f"{FETCH}type width\ntype here.z\n", "--put", "A,250,0,30").out.splitlines()
    assert "SIMULATED" in shown[0]
    assert shown[1].startswith("grasped: 30.")
    assert float(shown[2]) == pytest.approx(30, abs=0.5)
    assert float(shown[3]) == pytest.approx(75, abs=0.5)
    assert len(shown) == 4
    assert call("status", "--json", code=0).json["pose"]["z_mm"] == pytest.approx(75, abs=0.5)


def test_executed_lines_are_saved_as_a_program_that_runs(piped, call, tmp_path):
    path = tmp_path / "fetch.arm"
    text = f"{FETCH}list\nsave {path}\n"
    shown = piped(text, "--put", "A,250,0").out
    assert FETCH in shown
    assert path.read_text(encoding="utf-8") == FETCH
    assert "line 7: grasp into width" in call("run", str(path), "--check", code=0).out
    refused = piped(f"ready\nsave {path}\n", code=2)
    assert "standard input: line 2" in refused.err
    assert f"exists already: name another file, or type `save {path} over`" in refused.err
    piped(f"ready\nready\nsave {path} over\n")
    assert path.read_text(encoding="utf-8") == "ready\nready\n"
    names = piped(f"{FETCH.partition('fetch(pick)')[0]}names\n").out
    assert "  pick: x 250.0" in names
    assert "  fetch(place)\n" in names


def test_the_first_error_ends_it_with_its_code_and_place(homed, call):
    before = call("status", "--json", code=0).json["pose"]
    called = homed("delay 0\nmove at(900, 0, 0, -90)\nready\n", code=3)
    assert called.err.startswith("standard input: line 2, column 1\n    move at(900, 0, 0, -90)\n")
    assert "out of reach" in called.err
    assert call("status", "--json", code=0).json["pose"] == before
    assert (
        homed("ready\n\nrepeat 2\n  type 1\n", code=2)
        .err.splitlines()[0]
        .endswith("standard input: line 3, column 1: this `repeat` has no `end`")
    )
    assert "standard input: line 1, column 6" in homed("move pikc\n", code=2).err


def test_for_programs_there_are_json_lines(homed):
    called = homed("w = 3\ntype w\nready\nnames\nquit\nready\n", "--json")
    events = called.json_lines
    assert [each["event"] for each in events] == [
        "begin", "act", "say", "done", "act", "done", "reply", "reply", "end",
    ]  # fmt: skip
    assert events[2]["text"] == "3"
    assert events[6]["text"] == "  w = 3"
    assert events[-1]["entries"] == 3
    failed = homed("ready\nmove at(900, 0, 0, -90)\n", "--json", code=3)
    assert failed.json_lines[-1]["event"] == "failed"
    assert failed.json_lines[-1]["line"] == 2
    assert failed.err.count("\n") == 1


def test_help_knows_every_word_and_suggests(piped):
    words = "".join(f"help {word}\n" for word in (*SPELLINGS, *OWN_WORDS, "repeat", "sqrt"))
    shown = piped(f"help\n{words}").out
    for word in OWN_WORDS.values():
        assert f"{word.pattern}\n  {word.says}" in shown
    assert "old spelling: APPRO" in shown
    assert "did you mean 'grasp'" in piped("help grsap\n", code=2).err


def test_switching_off_needs_a_yes_and_nothing_moves_until_it_is_on_again(homed):
    assert "`disable yes`" in homed("disable\n", code=3).err
    called = homed("disable yes\nenable\nstatus\n", "--sim", "robko01")
    assert "state disabled, motor current off" in called.out
    assert "state standby, motor current held" in called.out


def test_blocks_of_a_simulated_arm_are_put_and_shown(piped):
    shown = piped("blocks\nput A 250 0 30\nput B,250,0\nblocks\n").out.splitlines()
    assert "`put A 250 0`" in shown[1]
    on_top = "  B: its bottom at x 250.0, y 0.0, z 30.0 mm, 25 mm wide and 25 mm high"
    assert shown[3:] == [on_top, shown[2], on_top]
    fetched = piped(f"{FETCH}blocks\n", "--json").json_lines[-3:-1]
    assert "A: in the fingers" in fetched[0]["text"]  # which took the lower one
    assert "NAME X Y" in piped("put A\n", code=2).err
