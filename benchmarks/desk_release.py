"""Print how long an arm goes on when a key of the real desk is let go, on a real terminal.

`python benchmarks/desk_release.py`: the whole desk on a pseudo-terminal, in a process of its own;
its arm, a twin, in another; the keys of releasing.py, as a terminal brings them, at full speed by
joints, and by the tip with the fastest keyboard. A keyboard of 11, 25 or 33 repeats a second on a
link with 60 ms of jitter; the same on one that loses one repeat in five, and on one that stalls for
a second and then delivers everything at once. Time, way and bound are as releasing.py has them.
Exit code 1 where a bound is broken.
"""

from __future__ import annotations

import itertools
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from random import Random

from desk_terminal import LinedTerminal, desk_of
from feel import Figures, Options, report
from feel_benches import DensePtyBench, chance
from feel_headless import Watcher
from feel_keys import JITTER_S, RATES_HZ, Press, press
from releasing import NOTHING_COMES_S, Promise, Released, figures

TIMES, QUICK_TIMES = 12, 1
LOST = 0.2
"""The share of repeats that a bad link loses."""

KEYS = (b"q", b"w", b"a", b"s")
"""Base and shoulder, there and back."""

TIP_KEYS = (b"w", b"e", b"s", b"d")
"""In Cartesian mode: along y and z, there and back."""

OTHER_MODE = b"m"
TIP_MODE = "CARTESIAN"
"""The desk shows this word then."""


def losing(luck: Random, way: Press) -> Press:
    """Lose some repeats, and never the first touch: without that there is no press."""
    first, *others = way.arrivals_s
    return replace(way, arrivals_s=(first, *(each for each in others if luck.random() >= LOST)))


LINKS: dict[str, Callable[[Random, float], Press]] = {
    "": press,
    ", repeats are lost": lambda luck, rate_hz: losing(luck, press(luck, rate_hz)),
    ", the link stalls": lambda luck, rate_hz: press(luck, rate_hz, stalls=True),
}
"""What the link does, in words, and a press on it."""


def press_once(bench: DensePtyBench, desk: LinedTerminal, key: bytes, way: Press) -> Released:
    """Hold a key as the link brings it, and watch the arm from when the finger lifts."""
    time.sleep(NOTHING_COMES_S)
    desk.arm_keys()
    time.sleep(NOTHING_COMES_S)
    stood = bench.look().motors
    start_s = time.monotonic()
    last_s = start_s + max(way.lifted_s, way.arrivals_s[-1])
    moments = [(start_s + each, False) for each in way.arrivals_s]
    lifted_s = start_s + way.lifted_s
    for moment_s, lifts in sorted([*moments, (lifted_s, True)]):
        time.sleep(max(moment_s - time.monotonic(), 0.0))
        if lifts:
            watcher = Watcher(bench, last_s + NOTHING_COMES_S)
            promise = Promise(**desk.ask("look")["promise"])
        else:
            desk.type(key)
    watcher.wait()
    if bench.look().motors == stood:
        raise RuntimeError(f"the key moved nothing: {desk.ask('look')}")
    tapped = desk.ask("look")["tapped_s"] > lifted_s
    return watcher.seeing.released(promise, tapped=tapped)


def measure(options: Options, dialect: str) -> Iterator[Figures]:
    """Press keys of one desk, on every keyboard and link."""
    rates_hz = RATES_HZ[-1:] if options.quick else RATES_HZ
    with (
        DensePtyBench(dialect) as bench,
        desk_of(bench.port, dialect, bench.look().motors) as desk,
    ):
        yield from pressed(bench, desk, options, rates_hz, KEYS)
        desk.type(OTHER_MODE)
        desk.shown_s(TIP_MODE)
        yield from pressed(bench, desk, options, rates_hz[-1:], TIP_KEYS, "the tip, ")


def pressed(
    bench: DensePtyBench,
    desk: LinedTerminal,
    options: Options,
    rates_hz: Sequence[float],
    keys: Sequence[bytes],
    by: str = "",
) -> Iterator[Figures]:
    """Press these keys on every link; `by` says in words what they move."""
    each = itertools.cycle(keys)  # never twice the same way, which would end at a limit
    for words, draw in LINKS.items():
        for rate_hz in rates_hz:
            what = f"{by}{rate_hz} Hz, {JITTER_S * 1e3:.0f} ms of jitter{words}"
            luck = chance("desk release", bench.row.name, what)
            found = [
                press_once(bench, desk, next(each), draw(luck, rate_hz))
                for _ in range(options.times)
            ]
            yield from figures(bench.row.name, what, found)


def main(argv: list[str] | None = None) -> int:
    """Measure every dialect, or those that are asked for."""
    return report(argv, __doc__, measure, times=TIMES, quick_times=QUICK_TIMES)


if __name__ == "__main__":
    sys.exit(main())
