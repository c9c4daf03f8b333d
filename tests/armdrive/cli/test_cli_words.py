"""The command line's own words: help, unknown commands, wrong options, and what it imports."""

import argparse
import json
import re
import shlex
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from amounts import amount, every_row
from cli_calls import Caller

from armdrive.cli import runner
from armdrive.cli.chosen_arm import connect_remembered
from armdrive.cli.commands import COMMANDS, EXIT_CODES, GROUPS, ROWS
from armdrive.cli.runner import command_parser
from armdrive.connect.target import simulated_config
from armdrive.errors import ArmError

LOADED_TO_RUN = {
    "armdrive.arm", "armdrive.connect", "lark", "numpy", "textual",
}  # fmt: skip
"""The commands each of whose actions has a function of its own."""


def error_classes(kind=ArmError):
    yield kind
    for each in kind.__subclasses__():
        yield from error_classes(each)


@pytest.mark.parametrize("words", [(), ("--help",), ("-h",), ("help",)])
def test_the_help_shows_every_command_in_its_group_on_one_screen(call, words):
    lines = call(*words, code=0).out.splitlines()
    assert len(lines) <= 24
    assert max(map(len, lines)) < 80
    table = lines[2 : lines.index("", 2)]
    rows, group = {name: [] for name in GROUPS}, ""
    for line in table:
        group = line[:8].strip() or group
        rows[group] += [line[8:], *([line[8 + 36 :]] if line[8 + 36 :].strip() else [])]
    assert all(line[42:44] == "  " for line in table if len(line) > 44)  # columns stay apart
    for group, commands in GROUPS.items():
        assert [cell.split()[0] for cell in rows[group]] == list(commands)


def test_the_exit_codes_of_all_errors_have_a_page_of_help(call):
    text = call("help", "exit-codes", code=0).out
    assert all(f"  {code} " in text for code in EXIT_CODES)
    assert {each.exit_code for each in error_classes()} <= EXIT_CODES.keys()


@every_row("name", COMMANDS)
def test_every_command_has_help_that_fits_the_terminal_and_breaks_no_word(call, name, monkeypatch):
    text = call(name, "--help", code=0).out
    assert text.startswith(f"usage: armdrive {name}")
    function, _ = ROWS[name]
    assert str(command_parser(name, function).description) in " ".join(text.split())
    assert "--json" in text or name in {"completion", "sim"}
    shown = {}
    for columns in (1000, 80, 70):
        monkeypatch.setenv("COLUMNS", str(columns))
        shown[columns] = "".join(helps(command_parser(name, function)))
        assert [line for line in shown[columns].splitlines() if len(line) > columns] == []
        assert shown[columns].split() == shown[1000].split()


def test_an_unknown_word_is_answered_with_the_nearest_command_or_the_help(call):
    sentence = call.refused("mvoe", code=2)
    assert "'mvoe'" in sentence
    assert "`armdrive move`" in sentence
    assert "`armdrive --help`" in call.refused("qqqqq", code=2)


@pytest.mark.parametrize("words", [("mvoe",), ("move", "--x", "abc"), ("points", "gow")])
def test_a_usage_error_is_json_where_that_is_asked_for(call, words):
    told = json.loads(call(*words, "--json", code=2).err)
    assert (told["code"], "armdrive" in told["message"]) == ("E101", True)


@every_row(
    "words, named",
    [
        (["move", "--x", "abc"], "'abc' is not a number"),
        (["move", "--speed", "0", "--park"], "a speed is above 0, not 0: write 0.5 or 50%"),
        (
            ["move", "--speed", "1.5", "--park"],
            "a fraction of the limits, not 1.5: write 0.015 or 1.5%",
        ),
        (["fk", "0", "0"], "required"),
        (["status", "--sim", "teachmoover"], "'teachmoover'"),
        (["status", "--baud", "0"], "'0' is not a whole number from 1 on"),
        (["sim", "teachmover"], "required"),
        (["demo", "--pace", "0"], "--pace: '0' is not above 0"),
        (["move", "-sped=2"], "there is no option -sped (did you mean --speed?)"),
        (["doctor", "--fresh"], "there is no option --fresh; type"),
        (["move", "now"], "'now' is one argument too many"),
        (["run", "x.arm", "--put", "A,250"], "write it like A,250,0 or A,250,0,30,20, not 'A,250'"),
        (["points", "gow"], "(choose from 'list', "),
        (["run"], "required: PROGRAM; type `armdrive run [OPTIONS] PROGRAM"),
        (["fk", "--shoulder", "40"], "as in `armdrive fk 0 40 -60 -70 0`; see"),
        (
            ["points", "go", "pick", "--sped", "1"],
            "--sped (did you mean --speed?); type `armdrive points go [OPT",
        ),
        (["points"], "required: ACTION; type"),
        (["points", "go"], "as in `armdrive points go pick --line --speed 30%`; see"),
    ],
)
def test_a_wrong_option_is_named_with_where_to_find_help(call, words, named):
    sentence = call.refused(*words, code=2)
    assert named in sentence
    if words[0] not in ("fk", "sim") or "required" not in named:  # those two count for themselves
        assert re.search(f"; see `armdrive {words[0]}( go)? --help`$", sentence)
    assert call(*words).out == ""


LEFT_OUT = (
    ("stop", ("armdrive.config", "armdrive.dialects.recognition", "armdrive.sim", "numpy")),
    ("points list", ("armdrive.arm", "armdrive.programs", "armdrive.sim")),
    ("log", ("armdrive.arm", "armdrive.programs", "armdrive.sim")),
    (
        "status --port /dev/none --dialect grbl",
        ("armdrive.sim", "armdrive.programs", "can", "lark"),
    ),
)
"""Commands of one process, each with what is not loaded yet when it has ended."""


