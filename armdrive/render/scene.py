"""The picture of one arm in space over time.

`ArmDrawing.space(moment)` makes the layers for a posture, a goal and a planned path: what stays
(table, base, guards), and what moves over it (arm, trail, ghost, reach). `Studio.draw` turns them
into cells, through a camera. A desk draws this at each poll of a moving arm, therefore what stays
is drawn once for each camera and size, and copied.

The outline of the reach takes too long for a poll. `ArmDrawing.missing` names the one that is
wanted, the caller has `work_out` compute it in a thread, and gives it back to `keep`.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import product

from armdrive.render.camera import VIEWS, Camera, Dome, Projection, projection, side_of
from armdrive.render.canvas import PATTERNS, Ink, Layer, Letters, Painted, Raster, Stroke
from armdrive.render.figure import Stance, dome, figure, ghost, stance
from kinematics.five_axis import FiveAxisArm
from kinematics.five_axis.workspace import section
from kinematics.geometry import ArmGeometry, Point
from kinematics.guards import Guards
from kinematics.guards.shapes import Box
from kinematics.limits import sampled
from kinematics.presets import ArmModel
from kinematics.spaces import Joints

# --- What surrounds an arm ----------------------------------------------------------------------

GRID_MM = 100.0  # size of the squares on the table
_FOOT = 0.13  # radius of a base of unknown size, as a share of the reach

_CORNERS = 36
_NAME_LENGTH = 10


def surroundings(arm: ArmGeometry, guards: Guards, dome: Dome) -> Layer:
    """Return everything that does not move: table with axes, base column, boxes and radii."""
    return (
        _table(dome)
        + _turn(arm, dome)
        + _base(guards, dome)
        + _radii(guards)
        + _boxes(guards.boxes, Ink.GUARD)
    )


def _table(dome: Dome) -> Layer:
    """Return the squares of the table within the arm's reach, and the letters of its axes."""
    count = math.floor(dome.reach_mm / GRID_MM)
    lines = []
    for index in range(-count, count + 1):
        at = index * GRID_MM
        half = math.sqrt(max(dome.reach_mm**2 - at**2, 0.0))
        lines.append(((at, -half, 0.0), (at, half, 0.0)))
        lines.append(((-half, at, 0.0), (half, at, 0.0)))
    strokes = tuple(Stroke(Ink.TABLE, line) for line in lines)
    letters = (
        Letters(Ink.TABLE, (dome.reach_mm, 0.0, 0.0), "X"),
        Letters(Ink.TABLE, (0.0, dome.reach_mm, 0.0), "Y"),
    )
    return Layer(strokes, letters)


def _turn(arm: ArmGeometry, dome: Dome) -> Layer:
    """Return the limits of the base joint as lines, if it cannot make a full turn."""
    base = arm.limits[0]
    if base.high_rad - base.low_rad >= math.tau:
        return Layer()
    x, y, _ = dome.centre
    bounds = tuple(
        Stroke(
            Ink.REACH,
            (
                (x, y, 0.0),
                (x + dome.reach_mm * math.cos(angle), y + dome.reach_mm * math.sin(angle), 0.0),
            ),
        )
        for angle in (base.low_rad, base.high_rad)
    )
    return Layer(bounds)


