"""The page on the flight recorder says what the code does."""

from __future__ import annotations

import re

from pages import page

from armdrive.trace import entries as ring
from armdrive.trace import files
from armdrive.trace.entries import TITLES, EntryKind

PAGE = page("recordings")


def test_the_page_lists_every_kind_of_entry_in_its_words():
    shown = re.findall(r"^\| `(\w+)` \| (.+) \|$", PAGE, re.MULTILINE)
    assert shown == [(kind.value, TITLES[kind]) for kind in EntryKind]


def test_the_page_names_the_bounds():
    assert "last five minutes" in PAGE
    assert ring.LONGEST_S == 5 * 60
    assert f"{ring.MOST_BYTES // 1_000_000} MB" in PAGE
    assert f"newest {files.MOST_FILES} are left" in PAGE
