"""The page about the examples tells of each, and what it says of refusals is so."""

import pytest
from pages import page_path

from armdrive.registry import DIALECTS

from .examples_table import EXAMPLES
from .on_arms import FOLDER
from .page import amounts, table, told, with_table

PAGE = page_path("examples")


@pytest.fixture(scope="module")
def page():
    return PAGE.read_text(encoding="utf-8")


@pytest.mark.parametrize("path", sorted(FOLDER.iterdir()), ids=lambda path: path.name)
def test_the_page_names_every_example(page, path):
    if path.is_file():
        assert f"`{path.name}`" in page


def test_the_table_tells_of_every_dialect_how_it_went_or_why_not(page):
    for file, example in EXAMPLES.items():
        for dialect in DIALECTS:
            said = told(page, file, dialect)
            if why_not := example.against(dialect):
                assert said == why_not
            else:
                assert len(amounts(said)) == (1 if example.beside_mm is None else 2), said


def test_a_new_table_takes_the_place_of_the_old_one(page):
    example = EXAMPLES["circle.py"]
    cells = {(example.file, dialect): "1 s" for dialect in DIALECTS}
    changed = with_table(page, table([example], cells))
    assert told(changed, "circle.py", "mks") == "1 s"
    assert told(changed, "hanoi.arm", "mks") == ""
    assert "what it shows" in changed
