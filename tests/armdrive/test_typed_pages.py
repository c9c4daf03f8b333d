"""Every command, session, file and program on the pages works as it is shown."""

import re
import sys

import pytest
from amounts import every_row
from pages import PAGES, ROOT
from typed_pages import FENCE, Typist, fits, parts

from armdrive.cli.commands import COMMANDS

TYPED_ELSEWHERE = {"adding-a-controller": "tests/test_adding_a_controller.py"}
"""Pages whose blocks change the project itself, and their tests."""

SHOWN = [path for path in PAGES if path.stem not in TYPED_ELSEWHERE]


@pytest.mark.parametrize("path", SHOWN, ids=lambda path: path.stem)
def test_everything_on_a_page_is_as_it_says(path, call, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")  # the reader may have other plugins
    monkeypatch.setenv("ARMDRIVE_FORCE_SIM", "1")  # an arm of the page's is its simulated device
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    page = path.read_text(encoding="utf-8")
    with Typist(call, lambda text: monkeypatch.setattr(sys, "stdin", text), tmp_path) as typist:
        for kind, text in (*parts(page), ("end", "")):
            unshown = typist.printed if path.parent.name == "textbook" and kind != "text" else None
            assert not unshown, f"the page lacks what a program prints: {unshown}"
            typist.do(kind, text)


NAMED = re.compile(r"(?:`|^\$ )armdrive ([^`\n]+)", re.MULTILINE)
"""A command that a page names, in a sentence or in a block; what follows `#` is a remark."""


def named_commands():
    """Return every command on the pages, as words, with the page that names it."""
    for path in PAGES:
        for found in NAMED.finditer(path.read_text(encoding="utf-8")):
            yield path.stem, tuple(found[1].partition(" #")[0].split())


def test_every_command_and_option_that_a_page_names_exists(call):
    helps = {}

    def help_of(*words):
        if words not in helps:
            helps[words] = call(*words, "--help").out
        return helps[words]

    for page, words in sorted(set(named_commands())):
        command, *rest = words
        if command.startswith(("-", "COMMAND")) or not command.isalpha():
            continue
        assert command in COMMANDS, (page, words)
        text = help_of(command)
        if rest and re.search(rf"^ +{re.escape(rest[0])}\b", text, re.MULTILINE):
            text += help_of(command, rest[0])
        for option in rest:
            if option == "--":  # what follows are a script's own words
                break
            if option.startswith("--"):
                name = re.match(r"--[a-z0-9-]*", option)[0]
                assert re.search(rf"{name}(?![a-z0-9-])", text), (page, words, name)


COMMAND_LINE = re.compile(r"^(?:\$ )?armdrive (?!pendant program)", re.MULTILINE)


@every_row("path", SHOWN, ids=lambda path: path.stem)
def test_commands_stand_in_blocks_that_are_typed(path):
    """A command in any other block would escape the tests."""
    for kind, text in re.findall(FENCE, path.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE):
        if kind not in ("console", "prompt"):
            assert not COMMAND_LINE.search(text), (kind, text)


def test_a_line_that_differs_is_seen():
    assert fits(["a", "b", "c 1"], ["a", "...", "c ..."])
    assert fits(["a"], ["..."])
    assert not fits(["a", "b", "c"], ["a", "c"])
    assert not fits(["a", "b"], ["a"])
