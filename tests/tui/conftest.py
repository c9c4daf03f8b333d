"""A desk in a test is waited for until nothing of it could run, however busy the computer is."""

from __future__ import annotations

import asyncio
from types import SimpleNamespace

import pytest
from desk_planner import at_rest
from textual._compositor import Compositor
from textual.css.stylesheet import Stylesheet
from textual.pilot import Pilot

from armdrive.storage import files as places
from tui import app as app_module

QUIET_TURNS = 3
MOST_TURNS = 100_000


async def quiet(min_sleep: float = 0.0, max_sleep: float = 1.0) -> None:
    """Let the loop turn until it has had nothing but this to do for some turns.

    Textual's own waits until the processor is idle: a fiftieth of a second at least for each key,
    and on a busy computer a desk that has not been let run looks idle too.
    """
    loop = asyncio.get_running_loop()
    turns = 0
    for _ in range(MOST_TURNS):
        await asyncio.sleep(0)
        turns = 0 if loop._ready else turns + 1
        if turns == QUIET_TURNS:
            return


@pytest.fixture(autouse=True)
def _wait_for_the_desk_alone(monkeypatch):
    monkeypatch.setattr("textual.app.wait_for_idle", quiet)
    monkeypatch.setattr("textual.pilot.wait_for_idle", quiet)

    async def widgets_are_done(pilot: Pilot[object], timeout: float = 30.0) -> bool:
        await quiet()  # the framework sends each widget a message and waits for all, at each key
        return True

    monkeypatch.setattr(Pilot, "_wait_for_screen", widgets_are_done)


@pytest.fixture(autouse=True)
def _time_stands_still(monkeypatch):
    """Keep apps from reading the wall clock: on a busy computer they would seem suspended.

    A test that is about old keys or about a suspension gives its app a clock of its own.
    """
    monkeypatch.setattr(app_module, "_time", SimpleNamespace(get_time=lambda: 0.0))


@pytest.fixture
def snap_compare(snap_compare):
    """Take each picture once the app is at rest, and press each key only then.

    The plugin's own fixture presses keys last and waits for no thread and no layout, so that its
    picture depends on how busy the computer is.
    """

    def compare(app, press=(), terminal_size=(80, 24), run_before=None):
        async def shown(pilot):
            await at_rest(pilot)
            if run_before is not None:
                await run_before(pilot)
            for key in press:
                await pilot.press(key)
                await at_rest(pilot)
            await at_rest(pilot)

        return snap_compare(app, terminal_size=terminal_size, run_before=shown)

    return compare


@pytest.fixture(autouse=True)
def _paint_only_whole_pictures(monkeypatch):
    """Leave out what would only be sent to a terminal: nobody looks at a headless one.

    A snapshot paints the whole picture, and so does a session whenever it is looked at.
    """
    render_update = Compositor.render_update

    def paint(self, full=False, **more):
        if full:
            return render_update(self, full, **more)
        self._dirty_regions.clear()
        return None

    monkeypatch.setattr(Compositor, "render_update", paint)


@pytest.fixture(scope="session")
def _rules_read():
    return {}


@pytest.fixture(autouse=True)
def _read_each_style_once(monkeypatch, _rules_read):
    """Parse a style sheet once for all desks: each reads the same ones, for half of its start."""
    parse_anew = Stylesheet._parse_rules

    def parse(self, css, read_from, is_default_rules=False, tie_breaker=0, scope=""):
        key = (css, read_from, is_default_rules, tie_breaker, scope, *self._variables.items())
        if key not in _rules_read:
            _rules_read[key] = parse_anew(
                self, css, read_from, is_default_rules, tie_breaker, scope
            )
        return _rules_read[key]

    monkeypatch.setattr(Stylesheet, "_parse_rules", parse)


@pytest.fixture
def own_home(tmp_path, monkeypatch):
    """Give the arm files of a test a folder of their own."""
    monkeypatch.setenv("ARMDRIVE_HOME", str(tmp_path))
    monkeypatch.delenv("ARMDRIVE_FORCE_SIM", raising=False)
    places.arm_files().mkdir(parents=True, exist_ok=True)
