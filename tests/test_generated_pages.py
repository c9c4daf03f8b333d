"""The generated parts of the pages are as the program has them."""

import sys

import pytest
from pages import DOCS, PAGES

sys.path.append(str(DOCS))
import generated

sys.path.remove(str(DOCS))


@pytest.mark.parametrize(
    ("path", "text"), generated.files(), ids=lambda each: getattr(each, "name", "")
)
def test_a_generated_page_is_fresh(path, text):
    assert path.read_text(encoding="utf-8") == text, "run: python docs/generated.py"


def test_every_generated_part_stands_on_one_page():
    text = "".join(path.read_text(encoding="utf-8") for path in PAGES)
    for name in generated.PARTS:
        assert text.count(f"<!-- {name} -->") == 1, name
