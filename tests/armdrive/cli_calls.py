"""Calling the command line within the test's own process, and what it said."""

import io
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from armdrive.cli import main
from armdrive.storage import files as places

TRACEBACK = "Traceback"
ESCAPED_BREAK = "\\n  "
"""A line break of our own that was printed as an escape, as only one in foreign text may be."""

SHOW_BYTES = (("log",), ("replay",), ("can",))
"""Commands that show the line breaks of devices, in columns."""


@dataclass(frozen=True)
class Called:
    """What one command ended with and printed."""

    code: int
    out: str
    err: str

    @property
    def json(self) -> dict[str, Any]:
        return json.loads(self.out)

    @property
    def json_lines(self) -> list[dict[str, Any]]:
        return [json.loads(line) for line in self.out.splitlines()]


class Caller:
    """Calls commands one after another; none of them may end in a traceback."""

    def __init__(self, capsys) -> None:
        self._capsys = capsys

    def __call__(self, *words: str, code: int | None = None) -> Called:
        """Call a command; `code` is what it has to end with, where the test knows."""
        self._capsys.readouterr()
        try:
            ended = main(list(words))
        except SystemExit as end:  # how argparse ends
            ended = end.code if isinstance(end.code, int) else 1
        said = self._capsys.readouterr()
        called = Called(ended, said.out, said.err)
        assert TRACEBACK not in said.out + said.err
        ours = "--json" not in words and words[:1] not in SHOW_BYTES
        assert not ours or ESCAPED_BREAK not in said.out + said.err, called
        assert code is None or ended == code, called
        return called

    def refused(self, *words: str, code: int) -> str:
        """Call a command that must fail; return its one sentence."""
        called = self(*words, code=code)
        assert called.err.count("\n") == 1, called
        if "--json" in words:
            return str(json.loads(called.err)["message"])
        assert called.err.startswith("armdrive: "), called
        return called.err.strip()


class Terminal(io.StringIO):
    """A terminal: what was typed at it, or what is shown on it."""

    def isatty(self) -> bool:
        return True


def typed(*lines: str) -> str:
    """Return lines as a person types them."""
    return "".join(f"{line}\n" for line in lines)


def write_arm_file(name: str, text: str) -> Path:
    """Put an arm file where arm files are looked for."""
    path = places.arm_files() / f"{name}.toml"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path


def write_bench(port: object = "/dev/none", name: str = "bench", usb_serial: str = "") -> Path:
    """Put the arm file of a TeachMover on a port, which is not there unless one is given."""
    keys = f'dialect = "teachmover"\nport = "{port}"\nusb_serial = "{usb_serial}"\n'
    return write_arm_file(name, f'model = "teachmover"\n[connection]\n{keys}')