def _base(guards: Guards, dome: Dome) -> Layer:
    """Return the base column from the guards, or else a circle on the table."""
    x, y, _ = dome.centre
    if guards.base_radius_mm is None:
        return Layer((Stroke(Ink.BASE, _ring(x, y, dome.reach_mm * _FOOT, 0.0)),))
    radius, top = guards.base_radius_mm, guards.base_top_mm
    rings = tuple(Stroke(Ink.BASE, _ring(x, y, radius, z)) for z in (0.0, top))
    posts = tuple(
        Stroke(Ink.BASE, ((px, py, 0.0), (px, py, top)))
        for px, py, _ in _ring(x, y, radius, 0.0)[: -1 : _CORNERS // 4]
    )
    return Layer((*rings, *posts))


def _radii(guards: Guards) -> Layer:
    """Return the circles on the table that limit the radius of the tip."""
    radii = (guards.inner_radius_mm, guards.outer_radius_mm)
    return Layer(
        tuple(Stroke(Ink.GUARD, _ring(0.0, 0.0, one, 0.0)) for one in radii if one is not None)
    )


def _boxes(boxes: Iterable[Box], ink: Ink) -> Layer:
    """Return the edges of boxes, each with its shortened name on top."""
    boxes = tuple(boxes)
    strokes = tuple(Stroke(ink, edge) for box in boxes for edge in _edges(box))
    return Layer(
        strokes, tuple(Letters(ink, _above(box), box.name[:_NAME_LENGTH]) for box in boxes)
    )


def _edges(box: Box) -> Iterator[tuple[Point, Point]]:
    """Yield the twelve edges: pairs of corners that differ in one coordinate."""
    corners: list[Point] = [
        (x, y, z) for x, y, z in product(*zip(box.min_mm, box.max_mm, strict=True))
    ]
    for index, one in enumerate(corners):
        for other in corners[index + 1 :]:
            if sum(a != b for a, b in zip(one, other, strict=True)) == 1:
                yield one, other


def _above(box: Box) -> Point:
    (x0, y0, _), (x1, y1, z1) = box.min_mm, box.max_mm
    return (x0 + x1) / 2.0, (y0 + y1) / 2.0, z1


def _ring(x: float, y: float, radius: float, z: float) -> tuple[Point, ...]:
    """Return a closed circle around a vertical axis."""
    angles = (math.tau * corner / _CORNERS for corner in range(_CORNERS + 1))
    return tuple((x + radius * math.cos(a), y + radius * math.sin(a), z) for a in angles)


# --- The trail: a limited number of the tip's latest points ---------------------------------------

MOST_POINTS = 400

# If the tip moves by this share of the reach between two updates, the position was changed.
#
# The fastest arm sweeps its whole reach in about a second, and updates are 0.05 s apart.
LEAP = 0.35

_SPACING = 0.008  # share of the reach; closer points would fall on the same dots


class Trail:
    """The recent path of the tip, oldest point first; it is interrupted if the position is lost."""

    def __init__(self, reach_mm: float) -> None:
        self._leap_mm = LEAP * reach_mm
        self._spacing_mm = _SPACING * reach_mm
        self._points: deque[Point | None] = deque([None], maxlen=MOST_POINTS)

    def add(self, tip: Point | None) -> None:
        """Add the position of the tip now, or None while it is unknown."""
        last = self._points[-1]
        if tip is not None and last is not None:
            gone_mm = math.dist(last, tip)
            if gone_mm < self._spacing_mm:
                return
            if gone_mm > self._leap_mm:
                self._points.append(None)
        elif tip is last:
            return
        self._points.append(tip)

    def clear(self) -> None:
        """Forget the trail, except for the current position."""
        last = self._points[-1]
        self._points.clear()
        self._points.append(last)

    @property
    def layer(self) -> Layer:
        """The trail as lines, one for each part without an interruption."""
        parts: list[list[Point]] = [[]]
        for point in self._points:
            if point is None:
                parts.append([])
            else:
                parts[-1].append(point)
        return Layer(tuple(Stroke(Ink.DRIVEN, tuple(part)) for part in parts if len(part) > 1))


# --- The outline of the reach, as lines in the arm's plane: slow to compute, therefore kept -------
#
# A five-axis arm of the Mini-mover type has an exact outline for each pitch of the hand. For any
# other arm, many postures are sampled, and the outline is the greatest distance of the tip at each
# height, at any pitch.

PITCH_DEG = 5  # the outline is computed for the nearest multiple of this pitch
# The same for the azimuth, because the base's limits restrict the reach behind its axis.
AZIMUTH_DEG = 15

_STEP_MM = 20.0  # length of chords; on the smallest arc of an arm they are within 1 mm of it

_POSTURES = 3000
_LEVELS = 24

# Pitch and azimuth in degrees; always (0, 0) for an arm with a single outline.
Key = tuple[int, int]


@dataclass(frozen=True, slots=True)
class Outline:
    """Curves of (distance from the base axis, height) in mm, and a description for the legend."""

    curves: tuple[tuple[tuple[float, float], ...], ...]
    words: str


def key_of(arm: ArmGeometry, pitch_rad: float, azimuth_rad: float) -> Key:
    """Return the key of a posture's outline; similar postures share one."""
    if not isinstance(arm, FiveAxisArm) or arm.tool:
        return 0, 0
    return _nearest(pitch_rad, PITCH_DEG), _nearest(azimuth_rad, AZIMUTH_DEG)


def outline(arm: ArmGeometry, key: Key) -> Outline:
    """Compute an outline. Takes some hundredths of a second: do not call on the screen's thread."""
    pitch_deg, azimuth_deg = key
    if isinstance(arm, FiveAxisArm) and not arm.tool:
        cut = section(arm, math.radians(pitch_deg), math.radians(azimuth_deg), _STEP_MM)
        return Outline(cut.boundary, f"reach at pitch {pitch_deg}")
    return Outline((_farthest(arm),), "reach at any pitch")


def in_plane(of: Outline, centre: Point, azimuth_rad: float) -> Layer:
    """Return an outline in the vertical plane through the base axis at an azimuth."""
    cosine, sine = math.cos(azimuth_rad), math.sin(azimuth_rad)
    x, y, _ = centre
    strokes = tuple(
        Stroke(Ink.REACH, tuple((x + r * cosine, y + r * sine, z) for r, z in curve))
        for curve in of.curves
    )
    return Layer(strokes)


def _nearest(angle_rad: float, step_deg: int) -> int:
    return round(math.degrees(angle_rad) / step_deg) * step_deg


def _farthest(arm: ArmGeometry) -> tuple[tuple[float, float], ...]:
    """Return the farthest sampled point of the tip at each level, from the lowest up.

    Distances are measured from the base axis. Every call samples the same postures.
    """
    spans = [(one.low_rad, one.high_rad) for one in arm.limits]
    tips = [_tip(arm, angles) for angles in sampled(spans, _POSTURES)]
    heights = [z for _, z in tips]
    low, high = min(heights), max(heights)
    size = max((high - low) / _LEVELS, 1e-9)
    best: dict[int, tuple[float, float]] = {}
    for r, z in tips:
        level = min(int((z - low) / size), _LEVELS - 1)
        if level not in best or r > best[level][0]:
            best[level] = (r, z)
    return tuple(best[level] for level in sorted(best))


def _tip(arm: ArmGeometry, angles: tuple[float, ...]) -> tuple[float, float]:
    points = arm.points(Joints(angles, arm.joint_names))
    return math.hypot(points[-1][0] - points[0][0], points[-1][1] - points[0][1]), points[-1][2]


# --- A picture: what stays is drawn only once -------------------------------------------------

_SAMPLE = 4  # cells of a line's sample in the legend: a full period of every pattern
_GAP = 2
_LEAST_HEIGHT = 8  # in rows; a smaller picture has no room for a legend


@dataclass(frozen=True, slots=True)
class SceneSpace:
    """A picture: the layer that stays as it is, and the layers over it, which change.

    `reach` describes the outline of the reach in the legend; `notice` is written across the middle.
    """

    still: Layer
    moving: tuple[Layer, ...] = ()
    reach: str = ""
    notice: str = ""

    @property
    def layers(self) -> tuple[Layer, ...]:
        """All layers, the lowest first."""
        return (self.still, *self.moving)


class Studio:
    """Draws one arm repeatedly, in braille or plain ASCII.

    What stays as it is has a canvas of its own as long as it is the same object, seen by the same
    camera at the same size.
    """

    def __init__(self, dome: Dome, *, braille: bool) -> None:
        self.dome = dome
        self.braille = braille
        self._key: tuple[Camera, int, int] | None = None
        self._still: Layer | None = None
        self._backdrop = Raster(0, 0, braille=braille)
        self._seen = Projection((0.0,) * 4, (0.0,) * 4)

    def draw(self, space: SceneSpace, camera: Camera, width: int, height: int) -> Painted:
        """Return a picture of `width` by `height` cells, with the legend in the last row."""
        worded = height >= _LEAST_HEIGHT
        if self._key != (camera, width, height) or self._still is not space.still:
            self._key, self._still = (camera, width, height), space.still
            backdrop = self._backdrop = Raster(width, height - worded, braille=self.braille)
            across, down = backdrop.right + 1, backdrop.bottom + 1
            self._seen = projection(camera, self.dome, across, down, backdrop.dot_aspect)
            backdrop.draw(space.still, self._seen)
        work = self._backdrop.copy()
        for layer in space.moving:
            work.draw(layer, self._seen)
        for layer in space.layers:
            work.write(layer, self._seen)
        if space.notice:
            column = max((work.width - len(space.notice)) // 2, 0)
            work.text(column, work.height // 2, space.notice, Ink.WORD)
        name = camera.name + (f", zoom {camera.zoom:+d}" if camera.zoom else "")
        work.text(0, 0, name, Ink.WORD)
        painted = work.painted()
        if not worded:
            return painted
        below = self._legend(space, width).painted()
        text, inks = painted.text + below.text, painted.inks + below.inks
        return Painted(work.width, work.height + 1, text, inks)

    def _legend(self, space: SceneSpace, width: int) -> Raster:
        """Return the legend in one row, with as many complete entries as fit."""
        drawn = Raster(width, 1, braille=self.braille)
        inks = {stroke.ink for layer in space.layers for stroke in layer.strokes}
        column = 0
        for ink, pattern in PATTERNS.items():
            word = space.reach if ink is Ink.REACH and space.reach else pattern.word
            if not word or ink not in inks:
                continue
            if column + _SAMPLE + 1 + len(word) > width:
                break
            drawn.sample(column, 0, _SAMPLE, ink)
            drawn.text(column + _SAMPLE + 1, 0, word, ink)
            column += _SAMPLE + 1 + len(word) + _GAP
        return drawn


# --- One arm over time --------------------------------------------------------------------------

PLANE_DEG = 3  # the plane of the outline is rounded to this azimuth, which is a dot or two off


@dataclass(frozen=True, slots=True)
class Moment:
    """The arm's posture and goal at one moment.

    `joints` are None while the posture is unknown. `goal` is drawn as a ghost, with the fingers as
    they are now, and `planned` as the path there: points of the tip in mm.
    """

    joints: Joints | None = None
    opening_mm: float | None = None
    goal: Joints | None = None
    planned: tuple[Point, ...] = ()


class ArmDrawing:
    """Makes the layers of one arm. Only `work_out` may be called from another thread."""

    def __init__(self, model: ArmModel) -> None:
        self.arm = model.arm
        self.dome = dome(model.arm)
        self.trail = Trail(self.dome.reach_mm)
        self.tip: Point | None = None
        self._backdrop = surroundings(model.arm, model.guards, self.dome)
        self._outline: Outline | None = None
        self._known: Key | None = None
        self._wanted: Key | None = None

    @property
    def missing(self) -> Key | None:
        """The key of the outline to compute now; None if it is known, or none is needed."""
        return None if self._wanted == self._known else self._wanted

    def work_out(self, key: Key) -> Outline:
        """Compute an outline, in some hundredths of a second, without changing this object."""
        return outline(self.arm, key)

    def keep(self, key: Key, found: Outline) -> None:
        """Draw this outline until another one is computed."""
        self._known, self._outline = key, found

    def space(self, moment: Moment, notice: str = "") -> SceneSpace:
        """Return the picture of a moment; `notice` is shown while the posture is unknown."""
        here = None if moment.joints is None else self._stance(moment.joints, moment)
        self.tip = None if here is None else here.tip
        self.trail.add(self.tip)
        moving = [*self._ahead(moment), self.trail.layer]
        if moment.joints is None or here is None:
            return SceneSpace(self._backdrop, tuple(moving), notice=notice)
        azimuth_rad = self._azimuth_rad(moment.joints, here.tip)
        self._wanted = key_of(self.arm, self.arm.fk(moment.joints).pitch_rad, azimuth_rad)
        words = ""
        if self._outline is not None:
            words, turned_deg = self._outline.words, _nearest(azimuth_rad, PLANE_DEG)
            moving.append(in_plane(self._outline, self.dome.centre, math.radians(turned_deg)))
        return SceneSpace(self._backdrop, (*moving, figure(here)), words)

    def _stance(self, joints: Joints, moment: Moment) -> Stance:
        return stance(self.arm, joints, moment.opening_mm, self.dome.reach_mm)

    def _ahead(self, moment: Moment) -> Iterator[Layer]:
        """Yield the planned path and the ghost at its end."""
        if len(moment.planned) > 1:
            yield Layer((Stroke(Ink.PLANNED, moment.planned),))
        if moment.goal is not None:
            yield ghost(self._stance(moment.goal, moment))

    def _azimuth_rad(self, joints: Joints, tip: Point) -> float:
        """Return the azimuth of the arm's plane: of the base joint, or of the tip."""
        if isinstance(self.arm, FiveAxisArm):
            return joints[0]
        x, y, _ = self.dome.centre
        return math.atan2(tip[1] - y, tip[0] - x)


# --- One posture, for questions and for drawings without a screen of their own -------------------


def posture_cameras(joints: Joints | None) -> tuple[Camera, Camera]:
    """Return the views from the side and from above, by which a person judges a posture."""
    return VIEWS["side"] if joints is None else side_of(joints[0]), VIEWS["top"]


class PostureDrawing:
    """Draws postures as rows of characters, from the side and from above.

    What surrounds the arm is drawn once, so that a moving arm can be followed.
    """

    def __init__(self, model: ArmModel, *, braille: bool) -> None:
        self.braille = braille
        self._drawing = ArmDrawing(model)
        self._side, self._top = (Studio(self._drawing.dome, braille=braille) for _ in range(2))

    def side(
        self, moment: Moment, width: int, height: int, blocks: Iterable[Box] = ()
    ) -> list[str]:
        """Return `height` rows of `width` characters, with blocks that lie about."""
        camera, _ = posture_cameras(moment.joints)
        return self._side.draw(self._space(moment, blocks), camera, width, height).rows()

    def top(self, moment: Moment, width: int, height: int, blocks: Iterable[Box] = ()) -> list[str]:
        """Return the view from above."""
        _, camera = posture_cameras(moment.joints)
        return self._top.draw(self._space(moment, blocks), camera, width, height).rows()

    def _space(self, moment: Moment, blocks: Iterable[Box]) -> SceneSpace:
        space = self._drawing.space(moment)
        self._drawing.trail.add(None)  # each picture is of one posture alone
        return SceneSpace(space.still, (*space.moving, _boxes(blocks, Ink.BASE)))
