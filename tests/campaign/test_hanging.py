"""A driver that hangs, in each way, is a violation `hangs`; a paused arm is not."""

import gc
import math

import pytest

from armdrive.errors import WrongState
from armdrive.motion.execute import follow
from armdrive.runtime.clock import SimulatedPace
from armdrive.runtime.engine import Engine
from armdrive.runtime.overrides import LONGEST_SIMULATED_WAIT_S, SpeedOverride
from armdrive.status import State
from armdrive.tasks import SleepUntil

from . import clock
from .actions import move_j
from .clock import Deadlines, Hang
from .laws import LONGEST_S, Broken, call
from .mission import Mission, Outcome, run_mission

SEED = 1


def test_no_time_passes(monkeypatch):
    monkeypatch.setattr(Engine, "_next_s", lambda engine: engine.now_s)
    result = run_mission("teachmover", SEED)
    assert result.outcome is Outcome.VIOLATION
    assert "hangs: the engine was called" in result.broken[0]


def test_a_task_loops_without_waiting(monkeypatch):
    def circling(context, plan):
        while True:
            yield SleepUntil(context.now_s)

    monkeypatch.setattr("armdrive.arm.moving.follow", circling)
    seeds = (run_mission("teachmover", seed) for seed in range(8))
    found = next(each for each in seeds if each.broken)
    assert "hangs: " in found.broken[0]
    assert "without waiting" in found.broken[0]


def test_time_passes_for_ever(monkeypatch):
    """A motion never ends, and its call never gives up."""

    def waiting(context, plan):
        while not context.stopping:
            yield SleepUntil(context.now_s + 1.0)
        yield from follow(context, plan)

    monkeypatch.setattr("armdrive.arm.moving.follow", waiting)
    monkeypatch.setattr("armdrive.arm.moving.PATIENCE_S", 1e9)
    found = next(
        each for each in (run_mission("teachmover", seed) for seed in range(8)) if each.broken
    )
    assert "hangs: " in found.broken[0]
    assert "had not ended at" in found.broken[0]
    assert "(" in found.broken[0].partition("hangs: ")[2]  # the call, with its goal


def test_a_call_waits_for_ever_in_a_pause(monkeypatch):
    """An earlier bug: the driver has no limit, and the mission does not resume."""
    monkeypatch.setattr(SpeedOverride, "longest_s", math.inf)
    monkeypatch.setattr("armdrive.runtime.overrides.time.sleep", lambda _: None)
    mission = ready()
    mission.stage.arm.pause()
    with pytest.raises(Broken, match=r"hangs: move_j\(.* had not ended at"):
        moved(mission)


def test_a_driver_that_never_lets_the_engine_take_a_turn(monkeypatch):
    def computing(*_):
        while True:
            pass

    monkeypatch.setattr(Mission, "cpu_s", 0.2)
    monkeypatch.setattr(SimulatedPace, "wait", computing)
    gc.disable()  # what a signal raises in one of hypothesis's callbacks of the collector is lost
    try:
        result = run_mission("teachmover", SEED)
    finally:
        gc.enable()
    assert result.broken == ("hangs: the driver has computed for 0.2 s of processor time",)


def ready() -> Mission:
    """Return a mission whose arm is in standby and referenced."""
    mission = Mission("teachmover", SEED)
    stage = mission.stage
    stage.connect(allow_restored=False, automatic=False)
    joints, opening_mm = stage.posture()
    stage.arm.reference.declare(joints, opening_mm=opening_mm)
    return mission


def moved(mission):
    """Move within the limits; return the error, if any."""
    stage = mission.stage
    while True:
        error = move_j(stage)
        if error is None or isinstance(error, WrongState):
            return error


def test_a_motion_requested_in_a_pause_ends_and_says_how_to_resume(monkeypatch):
    monkeypatch.setattr("armdrive.runtime.overrides.time.sleep", lambda _: None)
    mission = ready()
    arm = mission.stage.arm
    arm.pause()
    began_s = mission.stage.now_s
    error = moved(mission)
    assert "call `resume()`, or run `armdrive resume`" in str(error)
    assert mission.stage.now_s - began_s >= LONGEST_SIMULATED_WAIT_S
    assert arm.status.paused
    assert arm.status.state is State.STANDBY
    arm.resume()
    assert moved(mission) is None


@pytest.mark.parametrize("seed", [9800394, 9801417, 77100004])
def test_a_program_that_is_suspended_in_a_pause_ends(seed):
    assert not run_mission("teachmover", seed).broken


def test_turns_and_time_are_counted_for_a_call_and_for_a_mission(monkeypatch):
    monkeypatch.setattr(clock, "CALL_TURNS", 10)
    monkeypatch.setattr(clock, "MISSION_TURNS", 25)
    deadlines = Deadlines()
    for _ in range(2):
        deadlines.begin("look", 100.0)
        for _ in range(10):
            deadlines.turn(1.0)
    with pytest.raises(Hang, match="look had not ended"):
        deadlines.turn(1.0)
    deadlines.end()
    for _ in range(4):
        deadlines.turn(1.0)
    with pytest.raises(Hang, match="the mission had not ended"):
        deadlines.turn(1.0)


def test_a_suspension_does_not_count_as_time_of_a_call():
    deadlines = Deadlines()
    deadlines.begin("look", LONGEST_S)
    deadlines.postpone(4000.0)
    deadlines.turn(4010.0)
    with pytest.raises(Hang):
        deadlines.turn(4100.0)


def test_a_late_call_is_reported_with_how_late_it_was():
    mission = ready()
    with pytest.raises(Broken, match=r"it lasted 2\d\.\d s"):
        call(mission.stage, lambda: mission.stage.arm.sleep(LONGEST_S + 1.0))
