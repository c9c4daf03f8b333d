"""A running program: values, errors, and resuming a run."""

import json

import pytest
from amounts import every_row
from program_acts import goal_of, ready, travels
from program_bench import refused, reply, run, started, told

from armdrive.programs import read_program
from armdrive.programs.acts import Say, act_name
from armdrive.programs.problems import ProgramError
from armdrive.programs.program import DEEPEST_CALL

STACK = """# Stack blocks until there is none left.
point stack = at(200, 120, 30, -90)
speed 50%
count = 0
define fetch(place)
  approach place, 60
  open
  move_line place
  grasp into width
  depart_line 60
end
repeat 5 as level
  fetch(pick)
  if width == 0
    type "none left after", count
    break
  end
  approach shifted(stack, 0, 0, (level - 1) * 20), 60
  draw 0, 0, -60
  open_now
  count = count + 1
end
ready
"""


@every_row(
    "value, wanted",
    {
        "1 + 2 * 3": "7", "(1 + 2) * 3": "9", "7 - 2 - 1": "4", "8 / 2 / 2": "2",
        "-2 * -3": "6", "- (2 + 1)": "-3", "2 - -1": "3", "50%": "0.5", "1e3": "1000",
        "1 / 3": "0.333", "-0.0001": "0", "not 1 > 2": "on", "on or off and off": "on",
        "1 + 1 == 2": "on", "2 <> 2": "off", "on is on": "on", "on is not off": "on",
        "1 < 2 and 2 <= 2 and 3 > 2 and 2 >= 2": "on", "2 ge 3 or 2 le 3": "on",
        "not on == off": "on", '"say ""hi"""': 'say "hi"',
    }.items(),
)  # fmt: skip
def test_values_come_out_as_in_mathematics(value, wanted):
    assert told(f"type {value}") == [wanted]


def test_stacking_ends_when_there_is_nothing_left():
    machine = started(STACK)
    found = run(machine, widths=[25.0, 24.0, 0.0])
    assert [act_name(act) for act in found[:6]] == ["Go", "Fingers", "Go", "Grasp", "Look", "Go"]
    assert [act.text for act in found if isinstance(act, Say)] == ["none left after 2"]
    assert found[-1] == ready(0.5)
    goals = [goal_of(act) for act in found if travels(act)]
    assert [goal.z_mm for goal in goals if getattr(goal, "y_mm", 0.0) == 120.0] == [90.0, 110.0]


def test_an_act_knows_its_line_and_an_error_the_calls_that_led_to_it():
    inner = "define inner()\nready\nexpect off\nend"
    text = f"define outer()\ninner()\nend\n{inner}\nif on\nouter()\nend"
    machine = started(text)
    assert machine.next().mark.line == 5
    machine.answer(None)
    with pytest.raises(ProgramError, match="does not hold, called in line 2, called in line 9\n"):
        machine.next()


def test_the_act_stays_the_same_until_it_is_answered():
    machine = started("ready\nhome")
    assert machine.next() is machine.next()
    machine.answer(None)
    assert machine.next().mark.line == 2
    machine.answer(None)
    assert machine.next() is None
    with pytest.raises(ProgramError, match="has ended"):
        machine.answer(None)


# -- what cannot be carried out ----------------------------------------------------------------

FAILING = [
    ("n = 0\nx = 1 / n", "divides by zero"),
    ("x = sqrt(1 - 2)", "a negative number has no square root"),
    ("x = tan(45 + 45)", "a right angle has no tangent"),
    ("x = 1e300 * 1e300", "too large"),
    ("x = floor(1e999)", "this number is too large"),
    ("n = 1.5\nrepeat n\nend", "the number of rounds must be a whole number, not 1.5"),
    ("n = 2\nspeed n", "a fraction of the limits, not 2: write 0.02 or 2%"),
    ("n = -2\ndelay n", "at least 0, not -2"),
    ("n = 1.5\nsignal n", "whole number, not 1.5"),
    ("n = 0\nif input(n)\nend", "at least 1, not 0"),
    ("n = -1\nwait_input 1 within n", "the time in s must be at least 0, not -1"),
    ("n = 1\nsignal n, -n", "1 cannot be both on and off"),
    ("x = pick.yaw", "this arm has no yaw"),
    ("while on\nend", "loops here without giving the arm anything"),
    ("define f(a)\nmove a\nend\nf(3)", "a place is needed, not 3"),
    ("define f()\ntype x\nend\nf()\nx = 1", "'x' has no value yet, called in line 4"),
    ("x = x + 1", "'x' has no value yet"),
    ("x = 1\nif x == on\nend", "1 and on cannot be compared"),
    ("point p = pick\nif p == tray\nend", "is not defined"),
    ("x = 3\ndelay x > 2", "a number is needed"),
    ("x = pick.x\nif x\nend", "on or off is needed, not"),
    ("define f()\nf()\nend\nf()", f"more than {DEEPEST_CALL} deep"),
    ("expect 1 > 2", "what is expected does not hold"),
    ('x = 3\nexpect x > 5, "only", x', "only 3"),
]


