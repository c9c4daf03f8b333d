"""No announced bound is broken, and none is inflated: the worst case reaches half of it.

Each row of the table is measured in simulated time, against the physical arm.
"""

from dataclasses import replace

import pytest
from amounts import THOROUGH, every_row

from armdrive.connect.target import simulated_config
from armdrive.registry import DIALECTS
from armdrive.runtime.stop_bounds import StopForecast
from armdrive.status import State

from .rows import HALF, REASONS, ROWS, Begin, Cause, Row, begin, measure, stage_of

TODAY = [row for row in ROWS if THOROUGH or row.cause not in (Cause.EXPIRY, Cause.SUSPENDED)]
"""A hold that expires is announced and ends as one that is released, a suspended program as a dead
one. Every dialect's are measured with THOROUGH=1."""


@pytest.mark.parametrize("row", TODAY, ids=str)
def test_the_worst_case_keeps_its_bound_and_reaches_half_of_it(row: Row) -> None:
    found = [measure(row, after_s) for after_s in row.after_s]
    for after_s, each in zip(row.after_s, found, strict=True):
        assert max(each.time_share, each.way_share) <= 1.0, f"ended after {after_s} s: {each}"
    least = REASONS[row.time].least if row.time else HALF
    assert max(each.time_share for each in found) >= least, f"the time is inflated: {found}"
    least = REASONS[row.way].least if row.way else HALF
    assert max(each.way_share for each in found) >= least, f"the distance is inflated: {found}"


def test_every_dialect_has_a_row_for_every_cause() -> None:
    there = {(row.dialect, row.cause) for row in ROWS}
    assert there == {(dialect, cause) for dialect in DIALECTS for cause in Cause}


@every_row("dialect", DIALECTS)
def test_each_dialect_reaches_half_of_both_bounds_without_a_reason(dialect: str) -> None:
    rows = [row for row in ROWS if row.dialect == dialect]
    assert any(not row.time for row in rows)
    assert any(not row.way for row in rows)


def test_every_reason_is_used_and_explained() -> None:
    given = {name for row in ROWS for name in (row.time, row.way) if name}
    assert given == set(REASONS)
    assert all(reason.why and 0.0 < reason.least < HALF for reason in REASONS.values())


def test_a_forecast_belongs_to_the_present_controller() -> None:
    config = simulated_config("teachmover")
    slow = replace(config, device=replace(config.device, speed_margin=8.0))
    forecast = StopForecast(config, config.model.transmission)
    bounds = [
        forecast.bound(DIALECTS["teachmover"].controller(each), None, lost=False, slowed=False)
        for each in (config, slow, config)
    ]
    assert bounds[0].time_s < bounds[1].time_s
    assert bounds[2] == bounds[0]


@pytest.mark.parametrize("dialect", DIALECTS)
def test_the_bound_at_rest_holds_for_any_motion_and_that_of_a_motion_ends_with_it(dialect):
    stage = stage_of(dialect, Begin.PLANNED)
    stops, motion = stage.arm.parts.core.stops, stage.arm.config.motion
    present = stage.arm.parts.core.stop_bound
    before = present()
    stage.arm.move_j(base_deg=3.0, speed=0.3, wait=False)
    stage.arm.sleep(0.1)
    assert present().distance_mm < before.distance_mm
    stage.arm.stop()
    assert present().time_s == before.time_s
    assert present().distance_mm == pytest.approx(before.distance_mm, rel=0.01)
    stops.burst_s = max(motion.planned_burst_s, motion.jog_burst_s)
    at_rest = present()
    begin(stage, Begin.PLANNED, 1.0, 1.0)
    stage.arm.sleep(0.05)
    assert stage.arm.parts.core.state is State.MOVING
    for figure in ("time_s", "silent_time_s", "distance_mm", "silent_distance_mm"):
        assert getattr(present(), figure) <= getattr(at_rest, figure)


@pytest.mark.parametrize("dialect", DIALECTS)
def test_a_slowed_motion_has_the_bound_of_any_motion(dialect: str) -> None:
    stage = stage_of(dialect, Begin.PLANNED)
    stage.arm.parts.core.stops.burst_s = stage.arm.config.motion.planned_burst_s
    anything = stage.arm.parts.core.stop_bound()
    begin(stage, Begin.PLANNED, 1.0, 1.0)
    stage.arm.sleep(0.05)
    stage.arm.speed_override = 0.1
    assert stage.arm.parts.core.stop_bound().time_s >= anything.time_s
    stage.arm.speed_override = 1.0  # the slow motion that was sent before still runs
    assert stage.arm.parts.core.stop_bound().time_s >= anything.time_s


def test_while_the_device_homes_the_bound_holds_for_any_posture() -> None:
    stage = stage_of("mks", Begin.HOMING)
    core = stage.arm.parts.core
    begin(stage, Begin.HOMING, 0.0, 1.0)
    stage.arm.sleep(0.3)
    folded = core.position.coordinates.joints.replace(shoulder=1.5, elbow=-1.5)
    bounds = [
        core.stops.bound(core.controller, joints, lost=False, slowed=False)
        for joints in (folded, None)
    ]
    assert bounds[0] == bounds[1]
    stage.arm.stop()
    assert core.stop_bound().distance_mm < bounds[0].distance_mm


def test_drives_that_fall_silent_while_homing_keep_its_bound_until_they_answer_a_reset() -> None:
    stage = stage_of("cia402", Begin.HOMING)
    core = stage.arm.parts.core
    at_rest = core.stop_bound()
    begin(stage, Begin.HOMING, 0.0, 1.0)
    stage.arm.sleep(0.3)
    homing = core.stop_bound()
    assert homing != at_rest
    stage.arm.twin.faults.add("mute")
    stage.arm.sleep(3.0)
    assert core.state is State.ERROR_STOP
    assert core.stop_bound() == homing
    stage.arm.twin.faults.end()
    stage.arm.reset()
    assert core.stop_bound().silent_time_s == at_rest.silent_time_s
