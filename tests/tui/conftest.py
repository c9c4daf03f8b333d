"""A desk in a test is waited for until nothing of it could run, however busy the computer is."""

from __future__ import annotations

import asyncio

import pytest

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


@pytest.fixture
def own_home(tmp_path, monkeypatch):
    """Give the arm files of a test a folder of their own."""
    monkeypatch.setenv("ARMDRIVE_HOME", str(tmp_path))
    monkeypatch.delenv("ARMDRIVE_FORCE_SIM", raising=False)
    places.arm_files().mkdir(parents=True, exist_ok=True)
