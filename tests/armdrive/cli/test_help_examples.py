"""The examples in the help of the commands: all are understood, and most are run."""

from __future__ import annotations

import argparse
import re
import shlex
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from cli_calls import Caller

from armdrive.cli.chosen_arm import connect_remembered
from armdrive.cli.commands import GROUPS, ROWS
from armdrive.cli.runner import command_parser
from armdrive.connect.target import simulated_config

EXAMPLE = re.compile(r"^ {2,}armdrive ((?:\S+ )*\S+)(?: {2,}.*)?$", re.MULTILINE)
"""A line of help that begins with the command; what follows two spaces explains it."""

BEFORE = {
    "move": ["home"],
    "verify": ["home"],
    "points": ["home", "teach add stack gripper 20"],
    "pendant": ["home", "points save pick", "teach add stack to pick"],
}
"""Commands that come before the examples of a command."""

BEFORE_EACH = {"disable": ["home"]}
ASKS = {("pendant", "write"): "--yes"}
"""What a person at a terminal would answer."""

RECORDED = {"log", "replay"}
"""Commands that read what `armdrive record` wrote."""

OF_A_HOLDER = {"pause", "record", "resume", "slow", "stop"}
"""Commands to a program that drives an arm, which the test itself is."""

NOT_RUN = {
    "jog": "needs a terminal",
    "watch": "goes on until the arm is given back",
    "completion": "writes into the user's folders",
}


def examples(name: str) -> list[list[str]]:
    """Return the words of every example in the help of a command."""
    function, _, summary = ROWS[name]
    text = re.sub(r"\\\n *", "", command_parser(name, summary, function).format_help())
    return [shlex.split(re.split(" [<>] ", found)[0]) for found in EXAMPLE.findall(text)]


@pytest.mark.parametrize("name", sorted(ROWS.keys() - {"ports", "demo"}))
def test_every_command_has_examples_and_understands_them(name):
    found = examples(name)
    assert found
    for command, *words in found:
        function, _, summary = ROWS[command]
        command_parser(command, summary, function).parse_args(words)
        says = command == "can" or "--port" not in words or "--dialect" in words
        assert says, f"{words}: without its dialect the arm on a port is refused"


def helps(parser: argparse.ArgumentParser) -> Iterator[str]:
    """Give the help of a parser and of its actions."""
    yield parser.format_help()
    for action in parser._actions:  # argparse has no public way to them
        if isinstance(action, argparse._SubParsersAction):
            for each in action.choices.values():
                yield from helps(each)


@pytest.mark.parametrize("columns", [80, 70])
@pytest.mark.parametrize("name", sorted(ROWS))
def test_help_fits_the_terminal_and_breaks_no_word(name, columns, monkeypatch):
    def shown(width: int) -> list[str]:
        monkeypatch.setenv("COLUMNS", str(width))
        function, _, summary = ROWS[name]
        return list(helps(command_parser(name, summary, function)))

    for narrow, wide in zip(shown(columns), shown(1000), strict=True):
        assert [line for line in narrow.splitlines() if len(line) > columns] == []
        assert narrow.split() == wide.split()


@pytest.fixture
def here(capsys, tmp_path, monkeypatch):
    """Return what calls commands in a folder of their own."""
    monkeypatch.setenv("ARMDRIVE_HOME", str(tmp_path / "home"))
    monkeypatch.chdir(tmp_path)
    return Caller(capsys)


RUN = [name for group in ("Drive", "Look", "Learn") for name in GROUPS[group]]


@pytest.mark.parametrize("name", sorted({*RUN, "pendant"} - NOT_RUN.keys() - OF_A_HOLDER))
def test_the_examples_of_a_command_run_one_after_the_other(here, name):
    for line in BEFORE.get(name, ()):
        here(*line.split(), code=0)
    if name in RECORDED:
        with held_arm():
            here("record", code=0)
            here("record", "--output", "monday.jsonl", code=0)
    for words in examples(name):
        for line in BEFORE_EACH.get(name, ()):
            here(*line.split(), code=0)
        answer = ASKS.get(tuple(words[:2]))
        called = here(*words, *([answer] if answer else []))
        assert (called.code, called.err) == (0, ""), words


@pytest.mark.parametrize("name", sorted(OF_A_HOLDER))
def test_the_examples_of_a_command_to_another_program_reach_it(here, name):
    with held_arm():
        for words in examples(name):
            here(*words, code=0)


@contextmanager
def held_arm():
    """Hold the simulated arm of the command line, as another program would."""
    with connect_remembered(simulated_config("teachmover"), pace=10.0) as arm:
        arm.confirm_reference()
        yield


@pytest.mark.parametrize(
    ("command", "otherwise"),
    [
        *((command, "every arm that your programs are driving") for command in sorted(OF_A_HOLDER)),
        ("watch", "the only arm that your programs are driving"),
    ],
)
def test_the_help_of_a_command_to_a_driving_program_says_which_arm_it_means(
    call, command, otherwise
):
    said = call("help", command, code=0).out
    assert f"Without one of these options, {otherwise}." in said
    assert "--fresh" not in said, "that program has the simulated arm already"
