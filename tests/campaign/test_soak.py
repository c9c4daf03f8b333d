"""The soak's judge tells a leak from a cache that fills; its census sees objects that are kept."""

import gc
import itertools
import random
import subprocess
import sys
import weakref
from pathlib import Path

import pytest

from . import soak as whole_soak
from .soak import (
    BETWEEN,
    PROCESS,
    WITHIN,
    Census,
    Figures,
    Soak,
    judged,
    risen_kb,
    row,
    soak,
    trend_kb,
    wrong_with,
)

ROOT = Path(__file__).parents[2]
HOURS = [2.4 + hour for hour in range(22)]


def looks(kb_at, noise_kb=0.0):
    draw = random.Random("looks")
    return [(hours, 10_000.0 + kb_at(hours) + draw.uniform(-1, 1) * noise_kb) for hours in HOURS]


def figures(memory_kb=lambda _: 0.0, process_kb=lambda _: 0.0, drift_steps=0):
    return [
        Figures(h, 100, 9, 10_000.0 + memory_kb(h), 40_000.0 + process_kb(h), drift_steps, h)
        for h in HOURS
    ]


@pytest.mark.parametrize("allowed", [BETWEEN, WITHIN, PROCESS])
def test_a_leak_is_refused(allowed):
    a_day_kb = 4 * allowed.trend_kb
    wrong = judged(looks(lambda h: a_day_kb * h / 24, allowed.trend_kb / 4), allowed)
    assert any("keeps growing" in line for line in wrong)


def test_a_leak_of_one_byte_a_call_is_refused():
    a_call, calls_an_hour = 1 / 1024, 3000
    assert judged(looks(lambda h: a_call * calls_an_hour * h, 3.0), BETWEEN)


@pytest.mark.parametrize("full_after_h", [3.0, 8.0, 12.0])
def test_a_bounded_cache_that_fills_is_not_refused(full_after_h):
    size_kb = 0.8 * BETWEEN.total_kb
    filling = looks(lambda h: size_kb * min(h / full_after_h, 1.0), 3.0)
    assert not judged(filling, BETWEEN)


def test_a_ring_whose_content_comes_and_goes_is_not_refused():
    draw = random.Random("ring")
    assert not judged(looks(lambda _: draw.uniform(0.0, 250.0)), WITHIN)


def test_outliers_are_no_trend_and_hide_none():
    steady = looks(lambda h: 200.0 if h > 22.5 else 0.0)
    leaking = looks(lambda h: -400.0 if h > 22.5 else 5.0 * h)
    assert not judged(steady, BETWEEN)
    assert judged(leaking, BETWEEN)


def test_too_much_early_growth_is_refused():
    wrong = judged(looks(lambda h: 300.0 if h > 6.0 else 0.0), BETWEEN)
    assert [line for line in wrong if "since it was warm" in line] == wrong != []


def test_memory_that_is_released_is_allowed():
    falling = looks(lambda h: -20.0 * h)
    assert trend_kb(falling) < 0.0
    assert risen_kb(falling) < 0.0
    assert not judged(falling, BETWEEN)


def test_the_process_and_the_drift_are_judged_as_well():
    assert not wrong_with(figures())
    assert "process" in wrong_with(figures(process_kb=lambda h: 400.0 * h))[0]
    assert wrong_with(figures(drift_steps=1)) == ["it drifted"]
    assert row("grbl", figures(drift_steps=2)).split(" | ")[-2] == "2"


WHAT_IS_KEPT = """
from tests.campaign.soak import census, process_kb
before = census()
kept = [bytes(1000) + str(number).encode() for number in range(1000)]
during = census()
del kept
after = census()
assert during.total_kb - before.total_kb > 1000.0
assert abs(after.total_kb - before.total_kb) < 100.0
assert during.since(before).startswith("bytes +")
assert process_kb() >= 0.0
"""


def test_a_census_sees_objects_while_they_are_kept():
    """It runs in a process of its own, because that of a whole suite has too many objects."""
    run = subprocess.run(
        [sys.executable, "-c", WHAT_IS_KEPT],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stderr


def test_a_program_that_was_closed_leaves_nothing_behind():
    work = Soak("teachmover")
    work.stage.connect(allow_restored=True, automatic=True)
    recorder = weakref.ref(work.stage.arm.parts.tracer)
    work.stage.arm.close()
    work.stage.arm = None
    gc.collect()
    assert recorder() is None


@pytest.mark.parametrize("lasting", [False, True])
def test_a_short_soak_drifts_nowhere_and_a_leak_in_it_is_refused(monkeypatch, capsys, lasting):
    counted = itertools.count()
    monkeypatch.setattr(whole_soak, "census", lambda: Census({"Entry": 50_000 * next(counted)}))
    table_row, wrong = soak("teachmover", 0.05, lasting=lasting)
    assert all("memory" in line or "Entry +" in line for line in wrong)
    assert len(wrong) > 1
    assert table_row.startswith("| teachmover | 0.1 |")
    assert len(capsys.readouterr().out.splitlines()) > 4
