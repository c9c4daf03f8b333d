"""Kill a driving program anywhere in a move: `python benchmarks/kill_everywhere.py [DIALECT ...]`.

A simulated arm in a process of its own stands at a pty; a second process drives it and is killed
by SIGKILL before every operation on the disk, at writes to the wire and parts of them, and at
random moments; then this one connects, and compares what it believes with where the motors
physically stand. Exit code 1 where anything was believed that is not so.
"""

from __future__ import annotations

import random
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from measuring import asked, machine, own_home

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "armdrive"))
from killing_ground import Found, KillingGround

from armdrive.registry import DIALECTS
from armdrive.status import Trust

SEED = 1982
OPERATIONS = 28
"""On the disk: a mark, its clearing, another mark, and the end, of seven operations each."""

WRITES = 16
"""To the wire, or more, in two moves."""

MOVE_DEG = 15.0
WHOLE_S = 3.0
"""Two moves and the rest between, roughly; a late kill may come after the end."""

REST_S = 0.5
"""The mark is cleared after so long here, so that a hundred kills end within minutes."""


def orders(times: int) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield what is to be killed where: by kind, and so many in all, or all the disk's."""
    chance = random.Random(SEED)
    for operation in range(min(OPERATIONS, times)):
        yield "before an operation on the disk", {"disk": operation}
    for index in range(max(times - OPERATIONS, 0)):
        if index % 2:
            yield "at a random moment", {"after_s": round(chance.uniform(0.0, WHOLE_S), 3)}
        else:
            order = {"wire": chance.randrange(WRITES), "bytes": chance.randrange(24)}
            yield "in a write to the wire", order


def line(dialect: str, kind: str, found: list[Found]) -> str:
    """Return a row of the table."""
    counts = [sum(each.trust is trust for each in found) for trust in Trust]
    killed = sum(each.killed for each in found)
    wrong = sum(each.wrong for each in found)
    return f"{dialect:<12}{kind:<34}{killed:>8}" + "".join(
        f"{count:>12}" for count in (*counts, wrong)
    )


def main(argv: list[str] | None = None) -> int:
    """Kill on every dialect that is asked for."""
    times = {"type": int, "default": 100, "help": "how many kills of each dialect"}
    options = asked(argv, __doc__, DIALECTS, "dialect", ["teachmover"], times=times)
    heads = ("killed", *(trust.value for trust in Trust), "WRONG")
    print(
        machine(), f"{'':<46}{heads[0]:>8}" + "".join(f"{head:>12}" for head in heads[1:]), sep="\n"
    )
    wrong: list[Found] = []
    for dialect in options.names:
        wrong += killed_everywhere(dialect, options.times)
    for each in wrong:
        print(f"WRONG: {each}")
    return 1 if wrong else 0


def killed_everywhere(dialect: str, times: int) -> list[Found]:
    """Kill, print what was found, and return what was wrong."""
    kinds: dict[str, list[Found]] = {}
    with (
        own_home(),
        tempfile.TemporaryDirectory() as folder,
        KillingGround(Path(folder), dialect) as ground,
    ):
        for kind, order in orders(times):
            kinds.setdefault(kind, []).append(
                ground.kill(**order, still_s=REST_S, move_deg=MOVE_DEG)
            )
    for kind, found in kinds.items():
        print(line(dialect, kind, found), flush=True)
    return [each for found in kinds.values() for each in found if each.wrong]


if __name__ == "__main__":
    sys.exit(main())
