"""A status as plain data, with units in the names: what `--json` prints and sockets carry."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from armdrive.status import Status
    from kinematics import Joints, LimitViolation, Pose


def pose_view(pose: Pose | None) -> dict[str, float] | None:
    """Return a pose in mm and degrees."""
    if pose is None:
        return None
    yaw = {} if pose.yaw_deg is None else {"yaw_deg": round(pose.yaw_deg, 4)}
    return {
        "x_mm": round(pose.x_mm, 3),
        "y_mm": round(pose.y_mm, 3),
        "z_mm": round(pose.z_mm, 3),
        "pitch_deg": round(pose.pitch_deg, 4),
        "roll_deg": round(pose.roll_deg, 4),
        **yaw,
    }


def joints_view(joints: Joints | None) -> dict[str, float] | None:
    """Return joint angles in degrees."""
    if joints is None:
        return None
    return {f"{name}_deg": round(angle, 4) for name, angle in joints.deg.items()}


def violation_text(violation: LimitViolation) -> str:
    """Put a joint beyond its limit into a few words."""
    value, bound = math.degrees(violation.value_rad), math.degrees(violation.bound_rad)
    name = violation.joint.replace("_", " ")
    return f"{name} {abs(value - bound):.1f}° beyond its limit of {bound:.1f}°"


def status_view(status: Status) -> dict[str, Any]:
    """Return a status."""
    return {
        "arm": status.arm,
        "title": status.title,
        "link": status.link,
        "dialect": status.dialect,
        "simulated": status.simulated,
        "state": status.state.value,
        "paused": status.paused,
        "speed_override": round(status.speed_override, 4),
        "trust": status.trust.value,
        "trust_reason": status.trust_reason,
        "trust_for_s": round(max(status.time_s - status.trust_since_s, 0.0), 1),
        "current": status.current.value,
        "joints": joints_view(status.joints),
        "pose": pose_view(status.pose),
        "gripper_mm": None if status.gripper_mm is None else round(status.gripper_mm, 3),
        "gripping": status.gripping,
        "commanded_steps": status.commanded,
        "acknowledged_steps": status.acknowledged,
        "read_back_steps": status.read_back,
        "inputs": status.inputs,
        "outputs": status.outputs,
        "stop_time_s": round(status.stop_time_s, 3),
        "stop_distance_mm": round(status.stop_distance_mm, 1),
        "silent_time_s": round(status.silent_time_s, 3),
        "silent_distance_mm": round(status.silent_distance_mm, 1),
        "pause_time_s": round(status.pause_time_s, 3),
        "pause_distance_mm": round(status.pause_distance_mm, 1),
        "wakes": {
            "deadlines": status.wakes.count,
            "median_ms": round(status.wakes.median_s * 1e3, 3),
            "p99_ms": round(status.wakes.p99_s * 1e3, 3),
            "worst_ms": round(status.wakes.worst_s * 1e3, 3),
        },
        "underruns": status.underruns,
        "torque": None if status.torque is None else asdict(status.torque),
        "notice": status.notice,
        "error": status.error,
        "trust_code": status.trust_code,
        "notice_code": status.notice_code,
        "error_code": status.error_code,
    }
