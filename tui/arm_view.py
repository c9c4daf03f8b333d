"""The arm as a widget, seen from any side; it repaints only what has changed.

    view = SpaceView(desk.arm.model, braille=desk.braille, id="space")
    view.show(Moment(status.joints, status.gripper_mm))              # at each poll
    view.show(Moment(status.joints, status.gripper_mm, goal=joints, planned=tip_points))

Keys come to it by `look`, from rows of the table of keys; the mouse orbits by dragging, and zooms.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from functools import partial
from types import MappingProxyType

from rich.segment import Segment
from rich.style import Style
from textual import events
from textual.dom import DOMNode
from textual.geometry import Region
from textual.strip import Strip
from textual.widget import Widget

from armdrive.render.camera import LOOKS, VIEWS, Camera
from armdrive.render.canvas import Ink, Painted
from armdrive.render.scene import ArmDrawing, Key, Moment, Outline, Studio
from kinematics.presets import ArmModel

# Dragging by one cell to the side, and by one row, which is twice as high.
DRAG_DEG = (3, 6)

# Outlines of the reach are worked out no more often: it takes time from the arm's own thread.
REST_S = 1.0

# In fewer rows nothing can be recognised, and nothing is drawn.
LEAST_ROWS = 5

# Asks for the driven way to be forgotten.
CLEAR = "clear"


# Spans of text in these styles, instead of component classes of the widget: the framework works
# out the rules for each such class again whenever any style on the screen may have changed.
# How each kind of line looks, in the colours of the theme.
INK_STYLES: Mapping[Ink, str] = MappingProxyType(
    {
        Ink.NONE: "",
        Ink.TABLE: "$foreground 70%",
        Ink.REACH: "$text-secondary",
        Ink.GUARD: "$text-error",
        Ink.BASE: "$foreground",
        Ink.PLANNED: "$text-accent",
        Ink.DRIVEN: "$text-success",
        Ink.GOAL: "bold $text-accent",
        Ink.ARM: "bold $foreground",
        Ink.GRIPPER: "bold $foreground",
        Ink.JOINT: "bold $text-primary",
        Ink.AXIS: "bold $text-warning",
        Ink.WORD: "bold $foreground",
    }
)


def move_cameras(at: DOMNode, what: str) -> bool:
    """Do this to every arm view below a node that is shown; return whether there is one."""
    views = [view for view in at.query(SpaceView) if view.is_on_screen]
    for view in views:
        view.look(what)
    return bool(views)


class SpaceView(Widget):
    """An arm with its table, guards, reach, way and goal, seen from wherever the watcher stands."""

    DEFAULT_CSS = "SpaceView { width: 1fr; height: 1fr; }"

    def __init__(
        self,
        model: ArmModel,
        *,
        braille: bool,
        unknown: str = "posture not known",
        camera: Camera = VIEWS["iso"],
        clock: Callable[[], float] = time.monotonic,
        id: str | None = None,  # noqa: A002
    ) -> None:
        super().__init__(id=id)
        self.camera: Camera = camera
        self._unknown = unknown
        self._clock = clock
        self._scene = ArmDrawing(model)
        self._studio = Studio(self._scene.dome, braille=braille)
        self._moment = Moment()
        self._painted: Painted | None = None
        self._styles: dict[Ink, Style] = {}
        self._worked_s = -math.inf
        self._working = False
        self._held_at: tuple[float, float] | None = None

    @property
    def rows(self) -> tuple[str, ...]:
        """The picture, row by row."""
        return tuple(self._painted.rows()) if self._painted is not None else ()

    def show(self, moment: Moment) -> None:
        """Draw the arm as it is now; nothing is done where nothing changed."""
        if moment != self._moment or self._painted is None:
            self._moment = moment
            self._redraw()
        if self._scene.missing is not None:
            self._work_out(self._scene.missing)

    def look(self, what: str) -> None:
        """Move the camera as a key asks, or forget the driven way; `LOOKS` and `CLEAR` name it."""
        if what == CLEAR:
            self._scene.trail.clear()
        else:
            self.camera = LOOKS[what](self.camera, self._scene.tip, self._scene.dome)
        self._redraw()

    # -- drawing ------------------------------------------------------------------------------

    def on_resize(self) -> None:
        """Draw again at the new size."""
        self._redraw()

    def notify_style_update(self) -> None:
        """Take the colours of another theme."""
        super().notify_style_update()
        self._styles = {}

    def render_line(self, y: int) -> Strip:
        """Return a row of the picture."""
        painted = self._painted
        if painted is None or y >= painted.height:
            return Strip.blank(self.size.width, self.rich_style)
        segments = [Segment(text, self._style(ink)) for text, ink in painted.runs(y)]
        return Strip(segments, painted.width)

    def _style(self, ink: Ink) -> Style:
        """Return how an ink looks in the present theme."""
        if ink not in self._styles:
            ink_style = self.app.stylesheet.parse_style(INK_STYLES[ink])
            self._styles[ink] = (self.visual_style + ink_style).rich_style
        return self._styles[ink]

    def _redraw(self) -> None:
        if self.size.height < LEAST_ROWS:
            self._painted = None
            return
        space = self._scene.space(self._moment, self._unknown)
        before = self._painted
        self._painted = self._studio.draw(space, self.camera, self.size.width, self.size.height)
        changed = [Region(x, y, width, 1) for x, y, width in self._painted.changes(before)]
        if changed:
            self.refresh(*changed)

    # -- the reach ----------------------------------------------------------------------------

    def _work_out(self, key: Key) -> None:
        """Compute an outline in a thread, one at a time, and not too often."""
        if self._working or self._clock() - self._worked_s < REST_S or not self.is_attached:
            return
        self._working, self._worked_s = True, self._clock()
        work = partial(self._worked, key)
        self.run_worker(work, thread=True, exit_on_error=False, group="reach")

    def _worked(self, key: Key) -> None:
        try:
            found = self._scene.work_out(key)
            self.app.call_from_thread(self._keep, key, found)
        finally:
            self._working = False

    def _keep(self, key: Key, found: Outline) -> None:
        self._scene.keep(key, found)
        self._redraw()

    # -- the mouse ----------------------------------------------------------------------------

    def on_mouse_down(self, event: events.MouseDown) -> None:
        """Take hold of the picture."""
        event.stop()
        self._held_at = (event.screen_x, event.screen_y)
        self.capture_mouse()

    def on_mouse_up(self, event: events.MouseUp) -> None:
        """Let go of it."""
        event.stop()
        self.release_mouse()

    def on_mouse_release(self) -> None:
        """Turn it no further: the button was released, or the app has taken the mouse away."""
        self._held_at = None

    def on_mouse_move(self, event: events.MouseMove) -> None:
        """Go round the arm, as if the table were turned by hand."""
        if self._held_at is None:
            return
        x, y = self._held_at
        self._held_at = (event.screen_x, event.screen_y)
        across, down = DRAG_DEG
        by_x, by_y = event.screen_x - x, event.screen_y - y
        if by_x or by_y:
            self.camera = self.camera.orbited(round(-by_x * across), round(by_y * down))
            self._redraw()

    def on_mouse_scroll_up(self, event: events.MouseScrollUp) -> None:
        """Come nearer."""
        event.stop()
        self.look("nearer")

    def on_mouse_scroll_down(self, event: events.MouseScrollDown) -> None:
        """Go farther away."""
        event.stop()
        self.look("farther")
