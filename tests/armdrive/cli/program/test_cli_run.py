"""`armdrive run` on program files: rehearsed, run, shown, interrupted, resumed."""

import json
import shlex

import pytest
from cli_calls import write_bench

from armdrive.cli.chosen_arm import world_file
from armdrive.programs.journal import journal_file

CARRY = """\
# carry one block
point pick = at(250, 60, 15, -90)
point put = at(250, -60, 16, -90)
define fetch(place)
  open 60
  approach place, 60
  move_line place
  grasp into width
  depart_line 60
end
fetch(pick)
type "it measures", width
approach put, 60
move_line put
open_now 55
depart_line 60
ready
"""
ARM = "sim:teachmover"


def pose(call):
    return call("status", "--json", code=0).json["pose"]


def test_a_check_says_what_every_line_takes_and_moves_nothing(homed, write):
    before = pose(homed)
    checked = homed("run", write(CARRY), "--check", "--plot", code=0).out
    assert "line 7: move_line place" in checked
    assert "for 12 acts" in checked
    assert "distance from the base axis across, 127 to" in checked
    view = homed("run", write(CARRY), "--check", "--json", code=0).json
    assert view["event"] == "rehearsal"
    assert view["refused"] is None
    assert view["took_s"] == pytest.approx(sum(each["took_s"] for each in view["lines"]), abs=0.1)
    assert pose(homed) == before


def test_a_run_shows_a_line_a_motion_and_where_it_ends(homed, write):
    ran = homed("run", write(CARRY), code=0).out
    assert "%  line 6: approach place, 60" in ran
    assert "s left" in ran
    assert "it measures 0" in ran
    assert "done: 12 acts in" in ran
    assert pose(homed)["z_mm"] == pytest.approx(30, abs=0.5)
    assert not journal_file(ARM).exists()
    lines = homed("run", write(CARRY), "--json", code=0).json_lines
    assert [each["event"] for each in lines][:2] == ["begin", "act"]
    assert lines[-1]["event"] == "end"
    acts = [each for each in lines if each["event"] == "act"]
    shares = [each["percent"] for each in acts]
    assert shares == sorted(shares)
    assert acts[0]["left_s"] == pytest.approx(lines[0]["left_s"], abs=0.2)
    assert lines[-1]["took_s"] == pytest.approx(lines[0]["left_s"], rel=0.02)
    assert {"event": "say", "text": "it measures 0"} in lines


def test_a_program_whose_rehearsal_is_refused_does_not_begin(homed, write):
    path = write("move at(250, 0, 120, -90)\nmove at(900, 0, 120, -90)\n")
    before = pose(homed)
    refused = homed("run", path, code=3)
    assert refused.err.startswith(
        f"{path}: line 2, column 1\n    move at(900, 0, 120, -90)\n    ^\n"
    )
    assert "reach" in refused.err
    assert pose(homed) == before
    assert not journal_file(ARM).exists()
    checked = homed("run", path, "--check", "--json", code=3)
    assert checked.json["line"] == 2
    assert "reach" in checked.json["refused"]["message"]
    assert json.loads(checked.err)["message"] == checked.json["refused"]["message"]


@pytest.mark.parametrize(
    ("end", "word"),
    [("open 40", "open"), ("close", "close"), ("done()\ndefine done\nopen\nend", "open")],
)
def test_fingers_that_would_wait_for_no_move_are_refused_before_anything_moves(
    homed, write, end, word
):
    before = homed("status", "--json", code=0).json["pose"]
    path = write(f"move at(250, 0, 120, -90)\n{end}\n")
    for words in (("--check",), (), ("--loops", "2")):
        refused = homed("run", path, *words, code=2).err
        assert f"`{word}` waits for the next move, and none follows: write `{word}_now`" in refused
    assert homed("status", "--json", code=0).json["pose"] == before
    for last in ("ready", 'stop "enough"'):
        homed("run", write(f"open 40\n{last}\n"), code=0)


FAILS = """\
move at(250, 0, 120, -90)
if not input(2)
  move at(900, 0, 120, -90)
end
"""


def test_a_refusal_that_rests_on_an_assumption_needs_yes_and_the_run_resumes(call, write):
    sim = ("--sim", "grbl")
    call("home", *sim, code=0)
    path = write(FAILS)
    run = ("run", path, *sim, "--speed", "50%")
    assert "line 2: input 2 is off; give the real values" in call(*run, code=3).err
    call(*run, "--check", "--input", "2=on", code=0)
    call(*run, "--input", "2=on", code=3)  # the run itself reads the input
    ended = call(*run, "--yes", code=3)
    assert "ended early: 2 acts done" in ended.out
    assert "to continue from there: armdrive run" in ended.err
    assert "line 3" in call(*run, "--resume", "--yes", code=3).err
    call("move", *sim, "--z", "100", code=0)
    moved = call(*run, "--resume", "--yes", code=3).err
    assert "does not stand where the program was interrupted" in moved
    # what a person is told to type names the arm, as the command reads it
    told = moved[moved.index("armdrive move ") :].splitlines()[0].partition("`")[0]
    words = shlex.split(told)
    assert words[:6] == ["armdrive", "move", *sim, "--speed", "0.5"]
    call(*words[1:], code=0)
    assert "out of reach" in call(*run, "--resume", "--yes", code=3).err  # line 3 is tried again
    write("ready\n")
    changed = "was changed since it was interrupted in line 3"
    assert changed in call(*run, "--resume", code=3).err
    call(*run, code=0)
    assert "nothing to resume" in call(*run, "--resume", code=3).err


