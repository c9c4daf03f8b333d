"""Jog at full speed into every bound: `python benchmarks/jog_limits.py [DIALECT ...] [--quick]`.

On simulated time, from random postures, each simulated arm is jogged joint by joint into its soft
limits and along lines into the table, a wall, its own body and the edge of its reach, and past its
base axis where the base has to turn fast; then back. The physical arm is looked at: how many steps
before the bound it came to rest, how far it ever was beyond one, and how long the way back took to
begin, more than a jog takes anywhere on that device. Exit code 1 where a bound was passed by more
than a step, an arm went into error-stop, or the way back stalled for more than 0.2 s.

A step is one of every motor that turns the joint, or that moves the tip: rounding to whole steps
alone is up to half of it, and while motors move they are not all at the same one. "left" is how
many steps before the bound the arm stood, "at rest" and "moving" how many beyond it. A line that
grazes a limit for a while (a wrist that stands at 90 degrees but for a rounding) ends where
rounding puts its beginning, and one that leads through the base axis before it: those are the few
that end early.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from statistics import median

from feel import padded
from jog_bench import Ground, Outcome, trials
from measuring import asked, machine, own_home, p99

from armdrive.registry import DIALECTS
from armdrive.status import State

SEED = 1982
EACH, QUICK = 250, 20
LATER_S = 0.2
EARLY_STEPS = 3.0
HEAD = (
    "dialect", "into", "jogs", "left", "p99", "worst", "early", "at rest", "moving", "back",
    "worst", "stall", "errors",
)  # fmt: skip
WIDTHS = (12, 16, 6, 8, 8, 9, 7, 9, 9, 9, 9, 9, 7)


def kind_of(one: Outcome) -> str:
    """Return what ended a jog: a limit, a guard, the reach, or nothing within the time."""
    if one.what == "over the base":
        return str(one.what)
    if one.left_steps is None:
        return "(not reached)"
    if "stopped at the limit" in one.ended:
        return "joint limits"
    if "beyond its limit" in one.ended:
        return "limits of lines"
    return "reach" if "span" in one.ended else "guards"


def line(dialect: str, kind: str, found: Sequence[Outcome], ordinary: tuple[float, float]) -> str:
    """Return a row: steps and ms."""
    lefts = [one.left_steps for one in found if one.left_steps is not None] or [0.0]
    backs = [one.back_s - ordinary[0] for one in found]
    stall_s = max(one.stall_s for one in found) - ordinary[1]
    early = sum(left > EARLY_STEPS for left in lefts)
    errors = sum(one.state is State.ERROR_STOP for one in found)
    cells = (
        dialect,
        kind,
        str(len(found)),
        f"{median(lefts):.1f}",
        f"{p99(lefts):.1f}",
        f"{max(lefts):.1f}",
        str(early),
        f"{max(one.rest_steps for one in found):.2f}",
        f"{max(one.over_steps for one in found):.2f}",
        f"{1e3 * median(backs):.0f} ms",
        f"{1e3 * max(backs):.0f} ms",
        f"{1e3 * max(stall_s, 0.0):.0f} ms",
        str(errors),
    )
    return padded(cells, WIDTHS)


def measure(dialect: str, count: int, seed: int) -> bool:
    """Jog one arm, print what came of it, and tell whether all of it was as promised."""
    ground = Ground(dialect, seed)
    begins_s, stands_s = ground.begins_s, ground.stands_s
    print(
        f"{dialect}: a jog begins {1e3 * begins_s:.0f} ms after it is asked for, stands for up to "
        f"{1e3 * stands_s:.0f} ms between two bursts, and makes {ground.share:.0%} of full speed"
    )
    found = list(trials(dialect, seed, count))
    for kind in sorted({kind_of(one) for one in found}):
        rows = [one for one in found if kind_of(one) == kind]
        print(line(dialect, kind, rows, (begins_s, stands_s)), flush=True)
    print(line(dialect, "all", found, (begins_s, stands_s)), flush=True)
    bad = [
        one
        for one in found
        if not one.kept or one.back_s > begins_s + LATER_S or one.stall_s > stands_s + LATER_S
    ]
    for one in bad:
        print("  NOT AS PROMISED:", one)
    return not bad


def main(argv: list[str] | None = None) -> int:
    """Jog the arms that are asked for, or all of them."""
    options = asked(
        argv,
        __doc__,
        DIALECTS,
        "dialect",
        quick={"action": "store_true", "help": f"{QUICK} jogs of each, not {EACH}"},
        count={"type": int, "help": "how many jogs of each"},
        seed={"type": int, "default": SEED},
    )
    count = options.count or (QUICK if options.quick else EACH)
    print(machine(), padded(HEAD, WIDTHS), sep="\n")
    with own_home():
        kept = [measure(each, count, options.seed) for each in options.names]
    return 0 if all(kept) else 1


if __name__ == "__main__":
    sys.exit(main())
