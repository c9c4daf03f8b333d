"""The page on the log names topics and keys as the tables have them, and its program runs."""

import re
from pathlib import Path

from armdrive.trace.log import BACK, KEPT, MOST, TOPICS, Topic
from tui.keys.keyboard import label
from tui.keys.rows import LOG_KEYS

PAGE = (Path(__file__).parents[3] / "docs" / "log.md").read_text(encoding="utf-8")


def test_the_page_lists_every_kind_under_its_topic():
    rows = dict(re.findall(r"^\| `(\w+)` \| ([a-z, ]+) \|$", PAGE, re.MULTILINE))
    for topic in Topic:
        kinds = {kind.value for kind, its in TOPICS.items() if its is topic}
        assert set(rows[topic.value].split(", ")) == kinds


def test_the_page_lists_every_key_in_its_words():
    shown = re.findall(r"^\| `(\S+)` \| (.+\.) \|$", PAGE, re.MULTILINE)
    assert shown == [(label(row.keys[0]), row.tooltip) for row in LOG_KEYS]


def test_the_page_names_the_bounds():
    assert f"last {KEPT} lines" in PAGE
    assert f"last {BACK} entries" in PAGE
    assert f"at most {MOST} lines" in PAGE


def test_the_program_of_the_page_prints_the_motion(capsys):
    (program,) = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    exec(compile(program, "log.md", "exec"), {})
    printed = capsys.readouterr().out
    assert "call: move_motors(37, 0, 0, 0, 0, 0)" in printed
    assert "step at speed" in printed
    assert "unknown: no position of this arm" not in printed
