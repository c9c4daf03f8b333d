"""Routes: joint motions, straight lines and arcs one after another, and blends between them.

Units: mm and rad. A route becomes sections: corners of a path in joint space that is passed
without stopping, at rest at its ends. Lines and arcs are cut by chords.py, blends made by
blends.py, parts laid end to end by laying.py.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

from kinematics.arm_geometry import ArmGeometry
from kinematics.blends import Blend, blend
from kinematics.chords import STILL_RAD, Chord, corners, cut, smooth, trim
from kinematics.errors import PathBroken
from kinematics.laying import Laid, lay
from kinematics.moves import Move
from kinematics.paths import LINE_TOLERANCE_MM
from kinematics.spaces import Joints


@dataclass(frozen=True, slots=True)
class Route:
    """Where the arm begins, and what it does from there, in order."""

    start: Joints
    parts: tuple[Move, ...]


@dataclass(frozen=True, slots=True)
class PathSection:
    """A path that is passed without stopping: at rest at its first corner and at its last.

    Between corners every joint turns in proportion. `parts` are the numbers, from 1, of the parts
    of the route that it consists of. For each of them `blends_mm` is the radius of the blend at
    its end: how far the tip is from the end of the part, at most, while it passes. It may be less
    than was asked for; for the last part, where the arm stops, it is 0.
    """

    corners: tuple[Joints, ...]
    parts: tuple[int, ...]
    blends_mm: tuple[float, ...]


def route_sections(
    arm: ArmGeometry, route: Route, tolerance_mm: float = LINE_TOLERANCE_MM
) -> tuple[PathSection, ...]:
    """Return the sections of a route; a stop is where one ends and the next begins.

    All lines and arcs of the route are followed in one posture of the arm. Between corners the
    tip is never further than `tolerance_mm` from the line, the arc or the blend. At a corner the
    path's direction in joint space turns by at most 15 degrees, unless the joints turn by less
    than a thousandth of a rad there (chords.py).

    Joint motions are not checked against joint limits, nor anything against guards: whoever
    drives looks at all the corners. Raises `PathBroken`, which names the part and the point, and
    `NoArc`.
    """
    if not route.parts:
        return ()
    laid = lay(arm, route.start, route.parts, tolerance_mm)
    blends = [
        blend(arm, here.chords, after.chords, here.move.blend_mm) for here, after in pairwise(laid)
    ]
    return tuple(
        _section(arm, run, joins, tolerance_mm) for run, joins in _runs(laid, [*blends, None])
    )


def _runs(
    laid: Sequence[Laid], blends: Sequence[Blend | None]
) -> Iterator[tuple[list[Laid], list[Blend]]]:
    """Yield the parts that no stop divides, and the blends between them."""
    run: list[Laid] = []
    joins: list[Blend] = []
    for part, join in zip(laid, blends, strict=True):
        run.append(part)
        if join is None:
            yield run, joins
            run, joins = [], []
        else:
            joins.append(join)


def _section(
    arm: ArmGeometry, run: Sequence[Laid], joins: Sequence[Blend], tolerance_mm: float
) -> PathSection:
    leaves = [*(join.leave for join in joins), 1.0]
    enters = [0.0, *(join.enter for join in joins)]
    chords: list[Chord] = []
    for part, enter, leave, join in zip(run, enters, leaves, [*joins, None], strict=True):
        _append(chords, trim(part.chords, enter, leave))
        if join is None:
            break
        try:
            _append(chords, cut(arm, join.curve, chords[-1].end, tolerance_mm))
        except PathBroken as broken:
            raise broken.of_part(part.number) from None
    return PathSection(
        corners(smooth(_moving(chords))),
        tuple(part.number for part in run),
        (*(join.radius_mm for join in joins), 0.0),
    )


def _append(chords: list[Chord], more: Sequence[Chord]) -> None:
    """Add chords that begin, but for rounding, where the others end."""
    for chord in more:
        chords.append(chord._replace(start=chords[-1].end) if chords else chord)


def _moving(chords: Sequence[Chord]) -> list[Chord]:
    """Return the chords without those in which nothing turns; the ends stay what they are."""
    found: list[Chord] = []
    for chord in chords:
        if max(abs(b - a) for a, b in zip(chord.start, chord.end, strict=True)) > STILL_RAD:
            found.append(chord._replace(start=found[-1].end) if found else chord)
    found = found or [chords[-1]]
    found[0] = found[0]._replace(start=chords[0].start)
    found[-1] = found[-1]._replace(end=chords[-1].end)
    return found
