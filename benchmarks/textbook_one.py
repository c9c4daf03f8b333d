"""One pose: forward, Jacobian and inverse of the Mini-mover and of the Puma, beside the peers."""

from __future__ import annotations

import importlib
import math
from collections.abc import Callable
from statistics import median
from typing import Any

import numpy as np
from measuring import Row, Section, each, interleaved, ratio
from textbook_goals import postures
from textbook_peers import (
    START,
    Peers,
    eaik_robot,
    matrix,
    solvers,
    toolbox_puma,
    toolbox_robot,
)

from kinematics import FiveAxisArm, Joints, preset
from kinematics.chains.chain import Chain
from kinematics.chains.closed_form import closed_form
from kinematics.chains.generated import generated
from kinematics.five_axis.closed_form import forward_frame
from kinematics.textbook.systems.mini_movers import MINI_MOVER, with_arm
from kinematics.textbook.systems.named import System
from kinematics.textbook.systems.puma import PUMA

Cases = dict[str, Callable[[], object]]


def minimover_inverse(peers: Peers, poses: int = 200, rounds: int = 15) -> Section:
    """Solve reachable poses of the Mini-mover, ours within limits, the peers as they are."""
    arm = preset("minimover5").arm
    frames = [arm.transform(Joints(q)) for q in postures(arm, poses)]
    poses_of = [arm.fk(Joints(q)) for q in postures(arm, poses)]
    goals = [(p.x_mm, p.y_mm, p.z_mm, p.pitch_rad, p.roll_rad) for p in poses_of]
    seed = Joints(START)
    cases: Cases = {
        "solve_angles: bare floats, limits, turns, seed": each(
            lambda goal: arm.solve_angles(goal, START), goals
        ),
        "solve: the same on value types": each(lambda pose: arm.solve(pose, seed), poses_of),
        "solve_frame_angles: a 4x4, off-manifold too": each(
            lambda frame: arm.solve_frame_angles(frame, START), frames
        ),
    }
    ours = len(cases)
    fast = [one for one in solvers(peers, arm) if not one.slow]
    for peer in fast:
        cases[f"{peer.name}, bare"] = each(peer.call, [peer.prepare(one) for one in frames])
    robot = eaik_robot(peers, arm)
    if robot is not None:
        cases["EAIK with limits and the nearest branch"] = each(
            lambda goal: _nearest(robot.IK(goal).Q, arm), [matrix(one) for one in frames]
        )
    taken = interleaved(cases, rounds)
    others = [name for name in cases if name.endswith(", bare")]
    slow = [one for one in solvers(peers, arm) if one.slow]
    rows = list(_rows(taken, poses, ours, others))
    for peer in slow:
        few = [peer.prepare(one) for one in frames[:10]]
        seconds = interleaved({peer.name: each(peer.call, few)}, 2)[peer.name]
        rows.append(Row(f"{peer.name} (ten poses)", median(seconds) / 10 * 1e6, "us a pose"))
    return Section("Mini-mover, IK of one pose", tuple(rows), _note(poses, rounds))


def _nearest(found: Any, arm: FiveAxisArm) -> Any:
    """Do with a peer's branches what `solve_angles` does: turns, limits, nearest to the seed."""
    low = np.array([one.low_rad for one in arm.limits])
    high = np.array([one.high_rad for one in arm.limits])
    joints = np.array(found) - (0.0, 0.0, 0.0, math.pi / 2.0, 0.0)
    joints -= np.rint((joints - START) / math.tau) * math.tau
    inside = joints[((joints >= low - 1e-7) & (joints <= high + 1e-7)).all(axis=1)]
    return inside[np.argmin(((inside - START) ** 2).sum(axis=1))] if len(inside) else None


