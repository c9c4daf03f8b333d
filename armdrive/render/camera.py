"""The camera that views an arm, and its projection onto a canvas.

The projection is orthographic: lengths across the line of sight are true to scale.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

from kinematics.frames.numbers import cos_sin
from kinematics.frames.rotations import Matrix3, transpose
from kinematics.frames.vectors import dot
from kinematics.geometry import Point

ZOOM = 1.25  # magnification of one zoom step
LEAST_ZOOM, MOST_ZOOM = -4, 14  # steps: from 0.4 to 23 times

LOWEST_DEG, HIGHEST_DEG = -90, 90
FULL_TURN_DEG = 360

_ROOM = 1.04  # a little air around the reach
_BELOW_TABLE_MM = 25.0


@dataclass(frozen=True, slots=True)
class Camera:
    """The viewing direction: azimuth around the arm from its front, elevation above the table.

    Angles are whole degrees, so that a full turn returns to exactly the same picture. `zoom` counts
    steps. `centre_mm` is the point in the middle of the picture; None is the middle of the reach.
    `title` is the name of a view that is none of `VIEWS`.
    """

    azimuth_deg: int
    elevation_deg: int
    zoom: int = 0
    centre_mm: Point | None = None
    title: str = ""

    @property
    def rotation(self) -> Matrix3:
        """The view's axes in the table's frame: rows for right, up and towards the viewer."""
        # exact at right angles, so that no view is slightly tilted
        ca, sa = cos_sin(math.radians(self.azimuth_deg))
        ce, se = cos_sin(math.radians(self.elevation_deg))
        return (-sa, ca, 0.0), (-se * ca, -se * sa, ce), (ce * ca, ce * sa, se)

    @property
    def name(self) -> str:
        """The name of the view if it has one, else its angles."""
        for name, view in VIEWS.items():
            if (view.azimuth_deg, view.elevation_deg) == (self.azimuth_deg, self.elevation_deg):
                return name
        return self.title or f"azimuth {self.azimuth_deg}, elevation {self.elevation_deg}"

    def orbited(self, azimuth_deg: int, elevation_deg: int = 0) -> Camera:
        """Turn around the arm and upwards, as far as straight above or straight below."""
        turned = (self.azimuth_deg + azimuth_deg) % FULL_TURN_DEG
        up = min(max(self.elevation_deg + elevation_deg, LOWEST_DEG), HIGHEST_DEG)
        return replace(self, azimuth_deg=turned, elevation_deg=up, title="")

    def zoomed(self, steps: int, about: Point | None, dome: Dome) -> Camera:
        """Zoom in or out; when zooming in, the point `about` keeps its place on the screen."""
        zoom = min(max(self.zoom + steps, LEAST_ZOOM), MOST_ZOOM)
        if zoom <= 0:
            return replace(self, zoom=zoom, centre_mm=None)
        if about is None:
            return replace(self, zoom=zoom)
        share = ZOOM ** (self.zoom - zoom)
        x, y, z = (p + (c - p) * share for p, c in zip(about, _middle(self, dome), strict=True))
        return replace(self, zoom=zoom, centre_mm=(x, y, z))

    def fitted(self) -> Camera:
        """Show all of the arm's reach again, from the same direction."""
        return replace(self, zoom=0, centre_mm=None)


# Views by name, in the order of the key for the next view.
#
# From the side x points right. From above, and in iso, the viewer is behind the base, so that
# turning the base to the left turns the picture of the arm to the left.
VIEWS: Mapping[str, Camera] = MappingProxyType(
    {
        "iso": Camera(225, 35),
        "side": Camera(270, 0),
        "top": Camera(180, 90),
        "front": Camera(0, 0),
    }
)


def side_of(base_rad: float) -> Camera:
    """Return the view from the side onto the plane of an arm whose base is turned this far."""
    azimuth_deg = (VIEWS["side"].azimuth_deg + round(math.degrees(base_rad))) % FULL_TURN_DEG
    return Camera(azimuth_deg, 0, title="side")


