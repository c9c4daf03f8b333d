"""A program is checked as a whole: every mistake is reported at its place before anything moves."""

import pytest
from amounts import every_row
from program_bench import acts, refused, started

from armdrive.errors.table import entry
from armdrive.programs import read_program
from armdrive.programs.language.grammar import DEEPEST_BLOCK, LONGEST_LINE, MOST_LINES
from armdrive.programs.language.words import RESERVED, WORDS
from armdrive.programs.problems import MOST_SHOWN, ProgramError

WRONG = [
    # words that are none, and lines that end too early or too late
    ("mvoe pick", 1, "there is no word 'mvoe'; did you mean 'move'?"),
    ("reday", 1, "there is no word and no subprogram 'reday'; did you mean 'ready'?"),
    ("zigzag pick", 1, "no word 'zigzag'; `zigzag = ...` names a value, and `zigzag(...)` calls"),
    ("zigzag", 1, "there is no word and no subprogram 'zigzag'"),
    ("move pick,", 11, "the line ends too early: a value is missing"),
    ("move (pick", 11, "the line ends too early: a `)` is missing"),
    ("move pick)", 10, "')' does not belong here"),
    ("approach pick 60", 15, "'60' does not belong here, as in `approach pick, 60`"),
    ('type "abc', 6, 'a `"` is missing'),
    ("move ?", 6, "'?' has no meaning in a program"),
    ("höhe = 20", 2, "'ö' has no meaning in a program: names have the letters a to z"),
    ("x = 1 < 2 < 3", 11, "'<' does not belong here"),
    ("point home at(1, 2, 3, 4)", 12, "'at' does not belong here"),
    ("3 = x", 3, "'=' does not belong here"),
    # blocks
    ("end", 1, "this `end` ends nothing"),
    ("else", 1, "this `else` belongs to no `if`"),
    ("while on", 1, "this `while` has no `end`"),
    ("repeat 2\ndefine f()\nend\nend", 1, "cannot be defined within a block"),
    ("if on\nelse\nelse if off\nend", 1, "nothing comes after `else` but `end`"),
    # how many values, of which kind, in which bounds
    ("move", 1, "`move` needs the place: `move pick`"),
    ("move pick, 3", 12, "`move` takes 1 value, this is too many"),
    ("ready 3", 7, "`ready` takes nothing, this is too many"),
    ("approach pick", 1, "`approach` needs the distance in mm: `approach pick, 60`"),
    ("approach 60, 60", 10, "a place is needed here, not a number"),
    ("delay on", 7, "a number is needed here, not on or off"),
    ('delay "long"', 7, "a number is needed here, not a text"),
    ("while 3\nend", 7, "on or off is needed here, not a number"),
    ("if not 3\nend", 8, "on or off is needed here, not a number"),
    ("speed 50", 7, "a speed is a fraction of the limits, not 50: write 0.5 or 50%"),
    ("speed 120%", 7, "at most 100% of the limits, not 120%: write 0.5 or 50%"),
    ("speed 0", 7, "above 0, not 0"),
    ("delay -1", 7, "at least 0, not -1"),
    ("delay 1e300", 7, "at most 1000000, not 1e+300"),
    ("signal 0", 8, "counts from 1, so 0 is not allowed"),
    ("wait_input 1 within -2", 21, "at least 0, not -2"),
    ("repeat 2.5\nend", 8, "whole number, not 2.5"),
    ("if input(0)\nend", 10, "at least 1, not 0"),
    ("shift pick", 1, "`shift` needs `by`"),
    ("grasp by 3", 1, "`by` does not belong to `grasp` here"),
    ("wait_input 1 within 2 within 3", 1, "`within` does not belong to `wait_input` here"),
    ("here at(1, 2, 3, 4)", 6, "`here` needs a name here"),
    # functions, parts, joints
    ("x = sinn(3)", 5, "there is no function 'sinn'; did you mean 'sin'?"),
    ("x = abs()", 5, "`abs` needs the number"),
    ("x = pick.q", 5, "a place has x, y, z, pitch, roll, yaw, no q"),
    ("move joints(base 0, base 1)", 6, "base has two angles"),
    ("move joints(base 0, elbw 1)", 6, "no joint 'elbw'; did you mean 'elbow'?"),
    ("move joints(base 0)", 6, "shoulder, elbow, wrist_pitch, wrist_roll missing"),
    ("move taught(3)", 13, "a text is needed here, not a number"),
    ('if 3 == "a"\nend', 9, "a number, or on or off is needed here, not a text"),
    ("if input(1) == above(pick, 1)\nend", 16, "on or off is needed here, not a place"),
    # names
    ("speed = 3", 1, "`speed` is a word of the language: give the value another name"),
    ("grasp into point", 12, "`point` is a word of the language"),
    ("point home = at(1, 2, 3, 4)", 7, "`home` is a word of the language"),
    ("x = widht", 5, "'widht' is not defined"),
    ("delay pick", 7, "'pick' is not defined"),
    ("move pik", 6, "no saved point has that name; did you mean 'pick'?"),
    ("x = at(1, 2, 3, 4)", 1, "to name a place, write `point x = ...`"),
    ("point x = 3", 11, "a place is needed here, not a number"),
    ('x = "text"', 5, "a text cannot have a name"),
    # subprograms and labels
    ("define f(a)\nend\nf()", 1, "`f` takes a: 1 value, not 0"),
    ('define f(a)\nend\nf("x")', 3, "a subprogram takes no text"),
    ("define f()\nend\ndefine F()\nend", 8, "there is already a subprogram 'F'"),
    ("define f(a, A)\nend", 8, "two parameters are called 'A'"),
    ("define f()\nend\nf = 3", 8, "'f' is also the name of a value"),
    ("goto there", 6, "there is no label 'there' in this block"),
    ("repeat 1\nthere:\nend\ngoto there", 6, "there is no label 'there' in this block"),
    ("there:\nTHERE:", 1, "there is already a label 'THERE'"),
    ("there:\ndefine f()\ngoto there\nend", 6, "no label 'there'"),
    ("if on then ready", 12, "`ready` is no label: the lines of an `if` follow it"),
    ("there:\ngoto ther", 6, "did you mean 'there'?"),
    ("break", 1, "`break` is allowed in a loop only"),
    ("define f()\ncontinue\nend\nrepeat 1\nf()\nend", 1, "`continue` is allowed in a loop only"),
    ("return", 1, "`return` is allowed in a subprogram only"),
]  # fmt: skip


