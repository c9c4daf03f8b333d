"""Goals that any arm can reach from where a simulated arm is found, and calls that go there."""

from __future__ import annotations

from collections.abc import Callable

from armdrive.arm import Arm
from armdrive.errors import ArmError, NotReferenced, Refused, WrongState
from armdrive.flows.motion import Moved
from armdrive.handle import Handle
from armdrive.intents import Jog
from kinematics import Pose

from .seen import Broken

FIRST_DEG = 20.0
SECOND_DEG = -10.0


def joints_from(arm: Arm, first_deg: float = FIRST_DEG, second_deg: float = SECOND_DEG):
    """Return joint goals beside the present posture: of the first two joints."""
    first, second = arm.model.arm.joint_names[:2]
    here = arm.joints.deg
    return {f"{first}_deg": here[first] + first_deg, f"{second}_deg": here[second] + second_deg}


def begin_joints(arm: Arm, first_deg: float = FIRST_DEG) -> Handle[Moved]:
    """Begin a planned joint motion of a second or so."""
    return arm.move_j(wait=False, **joints_from(arm, first_deg))


def beside(pose: Pose, x_mm: float = 0.0, y_mm: float = 0.0, z_mm: float = 0.0) -> Pose:
    """Return a pose beside another; the hand keeps its attitude, but for an arm's own heading."""
    return Pose(
        pose.x_mm + x_mm,
        pose.y_mm + y_mm,
        pose.z_mm + z_mm,
        pose.pitch_rad,
        pose.roll_rad,
        pose.yaw_rad,
    )


def first_jog(arm: Arm) -> Jog:
    """Return a jog of the joints that sweep the tip furthest."""
    names = arm.model.arm.joint_names[:3]
    return Jog.joint(**dict.fromkeys(names, 1.0))


def refused(call: Callable[[], object], kind: type[ArmError], what: str) -> ArmError:
    """Check that a call is refused, in words of the right kind."""
    try:
        call()
    except kind as refusal:
        return refusal
    except ArmError as other:
        raise Broken(f"{what} was refused as {type(other).__name__}: {other}") from other
    raise Broken(f"{what} was not refused")


def planned(arm: Arm) -> dict[str, Callable[[], object]]:
    """Return the planned motions that need a reference."""
    first = arm.model.arm.joint_names[0]
    goal = arm.model.arm.fk(arm.core.coordinates.joints)
    return {
        "move_j": lambda: arm.move_j(**{f"{first}_deg": 1.0}),
        "move_to": lambda: arm.move_to(goal),
        "move_l": lambda: arm.move_l(goal),
        "park": arm.park,
    }


NOT_REFERENCED, WRONG, REFUSED = NotReferenced, WrongState, Refused
