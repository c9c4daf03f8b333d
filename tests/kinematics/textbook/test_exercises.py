"""The page of worked exercises prints what it says."""

import contextlib
import io
import re

import pytest
from pages import page_path

PAGE = page_path("exercises")
BLOCK = re.compile(r"^```python\n(.*?)^```\n(?:```text\n(.*?)^```\n)?", re.DOTALL | re.MULTILINE)


def test_every_block_prints_what_the_page_shows():
    names = {}
    text = PAGE.read_text(encoding="utf-8")
    blocks = list(BLOCK.finditer(text))
    assert len(blocks) > 10
    for block in blocks:
        code, shown = block.groups(default="")
        line = text[: block.start()].count("\n") + 1
        # The blank lines make a traceback name the line of the page.
        with contextlib.redirect_stdout(io.StringIO()) as printed:
            exec(compile("\n" * line + code, PAGE.name, "exec"), names)
        assert printed.getvalue() == shown, f"the block at line {line} of {PAGE.name}"


@pytest.mark.parametrize("number", [1, 2, 3, 4, 5, 6, 7, 10])
def test_every_exercise_is_worked(number):
    text = PAGE.read_text(encoding="utf-8")
    section = re.search(rf"^## {number}\. .*?(?=^## |\Z)", text, re.DOTALL | re.MULTILINE)
    assert section
    assert BLOCK.search(section[0])
