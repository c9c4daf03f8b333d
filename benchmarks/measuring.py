"""Measuring things side by side: every case in turn, round after round, then medians and ratios.

And how a benchmark of such sections is called and prints. Those that hold values against announced
bounds are called and print by feel.py.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import platform
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from statistics import median
from types import MappingProxyType
from typing import Any

# benchmarks are run as scripts, and share the benches of the tests
sys.path.insert(0, str(Path(__file__).parents[1]))


@dataclass(frozen=True, slots=True)
class Row:
    """One thing that was measured; `times` holds its ratios to what it is compared with."""

    what: str
    value: float
    unit: str
    p99: float | None = None
    times: Mapping[str, float] = field(default_factory=dict)

    def __str__(self) -> str:
        words = [f"{self.what:<46}{self.value:>10.4g} {self.unit}"]
        if self.p99 is not None:
            words.append(f"p99 {self.p99:.4g}")
        words += [f"{ratio:.3g} x {other}" for other, ratio in self.times.items()]
        return ", ".join(words)


@dataclass(frozen=True, slots=True)
class Section:
    """What one part of the benchmark found, and how to read it."""

    title: str
    rows: tuple[Row, ...]
    note: str = ""


def interleaved(cases: Mapping[str, Callable[[], object]], rounds: int) -> dict[str, list[float]]:
    """Call every case in turn, `rounds` times; return the seconds that each call took.

    What disturbs the computer for a while then disturbs all cases alike. One call of each
    beforehand warms it up, and is not counted.
    """
    for case in cases.values():
        case()
    taken_s: dict[str, list[float]] = {name: [] for name in cases}
    for _ in range(rounds):
        for name, case in cases.items():
            began_s = time.perf_counter()
            case()
            taken_s[name].append(time.perf_counter() - began_s)
    return taken_s


def p99(values: list[float]) -> float:
    """Return the value that one in a hundred reaches or passes; of fewer values, the largest."""
    ordered = sorted(values)
    return ordered[min(int(len(ordered) * 0.99), len(ordered) - 1)]


def ratio(values: list[float], others: list[float]) -> float:
    """Return how many times larger the one median is than the other."""
    return median(values) / median(others)


SCALES = {"ms": 1e3, "us": 1e6}


def timing(
    what: str,
    seconds: list[float],
    unit: str = "ms",
    *,
    per: int = 1,
    beside: Mapping[str, list[float]] = MappingProxyType({}),
) -> Row:
    """Return a row of times, each of so many calls, with its ratios to what was timed beside it."""
    scale = SCALES[unit.split()[0]] / per
    times = {name: ratio(seconds, others) for name, others in beside.items()}
    return Row(what, median(seconds) * scale, unit, p99(seconds) * scale, times)


@contextlib.contextmanager
def own_home() -> Iterator[Path]:
    """Keep arm files, positions and locks in a folder of this run, away from the user's."""
    kept = {name: os.environ.get(name) for name in ("ARMDRIVE_HOME", "ARMDRIVE_FORCE_SIM")}
    with tempfile.TemporaryDirectory(prefix="armdrive-bench-") as folder:
        os.environ["ARMDRIVE_HOME"] = folder
        os.environ.pop("ARMDRIVE_FORCE_SIM", None)
        try:
            yield Path(folder)
        finally:
            for name, value in kept.items():
                if value is None:
                    os.environ.pop(name, None)
                else:
                    os.environ[name] = value


def command() -> list[str]:
    """Return how people call it: the script beside this interpreter, or the module."""
    script = Path(sys.executable).with_name("armdrive")
    return [str(script)] if script.is_file() else [sys.executable, "-m", "armdrive"]


# -- how a benchmark of sections is called and prints ---------------------------------------------

JSON = {"action": "store_true", "help": "print JSON lines"}


def asked(
    argv: list[str] | None,
    description: str | None,
    known: Iterable[str],
    what: str = "section",
    usual: Iterable[str] | None = None,
    **flags: Mapping[str, Any],
) -> argparse.Namespace:
    """Return the options: `names` of what is asked for, or of what is `usual`, and the flags.

    Usual is all that is known if nothing is said of it. The flags are as `add_argument` takes them.
    """
    known = list(known)
    parser = argparse.ArgumentParser(description=(description or "").partition("\n")[0])
    parser.add_argument("names", nargs="*", metavar=what.upper(), help=", ".join(known))
    for name, flag in flags.items():
        parser.add_argument(f"--{name}", **flag)
    options = parser.parse_args(argv)
    unknown = set(options.names) - set(known)
    if unknown:
        parser.error(f"no {what} is called {min(unknown)}; there are {', '.join(known)}")
    options.names = options.names or list(usual or known)
    return options


def machine() -> str:
    """Say what the figures were measured on."""
    return (
        f"Python {platform.python_version()} on {platform.system()} {platform.machine()}, "
        f"{os.cpu_count()} processors"
    )


def show(name: str, section: Section, *, as_json: bool) -> None:
    """Print a section for people or for programs."""
    if as_json:
        print(json.dumps({"section": name, **asdict(section)}), flush=True)
        return
    print(f"\n{section.title}: {section.note}")
    for row in section.rows:
        print(f"  {row}")
    sys.stdout.flush()


def report(
    argv: list[str] | None, description: str | None, sections: Mapping[str, Callable[[], Section]]
) -> int:
    """Run the sections that are asked for, or all of them, and print each as it ends."""
    options = asked(argv, description, sections, json=JSON)
    print(json.dumps({"machine": machine()}) if options.json else machine())
    for name in options.names:
        show(name, sections[name](), as_json=options.json)
    return 0
