"""Whatever text comes from, a terminal is sent printable characters and our own styling alone."""

import ast
import contextlib
import json
from pathlib import Path

import pytest
from amounts import every_row
from cli_calls import TRACEBACK, write_arm_file
from hostile import HOSTILE_TEXT, toml_text, unprintable
from hypothesis import given
from hypothesis import strategies as st

import armdrive
from armdrive.cli import chosen_arm, main
from armdrive.cli.set_up import ports as ports_command
from armdrive.errors import ArmError, BadRequest, DeviceFault, UnknownPoint
from armdrive.errors.printable import (
    LONGEST_LINE,
    as_message,
    printable,
    printable_lines,
)
from armdrive.programs.problems import excerpt
from armdrive.storage import files as places
from armdrive.trace.entries import TRAFFIC, EntryKind
from armdrive.transports import ports
from armdrive.transports.ports import PortHolder, PortInfo

SOURCES = Path(armdrive.__file__).parent


# -- the rule itself --------------------------------------------------------------------------


@given(st.text())
def test_printable_text_is_printable_and_stays_as_it_is(text):
    shown = printable(text)
    assert shown.isprintable()
    assert printable(shown) == shown
    assert (shown == text) == text.isprintable()


@given(st.text())
def test_lines_keep_their_breaks_and_nothing_else(text):
    assert not unprintable(printable_lines(text))
    assert printable_lines(text).count("\n") == text.count("\n")


@every_row("text", HOSTILE_TEXT.values(), ids=HOSTILE_TEXT)
def test_an_error_is_printable_wherever_it_is_shown(text):
    for kind in (ArmError, BadRequest, UnknownPoint):
        assert not unprintable(str(kind(f"no {text} here")))


def test_an_error_that_quotes_a_whole_file_keeps_its_beginning_and_its_end():
    told = str(BadRequest(f"x must be a number, not {'9' * 100_000}; correct it"))
    assert len(told) <= LONGEST_LINE
    assert told.startswith("x must be a number")
    assert told.endswith("; correct it")
    assert as_message(told) == told


@every_row("text", HOSTILE_TEXT.values(), ids=HOSTILE_TEXT)
def test_a_caret_stands_under_its_place_behind_hostile_text(text):
    line, caret = excerpt(f"{text.replace(chr(10), ' ')}HERE", len(text) + 1).split("\n")
    assert line[caret.index("^") :] == "HERE"
    assert line.isprintable()


PRINTING = {"print", "_print", "sys.stdout.write", "sys.stderr.write", "output.write", "_send"}
OWN_WORDS = {
    # the help, before anything is loaded
    "__init__.py": {"_exit_codes()", "_help()", "f\"armdrive {version('armdrive')}\\n\"", "text"},
    "presenter.py": {
        "text",
        "(_in_inks(rows, parts) if has_colour(sys.stdout) else rows) + '\\n'",
        "control + _printable(text, stream)",
    },
    "program/run_person.py": {"f'{words}\\n'"},  # in a signal handler; constants
}
"""What the command line writes by itself: our own words, which quote nothing."""


