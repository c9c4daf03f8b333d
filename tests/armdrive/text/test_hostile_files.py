"""Every command that reads a file answers a hostile one with a sentence and its exit code."""

import ast
import json
import os
from pathlib import Path

import pytest
from amounts import every_row
from hostile import CONTENTS, special_files, unprintable

from armdrive.cli.runner import FAULT
from armdrive.cli.unexpected import DETAILS
from armdrive.errors import BadRequest
from armdrive.storage import files as places
from armdrive.storage.point_file import LARGEST_BYTES as LARGEST_POINTS
from armdrive.text.reading import (
    DEEPEST,
    LARGEST_BYTES,
    LARGEST_INTEGER,
    parse_json,
    parse_toml,
    read_bytes,
    read_text,
    read_toml,
)

LONGEST_ANSWER = 10_000
"""Characters. A message quotes a little of what was wrong, and not a whole file."""

USAGE = 2
SIMULATED = ("--sim", "teachmover")
READERS = {
    "an arm file to check": ("config", "check", "{}.toml"),
    "an arm": ("status", "--arm", "{}.toml"),
    "answers": ("config", "new", "bench", "--yes", "--answers", "{}.toml"),
    "a model": ("explain", "{}.toml"),
    "a program": ("run", "{}.arm", "--check", *SIMULATED),
    "a script": ("run", "{}.py", "--check", *SIMULATED),
    "a recording": ("log", "{}.jsonl"),
    "a recording to replay": ("replay", "{}.jsonl"),
    "a pendant's program": ("pendant", "write", "{}.pendant", "--yes", *SIMULATED),
}
"""The commands that take a file of each kind; the ending is put behind its name."""


def named(words, path):
    """Return the words of a command, with a file in their place."""
    return [str(path) + word.removeprefix("{}") if "{}" in word else word for word in words]


def ending(words):
    return next(word.removeprefix("{}") for word in words if "{}" in word)


@pytest.mark.parametrize("reader", ["an arm", "a model", "a program", "a recording"])
def test_anything_but_a_plain_file_is_reported(call, reader, tmp_path):
    words = READERS[reader]
    alias = tmp_path / f"alias{ending(words)}"
    for name, path in special_files(tmp_path).items():
        alias.unlink(missing_ok=True)
        alias.symlink_to(path)  # a command may go by the ending
        said = call(*named(words, alias.with_suffix("")))
        assert said.code == USAGE, (name, said)
        assert not unprintable(said.out + said.err), name
        assert len(said.out + said.err) < LONGEST_ANSWER, name


@pytest.mark.parametrize("reader", READERS)
@every_row("content", CONTENTS.values(), ids=CONTENTS)
def test_a_hostile_content_is_told(call, reader, content, tmp_path):
    words = READERS[reader]
    if reader == "a script" and is_python(content):
        return  # a script that can be read may do as it likes
    path = tmp_path / "hostile"
    path.with_suffix(ending(words)).write_bytes(content)
    said = call(*named(words, path))
    assert said.code == USAGE or (said.code == 0 and reader in MAY_BE_READ), said
    assert not unprintable(said.out + said.err)
    assert len(said.out + said.err) < LONGEST_ANSWER


def is_python(content):
    try:
        ast.parse(content)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return False
    return True


MAY_BE_READ = {"a program", "answers"}
"""Nothing at all, and line breaks alone, are a program that does nothing."""


@pytest.mark.parametrize("content", CONTENTS.values(), ids=CONTENTS)
def test_a_hostile_content_in_our_own_folders_is_told(call, content):
    """Arm files, points, the default arm and worlds that another program may have written."""
    places.arm_files().mkdir(parents=True)
    (places.arm_files() / "bench.toml").write_text('model = "teachmover"\n')
    (places.arm_files() / "odd.toml").write_bytes(content)
    (places.arm_files().parent / "default-arm").write_bytes(content)
    places.points_file("bench").parent.mkdir(parents=True)
    places.points_file("bench").write_bytes(content)
    places.states().mkdir(parents=True)
    for kind in ("world.json", "program.json", "json"):
        (places.states() / f"{places.file_name('sim:teachmover')}.{kind}").write_bytes(content)
    for words in (
        ("config", "list"),
        ("config", "check"),
        ("points", "list", "--arm", "bench"),
        ("status", *SIMULATED),
        ("status",),
        ("run", "--resume", "x.arm", *SIMULATED),
    ):
        said = call(*words)
        assert said.code in (0, 1, USAGE), said
        assert not unprintable(said.out + said.err)


# -- the rule for reading ---------------------------------------------------------------------


def test_a_byte_order_mark_and_every_kind_of_line_break_are_read(tmp_path):
    path = tmp_path / "windows.toml"
    path.write_bytes(b"\xef\xbb\xbfa = 1\r\nb = 2\rc = 3\n")
    assert read_toml(path, "the file", BadRequest) == {"a": 1, "b": 2, "c": 3}
    assert read_text(path, "the file", BadRequest) == "a = 1\nb = 2\nc = 3\n"


