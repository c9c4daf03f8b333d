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
from collections import OrderedDict, deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache, partial
from itertools import product

from armdrive.render.camera import VIEWS, Camera, Dome, Projection, projection, side_of
from armdrive.render.canvas import PATTERNS, Ink, Layer, Letters, Painted, Stroke, raster
from armdrive.render.figure import Stance, dome, figure, ghost, stance
from kinematics.five_axis import FiveAxisArm
from kinematics.five_axis.workspace import section
from kinematics.geometry import ArmGeometry, Point
from kinematics.guards import Guards
from kinematics.guards.shapes import Box
from kinematics.limits import spread_over
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


# --- The trail: a limited number of the tip's latest points, in pieces ---------------------------

PIECE = 16  # points in a piece: one that is full stays as it is, and so do its dots
MOST_PIECES = 24

LEAP = 0.35
"""If the tip moves by this share of the reach between two updates, the position was changed.

The fastest arm sweeps its whole reach in about a second, and updates are 0.05 s apart.
"""

_SPACING = 0.008  # share of the reach; closer points would fall on the same dots


class Trail:
    """The recent path of the tip, oldest point first; it is interrupted if the position is lost."""

    def __init__(self, reach_mm: float) -> None:
        self._leap_mm = LEAP * reach_mm
        self._spacing_mm = _SPACING * reach_mm
        self._full: deque[Stroke] = deque(maxlen=MOST_PIECES)
        self._points: list[Point] = []

    def add(self, tip: Point | None) -> None:
        """Add the position of the tip now, or None while it is unknown."""
        gone_mm = math.dist(self._points[-1], tip) if tip is not None and self._points else 0.0
        if tip is None or gone_mm > self._leap_mm:
            self._full.extend(self._latest)
            self._points = []
        if tip is None or (self._points and gone_mm < self._spacing_mm):
            return
        self._points.append(tip)
        if len(self._points) == PIECE:
            self._full.extend(self._latest)
            self._points = [tip]  # the next piece continues from here

    def clear(self) -> None:
        """Forget the trail, except for the current position."""
        self._full.clear()
        self._points = self._points[-1:]

    @property
    def layer(self) -> Layer:
        """The trail as lines."""
        return Layer((*self._full, *self._latest))

    @property
    def _latest(self) -> tuple[Stroke, ...]:
        """The piece that still grows, as soon as it is a line."""
        return (Stroke(Ink.DRIVEN, tuple(self._points)),) if len(self._points) > 1 else ()


# --- The outline of the reach, as lines in the arm's plane: slow to compute, therefore kept -------
#
# A five-axis arm of the Mini-mover type has an exact outline for each pitch of the hand. For any
# other arm, many postures are sampled, and the outline is the greatest distance of the tip at each
# height, at any pitch.

PITCH_DEG = 5  # the outline is computed for the nearest multiple of this pitch
AZIMUTH_DEG = 15
"""The same for the azimuth, because the base's limits restrict the reach behind its axis."""

_STEP_MM = 20.0  # length of chords; on the smallest arc of an arm they are within 1 mm of it

_POSTURES = 3000
_LEVELS = 24

Key = tuple[int, int]
"""Pitch and azimuth in degrees; always (0, 0) for an arm with a single outline."""


@dataclass(frozen=True, slots=True)
class Outline:
    """Curves of (distance from the base axis, height) in mm, and a description for the legend."""

    curves: tuple[tuple[tuple[float, float], ...], ...]
    words: str


def key_of(arm: ArmGeometry, pitch_rad: float, azimuth_rad: float) -> Key:
    """Return the key of a posture's outline; similar postures share one."""
    if not isinstance(arm, FiveAxisArm):
        return 0, 0
    return _nearest(pitch_rad, PITCH_DEG), _nearest(azimuth_rad, AZIMUTH_DEG)


