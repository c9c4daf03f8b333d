"""What commands return, printed for people or for programs."""

import os
import sys
from argparse import Namespace

import pytest
from amounts import every_row
from cli_calls import Terminal

from armdrive.cli import presenter
from armdrive.cli.presenter import (
    Ink,
    Inked,
    Result,
    agreed,
    complain,
    emit,
    has_colour,
    present,
    say,
    say_lines,
    tell,
    typed,
    with_arm,
)
from armdrive.cli.program.run_output import Display

if sys.platform != "win32":

    def test_a_line_typed_before_its_question_is_shown_confirms_nothing(monkeypatch):
        keyboard, terminal = os.openpty()
        shown = []

        def show(text):
            shown.append(text)
            os.write(keyboard, b"no\n")

        monkeypatch.setattr(presenter, "put", show)
        os.write(keyboard, b"yes\nyes\n")
        with os.fdopen(terminal, encoding="utf-8") as stdin:
            monkeypatch.setattr(sys, "stdin", stdin)
            assert not agreed("Open it? Type yes: ")
        assert shown == ["Open it? Type yes: "]
        os.close(keyboard)


STATE, NAME = Result({"state": "standby"}, "it stands"), Result({"name": "a"}, ("its name:", "a"))


@pytest.mark.parametrize(
    ("outcome", "as_text", "as_json", "code"),
    [
        (STATE, "it stands\n", '{"state": "standby"}\n', 0),
        ([STATE, NAME], "it stands\nits name:\na\n", '{"state": "standby"}\n{"name": "a"}\n', 0),
        (Result(None, "for people"), "for people\n", "", 0),
        (Result({}, "a\x1b[31m\nb"), "a\\x1b[31m\\nb\n", "{}\n", 0),
        ([Result({}, "", 2), Result({}, "", 1)], "\n\n", "{}\n{}\n", 2),
        (5, "", "", 5),
        ([], "", "", 0),
        (None, "moving\n", "", 0),
    ],
)
def test_a_result_has_two_forms_and_the_options_choose(capsys, outcome, as_text, as_json, code):
    for options, said in (({}, as_text), ({"json": False}, as_text), ({"json": True}, as_json)):
        if outcome is None:
            tell(Namespace(**options), "moving")  # progress is for people
        else:
            assert present(outcome, Namespace(**options)) == code
        assert capsys.readouterr().out == said


@pytest.fixture
def terminal(monkeypatch):
    """Return what puts a terminal with colours in the place of both outputs."""

    def put_in_place() -> Terminal:  # in the test itself, since pytest sets its own before that
        stream = Terminal()
        for name in ("stdout", "stderr"):
            monkeypatch.setattr(sys, name, stream)
        return stream

    monkeypatch.setenv("TERM", "xterm-256color")
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.setenv("WT_SESSION", "on Windows, the terminal that knows colours")
    return put_in_place


def test_a_terminal_shows_words_and_errors_in_colour(terminal):
    stream = terminal()
    say(("state ", Inked("moving", Ink.GOOD)))
    complain("armdrive: [E404] in use")
    say((Inked("\x1b[31mred", Ink.GOOD), "\x1b[2J"))  # text of a device is no colour
    assert stream.getvalue().splitlines() == [
        "state \x1b[32mmoving\x1b[0m",
        "\x1b[1;31marmdrive:\x1b[0m [E404] in use",
        "\x1b[32m\\x1b[31mred\x1b[0m\\x1b[2J",
    ]


@pytest.mark.parametrize(("name", "value"), [("NO_COLOR", "1"), ("TERM", "Dumb")])
def test_colours_are_left_out_where_they_are_not_wanted(terminal, monkeypatch, name, value):
    stream = terminal()
    assert has_colour(sys.stdout)
    monkeypatch.setenv(name, value)
    say((Inked("moving", Ink.GOOD), "!"))
    assert stream.getvalue() == "moving!\n"


# A terminal gets lines folded at spaces. Its own way is to break them in the middle of a word.


LONG = "the arm stands, and what is longer than a line goes on below"
FOLDED = "the arm stands, and\n  what is longer than\n  a line goes on below"


@pytest.fixture
def narrow(terminal, monkeypatch):
    """Put a terminal of 22 columns in place."""
    monkeypatch.setenv("COLUMNS", "22")
    return terminal


@pytest.mark.parametrize(
    ("show", "shown"),
    [
        (lambda: say(LONG), f"{FOLDED}\n"),
        (lambda: say_lines(f"{LONG}\nas two\n"), f"{FOLDED}\nas two\n\n"),
        (lambda: complain(LONG), f"{FOLDED}\n"),
        (lambda: typed(f"{LONG}? "), f"{FOLDED.removesuffix(' below')}\n  below? "),
        (lambda: Display({}, as_json=False).tell(None, LONG), f"{FOLDED}\n"),
        (lambda: emit({"said": LONG}), f'{{"said": "{LONG}"}}\n'),
        (lambda: present(Result({}, LONG, verbatim=True), Namespace()), f"{LONG}\n"),
        (lambda: Display({}, as_json=True).tell({"said": LONG}, ""), f'{{"said": "{LONG}"}}\n'),
    ],
)
def test_a_terminal_gets_sentences_folded_and_documents_as_they_are(
    narrow, monkeypatch, show, shown
):
    stream = narrow()
    monkeypatch.setattr(sys, "stdin", Terminal("yes\n"))
    show()
    assert stream.getvalue() == shown


# A remedy that names a command names the arm as well, if one was named.


HOME, FIX = "run `armdrive home`, or call home()", "`armdrive doctor --fix` sends these lines"


@every_row(
    "given, sentence, added",
    [
        ({"arm": "bench"}, HOME, " --arm bench"),
        ({"arm": "my arm"}, HOME, " --arm 'my arm'"),
        ({"port": "/dev/x", "dialect": "mks"}, HOME, " --port /dev/x --dialect mks"),
        ({}, HOME, ""),
        ({"arm": "bench"}, "`armdrive home --yes`", " --arm bench"),
        ({"arm": "bench"}, "`armdrive doctor --can`", ""),
        ({"arm": "bench"}, "`armdrive home --arm x`", ""),
        ({"arm": "my arm"}, FIX, " --arm 'my arm'"),  # the settings are in its file
        ({"sim": "grbl"}, FIX, ""),
    ],
)
def test_a_command_names_the_arm_that_was_named(given, sentence, added):
    command = "doctor" if sentence is FIX else "home"
    named = sentence.replace(f"armdrive {command}", f"armdrive {command}{added}")
    assert with_arm(sentence, Namespace(**given)) == named