def loaded_after(*lines):
    """Call commands in one new process; return the modules that are loaded after each."""
    program = (
        "import contextlib, sys\nfrom armdrive.cli import main\n"
        "for words in sys.argv[1:]:\n"
        "    with contextlib.suppress(SystemExit):\n"
        "        main(words.split())\n"
        "    print('loaded', *sys.modules, file=sys.stderr)"
    )
    ended = subprocess.run(
        [sys.executable, "-c", program, *lines],
        capture_output=True, text=True, check=True, stdin=subprocess.DEVNULL,
    )  # fmt: skip
    told = [line.split() for line in ended.stderr.splitlines() if line.startswith("loaded ")]
    assert all("armdrive.cli.runner" in loaded for loaded in told)
    return told


def test_a_command_loads_nothing_that_only_others_need(tmp_path, monkeypatch):
    monkeypatch.setenv("ARMDRIVE_HOME", str(tmp_path))
    told = loaded_after(*(words for words, _ in LEFT_OUT))
    for (words, spared), loaded in zip(LEFT_OUT, told, strict=True):
        others = tuple(f"{each}." for each in spared)
        assert [name for name in loaded if f"{name}.".startswith(others)] == [], words
    loaded = set(loaded_after(*(f"{name} --help" for name in COMMANDS))[-1])
    assert "armdrive.cli.drive.arguments" in loaded
    assert not loaded & LOADED_TO_RUN
    # a table, as an option offers its names, and how the name of a program's file ends
    light = {"armdrive.setup.templates", "armdrive.programs.language"}
    heavy = ("armdrive.setup.", "armdrive.programs.")
    assert {name for name in loaded if name.startswith(heavy)} <= light


@pytest.mark.skipif(sys.platform == "win32", reason="no shell that closes streams")
@pytest.mark.skipif(sys.platform != "linux", reason="needs /dev/full")
@pytest.mark.parametrize("words", ["--help", "errors E101"])
def test_an_output_that_takes_nothing_is_named_and_one_that_has_gone_ends_quietly(words):
    command = f"'{sys.executable}' -m armdrive {words}"

    def shell(line):
        return subprocess.run(line, shell=True, capture_output=True, text=True, check=False)

    full = shell(f"{command} >/dev/full")
    assert full.returncode == 1
    assert full.stderr.startswith("armdrive: [E002] the output cannot be used (No space left")
    assert full.stderr.count("\n") == 1
    for ended in (shell(f"{command} >&-"), shell(f"{command} | true")):
        assert (ended.returncode, ended.stderr) == (0, "")


def test_only_the_first_of_several_ending_signals_raises():
    with runner._signals():
        with pytest.raises(runner.CommandEnded):
            signal.raise_signal(signal.SIGTERM)
        signal.raise_signal(signal.SIGTERM)  # the terminal is closed while the arm is being stopped
    with runner._signals(), pytest.raises(runner.CommandEnded):
        signal.raise_signal(signal.SIGTERM)


# The examples in the help of the commands: all are understood, and most are run.


EXAMPLE = re.compile(r"^ {2,}armdrive ((?:\S+ )*\S+)(?: {2,}.*)?$", re.MULTILINE)
"""A line of help that begins with the command; what follows two spaces explains it."""

BEFORE = {
    "move": ["home"],
    "verify": ["home"],
    "points": ["home"],
    "pendant": ["home", "points save pick"],
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
    function, _ = ROWS[name]
    text = re.sub(r"\\\n *", "", command_parser(name, function).format_help())
    return [shlex.split(re.split(" [<>] ", found)[0]) for found in EXAMPLE.findall(text)]


def helps(parser: argparse.ArgumentParser) -> Iterator[str]:
    """Give the help of a parser and of its actions."""
    yield parser.format_help()
    for action in parser._actions:  # argparse has no public way to them
        if isinstance(action, argparse._SubParsersAction):
            for each in action.choices.values():
                yield from helps(each)


@pytest.fixture
def here(capsys, tmp_path, monkeypatch):
    """Return what calls commands in a folder of their own, with a program in it."""
    monkeypatch.setenv("ARMDRIVE_HOME", str(tmp_path / "home"))
    monkeypatch.chdir(tmp_path)
    (tmp_path / "stack.arm").write_text("move pick\n", encoding="utf-8")
    return Caller(capsys)


RUN = [name for group in ("Drive", "Look", "Learn") for name in GROUPS[group]]


EXAMPLES_RUN = sorted({*RUN, "pendant"} - NOT_RUN.keys() - OF_A_HOLDER)


@pytest.mark.parametrize("name", EXAMPLES_RUN[:: amount(3, 1)])
def test_the_examples_of_a_command_run_one_after_the_other(here, name):
    for line in BEFORE.get(name, ()):
        here(*line.split(), code=0)
    if name in RECORDED:
        with held_arm():
            said = here("record", code=0).out
        shutil.copy(said.removeprefix("saved ").strip(), "monday.jsonl")
    for words in examples(name):
        for line in BEFORE_EACH.get(name, ()):
            here(*line.split(), code=0)
        answer = ASKS.get(tuple(words[:2]))
        called = here(*words, *([answer] if answer else []))
        assert (called.code, called.err) == (0, ""), words


@contextmanager
def held_arm():
    """Hold the simulated arm of the command line, as another program would."""
    with connect_remembered(simulated_config("teachmover"), pace=10.0) as arm:
        arm.reference.confirm()
        yield
