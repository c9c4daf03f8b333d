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


PRINTING = {"print", "_print", "sys.stdout.write", "sys.stderr.write", "output.write", "_send"}
OWN_WORDS = {
    "__init__.py": {"_exit_codes()", "_help()", "f\"armdrive {version('armdrive')}\\n\"", "text"},
    "presenter.py": {
        "text",
        "(_in_inks(rows, parts) if has_colour(sys.stdout) else rows) + '\\n'",
        "control + _printable(text, stream)",
        "control + ''.join((f'{line}{line_end}' for line in shown))",
    },
    "program/run_person.py": {"f'{words}\\n'"},  # in a signal handler; constants
}
"""What is written past that module: our own words, that quote nothing."""


# -- every outlet -----------------------------------------------------------------------------


def arm_with(lines, ending=""):
    """Return what writes an arm file with a hostile text in some lines."""
    return lambda text: write_arm_file("bench", lines.format(toml_text(text + ending)))


PLAIN = 'model = "teachmover"\n'
arm_with_title = arm_with(PLAIN + "title = {}\n")
arm_with_key = arm_with(PLAIN + "{} = 1\n")
arm_with_value = arm_with("model = {}\n", ".toml")
arm_with_frame = arm_with(PLAIN + "[frames.{}]\nx_mm = 1\n")


def named_points(text):
    arm_with_title("bench")
    angles = "{ base = 0, shoulder = 0, elbow = 0, wrist_pitch = 0, wrist_roll = 0 }"
    path = places.points_file("bench")
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(
        f"[points.here]\njoints_deg = {angles}\nnote = {toml_text(text)}\n",
        encoding="utf-8",
    )


def oddly_named_point(text):
    named_points("x")
    path = places.points_file("bench")
    path.write_text(
        path.read_text(encoding="utf-8").replace("points.here", f"points.{toml_text(text)}"),
        encoding="utf-8",
    )


def model(text):
    Path("m.toml").write_text(
        f"name = {toml_text(text)}\ntitle = {toml_text(text)}\nsource = {toml_text(text)}\n"
        "[[links]]\na_mm = 10\n[[links]]\na_mm = 10\n",
        encoding="utf-8",
    )


def program(text):
    Path("p.arm").write_text(
        f'type "{text}"\n# {text}\nx = {text} 1\n', encoding="utf-8", errors="surrogateescape"
    )


def said_program(text):
    Path("p.arm").write_text(
        f'type "{text}" # {text}\n', encoding="utf-8", errors="surrogateescape"
    )


def script(text):
    Path("s.py").write_text(f"raise SystemExit({text!r})\n", encoding="utf-8")


def failing_script(text):
    Path("s.py").write_text(f"raise ValueError({text!r})\n", encoding="utf-8")


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


def pendant(text):
    Path("f.pendant").write_text(
        f"armdrive pendant program 1\n{text} 1 2\n", encoding="utf-8", errors="surrogateescape"
    )


SIMULATED = ("--sim", "teachmover")
OUTLETS = {
    "an arm's title": (arm_with_title, (
        ("config", "show", "bench"), ("config", "check", "bench"), ("config", "list"),
        ("config", "show", "bench", "--toml"), ("config", "show", "bench", "--json"),
    )),
    "a key of an arm file": (arm_with_key, (
        ("config", "show", "bench"), ("config", "check"), ("config", "list"),
    )),
    "a value of an arm file": (arm_with_value, (
        ("config", "show", "bench"), ("config", "check", "bench"), ("config", "list"),
    )),
    "a frame of an arm file": (arm_with_frame, (
        ("config", "show", "bench"), ("config", "check", "bench"),
    )),
    "points": (named_points, (
        ("points", "list", "--arm", "bench"), ("points", "list", "--arm", "bench", "--json"),
        ("points", "show", "here", "--arm", "bench"),
    )),
    "the name of a point": (oddly_named_point, (
        ("points", "list", "--arm", "bench"), ("points", "show", "x", "--arm", "bench"),
    )),
    "a model file": (model, (
        ("explain", "m.toml", "1", "2"), ("fk", "--model", "m.toml", "1", "2"),
        ("explain", "m.toml", "--urdf"), ("explain", "m.toml", "1"),
    )),
    "a line of a program": (program, (("run", "p.arm", "--check", *SIMULATED),)),
    "a text of a program": (said_program, (
        ("run", "p.arm", *SIMULATED), ("run", "p.arm", "--check", *SIMULATED),
    )),
    "the end of a script": (script, (("run", "s.py", *SIMULATED),)),
    "an error of a script": (failing_script, (("run", "s.py", *SIMULATED),)),
    "a recording": (recording, (("log", "r.jsonl"), ("replay", "r.jsonl"))),
    "a pendant's program": (pendant, (("pendant", "points", "f.pendant", "x", *SIMULATED),)),
}  # fmt: skip
"""What brings text in, and the commands that may print it."""


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
            for words in commands:
                main(list(words))
                said = capsys.readouterr()
                assert not unprintable(said.out + said.err), (kind, words)
                raised = name == "an error of a script"  # its own traceback may be printed
                assert raised or TRACEBACK not in said.out + said.err, (kind, words)
    assert written >= len(HOSTILE_TEXT) - 1


