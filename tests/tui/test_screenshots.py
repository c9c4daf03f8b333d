"""The pictures of the documentation: each is what the program shows now, and is shown somewhere."""

import re
import sys
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest
from desk_planner import at_rest
from pages import PAGES

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
sys.path.append(str(DOCS))
import screenshots  # noqa: E402

sys.path.remove(str(DOCS))

SHOWN = {
    "jog": "tap a key for one step",
    "move": "enter twice moves the arm like this",
    "points": "fingers round the block",
    "setup": "Expected:",
    "log": "registers:",
    "program": "WAITS FOR YOU: next, line",
    "watch": "WATCHED",
    "model": "MODEL ONLY",
    "first-run": "Before you move anything",
    "help": "Move the arm, on the jog screen",
    "palette": "A simulated arm goes there by itself",
    "question": "Does the arm stand exactly like this?",
}
"""Words that only this picture's screen has, of each picture."""
MOST_BYTES = 130_000


def words(svg):
    """Return a picture's text, row by row."""
    rows = {}
    for text in ET.fromstring(svg).iter("{http://www.w3.org/2000/svg}text"):
        rows.setdefault(float(text.get("y")), []).append((float(text.get("x")), text.text or ""))
    lines = (" ".join(each for _, each in sorted(row)) for _, row in sorted(rows.items()))
    return re.sub(r"\s+", " ", "\n".join(lines).replace("\xa0", " "))


@pytest.fixture(autouse=True)
def _wait_as_in_other_tests(monkeypatch):
    monkeypatch.setattr(screenshots, "settle", at_rest)


@pytest.mark.parametrize("name", sorted(screenshots.PICTURES))
def test_every_picture_is_taken_as_it_is_kept_and_shows_its_screen(name):
    """They are the snapshots of all screens at 120x40. `python docs/screenshots.py` renews them."""
    kept = (screenshots.FOLDER / f"{name}.svg").read_text(encoding="utf-8")
    assert SHOWN[name] in words(kept)
    assert "url(http" not in kept, "it would be fetched from elsewhere"
    assert len(kept.encode()) < MOST_BYTES
    taken = screenshots.take(name)
    assert words(taken) == words(kept), "look at what differs, then renew it"
    assert taken == kept, "the same words in other colours or places"


def test_the_docs_show_every_picture_and_no_other():
    text = "\n".join(path.read_text(encoding="utf-8") for path in PAGES)
    named = re.findall(r"!\[[^\]]{20,}\]\((?:docs/|\.\./)?pictures/([a-z-]+)\.svg\)", text)
    assert set(named) == set(screenshots.PICTURES)
    assert {each.stem for each in screenshots.FOLDER.iterdir()} == set(screenshots.PICTURES)
