"""Every exercise is worked and every misprint proved on its page; `test_typed_pages` runs both."""

import re

from amounts import every_row
from pages import blocks, page


@every_row("number", range(1, 12))
def test_every_exercise_is_worked(number):
    section = re.search(
        rf"^## {number}\. .*?(?=^## |\Z)", page("exercises"), re.DOTALL | re.MULTILINE
    )
    assert section
    assert blocks(section[0], "python")


BLOCK = re.compile(r"^```python\n.*?^```\n(?:```text\n(.*?)^```\n)?", re.DOTALL | re.MULTILINE)
ENTRY = re.compile(r"^## (.*?)\n(.*?)(?=^## |\Z)", re.DOTALL | re.MULTILINE)


def test_every_entry_has_a_proof_that_prints_something():
    entries = ENTRY.findall(page("misprints"))
    assert len(entries) > 18
    for place in (
        "after equation 2.21", "equations 2.30 and 2.32", "equation 2.34: two solutions",
        "equation 2.46, line 3", "figure 2.15",
    ):  # fmt: skip
        assert any(place in title for title, _ in entries), place
    for title, body in entries:
        proofs = BLOCK.findall(body)
        assert all(proofs), title
        assert proofs or title.startswith("Misread digits"), title
