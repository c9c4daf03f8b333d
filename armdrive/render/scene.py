"""The picture of one arm in space, from moment to moment: its layers, and what changed.

It keeps the way that the tip has gone, and the outlines of the reach that were worked out.
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

# --- Layers: what stands still is drawn only once ------------------------------------------------

_SAMPLE = 4
"""Cells of a line, a whole period of its pattern, that show what it looks like, beside its word."""

_GAP = 2
_LEAST_HEIGHT = 8
"""In a lower picture the words under it would hide more than they tell."""


@dataclass(frozen=True, slots=True)
class SceneSpace:
    """What there is to see, in sheets of layers: the first stands still, the last moves most.

    A sheet is drawn anew only where one of its layers, or a sheet before it, has changed. `reach`
    says in words what the lines of the reach hold for; `notice` is written across the middle.
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
    """A raster with layers over another sheet, drawn anew only where one of them is another one.

    Layers are compared by identity: equal ones would take longer to compare than to draw.
    """

    def __init__(self, width: int, height: int, *, braille: bool) -> None:
        self.raster: Raster = raster(width, height, braille=braille)
        self.edition = 0
        self._layers: tuple[Layer, ...] = ()
        self._over = 0

    def show(self, layers: tuple[Layer, ...], seen: Projection, under: _Sheet | None) -> None:
        """Show these layers over that sheet. Further ones are added to those that are there."""
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
        """Draw sheets of layers, one over the other, of which all but the last are kept."""
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
    """Draws one arm again and again, in braille or plain ASCII."""

    def __init__(self, dome: Dome, *, braille: bool) -> None:
        self.dome = dome
        self.braille = braille
        self._key: tuple[Camera, int, int] | None = None
        self._easel: _Easel | None = None
        self._legend = lru_cache(maxsize=8)(partial(_legend, braille=braille))

    def draw(self, space: SceneSpace, camera: Camera, width: int, height: int) -> Painted:
        """Return the picture on so many cells, with the legend in the last row."""
        worded = height >= _LEAST_HEIGHT
        key = (camera, width, height)
        if self._easel is None or key != self._key:
            work = raster(width, height - worded, braille=self.braille)
            self._key, self._easel = key, _Easel(camera, self.dome, work)
        self._easel.show(space)
        painted = self._easel.work.painted()
        return painted.above(self._legend(space.inks, space.reach, width)) if worded else painted


def _legend(inks: frozenset[Ink], reach: str, width: int, *, braille: bool) -> Painted:
    """Return a row that tells what the kinds of lines are, each whole or not at all."""
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


MOST_OUTLINES = 128
"""Outlines of the reach that are kept: about a hundred kilobytes each at most."""

PLANE_DEG = 3
"""The outline is laid in the nearest plane that is a multiple of this: a dot or two off."""

_NO_LAYER = Layer()


@dataclass(frozen=True, slots=True)
class Moment:
    """What is known of the arm at one moment, and what is wanted of it.

    `joints` are None while nobody knows the posture. `goal` is drawn as a ghost, `planned` as the
    way there: points of the tip in mm. `goal_opening_mm` is how far its fingers are open.
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
        """The outline that should be worked out now; None where it is there, or not wanted."""
        return None if self._wanted in self._outlines else self._wanted

    def stance(self, joints: Joints, opening_mm: float | None) -> Stance:
        """Return where everything of the arm is in a posture."""
        return stance(self.arm, joints, opening_mm, self.dome.reach_mm)

    def work_out(self, key: Key) -> Outline:
        """Work an outline out, which takes some hundredths of a second; changes nothing here."""
        return outline(self.arm, key)

    def keep(self, key: Key, found: Outline) -> None:
        """Draw this outline where it is wanted, from now on."""
        self._outlines[key] = found
        while len(self._outlines) > MOST_OUTLINES:
            self._outlines.popitem(last=False)

    def space(self, moment: Moment, notice: str = "") -> SceneSpace:
        """Return what there is to see; `notice` is said while nobody knows the posture."""
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
        """Draw the way that is planned and the ghost at its end, where they are other ones."""
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
        """Lay this posture's outline in the arm's plane; the last one as long as it is missing."""
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
        """Return which way the arm's plane lies: by its base, or by where its tip is."""
        if isinstance(self.arm, FiveAxisArm):
            return joints[0]
        assert self.tip is not None  # noqa: S101 - `space` has set it
        x, y, _ = self.dome.centre
        return math.atan2(self.tip[1] - y, self.tip[0] - x)
