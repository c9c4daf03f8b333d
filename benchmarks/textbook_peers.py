"""Other people's solvers of the same arm, each behind the same two calls; absent ones are named.

A peer's `solve` returns the joint angles it offers as an answer (none where it says that there
is none), in this project's joints. What a peer flags counts as no answer: a least-squares mark
of EAIK, `success` of the Robotics Toolbox. ikpy has no flag.
"""

from __future__ import annotations

import importlib
import math
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from types import ModuleType
from typing import Any

import numpy as np

from kinematics import FiveAxisArm
from kinematics.five_axis.closed_form import Angles
from kinematics.frames.transforms import Transform
from kinematics.textbook.systems.named import System

QUARTER = math.pi / 2.0
WHEELS = {
    "eaik": "eaik",
    "roboticstoolbox": "roboticstoolbox-python",
    "py_opw_kinematics": "py-opw-kinematics",
    "ikpy": "ikpy",
    "pinocchio": "pin",
}
"""Module to the package that brings it."""

START: Angles = (0.0, 0.6, -1.2, -0.6, 0.0)
"""A posture within the limits that every solver starts from."""


@dataclass(frozen=True, slots=True)
class Peer:
    """A solver: `prepare` turns a frame (mm) into what its `call` takes, `answers` reads it."""

    name: str
    prepare: Callable[[Transform], Any]
    call: Callable[[Any], Any]
    answers: Callable[[Any], list[Angles]]
    slow: bool = False

    def solve(self, goal: Transform) -> list[Angles]:
        """Return every answer that the peer claims."""
        return self.answers(self.call(self.prepare(goal)))


@dataclass(slots=True)
class Peers:
    """Which peers are installed."""

    modules: dict[str, ModuleType] = field(default_factory=dict)
    missing: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        for name, package in WHEELS.items():
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")
                    self.modules[name] = importlib.import_module(name)
            except ImportError:
                self.missing.append(package)

    def get(self, name: str) -> Any:
        """Return a peer's module, or None."""
        return self.modules.get(name)


def matrix(frame: Transform) -> Any:
    """Return a frame as an array, in mm."""
    return np.array(frame)


def in_metres(frame: Transform) -> Any:
    """Return a frame as an array, in m."""
    made = np.array(frame)
    made[:3, 3] /= 1000.0
    return made


def eaik_robot(peers: Peers, arm: FiveAxisArm) -> Any:
    """Return EAIK's model of the arm in mm, or None."""
    if peers.get("eaik") is None:
        return None
    height, upper, fore, hand = arm.lengths
    dh = importlib.import_module("eaik.IK_DH")
    return dh.DhRobot(
        np.array([QUARTER, 0.0, 0.0, QUARTER, 0.0]),
        np.array([0.0, upper, fore, 0.0, 0.0]),
        np.array([height, 0.0, 0.0, 0.0, hand]),
    )


def toolbox_robot(peers: Peers, arm: FiveAxisArm) -> Any:
    """Return the Robotics Toolbox's model of the arm in m, or None."""
    rtb = peers.get("roboticstoolbox")
    if rtb is None:
        return None
    height, upper, fore, hand = (length / 1000.0 for length in arm.lengths)
    links = [
        rtb.RevoluteDH(d=height, alpha=QUARTER),
        rtb.RevoluteDH(a=upper),
        rtb.RevoluteDH(a=fore),
        rtb.RevoluteDH(alpha=QUARTER, offset=QUARTER),
        rtb.RevoluteDH(d=hand),
    ]
    for link, bounds in zip(links, arm.limits, strict=True):
        link.qlim = np.array([bounds.low_rad, bounds.high_rad])
    return rtb.DHRobot(links)


def toolbox_puma(peers: Peers, puma: System) -> Any:
    """Return the Robotics Toolbox's model of the simplified Puma in m, or None."""
    rtb = peers.get("roboticstoolbox")
    if rtb is None:
        return None
    return rtb.DHRobot(
        [
            rtb.RevoluteDH(d=link.d_mm / 1000.0, a=link.a_mm / 1000.0, alpha=link.alpha_rad)
            for link in puma.chain().links
        ]
    )


def ikpy_chain(peers: Peers, arm: FiveAxisArm) -> Any:
    """Return ikpy's chain of the arm in m, or None."""
    if peers.get("ikpy") is None:
        return None
    chains = importlib.import_module("ikpy.chain")
    link = importlib.import_module("ikpy.link")
    height, upper, fore, hand = (length / 1000.0 for length in arm.lengths)
    rows = (
        ((0.0, 0.0, height), (0.0, 0.0, 0.0)),
        ((0.0, 0.0, 0.0), (QUARTER, 0.0, 0.0)),
        ((upper, 0.0, 0.0), (0.0, 0.0, 0.0)),
        ((fore, 0.0, 0.0), (0.0, 0.0, 0.0)),
        ((0.0, 0.0, 0.0), (QUARTER, 0.0, QUARTER)),  # z along the hand, x upwards at no roll
    )
    joints = [
        link.URDFLink(
            name=f"joint_{index}",
            origin_translation=np.array(place),
            origin_orientation=np.array(turn),
            rotation=np.array([0.0, 0.0, 1.0]),
            bounds=(bounds.low_rad, bounds.high_rad),
        )
        for index, ((place, turn), bounds) in enumerate(zip(rows, arm.limits, strict=True))
    ]
    tool = link.URDFLink("tool", np.array([0.0, 0.0, hand]), np.zeros(3), joint_type="fixed")
    mask = [False, *([True] * 5), False]
    return chains.Chain([link.OriginLink(), *joints, tool], active_links_mask=mask)


def solvers(peers: Peers, arm: FiveAxisArm) -> list[Peer]:
    """Return the inverse solvers of the five-axis arm that are installed."""
    made = (_eaik(peers, arm), _toolbox(peers, arm), _ikpy(peers, arm))
    return [one for one in made if one is not None]


def _eaik(peers: Peers, arm: FiveAxisArm) -> Peer | None:
    robot = eaik_robot(peers, arm)
    if robot is None:
        return None

    def answers(found: Any) -> list[Angles]:
        return [
            _angles((*row[:3], row[3] - QUARTER, row[4]))
            for row, least_squares in zip(found.Q, found.is_LS, strict=True)
            if not least_squares
        ]

    return Peer("EAIK", matrix, robot.IK, answers)


def _toolbox(peers: Peers, arm: FiveAxisArm) -> Peer | None:
    robot = toolbox_robot(peers, arm)
    if robot is None:
        return None
    ets = robot.ets()
    return Peer(
        "Robotics Toolbox ik_LM",
        in_metres,
        ets.ik_LM,
        lambda found: [_angles(found.q)] if found.success else [],
    )


def _ikpy(peers: Peers, arm: FiveAxisArm) -> Peer | None:
    chain = ikpy_chain(peers, arm)
    if chain is None:
        return None
    start = [0.0, *START, 0.0]
    return Peer(
        "ikpy",
        in_metres,
        lambda goal: chain.inverse_kinematics_frame(
            goal, initial_position=start, orientation_mode="all"
        ),
        lambda found: [_angles(found[1:6])],
        slow=True,
    )


def _angles(values: Sequence[float]) -> Angles:
    base, shoulder, elbow, wrist, roll = (float(value) for value in values)
    return base, shoulder, elbow, wrist, roll
