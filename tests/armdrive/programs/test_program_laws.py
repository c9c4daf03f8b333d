"""Laws of programs: no text is a crash, and a run can always be resumed."""

import json
from contextlib import suppress

from amounts import amount
from hypothesis import example, given, settings
from hypothesis import strategies as st
from program_bench import BOOK, fk, reply

from armdrive.programs import read_program
from armdrive.programs.language.words import FUNCTIONS, LINKS, WORDS
from armdrive.programs.problems import ProgramError

PIECES = st.sampled_from([
    *WORDS, *LINKS, *FUNCTIONS, "if", "else", "end", "while", "repeat", "define", "goto", "point",
    "then", "as", "here", "pick", "x", "f", "=", "==", "(", ")", ",", ".", "-", "+", "%", "3",
    "0.5", '"a"', "#", ":", "\n", "\n", "\t", "and", "not", "is", "on", "joints", "base", "'", '"',
])  # fmt: skip


@given(st.lists(PIECES, max_size=30).map(" ".join) | st.text(max_size=60))
@example('"')
@example("\x00")
@example("\ufeffready")
@example("move p\x85move")
@example("x = ٣")
@example("move é\u2028ready")
@settings(max_examples=amount(120, 4000), deadline=None)
def test_any_text_is_a_program_or_an_error_with_its_places(text):
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    program, problems = read_or_refused(text)
    assert all(1 <= each.mark.line <= len(lines) for each in problems)
    assert (program is None) == bool(problems)
    if program is None:
        return
    carried_out(program)


def read_or_refused(text):
    try:
        return read_program(text, "any.arm"), ()
    except ProgramError as error:
        return None, error.problems


def carried_out(program, most=40):
    """Carry some acts of any program out; it may fail, but only as programs fail."""
    with suppress(ProgramError):
        machine = program.machine(BOOK, fk)
        for _ in range(most):
            stage = machine.next()
            if stage is None:
                return
            machine.answer(reply(stage.act))


BRICKS = st.sampled_from([
    "move pick", "approach pick, n", "open", "close_now", "grasp into n", "depart 10", "f(n)",
    "draw n, 0, 0", "type n, b", "wait_input 1 within 2 into b", "speed 50%", "open n + 1\nready",
    "here spot", "shift tray by 1, 0, 0", "n = n + 1", "b = input(1)", "signal 1, -2", "delay 0",
    "move spot", "hold",
])  # fmt: skip


def nested(inner):
    body = st.lists(inner, min_size=1, max_size=3).map("\n".join)
    return st.one_of(
        body.map("repeat 2 as n\n{}\nend".format),
        body.map("if b\n{}\nelse\nn = 1\nend".format),
        body.map("if input(2) or n > 2\n{}\nend".format),
    )


bodies = st.lists(st.recursive(BRICKS, nested, max_leaves=6), max_size=5).map("\n".join)


@given(bodies, bodies.filter(lambda text: "f(n)" not in text), st.data())
@settings(max_examples=amount(30, 1000), deadline=None)
def test_a_run_restored_at_any_act_has_the_same_rest(body, part, data):
    text = f"n = 1\nb = off\npoint spot = tray\n{body}\ndefine f(n)\n{part}\nend\n"
    program = read_program(text.replace("spot = tray", "spot = at(200, 0, 100, -90)"))
    answers = data.draw(st.lists(st.booleans(), min_size=10, max_size=10))

    def rest(machine, position):
        found = []
        while (stage := machine.next()) is not None and len(found) < 300:
            found.append(stage)
            inputs = (1, 2) if answers[(position + len(found)) % len(answers)] else ()
            machine.answer(reply(stage.act, inputs))
        return found

    whole = rest(program.machine(BOOK, fk), 0)
    at = data.draw(st.integers(0, max(0, len(whole) - 1)))
    machine = program.machine(BOOK, fk)
    for position in range(at):
        stage = machine.next()
        inputs = (1, 2) if answers[(position + 1) % len(answers)] else ()
        machine.answer(reply(stage.act, inputs))
    again = program.restored(json.loads(json.dumps(machine.snapshot())), fk=fk)
    assert rest(again, at)[: len(whole) - at] == whole[at:]
