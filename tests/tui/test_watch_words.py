"""What is said of an arm that another program drives."""

import pytest

from tui import watch_words

PROGRAM = {
    "file": "stack.arm",
    "line": 12,
    "text": "move above",
    "act": "Move",
    "loop": 2,
    "loops": 3,
    "percent": 41.6,
    "left_s": 75.2,
}
PROGRAM_SHOWN = "program stack.arm, loop 2 of 3\nline 12: move above\n42 %, 75 s left"
PROGRAM_WORDS = [
    (PROGRAM, PROGRAM_SHOWN),
    (PROGRAM | {"loop": 1, "loops": 1}, "program stack.arm\nline 12: move above\n42 %, 75 s left"),
    (PROGRAM | {"loops": 0}, "program stack.arm, loop 2\nline 12: move above\n42 %, 75 s left"),
    (
        PROGRAM | {"loops": 1, "line": None, "text": "", "percent": None, "left_s": None},
        "program stack.arm\nMove",
    ),
    (PROGRAM | {"file": "/home/me/stack.arm"}, PROGRAM_SHOWN),
    (PROGRAM | {"loops": 1, "text": "", "percent": "a"}, "program stack.arm\nline 12: Move"),
    ({}, None),
    (None, None),
    ({"file": "stack.arm"}, "program stack.arm"),
]


@pytest.mark.parametrize(("program", "words"), PROGRAM_WORDS)
def test_the_program_that_is_under_way_is_named_with_its_line_and_share(program, words):
    assert watch_words.program_words({"program": program}) == words


@pytest.mark.parametrize(("now", "steps", "then"), [(10, -1, 10), (100, 1, 100), (33, -1, 25)])
def test_a_tempo_between_the_steps_goes_to_the_next_one(now, steps, then):
    assert watch_words.tempo(now, steps) == then


@pytest.mark.parametrize(
    ("program", "words"),
    [
        (PROGRAM, "stack.arm 42 %"),
        (PROGRAM | {"percent": None, "steps": 20}, "stack.arm 12/20"),
        (PROGRAM | {"percent": None}, "stack.arm"),
        (None, ""),
        ({}, ""),
    ],
)
def test_the_title_names_the_program_and_how_far_it_is(program, words):
    view = {"simulated": False, "title": "TeachMover", "link": "COM3", "program": program}
    title = watch_words.title("left", view, 60)
    assert title.rstrip().endswith(words)
    assert title.startswith("REAL ARM, WATCHED: left (TeachMover) ")
    assert len(title) == 60
    assert len(watch_words.title("left", view, 20)) == 20
