"""Every exercise is worked on its page; `test_typed_pages` runs the programs there."""

import re

import pytest
from pages import blocks, page


@pytest.mark.parametrize("number", range(1, 12))
def test_every_exercise_is_worked(number):
    section = re.search(
        rf"^## {number}\. .*?(?=^## |\Z)", page("exercises"), re.DOTALL | re.MULTILINE
    )
    assert section
    assert blocks(section[0], "python")
