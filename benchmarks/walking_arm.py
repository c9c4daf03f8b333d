"""Print what the walking arm costs, in one run: `python benchmarks/walking_arm.py [--json]`.

Nothing here passes or fails. Times differ from one computer to the next and from one minute to
the next, so each stands beside a floor or a peer that was measured in turn with it.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import sys
from collections.abc import Callable, Mapping
from dataclasses import asdict

from killing import killing
from measuring import Section, own_home
from simulated_time import simulated_time
from solving import solving
from starting import starting
from wire import wire

SECTIONS: Mapping[str, Callable[[], Section]] = {
    "solving": solving,
    "wire": wire,
    "simulated_time": simulated_time,
    "starting": starting,
    "killing": killing,
}


def main(argv: list[str] | None = None) -> int:
    """Run the sections that are asked for, or all of them."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("sections", nargs="*", metavar="SECTION", help=", ".join(SECTIONS))
    parser.add_argument("--json", action="store_true", help="print JSON lines")
    options = parser.parse_args(argv)
    unknown = set(options.sections) - SECTIONS.keys()
    if unknown:
        parser.error(f"no section is called {min(unknown)}; there are {', '.join(SECTIONS)}")
    machine = (
        f"Python {platform.python_version()} on {platform.system()} {platform.machine()}, "
        f"{os.cpu_count()} processors"
    )
    print(json.dumps({"machine": machine}) if options.json else machine)
    with own_home():
        for name in options.sections or SECTIONS:
            show(name, SECTIONS[name](), as_json=options.json)
    return 0


def show(name: str, section: Section, *, as_json: bool) -> None:
    """Print a section for people or for programs."""
    if as_json:
        print(json.dumps({"section": name, **asdict(section)}), flush=True)
        return
    print(f"\n{section.title}: {section.note}")
    for row in section.rows:
        print(f"  {row}")
    sys.stdout.flush()


if __name__ == "__main__":
    sys.exit(main())
