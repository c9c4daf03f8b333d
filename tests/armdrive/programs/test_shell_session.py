"""How the prompt reads the lines that are typed, without an arm."""

import pytest
from amounts import every_row
from program_acts import go, ready
from program_bench import fk

from armdrive.programs import read_program
from armdrive.programs.acts import Delay, Say, act_name
from armdrive.programs.problems import ProgramError
from armdrive.programs.session import Session

BOOK = {"tray": {"base": 1.0}}


class Prompt:
    """A session whose entries are carried out on nothing; grasps find 30 mm."""

    def __init__(self, title=""):
        self.session = Session(title)
        self.lines = 0

    def __call__(self, *lines):
        """Type lines; return the acts of the last entry, None while there is none."""
        acts = None
        for line in lines:
            self.lines += 1
            entry = self.session.take(line, self.lines)
            acts = None if entry is None else self.carried_out(entry)
        return acts

    def carried_out(self, entry):
        machine = entry.machine(BOOK, fk)
        acts, done = [], False
        try:
            while (stage := machine.next()) is not None:
                acts.append(stage.act)
                machine.answer(30.0 if act_name(stage.act) == "Grasp" else None)
            done = True
        finally:
            self.session.learn(entry, machine, done=done)
        return acts


@pytest.fixture
def prompt():
    return Prompt()


def said(*texts):
    return [Say(text) for text in texts]


def test_a_line_is_an_entry_and_a_block_when_its_end_has_come(prompt):
    assert prompt("ready") == [ready()]
    assert prompt("repeat 2 as n", "  if n > 1", "  delay n", "  else") is None
    assert prompt.session.unfinished
    assert prompt("  type n", "  end", "end") == [Say("1"), Delay(2.0)]
    assert not prompt.session.unfinished


def test_names_subprograms_and_the_speed_stay(prompt):
    prompt("n = 2", "define twice(x)", "  n = n * 2", "  type x, n", "end", "speed 25%")
    assert prompt("twice(7)") == said("7 4")
    assert prompt("ready") == [ready(0.25)]
    assert prompt("type n") == said("4")
    prompt("speed 100%", "point p = joints(base 1)")
    assert prompt("move p") == [go({"base": 1.0}, name="p")]


def test_a_subprogram_can_be_replaced_and_needs_what_it_needed(prompt):
    for text in ("1", "2"):
        prompt("define f()", f"type {text}", "end")
    assert prompt("f()") == said("2")
    assert [each.name for each in prompt.session.context.defines] == ["f"]
    with pytest.raises(ProgramError, match="'y' is not defined"):
        prompt("define f()", "x = y + 1", "end")


@every_row(
    "line, told",
    [
        ("move pikc", "did you mean 'pick'?\n    move pikc\n         ^"),
        ("mvoe tray", "did you mean 'move'?\n    mvoe tray\n    ^"),
        ("w = 1 / 0", "divides by zero\n    w = 1 / 0\n          ^"),
        ("w = 2 * (3", "a `)` is missing\n    w = 2 * (3\n              ^"),
        ("end", "this `end` ends nothing\n    end\n    ^"),
    ],
)
def test_a_mistake_is_shown_with_the_typed_line(line, told):
    prompt = Prompt()
    prompt("w = 1", "point pick = at(250, 0, 40, -90)")
    with pytest.raises(ProgramError) as caught:
        prompt(line)
    assert told in str(caught.value)
    assert "line 1" not in str(caught.value)
    assert prompt.session.text == "w = 1\npoint pick = at(250, 0, 40, -90)\n"


def test_a_line_of_a_block_that_cannot_be_read_is_not_taken_and_the_block_goes_on(prompt):
    prompt("repeat 2", "type 1")
    for line, sentence in (("tpye 1", "there is no word 'tpye'"), ("else", "belongs to no `if`")):
        with pytest.raises(ProgramError, match=sentence):
            prompt(line)
    assert prompt("type 2", "end") == said("1", "2", "1", "2")
    prompt("while on")
    with pytest.raises(ProgramError, match="this `while` has no `end`"):
        prompt.session.end()
    assert not prompt.session.unfinished


def test_the_lines_of_a_pipe_are_counted():
    prompt = Prompt("standard input")
    prompt("", "define half(x)", "  type 1 / (x - 2)", "end", "# now", "half(4)")
    with pytest.raises(ProgramError) as caught:
        prompt("half(2)")
    text = str(caught.value)
    assert text.startswith("standard input: line 3, column 10: this divides by zero")
    assert "called in line 7" in text


def test_an_aborted_entry_keeps_its_values_but_is_not_listed(prompt):
    with pytest.raises(ProgramError):
        prompt("repeat 2 as n", "  m = n", "  ready", "  m = 1 / (2 - n)", "end")
    assert prompt.session.text == ""
    assert prompt("type n, m") == said("2 2")


def test_the_program_is_what_was_carried_out_and_checks(prompt):
    prompt("# fetch it", "point pick = at(250, 0, 40, -90)", "define go(p)", "move p", "end")
    prompt("go(pick)", "w = 3", "stop", "define go(p)", "  move_line p", "end", "", "go(tray)")
    text = prompt.session.text
    assert text == (
        "# fetch it\npoint pick = at(250, 0, 40, -90)\ngo(pick)\nw = 3\n"
        "define go(p)\n  move_line p\nend\ngo(tray)\n"
    )
    assert read_program(text).machine(BOOK).next() is not None
