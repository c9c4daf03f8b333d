"""A person at a terminal who looks at the arm: drawn postures, and questions with a clear no."""

from __future__ import annotations

import os
import sys

from armdrive.arm import Arm
from armdrive.cli.output import put, say
from armdrive.dialog import PostureRequest
from armdrive.errors import OperatorNeeded
from armdrive.render.canvas import can_braille
from armdrive.render.side_view import ArmScene, side_view
from armdrive.status import Trust
from kinematics import Joints

WIDTH, HEIGHT = 60, 16


def posture_drawing(arm: Arm, joints: Joints, opening_mm: float) -> list[str]:
    """Draw a posture from the side."""
    scene = scene_of(arm, joints, opening_mm)
    return side_view(scene, WIDTH, HEIGHT, can_braille(sys.stdout.encoding, os.environ))


def scene_of(arm: Arm, joints: Joints, opening_mm: float) -> ArmScene:
    """Return what there is to draw of an arm in a posture."""
    geometry = arm.model.arm
    return ArmScene(
        points=geometry.points(joints),
        opening_mm=max(opening_mm, 0.0),
        base_rad=joints[0],
        reach_mm=geometry.levers_mm(None)[0],
    )


def ask_operator(request: PostureRequest) -> bool:
    """Ask the person at the terminal whether the arm stands in the posture."""
    for line in posture_drawing(request.arm, request.joints, request.opening_mm):
        say(line)
    say(str(request))
    return agreed("Does the arm stand exactly like this? Type yes: ")


def settle_trust(arm: Arm) -> None:
    """Have a restored position confirmed: by the simulated operator, or by the person here."""
    status = arm.status
    if status.trust is not Trust.RESTORED or arm.core.allow_restored or status.joints is None:
        return
    if arm.simulated:
        confirm_simulated(arm)
        return
    if not sys.stdin.isatty():
        return  # the motion is refused, with the ways to confirm
    for line in posture_drawing(arm, status.joints, status.gripper_mm or 0.0):
        say(line)
    say(f"An earlier program left the arm at {status.joints}.")
    if not agreed("Does the arm stand like this? Type yes: "):
        raise OperatorNeeded("not confirmed: run `armdrive home`")
    arm.confirm_restored()


def confirm_simulated(arm: Arm) -> None:
    """Let the simulated operator look at the simulated arm, and confirm what he sees."""
    joints = arm.status.joints
    if arm.twin is None or joints is None or arm.status.trust is not Trust.RESTORED:
        return
    if arm.twin.operator.stands_at(joints):
        arm.confirm_restored()


def agreed(question: str) -> bool:
    """Ask a question at the terminal; anything but a yes is a no."""
    if not sys.stdin.isatty():
        return False
    put(question)
    return sys.stdin.readline().strip().lower() in ("yes", "y")
