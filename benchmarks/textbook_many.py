"""A million postures at once: where the tool comes, and a map of the reach, beside a plain copy."""

from __future__ import annotations

from collections.abc import Callable
from statistics import median

import numpy as np
from measuring import Row, Section, interleaved, ratio
from textbook_goals import SEED
from textbook_peers import Peers

from kinematics import preset, system
from kinematics.chains.many import reach_maps, tips_of_many
from kinematics.textbook.systems.mini_movers import MINI_MOVER, with_arm

COPY = "copy of three numbers a posture"


def many(_peers: Peers, postures: int = 1_000_000, rounds: int = 5) -> Section:
    """Measure whole arrays, of an arm of five axes and of one of six."""
    chains = {
        "TeachMover": with_arm(MINI_MOVER, preset("teachmover").arm).chain(),
        "Puma": system("puma").chain(),
    }
    cases: dict[str, Callable[[], object]] = {}
    for name, chain in chains.items():
        lows, highs = zip(*chain.limits, strict=True)
        shape = (postures, len(chain))
        values = np.asfortranarray(np.random.default_rng(SEED).uniform(lows, highs, shape))
        cases[f"{name}: FK to tips (tips_of_many)"] = lambda c=chain, v=values: tips_of_many(c, v)
        cases[f"{name}: two maps of the reach (reach_maps)"] = lambda c=chain: reach_maps(
            c, ((0, 2), (0, 1)), postures, 120
        )
    plain, copied = np.ones((postures, 3)), np.empty((postures, 3))
    cases[COPY] = lambda: np.copyto(copied, plain)
    taken = interleaved(cases, rounds)
    rows = []
    for name, seconds in taken.items():
        times = {} if name == COPY else {f"the {COPY}": ratio(seconds, taken[COPY])}
        rows.append(Row(name, median(seconds) / postures * 1e9, "ns a posture", times=times))
    note = f"{postures} postures, medians of {rounds} interleaved rounds"
    return Section("Many postures at once", tuple(rows), note)
