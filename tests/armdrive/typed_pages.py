"""Types what a page shows: its files are written, its commands typed, its answers compared.

A page is worked through from its top to its end, in one world of simulated arms:

- A `console` block has commands behind `$ `. Lines below a command are its answer, in which `...`
  at the end of a line stands for any text. Without an answer the command has to succeed.
- A `prompt` block is a session of `armdrive shell`, whose lines stand behind `> ` and `... `.
- A block that begins with `# NAME.arm`, `# NAME.py`, `# NAME.toml` or `<!-- NAME.urdf -->` is
  written to that file; one in TOML or URDF also into the folder of arm files. Other `python` blocks
  are run, one after another in one namespace; a `text` block right below is what they print.
- `armdrive sim` with a port serves in a process of its own to the end of the page. Files in /tmp
  are in the page's folder instead.
- `<!-- setup: COMMAND -->` types a command that the reader is not shown.
- `<!-- port: PORT is DIALECT -->` puts a simulated controller behind a port of the reader's. From
  there on the page's arms are real ones, driven in simulated time; `armdrive doctor` finds a new
  controller there. With `none` for both they are simulated twins again.
- `<!-- answers: LINE / LINE -->` types these lines at the questions of the next block.
- `<!-- not typed: REASON -->` above a block leaves it out, for one of the `REASONS`.

A failing page names the command and its answer.
"""

import contextlib
import io
import os
import re
import shlex
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Self

import pytest
from cli_calls import TRACEBACK, Called
from command_host import HostedCommand
from doctor_bench import lead, lead_to_bus, made
from pages import ROOT
from simulated_port import SimulatedPorts

from armdrive.config.sections import is_model_file
from armdrive.connect.target import FORCE_SIM, simulated_config
from armdrive.registry import DIALECTS
from armdrive.storage import files as places

REASONS = frozenset(
    (
        "needs hardware",
        "changes the computer",
    )
)
COMMENT = r"<!-- (?P<word>setup|port|answers|not typed): (?P<value>.*?) -->"
FENCE = r"^```(?P<kind>\w*)\n(?P<text>.*?)^```$"
PART = re.compile(rf"{COMMENT}|{FENCE}", re.DOTALL | re.MULTILINE)
NAMED = re.compile(r"(?:#|<!--) ([\w-]+\.(?:arm|py|toml|urdf))\b")
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


class Terminal(io.StringIO):
    """What a person types at a terminal."""

    def isatty(self) -> bool:
        return True

    def readline(self, size: int | None = -1, /) -> str:
        line = super().readline(size)
        sys.stdout.write(line)  # a terminal shows what is typed
        return line


