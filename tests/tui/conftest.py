"""Makes tests of the desk wait until it has nothing to do, however busy the computer is."""

import asyncio
from types import SimpleNamespace

import pytest
from desk_planner import at_rest
from textual._compositor import Compositor
from textual.css.stylesheet import Stylesheet
from textual.pilot import Pilot

from armdrive.render import scene
from armdrive.storage import files as places
from tui import app as app_module
from tui.keys import presses

QUIET_TURNS = 3
MOST_TURNS = 100_000


async def quiet(min_sleep: float = 0.0, max_sleep: float = 1.0) -> None:
    """Let the event loop turn until it has had nothing else to do for some turns.

    Textual's own function waits until the processor is idle, which takes at least 0.02 s per key,
    and on a busy computer a desk that could not run looks idle too.
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
        await quiet()  # Textual sends each widget a message for each key, and waits for all
        return True

    monkeypatch.setattr(Pilot, "_wait_for_screen", widgets_are_done)


@pytest.fixture(autouse=True)
def _time_stands_still(monkeypatch):
    """Keep apps from reading the wall clock, because on a busy computer they would seem suspended.

    A test of old keys or of a suspension gives its app another clock.
    """
    monkeypatch.setattr(app_module, "_time", SimpleNamespace(get_time=lambda: 0.0))


@pytest.fixture(autouse=True)
def _keys_do_not_wait(monkeypatch):
    """Let a test press keys one after the other at once; a test of pasted text lets them wait."""
    monkeypatch.setattr(presses, "GATE_S", 0.0)


@pytest.fixture
def snap_compare(snap_compare):
    """Take each picture, and press each key, when the app is at rest.

    The plugin's own fixture waits for no thread and no layout, so that its picture depends on how
    busy the computer is.
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
    """Skip partial updates, which only a terminal would show.

    Snapshots and sessions paint the whole picture.
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
    """Parse each style sheet once for all desks; parsing takes half of a desk's start."""
    parse_rules = Stylesheet._parse_rules

    def parse(self, css, read_from, is_default_rules=False, tie_breaker=0, scope=""):
        key = (css, read_from, is_default_rules, tie_breaker, scope, *self._variables.items())
        if key not in _rules_read:
            _rules_read[key] = parse_rules(
                self, css, read_from, is_default_rules, tie_breaker, scope
            )
        return _rules_read[key]

    monkeypatch.setattr(Stylesheet, "_parse_rules", parse)


@pytest.fixture(scope="session")
def _outlines():
    return {}


@pytest.fixture(autouse=True)
def _work_out_each_reach_once(monkeypatch, _outlines):
    """Compute the outline of an arm's reach once for all desks; a desk does it when it opens."""
    outline = scene.outline

    def kept(arm, key):
        if (arm, key) not in _outlines:
            _outlines[arm, key] = outline(arm, key)
        return _outlines[arm, key]

    monkeypatch.setattr(scene, "outline", kept)


@pytest.fixture
def own_home(tmp_path, monkeypatch):
    """Keep the arm files of a test in a folder of its own."""
    monkeypatch.setenv("ARMDRIVE_HOME", str(tmp_path))
    monkeypatch.delenv("ARMDRIVE_FORCE_SIM", raising=False)
    places.arm_files().mkdir(parents=True, exist_ok=True)
