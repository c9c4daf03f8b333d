"""A driven GRBL arm on a wire that a test can disturb, and ways to set it moving."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from functools import partial

from faults import OVER_THE_TABLE as OVER
from faults import DisturbedLink, placed, stand_still_s

from armdrive import Jog
from armdrive.arm import Arm
from armdrive.config.arm import ArmConfig
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import simulated_config
from armdrive.registry.simulate import simulate
from kinematics import Pose

OPENING_MM = 20.0
PIECES = re.compile(rb"[?!~\x18\x80-\xff]|[^?!~\x18\x80-\xff\n]*\n|[^?!~\x18\x80-\xff\n]+")


class Disturbed(DisturbedLink):
    """A GRBL board's wire; to the board go lines and real-time bytes."""

    end = b"\n"

    def written(self, data: bytes) -> list[bytes]:
        return PIECES.findall(data)

    @property
    def motions(self) -> list[bytes]:
        return [piece for piece in self.messages if piece.startswith((b"G91G1", b"$J="))]

    def pressed(self, byte: bytes) -> int:
        return self.messages.count(byte)


def config(device=None, gripper=None, **motion) -> ArmConfig:
    made = simulated_config("grbl")
    if gripper is not None:
        made = replace(
            made,
            gripper=replace(made.gripper, kind=gripper),
            model=replace(made.model, transmission=made.model.transmission.without_gripper()),
        )
    return replace(
        made,
        motion=replace(made.motion, **motion),
        device=replace(made.device, **(device or {})),
    )


def found(made: ArmConfig | None = None, **options) -> Arm:
    """Connect to a board whose arm stands over the table, without a reference."""
    made = made or config()
    twin = simulate(made, **options)
    twin = replace(placed(twin, OVER, OPENING_MM), link=Disturbed(twin.link))
    return Arm(connect_simulated(made, twin=twin))


def ready(made: ArmConfig | None = None, **options) -> Arm:
    """The same, referenced; what contact has sent is forgotten."""
    arm = found(made, **options)
    arm.declare_posture(OVER, opening_mm=OPENING_MM)
    arm.twin.link.sent.clear()
    return arm


stands = partial(stand_still_s, quiet_s=0.4, look_s=0.008)


def standing_as_said(arm: Arm) -> bool:
    """Tell whether the arm stands where it is said to stand."""
    return arm.twin.world.motors == arm.status.acknowledged


def killed(arm: Arm, look_s: float = 0.004) -> float:
    """Let the device live on without its driver; return for how long its motors turned."""
    start_s = now_s = since_s = arm.status.time_s
    last = arm.twin.world.motors
    while now_s < start_s + 1.2:
        now_s += look_s
        arm.twin.link.inner.read(now_s)  # what is on the wire arrives
        if arm.twin.world.motors != last:
            last, since_s = arm.twin.world.motors, now_s
    return since_s - start_s


def begin_planned(arm: Arm) -> None:
    arm.move_j(base_deg=80, shoulder_deg=75, elbow_deg=-40, wait=False)


def begin_line(arm: Arm) -> None:
    pose = arm.pose
    goal = Pose(pose.x_mm - 40, pose.y_mm + 150, pose.z_mm + 30, pose.pitch_rad, 0.0)
    arm.move_l(goal, wait=False)


def begin_jog(arm: Arm) -> None:
    arm.hold(Jog.joint(base=1.0, shoulder=1.0, elbow=1.0), speed=1.0, for_s=1.0)


def begin_tip_jog(arm: Arm) -> None:
    arm.hold(Jog.cartesian(y=1.0, z=0.3), speed=1.0, for_s=1.0)


def tip_mm(arm: Arm, tip) -> float:
    return math.dist(tip, arm.twin.world.tip)
