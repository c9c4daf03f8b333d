"""The page about the prompt: its table is the shell's own, and what it shows is what is shown."""

import io
import re
import sys

from pages import page

from armdrive.cli.program.shell_words import OWN_WORDS
from armdrive.programs.language.words import SHELL
from armdrive.sim.world.table import PARTS

PAGE = page("shell")
SHOWN = re.search(r"```\n(\$ armdrive shell .*?)```", PAGE, re.DOTALL)[1]
PROMPTS = re.compile(r"(?:> |\.\.\. ?)(.*)")


def test_the_table_is_made_from_the_shells_own_words():
    rows = [f"| `{word.pattern}` | {word.says} |" for word in SHELL]
    assert [word.name for word in SHELL] == list(OWN_WORDS)
    assert f"put {PARTS}" in [word.pattern for word in SHELL]
    assert "\n".join(["| word | what it does |", "|---|---|", *rows, ""]) in PAGE


def test_what_is_shown_is_what_a_person_sees(call, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    command, *rows = SHOWN.splitlines()
    typed = [PROMPTS.match(row)[1] for row in rows if PROMPTS.match(row)]
    told = [row for row in rows[2:] if not PROMPTS.match(row)]
    wrong = typed.index("move pikc")
    mistake = told.index(next(row for row in told if row.startswith("armdrive:")))
    assert command.split()[2:] == ["shell", *words(command)]
    monkeypatch.setattr(sys, "stdin", io.StringIO("\n".join(typed[:wrong] + typed[wrong + 1 :])))
    shown = call("shell", *words(command), code=0).out.splitlines()
    assert shown[0] == rows[0]
    assert shown[1:] == told[:mistake] + told[mistake + 3 :]
    monkeypatch.setattr(sys, "stdin", io.StringIO("\n".join(typed[: wrong + 1])))
    err = call("shell", *words(command), code=2).err
    assert (
        re.sub(r"standard input: line \d+, column \d+: ", "", err).splitlines()
        == (told[mistake : mistake + 3])
    )


def words(command):
    return command.split()[3:]
