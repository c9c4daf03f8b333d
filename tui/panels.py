"""The words and numbers beside the drawing, as plain text made from a status."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import zip_longest
from typing import TYPE_CHECKING

from armdrive.frames import BASE
from armdrive.status import State, Status, Trust, coded
from tui.keys import JogPair, label, words
from tui.settings import Settings

if TYPE_CHECKING:
    from kinematics import ArmModel

ROW_WIDTH = 34
"""What a row of the joint table takes beside its bar."""

SHORTEST_BAR, LONGEST_BAR = 7, 20

UNKNOWN = "?"
DISARMED = "DISARMED (enter arms)"
LOOK_FOR_IT = "L looks for it, q leaves"

_OUTSIDE = 0.002  # share of a range: less than any printed digit of it


def title(status: Status, width: int) -> str:
    """Say which arm this is and whether it is real, the latter first lest it is cut off."""
    kind = "SIMULATED" if status.simulated else "REAL ARM"
    return f"{kind}: {status.arm} ({status.title}) on {status.link}"[:width]


def banner(status: Status, *, looked_for: bool = False) -> str:
    """Say what forbids all motion, and what to do; nothing while nothing does.

    `looked_for` says that a lost link is looked for without anybody asking.
    """
    reason = (
        coded(status.error, status.error_code)
        or coded(status.notice, status.notice_code)
        or coded(status.trust_reason, status.trust_code)
    )
    if status.state is State.DISCONNECTED:
        way = "It is being looked for: L looks at once, q leaves" if looked_for else LOOK_FOR_IT
        return f"LINK LOST: {reason.rstrip('.')}. {way}."
    if status.state is State.ERROR_STOP:
        return f"ERROR-STOP: {reason}. R resets, and moves nothing."
    if status.paused:
        return "PAUSED from outside: `armdrive resume` lets the arm go on, space ends its motion."
    if status.speed_override < 1.0:
        return f"SLOWED from outside to {status.speed_override:.0%}: `armdrive slow 100` ends that."
    return ""


def link_back(status: Status) -> str:
    """Say what a link that came back has ended in: what is trusted, why, and what to do next."""
    first = {State.ERROR_STOP: "R resets, then ", State.DISABLED: "P switches the motors on, then "}
    then = "C compares it" if status.trust is Trust.RESTORED else "H references it"
    return (
        f"the link is back, and nothing was moved. The position is {status.trust.value}: "
        f"{status.trust_reason}. Look at the arm: {first.get(status.state, '')}{then}"
    )


def after_reset(status: Status) -> str:
    """Say what a reset has led to."""
    off = status.state is State.DISABLED
    return "reset: nothing was moved" + ("; P switches the motors on" if off else "")


def conduct(status: Status, settings: Settings, *, armed: bool) -> str:
    """Say what state the arm and the keys are in."""
    mode = f"mode {settings.space.value.upper()}"
    if settings.cartesian and settings.frame != BASE:
        mode += f" of {settings.frame}"
    step = f"step {settings.increment:g}\N{DEGREE SIGN}/mm"
    return "\n".join(
        (
            f"state {status.state.value}  keys {'ARMED' if armed else DISARMED}",
            f"position {status.trust.value} {status.trust_age}: {status.trust_reason}"
            + _way_out(status),
            f"{mode}  {step}  speed {settings.speed * 100:.0f}%",
            f"arrows: left right {_arrow(settings, 'left')}, up down {_arrow(settings, 'up')}",
        )
    )


def _way_out(status: Status) -> str:
    """Name the key that makes a position trusted again."""
    return {Trust.REFERENCED: "", Trust.RESTORED: " (C confirms)"}.get(status.trust, " (H)")


def _arrow(settings: Settings, key: str) -> str:
    pair = next(pair for pair in settings.pairs if pair.plus == key)
    return words(pair.axis(cartesian=settings.cartesian))


def joint_table(status: Status, model: ArmModel, settings: Settings, width: int) -> str:
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
        f"{_joint_keys(pair, settings):<3} {words(pair.joint):<11}{value:>7} "
        f"{low:>4.0f} {place} {high:.0f}"
        for pair, (value, place, (low, high)) in zip(settings.rows, rows, strict=True)
    )


def _bar_width(width: int) -> int:
    """Return how long a bar may be beside the words and numbers of its row."""
    return min(max(width - ROW_WIDTH, SHORTEST_BAR), LONGEST_BAR)


def _joint_keys(pair: JogPair, settings: Settings) -> str:
    """Return the keys of a row, where they move that joint in the present mode."""
    moves = pair.axis(cartesian=settings.cartesian) == pair.joint
    return f"{pair.plus}/{pair.minus}" if moves else ""


def bar(value: float | None, low: float, high: float, width: int) -> str:
    """Show where a value lies between two limits; `<` and `>` when it lies outside."""
    cells = ["-"] * width
    if value is None:
        return f"[{''.join(cells)}]"
    share = (value - low) / (high - low)
    place = min(max(round(share * (width - 1)), 0), width - 1)
    cells[place] = "<" if share < -_OUTSIDE else ">" if share > 1 + _OUTSIDE else "o"
    return f"[{''.join(cells)}]"


def tip_lines(status: Status, settings: Settings) -> str:
    """Show the pose with the keys that move it in Cartesian mode."""
    pose = status.pose
    if pose is None:
        return "tip: not known before the arm has a reference (H)"
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
        keys = f"{label(pair.plus)}/{label(pair.minus)}" if settings.cartesian else ""
        cells.append(f"{keys:<3} {pair.cartesian:<5}{_value(value, unit):>9}")
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


def remarks(status: Status, message: str) -> str:
    """Say what the desk and the arm have to say, each remark once."""
    if message and message in status.notice:
        message = ""  # what the desk was told is what the arm noticed
    said = (message, status.notice, "" if banner(status) else status.error)
    return "\n".join(f"! {remark}" for remark in dict.fromkeys(said) if remark)


def _grip(gripping: bool | None) -> str:
    """Say how the grip switch stands; nothing where there is none, or nobody has looked yet."""
    if gripping is None:
        return ""
    return f"  grip switch {'CLOSED' if gripping else 'open'}"


def _steps(steps: Sequence[int] | None) -> str:
    return UNKNOWN if steps is None else " ".join(map(str, steps))


def _value(value: float | None, unit: str) -> str:
    return UNKNOWN if value is None else f"{round(value, 1) + 0.0:.1f}{unit}"
