"""Print how fast and how true the textbook's solvers are: `python benchmarks/textbook.py`.

All cases of a section are measured in turn in one process, so that what disturbs the computer
disturbs all alike; ratios are what to read. Other people's solvers come with the extra
(`pip install "armdrive[bench]"`); one that is missing is named and left out. Nothing here passes
or fails.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import sys
from collections.abc import Callable, Mapping
from dataclasses import asdict

from measuring import Section
from textbook_many import many
from textbook_one import forward, minimover_inverse, puma_inverse
from textbook_peers import Peers
from textbook_truth import truth

SECTIONS: Mapping[str, Callable[[Peers], Section]] = {
    "minimover": minimover_inverse,
    "puma": puma_inverse,
    "forward": forward,
    "many": many,
    "truth": truth,
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
    peers = Peers()
    machine = (
        f"Python {platform.python_version()} on {platform.system()} {platform.machine()}, "
        f"{os.cpu_count()} processors"
    )
    if options.json:
        print(json.dumps({"machine": machine, "missing": peers.missing}))
    else:
        print(machine)
        if peers.missing:
            print(f"not installed, and left out: {', '.join(peers.missing)}")
    for name in options.sections or SECTIONS:
        show(name, SECTIONS[name](peers), as_json=options.json)
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