@every_row("text, column, wanted", WRONG)
def test_every_mistake_is_reported_at_its_place(text, column, wanted):
    ((_, at, said),) = refused(text)
    assert wanted in said
    assert at == column


def test_all_mistakes_are_reported_at_once_in_line_order():
    text = "delay -1\nmvoe pick\nif x >\nready\nend\nspeed 50\nmove"
    assert [line for line, _, _ in refused(text)] == [1, 2, 3, 6, 7]


@every_row("line", ["else", "define f()", "elseif on", ")", "ready )", "x ="])
def test_a_line_that_does_not_fit_leaves_the_block_as_it_was(line):
    inner = "end\n" if line.startswith("define") else ""
    text = f"while input(1)\nready\nhome\n{line}\n{inner}ready\nend\nif on\nready\nend"
    assert [number for number, _, _ in refused(text)] == [4]


def test_the_message_shows_the_line_and_a_caret_under_the_place():
    with pytest.raises(ProgramError) as caught:
        read_program("ready\n\tdelay -1", "stack.arm")
    assert str(caught.value) == (
        "stack.arm: line 2, column 8: the time in s must be at least 0, not -1\n"
        "     delay -1\n           ^"
    )
    assert str(caught.value.mark) == "stack.arm: line 2, column 8"
    assert caught.value.exit_code == 2
    assert entry(caught.value).name == "ProgramError"


def test_more_mistakes_than_a_screen_holds_are_counted():
    with pytest.raises(ProgramError, match="and 5 more") as caught:
        read_program("delay -1\n" * (MOST_SHOWN + 5))
    assert len(caught.value.problems) == MOST_SHOWN + 5


def test_names_of_a_program_must_not_be_words_of_the_language():
    for word in RESERVED:
        for text in (f"{word} = 3", f"grasp into {word}", f"define {word}()\nend"):
            with pytest.raises(ProgramError):
                read_program(text)
    assert set(WORDS) <= RESERVED


def test_blocks_and_values_are_nested_only_so_deep():
    deep = DEEPEST_BLOCK
    read_program("if on\n" * deep + "end\n" * deep)
    assert refused("if on\n" * 500 + "end\n" * 500)
    assert "nested too deeply" in refused("x = " + "(" * 2000 + "1" + ")" * 2000)[0][2]
    assert "nested too deeply" in refused("x = " + "-" * 2000 + "1")[0][2]
    assert "nested too deeply" in refused("x = 1" + " + 1" * 2000)[0][2]


def test_a_text_that_no_person_wrote_is_refused_at_once():
    assert "a line has at most" in refused("#" * (LONGEST_LINE + 1))[0][2]
    assert "a program has at most" in refused("\n" * MOST_LINES + "ready")[0][2]


# -- what the arm has to know ------------------------------------------------------------------


def test_every_missing_point_is_named():
    text = "move pik\nmove tray\nmove_line nowhere\nmove pik"
    assert [(line, column) for line, column, _ in refused(text)] == [(1, 6), (3, 11)]
    program = read_program(text)
    assert {name: mark.line for name, mark in program.wanted.items()} == {
        "pik": 1, "tray": 2, "nowhere": 3,
    }  # fmt: skip
    parameter = "define f(spot)\nmove spot\nend\n"
    shifts = read_program(f"{parameter}define g()\nshift spot by 1, 0, 0\nend")
    assert {name: mark.line for name, mark in shifts.wanted.items()} == {"spot": 5}


def test_the_joints_of_another_arm_are_another_arms():
    text = "move joints(a 1, b 2)"
    assert started(text, joint_names=("a", "b")).next() is not None
    assert started(text, joint_names=None).next() is not None
    assert refused(text)


def test_a_label_may_stand_before_an_end_or_an_else():
    for text in (
        "if on\n  goto x\n  stop\nx: else\n  stop\nend",
        "repeat 2\n  goto x\n  stop\nx: end",
    ):
        assert acts(f"{text}\nready") == acts("ready")
