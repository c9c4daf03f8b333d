"""From the command to its help: `armdrive --help` beside a bare interpreter."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from measuring import Section, interleaved, timing


def command() -> list[str]:
    """Return how people call it: the script beside this interpreter, or the module."""
    script = Path(sys.executable).with_name("armdrive")
    return [str(script)] if script.is_file() else [sys.executable, "-m", "armdrive"]


def _run(words: list[str]) -> None:
    subprocess.run(words, check=True, stdout=subprocess.DEVNULL)


def starting(rounds: int = 40) -> Section:
    """Run both in turn."""
    words = [*command(), "--help"]
    bare, ours = f"{Path(sys.executable).name} -c pass", "armdrive --help"
    taken = interleaved(
        {bare: lambda: _run([sys.executable, "-c", "pass"]), ours: lambda: _run(words)}, rounds
    )
    rows = (
        timing(bare, taken[bare]),
        timing(ours, taken[ours], beside={"a bare interpreter": taken[bare]}),
    )
    return Section("Starting", rows, f"{rounds} runs each, in turn; as {' '.join(words)}")
