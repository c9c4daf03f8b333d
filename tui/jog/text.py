"""The words and numbers of the jog screen, as plain text made from a status."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import zip_longest

from armdrive import Grasped
from armdrive.abilities import OUTPUTS
from armdrive.motion.frames import BASE
from armdrive.registry import DIALECTS
from armdrive.status import LinkStats, Status, Trust
from kinematics.presets import ArmModel
from kinematics.spaces import Pose
from tui.keys.keyboard import Keyboard
from tui.keys.table import JogPair, words
from tui.settings import JogSettings

ROW_WIDTH = 34
"""What a row of the joint table takes beside its bar."""

SHORTEST_BAR, LONGEST_BAR = 7, 20
WIDEST_ROW = ROW_WIDTH + LONGEST_BAR
"""A row of a table needs no more, however wide the terminal is."""

UNKNOWN = "?"

STOP_SCALE_MM = 100.0
"""The stop bar is full at so much."""

_OUTSIDE = 0.002  # share of a range: less than any printed digit of it


def conduct(status: Status, settings: JogSettings, keys: Keyboard, *, armed: bool) -> str:
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


def _arrow(settings: JogSettings, key: str) -> str:
    pair = next(pair for pair in settings.pairs if pair.plus == key)
    return words(pair.axis(cartesian=settings.cartesian))


def joint_table(
    status: Status, model: ArmModel, settings: JogSettings, keys: Keyboard, width: int
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
    lines = [
        _row(_joint_keys(pair, settings, keys), pair, *row)
        for pair, row in zip(settings.rows[:-1], rows, strict=True)
    ]
    if not settings.cartesian:
        lines.append(_gripper_row(status, model, settings, keys, width))
    return "\n".join(lines)


def _gripper_row(
    status: Status, model: ArmModel, settings: JogSettings, keys: Keyboard, width: int
) -> str:
    """Return the gripper's row: the last one of whatever table is jogged."""
    pair, range_mm = settings.rows[-1], model.gripper_range_mm
    place = bar(status.gripper_mm, *range_mm, _bar_width(width))
    both = _joint_keys(pair, settings, keys)
    return _row(both, pair, _value(status.gripper_mm, "mm"), place, range_mm)


def _row(both: str, pair: JogPair, value: str, place: str, bounds: tuple[float, float]) -> str:
    low, high = bounds
    return f"{_begun(both, pair.joint, value)} {low:>4.0f} {place} {high:.0f}"


def _bar_width(width: int) -> int:
    """Return how long a bar may be beside the words and numbers of its row."""
    return min(max(width - ROW_WIDTH, SHORTEST_BAR), LONGEST_BAR)


def _joint_keys(pair: JogPair, settings: JogSettings, keys: Keyboard) -> str:
    """Return the keys of a row, where they move that joint in the present mode."""
    moves = pair.axis(cartesian=settings.cartesian) == pair.joint
    return _both(pair, keys) if moves else ""


def bar(value: float | None, low: float, high: float, width: int) -> str:
    """Show where a value lies between two limits; `<` and `>` when it lies outside."""
    cells = ["-"] * width
    if value is None:
        return f"[{''.join(cells)}]"
    share = (value - low) / (high - low)
    place = min(max(round(share * (width - 1)), 0), width - 1)
    cells[place] = "<" if share < -_OUTSIDE else ">" if share > 1 + _OUTSIDE else "o"
    return f"[{''.join(cells)}]"


def tip_lines(
    status: Status,
    model: ArmModel,
    settings: JogSettings,
    keys: Keyboard,
    width: int,
    pose: Pose | None,
) -> str:
    """Show a pose of the tip: a row for each key in Cartesian mode, else in as few lines as go."""
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
    pairs = zip(settings.rows, (_value(*value) for value in values), strict=False)
    if settings.cartesian:
        lines = [_begun(_both(pair, keys), pair.cartesian, value) for pair, value in pairs]
        return "\n".join([*lines, _gripper_row(status, model, settings, keys, width)])
    texts = [f"    {pair.cartesian:<5}{value:>9}" for pair, value in pairs]
    columns = zip_longest(texts[:3], texts[3:], fillvalue="")
    return "\n".join(f"{a:<19} {b}".rstrip() for a, b in columns)


def _begun(both: str, axis: str, value: str) -> str:
    """Return how a row of either table begins: its keys, what they move, and where that is."""
    return f"{both:<3} {words(axis):<11}{value:>7}"


