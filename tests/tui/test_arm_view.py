"""The arm view: keys and mouse move its camera, little is repainted, the reach takes its time."""

import io
from dataclasses import replace

import pytest
from desk_fake import MODEL, Clock
from pages import page_path
from rich.console import Console
from textual._compositor import ChopsUpdate
from textual.actions import parse
from textual.app import App
from textual.events import MouseScrollUp

from armdrive.render.camera import LOOKS, VIEWS
from armdrive.render.canvas import PATTERNS
from armdrive.render.scene import Moment
from kinematics import Joints
from kinematics.guards.shapes import Box
from tui.arm_view import CLEAR, REST_S, SpaceView, move_cameras
from tui.keys.keyboard import label
from tui.keys.table import VIEW_KEYS

TRAY = Box("tray", (200.0, -150.0, 0.0), (320.0, -60.0, 60.0))
GUARDED = replace(
    MODEL,
    guards=replace(MODEL.guards, boxes=(TRAY,), radii_mm=(20.0, 20.0, 15.0), base_radius_mm=70.0),
)
PAGE = page_path("desk")
GOAL = Joints.of(-30.0, 40.0, -60.0, -60.0, 15.0)


def posture(base_deg=20.0, wrist_deg=-60.0):
    return Joints.of(base_deg, 60.0, -80.0, wrist_deg, 15.0)


@pytest.fixture(autouse=True)
def _paint_only_whole_pictures():
    """Paint what is sent to the terminal too: tests here look at it."""


class Viewer(App):
    """An app with an arm view, and what it was asked to repaint."""

    def __init__(self, *, braille=True, moment=None):
        super().__init__()
        self.clock = Clock()
        self.view = SpaceView(GUARDED, braille=braille, clock=self.clock, id="space")
        self.moment = moment or Moment(posture(), 38.0, goal=GOAL)
        self.painted = []
        self.begun = False

    def compose(self):
        yield self.view

    def on_mount(self):
        self.call_after_refresh(self.begin)

    def begin(self):
        self.view.show(self.moment)
        self.begun = True

    def _display(self, screen, renderable):
        if isinstance(renderable, ChopsUpdate):
            self.painted.append(renderable.render_segments(Console(file=io.StringIO())))
        super()._display(screen, renderable)


async def settled(pilot):
    """Wait until the view is shown and nothing is being worked out for it."""
    while not pilot.app.begun:
        await pilot.pause()
    await pilot.app.workers.wait_for_complete()
    await pilot.pause()


async def test_every_look_moves_the_camera_and_thirty_six_orbits_lead_back():
    app = Viewer()
    async with app.run_test(size=(80, 24)) as pilot:
        await settled(pilot)
        before = app.view.rows
        for _ in range(36):
            app.view.look("left")
        assert app.view.rows == before
        for what in LOOKS:
            app.view.camera = VIEWS["front"].orbited(33, 20).zoomed(1, None, app.view._scene.dome)
            camera = app.view.camera
            assert move_cameras(app.screen, what)
            assert app.view.camera != camera, what
            assert len(app.view.rows) == 24


async def test_a_small_motion_repaints_a_small_part_of_the_screen():
    app = Viewer()
    async with app.run_test(size=(120, 40)) as pilot:
        await settled(pilot)
        app.painted.clear()
        for _ in range(5):
            app.view.show(app.moment)
            await pilot.pause()
        assert app.painted == [], "nothing has changed"
        app.view.show(Moment(posture(20.3), 38.0, goal=GOAL))
        await pilot.pause()
        assert app.painted
        assert 0 < sum(len(text) for text in app.painted) < 4000
        assert sum(text.count("\x1b[") for text in app.painted) < 200


async def test_the_reach_is_worked_out_beside_the_polls_and_the_driven_way_is_shown():
    app = Viewer()
    async with app.run_test(size=(120, 40)) as pilot:
        await settled(pilot)
        assert "reach at pitch -80" in app.view.rows[-1]
        turned = Moment(posture(wrist_deg=0.0), 38.0)
        app.view.show(turned)
        await settled(pilot)
        assert "reach at pitch -80" in app.view.rows[-1], "not too often"
        app.clock.now_s += REST_S
        app.view.show(turned)
        await settled(pilot)
        assert "reach at pitch -20" in app.view.rows[-1]
        for step in range(20):
            app.view.show(Moment(posture(20.0 - 2.0 * step), 38.0))
        assert "driven" in app.view.rows[-1]
        app.view.look(CLEAR)
        assert "driven" not in app.view.rows[-1]


async def test_dragging_orbits_the_wheel_zooms_and_another_theme_takes_hold_at_once():
    app = Viewer()
    async with app.run_test(size=(80, 24)) as pilot:
        await settled(pilot)
        await pilot.mouse_down("#space", offset=(40, 12))
        await pilot.hover("#space", offset=(45, 13))
        await pilot.mouse_up("#space", offset=(45, 13))
        orbited = app.view.camera
        assert (orbited.azimuth_deg, orbited.elevation_deg) == (225 - 5 * 3, 35 + 6)
        await pilot.hover("#space", offset=(50, 13))
        assert app.view.camera == orbited
        await pilot._post_mouse_events([MouseScrollUp], "#space", button=0)
        assert app.view.camera.zoom == 1
        dark = app.view.render_lines(app.view.size.region)
        app.theme = "textual-light"
        await pilot.pause()
        light = app.view.render_lines(app.view.size.region)
        assert [strip.text for strip in light] == [strip.text for strip in dark]
        assert light != dark


def test_every_key_asks_for_a_look_that_there_is_and_none_could_come_as_an_arrow():
    asked = [parse(action)[2][0] for row in VIEW_KEYS for *_, action in row.bound]
    assert set(asked) == {*LOOKS, CLEAR} - set(VIEWS)
    assert len(set(asked)) == len(asked)
    assert not [key for row in VIEW_KEYS for key in row.all_keys if "+" in key or key in LOOKS]


def test_the_page_tells_every_key_and_every_mark():
    page = PAGE.read_text(encoding="utf-8")
    for row in VIEW_KEYS:
        assert f"`{label(row.keys[0])}`" in page, row.id
    for ink, pattern in PATTERNS.items():
        assert not pattern.mark or f"`{pattern.mark}`" in page, ink
        assert not pattern.word or f"| {pattern.word} |" in page, ink
        if pattern.period > 1:
            many = "a dot" if pattern.on == 1 else f"{pattern.on} dots"
            assert f"{many} in {pattern.period} |" in page, ink
