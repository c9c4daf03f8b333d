"""The words and numbers of the jog screen, as plain text made from a status."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import zip_longest
from typing import TYPE_CHECKING

from armdrive.frames import BASE
from armdrive.status import Status, Trust
from tui.keyboard import Keyboard
from tui.keys import JogPair, words
from tui.settings import Settings

if TYPE_CHECKING:
    from kinematics import ArmModel

ROW_WIDTH = 34
"""What a row of the joint table takes beside its bar."""

SHORTEST_BAR, LONGEST_BAR = 7, 20

UNKNOWN = "?"

_OUTSIDE = 0.002  # share of a range: less than any printed digit of it


def conduct(status: Status, settings: Settings, keys: Keyboard, *, armed: bool) -> str:
    """Say what state the arm and the keys are in."""
    disarmed = f"DISARMED ({keys.label('arm')} arms)"
    mode = f"mode {settings.space.value.upper()}"
    if settings.cartesian and settings.frame != BASE:
        mode += f" of {settings.frame}"
    step = f"step {settings.increment:g}\N{DEGREE SIGN}/mm"
    return "\n".join(
        (
            f"state {status.state.value}  keys {'ARMED' if armed else disarmed}",
            f"position {status.trust.value} {status.trust_age}: {status.trust_reason}"
            + _way_out(status, keys),
            f"{mode}  {step}  speed {settings.speed * 100:.0f}%",
            f"arrows: left right {_arrow(settings, 'left')}, up down {_arrow(settings, 'up')}",
        )
    )


def _way_out(status: Status, keys: Keyboard) -> str:
    """Name the key that makes a position trusted again."""
    confirms, reference = f" ({keys.label('confirm')} confirms)", f" ({keys.label('reference')})"
    return {Trust.REFERENCED: "", Trust.RESTORED: confirms}.get(status.trust, reference)


def _arrow(settings: Settings, key: str) -> str:
    pair = next(pair for pair in settings.pairs if pair.plus == key)
    return words(pair.axis(cartesian=settings.cartesian))


def joint_table(
    status: Status, model: ArmModel, settings: Settings, keys: Keyboard, width: int
) -> str:
    """List joints and gripper: keys, value, and the place between the limits."""
    angles = status.joints or (None,) * len(model.arm.limits)
    rows = [
        (
            _value(None if angle is None else math.degrees(angle), "\N{DEGREE SIGN}"),
            bar(angle, limit.low_rad, limit.high_rad, _bar_width(width)),
            (math.degrees(limit.low_rad), math.degrees(limit.high_rad)),
        )
        for angle, limit in zip(angles, model.arm.limits, strict=True)
    ]
    range_mm = model.gripper_range_mm
    grip = bar(status.gripper_mm, *range_mm, _bar_width(width))
    rows.append((_value(status.gripper_mm, "mm"), grip, range_mm))
    return "\n".join(
        f"{_joint_keys(pair, settings, keys):<3} {words(pair.joint):<11}{value:>7} "
        f"{low:>4.0f} {place} {high:.0f}"
        for pair, (value, place, (low, high)) in zip(settings.rows, rows, strict=True)
    )


def _bar_width(width: int) -> int:
    """Return how long a bar may be beside the words and numbers of its row."""
    return min(max(width - ROW_WIDTH, SHORTEST_BAR), LONGEST_BAR)


def _joint_keys(pair: JogPair, settings: Settings, keys: Keyboard) -> str:
    """Return the keys of a row, where they move that joint in the present mode."""
    moves = pair.axis(cartesian=settings.cartesian) == pair.joint
    return f"{keys.jog(pair.plus)}/{keys.jog(pair.minus)}" if moves else ""


def bar(value: float | None, low: float, high: float, width: int) -> str:
    """Show where a value lies between two limits; `<` and `>` when it lies outside."""
    cells = ["-"] * width
    if value is None:
        return f"[{''.join(cells)}]"
    share = (value - low) / (high - low)
    place = min(max(round(share * (width - 1)), 0), width - 1)
    cells[place] = "<" if share < -_OUTSIDE else ">" if share > 1 + _OUTSIDE else "o"
    return f"[{''.join(cells)}]"


def tip_lines(status: Status, settings: Settings, keys: Keyboard) -> str:
    """Show the pose with the keys that move it in Cartesian mode."""
    pose = status.pose
    if pose is None:
        return f"tip: not known before the arm has a reference ({keys.label('reference')})"
    values = [
        (pose.x_mm, "mm"),
        (pose.y_mm, "mm"),
        (pose.z_mm, "mm"),
        (pose.pitch_deg, "\N{DEGREE SIGN}"),
        (pose.roll_deg, "\N{DEGREE SIGN}"),
    ]
    if pose.yaw_deg is not None:
        values.append((pose.yaw_deg, "\N{DEGREE SIGN}"))
    cells = []
    for pair, (value, unit) in zip(settings.rows, values, strict=False):
        both = f"{keys.jog(pair.plus)}/{keys.jog(pair.minus)}" if settings.cartesian else ""
        cells.append(f"{both:<3} {pair.cartesian:<5}{_value(value, unit):>9}")
    left, right = cells[:3], cells[3:]
    return "\n".join(f"{a:<19} {b}".rstrip() for a, b in zip_longest(left, right, fillvalue=""))


def bottom_lines(status: Status) -> str:
    """Say how the motors stand, what a stop takes, and what went over the wire."""
    return "\n".join(
        (
            f"motor current {status.current.value}" + _grip(status.gripping),
            f"steps {_steps(status.acknowledged)}",
            f"a stop takes at most {status.stop_time_s:.2f} s, {status.stop_distance_mm:.0f} mm"
            + _if_silent(status),
            f"sent {status.last_sent or '-'}",
            f"answer {status.last_answer or '-'}",
        )
    )


def _if_silent(status: Status) -> str:
    """Say what goes on if this program dies, where that is more than a stop's way."""
    if status.silent_time_s <= status.stop_time_s:
        return ""
    return f"\nif the link dies {status.silent_time_s:.2f} s, {status.silent_distance_mm:.0f} mm"


def _grip(gripping: bool | None) -> str:
    """Say how the grip switch stands; nothing where there is none, or nobody has looked yet."""
    if gripping is None:
        return ""
    return f"  grip switch {'CLOSED' if gripping else 'open'}"


def _steps(steps: Sequence[int] | None) -> str:
    return UNKNOWN if steps is None else " ".join(map(str, steps))


def _value(value: float | None, unit: str) -> str:
    return UNKNOWN if value is None else f"{round(value, 1) + 0.0:.1f}{unit}"
