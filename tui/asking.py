"""What the desk asks a person before it is done: references, confirmed postures, the motors."""

from __future__ import annotations

from typing import TYPE_CHECKING

from armdrive.errors import ArmError
from armdrive.status import State, Trust
from kinematics import KinematicsError
from tui.views import scene_of

if TYPE_CHECKING:
    from tui.desk import Desk


def ask_reference(desk: Desk) -> None:
    """Ask whether the arm stands in its reference posture; a simulated one is brought there."""
    if desk.nobody_there():
        return
    arm = desk.arm
    if arm.homes_by_switches:
        text = "THE ARM WILL MOVE: its controller seeks its switches."
        done = "homed by its own switches"
        desk.ask(text, desk.scene(), arm.home, done, asked="Is its way clear?")
        return
    if desk.status.simulated:
        desk.disarm("the simulated operator is at work")
        desk.call(arm.home, "the simulated operator referenced the arm")
        return
    try:
        request = arm.reference_request()
    except (ArmError, KinematicsError) as error:
        desk.say(str(error))
        return
    scene = scene_of(arm.model, request.joints, request.opening_mm)
    desk.ask(str(request), scene, arm.confirm_reference)


def ask_confirm(desk: Desk) -> None:
    """Ask whether the arm stands where it is remembered to."""
    status = desk.status
    if desk.nobody_there():
        return
    if status.trust is not Trust.RESTORED or status.joints is None:
        desk.say(f"nothing to confirm: the position is {status.trust.value}")
        return
    scene = scene_of(desk.arm.model, status.joints, status.gripper_mm)
    text = f"Remembered ({status.trust_reason}): {status.joints}"
    desk.ask(text, scene, desk.arm.confirm_restored)


def ask_motors(desk: Desk) -> None:
    """Switch the motor current on; off only after a question, since the arm sags then."""
    if desk.nobody_there():
        return
    if desk.status.state is State.DISABLED:
        desk.call(desk.arm.enable, "the motors are on: nothing was moved")
        return
    text = "The motors are switched off: THE ARM SAGS, and its position is lost."
    desk.ask(text, desk.scene(), desk.arm.disable, "the motors are off", asked="Is it supported?")
