"""Types what a page shows: its files are written, its commands typed, its answers compared.

A page is worked through from its top to its end, in one world of simulated arms:

- A `console` block has commands behind `$ `. Lines below a command are its answer, in which `...`
  at the end of a line stands for any text. Without an answer the command has to succeed.
- A `prompt` block is a session of `armdrive shell`, whose lines stand behind `> ` and `... `.
- A block that begins with `# NAME.arm`, `# NAME.py`, `# NAME.toml` or `<!-- NAME.urdf -->` is
  written to that file; one in TOML or URDF also into the folder of arm files. Other `python` blocks
  are run, one after another in one namespace; a `text` block right below is what they print.
- `<!-- setup: COMMAND -->` types a command that the reader is not shown.
- `<!-- not typed: REASON -->` above a block leaves it out, for one of the `REASONS`.

A failing page names the command and its answer. With `WRITE_PAGES=1` in the environment the tests
write the new answers into the pages, line by line: read the difference before you keep it.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import shlex
import subprocess
import sys
from collections.abc import Callable, Iterator
from difflib import SequenceMatcher
from pathlib import Path
from typing import Any

from cli_calls import TRACEBACK, Called

from armdrive.config.sections import is_model_file
from armdrive.storage import files as places

REASONS = frozenset(
    (
        "needs hardware",
        "needs a terminal",
        "needs a second terminal",
        "runs until it is stopped",
        "takes long",
        "changes the computer",
        "is an outline",
    )
)
COMMENT = r"<!-- (?P<word>setup|not typed): (?P<value>.*?) -->"
FENCE = r"^```(?P<kind>\w*)\n(?P<text>.*?)^```$"
PART = re.compile(rf"{COMMENT}|{FENCE}", re.DOTALL | re.MULTILINE)
NAMED = re.compile(r"(?:#|<!--) ([\w-]+\.(?:arm|py|toml|urdf))\b")
WRITE = "WRITE_PAGES" in os.environ
AS_INSTALLED = ("-parmdrive.testing.plugin", "-pno:cacheprovider")
"""What pytest finds by itself where armdrive was installed."""


def parts(text: str) -> Iterator[tuple[str, str]]:
    """Yield the comments and blocks of a page that the tests act on, with their kinds."""
    left_out = False
    for found in PART.finditer(text):
        word = found["word"]
        if word == "not typed":
            assert found["value"] in REASONS, f"{found['value']!r} is none of {sorted(REASONS)}"
            left_out = True
        elif word:
            yield word, found["value"]
        else:
            if not left_out:
                yield found["kind"], found["text"]
            left_out = False


def commands(text: str) -> list[tuple[str, list[str]]]:
    """Split a block into commands, each with the lines that are shown below it."""
    found: list[tuple[str, list[str]]] = []
    for row in text.splitlines():
        if row.startswith("$ "):
            found.append((row[2:], []))
        else:
            found[-1][1].append(row)
    return found


def fits(shown: list[str], wanted: list[str]) -> bool:
    """Return whether an answer is as the page has it; `...` is whatever was left out there."""
    pieces = re.split(r"\.\.\.$", "\n".join(wanted), flags=re.MULTILINE)
    return re.fullmatch(r"(?s:.*?)".join(map(re.escape, pieces)), "\n".join(shown)) is not None


def renewed(shown: list[str], wanted: list[str]) -> list[str]:
    """Return the lines of a page with each one that differs replaced by the answer's nearest."""
    return [row if row == "..." else _nearest(shown, row) for row in wanted]


def _nearest(shown: list[str], row: str) -> str:
    """Return the line of an answer that is most like a row, cut off where the row is cut off."""
    stem = row.removesuffix("...")
    found = max(shown, key=lambda each: SequenceMatcher(None, each[: len(row)], stem).ratio())
    if stem == row:
        return found
    head, sign, _ = found.partition(stem[-2:])
    for _ in range(stem.count(sign) - 1):
        more, sign, _ = found[len(head + sign) :].partition(sign)
        head += sign + more
    return f"{head}{sign}..."


class Typist:
    """Types the blocks of one page, in a folder of its own."""

    def __init__(
        self, call: Callable[..., Called], set_input: Callable[[str], None], folder: Path
    ) -> None:
        self._call = call
        self._set_input = set_input
        self._folder = folder
        self._names: dict[str, Any] = {"__name__": "page"}
        self.printed: str | None = None
        """What the last program printed, None where the last block was none."""
        self.typed = 0
        self.renewed: list[tuple[str, str]] = []
        """Pieces of the page whose answers differ, and what they should be."""

    def do(self, kind: str, text: str) -> None:
        """Carry out one comment or block of a page."""
        printed, self.printed = self.printed, None
        if kind == "setup":
            assert self._type(text).code == 0, text
        elif named := NAMED.match(text):
            self._write(named[1], text)
        elif kind == "console":
            for command, wanted in commands(text):
                self._compare(command, wanted)
        elif kind == "prompt":
            self._prompt(text)
        elif kind == "python":
            self.printed = self._run(text)
        elif kind == "text" and printed is not None:
            assert printed == text

    def _write(self, name: str, text: str) -> None:
        for folder in (self._folder, places.arm_files())[: 1 + is_model_file(name)]:
            folder.mkdir(parents=True, exist_ok=True)
            (folder / name).write_text(text, encoding="utf-8")

    def _compare(self, command: str, wanted: list[str]) -> None:
        called = self._type(command)
        shown = [*called.out.splitlines(), *called.err.splitlines()]
        if WRITE and shown and not fits(shown, wanted):
            old, new = (
                "\n".join((f"$ {command}", *rows)) for rows in (wanted, renewed(shown, wanted))
            )
            self.renewed.append((old, new))
            wanted = []
        assert not wanted or fits(shown, wanted), (command, shown)
        refused = any(row.startswith("armdrive: [") for row in wanted)
        assert called.code == 0 or refused, (command, called)
        self.typed += 1

    def _prompt(self, text: str) -> None:
        ((command, rows),) = commands(text)
        typed = [row for row in rows if row.startswith(("> ", "... "))]
        answers = [row for row in rows if row not in typed]
        self._set_input("\n".join(row.partition(" ")[2] for row in typed))
        assert self._type(command).out.splitlines()[1:] == answers, text
        self.typed += len(typed)

    def _type(self, command: str) -> Called:
        program, *words = shlex.split(command, comments=True)
        if program == "ARMDRIVE_FORCE_SIM=1":  # holds for every page
            program, *words = words
        if program == "armdrive":
            return self._call(*words)
        ran = subprocess.run(
            [sys.executable, "-m", program, *words, *AS_INSTALLED],
            cwd=self._folder,
            capture_output=True,
            text=True,
            check=False,
        )
        assert TRACEBACK not in ran.stdout + ran.stderr
        return Called(ran.returncode, ran.stdout, ran.stderr)

    def _run(self, code: str) -> str:
        with contextlib.redirect_stdout(io.StringIO()) as printed:
            exec(compile(code, "page", "exec"), self._names)
        self.typed += 1
        return printed.getvalue()
