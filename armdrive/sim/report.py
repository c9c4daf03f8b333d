"""The whole state of a simulated arm, physical and commanded, for people and for programs."""

from __future__ import annotations

from armdrive.sim.device import SimDevice
from armdrive.sim.saved import Json
from armdrive.sim.world_file import block_to_json, incident_to_json

_MM_DIGITS = 3
_DEG_DIGITS = 3


def state_json(device: SimDevice) -> dict[str, Json]:
    """Return the state as plain data; lengths in mm, angles in degrees, forces in N."""
    world = device.world
    pose, scene = world.pose, world.scene
    joints: dict[str, Json] = {
        name: round(angle, _DEG_DIGITS) for name, angle in world.joints.deg.items()
    }
    return {
        "powered": device.powered,
        "energised": world.energised,
        "moving": device.moving,
        "busy": device.busy,
        "registers": list(device.registers),
        "motors": list(world.motors),
        "joints_deg": joints,
        "pose": {
            "x_mm": round(pose.x_mm, _MM_DIGITS),
            "y_mm": round(pose.y_mm, _MM_DIGITS),
            "z_mm": round(pose.z_mm, _MM_DIGITS),
            "pitch_deg": round(pose.pitch_deg, _DEG_DIGITS),
            "roll_deg": round(pose.roll_deg, _DEG_DIGITS),
            **({} if pose.yaw_deg is None else {"yaw_deg": round(pose.yaw_deg, _DEG_DIGITS)}),
        },
        "opening_mm": round(world.opening_mm, _MM_DIGITS),
        "grip_force_n": round(world.grip_force_n, _MM_DIGITS),
        "inputs": device.inputs,
        **device.details(),
        "stalled": [motor + 1 for motor in sorted(world.stalled)],
        "held": scene.held,
        "blocks": [block_to_json(block) for block in scene.blocks.values()],
        "incidents": [incident_to_json(incident) for incident in world.incidents],
    }


def state_line(device: SimDevice) -> str:
    """Return the state in one line."""
    world = device.world
    words = [
        f"power {'on' if device.powered else 'off'}",
        f"current {'on' if world.energised else 'off'}",
        "moving" if device.moving else "still",
        str(world.pose),
        f"fingers {world.opening_mm:.1f} mm apart",
        f"grip {world.grip_force_n:.1f} N",
        f"registers {','.join(map(str, device.registers))}",
    ]
    held, blocks = world.scene.held, world.scene.blocks
    words += [f"holds {held}"] if held else []
    words += [f"blocks {', '.join(blocks)}"] if blocks else []
    words += [f"incidents {len(world.incidents)}"] if world.incidents else []
    return "; ".join(words)
