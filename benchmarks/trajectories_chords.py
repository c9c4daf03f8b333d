"""Straight lines of the tip, cut into chords: durations beside toppra's, and beside a finer cut.

toppra (Pham and Pham, TOPP-RA) is given a cubic spline through the corners of the finest cut, and
finds the least time under the same speeds and accelerations on a grid. `timed` takes what a bend
costs as if it always added up, so it may be slower, and has the directions of chords, not of a
spline, so it may be a little quicker where the cut is coarse.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from itertools import islice
from random import Random
from statistics import median
from typing import Any

import numpy as np
from measuring import Row, Section, interleaved
from trajectories_peers import HARD_RAD_S2, joint_limits, missing, model, peer, ways

from kinematics import Joints, KinematicsError, MotionLimits, Pose, line_path, timed

LINES = 40
SEED = 21
GRID = 400
TOLERANCES_MM = (0.5, 0.05, 0.005)
FINEST_MM = 0.0005
ROUNDS = 3

Corners = list[tuple[float, ...]]


def chords() -> Section:
    """Compare random lines at several tolerances of the cut."""
    limits = joint_limits(motors=False)
    found = list(islice(cuts(), LINES))
    finest = [timed(line[FINEST_MM], limits).duration_s for line in found]
    toppra = peer("toppra")
    best = [toppra_s(line[FINEST_MM], limits) for line in found] if toppra else finest
    beside = "toppra's duration" if toppra else "the finest cut's duration"
    rows = []
    for tolerance_mm in (*TOLERANCES_MM, FINEST_MM):
        corners = median(len(line[tolerance_mm]) for line in found)
        ratios = sorted(
            timed(line[tolerance_mm], limits).duration_s / least_s
            for line, least_s in zip(found, best, strict=True)
            if least_s
        )
        what = f"cut to {tolerance_mm:g} mm, {corners:g} corners"
        rows += [
            Row(f"{what}: {word}", value, f"x {beside}")
            for word, value in (
                ("least", ratios[0]),
                ("median", median(ratios)),
                ("most", ratios[-1]),
            )
        ]
    rows += planning(found, limits)
    note = f"{LINES} random lines, {HARD_RAD_S2:g} rad/s^2" + missing("toppra")
    return Section("Straight lines of the tip in chords", tuple(rows), note)


def planning(found: Sequence[dict[float, Corners]], limits: MotionLimits) -> list[Row]:
    """Measure what one line takes, of the coarsest cut and of the grid."""
    cases: dict[str, Callable[[], object]] = {
        "timed()": lambda: [timed(line[TOLERANCES_MM[0]], limits) for line in found]
    }
    if peer("toppra") is not None:
        cases["toppra"] = lambda: [toppra_s(line[TOLERANCES_MM[0]], limits) for line in found]
    taken = interleaved(cases, ROUNDS)
    return [
        Row(f"planning, {name}", median(seconds) / len(found) * 1e6, "us")
        for name, seconds in taken.items()
    ]


def cuts():  # an endless iterator of dicts from tolerance to corners
    """Yield lines at every tolerance."""
    for start, goal in ways(Random(SEED)):
        try:
            yield {mm: cut(start, goal, mm) for mm in (*TOLERANCES_MM, FINEST_MM)}
        except KinematicsError:
            continue


def cut(start: Joints, goal: Pose, tolerance_mm: float) -> Corners:
    """Return the corners of one line."""
    return [joints.angles_rad for joints in line_path(model().arm, start, goal, tolerance_mm)]


def toppra_s(corners: Corners, limits: MotionLimits) -> float | None:
    """Return the least time that toppra finds, None where it finds none."""
    toppra: Any = peer("toppra")
    constraint: Any = peer("toppra.constraint")
    algorithm: Any = peer("toppra.algorithm")
    logging.getLogger("toppra").setLevel(logging.CRITICAL)
    marks = timed(corners, MotionLimits(limits.speeds)).times_s
    path = toppra.SplineInterpolator(marks, np.array(corners))
    both = [
        np.array([[-limit, limit] for limit in each])
        for each in (limits.speeds, limits.accelerations)
    ]
    limiting = [
        constraint.JointVelocityConstraint(both[0]),
        constraint.JointAccelerationConstraint(both[1]),
    ]
    grid = np.linspace(0.0, marks[-1], GRID)
    solver = algorithm.TOPPRA(limiting, path, gridpoints=grid, solver_wrapper="seidel")
    found = solver.compute_trajectory()
    return None if found is None else float(found.duration)
