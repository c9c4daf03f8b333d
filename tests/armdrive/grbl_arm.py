"""A driven GRBL arm on a wire that a test can disturb, and ways to set it moving."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import replace

from armdrive import Jog
from armdrive.arm import Arm
from armdrive.config.arm import ArmConfig
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import simulated_config
from armdrive.registry.simulate import simulate
from kinematics import Joints, Pose

OVER = Joints.of(0.0, 40.0, -80.0, -40.0, 0.0)
OPENING_MM = 20.0
PIECES = re.compile(rb"[?!~\x18\x80-\xff]|[^?!~\x18\x80-\xff\n]*\n|[^?!~\x18\x80-\xff\n]+")
Change = Callable[[bytes], bytes]


class Disturbed:
    """A link whose pieces, lines or real-time bytes, go through rules `to` the board and `back`."""

    def __init__(self, inner):
        self.inner = inner
        self.to: list[list] = []
        self.back: list[list] = []
        self.sent: list[tuple[float, bytes]] = []
        self._half = b""

    def __getattr__(self, name):
        return getattr(self.inner, name)

    @property
    def motions(self) -> list[bytes]:
        return [piece for _, piece in self.sent if piece.startswith((b"G91G1", b"$J="))]

    def pressed(self, byte: bytes) -> int:
        return sum(piece == byte for _, piece in self.sent)

    def write(self, data, now_s):
        for piece in PIECES.findall(data):
            self.sent.append((now_s, piece))
            changed = _changed(self.to, piece)
            if changed:
                self.inner.write(changed, now_s)

    def read(self, now_s):
        *whole, self._half = (self._half + self.inner.read(now_s)).split(b"\n")
        return b"".join(_changed(self.back, line + b"\n") for line in whole)


def _changed(rules, piece):
    for each in rules:
        pattern, change, skip, times = each
        if times > 0 and re.match(pattern, piece):
            if skip > 0:
                each[2] -= 1
                continue
            each[3] -= 1
            return change(piece)
    return piece


def rule(pattern: bytes, change: Change, skip: int = 0, times: float = 1) -> list:
    """Return a rule: what it matches, what it makes of it, how many pass before, how often."""
    return [pattern, change, skip, times]


def lost(piece: bytes) -> bytes:
    return b""


def without(index: int) -> Change:
    return lambda piece: piece[:index] + piece[index + 1 :]


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
    body = twin.world.body
    twin.world.drive_to(body.transmission.to_motors(OVER, OPENING_MM))
    return Arm(connect_simulated(made, twin=replace(twin, link=Disturbed(twin.link))))


def ready(made: ArmConfig | None = None, **options) -> Arm:
    """The same, referenced; what contact has sent is forgotten."""
    arm = found(made, **options)
    arm.declare_posture(OVER, opening_mm=OPENING_MM)
    arm.twin.link.sent.clear()
    return arm


def stands(arm: Arm, quiet_s: float = 0.4, look_s: float = 0.008) -> float:
    """Let time pass until the motors have stood for a while; return when they stopped."""
    last, since_s = arm.twin.world.motors, arm.status.time_s
    while arm.status.time_s < since_s + quiet_s:
        arm.sleep(look_s)
        if arm.twin.world.motors != last:
            last, since_s = arm.twin.world.motors, arm.status.time_s
    return since_s


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
