"""From the command to its help: `armdrive --help` beside a bare interpreter."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from statistics import median

from measuring import Row, Section, interleaved, p99, ratio


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
    rows = tuple(
        Row(
            name,
            median(seconds) * 1e3,
            "ms",
            p99(seconds) * 1e3,
            {"a bare interpreter": ratio(seconds, taken[bare])} if name == ours else {},
        )
        for name, seconds in taken.items()
    )
    return Section("Starting", rows, f"{rounds} runs each, in turn; as {' '.join(words)}")
