"""The soak's judge tells a leak from a cache that fills, and a short soak drifts nowhere."""

import gc
import weakref

import pytest
from amounts import every_row

from tests.scenarios.stage import Stage

from .arms import config_of
from .soak import OBJECTS, Figures, work, wrong_with

HOURS = range(3, 24)


@every_row(
    "objects, drift, wrong",
    [
        (lambda _: 0.0, 0, False),
        (lambda _: 0.0, 1, True),
        (lambda hour: hour * OBJECTS / 6.0, 0, True),
        (lambda hour: 9e4 * min(hour / 8.0, 1.0), 0, False),  # a cache, full in 8 hours
        (lambda hour: -20.0 * hour, 0, False),
        (lambda hour: 9e4 if hour > 22 else 0.0, 0, False),  # an outlier
    ],
    ids=lambda row: str(row[1:]),
)
def test_a_leak_is_told_from_a_cache_and_an_outlier(objects, drift, wrong):
    found = [Figures(hour, 9, round(1e5 + objects(hour)), drift) for hour in HOURS]
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
    found = list(work("teachmover", 0.008, lasting=lasting))
    assert len(found) > 3
    assert not any(each.drift_steps for each in found)