ARGUMENTS = {
    "no such command": ("{}",),
    "an arm": ("status", "--arm", "{}"),
    "a port": ("status", "--port", "{}"),
    "an unknown option": ("status", "--{}"),
    "an arm file": ("config", "check", "{}"),
    "a new arm": ("config", "new", "{}", "--yes"),
    "answers": ("config", "new", "bench", "--answers", "{}"),
    "a program": ("run", "{}.arm"),
    "a point to save": ("points", "save", "{}", *SIMULATED),
    "a recording": ("log", "{}"),
    "a setting": ("replay", "x.jsonl", "--set", "{}=1"),
    "a joint": ("explain", "two-link-1", "{}"),
    "words of an error": ("errors", "--find", "{}"),
    "a pendant's file": ("pendant", "points", "{}", "x", *SIMULATED),
    "a fault": ("sim", "teachmover", "--fault", "{}"),
    "a keyboard": ("jog", *SIMULATED, "--keys", "{}"),
    "a file to record into": ("record", "--arm", "{}"),
}  # fmt: skip
"""One module prints for all commands, so some of them stand for all."""


@pytest.mark.parametrize("name", ARGUMENTS)
def test_no_command_prints_an_argument_raw(call, name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for kind, text in HOSTILE_TEXT.items():
        said = call(*(word.replace("{}", text) for word in ARGUMENTS[name]))
        assert not unprintable(said.out + said.err), kind
        assert said.code != 0 or name in CAN_END_WELL, kind


CAN_END_WELL = {"a point to save", "words of an error", "a new arm"}


@pytest.mark.parametrize("variable", ["ARMDRIVE_ARM", "ARMDRIVE_HOME"])
def test_no_command_prints_a_variable_of_the_environment_raw(call, variable, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for kind, text in HOSTILE_TEXT.items():
        monkeypatch.setenv(variable, text)
        for words in (("status",), ("config", "list"), ("config", "check")):
            said = call(*words)
            assert not unprintable(said.out + said.err), kind


# -- what comes from devices ------------------------------------------------------------------


@pytest.mark.parametrize("text", HOSTILE_TEXT.values(), ids=HOSTILE_TEXT)
def test_the_words_of_an_adapter_are_not_printed_raw(call, text, monkeypatch):
    found = PortInfo(
        f"/dev/tty{text}",
        description=text,
        serial_number=text,
        manufacturer=text,
        holder=PortHolder(1234, text),
        stable_name=text,
    )
    for module in (ports, ports_command):
        monkeypatch.setattr(module, "list_ports", lambda: (found,))
    for words in (("ports",), ("ports", "--json"), ("doctor",)):
        said = call(*words)
        assert not unprintable(said.out + said.err), words


@pytest.mark.parametrize("text", HOSTILE_TEXT.values(), ids=HOSTILE_TEXT)
def test_the_words_of_a_device_are_not_printed_raw(call, text, monkeypatch):
    def refuses(*_, **__):
        raise DeviceFault(f"the board said {text!s}")

    monkeypatch.setattr(chosen_arm, "connect_chosen", refuses)
    for words in (("home", *SIMULATED), ("home", *SIMULATED, "--json")):
        said = call(*words, code=DeviceFault.exit_code)
        assert not unprintable(said.out + said.err)


# -- numbers ----------------------------------------------------------------------------------

BAD_NUMBERS = ("9" * 6000, "1e999", "nan", "-inf", "\u0663", "1_0", "0x10", "", "--", "1,5")


@every_row("words", [
    ("fk", "{}", "0", "0", "0", "0"), ("explain", "two-link-1", "{}", "0"), ("slow", "{}"),
    ("status", "--baud", "{}"), ("run", "p.arm", "--loops", "{}"), ("run", "p.arm", "--pace", "{}"),
    ("watch", "--every", "{}"), ("ik", "--x={}"),
    ("move", "--gripper={}", *SIMULATED), ("can", "monitor", "--count", "{}"),
], ids=lambda words: " ".join(words[:2]))  # fmt: skip
def test_a_number_that_is_none_is_refused(call, words):
    for text in BAD_NUMBERS:
        said = call(*(word.replace("{}", text) for word in words), code=2)
        assert len(said.err) < 2 * LONGEST_LINE
        assert not unprintable(said.out + said.err)


# -- programs that never end, or grow ---------------------------------------------------------

ENDLESS = {
    "a thousand million rounds": "repeat 1000000000\n  x = 1\nend\n",
    "more rounds than a number has": "repeat 1e300\n  x = 1\nend\n",
    "a loop": "while true\n  x = 1\nend\n",
    "a jump to itself": "10: goto 10\n",
    "a call of itself": "define f(x)\n  f(x + 1)\n  f(x + 1)\nend\nf(1)\n",
    "an endless wait": "delay 1e300\n",
    "a number without end": "x = 1e308 * 10\ndelay x - x\n",
    "a digit of another script": "delay \u0663\n",
    "blocks within blocks": "repeat 2\n" * 500 + "end\n" * 500,
    "a long line": "x = " + "1 + " * 10_000 + "1\n",
    "many lines": "x = 1\n" * 20_000,
}


@pytest.mark.parametrize("text", ENDLESS.values(), ids=ENDLESS)
def test_a_program_that_never_ends_is_refused_in_a_rehearsal(call, text, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("p.arm").write_text(text, encoding="utf-8")
    said = call("run", "p.arm", "--check", *SIMULATED)
    assert said.code in (2, 3), said
    assert len(said.out + said.err) < 2 * LONGEST_LINE