def next_view(camera: Camera) -> Camera:
    """Return the next named view, or the first one after a direction without a name."""
    names = list(VIEWS)
    place = names.index(camera.name) + 1 if camera.name in names else 0
    return VIEWS[names[place % len(names)]]


@dataclass(frozen=True, slots=True)
class Dome:
    """The space within an arm's reach: a ball around the end of its base, above the table, in mm.

    It fixes the scale, so that the picture's size depends on neither posture nor viewing direction.
    """

    centre: Point
    reach_mm: float


@dataclass(frozen=True, slots=True)
class Projection:
    """A linear map from points in mm to dots on a canvas, x to the right and y down."""

    right: tuple[float, float, float, float]
    down: tuple[float, float, float, float]

    def dots(self, point: Point) -> tuple[float, float]:
        """Return a point's position in dots, from the centre of the upper left dot."""
        x, y, z = point
        a, b, c, d = self.right
        e, f, g, h = self.down
        return a * x + b * y + c * z + d, e * x + f * y + g * z + h


def projection(
    camera: Camera, dome: Dome, width_dots: int, height_dots: int, dot_aspect: float = 1.0
) -> Projection:
    """Return a camera's projection onto a canvas, which the dome fills at zoom 0.

    `dot_aspect` is a dot's height divided by its width.
    """
    wide, high = max(width_dots - 1, 0), max(height_dots - 1, 0)
    above, below = _extent(camera, dome)
    across = 2.0 * dome.reach_mm * _ROOM
    scale = min(wide / across, high * dot_aspect / ((above + below) * _ROOM)) * ZOOM**camera.zoom
    tall = scale / dot_aspect
    right, up, _ = camera.rotation
    middle = _middle(camera, dome)
    return Projection(
        (
            right[0] * scale,
            right[1] * scale,
            right[2] * scale,
            wide / 2 - scale * dot(right, middle),
        ),
        (-up[0] * tall, -up[1] * tall, -up[2] * tall, high / 2 + tall * dot(up, middle)),
    )


def _extent(camera: Camera, dome: Dome) -> tuple[float, float]:
    """Return how far dome and table extend up and down in the picture from the dome's centre."""
    _, up, towards = camera.rotation
    below = dome.reach_mm * abs(towards[2]) + (dome.centre[2] + _BELOW_TABLE_MM) * up[2]
    return dome.reach_mm, max(below, 0.0)


def _middle(camera: Camera, dome: Dome) -> Point:
    """Return the point in the middle of the canvas."""
    if camera.centre_mm is not None:
        return camera.centre_mm
    above, below = _extent(camera, dome)
    x, y, z = transpose(camera.rotation)
    lift = (above - below) / 2.0
    cx, cy, cz = dome.centre
    return cx + x[1] * lift, cy + y[1] * lift, cz + z[1] * lift


# --- Changes of the view: orbit, zoom, named views -----------------------------------------------

ORBIT_DEG = 10  # one step around the arm or up; divides a full turn

# All changes of the view by name: the next camera for the present one, the tip and the arm's dome.
#
# `nearer` zooms in on the tip.
LOOKS: Mapping[str, Callable[[Camera, Point | None, Dome], Camera]] = MappingProxyType(
    {
        "left": lambda camera, _tip, _dome: camera.orbited(-ORBIT_DEG),
        "right": lambda camera, _tip, _dome: camera.orbited(ORBIT_DEG),
        "up": lambda camera, _tip, _dome: camera.orbited(0, ORBIT_DEG),
        "down": lambda camera, _tip, _dome: camera.orbited(0, -ORBIT_DEG),
        "nearer": lambda camera, tip, dome: camera.zoomed(1, tip, dome),
        "farther": lambda camera, tip, dome: camera.zoomed(-1, tip, dome),
        "fit": lambda camera, _tip, _dome: camera.fitted(),
        "next": lambda camera, _tip, _dome: next_view(camera),
    }
)
