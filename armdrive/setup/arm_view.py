"""Shows an arm as armdrive reads its file: lengths, steps, directions, limits, stopping."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Any

from armdrive.abilities import Budget
from armdrive.config.arm import ArmConfig
from armdrive.config.preset import LENGTHS
from armdrive.registry import dialect
from armdrive.runtime.stop_bounds import stop_bound
from armdrive.status import pose_view, rounded_up
from kinematics.presets import ArmPreset
from kinematics.transmission import MotorSpec, Transmission


def arm_view(config: ArmConfig) -> dict[str, Any]:
    """Return an arm as plain data, units in the names."""
    model = config.model
    names = model.arm.joint_names
    speeds = (round(math.degrees(speed), 3) for speed in model.joint_speeds_rad_s)
    return {
        "arm": config.name,
        "title": config.title,
        "model": model.key,
        "verified": model.verified,
        "dialect": config.connection.dialect,
        "port": config.connection.port,
        "baud": config.connection.baud,
        "reach_mm": round(model.arm.levers_mm(None)[0], 1),
        "limits_deg": {
            name: [round(math.degrees(each.low_rad), 3), round(math.degrees(each.high_rad), 3)]
            for name, each in zip(names, model.arm.limits, strict=True)
        },
        "speeds_deg_s": dict(zip(names, speeds, strict=True)),
        "motors": [] if model.transmission is None else _motors(model.transmission),
        "gripper": config.gripper.kind,
        "homes_by_itself": config.homing is not None,
        "reference": None if model.reference is None else pose_view(model.reference.pose),
        "park": pose_view(config.park),
        "tool": asdict(config.tool) if config.tool else None,
        "frames": list(config.frames),
        "jog_burst_s": config.motion.jog_burst_s,
        "planned_burst_s": config.motion.planned_burst_s,
        "stopping": _stopping(config),
        "wire": _wire(config),
        "notes": model.notes,
    } | _lengths(config)


def _lengths(config: ArmConfig) -> dict[str, Any]:
    if not isinstance(config.bare, ArmPreset):
        return {}
    return {"lengths": {key: getattr(config.bare.arm, key) for key in LENGTHS}}


def _motors(transmission: Transmission) -> list[dict[str, Any]]:
    seen = [*transmission.joint_names, "opening"][: len(transmission.motors)]
    return [_motor(motor, seen, transmission) for motor in transmission.motors]


def _motor(motor: MotorSpec, seen: list[str], transmission: Transmission) -> dict[str, Any]:
    slides = motor.sees[-1] != 0.0 and seen[-1] == "opening"
    key, scale = ("steps_per_mm", 1.0) if slides else ("steps_per_turn", math.tau)
    sign = math.copysign(1.0, motor.steps_per_unit)
    others = {transmission.motors[index].name: ratio for index, ratio in motor.follows}
    shares = {n: sign * share for n, share in zip(seen, motor.sees, strict=True) if share}
    return {
        "name": motor.name,
        key: round(abs(motor.steps_per_unit) * scale, 6),
        "counts_up_for": shares,
        "follows": others,
    }


def _wire(config: ArmConfig) -> dict[str, float]:
    """Return the time of an exchange on this wire, and the share of time left for motion."""
    able, baud = dialect(config.connection.dialect).abilities, config.connection.baud
    lengths = Budget(config.motion.jog_burst_s, config.motion.planned_burst_s)
    share = lengths.moving_share(able.traffic, baud, able.queued_segments)
    return {
        "exchange_s": round(able.traffic.exchange_s(baud), 4),
        "moving_share": round(share, 3),
    }


def _stopping(config: ArmConfig) -> dict[str, dict[str, float]]:
    """Return the stop bounds, with the arm stretched out, while jogging and in planned motion."""
    controller = dialect(config.connection.dialect).controller(config)
    found = {}
    motion = config.motion
    for name, burst_s in (("jog", motion.jog_burst_s), ("planned", motion.planned_burst_s)):
        bound = stop_bound(config, controller, None, burst_s)
        found[name] = {
            "time_s": rounded_up(bound.time_s, 3),
            "distance_mm": rounded_up(bound.distance_mm, 1),
            "silent_time_s": rounded_up(bound.silent_time_s, 3),
            "silent_distance_mm": rounded_up(bound.silent_distance_mm, 1),
        }
    return found


def arm_lines(view: dict[str, Any]) -> list[str]:
    """Return the view as lines of text."""
    port = view["port"] or "(no port: only simulated)"
    lines = [
        f"{view['arm']}: {view['title']}, model {view['model']}"
        + ("" if view["verified"] else " (a template: Cartesian motion is refused)"),
        f"speaks {view['dialect']} at {port}, {view['baud']} baud",
    ]
    if "lengths" in view:
        lengths = (f"{k.removesuffix('_mm').replace('_', ' ')} {v:g}" for k, v in _items(view))
        lines.append(f"lengths: {', '.join(lengths)} mm")
    lines.append(f"reach {view['reach_mm']:g} mm from the base axis at most")
    for name, (low, high) in view["limits_deg"].items():
        speed = view["speeds_deg_s"][name]
        lines.append(f"  {name:<14} {low:8g} to {high:<6g} deg, {speed:g} deg/s")
    lines += [_motor_line(motor) for motor in view["motors"]] or ["the motor steps are unknown"]
    lines.append(f"gripper: {view['gripper']}; homes by itself: {_yes(view['homes_by_itself'])}")
    for what, bound in view["stopping"].items():
        lines.append(
            f"a stop while {_WHILE[what]} takes at most {bound['time_s']:g} s and "
            f"{bound['distance_mm']:g} mm (this program dying: {bound['silent_time_s']:g} s, "
            f"{bound['silent_distance_mm']:g} mm)"
        )
    return [*lines, f"notes: {view['notes']}"] if view["notes"] else lines


_WHILE = {"jog": "jogging", "planned": "moving as planned"}


def _items(view: dict[str, Any]) -> list[tuple[str, float]]:
    return list(view["lengths"].items())


def _motor_line(motor: dict[str, Any]) -> str:
    unit = "mm" if "steps_per_mm" in motor else "turn"
    shares = ", ".join(
        f"{'+' if share > 0 else '-'}{name}" + ("" if abs(share) == 1 else f" x {abs(share):g}")
        for name, share in motor["counts_up_for"].items()
    )
    follows = "".join(f", follows {name} x {ratio}" for name, ratio in motor["follows"].items())
    steps = f"{motor[f'steps_per_{unit}']:g} steps/{unit}"
    return f"  motor {motor['name']:<13} {steps}, up for {shares}{follows}"


def _yes(value: bool) -> str:
    return "yes" if value else "no"
