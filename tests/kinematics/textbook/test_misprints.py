"""The page of the notes' misprints proves what it says."""

import contextlib
import io
import re

from pages import page_path

PAGE = page_path("misprints")
BLOCK = re.compile(r"^```python\n(.*?)^```\n(?:```text\n(.*?)^```\n)?", re.DOTALL | re.MULTILINE)
ENTRY = re.compile(r"^## (.*?)\n(.*?)(?=^## |\Z)", re.DOTALL | re.MULTILINE)


def test_every_block_prints_what_the_page_shows():
    names = {}
    text = PAGE.read_text(encoding="utf-8")
    for block in BLOCK.finditer(text):
        code, shown = block.groups(default="")
        line = text[: block.start()].count("\n") + 1
        # The blank lines make a traceback name the line of the page.
        with contextlib.redirect_stdout(io.StringIO()) as printed:
            exec(compile("\n" * line + code, PAGE.name, "exec"), names)
        assert printed.getvalue() == shown, f"the block at line {line} of {PAGE.name}"


def test_every_entry_has_a_proof_that_prints_something():
    entries = ENTRY.findall(PAGE.read_text(encoding="utf-8"))
    assert len(entries) > 12
    for title, body in entries:
        proofs = [shown for _, shown in BLOCK.findall(body)]
        assert all(proofs), title
        assert proofs or title.startswith("Misread digits"), title
