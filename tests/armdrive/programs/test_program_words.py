"""Every word of the language and the acts that it makes, in the new and the old spelling."""

import pytest
from amounts import every_row
from program_acts import fingers, go, grasp, ready
from program_bench import BOOK, HERE_DEG, acts, at, fk, goals, refused, told

from armdrive.programs.acts import (
    AwaitInputs,
    Delay,
    Hold,
    Home,
    Look,
    Outputs,
    ReadInput,
    Remember,
    Say,
    act_name,
)
from armdrive.programs.language.words import FORMS, FUNCTIONS, WORDS
from armdrive.programs.program import read_program_file
from kinematics.spaces import POSE_FIELDS

PICK = BOOK["pick"]
P = "point p = at(250, 0, 60, -90)\n"
LOOP = "repeat 2\n{}\ntype 1\nend"

GOLDEN = {
    "move": ("move pick", [go(PICK, name="pick")]),
    "move_line": ("move_line pick", [go(PICK, line=True, name="pick")]),
    "move_with": ("move_with pick, 40", [go(PICK, opening_mm=40.0, name="pick")]),
    "move_line_with": (
        "move_line_with pick, 40",
        [go(PICK, line=True, opening_mm=40.0, name="pick")],
    ),
    "approach": (P + "approach p, 60", [go(at(250, 0, 120), name="p")]),
    "approach_line": (P + "approach_line p, 60", [go(at(250, 0, 120), line=True, name="p")]),
    "depart": ("depart 60", [Look(), go(at(200, 0, 160))]),
    "depart_line": ("depart_line 60", [Look(), go(at(200, 0, 160), line=True)]),
    "draw": ("draw 10, 0, -5", [Look(), go(at(210, 0, 95), line=True)]),
    "ready": ("ready", [ready()]),
    "home": ("home", [Home()]),
    "speed": ("speed 50%\nready", [ready(0.5)]),
    "open": ("open 30\nmove pick", [go(PICK, opening_mm=30.0, name="pick")]),
    "close": ("close\nmove pick", [go(PICK, opening_mm=0.0, name="pick")]),
    "open_now": ("open_now", [fingers(None)]),
    "close_now": ("close_now", [fingers(0.0)]),
    "grasp": ("grasp into w\ntype w", [grasp(), Say("30")]),
    "here": ("here q\nmove q", [Look(), go(HERE_DEG, name="q")]),
    "shift": (P + "shift p by 10, 0, -5\nmove p", [go(at(260, 0, 55), name="p")]),
    "remember": ("remember spot", [Look(), Remember("spot", HERE_DEG, 40.0)]),
    "delay": ("delay 1.5", [Delay(1.5)]),
    "signal": ("signal 3, -4", [Outputs((3,), (4,))]),
    "wait_input": ("wait_input 1, -2", [AwaitInputs((1,), (2,))]),
    "hold": ('hold "turn it"', [Hold("turn it")]),
    "type": ('type "width", 2.5, on', [Say("width 2.5 on")]),
    "expect": ("expect 3 > 2\nready", [ready()]),
    "stop": ('stop "enough"\nready', [Say("enough")]),
    "return": ("define f()\nreturn\nready\nend\nf()", []),
    "break": (LOOP.format("break"), []),
    "continue": (LOOP.format("continue"), []),
}


@every_row("word", WORDS)
def test_every_word_asks_for_its_acts_and_its_example_can_be_read(word):
    text, wanted = GOLDEN[word]
    assert acts(text) == wanted
    setting = {"shift": "point corner = pick\n", "type": "width = 3\n", "expect": "width = 30\n"}
    text = setting.get(word, "") + WORDS[word].example
    if word in ("return", "break", "continue"):
        text = f"define f()\nrepeat 1\n{WORDS[word].example}\nend\nend"
    acts(text, inputs=(1,))


@every_row("word, old", [(word.name, old) for word in WORDS.values() for old in word.old])
def test_every_old_spelling_in_capitals_means_the_same(word, old):
    text, wanted = GOLDEN[word]
    lines = [
        old.upper() + line.removeprefix(word) if line.split()[0] == word else line
        for line in text.split("\n")
    ]
    assert lines != text.split("\n")
    assert acts("\n".join(lines)) == wanted


VALUES = {
    "at": ("at(250, 0, 60, -90).z", "60"),
    "taught": ('taught("Place-2").roll', "0"),
    "shifted": ("shifted(at(1, 2, 3, 0), 1, 1, 1).y", "3"),
    "above": ("above(at(1, 2, 3, 0), 30).z", "33"),
    "input": ("input(3)", "on"),
    "abs": ("abs(-3)", "3"),
    "min": ("min(4, 2, 3)", "2"),
    "max": ("max(4, 2, 3)", "4"),
    "mod": ("mod(7, 3)", "1"),
    "sqrt": ("sqrt(9)", "3"),
    "sin": ("sin(30)", "0.5"),
    "cos": ("cos(60)", "0.5"),
    "tan": ("tan(45)", "1"),
    "atan2": ("atan2(1, 1)", "45"),
    "floor": ("floor(-2.5)", "-3"),
    "round": ("round(2.5)", "3"),
}


@every_row("name", FUNCTIONS)
def test_every_function_gives_its_value(name):
    value, wanted = VALUES[name]
    assert told(f"type {value}", inputs=(3,)) == [wanted]


def test_every_part_of_a_place_is_a_number():
    parts = ", ".join(f"p.{name}" for name in POSE_FIELDS)
    assert told(f"point p = at(1, 2, 3, -90, 10, 20)\ntype {parts}") == ["1 2 3 -90 10 20"]