def test_a_file_of_the_largest_size_is_read_and_no_larger_one(tmp_path):
    path = tmp_path / "large"
    path.write_bytes(b"x" * LARGEST_BYTES)
    assert len(read_bytes(path, "the file", BadRequest)) == LARGEST_BYTES
    path.write_bytes(b"x" * (LARGEST_BYTES + 1))
    with pytest.raises(BadRequest, match="larger"):
        read_bytes(path, "the file", BadRequest)


def test_a_device_is_not_even_opened(monkeypatch):
    """Opening a serial port resets the board behind it."""
    opened = []
    monkeypatch.setattr(os, "open", lambda *words: opened.append(words))
    with pytest.raises(BadRequest, match="not a regular file"):
        read_bytes(Path("/dev/null"), "the file", BadRequest)
    assert not opened


@pytest.mark.parametrize("path", ["a\0b", "\ud800", "x" * 10_000])
def test_a_path_that_no_file_can_have_is_told(path):
    with pytest.raises(BadRequest, match="cannot be read"):
        read_bytes(Path(path), "the file", BadRequest)


NESTED = {
    "lists": lambda n: "x = " + "[" * n + "]" * n,
    "tables": lambda n: "x = " + "{a = " * n + "1" + "}" * n,
    "a header": lambda n: "[" + ".".join("a" * n) + "]",
    "a key": lambda n: ".".join("a" * n) + " = 1",
    "lists in a table": lambda n: "[" + ".".join("a" * (n - 9)) + "]\nx = " + "[" * 9 + "]" * 9,
}


@every_row("build", NESTED.values(), ids=NESTED)
def test_nesting_is_read_down_to_a_limit(build):
    assert parse_toml(build(DEEPEST - 1), BadRequest)
    with pytest.raises(BadRequest, match="nested"):
        parse_toml(build(DEEPEST + 2), BadRequest)


def test_a_key_of_many_parts_is_refused_before_a_parser_spends_hours_on_it():
    with pytest.raises(BadRequest, match="nested"):
        parse_toml("a." * 100_000 + "a = 1", BadRequest)


@every_row("text", ["# " + "a." * 99, 'x = "' + "a." * 99 + '"', f"x = [{'1.5, ' * 9999}]"])
def test_dots_that_nest_nothing_are_read(text):
    parse_toml(text, BadRequest)


@every_row(
    "text, said",
    [
        (f"x = {LARGEST_INTEGER + 1}", "64 bits"),
        (f"x = -{LARGEST_INTEGER + 2}", "64 bits"),
        ("x = 0x" + "f" * 300, "64 bits"),
        ("x = [{ y = 1" + "0" * 30 + "}]", "64 bits"),
        ("x = " + "9" * 6000, "digits"),
    ],
)
def test_a_number_that_is_too_large_is_told(text, said):
    with pytest.raises(BadRequest, match=said):
        parse_toml(text, BadRequest)


@every_row("text", ["NaN", "[Infinity]", "-Infinity", "1" * 30, "9" * 6000, "[" * 99])
def test_json_has_the_same_limits_and_no_nan(text):
    with pytest.raises(BadRequest):
        parse_json(text, BadRequest)


def test_points_that_were_read_in_part_are_never_written_back(call):
    """A file beyond the limit was cut there: a change would have lost what lay behind."""
    path = places.points_file("sim:teachmover")
    path.parent.mkdir(parents=True)
    comment = b"# a long comment\n" * (LARGEST_POINTS // 17 + 1)
    path.write_bytes(comment)
    call("home", *SIMULATED, code=0)
    assert "larger" in call.refused("points", "save", "here", *SIMULATED, code=USAGE)
    assert path.read_bytes() == comment


# -- the last resort --------------------------------------------------------------------------


def nobody_foresaw_this(options):
    raise LookupError("\x1b[31m nobody foresaw this\n and a second line")


def again(options):
    return again(options)


@pytest.fixture
def failing(call, monkeypatch):
    """Return what calls a command that has a fault of its own."""

    def called(fault, *words, traceback="", code=FAULT):
        monkeypatch.setattr("armdrive.cli.learn.errors.errors", fault)
        monkeypatch.setenv("ARMDRIVE_TRACEBACK", traceback)
        return call("errors", *words, code=code)

    return called


def test_a_fault_is_one_sentence_and_a_file_with_the_details(failing):
    told = failing(nobody_foresaw_this).err
    details = places.states() / DETAILS
    for words in (str(details), "[E005]", "LookupError"):
        assert words in told
    assert told.count("\n") == 1
    text = details.read_text(encoding="utf-8")
    assert "nobody foresaw this" in text
    assert "in nobody_foresaw_this" in text
    assert not unprintable(text + told)
    said = failing(nobody_foresaw_this, "--json", traceback="0")
    assert json.loads(said.err)["code"] == "E005"
    assert "RecursionError" in failing(again).err


def test_details_that_cannot_be_written_are_told(failing):
    Path(os.environ["ARMDRIVE_HOME"]).write_text("a file where the folder would be")
    assert "ARMDRIVE_TRACEBACK=1" in failing(nobody_foresaw_this).err


def test_the_environment_lets_the_exception_through(failing):
    with pytest.raises(LookupError):
        failing(nobody_foresaw_this, traceback="1")