def test_the_command_line_prints_through_one_module():
    printing = {}
    for path in sorted((SOURCES / "cli").rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and ast.unparse(node.func) in PRINTING:
                name = path.relative_to(SOURCES / "cli").as_posix()
                printing.setdefault(name, set()).add(ast.unparse(node.args[0]))
    assert printing == {
        # each version of Python has its own quotes within an f-string
        name: {ast.unparse(ast.parse(each)) for each in words}
        for name, words in OWN_WORDS.items()
    }


def caught_from_the_system(tree):
    """Yield each handler of `OSError`, with the name of what it caught."""
    for node in ast.walk(tree):
        named = isinstance(node, ast.ExceptHandler) and node.name and node.type is not None
        if named and "OSError" in ast.unparse(node.type):
            yield node, node.name


def test_no_message_quotes_an_error_of_the_system_with_its_number():
    """`reason_of` and `in_words` leave `[Errno 21]` out."""
    found = []
    for path in sorted([*SOURCES.rglob("*.py"), *(SOURCES.parent / "tui").rglob("*.py")]):
        source = path.read_text(encoding="utf-8")
        if "OSError" not in source:
            continue
        for handler, caught in caught_from_the_system(ast.parse(source)):
            said = {ast.unparse(each) for each in ast.walk(handler)}
            if said & {f"str({caught})", f"{{{caught}}}"}:
                found.append(f"{path}:{handler.lineno}")
    assert not found


# -- every outlet -----------------------------------------------------------------------------

SIMULATED = ("--sim", "teachmover")


def arm_file(text):
    write_arm_file("bench", f'model = "teachmover"\ntitle = {toml_text(text)}\n')
    angles = "{ base = 0, shoulder = 0, elbow = 0, wrist_pitch = 0, wrist_roll = 0 }"
    point = f"[points.{toml_text(text)}]\njoints_deg = {angles}\nnote = {toml_text(text)}\n"
    places.points_file("bench").parent.mkdir(parents=True, exist_ok=True)
    places.points_file("bench").write_text(point, encoding="utf-8")


def broken_arm_file(text):
    write_arm_file("bench", f'model = "teachmover"\n{toml_text(text)} = 1\n')


def file_with(name, *lines):
    """Return what writes a file whose lines hold a hostile text."""

    def write(text):
        shown = "".join(f"{line.replace('{}', text)}\n" for line in lines)
        Path(name).write_text(shown, encoding="utf-8", errors="surrogateescape")

    return write


def recording(text):
    header = dict.fromkeys(HEADER, text)
    header |= {"armdrive_recording": 1, "began_s": 0.0, "dialect": "grbl"}
    wire = "".join(each for each in text if ord(each) < 256) + "\r\n"
    entries = [
        {"t": 0.0, "kind": kind.value, "bytes": wire}
        if kind in TRAFFIC
        else {"t": 0.0, "kind": kind.value, "text": text}
        for kind in EntryKind
    ]
    Path("r.jsonl").write_text("".join(f"{json.dumps(each)}\n" for each in [header, *entries]))


HEADER = (
    "version", "why", "arm", "title", "dialect", "link", "calibration", "began", "began_s",
    "arm_file", "model_file",
)  # fmt: skip

OUTLETS = {
    "an arm file and its points": (arm_file, (
        "config show bench", "config list", "points list --arm bench",
        "points list --arm bench --json", "points show x --arm bench",
    )),
    "a key of an arm file": (broken_arm_file, ("config show bench", "config check", "config list")),
    "a line of a program": (file_with("p.arm", 'type "{}"', "# {}", "x = {} 1"), ("run p.arm",)),
    "a text of a program": (file_with("p.arm", 'type "{}" # {}'), (
        "run p.arm --sim teachmover", "run p.arm --check --sim teachmover",
    )),
    "an error of a script": (
        lambda text: Path("s.py").write_text(f"raise ValueError({text!r})\n", encoding="utf-8"),
        ("run s.py --sim teachmover",),
    ),
    "a recording": (recording, ("log r.jsonl", "replay r.jsonl")),
}  # fmt: skip
"""What brings text in, and the commands that may print it: one module prints for all of them."""


@pytest.mark.parametrize("name", OUTLETS)
def test_no_command_prints_text_of_a_file_raw(name, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("ARMDRIVE_TRACEBACK", "")  # as a person has it, who runs a script
    places.arm_files().mkdir(parents=True)
    write, commands = OUTLETS[name]
    written = 0
    for kind, text in HOSTILE_TEXT.items():
        with contextlib.suppress(UnicodeEncodeError):  # no file of this kind can hold it
            write(text)
            written += 1
            for line in commands:
                main(line.split())
                said = capsys.readouterr()
                assert not unprintable(said.out + said.err), (kind, line)
                raised = name == "an error of a script"  # its own traceback may be printed
                assert raised or TRACEBACK not in said.out + said.err, (kind, line)
    assert written >= len(HOSTILE_TEXT) - 1


@every_row("line", [
    "{}", "status --arm {}", "status --{}", "config new {} --yes", "run {}.arm", "log {}",
    "points save {} --sim teachmover", "errors {}", "sim teachmover --fault {}",
])  # fmt: skip
def test_no_command_prints_an_argument_raw(call, line, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for kind, text in HOSTILE_TEXT.items():
        said = call(*(word.replace("{}", text) for word in line.split()))
        assert not unprintable(said.out + said.err), kind


@pytest.mark.parametrize("variable", ["ARMDRIVE_ARM", "ARMDRIVE_HOME"])
def test_no_command_prints_a_variable_of_the_environment_raw(call, variable, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for kind, text in HOSTILE_TEXT.items():
        monkeypatch.setenv(variable, text)
        for words in (("status",), ("config", "check")):
            said = call(*words)
            assert not unprintable(said.out + said.err), kind


def test_the_words_of_adapters_and_devices_are_not_printed_raw(call, monkeypatch):
    for text in HOSTILE_TEXT.values():
        names = dict.fromkeys(("description", "serial_number", "manufacturer", "stable_name"), text)
        found = PortInfo(f"/dev/tty{text}", holder=PortHolder(1234, text), **names)

        def refuses(*_, text=text, **__):
            raise DeviceFault(f"the board said {text!s}")

        for module in (ports, ports_command):
            monkeypatch.setattr(module, "list_ports", lambda found=found: (found,))
        monkeypatch.setattr(chosen_arm, "connect_chosen", refuses)
        for line in ("ports", "ports --json", "home --sim teachmover", "reset --json"):
            said = call(*line.split())
            assert not unprintable(said.out + said.err), (line, text)


# -- numbers ---------------------------------------------

BAD_NUMBERS = ("9" * 6000, "1e999", "nan", "-inf", "\u0663", "1_0", "0x10", "", "--", "1,5")


@every_row("words", [
    ("fk", "{}", "0", "0", "0", "0"), ("slow", "{}"), ("status", "--baud", "{}"),
    ("run", "p.arm", "--loops", "{}"), ("move", "--gripper={}", *SIMULATED),
    ("can", "monitor", "--count", "{}"),
], ids=lambda words: " ".join(words[:2]))  # fmt: skip
def test_a_number_that_is_none_is_refused(call, words):
    for text in BAD_NUMBERS:
        said = call(*(word.replace("{}", text) for word in words), code=2)
        assert len(said.err) < 2 * LONGEST_LINE
        assert not unprintable(said.out + said.err)
