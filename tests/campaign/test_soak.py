"""The soak's judge tells a leak from a cache that fills; its census sees objects that are kept."""

import gc
import itertools
import random
import subprocess
import sys
import weakref
from pathlib import Path

import pytest
from amounts import THOROUGH, every_row

from . import soak as whole_soak
from .soak import ALLOWED_KB, Census, Figures, Soak, judged, soak, wrong_with

ROOT = Path(__file__).parents[2]
HOURS = range(3, 24)
BETWEEN, WITHIN, PROCESS = ALLOWED_KB


def figures(memory_kb=lambda _: 0.0, process_kb=lambda _: 0.0, drift_steps=0):
    return [
        Figures(h, 100, 9, 10_000.0 + memory_kb(h), 40_000.0 + process_kb(h), drift_steps, h)
        for h in HOURS
    ]


def noise(most_kb):
    draw = random.Random("figures")
    return lambda _: draw.uniform(-1, 1) * most_kb


@every_row(
    "what, kb_at, leaks",
    [
        *((what, lambda h, most=most: most * h / 6, True) for what, most in ALLOWED_KB.items()),
        (BETWEEN, lambda h: 3000 / 1024 * h * 2 + noise(3.0)(h), True),  # two bytes a call
        (BETWEEN, noise(3.0), False),
        (BETWEEN, lambda h: 100.0 * min(h / 8.0, 1.0), False),  # a cache that is full in 8 hours
        (BETWEEN, lambda h: -20.0 * h, False),
        (BETWEEN, lambda h: 200.0 if h > 22 else 0.0, False),
        (BETWEEN, lambda h: -400.0 if h > 22 else 5.0 * h, True),
        (WITHIN, noise(125.0), False),  # a ring whose content comes and goes
    ],
    ids=lambda row: row[0],
)
def test_a_leak_is_told_from_a_cache_a_ring_and_an_outlier(what, kb_at, leaks):
    assert bool(judged(what, [10_000.0 + kb_at(hour) for hour in HOURS])) is leaks


def test_the_process_and_the_drift_are_judged_as_well():
    assert not wrong_with(figures())
    assert "process" in wrong_with(figures(process_kb=lambda h: 400.0 * h))[0]
    assert wrong_with(figures(drift_steps=1)) == ["it drifted"]


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


@pytest.mark.skipif(not THOROUGH, reason="tests a figure of the soak, in a process of its own")
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
    wrong = soak("teachmover", 0.05, lasting=lasting)
    assert all("memory" in line or "Entry +" in line for line in wrong)
    assert len(wrong) > 1
    assert len(capsys.readouterr().out.splitlines()) > 4