class Typist:
    """Types the blocks of one page, in a folder of its own."""

    def __init__(
        self, call: Callable[..., Called], set_input: Callable[[io.StringIO], None], folder: Path
    ) -> None:
        self._call = call
        self._set_input = set_input
        self._folder = folder
        self._places = {"/tmp/": f"{folder}/"}
        self._names: dict[str, Any] = {"__name__": "page"}
        self._serving: list[HostedCommand] = []
        self._patch = pytest.MonkeyPatch()
        self._ports: SimulatedPorts | None = None
        self.printed: str | None = None
        """What the last program printed, None where the last block was none."""
        self.typed = 0
        """Pieces of the page whose answers differ, and what they should be."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self._patch.undo()
        for arm in self._serving:
            arm.communicate("quit\n")

    def do(self, kind: str, text: str) -> None:
        """Carry out one comment or block of a page."""
        printed, self.printed = self.printed, None
        if kind == "setup":
            called = self._type(text)
            assert called.code == 0, (text, called)
        elif kind == "port" and text == "none":
            os.environ[FORCE_SIM] = "1"
        elif kind == "port":
            self._put_behind(*text.split(" is "))
        elif kind == "answers":
            typed = "".join(f"{line}\n" for line in _lines(text))
            self._set_input(Terminal(self._here(typed)))
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

    def _put_behind(self, port: str, dialect: str) -> None:
        """Put a simulated controller at a path, and use that path for the port of the page."""
        self._ports = self._ports or SimulatedPorts(self._patch)
        if port not in self._places:
            path = self._folder / Path(port).name
            path.touch()  # the doctor looks whether there is such a port
            self._places[port] = str(path)
            self._ports.put(str(path), dialect)
        os.environ.pop(FORCE_SIM, None)

    def _doctor(self, *words: str) -> Called:
        """Have the doctor look at a new controller, since its waits take seconds in real time."""
        with pytest.MonkeyPatch.context() as patch:
            for port, arm in (self._ports.arms if self._ports else {}).items():
                if DIALECTS[arm.dialect].can:
                    lead_to_bus(patch, simulated_config(arm.dialect))
                else:
                    lead(patch, port, made(arm.dialect))
            return self._call(*words)

    def _serve(self, *words: str) -> Called:
        """Begin `armdrive sim`, which says where the arm is once the port can be opened."""
        process = HostedCommand(*words)
        self._serving.append(process)
        return Called(0, process.stdout.readline(), "")

    def _here(self, text: str) -> str:
        """Return a text of the page with the paths that the test has in place of the reader's."""
        for theirs, ours in self._places.items():
            text = text.replace(theirs, ours)
        return text

    def _there(self, text: str) -> str:
        for theirs, ours in reversed(self._places.items()):
            text = text.replace(ours, theirs)
        return text

    def _write(self, name: str, text: str) -> None:
        for folder in (self._folder, places.arm_files())[: 1 + is_model_file(name)]:
            folder.mkdir(parents=True, exist_ok=True)
            (folder / name).write_text(self._here(text), encoding="utf-8")

    def _compare(self, command: str, wanted: list[str]) -> None:
        called = self._type(command)
        shown = [*called.out.splitlines(), *called.err.splitlines()]
        shown = [self._there(row) for row in shown]
        assert not wanted or fits(shown, wanted), (command, shown)
        refused = any(row.startswith("armdrive: [") for row in wanted)
        assert called.code == 0 or refused, (command, called)
        self.typed += 1

    def _prompt(self, text: str) -> None:
        ((command, rows),) = commands(text)
        typed = [row for row in rows if row.startswith(("> ", "... "))]
        answers = [row for row in rows if row not in typed]
        self._set_input(io.StringIO("\n".join(row.partition(" ")[2] for row in typed)))
        assert self._type(command).out.splitlines()[1:] == answers, text
        self.typed += len(typed)

    def _type(self, command: str) -> Called:
        program, *words = shlex.split(self._here(command), comments=True)
        if program == f"{FORCE_SIM}=1":
            with pytest.MonkeyPatch.context() as patch:
                patch.setenv(FORCE_SIM, "1")
                return self._call(*words[1:])
        if program == "armdrive":
            if words[0] == "sim" and "--list" not in words:
                return self._serve(*words)
            return (self._doctor if words[0] == "doctor" else self._call)(*words)
        module, cwd = (words[1], ROOT) if program == "python" else (program, self._folder)
        options = words[2:] if program == "python" else [*words, *AS_INSTALLED]
        ran = subprocess.run(
            [sys.executable, "-m", module, *options],
            cwd=cwd,
            capture_output=True,
            text=True,
            check=False,
        )
        assert TRACEBACK not in ran.stdout + ran.stderr
        return Called(ran.returncode, ran.stdout, ran.stderr)

    def _run(self, code: str) -> str:
        with contextlib.redirect_stdout(io.StringIO()) as printed:
            exec(compile(self._here(code), "page", "exec"), self._names)
        self.typed += 1
        return printed.getvalue()


def _lines(text: str) -> list[str]:
    """Split the lines that are typed at questions."""
    return [line.strip() for line in text.split(" / ")]
