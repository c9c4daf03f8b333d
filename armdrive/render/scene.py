"""The picture of one arm in space over time: its layers, and which of them changed.

Keeps the trail of the tip, and the computed outlines of the reach.
"""

from __future__ import annotations

import math
from collections import OrderedDict
from dataclasses import dataclass
from functools import lru_cache, partial

from armdrive.render.camera import Camera, Dome, Projection, projection
from armdrive.render.figure import Stance, dome, figure, ghost, stance
from armdrive.render.inks import PATTERNS, Ink, Layer, Stroke
from armdrive.render.raster import Painted, Raster, raster
from armdrive.render.reach import Key, Outline, in_plane, key_of, outline
from armdrive.render.surroundings import Trail, surroundings
from kinematics.five_axis.arm import FiveAxisArm
from kinematics.geometry import Point
from kinematics.presets import ArmModel
from kinematics.spaces import Joints

# --- Layers: those that do not change are drawn only once ----------------------------------------

_SAMPLE = 4  # cells of a line's sample in the legend: a full period of every pattern
_GAP = 2
_LEAST_HEIGHT = 8  # in rows; a smaller picture has no room for a legend


@dataclass(frozen=True, slots=True)
class SceneSpace:
    """A picture as sheets of layers, from the one that never changes to the one that changes most.

    A sheet is redrawn only if one of its layers or a sheet below it has changed. `reach` describes
    the outline of the reach in the legend; `notice` is written across the middle.
    """

    sheets: tuple[tuple[Layer, ...], ...]
    reach: str = ""
    notice: str = ""

    @property
    def inks(self) -> frozenset[Ink]:
        """The inks of all its lines."""
        layers = (layer for sheet in self.sheets for layer in sheet)
        return frozenset(stroke.ink for layer in layers for stroke in layer.strokes)


class _Sheet:
    """A raster with layers on top of another sheet, redrawn only if one of them was replaced.

    Layers are compared by identity, because comparing their contents takes longer than drawing.
    """

    def __init__(self, width: int, height: int, *, braille: bool) -> None:
        self.raster: Raster = raster(width, height, braille=braille)
        self.edition = 0
        self._layers: tuple[Layer, ...] = ()
        self._over = 0

    def show(self, layers: tuple[Layer, ...], seen: Projection, under: _Sheet | None) -> None:
        """Show layers on top of a sheet. Layers added at the end are drawn over the others."""
        edition = under.edition if under is not None else 0
        kept = len(self._layers)
        same = edition == self._over and all(
            a is b for a, b in zip(self._layers, layers, strict=False)
        )
        if not same or kept > len(layers):
            kept = 0
            if under is None:
                self.raster.clear()
            else:
                self.raster.taken_from(under.raster)
            self.edition += 1
        for layer in layers[kept:]:
            self.raster.draw(layer, seen)
            self.edition += 1
        self._layers, self._over = layers, edition


class _Easel:
    """The sheets and the projection of one camera on one size of canvas."""

    def __init__(self, camera: Camera, dome: Dome, work: Raster) -> None:
        self.work = work
        self.name = camera.name + (f", zoom {camera.zoom:+d}" if camera.zoom else "")
        self._sheets: list[_Sheet] = []
        self._seen = projection(camera, dome, work.right + 1, work.bottom + 1, work.dot_aspect)

    def show(self, space: SceneSpace) -> None:
        """Draw the sheets on top of each other; all but the last are kept for the next time."""
        work = self.work
        under: _Sheet | None = None
        for index, layers in enumerate(space.sheets[:-1]):
            if index == len(self._sheets):
                self._sheets.append(_Sheet(work.width, work.height, braille=work.braille))
            self._sheets[index].show(layers, self._seen, under)
            under = self._sheets[index]
        if under is None:
            work.clear()
        else:
            work.taken_from(under.raster)
        for layer in space.sheets[-1]:
            work.draw(layer, self._seen)
        if space.notice:
            column = max((work.width - len(space.notice)) // 2, 0)
            work.text(column, work.height // 2, space.notice, Ink.WORD)
        work.text(0, 0, self.name, Ink.WORD)


class Studio:
    """Draws one arm repeatedly, in braille or plain ASCII."""

    def __init__(self, dome: Dome, *, braille: bool) -> None:
        self.dome = dome
        self.braille = braille
        self._key: tuple[Camera, int, int] | None = None
        self._easel: _Easel | None = None
        self._legend = lru_cache(maxsize=8)(partial(_legend, braille=braille))

    def draw(self, space: SceneSpace, camera: Camera, width: int, height: int) -> Painted:
        """Return a picture of `width` by `height` cells, with the legend in the last row."""
        worded = height >= _LEAST_HEIGHT
        key = (camera, width, height)
        if self._easel is None or key != self._key:
            work = raster(width, height - worded, braille=self.braille)
            self._key, self._easel = key, _Easel(camera, self.dome, work)
        self._easel.show(space)
        painted = self._easel.work.painted()
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


MOST_OUTLINES = 128  # cached outlines of the reach, of at most about a hundred kilobytes each
PLANE_DEG = 3  # the plane of the outline is rounded to this azimuth, which is a dot or two off

_NO_LAYER = Layer()


@dataclass(frozen=True, slots=True)
class Moment:
    """The arm's posture and goal at one moment.

    `joints` are None while the posture is unknown. `goal` is drawn as a ghost, with its fingers
    `goal_opening_mm` apart, and `planned` as the path there: points of the tip in mm.
    """

    joints: Joints | None = None
    opening_mm: float | None = None
    goal: Joints | None = None
    goal_opening_mm: float | None = None
    planned: tuple[Point, ...] = ()


class ArmDrawing:
    """Makes the layers of one arm. Only `work_out` may be called from another thread."""

    def __init__(self, model: ArmModel) -> None:
        self.arm = model.arm
        self.dome = dome(model.arm)
        self.trail = Trail(self.dome.reach_mm)
        self.tip: Point | None = None
        self._backdrop = (surroundings(model.arm, model.guards, self.dome),)
        self._ahead: tuple[Layer, ...] = ()
        self._wanted_ahead: tuple[Joints | None, float | None, tuple[Point, ...]] | None = None
        self._outlines: OrderedDict[Key, Outline] = OrderedDict()
        self._outline: Outline | None = None
        self._wanted: Key | None = None
        self._azimuth_deg = 0
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
            return SceneSpace((self._backdrop, self._ahead, self.trail.full, ()), notice=notice)
        here = self.stance(moment.joints, moment.opening_mm)
        self.tip = here.tip
        self.trail.add(here.tip)
        self._turn_reach(moment.joints)
        words = self._outline.words if self._outline is not None else ""
        moving = (self.trail.latest, figure(here))
        sheets = (self._backdrop, self._ahead, self.trail.full, (self._reach,), moving)
        return SceneSpace(sheets, words)

    def _want(self, moment: Moment) -> None:
        """Update the planned path and the ghost at its end, if they changed."""
        wanted = (moment.goal, moment.goal_opening_mm, moment.planned)
        if wanted == self._wanted_ahead:
            return
        self._wanted_ahead = wanted
        way = (Stroke(Ink.PLANNED, moment.planned),) if len(moment.planned) > 1 else ()
        layers = [Layer(way)]
        if moment.goal is not None:
            layers.append(ghost(self.stance(moment.goal, moment.goal_opening_mm)))
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
