"""Print what the desk costs and how quick it is, on a pseudo-terminal: `python benchmarks/desk.py`.

Everything stands beside its floor: a bare interpreter, an app of the framework that shows one word.
Bytes are those that the terminal gets. The processor's time is that of the whole program of the
desk, its driver with it; the simulated arm is another process, except where the command is timed as
people give it.
"""

from __future__ import annotations

import contextlib
import queue
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from desk_child import SHOWN
from desk_ends import KEYS, held
from desk_terminal import CHILD, LinedTerminal, Terminal, desk_of, instructed
from measuring import Row, Section, command, interleaved, own_home, report, timing
from sim_process import SimProcess

from tui.app import POLL_S

PAUSE_S, FLOOR_PAUSE_S = 0.6, 0.05
PATIENCE_S = 10.0


# -- from the command to the first picture -------------------------------------------------------


def _first_paint(words: list[str]) -> Callable[[], object]:
    def start() -> None:
        with Terminal(words) as terminal:
            terminal.shown_s()
            terminal.process.kill()  # how it ends is not what is timed

    return start


def starting(rounds: int = 10) -> Section:
    """Start each in turn."""
    bare = "a bare interpreter says a word"
    floor = "a bare app of the framework"
    ours = "armdrive jog --sim teachmover"
    with own_home():
        instructed()
        taken = interleaved(
            {
                bare: _first_paint([sys.executable, "-c", f"print('{SHOWN}')\ninput()"]),
                floor: _first_paint([sys.executable, str(CHILD), "-1", "bare"]),
                ours: _first_paint([*command(), "jog", "--sim", "teachmover"]),
            },
            rounds,
        )
    rows = (
        timing(bare, taken[bare]),
        timing(floor, taken[floor], beside={bare: taken[bare]}),
        timing(ours, taken[ours], beside={bare: taken[bare], floor: taken[floor]}),
    )
    return Section("From the command to the first picture", rows, f"{rounds} starts each, in turn")


# -- from a key to the wire ----------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Write:
    """A write of the driver's that answers a key: how it begins, and the key."""

    what: str
    dialect: str
    key: bytes
    begins: tuple[str, ...]
    in_jog: bool = False
    """Whether a jog is held when the key is pressed."""


FLOOR = Write("a key to its handler in a bare app, the floor", "", b"q", ())
WRITES = (
    Write("jog key to the first byte, teachmover", "teachmover", b"q", ("@",)),
    Write("jog key to @STEP, teachmover", "teachmover", b"q", ("@STEP",)),
    Write("jog key to $J=, grbl", "grbl", b"q", ("$J=",)),
    Write("space in mid-jog to its stop, grbl", "grbl", b" ", ("!", "\x85"), in_jog=True),
)


def _written_s(terminal: LinedTerminal, write: Write) -> float:
    """Press a key, and return how long it took until its bytes had left."""
    with contextlib.suppress(queue.Empty):
        while True:
            terminal.writes.get_nowait()
    pressed_s = time.monotonic()
    terminal.type(write.key)
    while True:
        told = terminal.writes.get(timeout=PATIENCE_S)
        if not write.begins or told["head"].startswith(write.begins):
            return float(told["wrote_s"]) - pressed_s


def _answered(write: Write, folder: Path, count: int) -> Iterator[float]:
    """Press a key of the desk again and again, while the arm stands or is jogged."""
    with (
        SimProcess(folder / write.dialect, write.dialect) as sim,
        desk_of(sim.port, write.dialect, sim.state()["motors"]) as desk,
    ):
        for index in range(count):
            desk.arm_keys()
            time.sleep(PAUSE_S)
            key = KEYS[index % 2]
            if not write.in_jog:
                yield _written_s(desk, replace(write, key=key))
                continue
            with held(desk, key) as finger:
                sim.wait_until_moving()
                time.sleep(PAUSE_S)
                finger.lift()
                yield _written_s(desk, write)
            sim.rest_after_s(time.monotonic())


def _floor(count: int) -> Iterator[float]:
    """Press a key of an app that does nothing but tell of it."""
    with LinedTerminal("bare") as terminal:
        terminal.shown_s()
        for _ in range(count):
            time.sleep(FLOOR_PAUSE_S)
            yield _written_s(terminal, FLOOR)


def keys(count: int = 60) -> Section:
    """Press keys; how long until the bytes that they cause have left."""
    floor = list(_floor(count))
    rows = [timing(FLOOR.what, floor)]
    with own_home() as folder:
        for write in WRITES:
            taken = list(_answered(write, folder, count))
            rows.append(timing(write.what, taken, beside={"the floor": floor}))
    note = f"{count} times each; from the key at the terminal to the return of our write"
    return Section("From a key to the wire", tuple(rows), note)


# -- at rest and in motion ------------------------------------------------------------------------

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


SECTIONS = {"starting": starting, "keys": keys, "painting": painting}


def main(argv: list[str] | None = None) -> int:
    """Measure every part, or those that are asked for."""
    return report(argv, __doc__, SECTIONS)


if __name__ == "__main__":
    sys.exit(main())
