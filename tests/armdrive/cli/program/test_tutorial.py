"""The tutorial stays true: its files are written, its commands typed, its answers compared."""

import io
import re
import subprocess
import sys

import pytest
from cli_calls import TRACEBACK
from pages import page

PAGE = page("tutorial")
BLOCKS = re.findall(r"```(arm|python|console|prompt)\n(.*?)```", PAGE, re.DOTALL)
AS_INSTALLED = ("-parmdrive.testing.plugin", "-pno:cacheprovider")
"""What pytest finds by itself where armdrive was installed anew."""


def pieces(text):
    """Split a block into commands with the lines that are shown behind each."""
    found = []
    for row in text.splitlines():
        if row.startswith("$ "):
            found.append((row[2:], []))
        else:
            found[-1][1].append(row)
    return found


def fits(shown, wanted):
    """Tell whether lines are as the page has them; `...` is whatever was left out there."""
    pattern = "\n".join(wanted)
    parts = [re.escape(part) for part in re.split(r"\.\.\.$", pattern, flags=re.MULTILINE)]
    return re.fullmatch(r"(?s:.*?)".join(parts), "\n".join(shown)) is not None


@pytest.fixture
def type_in(call, monkeypatch):
    """Type a command, with lines for its prompt; return what is shown."""

    def typed(command, lines=()):
        program, *words = command.split()
        if program != "armdrive":
            return run_outside(command)
        monkeypatch.setattr(sys, "stdin", io.StringIO("\n".join(lines)))
        called = call(*words)
        return [*called.out.splitlines(), *called.err.splitlines()]

    return typed


def run_outside(command):
    ran = subprocess.run(
        [sys.executable, "-m", *command.split(), *AS_INSTALLED],
        capture_output=True,
        text=True,
        check=False,
    )
    assert TRACEBACK not in ran.stdout + ran.stderr
    return ran.stdout.splitlines()


def at_prompt(type_in, text):
    """Type a session at the prompt, whose answers come between its lines."""
    ((command, rows),) = pieces(text)
    lines = [row.removeprefix("> ") for row in rows if row.startswith("> ")]
    shown = [row for row in rows if not row.startswith("> ")]
    assert type_in(command, lines)[1:] == shown, text


def test_everything_on_the_page_is_as_it_says(type_in, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")  # others are none of the page's
    typed = 0
    for kind, text in BLOCKS:
        if kind in ("arm", "python"):
            name = re.match(r"# ([a-z_]+\.(?:arm|py)): ", text)[1]
            (tmp_path / name).write_text(text, encoding="utf-8")
        elif kind == "prompt":
            at_prompt(type_in, text)
        else:
            for command, wanted in pieces(text):
                shown = type_in(command)
                assert fits(shown, wanted), (command, shown)
                typed += 1
    assert typed > 10


def test_a_line_that_differs_is_seen():
    assert fits(["a", "b", "c 1"], ["a", "...", "c ..."])
    assert fits(["a"], ["..."])
    assert not fits(["a", "b", "c"], ["a", "c"])
    assert not fits(["a", "b"], ["a"])
