"""Print how fast and how true the textbook's solvers are: `python benchmarks/textbook.py`.

All cases of a section are measured in turn in one process, so that what disturbs the computer
disturbs all alike; ratios are what to read. Other people's solvers come with the extra
(`pip install "armdrive[bench]"`); one that is missing is named and left out. Nothing here passes
or fails.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Mapping

from measuring import Section
from reporting import JSON, asked, machine, show
from textbook_arms import closed_forms, general_arms
from textbook_many import many
from textbook_one import forward, minimover_inverse, puma_inverse
from textbook_peers import Peers
from textbook_truth import truth

SECTIONS: Mapping[str, Callable[[Peers], Section]] = {
    "minimover": minimover_inverse,
    "puma": puma_inverse,
    "arms": closed_forms,
    "general": general_arms,
    "forward": forward,
    "many": many,
    "truth": truth,
}


def main(argv: list[str] | None = None) -> int:
    """Run the sections that are asked for, or all of them."""
    options = asked(argv, __doc__, SECTIONS, json=JSON)
    peers = Peers()
    if options.json:
        print(json.dumps({"machine": machine(), "missing": peers.missing}))
    else:
        print(machine())
        if peers.missing:
            print(f"not installed, and left out: {', '.join(peers.missing)}")
    for name in options.names:
        show(name, SECTIONS[name](peers), as_json=options.json)
    return 0


if __name__ == "__main__":
    sys.exit(main())
