"""Programs that are read one after another, as at a prompt: each knows what came before it."""

from __future__ import annotations

import pytest
from program_acts import fingers, go, ready
from program_bench import BOOK, fk, run

from armdrive.programs import read_program
from armdrive.programs.acts import Say
from armdrive.programs.problems import ProgramError


def entered(*entries):
    """Run entries one after another; return the acts of the last."""
    context, found = None, []
    for number, text in enumerate(entries, start=1):
        machine = read_program(text, f"entry {number}", context).machine(BOOK, fk)
        found, context = run(machine), machine.context
    return found


def test_values_and_subprograms_and_the_speed_stay():
    assert entered("n = 2", "define f(a)\ntype a, n\nend", "n = n + 1", "f(7)") == [Say("7 3")]
    assert entered("speed 25%", "ready") == [ready(0.25)]
    assert entered("point p = joints(base 1)", "move p") == [go({"base": 1.0}, name="p")]


def test_an_opening_waits_for_the_move_of_a_later_entry():
    assert entered("open", "ready") == [fingers(None), ready()]


def test_a_shifted_point_of_the_book_stays_shifted():
    first = entered("shift pick by 0, 0, 10\ntype pick.z")
    assert entered("shift pick by 0, 0, 10", "type pick.z") == first


def test_a_subprogram_can_be_replaced_and_needs_what_it_needed():
    assert entered("define f()\ntype 1\nend", "define f()\ntype 2\nend", "f()") == [Say("2")]
    with pytest.raises(ProgramError, match="'y' is set nowhere"):
        entered("define f()\nx = y + 1\nend")
    with pytest.raises(ProgramError, match="may have no value yet") as caught:
        entered("define f()\ntype x\nend\ndefine g()\nx = 1\nend", "f()")
    assert "entry 1: line 2" in str(caught.value)
    assert "f()" not in str(caught.value)  # the line that is shown would be another entry's


def test_a_name_keeps_its_kind_and_a_value_is_no_subprogram():
    with pytest.raises(ProgramError, match="cannot become a place"):
        entered("n = 2", "point n = pick")
    with pytest.raises(ProgramError, match="is the name of a value too"):
        entered("n = 2", "define n()\nend")


def test_a_run_within_a_context_can_be_taken_up_again_only_there():
    context = read_program("n = 2").machine()
    assert context.next() is None
    program = read_program("ready\ntype n", "b", context.context)
    machine = program.machine(BOOK, fk)
    machine.next()
    again = program.restored(machine.snapshot())
    again.answer(None)
    assert again.next().act == Say("2")
    with pytest.raises(ProgramError, match="changed since"):
        read_program("n = 1\nready\ntype n", "b").restored(machine.snapshot())
