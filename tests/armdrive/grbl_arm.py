"""A driven GRBL arm on a wire that a test can disturb, and ways to set it moving."""

import math
import re
from dataclasses import replace
from functools import partial

from faults import DisturbedLink, Rule, arm_config, driven, stand_still_s

from armdrive import Jog
from armdrive.arm import Arm
from armdrive.config.arm import ArmConfig
from armdrive.connect.parts import connect_simulated
from armdrive.registry import simulate
from kinematics import Pose

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


config = partial(arm_config, "grbl")
"""An arm on a GRBL board."""


def found(made: ArmConfig | None = None, **options) -> Arm:
    """Connect to a board whose arm stands over the table, without a reference."""
    return driven(made or config(), link=Disturbed, referenced=False, **options)


def ready(made: ArmConfig | None = None, **options) -> Arm:
    """The same, referenced; what contact has sent is forgotten."""
    return driven(made or config(), link=Disturbed, **options)


def over(*rules: Rule, **options) -> Arm:
    """Connect over a wire that changes by rules what the board sends."""
    twin = simulate(config(), **options)
    link = Disturbed(twin.link)
    link.back += rules
    return Arm(connect_simulated(config(), twin=replace(twin, link=link)))


stands = partial(stand_still_s, quiet_s=0.4, look_s=0.008)


def standing_as_said(arm: Arm) -> bool:
    """Tell whether the arm stands where it is said to stand."""
    return arm.twin.world.motors == arm.status.acknowledged


def begin_planned(arm: Arm) -> None:
    arm.move_j(base_deg=80, shoulder_deg=75, elbow_deg=-40, wait=False)


def begin_line(arm: Arm) -> None:
    pose = arm.pose
    goal = Pose(pose.x_mm - 40, pose.y_mm + 150, pose.z_mm + 30, pose.pitch_rad, 0.0)
    arm.move_l(goal, wait=False)


def begin_jog(arm: Arm) -> None:
    arm.jogging.hold(Jog.joint(base=1.0, shoulder=1.0, elbow=1.0), speed=1.0, for_s=1.0)


def begin_tip_jog(arm: Arm) -> None:
    arm.jogging.hold(Jog.cartesian(y=1.0, z=0.3), speed=1.0, for_s=1.0)


BEGINNINGS = [begin_planned, begin_line, begin_jog, begin_tip_jog]
FIRMWARES = ["grbl", "mega5x", "grblhal", "fluidnc"]
HOME_SINGLE_AXES = FIRMWARES[1:]
"""Those that know `$HX`, which the driver needs; GRBL 1.1 as published does not."""


def tip_mm(arm: Arm, tip) -> float:
    return math.dist(tip, arm.twin.world.tip)