FORMED = {
    "point": ("point q = pick\nmove q", [go(PICK, name="q")]),
    "=": ("n = 2\ntype n", [Say("2")]),
    "if": ("if 1 > 2\nready\nelse if 2 > 1\nhome\nelse\nready\nend", [Home()]),
    "while": ("n = 0\nwhile n < 2\nn = n + 1\ntype n\nend", [Say("1"), Say("2")]),
    "repeat": ("repeat 2 as n\ntype n\nend", [Say("1"), Say("2")]),
    "define": ("define f(a)\ntype a\nend\nf(7)", [Say("7")]),
    "end": ("repeat 1\nend\nready", [ready()]),
    "goto": ("goto there\nready\nthere:\nhome", [Home()]),
    "#": ("# nothing\nready # something", [ready()]),
}


@every_row("form", FORMS, ids=lambda form: form.name)
def test_every_form_of_a_line(form):
    text, wanted = FORMED[form.name]
    assert acts(text) == wanted


def test_a_program_of_the_old_days_runs_as_it_is():
    old = """
        SPEED 50%
        N = 0
    10  APPRO PICK, 30
        MOVES PICK
        GRASP
        DEPARTS 30
        N = N + 1
        IF N LT 2 THEN GOTO 10
        IF N EQ 2 THEN 30
        HOME
    30: READY
    """
    kinds = [act_name(act) for act in acts(old)]
    assert kinds == ["Go", "Go", "Grasp", "Look", "Go"] * 2 + ["Ready"]


# -- the fingers with the next move, and places in joint angles ----------------------------------

PICKED, TRAYED = go(PICK, name="pick"), go(BOOK["tray"], name="tray")
CLOSING = go(PICK, opening_mm=0.0, name="pick")
TURNED = go({**HERE_DEG, "base": 10.0, "wrist_roll": 10.0}, name="SPOT")
SPOT = "joints(base 10, shoulder 40, elbow -60, wrist_pitch -70, wrist_roll 5 + 5)"
ASKED = {
    "open all the way comes before the move": (
        "open\nmove pick\nmove tray", [fingers(None), PICKED, TRAYED]),
    "an opening before ready is an act of its own": ("open 20\nready", [fingers(20.0), ready()]),
    "an opening of the move itself counts": (
        "open 20\nmove_with pick, 40\nmove tray", [go(PICK, opening_mm=40.0, name="pick"), TRAYED]),
    "what is done at once is not done again": (
        "close\nopen_now\nmove pick", [fingers(None), PICKED]),
    "a grasp is not followed by an opening": ("open\ngrasp\nmove pick", [grasp(), PICKED]),
    "homing leaves it to the next move": ("close\nhome\nmove pick", [Home(), CLOSING]),
    "a place in joint angles is gone to as it is": (f"point SPOT = {SPOT}\nmove SPOT", [TURNED]),
}  # fmt: skip


@every_row("what", ASKED)
def test_what_lines_ask_for_together(what):
    text, wanted = ASKED[what]
    assert acts(text) == wanted


def test_an_approach_goes_back_along_the_hand():
    (goal,) = goals("approach at(0, 200, 60, 30), 20")
    assert (goal.x_mm, goal.y_mm, goal.z_mm) == pytest.approx((0.0, 182.679, 50.0), abs=1e-3)


def test_an_approach_beyond_the_axis_of_the_base_is_refused():
    ((_, _, text),) = refused("approach at(50, 0, 60, 0), 60")
    assert "behind the axis" in text
    (goal,) = goals("approach at(50, 0, 60, 0, 0, 90), 60")  # this hand has a direction of its own
    assert (goal.x_mm, goal.y_mm) == pytest.approx((50.0, -60.0))


def test_a_point_of_the_book_can_be_shifted_and_stays_in_the_book():
    (goal,) = goals("shift pick by 0, 0, 10\nmove pick")
    assert goal.z_mm == pytest.approx(fk(PICK).z_mm + 10.0)
    assert goals("move pick") == [PICK]


def test_a_book_is_looked_up_in_any_capitals_where_that_is_clear():
    assert goals("MOVE PICK\nmove Tray") == [PICK, BOOK["tray"]]
    points = {"spot": PICK, "Spot": BOOK["tray"]}
    assert goals("move Spot", points=points) == [BOOK["tray"]]
    assert "did you mean" in refused("move SPOT", points=points)[0][2]


# -- inputs ------------------------------------------------------------------------------------


def test_a_wait_that_times_out_ends_the_program_or_returns_off():
    assert acts("wait_input 1 within 2\nready", inputs=(1,))[-1] == ready()
    ((line, _, text),) = refused("wait_input 1, -2 within 2\nready")
    assert (line, text) == (1, "within 2 s it did not happen that input 1 is on and input 2 is off")
    assert told("wait_input 1 within 2 into came\ntype came") == ["off"]
    assert told("wait_input 1 within 2 into came\ntype came", inputs=(1,)) == ["on"]


def test_an_input_is_read_anew_each_time_and_only_where_it_counts():
    text = "repeat 2\nif input(1) and input(2)\nready\nend\nend"
    assert acts(text, inputs=(2,)) == [ReadInput(1), ReadInput(1)]
    assert acts("if input(1) or input(2)\nend", inputs=(1,)) == [ReadInput(1)]


# -- program files as editors leave them ----------------------------------------------------------


@every_row(
    "data", [b'\xef\xbb\xbftype "a"\nready\n', b'type "a"\r\nready\r\n', b'\ttype\t"a"\n\t ready']
)
def test_a_file_of_any_editor_is_read(tmp_path, data):
    path = tmp_path / "t.arm"
    path.write_bytes(data)
    program = read_program_file(path)
    assert [line.split() for line in program.text.splitlines()] == [["type", '"a"'], ["ready"]]
    assert program.machine().next().mark.line == 1
