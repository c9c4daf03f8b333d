"""The page on trust shows a true record and the times of the code.

`python tests/armdrive/runtime/test_trust_page.py` prints such a record.
"""

from __future__ import annotations

import sys

from pages import page_path

from armdrive.connect.parts import CLOSING_S
from armdrive.motion import standing
from armdrive.motion.context import LONGEST_S
from armdrive.storage import record
from armdrive.storage.record import FORMAT, Record, from_text, to_text

PAGE = page_path("trust")


def test_the_page_shows_a_record_that_can_be_read():
    text = PAGE.read_text(encoding="utf-8")
    shown = text.partition("```json\n")[2].partition("```")[0]
    assert from_text(shown.encode()).trust == "referenced"


def test_the_page_gives_the_times_and_names_of_the_code():
    text = PAGE.read_text(encoding="utf-8")
    assert standing.STILL_S == 2.0
    assert "two seconds" in text
    assert f"{LONGEST_S:g} s" in text
    assert f"{CLOSING_S:g} s" in text
    assert f"NAME.json{record.BAD}" in text
    assert f'"format": {FORMAT}' in text


if __name__ == "__main__":
    shown = Record(
        "lab3",
        "5b0c9e6a21f4d873",
        (0, 0, 0, 0, 0, 0),
        (1768, -220, 415, 96, -96, 0),
        (1.571, 0.698, -1.396, -0.698, 0.0, 20.0),
        "referenced",
        "referenced in the reference posture",
    )
    sys.stdout.write(to_text(shown).decode())
