"""The soak's judge tells a leak from a cache that fills, and a short soak drifts nowhere."""

import gc
import weakref

import pytest
from amounts import every_row

from tests.scenarios.stage import Stage

from .arms import config_of
from .soak import OBJECTS, PROCESS_KB, Figures, work, wrong_with

HOURS = range(3, 24)


def nothing(_: int) -> float:
    return 0.0


@every_row(
    "objects, process_kb, drift, wrong",
    [
        (nothing, nothing, 0, False),
        (nothing, nothing, 1, True),
        (lambda hour: hour * OBJECTS / 6.0, nothing, 0, True),
        (nothing, lambda hour: hour * PROCESS_KB / 6.0, 0, True),
        (lambda hour: 9e4 * min(hour / 8.0, 1.0), nothing, 0, False),  # a cache, full in 8 hours
        (lambda hour: -20.0 * hour, nothing, 0, False),
        (lambda hour: 9e4 if hour > 22 else 0.0, nothing, 0, False),  # an outlier
    ],
    ids=lambda row: str(row[2:]),
)
def test_a_leak_is_told_from_a_cache_and_an_outlier(objects, process_kb, drift, wrong):
    found = [Figures(h, 9, round(1e5 + objects(h)), 4e4 + process_kb(h), drift) for h in HOURS]
    assert bool(wrong_with(found)) is wrong


def test_a_program_that_was_closed_leaves_nothing_behind():
    stage = Stage(config_of("teachmover", 0))
    stage.connect()
    recorder = weakref.ref(stage.arm.parts.tracer)
    stage.arm.close()
    stage.arm = None
    gc.collect()
    assert recorder() is None


@pytest.mark.parametrize("lasting", [False, True])
def test_a_short_soak_drifts_nowhere(lasting):
    found = list(work("teachmover", 0.012, lasting=lasting))
    assert len(found) > 3
    assert not any(each.drift_steps for each in found)
