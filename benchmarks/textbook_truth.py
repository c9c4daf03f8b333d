"""Answers that are wrong and not flagged, over goals of every kind, ours beside the peers'.

An answer is wrong when its own hand frame, by the product of the arm's matrices, is farther than
a tenth of a millimetre or a tenth of a degree from the goal: well below one motor step. Where a
solver offers several answers, one wrong among them makes the goal's count. A goal that has a
posture within the limits and gets no answer is missed, which is not wrong; limits that a peer
does not know are not held against it.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from measuring import Row, Section
from textbook_goals import GoalSet, goal_sets
from textbook_peers import START, Peers, solvers

from kinematics import FiveAxisArm, preset
from kinematics.five_axis.closed_form import Angles
from kinematics.frames.transforms import Transform
from kinematics.textbook.systems.mini_movers import MINI_MOVER, with_arm

NEAR_MM = 0.1
NEAR_RAD = math.radians(0.1)

Solver = Callable[[Transform], list[Angles]]


def truth(peers: Peers, goals: int = 60, few: int = 8) -> Section:
    """Count over every kind of goal; slow peers get the first `few` goals of each."""
    arm = preset("minimover5").arm
    rows = []
    sets = goal_sets(arm, goals)
    rows += _count(arm, "ours", lambda goal: _ours(arm, goal), sets, goals)
    for peer in solvers(peers, arm):
        rows += _count(arm, peer.name, peer.solve, sets, few if peer.slow else goals)
    return Section(
        "Answers that are wrong and not flagged",
        tuple(rows),
        f"wrong is beyond {NEAR_MM} mm or {math.degrees(NEAR_RAD):.1f} degrees",
    )


def _ours(arm: FiveAxisArm, goal: Transform) -> list[Angles]:
    found = arm.solve_frame_angles(goal, START)
    if found.angles is None or not found.on_manifold:
        return []
    return [found.angles]


def _count(
    arm: FiveAxisArm, name: str, solve: Solver, sets: tuple[GoalSet, ...], most: int
) -> list[Row]:
    rows, total = [], 0
    for kind in sets:
        wrong = missed = 0
        goals = kind.frames[:most]
        for goal in goals:
            answers = solve(goal)
            wrong += any(not _holds(arm, answer, goal) for answer in answers)
            missed += kind.held and not answers
        total += wrong
        unit = f"of {len(goals)} wrong" + (f", {missed} missed" if missed else "")
        rows.append(Row(f"{name}: {kind.name}", wrong, unit))
    rows.append(Row(f"{name}: IN ALL", total, "wrong and not flagged"))
    return rows


def _holds(arm: FiveAxisArm, joints: Angles, goal: Transform) -> bool:
    """Whether a posture's frame, by the product of matrices, is the goal's."""
    found, wanted = np.array(with_arm(MINI_MOVER, arm).chain().fk(joints)), np.array(goal)
    turn = found[:3, :3].T @ wanted[:3, :3]
    lean = np.linalg.norm(
        [turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]
    )
    angle = math.atan2(lean, float(np.trace(turn)) - 1.0)
    return float(np.linalg.norm(found[:3, 3] - wanted[:3, 3])) <= NEAR_MM and angle <= NEAR_RAD
