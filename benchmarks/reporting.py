"""How a benchmark is called and how it prints: the same for all of them."""

import argparse
import json
import os
import platform
import sys
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict

from measuring import Section


def asked(argv: list[str] | None, description: str | None, sections: Iterable[str]):
    """Return the options: the sections that are asked for, or all of them, and `--json`."""
    known = list(sections)
    parser = argparse.ArgumentParser(description=(description or "").partition("\n")[0])
    parser.add_argument("sections", nargs="*", metavar="SECTION", help=", ".join(known))
    parser.add_argument("--json", action="store_true", help="print JSON lines")
    options = parser.parse_args(argv)
    unknown = set(options.sections) - set(known)
    if unknown:
        parser.error(f"no section is called {min(unknown)}; there are {', '.join(known)}")
    options.sections = options.sections or known
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
    options = asked(argv, description, sections)
    print(json.dumps({"machine": machine()}) if options.json else machine())
    for name in options.sections:
        show(name, sections[name](), as_json=options.json)
    return 0
