"""A desk in a test is waited for until nothing of it could run, however busy the computer is."""

from __future__ import annotations

import asyncio

import pytest
from textual.css.stylesheet import Stylesheet

from armdrive import places

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