def forward(peers: Peers, poses: int = 200, rounds: int = 15) -> Section:
    """Compute frames and Jacobians of both arms."""
    arm, puma = preset("minimover5").arm, PUMA
    five = postures(arm, poses)
    six = [(*q, 0.3) for q in five]
    cases: Cases = {
        "Mini-mover FK, closed form": each(lambda q: forward_frame(q, arm.lengths), five),
        **_generated("Mini-mover", with_arm(MINI_MOVER, arm).chain(), five),
        **_generated("Puma", puma.chain(), six),
    }
    ours = len(cases)
    for name, robot, values in (
        ("Mini-mover", toolbox_robot(peers, arm), five),
        ("Puma", toolbox_puma(peers, puma), six),
    ):
        if robot is None:
            continue
        ets, arrays = robot.ets(), [np.array(q) for q in values]
        cases[f"{name} FK, Robotics Toolbox eval (C++)"] = each(ets.eval, arrays)
        cases[f"{name} FK, Robotics Toolbox fkine"] = each(robot.fkine, arrays[:20] * 10)
        cases[f"{name} Jacobian, Robotics Toolbox (C++)"] = each(ets.jacob0, arrays)
    eaik = eaik_robot(peers, arm)
    if eaik is not None:
        cases["Mini-mover FK, EAIK (C++)"] = each(eaik.fwdKin, [np.array(q) for q in five])
    taken = interleaved(cases, rounds)
    others = [name for name in list(cases)[ours:] if "fkine" not in name]
    return Section(
        "FK and Jacobian of one posture",
        tuple(_rows(taken, poses, ours, others, alike=_alike)),
        _note(poses, rounds),
    )


def _generated(name: str, chain: Chain, values: list[Any]) -> Cases:
    made = generated(chain)
    return {
        f"{name} FK, generated": each(made.fk, values),
        f"{name} Jacobian, generated": each(made.jacobian, values),
    }


def _alike(ours: str, other: str) -> bool:
    """Whether two cases compute the same thing of the same arm."""
    return ours.partition(",")[0] == other.partition(",")[0]


def puma_inverse(peers: Peers, poses: int = 200, rounds: int = 15) -> Section:
    """Solve frames of a Puma, all eight branches."""
    puma = PUMA
    chain = puma.chain()
    closed = closed_form(chain)
    if closed is None:
        raise AssertionError("the Puma has a closed form")
    find, seed = closed.solver.frames, (0.0,) * 6
    fk = generated(chain).fk
    frames = [fk((*q, 0.3)) for q in postures(preset("minimover5").arm, poses)]

    def eight_branches() -> None:
        for frame in frames:
            find(frame, seed)

    cases: Cases = {"eight branches": eight_branches}
    opw = peers.get("py_opw_kinematics")
    if opw is not None:
        cases["py-opw, eight branches"] = _opw_case(opw, puma, poses)
    if peers.get("eaik") is not None:
        cases["EAIK, eight branches"] = _eaik_case(puma, frames)
    taken = interleaved(cases, rounds)
    others = list(cases)[1:]
    return Section(
        "Puma, IK of one pose", tuple(_rows(taken, poses, 1, others)), _note(poses, rounds)
    )


def _opw_case(opw: Any, puma: System, poses: int) -> Callable[[], object]:
    """Return py-opw's case: the same lengths, goals of its own postures, made beforehand."""
    size = puma.lengths()
    model = opw.KinematicModel(
        a1=size["a1"],
        a2=0.0,
        b=size["d2"],
        c1=size["d1"],
        c2=size["a2"],
        c3=size["d4"],
        c4=size["d6"],
    )
    robot = opw.Robot(model, degrees=False)
    own = postures(preset("minimover5").arm, poses)
    return each(robot.inverse, [robot.forward(np.array((*q, 0.3))) for q in own])


def _eaik_case(puma: System, frames: list[Any]) -> Callable[[], object]:
    links = puma.chain().links
    robot = importlib.import_module("eaik.IK_DH").DhRobot(
        np.array([link.alpha_rad for link in links]),
        np.array([link.a_mm for link in links]),
        np.array([link.d_mm for link in links]),
    )
    return each(robot.IK, [matrix(one) for one in frames])


def _rows(
    taken: dict[str, list[float]],
    poses: int,
    ours: int,
    others: list[str],
    alike: Callable[[str, str], bool] = lambda _ours, _other: True,
) -> list[Row]:
    """Return a row a case; ours say how many times as fast as each peer they are."""
    rows = []
    for index, (name, seconds) in enumerate(taken.items()):
        times = {
            f"as fast as {other}": ratio(taken[other], seconds)
            for other in others
            if index < ours and alike(name, other)
        }
        rows.append(Row(name, median(seconds) / poses * 1e6, "us", times=times))
    return rows


def _note(poses: int, rounds: int) -> str:
    return f"{poses} poses, medians of {rounds} interleaved rounds"
