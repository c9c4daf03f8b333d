"""Arms of link tables: closed forms by structure, jogs, and arms that have none, beside the peers.

A peer solves frames of its own model of the same arm, made beforehand. EAIK's solve is bare: all
branches, no limits, nothing checked. The Robotics Toolbox's `ik_LM` finds one posture and starts
again as often as it needs.
"""

from __future__ import annotations

import importlib
import itertools
import math
import random
import time
from collections.abc import Callable
from dataclasses import replace
from statistics import mean, median
from typing import Any

import numpy as np
from measuring import Row, Section, each, interleaved, ratio
from textbook_goals import SEED
from textbook_peers import Peers, in_metres

from kinematics import Chain, DHLink, Pose, frame_goal, solve_goal
from kinematics.chains.arm import ChainArm
from kinematics.chains.closed_form import closed_form
from kinematics.chains.generated import generated
from kinematics.chains.structure import axes_of
from kinematics.frames.transforms import position_of
from kinematics.frames.vectors import subtract

QUARTER = math.pi / 2.0
WIDE = math.radians(170.0)
JOG_MM = 1.0
ENOUGH = 10_000
"""Starts that `ik_LM` may make: more than any goal here needs."""

ARMS = {
    "Puma 560": (
        (0, 0, 0, QUARTER), (0, 0, 431.8, 0), (0, 150.05, 20.3, -QUARTER),
        (0, 431.8, 0, QUARTER), (0, 0, 0, -QUARTER), (0, 56.25, 0, 0),
    ),
    "KUKA KR 6": (
        (0, 400, 25, -QUARTER), (0, 0, 455, 0), (-QUARTER, 0, 35, -QUARTER),
        (0, 420, 0, QUARTER), (0, 0, 0, -QUARTER), (math.pi, 80, 0, 0),
    ),
    "AR4": (
        (0, 169.77, 64.2, -QUARTER), (-QUARTER, 0, 305, 0), (math.pi, 0, 0, QUARTER),
        (0, 222.63, 0, -QUARTER), (0, 0, 0, QUARTER), (math.pi, 36.25, 0, 0),
    ),
    "UR5": (
        (0, 89.159, 0, QUARTER), (0, 0, -425, 0), (0, 0, -392.25, 0),
        (0, 109.15, 0, QUARTER), (0, 94.65, 0, -QUARTER), (0, 82.3, 0, 0),
    ),
    "SCORBOT": (
        (0, 349, 16, -QUARTER), (0, 0, 221, 0), (0, 0, 221, 0), (-QUARTER, 0, 0, -QUARTER),
        (0, 145, 0, 0),
    ),
}  # fmt: skip
"""Link tables: rows of theta, d, a and alpha."""

Cases = dict[str, Callable[[], object]]


def closed_forms(peers: Peers, poses: int = 100, rounds: int = 15) -> Section:
    """Solve frames of each arm: bare, within limits, as a jog does, and by the peers."""
    rows: list[Row] = []
    for name, table in ARMS.items():
        links = tuple(DHLink(*row, low=-WIDE, high=WIDE) for row in table)
        rows += _closed_rows(peers, name, Chain(links), poses, rounds)
    return Section(
        "Arms of link tables, IK of one pose by their structure",
        tuple(rows),
        f"{poses} poses, medians of {rounds} interleaved rounds",
    )


def _closed_rows(peers: Peers, name: str, chain: Chain, poses: int, rounds: int) -> list[Row]:
    arm, closed = ChainArm(chain), closed_form(chain)
    if closed is None:
        raise AssertionError(f"{name} has a closed form")
    postures = _postures(len(chain), poses, WIDE)
    goals = [frame_goal(generated(chain).fk(one)) for one in postures]
    jogs = [(_moved(arm.fk(arm.joints_of(one))), arm.joints_of(one)) for one in postures]
    find, seed = closed.solver.frames, (0.1,) * len(chain)
    cases: Cases = {
        f"{name}: all branches": each(lambda goal: find(goal.frame, seed), goals),
        f"{name}: the nearest within limits, checked": each(
            lambda goal: closed.nearest(goal, seed), goals
        ),
        f"{name}: a jog cycle, from pose to joints": each(lambda jog: arm.solve_near(*jog), jogs),
    }
    ours = list(cases)
    eaik = _eaik(peers, chain)
    if eaik is not None:
        frames = [eaik.fwdKin(np.array(one)) for one in postures]
        cases[f"{name}: EAIK, all branches"] = each(eaik.IK, frames)
    robot = _toolbox(peers, chain)
    if robot is not None:
        metres = [in_metres(one.frame) for one in goals]
        cases[f"{name}: Robotics Toolbox ik_LM"] = each(
            lambda goal: robot.ik_LM(goal, slimit=ENOUGH), metres
        )
    taken = interleaved(cases, rounds)
    return [
        Row(
            case,
            median(seconds) / poses * 1e6,
            "us",
            times={
                f"as fast as {other.partition(': ')[2]}": ratio(taken[other], seconds)
                for other in cases
                if case in ours and other not in ours
            },
        )
        for case, seconds in taken.items()
    ]


