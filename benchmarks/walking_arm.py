"""Print what the walking arm costs, in one run: `python benchmarks/walking_arm.py [--json]`.

Nothing here passes or fails. Times differ from one computer to the next and from one minute to
the next, so each stands beside a floor or a peer that was measured in turn with it.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Mapping

from killing import killing
from measuring import Section, own_home
from reporting import asked, machine, show
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
    options = asked(argv, __doc__, SECTIONS)
    print(json.dumps({"machine": machine()}) if options.json else machine())
    with own_home():
        for name in options.sections:
            show(name, SECTIONS[name](), as_json=options.json)
    return 0


if __name__ == "__main__":
    sys.exit(main())