def outline(arm: ArmGeometry, key: Key) -> Outline:
    """Compute an outline. Takes some hundredths of a second: do not call on the screen's thread."""
    pitch_deg, azimuth_deg = key
    if isinstance(arm, FiveAxisArm):
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
    tips = [_tip(arm, angles) for angles in spread_over(spans, _POSTURES).postures()]
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
    def inks(self) -> frozenset[Ink]:
        """The inks of all its lines."""
        layers = (self.still, *self.moving)
        return frozenset(stroke.ink for layer in layers for stroke in layer.strokes)


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
        self._backdrop = self._work = raster(0, 0, braille=braille)
        self._seen = Projection((0.0,) * 4, (0.0,) * 4)
        self._legend = lru_cache(maxsize=8)(partial(_legend, braille=braille))

    def draw(self, space: SceneSpace, camera: Camera, width: int, height: int) -> Painted:
        """Return a picture of `width` by `height` cells, with the legend in the last row."""
        worded = height >= _LEAST_HEIGHT
        if self._key != (camera, width, height) or self._still is not space.still:
            self._key, self._still = (camera, width, height), space.still
            self._backdrop, self._work = (
                raster(width, height - worded, braille=self.braille) for _ in range(2)
            )
            across, down = self._work.right + 1, self._work.bottom + 1
            self._seen = projection(camera, self.dome, across, down, self._work.dot_aspect)
            self._backdrop.draw(space.still, self._seen)
        work = self._work
        work.taken_from(self._backdrop)
        for layer in space.moving:
            work.draw(layer, self._seen)
        if space.notice:
            column = max((work.width - len(space.notice)) // 2, 0)
            work.text(column, work.height // 2, space.notice, Ink.WORD)
        name = camera.name + (f", zoom {camera.zoom:+d}" if camera.zoom else "")
        work.text(0, 0, name, Ink.WORD)
        painted = work.painted()
        return painted.above(self._legend(space.inks, space.reach, width)) if worded else painted


def _legend(inks: frozenset[Ink], reach: str, width: int, *, braille: bool) -> Painted:
    """Return the legend in one row, with as many complete entries as fit."""
    drawn = raster(width, 1, braille=braille)
    column = 0
    for ink, pattern in PATTERNS.items():
        word = reach if ink is Ink.REACH and reach else pattern.word
        if not word or ink not in inks:
            continue
        if column + _SAMPLE + 1 + len(word) > width:
            break
        drawn.sample(column, 0, _SAMPLE, ink)
        drawn.text(column + _SAMPLE + 1, 0, word, ink)
        column += _SAMPLE + 1 + len(word) + _GAP
    return drawn.painted()


# --- One arm over time --------------------------------------------------------------------------

MOST_OUTLINES = 128  # cached outlines of the reach, of at most about a hundred kilobytes each:
# an arm that is jogged to and fro comes back to the same few pitches and azimuths
PLANE_DEG = 3  # the plane of the outline is rounded to this azimuth, which is a dot or two off

_NO_LAYER = Layer()


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
        self._ahead: tuple[Layer, ...] = ()
        self._wanted_ahead: tuple[Joints | None, float | None, tuple[Point, ...]] | None = None
        self._outlines: OrderedDict[Key, Outline] = OrderedDict()
        self._outline: Outline | None = None
        self._wanted: Key | None = None
        self._reach = _NO_LAYER
        self._reach_of: tuple[Outline | None, int] = (None, 0)

    @property
    def missing(self) -> Key | None:
        """The key of the outline to compute now; None if it is known, or none is needed."""
        return None if self._wanted in self._outlines else self._wanted

    def stance(self, joints: Joints, opening_mm: float | None) -> Stance:
        """Return the geometry of the arm in one posture."""
        return stance(self.arm, joints, opening_mm, self.dome.reach_mm)

    def work_out(self, key: Key) -> Outline:
        """Compute an outline, in some hundredths of a second, without changing this object."""
        return outline(self.arm, key)

    def keep(self, key: Key, found: Outline) -> None:
        """Add an outline to the cache."""
        self._outlines[key] = found
        while len(self._outlines) > MOST_OUTLINES:
            self._outlines.popitem(last=False)

    def space(self, moment: Moment, notice: str = "") -> SceneSpace:
        """Return the picture of a moment; `notice` is shown while the posture is unknown."""
        self._want(moment)
        if moment.joints is None:
            self.trail.add(None)
            self.tip = None
            return SceneSpace(self._backdrop, (*self._ahead, self.trail.layer), notice=notice)
        here = self.stance(moment.joints, moment.opening_mm)
        self.tip = here.tip
        self.trail.add(here.tip)
        self._turn_reach(moment.joints)
        words = self._outline.words if self._outline is not None else ""
        moving = (*self._ahead, self.trail.layer, self._reach, figure(here))
        return SceneSpace(self._backdrop, moving, words)

    def _want(self, moment: Moment) -> None:
        """Update the planned path and the ghost at its end, if they changed."""
        wanted = (moment.goal, moment.opening_mm, moment.planned)
        if wanted == self._wanted_ahead:
            return
        self._wanted_ahead = wanted
        way = (Stroke(Ink.PLANNED, moment.planned),) if len(moment.planned) > 1 else ()
        layers = [Layer(way)]
        if moment.goal is not None:
            layers.append(ghost(self.stance(moment.goal, moment.opening_mm)))
        self._ahead = tuple(layers)

    def _turn_reach(self, joints: Joints) -> None:
        """Place the posture's outline in the arm's plane; until it is known, keep the last one."""
        azimuth_rad = self._azimuth_rad(joints)
        self._wanted = key_of(self.arm, self.arm.fk(joints).pitch_rad, azimuth_rad)
        found = self._outlines.get(self._wanted)
        if found is not None:
            self._outline = found
            self._outlines.move_to_end(self._wanted)
        turned = (self._outline, round(math.degrees(azimuth_rad) / PLANE_DEG) * PLANE_DEG)
        if self._outline is not None and turned != self._reach_of:
            self._reach_of = turned
            self._reach = in_plane(self._outline, self.dome.centre, math.radians(turned[1]))

    def _azimuth_rad(self, joints: Joints) -> float:
        """Return the azimuth of the arm's plane: of the base joint, or of the tip."""
        if isinstance(self.arm, FiveAxisArm):
            return joints[0]
        assert self.tip is not None  # noqa: S101 - `space` has set it
        x, y, _ = self.dome.centre
        return math.atan2(self.tip[1] - y, self.tip[0] - x)


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
