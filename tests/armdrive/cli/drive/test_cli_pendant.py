"""`armdrive pendant`: a program out of the arm, into a file, and back."""

import sys

import pytest
from cli_calls import Terminal

from armdrive.dialects.teachmover.pendant import FIRST_LINE
from armdrive.motion import device as program_memory

ROWS = "move 1 240 100 -200 300 -400 500 -600\nraw 2 1 2 3 4 5 6 7\n"
WORDS = [[1, 3841, 14436, 28716, 43252, 65280, 65025, 64769], [2, 1, 2, 3, 4, 5, 6, 7]]


@pytest.fixture
def rows(tmp_path):
    path = tmp_path / "rows.pendant"
    path.write_text(f"{FIRST_LINE}\n{ROWS}", encoding="utf-8")
    return path


def words(call):
    return [row["words"] for row in call("pendant", "show", "--json", code=0).json["rows"]]


def test_a_file_goes_into_the_arm_and_comes_out_the_same(call, rows, tmp_path):
    said = call("pendant", "write", str(rows), "--yes", code=0).out
    assert "2 rows are in the arm: 2 written" in said
    assert words(call) == WORDS
    out = tmp_path / "again.pendant"
    assert "2 rows are in" in call("pendant", "read", str(out), code=0).out
    call("pendant", "write", str(out), "--yes", code=0)
    assert words(call) == WORDS
    assert "raw     2" in call("pendant", "show", code=0).out


@pytest.mark.parametrize(("answer", "code"), [("no\n", 3), ("\n", 3), ("yes\n", 0)])
def test_writing_asks_first(call, rows, monkeypatch, answer, code):
    monkeypatch.setattr(sys, "stdin", Terminal(answer))
    call("pendant", "write", str(rows), code=code)
    assert words(call) == (WORDS if code == 0 else [])


def test_without_a_person_to_ask_the_answer_is_no(call, rows):
    assert "--yes" in call.refused("pendant", "write", str(rows), "--json", code=3)
    assert words(call) == []


def test_a_file_that_cannot_be_used_is_named_with_its_line(call, tmp_path):
    path = tmp_path / "bad.pendant"
    assert "cannot be read" in call.refused("pendant", "write", str(path), code=2)
    path.write_text(f"{FIRST_LINE}\nmove 1\n", encoding="utf-8")
    assert "line 2" in call.refused("pendant", "write", str(path), code=2)


def test_an_arm_without_a_memory_says_so(call):
    assert "keeps no program" in call.refused("pendant", "show", "--sim", "mks", "--json", code=3)


def test_a_program_of_a_homed_arm_becomes_points_that_can_be_gone_to(call, tmp_path):
    call("home", code=0)
    path = tmp_path / "home.pendant"
    path.write_text(f"{FIRST_LINE}\nmove 1 140 0 0 0 0 0 0\n", encoding="utf-8")
    call("pendant", "write", str(path), "--yes", code=0)
    out = tmp_path / "out.pendant"
    call("pendant", "read", str(out), code=0)
    text = out.read_text(encoding="utf-8")
    assert "\norigin " in text
    assert "150 steps/s; base 0.0°" in text
    call("pendant", "points", str(out), "there", code=0)
    assert "there is there-1, there already" in call.refused(
        "pendant", "points", str(out), "there", code=2
    )
    call("pendant", "points", str(out), "there", "--again", code=0)
    assert "to there-1 at 32%" in call("points", "show", "there", code=0).out


def test_rows_without_an_origin_become_no_points(call, rows):
    assert "origin is unknown" in call.refused("pendant", "points", str(rows), "there", code=3)


def test_ctrl_c_in_the_middle_of_writing_names_the_rows(call, rows, monkeypatch):
    write_row = program_memory._write_row

    def interrupted(wire, row):
        if row[0] == 2:
            raise KeyboardInterrupt
        yield from write_row(wire, row)

    monkeypatch.setattr(program_memory, "_write_row", interrupted)
    said = call("pendant", "write", str(rows), "--yes", code=130)
    assert "row 1 new in the arm; the next one perhaps" in said.err


def test_an_unknown_position_is_reported_before_writing(call, rows, monkeypatch):
    text = rows.read_text(encoding="utf-8").replace("move", "origin 1 2 3 4 5 6\nmove")
    rows.write_text(text, encoding="utf-8")
    assert "This arm was not homed" in call("pendant", "write", str(rows), code=3).out
    call("home", code=0)
    assert "count from elsewhere" in call.refused(
        "pendant", "write", str(rows), "--yes", "--json", code=3
    )
    call("pendant", "write", str(rows), "--yes", "--as-is", code=0)
    assert words(call) == WORDS
