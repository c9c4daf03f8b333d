"""The page on recordings names topics and bounds as the code has them, and its program runs."""

import re

from pages import blocks, page

from armdrive.trace import entries, files
from armdrive.trace.log import BACK, KEPT, MOST, Topic

PAGE = page("recordings")


def test_the_page_lists_every_kind_under_its_topic():
    rows = dict(re.findall(r"^\| `(\w+)` \| ([a-z, ]+) \|$", PAGE, re.MULTILINE))
    for topic in Topic:
        kinds = {kind.value for kind in entries.EntryKind if kind.topic is topic}
        assert set(rows[topic.value].split(", ")) == kinds


def test_the_page_names_the_bounds():
    assert "last five minutes" in PAGE
    assert entries.LONGEST_S == 5 * 60
    assert f"{entries.MOST_BYTES // 1_000_000} MB" in PAGE
    assert f"newest {files.MOST_FILES} are kept" in PAGE
    assert f"last {KEPT} lines" in PAGE
    assert f"last {BACK} entries" in PAGE
    assert f"at most {MOST} lines" in PAGE


def test_the_program_of_the_page_prints_the_motion(capsys):
    (program,) = [text for text in blocks(PAGE, "python") if "arm.log" in text]
    exec(compile(program, "recordings.md", "exec"), {})
    printed = capsys.readouterr().out
    assert "call: move_motors(37, 0, 0, 0, 0, 0)" in printed
    assert "step at speed" in printed
    assert "unknown: no position of this arm" not in printed
