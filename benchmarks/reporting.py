"""How a benchmark is called and how it prints: the same for all of them."""

import argparse
import json
import os
import platform
import sys
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict
from typing import Any

from measuring import Section

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
