"""Many poses at once, beside EAIK's batch and a copy of the same data."""

from __future__ import annotations

import time
from collections.abc import Callable
from statistics import median
from typing import Any

import numpy as np
from measuring import Row, Section, interleaved, ratio
from textbook_goals import SEED
from textbook_peers import Peers, eaik_robot

from kinematics import preset
from kinematics.batch import (
    branches_many,
    branches_of_frames,
    forward_many,
    frames_many,
    inverse_many,
)


def many(peers: Peers, poses: int = 1_000_000, rounds: int = 5) -> Section:
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
    taken = interleaved(cases, rounds)
    small, large = list(cases)[-2:]
    eaik_s = _eaik_batch(peers, frames[: min(poses, 20_000)])
    rows = []
    for name, seconds in taken.items():
        times = {}
        if name not in {small, large}:
            floor = large if "4x4" in name else small
            times[f"the {floor}"] = ratio(seconds, taken[floor])
            if eaik_s and "IK" in name:
                times["as fast as EAIK's batch"] = eaik_s * poses / median(seconds)
        rows.append(Row(name, median(seconds) / poses * 1e9, "ns a pose", times=times))
    if eaik_s:
        rows.append(Row("EAIK, IK_batched", eaik_s * 1e9, "ns a pose"))
    note = f"{poses} poses, medians of {rounds} interleaved rounds"
    return Section("Mini-mover, many poses at once", tuple(rows), note)


def _eaik_batch(peers: Peers, frames: Any) -> float | None:
    """Return EAIK's seconds a pose, the best of its numbers of threads; None without EAIK."""
    robot = eaik_robot(peers, preset("minimover5").arm)
    if robot is None:
        return None
    best = []
    for threads in (1, 2, 4):
        robot.IK_batched(frames, threads)
        began_s = time.perf_counter()
        robot.IK_batched(frames, threads)
        best.append((time.perf_counter() - began_s) / len(frames))
    return min(best)
