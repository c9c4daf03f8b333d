"""What a watcher can ask of a camera, by name: go round, come nearer, take a named view."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from types import MappingProxyType

from armdrive.draw.camera import VIEWS, Camera, Dome, next_view
from kinematics.geometry import Point

ORBIT_DEG = 10
"""One step round the arm or up; 36 of them lead back."""

Look = Callable[[Camera, Point | None, Dome], Camera]
"""From where the camera is, where the tip is, and what the arm can fill, to the next camera."""


def _orbit(azimuth: int, elevation: int, camera: Camera, _tip: Point | None, _of: Dome) -> Camera:
    return camera.orbited(azimuth * ORBIT_DEG, elevation * ORBIT_DEG)


def _zoom(steps: int, camera: Camera, tip: Point | None, dome: Dome) -> Camera:
    return camera.zoomed(steps, tip, dome)


def _take(view: Camera, _camera: Camera, _tip: Point | None, _of: Dome) -> Camera:
    return view


LOOKS: Mapping[str, Look] = MappingProxyType(
    {
        "left": partial(_orbit, -1, 0),
        "right": partial(_orbit, 1, 0),
        "up": partial(_orbit, 0, 1),
        "down": partial(_orbit, 0, -1),
        "nearer": partial(_zoom, 1),
        "farther": partial(_zoom, -1),
        "fit": lambda camera, _tip, _of: camera.fitted(),
        "next": lambda camera, _tip, _of: next_view(camera),
        **{name: partial(_take, view) for name, view in VIEWS.items()},
    }
)
"""Every look; coming nearer goes towards the tip."""
