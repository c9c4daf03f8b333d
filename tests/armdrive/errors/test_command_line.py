"""One function makes the commands that messages suggest: it quotes what a shell would split."""

from __future__ import annotations

import ast
import os
import re
from pathlib import Path

import pytest

import armdrive
import tui
from armdrive.cli.commands import COMMANDS
from armdrive.errors.printable import command_line

FOLDERS = tuple(Path(each.__file__).parent for each in (armdrive, tui))
PLACE = "\0"
PASTED = re.compile(rf"armdrive (?:{'|'.join(COMMANDS)}) [^`\n]*{PLACE}")
"""A command in a text into which something is pasted."""


def pasted(source: str) -> list[str]:
    """Return the commands into which an f-string of a module pastes a value."""
    found: list[str] = []
    if "armdrive " not in source:  # parsing every source would take a second
        return found
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.JoinedStr):
            parts = [getattr(each, "value", PLACE) for each in node.values]
            text = "".join(each if isinstance(each, str) else PLACE for each in parts)
            found += PASTED.findall(text)
    return found


def test_no_text_pastes_a_name_into_a_command():
    assert pasted('f"run `armdrive run {file} --resume`"')
    assert not pasted('f"an armdrive wrote {file}; `armdrive run` and {file}"')
    paths = [path for folder in FOLDERS for path in folder.rglob("*.py")]
    found = {str(path): texts for path in paths if (texts := pasted(path.read_text("utf-8")))}
    assert found == {}


@pytest.mark.skipif(os.name != "posix", reason="other shells quote in other ways")
def test_names_are_quoted_as_a_shell_needs_it():
    resume = command_line("run", Path("my stack.arm"), "--resume")
    assert resume == "armdrive run 'my stack.arm' --resume"
