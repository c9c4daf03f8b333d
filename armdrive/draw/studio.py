"""A picture of an arm in space, put together from layers; what stands still is drawn only once."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache, partial

from armdrive.draw.camera import Camera, Dome, Projection, projection
from armdrive.draw.inks import PATTERNS, Ink, Layer
from armdrive.draw.painted import Painted
from armdrive.draw.raster import Raster, raster

_SAMPLE = 4
"""Cells of a line, a whole period of its pattern, that show what it looks like, beside its word."""

_GAP = 2
_LEAST_HEIGHT = 8
"""In a lower picture the words under it would hide more than they tell."""


@dataclass(frozen=True, slots=True)
class Space:
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

    def show(self, space: Space) -> None:
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

    def draw(self, space: Space, camera: Camera, width: int, height: int) -> Painted:
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
