"""Following a straight line in many points, and timing the corners it is cut into."""

from __future__ import annotations

from collections.abc import Callable
from statistics import median
from typing import Any

import numpy as np
from measuring import Row, Section, interleaved, p99
from textbook_peers import Peers, toolbox_robot
from trajectories_peers import joint_limits, missing, model, peer

from kinematics import Joints, Pose, line_path, timed
from kinematics.paths.curves import straight_line

START = Pose.of(x_mm=150.0, y_mm=-100.0, z_mm=150.0, pitch_deg=-60.0)
GOAL = Pose.of(x_mm=250.0, y_mm=100.0, z_mm=60.0, pitch_deg=-80.0, roll_deg=20.0)
HELD = Pose.of(x_mm=250.0, y_mm=100.0, z_mm=60.0, pitch_deg=-60.0)
SIZES = (200, 2000)
ROUNDS = 60
PEER_ROUNDS = 3
NEAR = 1e-6
"""How near a peer's solver comes to each point, in m and rad."""


def lines() -> Section:
    """Measure one line in points at two sizes, and the corners that are enough for the arm."""
    start = model().arm.ik(START)
    rows = []
    for points in SIZES:
        own = {
            f"pitch held, {points} points": lambda p=points: followed(start, HELD, p),
            f"pitch and roll turn, {points} points": lambda p=points: followed(start, GOAL, p),
        }
        taken = interleaved(own, ROUNDS)
        peers = peer_cases(np.array(followed(start, GOAL, points)))
        slow = interleaved(peers, PEER_ROUNDS) if peers else {}
        for name, seconds in taken.items():
            times = {
                f"as fast as {other}": median(theirs) / median(seconds)
                for other, theirs in slow.items()
            }
            speed = points / median(seconds) / 1e6
            rows.append(Row(name, speed, "M points/s", times=times))
        for name, seconds in slow.items():
            rows.append(
                Row(f"{name}, {points} points", points / median(seconds) / 1e6, "M points/s")
            )
    rows.append(cornered(start))
    note = "joints within limits, on one branch" + missing("roboticstoolbox", "pinocchio")
    return Section("A straight line in many points", tuple(rows), note)


def followed(start: Joints, goal: Pose, points: int) -> list[tuple[float, ...]]:
    """Return the joint angles at evenly spaced points of a line."""
    line, before, found = straight_line(model().arm, start, goal), start, []
    for index in range(points):
        before = line.solve(index / (points - 1), before)
        found.append(before.angles_rad)
    return found


def cornered(start: Joints) -> Row:
    """Measure what timing takes of a line that is cut into chords, without numpy."""
    corners = [joints.angles_rad for joints in line_path(model().arm, start, GOAL, 0.3)]
    limits = joint_limits(jerk_s=0.1)
    taken = interleaved({"timed": lambda: timed(corners, limits)}, ROUNDS)["timed"]
    name = f"timed(), a line of {len(corners)} corners, with build-up"
    return Row(name, median(taken) * 1e3, "ms", p99(taken) * 1e3)


def peer_cases(joints: Any) -> dict[str, Callable[[], object]]:
    """Return the peers' ways along the same line."""
    cases: dict[str, Callable[[], object]] = {}
    if peer("roboticstoolbox") is not None:
        toolbox, robot = peer("roboticstoolbox"), toolbox_robot(Peers(), model().arm)
        first, last = robot.fkine(joints[0]), robot.fkine(joints[-1])
        frames = [robot.fkine(q).A for q in joints]
        ctraj = toolbox_way(robot, joints[0], lambda: toolbox.ctraj(first, last, len(joints)).A)
        own = toolbox_way(robot, joints[0], lambda: frames)
        cases[f"Robotics Toolbox, ctraj and ik_LM (solves {ctraj()})"] = ctraj
        cases[f"Robotics Toolbox, ik_LM at frames given (solves {own()})"] = own
    if peer("pinocchio") is not None:
        cases["pinocchio, CLIK from frame to frame given"] = pinocchio_way(joints)
    return cases


def toolbox_way(robot: Any, start: Any, line: Callable[[], Any]) -> Callable[[], int]:
    """Return a way that solves each frame from the one before, and says how many it solved.

    Frames between two of the arm's are in general none of the arm's: five axes cannot hold them.
    What counts as solved is looser than elsewhere here: its tolerance is on the squared error.
    """
    ets = robot.ets()

    def way() -> int:
        q, solved = start, 0
        for frame in line():
            found = ets.ik_LM(frame, q0=q, slimit=1)
            solved += bool(found.success)
            q = found.q
        return solved

    return way


def pinocchio_way(joints: Any) -> Callable[[], object]:
    """Step to each frame of the line by damped least squares, as pinocchio's example does."""
    pin = peer("pinocchio")
    robot, tip = pinocchio_arm(pin)
    data = robot.createData()
    goals = []
    for q in np.ascontiguousarray(joints):
        pin.framesForwardKinematics(robot, data, q)
        goals.append(data.oMf[tip].copy())
    damping = 1e-12 * np.eye(6)

    def way() -> Any:
        q = np.array(joints[0])
        for goal in goals:
            for _ in range(50):
                pin.computeJointJacobians(robot, data, q)
                pin.updateFramePlacement(robot, data, tip)
                off = data.oMf[tip].actInv(goal)
                error = pin.log6(off).vector
                if np.linalg.norm(error) < NEAR:
                    break
                local = pin.getFrameJacobian(robot, data, tip, pin.ReferenceFrame.LOCAL)
                slope = -pin.Jlog6(off.inverse()) @ local
                q = q - slope.T @ np.linalg.solve(slope @ slope.T + damping, error)
        return q

    return way


def pinocchio_arm(pin: Any) -> tuple[Any, int]:
    """Return pinocchio's model of the arm in m, and its frame at the tip."""
    height, upper, fore, hand = (length / 1000.0 for length in model().arm.lengths)
    lifted = pin.SE3(pin.rpy.rpyToMatrix(np.pi / 2.0, 0.0, 0.0), np.array([0.0, 0.0, height]))
    robot, parent = pin.Model(), 0
    for index, (joint, place) in enumerate(
        (
            (pin.JointModelRZ(), pin.SE3.Identity()),
            (pin.JointModelRZ(), lifted),
            (pin.JointModelRZ(), pin.SE3(np.eye(3), np.array([upper, 0.0, 0.0]))),
            (pin.JointModelRZ(), pin.SE3(np.eye(3), np.array([fore, 0.0, 0.0]))),
            (pin.JointModelRX(), pin.SE3.Identity()),
        )
    ):
        parent = robot.addJoint(parent, joint, place, f"joint_{index}")
    at_tip = pin.SE3(np.eye(3), np.array([hand, 0.0, 0.0]))
    return robot, robot.addFrame(pin.Frame("tip", parent, 0, at_tip, pin.FrameType.OP_FRAME))