def _postures(joints: int, count: int, most: float) -> list[tuple[float, ...]]:
    chance = random.Random(SEED)
    return [tuple(chance.uniform(-most, most) for _ in range(joints)) for _ in range(count)]


def _moved(pose: Pose) -> Pose:
    return replace(pose, z_mm=pose.z_mm + JOG_MM)


def _eaik(peers: Peers, chain: Chain) -> Any:
    """Return EAIK's model of a chain in mm by its axes, or None."""
    if peers.get("eaik") is None:
        return None
    axes = axes_of(chain, chain.zero)
    points = [(0.0, 0.0, 0.0), *map(position_of, axes.frames), position_of(axes.hand)]
    ways = [subtract(after, before) for before, after in itertools.pairwise(points)]
    directions = [(frame[0][2], frame[1][2], frame[2][2]) for frame in axes.frames]
    return importlib.import_module("eaik.IK_HP").HPRobot(np.array(directions), np.array(ways))


def _toolbox(peers: Peers, chain: Chain) -> Any:
    """Return the Robotics Toolbox's model of a chain in m, or None."""
    rtb = peers.get("roboticstoolbox")
    if rtb is None:
        return None
    links = [
        rtb.RevoluteDH(
            d=link.d_mm / 1000.0, a=link.a_mm / 1000.0, alpha=link.alpha_rad, offset=link.theta_rad
        )
        for link in chain.links
    ]
    return rtb.DHRobot(links).ets()


def general_arms(peers: Peers, arms: int = 10, poses: int = 200) -> Section:
    """Solve poses of random arms of six joints, whose axes neither meet nor are parallel."""
    times: dict[str, list[float]] = {}
    found: dict[str, int] = {}
    for number in range(arms):
        chain = _random_chain(number)
        goals = [frame_goal(generated(chain).fk(one)) for one in _postures(6, poses, math.pi)]
        solvers: dict[str, tuple[Callable[[Any], bool], list[Any]]] = {
            "ours": (lambda goal, chain=chain: solve_goal(chain, goal).ok, goals)
        }
        robot = _toolbox(peers, chain)
        if robot is not None:
            metres = [in_metres(one.frame) for one in goals]
            solvers["Robotics Toolbox ik_LM"] = (
                lambda goal, robot=robot: bool(robot.ik_LM(goal, slimit=ENOUGH).success),
                metres,
            )
        for name, (solve, asked) in solvers.items():
            for goal in asked:
                began_s = time.perf_counter()
                met = solve(goal)
                times.setdefault(name, []).append(time.perf_counter() - began_s)
                found[name] = found.get(name, 0) + met
    rows = [
        Row(
            f"{name}: {found[name]} of {arms * poses} found",
            mean(seconds) * 1e6,
            "us on average",
            times={
                f"the time of {other}": mean(seconds) / mean(times[other])
                for other in times
                if name == "ours" and other != name
            },
        )
        for name, seconds in times.items()
    ]
    note = f"{arms} random arms of six joints, {poses} reachable poses each"
    return Section("Arms without a closed form, IK of one pose", tuple(rows), note)


def _random_chain(number: int) -> Chain:
    chance = random.Random(number)
    return Chain(
        tuple(
            DHLink(
                0.0,
                chance.uniform(-200.0, 200.0),
                chance.uniform(50.0, 400.0),
                chance.uniform(-2.0, 2.0),
                low=-math.pi,
                high=math.pi,
            )
            for _ in range(6)
        )
    )
