"""A preview for people, line by line, and as plain data for programs."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from armdrive.status import joints_view, pose_view

if TYPE_CHECKING:
    from collections.abc import Iterator

    from armdrive.motion.preview import Margin, Preview, Way
    from kinematics.guards.path import Clearance

MARGINS_SAID = 2
CLEARANCES_SAID = 3
"""How many of the nearest bounds a person is told; programs get them all."""


def preview_lines(preview: Preview) -> Iterator[str]:
    """Yield what a person wants to know before the arm moves."""
    for way in preview.ways:
        yield way_line(way)
    if preview.plan is not None:
        yield f"leads to {preview.plan.end.joints}"
        yield duration_words(preview)
        yield from (margin_words(one) for one in preview.margins[:MARGINS_SAID])
        yield from (clearance_words(preview, one) for one in preview.clearances[:CLEARANCES_SAID])
        yield (
            f"a stop on the way takes at most {preview.stop_time_s:.2f} s and "
            f"{preview.stop_distance_mm:.0f} mm"
        )
    for refusal in (preview.hindrance, preview.problem):
        if refusal is not None:
            yield f"refused: {refusal}"
    if preview.nearest is not None:
        yield nearest_words(preview)


def way_line(way: Way) -> str:
    """Say which posture it is, and why it is taken or not."""
    sign = "->" if way.taken else "  "
    because = "taken" if way.taken else way.against
    return f"{sign} {way.name or 'the nearest posture found':<22} {way.joints}   ({because})"


def duration_words(preview: Preview) -> str:
    """Say how long it takes, with a slow arm too where that is longer."""
    planned, slowest = f"{preview.duration_s:.1f} s", f"{preview.slowest_s:.1f} s"
    slow = f", about {slowest} with an arm that is as slow as it may be"
    return f"takes {planned}" + slow * (slowest != planned)


def margin_words(margin: Margin) -> str:
    """Say how near a joint comes to its limit."""
    away, bound = math.degrees(margin.margin_rad), math.degrees(margin.bound_rad)
    name = margin.joint.replace("_", " ")
    return f"{name} stays {away:.1f}° from its limit of {bound:.1f}°"


def clearance_words(preview: Preview, clearance: Clearance) -> str:
    """Say how near the arm comes to a guard, and where."""
    share = share_of_way(preview, clearance.index)
    where = {0.0: "at the start", 1.0: "at the goal"}.get(share, f"{share:.0%} of the way")
    return f"{clearance.guard}: {round(clearance.clearance_mm)} mm ({clearance.quantity}), {where}"


def share_of_way(preview: Preview, index: int) -> float:
    """Return the share of the way at which one of its postures is."""
    last = len(preview.postures) - 1
    return index / last if last > 0 else 1.0


def nearest_words(preview: Preview) -> str:
    """Say where the arm could go instead."""
    nearest = preview.nearest
    if nearest is None:
        return ""
    part = "" if nearest.share >= 1.0 else f"{nearest.share:.0%} of this way is free: "
    return f"possible instead: {part}{nearest.pose}, at {nearest.joints}"


def preview_view(preview: Preview) -> dict[str, Any]:
    """Return a preview as plain data, with units in the names."""
    from armdrive.errors.table import error_view

    refusal, nearest = preview.refusal, preview.nearest
    return {
        "possible": preview.possible,
        "refusal": None if refusal is None else error_view(refusal),
        "start": joints_view(preview.start),
        "end": joints_view(preview.end),
        "goal": pose_view(preview.goal),
        "ways": [
            {
                "name": way.name,
                "joints": joints_view(way.joints),
                "taken": way.taken,
                "allowed": way.allowed,
                "against": way.against,
            }
            for way in preview.ways
        ],
        "duration_s": round(preview.duration_s, 3),
        "slowest_s": round(preview.slowest_s, 3),
        "margins": [
            {
                "joint": one.joint,
                "margin_deg": round(math.degrees(one.margin_rad), 3),
                "bound_deg": round(math.degrees(one.bound_rad), 3),
                "share": round(share_of_way(preview, one.index), 4),
            }
            for one in preview.margins
        ],
        "clearances": [
            {
                "guard": one.guard,
                "of": one.quantity,
                "clearance_mm": round(one.clearance_mm, 2),
                "share": round(share_of_way(preview, one.index), 4),
            }
            for one in preview.clearances
        ],
        "stop_time_s": round(preview.stop_time_s, 3),
        "stop_distance_mm": round(preview.stop_distance_mm, 1),
        "nearest": None
        if nearest is None
        else {
            "pose": pose_view(nearest.pose),
            "joints": joints_view(nearest.joints),
            "share": round(nearest.share, 4),
        },
        "path_mm": [[round(each, 2) for each in point] for point in preview.path],
    }
