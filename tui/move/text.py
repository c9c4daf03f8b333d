"""What the move screen says: the form, the motion as it would be, the confirmation, progress."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator

from armdrive.motion.frames import TOOL
from armdrive.motion.preview import PostureOption, Preview, clearance_words, margin_words
from armdrive.status import Status
from kinematics.guards.path import Clearance
from kinematics.spaces import Pose
from tui.keys.keyboard import Keyboard
from tui.move.form import GoalForm

NOTHING_ASKED = "type into a field, or step it with the arrows"
BAR = 24
"""Characters of the bar that shows progress."""

_BEYOND = re.compile(r"(\S+)° beyond its limit of \S+°")
"""What narrow lines say in fewer words."""


def way_text(form: GoalForm, keys: Keyboard) -> str:
    """Say how the goal is meant and gone to: mode, frame, line or joints, speed, step."""
    return "\n".join(_manner_lines(form, keys))


def _manner_lines(form: GoalForm, keys: Keyboard) -> Iterator[str]:
    mode, line = keys.label("move-mode"), keys.label("move-line")
    if form.cartesian:
        way = "straight line" if form.line else "joint motion"
        change = " (a change)" if form.frame == TOOL else ""
        yield f"POSE [{mode}]  {way} [{line}]"
        yield f"frame {form.frame}{change} [{keys.label('move-frame')}]"
    else:
        yield f"JOINTS [{mode}]  joint motion"
    slower, faster = keys.label("move-slower"), keys.label("move-faster")
    finer, coarser = keys.label("move-finer"), keys.label("move-coarser")
    yield f"speed {form.speed:.0%} [{slower} {faster}]  step {form.step:g} [{finer} {coarser}]"


def preview_text(preview: Preview, keys: Keyboard) -> str:
    """Say what the motion would be, or why it is refused and what is possible instead."""
    return "\n".join(_preview_lines(preview, keys))


def short_text(preview: Preview) -> str:
    """Say in few words what the motion would be, or why it is refused."""
    lines = [f"REFUSED: {_reason(each)}" for each in (preview.hindrance, preview.problem) if each]
    if preview.plan is None:
        return "\n".join(lines)
    near = [f"{each.guard} {round(each.clearance_mm)} mm" for each in preview.clearances[:2]]
    return "\n".join([*lines, _duration(preview), "  ".join(near), _stop(preview)])


def _preview_lines(preview: Preview, keys: Keyboard) -> Iterator[str]:
    for refusal in (preview.hindrance, preview.problem):
        if refusal is not None:
            yield f"REFUSED: {_reason(refusal)}"
    if preview.nearest is not None:
        share = preview.nearest.share
        part = "" if share >= 1.0 else f" ({share:.0%} of this way)"
        yield f"[{keys.label('move-nearest')}] possible instead{part}:"
        yield f"  {_pose(preview.nearest.pose)}"
    if preview.plan is not None:
        yield _duration(preview)
        yield _stop(preview)
        if preview.margin is not None:
            yield margin_words(preview.margin)
        yield from (clearance_words(preview, each) for each in _clearances(preview))
        if preview.plan.note:
            yield preview.plan.note
    yield from _way_lines(preview, keys)


def _way_lines(preview: Preview, keys: Keyboard) -> Iterator[str]:
    yield from (_way_line(way) for way in preview.ways)
    if any(way.allowed and not way.taken for way in preview.ways):
        yield f"  [{keys.label('move-posture')}] takes another one that is allowed"


def _clearances(preview: Preview) -> Iterator[Clearance]:
    """Yield the table's clearance and the nearest other one."""
    table = [each for each in preview.clearances if each.guard == "table"]
    others = [each for each in preview.clearances if each.guard != "table"]
    yield from (*table, *others[:1])


def _way_line(way: PostureOption) -> str:
    sign = "*" if way.taken else "-"
    name = way.name or "nearest posture found"
    because = "taken" if way.taken else _BEYOND.sub(r"\1° too far", way.against.split(";")[0])
    return f"{sign} {name}: {because}"


def _stop(preview: Preview) -> str:
    """Say how much a stop on the way takes at most."""
    return f"a stop takes up to {preview.stop_time_s:.2f} s, {preview.stop_distance_mm:.0f} mm"


def _duration(preview: Preview) -> str:
    """Say how long it takes; how slow the arm may be is not known before it has moved."""
    planned, slowest = f"{preview.duration_s:.1f} s", f"{preview.slowest_s:.1f} s"
    return f"takes {planned}" + f" ({slowest} if the arm is slow)" * (slowest != planned)


def _reason(refusal: Exception) -> str:
    """Return a refusal without the goal, and without what is nearest: both have their lines."""
    reason = str(getattr(refusal, "reason", refusal))
    return reason.split("; nearest pose")[0]


def _pose(pose: Pose) -> str:
    x, y, z = pose.x_mm, pose.y_mm, pose.z_mm
    pitch = math.degrees(pose.pitch_rad)
    return f"x {x:.1f}  y {y:.1f}  z {z:.1f} mm  pitch {pitch:.1f}°"


def ready_text(preview: Preview | None, keys: Keyboard) -> str:
    """Say how the motion is begun; nothing where it would be refused."""
    if preview is None or preview.refusal is not None:
        return ""
    return f"{keys.label('move-go')} twice moves the arm like this"


def again_text(keys: Keyboard) -> str:
    """Say that a second press is waited for."""
    return f"{keys.label('move-go')} AGAIN MOVES THE ARM; a change takes that back"


def progress_text(share: float, keys: Keyboard) -> str:
    """Say how far the arm is, in a bar and a number, and how it is stopped."""
    return f"MOVING {progress_bar(share)}\n{keys.label('stop')} stops it"


def progress_bar(share: float) -> str:
    """Return a share of 1 as a bar and a number."""
    full = round(share * BAR)
    return f"[{'#' * full}{'-' * (BAR - full)}] {share:.0%}"


def arrived(status: Status) -> str:
    """Say where the arm is."""
    return "arrived" if status.pose is None else f"arrived: {_pose(status.pose)}"
