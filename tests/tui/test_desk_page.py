"""The page about the desk has the program's own tables."""

import sys
from pathlib import Path

DOCS = Path(__file__).parents[2] / "docs"


def test_the_page_has_every_screen_key_and_look_as_the_program_has_them(monkeypatch):
    monkeypatch.syspath_prepend(str(DOCS))
    monkeypatch.delitem(sys.modules, "desk_tables", raising=False)
    import desk_tables

    for path, row in ((desk_tables.PAGE, "| `stop` |"), (desk_tables.PAD_PAGE, "| `left-x` |")):
        page = path.read_text(encoding="utf-8")
        assert page.count(row) == 1
        assert desk_tables.filled(page) == page, "run: python docs/desk_tables.py"
