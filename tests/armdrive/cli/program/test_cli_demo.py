"""The demonstration: it stacks simulated blocks, and prints text, JSON or a drawing."""

import re
import sys
from dataclasses import replace

import pytest
from cli_calls import Terminal

from armdrive.cli import main
from armdrive.cli.program import demo
from armdrive.cli.program.demo import CURSOR_OFF, CURSOR_ON
from armdrive.programs.demonstration import JOBS, NEAR_ENOUGH_MM


def test_it_stacks_every_block_in_plain_text_and_the_next_commands_work_verbatim(call):
    before = call("status", "--json", code=0).json
    said = call("demo", code=0).out  # without a terminal it is plain by itself
    assert call("status", "--json", code=0).json == before  # the arm of the other commands
    assert "\x1b" not in said
    assert said.startswith("sim:teachmover (Microbot TeachMover), SIMULATED")
    for job in JOBS:
        assert f"block {job.name}: grasped" in said
    assert "Every block stands where it belongs, in the simulated world itself." in said
    *_, heading, first, second, third = said.splitlines()
    assert heading.startswith("Next")
    for line in (first, second):
        assert line.endswith(" --sim teachmover")
        call(*line.split()[1:], code=0)
    assert third.split()[1] == "jog"
    assert "needs a terminal" in call(*third.split()[1:], code=2).err


def test_a_block_that_was_not_brought_to_its_place_fails_the_check(call, monkeypatch):
    *others, last = JOBS
    there = (last.to_mm[0], last.to_mm[1] + 40.0, 0.0)

    def elsewhere(arm, jobs, tell):
        return perform(arm, (*others, replace(last, to_mm=there)), tell)

    perform = demo.perform
    monkeypatch.setattr("armdrive.cli.program.demo.perform", elsewhere)
    *steps, summary = call("demo", "--json", code=1).json_lines
    assert len(steps) > len(JOBS)
    assert all(list(step) == ["step"] for step in steps)
    assert summary["wrong"][0].startswith("block C is")
    assert summary["simulated_s"] > 10
    for block, job in zip(summary["blocks"], JOBS, strict=True):
        assert block["measured_mm"] == pytest.approx(job.width_mm, abs=0.5)
        placed = block["place_mm"] == pytest.approx(job.to_mm, abs=NEAR_ENOUGH_MM)
        assert placed == (job is not last)


class Screen(Terminal):
    """A terminal that shows every character."""

    encoding = "utf-8"


@pytest.mark.parametrize(("rows", "columns", "words"), [(2, 8, []), (60, 200, ["--ascii"])])
def test_in_a_terminal_of_any_size_it_is_drawn_and_leaves_the_terminal_as_it_was(
    rows, columns, words, monkeypatch
):
    size = {"TERM": "xterm-256color", "LC_ALL": "C.UTF-8", "LINES": rows, "COLUMNS": columns}
    for name, value in size.items():
        monkeypatch.setenv(name, str(value))
    paces, connect = [], demo.connect_simulated

    def at_once(config, *, twin, pace):  # in real time, a busy computer would miss deadlines
        paces.append(pace)
        return connect(config, twin=twin)

    monkeypatch.setattr(demo, "connect_simulated", at_once)
    monkeypatch.setattr(demo, "JOBS", JOBS[:1])
    monkeypatch.setattr(sys, "stdout", Screen())
    assert main(["demo", "--pace", "3", *words]) == 0
    assert paces == [3.0]
    shown = sys.stdout.getvalue()
    assert shown.count(CURSOR_OFF) == shown.count(CURSOR_ON) == 1
    picture, _, end = shown.partition(CURSOR_ON)
    assert picture.startswith(CURSOR_OFF)
    assert "Every block stands where it belongs" in " ".join(end.split())
    assert shown.isascii() == bool(words)
    if not words:
        assert any("\u2800" < character <= "\u28ff" for character in picture)  # braille
    lines = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", picture).splitlines()
    assert max(map(len, lines)) < columns
