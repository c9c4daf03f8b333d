"""Joint motions from rest to rest: durations beside ruckig's, and what planning one takes."""

from __future__ import annotations

from collections.abc import Callable
from itertools import islice
from random import Random
from statistics import median
from typing import Any

from measuring import Row, Section, interleaved
from trajectories_peers import HARD_RAD_S2, joint_limits, missing, peer, postures

from kinematics import Joints, MotionLimits, timed

MOVES = 500
SEED = 20
ROUNDS = 20
STRAIGHT = 1e-6
"""The largest share by which a motion that is straight in the joints leaves its line."""

BUILD_UPS_S = (0.05, 0.2)


def moves() -> Section:
    """Compare random motions, with two build-up times and the motors' rates left out."""
    some = postures(Random(SEED))
    pairs = list(islice(zip(some, some, strict=False), MOVES))
    rows: list[Row] = []
    for jerk_s in BUILD_UPS_S:
        limits = joint_limits(jerk_s, motors=False)
        cases: dict[str, Callable[[], object]] = {
            "timed()": lambda limits=limits: [
                timed((a.angles_rad, b.angles_rad), limits).duration_s for a, b in pairs
            ]
        }
        name = f"{jerk_s:g} s to build up"
        if peer("ruckig") is not None:
            rows += ratios(name, pairs, limits)
            cases["ruckig"] = lambda limits=limits: [ruckig_s(a, b, limits)[0] for a, b in pairs]
        for case, seconds in interleaved(cases, ROUNDS).items():
            rows.append(Row(f"planning, {name}, {case}", median(seconds) / MOVES * 1e6, "us"))
    note = f"{MOVES} random motions, {HARD_RAD_S2:g} rad/s^2" + missing("ruckig")
    return Section("Motions of the joints, jerk-limited, from rest to rest", tuple(rows), note)


def ratios(name: str, pairs: list[tuple[Joints, Joints]], limits: MotionLimits) -> list[Row]:
    """Return the ratios of durations, by what ruckig kept straight, and along the straight way.

    Where the joint that takes longest has a profile that another joint cannot follow in
    proportion, ruckig gives up the straight way in silence and only ends all joints at once.
    """
    found: dict[str, list[float]] = {
        "kept straight by it": [],
        "let bend by it": [],
        "given to it as one joint": [],
    }
    kept, bent, one = found.values()
    for start, end in pairs:
        theirs_s, straight = ruckig_s(start, end, limits)
        own_s = timed((start.angles_rad, end.angles_rad), limits).duration_s
        (kept if straight else bent).append(own_s / theirs_s)
        one.append(own_s / ruckig_s(*along(start, end, limits))[0])
    rows = []
    for which, values in found.items():
        if values:
            ordered = sorted(values)
            what = f"{name}, {len(values)} {which}"
            rows += [
                Row(f"{what}: {word}", value, "x ruckig's duration")
                for word, value in (
                    ("least", ordered[0]),
                    ("median", median(ordered)),
                    ("most", ordered[-1]),
                )
            ]
    return rows


def along(start: Joints, end: Joints, limits: MotionLimits) -> tuple[Joints, Joints, MotionLimits]:
    """Return the straight way as one joint that turns by 1, under the limits along it."""
    turns = [abs(b - a) for a, b in zip(start, end, strict=True)]
    speed, hard = (
        min(limit / turn for limit, turn in zip(each, turns, strict=True) if turn)
        for each in (limits.speeds, limits.accelerations)
    )
    ends = Joints((0.0,), ("way",)), Joints((1.0,), ("way",))
    return *ends, MotionLimits((speed,), (hard,), limits.jerk_s)


def ruckig_s(start: Joints, end: Joints, limits: MotionLimits) -> tuple[float, bool]:
    """Return ruckig's duration with its phases synchronised, and whether it stayed straight."""
    ruckig: Any = peer("ruckig")
    count = len(limits.speeds)
    asked = ruckig.InputParameter(count)
    asked.synchronization = ruckig.Synchronization.Phase
    asked.current_position, asked.target_position = start.angles_rad, end.angles_rad
    asked.max_velocity, asked.max_acceleration = limits.speeds, limits.accelerations
    asked.max_jerk = [limit / limits.jerk_s for limit in limits.accelerations]
    way = ruckig.Trajectory(count)
    ruckig.Ruckig(count).calculate(asked, way)
    early = way.at_time(0.2 * way.duration)[0]
    shares = [
        (now - a) / (b - a)
        for now, a, b in zip(early, start, end, strict=True)
        if abs(b - a) > 1e-6
    ]
    return way.duration, max(shares) - min(shares) < STRAIGHT