def test_a_run_reports_an_unfinished_rehearsal(homed, write, monkeypatch):
    monkeypatch.setattr("armdrive.cli.program.run_program.BEFORE_RUN_S", -1.0)
    path = write("repeat 5\n  delay 1\nend\n")
    ran = homed("run", path, code=0).out
    assert "rehearsed for 0.0 s; not rehearsed to its end, which would take too long" in ran
    assert "%" not in ran
    lines = homed("run", path, "--json", code=0).json_lines
    assert lines[0]["rehearsed_whole"] is False
    assert lines[1]["percent"] is None


def test_the_path_is_drawn_into_a_file(homed, write, tmp_path):
    pytest.importorskip("matplotlib")
    output = tmp_path / "path.svg"
    assert "written to" in homed("run", write(CARRY), "--plot", str(output), code=0).out
    assert "<svg" in output.read_text(encoding="utf-8")


def test_a_real_arm_that_is_not_there_is_checked_all_the_same(call, write):
    write_bench()
    checked = call("run", write(CARRY), "--check", "--arm", "bench", "--assume-width", "30", code=0)
    assert "assumed: the arm stands in its reference posture" in checked.out
    assert "cannot be asked where it stands" in checked.out
    assert "line 8: the fingers find something 30 mm wide" in checked.out
    view = call("run", write(CARRY), "--check", "--arm", "bench", "--json", code=0).json
    assert "cannot be asked" in view["not_asked"]
    assert call("run", write(CARRY), "--arm", "bench", code=4).err.startswith("armdrive: ")


def test_a_width_that_is_assumed_of_a_simulated_arm_says_that_it_changes_nothing(homed, write):
    program = ("run", write(CARRY), "--check")
    assert "assumed" not in homed(*program).out
    widened = homed(*program, "--assume-width", "30").out
    assert "line 8: the fingers find what the simulated world has there" in widened


def test_mistakes_in_a_program_are_shown_where_they_are(call, write):
    path = write("move at(250, 0, 120, -90)\nmoove pick\ngrap into width\n")
    shown = call("run", path, code=2).err
    assert f"{path}: line 2, column 1" in shown
    assert "line 3" in shown
    bad = write("", "bad.arm")
    with open(bad, "wb") as file:  # noqa: PTH123
        file.write(b"\xff\xfe")
    assert "is not UTF-8 text" in call.refused("run", bad, code=2)


def test_a_recording_of_the_run_is_kept(homed, write, tmp_path):
    for name, text, code in (("good", "ready\n", 0), ("bad", "ready\nstop_now\n", 2)):
        output = tmp_path / f"{name}.jsonl"
        homed("run", write(text), "--record", str(output), code=code)
        assert output.exists() is (code == 0)
    before = homed("status", "--json").json["read_back_steps"]
    path, impossible = write("move at(250, 0, 120, -90)\n"), tmp_path / "good.jsonl" / "it.jsonl"
    refused = homed("run", path, "--record", str(impossible), code=2)
    assert "could not be written" in refused.err
    assert refused.out == ""
    assert homed("status", "--json").json["read_back_steps"] == before


# -- blocks on the table before a program begins --------------------------------------------------


ACROSS = """
open 40
move at(250, 60, 70, -90)
move_line at(250, 60, 12, -90)
open_now 28
move_line at(250, 60, 70, -90)
move_line at(250, 0, 70, -90)
move_line at(250, 0, 12, -90)
open_now 40
ready
"""


def blocks(name="sim:teachmover"):
    saved = json.loads(world_file(name).read_text(encoding="utf-8"))
    return {each["name"]: each for each in saved["world"]["blocks"]}


def test_the_program_finds_the_blocks_that_were_put_there(call, write):
    call("run", write("home\n"), "--put", "A,250,60,30,20", "--put", "B,250,60", code=0)
    assert blocks()["B"]["z_mm"] == 20.0  # on the one before
    program = write(f"home\n{ACROSS}")
    call("run", program, "--fresh", "--put", "A,250,60,30", "--put", "B,180,-60", code=0)
    found = blocks()
    assert found["A"]["y_mm"] == pytest.approx(0.0, abs=1.0)
    assert found["A"]["height_mm"] == 30.0
    assert (found["B"]["width_mm"], found["B"]["z_mm"]) == (25.0, 0.0)


# -- every wait is shown --------------------------------------------------------------------------

WAITS = "delay 1.5\nwait_input 2, -3 within 2 into came\nready\n"
WAITING = (
    (1, "waiting 1.5 s"),
    (2, "waiting until input 2 is on and input 3 is off, for 2 s at most"),
)


def test_every_wait_is_a_line_and_an_event(homed, write):
    ran = homed("run", write(WAITS), code=0).out
    for line, text in WAITING:
        assert f"line {line}: {WAITS.splitlines()[line - 1]}  {text}" in ran
    lines = homed("run", write(WAITS), "--json", code=0).json_lines
    waits = [each for each in lines if each["event"] == "wait"]
    assert [(each["line"], each["waiting"]) for each in waits] == list(WAITING)
    waiting = [each["waiting"] for each in lines if each["event"] == "act"]
    assert waiting == [*(text for _, text in WAITING), None]
