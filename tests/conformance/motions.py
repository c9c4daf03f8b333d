"""Motions that any arm can make from where a simulated arm begins, and checks of refusals."""

import math
from collections.abc import Callable

from armdrive.arm import Arm
from armdrive.arm.connected import Handle
from armdrive.errors import ArmError
from armdrive.motion.execute import Moved
from armdrive.moves import Jog
from armdrive.runtime.position import ArmCoordinates
from kinematics import Motors, Pose

from .observation import Broken

FIRST_DEG = 20.0
SECOND_DEG = -10.0
LONGEST_S = 0.8


def joints_from(
    arm: Arm, first_deg: float = FIRST_DEG, second_deg: float = SECOND_DEG
) -> dict[str, float]:
    """Return goals for the first two joints, relative to the present posture.

    The goals are nearer if the arm would take longer than `LONGEST_S`: some arms take ten times as
    long as others.
    """
    first, second = arm.model.arm.joint_names[:2]
    here = arm.joints.deg
    named = {first: math.radians(here[first] + first_deg)}
    named[second] = math.radians(here[second] + second_deg)
    start = arm.parts.core.position.coordinates
    end = ArmCoordinates(start.joints.replace(**named), start.opening_mm)
    share = min(LONGEST_S / arm.parts.speeds.duration_s(start, end, 1.0), 1.0)
    return {
        f"{first}_deg": here[first] + share * first_deg,
        f"{second}_deg": here[second] + share * second_deg,
    }


def begin_joints(arm: Arm) -> Handle[Moved]:
    """Begin a planned joint motion of about a second."""
    return arm.move_j(wait=False, **joints_from(arm))


def motors_at_end(arm: Arm) -> Motors:
    """Return where the motors have to stand after the motion of `begin_joints`."""
    turned = {
        name.removesuffix("_deg"): math.radians(angle) for name, angle in joints_from(arm).items()
    }
    here = arm.parts.core.position.coordinates
    return arm.parts.core.transmission.to_motors(here.joints.replace(**turned), here.opening_mm)


def begin_sweep(arm: Arm, turn_deg: float = 60.0, speed: float = 1.0) -> Handle[Moved]:
    """Begin a motion of the first joint that is long enough to be stopped on any arm."""
    first = arm.model.arm.joint_names[0]
    goal = {f"{first}_deg": arm.joints.deg[first] + turn_deg}
    return arm.move_j(wait=False, speed=speed, **goal)


def sweep_plan(arm: Arm, turn_deg: float = 60.0) -> tuple[Motors, Motors, float]:
    """Return the start and the end of such a sweep, and its duration at full speed."""
    first = arm.model.arm.joint_names[0]
    start = arm.parts.core.position.coordinates
    angle_rad = math.radians(arm.joints.deg[first] + turn_deg)
    end = ArmCoordinates(start.joints.replace(**{first: angle_rad}), start.opening_mm)
    ends = (
        arm.parts.core.transmission.to_motors(each.joints, each.opening_mm) for each in (start, end)
    )
    return *ends, arm.parts.speeds.duration_s(start, end, 1.0)


def shifted(pose: Pose, x_mm: float = 0.0, y_mm: float = 0.0, z_mm: float = 0.0) -> Pose:
    """Return a pose moved by some mm, with the same orientation of the hand."""
    return Pose(
        pose.x_mm + x_mm,
        pose.y_mm + y_mm,
        pose.z_mm + z_mm,
        pose.pitch_rad,
        pose.roll_rad,
        pose.yaw_rad,
    )


def jog_first_joint(arm: Arm, angle_deg: float = 1.0) -> None:
    """Jog the first joint by an increment."""
    arm.jog_j(**{f"{arm.model.arm.joint_names[0]}_deg": angle_deg})


def sweeping_jog(arm: Arm) -> Jog:
    """Return a jog of the three joints that move the tip fastest."""
    names = arm.model.arm.joint_names[:3]
    return Jog.joint(**dict.fromkeys(names, 1.0))


def check_refused(call: Callable[[], object], kind: type[ArmError], what: str) -> ArmError:
    """Check that a call is refused with an error of a class; return the error."""
    try:
        call()
    except kind as refusal:
        return refusal
    except ArmError as other:
        raise Broken(f"{what} was refused as {type(other).__name__}: {other}") from other
    raise Broken(f"{what} was not refused")


def planned_motions(arm: Arm) -> dict[str, Callable[[], object]]:
    """Return one call of each planned motion that needs a reference, by its name."""
    first = arm.model.arm.joint_names[0]
    goal = arm.model.arm.fk(arm.parts.core.position.coordinates.joints)
    return {
        "move_j": lambda: arm.move_j(**{f"{first}_deg": 1.0}),
        "move_to": lambda: arm.move_to(goal),
        "move_l": lambda: arm.move_l(goal),
        "park": arm.park,
    }
