"""Laws of programs: writing undoes reading, no text is a crash, and a run can always be resumed."""

import json
from contextlib import suppress

import pytest
from amounts import amount
from hypothesis import example, given, settings
from hypothesis import strategies as st
from program_bench import BOOK, fk, reply

from armdrive.errors import BadRequest
from armdrive.programs import read_program
from armdrive.programs.language.grammar import read_tree
from armdrive.programs.language.syntax import (
    Assign,
    Call,
    Define,
    Do,
    Goto,
    If,
    IfBranch,
    JointsOf,
    Label,
    Literal,
    Name,
    Remark,
    Repeat,
    Tree,
    Use,
    While,
    negative,
)
from armdrive.programs.language.words import FUNCTIONS, LINKS, OPERATORS, PARTS, RESERVED, WORDS
from armdrive.programs.language.writing import unparse
from armdrive.programs.problems import ProgramError

names = st.from_regex(r"[A-Za-z_][A-Za-z0-9_]{0,6}", fullmatch=True).filter(
    lambda name: name.lower() not in RESERVED
)
notes = st.text(
    st.characters(exclude_characters="\r\n", exclude_categories=("Cs",)), max_size=10
).map(str.strip)
numbers = st.floats(allow_nan=False, allow_infinity=False) | st.integers(-999, 999).map(float)
leaves = st.one_of(
    numbers.map(Literal),
    st.integers(0, 10000).map(lambda count: Literal(float(f"{count / 100}") / 100, percent=True)),
    st.booleans().map(Literal),
    notes.map(Literal),
    names.map(Name),
)
SIGNS = sorted(name for name, row in OPERATORS.items() if len(row.slots) == 2)


def wider(inner):
    return st.one_of(
        inner.map(lambda value: Use("not", (value,))),
        inner.map(negative),
        st.builds(Use, st.sampled_from(SIGNS), st.tuples(inner, inner)),
        st.builds(Use, st.sampled_from(sorted(PARTS)), st.tuples(inner)),
        st.builds(Use, st.sampled_from(sorted(FUNCTIONS)), st.lists(inner, max_size=3).map(tuple)),
        st.builds(
            JointsOf,
            st.lists(st.tuples(names.map(str.lower), inner), min_size=1, max_size=3).map(tuple),
        ),
    )


values = st.recursive(leaves, wider, max_leaves=8)
some = st.lists(values, max_size=3).map(tuple)
links = st.lists(
    st.tuples(st.sampled_from(LINKS), st.lists(values, min_size=1, max_size=3).map(tuple)),
    max_size=2,
).map(tuple)
flat = st.one_of(
    st.builds(Remark, st.none() | notes),
    st.builds(Do, st.sampled_from(sorted(WORDS)), some, links, note=notes),
    st.builds(Assign, names, values, st.booleans(), note=notes),
    st.builds(Call, names, some, note=notes),
    st.builds(Label, names, note=notes),
    st.builds(Goto, names, note=notes),
)


def blocks(inner):
    body = st.lists(inner, max_size=3).map(tuple)
    branch = st.builds(IfBranch, values, body, note=notes)
    otherwise = st.builds(IfBranch, st.none(), body)
    return st.one_of(
        st.builds(While, values, body, note=notes),
        st.builds(Repeat, st.none() | values, body, st.just("") | names, note=notes),
        branch.map(lambda first: If((first,))),
        st.builds(lambda first, last: If((first, last)), branch, otherwise),
    )


lines = st.recursive(flat, blocks, max_leaves=8)
defines = st.builds(
    Define,
    names,
    st.lists(names, max_size=2).map(tuple),
    st.lists(lines, max_size=3).map(tuple),
    note=notes,
)
trees = st.lists(lines | defines, max_size=4).map(tuple).map(Tree)


@given(trees)
@settings(max_examples=amount(15, 1000), deadline=None)
def test_a_tree_that_is_written_and_read_is_the_same_tree(tree):
    text = unparse(tree)
    read = parse(text)
    assert read == tree
    assert unparse(read) == text


def parse(text):
    tree, problems = read_tree(text)
    assert problems == []
    return tree


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
    assert parse(unparse(program.tree)) == program.tree
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


def test_every_two_operators_are_written_with_the_brackets_that_they_need():
    x = Name("x")
    pairs = [
        Use(name, (inner, x) if left else (x, inner))
        for name in SIGNS
        for inner in (*(Use(other, (x, x)) for other in SIGNS), Use("not", (x,)), negative(x))
        for left in (True, False)
    ]
    tree = Tree(tuple(Assign("x", pair) for pair in pairs))
    assert parse(unparse(tree)) == tree


TIDY = """# Fetch it.
point pick = at(250, 0, 60, -90)  # over the tray

define fetch(place, far)
  approach_line place, far
  # both fingers
  open_now
  if input(3) is off
    move_line place
  else if far > 10 and not (far > 20 or far < 5)
    grasp into width
  else
    signal 1, -2
  end
end
fetch(pick, 2 * (3 + 4))
wait_input 1 within 5 into came
"""


def test_tidy_text_is_unchanged():
    assert unparse(parse(TIDY)) == TIDY


def test_old_and_untidy_text_becomes_todays():
    old = "  APPROS pick ,60   # near\r\nIF input( 1 )=on THEN GOTO 10\nOPENI\n10 READY\nEND"
    assert unparse(parse(old.removesuffix("\nEND"))) == (
        "approach_line pick, 60  # near\nif input(1) is on\n  goto 10\nend\nopen_now\n10:\nready\n"
    )


def test_comments_stay_with_their_lines_or_stand_behind_them():
    text = "if on # one\nelse # two\nend # three\nrepeat # four\nend\nx: # five\n"
    text += "if on then goto x # six\n"
    assert unparse(parse(text)) == (
        "if on  # one\nelse  # two\nend\n# three\nrepeat  # four\nend\nx:  # five\n"
        "if on  # six\n  goto x\nend\n"
    )


@pytest.mark.parametrize("make", [Remark, Literal])
def test_a_text_with_a_line_break_is_refused(make):
    with pytest.raises(BadRequest, match="one line"):
        make("a\nb")
