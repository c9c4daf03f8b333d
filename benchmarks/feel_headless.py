"""Keys for the whole desk on a headless terminal, in real time, and eyes on the physical arm."""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Iterator, Sequence
from random import Random

from feel import Figures
from feel_benches import DensePtyBench, chance, knows_lines
from feel_desk import TappingDesk, choose, set_up
from feel_keys import Press
from releasing import (
    NOTHING_COMES_S,
    Released,
    Seeing,
    at_home,
    figures,
    kinds,
    pressing,
    promised,
)
from textual import events

from armdrive.arm import Arm
from kinematics import Joints
from tui.startup import SCREENS

SIZE = (120, 40)


class Watcher:
    """A thread that looks at the physical arm until it has stood for a while."""

    def __init__(self, bench: DensePtyBench, until_s: float) -> None:
        self._bench, self._until_s = bench, until_s
        self.seeing = Seeing(bench)
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self) -> None:
        while not (self.seeing.quiet and time.monotonic() > self._until_s):
            self._bench.sleep(self._bench.look_s)
            self.seeing.take(self._bench.look())

    def wait(self) -> None:
        """Wait for its end."""
        self._thread.join()


async def press_once(
    bench: DensePtyBench, arm: Arm, home: Joints, luck: Random, way: Press
) -> Released:
    """Hold a key of a new desk, as a terminal tells of it, and watch the arm."""
    desk = TappingDesk(arm, screens=SCREENS, braille=False)
    async with desk.run_test(size=SIZE) as pilot:
        await pilot.pause()
        desk.watch_taps()
        set_up(desk)
        await asyncio.sleep(NOTHING_COMES_S)
        desk.jog.action_arm_keys()
        await asyncio.sleep(NOTHING_COMES_S)
        key = choose(desk, arm, home, luck, lines=knows_lines(bench))
        start_s = time.monotonic()
        lifted_s = start_s + way.lifted_s
        moments = [(start_s + each, False) for each in way.arrivals_s] + [(lifted_s, True)]
        watcher: Watcher | None = None
        last_s = max(each for each, _ in moments)
        for moment_s, lifts in sorted(moments):
            await asyncio.sleep(max(moment_s - time.monotonic(), 0.0))
            if lifts:
                promise = promised(arm)
                watcher = Watcher(bench, last_s + NOTHING_COMES_S)
            else:
                desk.post_message(events.Key(key, key))
        assert watcher is not None
        await asyncio.to_thread(watcher.wait)  # without keeping the desk waiting
        tapped = desk.tapped_s > lifted_s
    return watcher.seeing.released(promise, tapped=tapped)


def real(dialect: str, times: int, rates_hz: Sequence[int]) -> Iterator[Figures]:
    """Press so many keys of each kind, in real time over a pty."""
    with DensePtyBench(dialect) as bench:
        arm, home = at_home(bench)
        for what, rate_hz, stalls in kinds(rates_hz):
            luck = chance(dialect, what)
            draw = pressing(luck, rate_hz, stalls=stalls)
            found = [asyncio.run(press_once(bench, arm, home, luck, draw())) for _ in range(times)]
            yield from figures(dialect, what, found)