@every_row("text, wanted", FAILING)
def test_a_line_that_cannot_run_gives_the_reason_and_place(text, wanted):
    ((_, _, said),) = refused(text)
    assert wanted in said


def test_a_failure_stays_and_can_be_written_down():
    machine = started("ready\nx = 0\nx = 1 / x")
    machine.next()
    machine.answer(None)
    again = machine.program.restored(json.loads(json.dumps(machine.snapshot())))
    for each in (machine, machine, again):
        with pytest.raises(ProgramError, match="divides by zero"):
            each.next()


@every_row(
    "text, answer",
    [("grasp into w", None), ("grasp into w", float("nan")), ("here p", 3.0),
     ("x = input(1)", 1.0), ("wait_input 1 within 2", None)],
)  # fmt: skip
def test_an_answer_of_a_wrong_kind_is_refused_and_the_act_stays(text, answer):
    machine = started(text)
    stage = machine.next()
    with pytest.raises(ProgramError, match="the answer does not fit"):
        machine.answer(answer)
    assert machine.next() == stage


# -- taking it up again ------------------------------------------------------------------------


def snapshot():
    """Return what a run of the stacking program knows after six acts."""
    machine = started(STACK)
    for _ in range(6):
        machine.answer(reply(machine.next().act))
    machine.next()
    return json.loads(json.dumps(machine.snapshot()))


def test_another_program_does_not_take_it_up():
    for text, state in ((STACK + "# more\n", snapshot()), (STACK, {})):
        with pytest.raises(ProgramError, match="another program, or of another version"):
            read_program(text).restored(state)


@every_row(
    "key, value",
    [("state", None), ("state", {"at": 0}), ("points", {"pick": 3}), ("points", []),
     ("answers", [[]]), ("frames", []), ("frames", [{}]),
     ("frames", [{"block": 0, "at": 10**9, "begun": 0, "rounds": None, "own": {}}]),
     ("frames", [{"block": 99, "at": 0, "begun": 0, "rounds": None, "own": {}}]),
     ("frames", [{"block": 0, "at": 0, "begun": 0, "rounds": None, "own": None}]),
     ("variables", 3), ("speed", "x"), ("opening", [])],
)  # fmt: skip
def test_a_damaged_state_is_refused(key, value):
    data = snapshot()
    (data if key in data else data["state"])[key] = value
    with pytest.raises(ProgramError, match="this state of a program cannot be used"):
        read_program(STACK).restored(data)


WAYS = {
    "the next round": ("repeat 3 as n\nif n == 2\ncontinue\nend\ntype n\nend", ["1", "3"]),
    "rounds without an end are counted": (
        "repeat as n\ntype n\nif n == 2\nbreak\nend\nend", ["1", "2"]),
    "calls are deep, and the blocks around them are not": (
        "define f(n)\nif n > 0\nf(n - 1)\nelse\ntype 7\nend\nend\nf(40)", ["7"]),
    "out of the inner loop": (
        "repeat 2 as n\nwhile on\nif on\nbreak\nend\nend\ntype n\nend", ["1", "2"]),
    "one loop after another": ("repeat 2\ntype 1\nend\nrepeat 2\ntype 2\nend", list("1122")),
    "back over a loop": (
        "n = 0\nagain:\nrepeat 2\ntype n\nend\nn = n + 1\nif n < 2 then again", list("0011")),
    "out of loops by a jump": (
        "again:\nrepeat 3 as n\nif n == 2\ntype n\ngoto out\nend\nend\nout:\ntype 9", list("29")),
    "out of a subprogram's loop": (
        "define f()\nrepeat\nrepeat\nreturn\nend\nend\nend\nf()\ntype 3", ["3"]),
    "with parameters that hide the program's names": (
        "x = 1\ndefine f(x)\nx = x + 1\ntype x\nend\nf(7)\ntype x", ["8", "1"]),
    "from one branch behind the last": (
        "if off\ntype 1\nelse if on\ntype 2\nelse\ntype 3\nend\ntype 4", list("24")),
}  # fmt: skip


@every_row("way", WAYS)
def test_which_line_comes_next(way):
    text, wanted = WAYS[way]
    assert told(text) == wanted