def _both(pair: JogPair, keys: Keyboard) -> str:
    """Return both keys of a pair."""
    return f"{keys.jog(pair.plus)}/{keys.jog(pair.minus)}"


def bottom_lines(status: Status, width: int, force_n: float, load: float | None) -> str:
    """Say what a stop takes, how the gripper and the motors stand, and what the wire carries.

    `load` is the share of what the wire could carry, None where that is not known.
    """
    lines = (
        stop_bar(status, width),
        _if_silent(status),
        quicker(status.dialect, width),
        _grip(status.gripping, force_n),
        f"motors {status.current.value}  steps {_steps(status.acknowledged)}",
        _bits("inputs", status.inputs, _inputs(status.dialect))
        + _bits("outputs", status.outputs, OUTPUTS),
        _wire(status, load),
        f"sent {status.last_sent or '-'}",
        f"answer {status.last_answer or '-'}",
    )
    return "\n".join(line.strip() for line in lines if line)


def stop_bar(status: Status, width: int) -> str:
    """Show how far the tip goes on when it is stopped now, at most, as a bar and in numbers."""
    text = f"{status.stop_distance_mm:.0f} mm, {status.stop_time_s:.2f} s at most"
    room = min(max(width - len(text) - 8, SHORTEST_BAR), LONGEST_BAR)
    share = status.stop_distance_mm / STOP_SCALE_MM
    full = min(math.ceil(share * room - _OUTSIDE), room)
    cells = "#" * full + "-" * (room - full)
    return f"stop [{cells[:-1] + '>' if share > 1.0 else cells}] {text}"


def quicker(dialect: str, width: int) -> str:
    """Say what stops such an arm quicker than this program; in short where there is little room."""
    row = DIALECTS.get(dialect)
    if row is None:
        return ""
    return row.quick_stop if width >= len(row.quick_stop) else row.quick_stop.partition(":")[0]


def _wire(status: Status, load: float | None) -> str:
    """Say how much of the wire is used."""
    if load is None:
        return ""
    return f"wire {load:.0%} of {status.link_stats.baud} baud"


def _inputs(dialect: str) -> int:
    """Return how many inputs such an arm tells."""
    row = DIALECTS.get(dialect)
    return 0 if row is None else row.abilities.inputs


def _bits(name: str, value: int | None, lines: int) -> str:
    """Show digital lines, the lowest first: by its number where one is on, else by a dot."""
    if value is None or not lines:
        return ""
    shown = (str(n + 1) if value >> n & 1 else "." for n in range(lines))
    return f"{name} {' '.join(shown)}  "


def _if_silent(status: Status) -> str:
    """Say what goes on if this program dies, where that is more than a stop's way."""
    if status.silent_time_s <= status.stop_time_s:
        return ""
    return f"if the link dies {status.silent_time_s:.2f} s, {status.silent_distance_mm:.0f} mm"


def _grip(gripping: bool | None, force_n: float) -> str:
    """Say how the grip switch stands and what is pressed; nothing where there is no switch."""
    force = f"  pressing {force_n:.1f} N" if force_n > 0.0 else ""
    if gripping is None:
        return force.strip()
    return f"grip switch {'CLOSED' if gripping else 'open'}{force}"


def _steps(steps: Sequence[int] | None) -> str:
    return UNKNOWN if steps is None else " ".join(map(str, steps))


def _value(value: float | None, unit: str) -> str:
    return UNKNOWN if value is None else f"{round(value, 1) + 0.0:.1f}{unit}"


def grasped(found: Grasped) -> str:
    """Say what the fingers found."""
    if not found.holding:
        return "the fingers met each other: nothing is between them"
    return f"grasped: {found.width_mm:.1f} mm wide, pressed with {found.force_n:.1f} N"


# The load of the wire over the last moments, from two statuses.

OVER_S = 1.0
"""The load is that of at least so long, lest it flickers."""


class Load:
    """Remembers what the wire had carried a while ago."""

    def __init__(self) -> None:
        self._then: LinkStats | None = None
        self._then_s = 0.0
        self._load: float | None = None

    def of(self, now: LinkStats, now_s: float) -> float | None:
        """Return the share of the wire that is used; None where that cannot be known yet."""
        then = self._then
        if then is None or then.baud != now.baud or now.sent < then.sent:
            self._then, self._then_s, self._load = now, now_s, None  # another wire
        elif now_s - self._then_s >= OVER_S:
            self._load = now.load(then, now_s - self._then_s)
            self._then, self._then_s = now, now_s
        return self._load
