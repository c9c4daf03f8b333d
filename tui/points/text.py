"""What the points screen says: the list, the chosen point or sequence, the name being typed."""

from __future__ import annotations

from collections.abc import Iterator

from armdrive.programs.teaching.sequence import Stepper
from armdrive.storage.points import Point
from kinematics.geometry import ArmGeometry
from tui.keys.keyboard import Keyboard
from tui.keys.table import words
from tui.painting import Span
from tui.points.list import PointList, PointNaming
from tui.program.lines import CURRENT_STYLE, DONE_STYLE

NAME_WIDTH = 16
STEPS_SHOWN = 9
"""Steps of a sequence that are shown about the next one."""

_PURPOSES = {
    "teach": "name of this place",
    "rename": "new name",
    "append": "sequence to put it at the end of",
    "to": "point to go to",
    "gripper": "fingers: open, close, grasp, here, point, or mm",
    "wait": "seconds to wait",
}
_WRONG = {
    "to": "no name of a point",
    "gripper": "none of these",
    "wait": "no time",
}
_WRONG_NAME = "a letter first, then letters, digits, - _"


def list_rows(listed: PointList, arm: ArmGeometry) -> list[str]:
    """Return a row for each point and sequence."""
    return [
        f"{name[:NAME_WIDTH]:<{NAME_WIDTH}} "
        + (
            f"sequence, {len(listed.taught.sequences[name].steps)} steps"
            if is_sequence
            else _tip(listed.taught.points[name], arm)
        )
        for is_sequence, name in listed.rows
    ]


def none_yet(keys: Keyboard) -> str:
    """Say how the first point is made."""
    return f"no points yet: {keys.label('points-teach')} names the place where the arm stands"


def _tip(point: Point, arm: ArmGeometry) -> str:
    x, y, z = arm.points(point.joints)[-1]
    return f"x {x:.0f}  y {y:.0f}  z {z:.0f}"


def point_text(point: Point) -> str:
    """Say all that is known of a point."""
    lines = [
        "  ".join(f"{words(name)} {angle:.1f}°" for name, angle in point.joints.deg.items()),
    ]
    if point.opening_mm is not None:
        lines.append(f"fingers {point.opening_mm:.1f} mm, (unchanged)")
    taught = "" if point.taught is None else f"taught {point.taught:%Y-%m-%d %H:%M}"
    lines += [part for part in (taught, point.note) if part]
    return "\n".join(lines)


def sequence_lines(
    stepper: Stepper, keys: Keyboard, *, stepping: bool, marked: int | None = None
) -> Iterator[Span]:
    """Lay the steps out around the next or the marked one, and say what the keys would do."""
    total, middle = len(stepper.steps), stepper.at if marked is None else marked
    first = max(min(middle - STEPS_SHOWN // 2, total - STEPS_SHOWN), 0)
    for index, step in enumerate(stepper.steps[first : first + STEPS_SHOWN], first):
        mark = (">" if index == stepper.at else " ") + ("*" if index == marked else " ")
        style = CURRENT_STYLE if index == stepper.at else DONE_STYLE * (index < stepper.at)
        yield f"{mark}{index + 1:>3} {'done ' * (index < stepper.at)}{step}", style
    for line in _step_keys(stepper, keys, stepping=stepping, marked=marked is not None):
        yield line, ""


def _step_keys(stepper: Stepper, keys: Keyboard, *, stepping: bool, marked: bool) -> Iterator[str]:
    if marked:
        drop, sooner = keys.label("points-step-drop"), keys.label("points-step-sooner")
        later, change = keys.label("points-step-later"), keys.label("points-step-change")
        yield f"* {change} changes it, {drop} twice: out; {sooner} {later}: sooner, later"
    grip, wait = keys.label("points-grip"), keys.label("points-wait")
    yield f"{grip} adds a gripper step, {wait} a wait"
    if stepper.at == len(stepper.steps):
        yield f"at its end: {keys.label('points-rewind')} starts over"
    switch = keys.label("points-stepping")
    if not stepping:
        yield f"{switch} lets single steps be made"
        return
    yield f"STEPPING [{switch}]  {keys.label('points-forward')} next step"
    if stepper.before is not None:
        yield f"{keys.label('points-backward')} back to {stepper.before[1]}"


def how_text(*, line: bool, speed: float, keys: Keyboard) -> str:
    """Say how a point is gone to."""
    way = "straight line" if line else "joint motion"
    slower, faster = keys.label("points-slower"), keys.label("points-faster")
    return f"{way} [{keys.label('points-line')}]  speed {speed:.0%} [{slower} {faster}]"


def naming_text(naming: PointNaming, keys: Keyboard) -> str:
    """Show the name as it is typed."""
    enter, stop = keys.label("points-go"), keys.label("stop")
    reason = _WRONG.get(naming.purpose, _WRONG_NAME)
    wrong = "" if naming.good or not naming.text else f"  ({reason})"
    hint = "  (or type another)" if naming.offered else wrong
    return f"{_PURPOSES[naming.purpose]}: {naming.text}_{hint}\n{enter} takes it, {stop} drops it"
