"""What the desk takes of the processor, and sends to its terminal, at rest and in motion."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from desk_terminal import LinedTerminal, desk_of
from measuring import Row, Section, own_home
from sim_process import SimProcess

sys.path.insert(0, str(Path(__file__).parents[1]))
from tui.desk import POLL_S

DIALECT = "teachmover"
SIZES = ((80, 24), (120, 40), (200, 60))
OWN_HZ = 1.0 / POLL_S
RATE_HZ = 30.0
"""The desk looks at its arm `OWN_HZ` times a second; this often is what its picture is made for."""

SETTLED_S = 1.5
LASTS_S = 8.0


@dataclass(frozen=True, slots=True)
class Spent:
    """What a program took for a while."""

    percent: float
    kib_s: float
    shown_hz: float


def _spent(terminal: LinedTerminal, lasts_s: float, *, polls: bool = True) -> Spent:
    """Let a program be, and return what it took."""

    def polled() -> int:
        return int(terminal.ask("look")["polls"]) if polls else 0

    shown, painted, before = polled(), terminal.painted, terminal.ask("spent")
    time.sleep(lasts_s)
    after, painted, shown = terminal.ask("spent"), terminal.painted - painted, polled() - shown
    took_s = after["now_s"] - before["now_s"]
    used_s = after["cpu_s"] - before["cpu_s"]
    return Spent(100.0 * used_s / took_s, painted / 1024.0 / took_s, shown / took_s)


def _in_motion(desk: LinedTerminal, sim: SimProcess, lasts_s: float) -> Spent:
    """Have the arm swing for so long; it has to be moving when that begins and when it ends."""
    desk.ask("sweep")
    sim.wait_until_moving()
    spent = _spent(desk, lasts_s)
    sim.wait_until_moving()
    return spent


def _of_size(folder: Path, size: tuple[int, int], lasts_s: float) -> Iterator[tuple[str, Spent]]:
    """Measure the floor and the desk of one size."""
    with LinedTerminal("bare", str(RATE_HZ), size=size) as terminal:
        terminal.shown_s()
        time.sleep(SETTLED_S)
        yield (
            f"the floor, woken {RATE_HZ:.0f} times a second",
            _spent(terminal, lasts_s, polls=False),
        )
    for rate_hz in (OWN_HZ, RATE_HZ):
        with (
            SimProcess(folder / "arm", DIALECT) as sim,
            desk_of(sim.port, DIALECT, sim.state()["motors"], size=size, rate_hz=rate_hz) as desk,
        ):
            time.sleep(SETTLED_S)
            yield f"at rest, {rate_hz:.0f} looks a second", _spent(desk, lasts_s)
            yield f"in motion, {rate_hz:.0f} looks a second", _in_motion(desk, sim, lasts_s)


def painting(lasts_s: float = LASTS_S, sizes: Sequence[tuple[int, int]] = SIZES) -> Section:
    """Measure each size: processor and bytes."""
    rows: list[Row] = []
    with own_home() as folder:
        for width, height in sizes:
            floor = 0.0
            for what, spent in _of_size(folder, (width, height), lasts_s):
                shown = f" ({spent.shown_hz:.0f} shown)" if spent.shown_hz else ""
                name = f"{width}x{height}, {what}{shown}"
                times = {"the floor": spent.percent / floor} if floor else {}
                floor = floor or spent.percent
                rows += [Row(name, spent.percent, "% of a core", times=times)]
                rows += [Row("  to the terminal", spent.kib_s, "KiB/s")]
    note = f"{lasts_s:g} s each; the whole program of the desk, a {DIALECT} in another process"
    return Section("At rest and in motion", tuple(rows), note)
