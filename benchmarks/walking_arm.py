"""Print what the walking arm costs, in one run: `python benchmarks/walking_arm.py [--json]`.

Nothing here passes or fails. Times differ from one computer to the next and from one minute to
the next, so each stands beside a floor or a peer that was measured in turn with it.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping

from killing import killing
from measuring import Section, own_home
from reporting import report
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
    with own_home():
        return report(argv, __doc__, SECTIONS)


if __name__ == "__main__":
    sys.exit(main())
