"""Many poses at once, beside EAIK's batch and a copy of the same data."""

from __future__ import annotations

from collections.abc import Callable
from statistics import median

import numpy as np
from measuring import Row, Section, interleaved, ratio
from textbook_goals import SEED
from textbook_peers import Peers, eaik_robot

from kinematics import preset
from kinematics.five_axis.batch import (
    branches_many,
    branches_of_frames,
    forward_many,
    frames_many,
    inverse_many,
)

EAIK = "EAIK, IK_batched with its own number of threads"
EAIK_POSES = 20_000
"""So many of the poses are enough of a slow peer."""


def many(peers: Peers, poses: int = 1_000_000, rounds: int = 7) -> Section:
    """Measure whole arrays; results go to arrays that exist, as the copies' do."""
    arm = preset("minimover5").arm
    low = [one.low_rad for one in arm.limits]
    high = [one.high_rad for one in arm.limits]
    postures = np.asfortranarray(np.random.default_rng(SEED).uniform(low, high, (poses, 5)))
    goals, frames = forward_many(arm, postures), frames_many(arm, postures)
    five, sixteen = np.empty_like(goals), np.empty_like(frames)
    twenty = np.moveaxis(np.zeros((4, 5, poses)), -1, 0)
    cases: dict[str, Callable[[], object]] = {
        "IK, one branch (inverse_many)": lambda: inverse_many(arm, goals, out=five),
        "IK, four branches of poses (branches_many)": lambda: branches_many(arm, goals, out=twenty),
        "IK, four branches of 4x4s (branches_of_frames)": lambda: branches_of_frames(
            arm, frames, out=twenty
        ),
        "FK to 4x4s (frames_many)": lambda: frames_many(arm, postures, out=sixteen),
        "FK to poses (forward_many)": lambda: forward_many(arm, postures, out=five),
        "copy of five numbers a pose": lambda: np.copyto(five, goals),
        "copy of sixteen numbers a pose": lambda: np.copyto(sixteen, frames),
    }
    small, large = list(cases)[-2:]
    some = min(poses, EAIK_POSES)
    robot = eaik_robot(peers, arm)
    if robot is not None:
        few = frames[:some]
        cases[EAIK] = lambda: robot.IK_batched(few)
    taken = interleaved(cases, rounds)
    peer_s = median(taken.pop(EAIK)) / some if robot is not None else None
    rows = []
    for name, seconds in taken.items():
        times = {}
        if name not in {small, large}:
            floor = large if "4x4" in name else small
            times[f"the {floor}"] = ratio(seconds, taken[floor])
            if peer_s and "IK" in name:
                times["as fast as EAIK's batch"] = peer_s * poses / median(seconds)
        rows.append(Row(name, median(seconds) / poses * 1e9, "ns a pose", times=times))
    if peer_s:
        rows.append(Row(EAIK, peer_s * 1e9, "ns a pose"))
    note = f"{poses} poses, medians of {rounds} interleaved rounds"
    return Section("Mini-mover, many poses at once", tuple(rows), note)
