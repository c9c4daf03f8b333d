"""Pausing, resuming and slowing a simulated arm: what waits, continues, or ends."""

import contextlib
import math
import random
from functools import partial

import pytest
from amounts import amount
from faults import standing
from waiting import soon

from armdrive import Arm, Jog
from armdrive.connect import runner
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import simulated_config
from armdrive.errors import (
    ArmError,
    LinkLost,
    NoAnswer,
    NotReferenced,
    WrongState,
)
from armdrive.runtime import overrides
from armdrive.status import Evidence, State, Trust
from armdrive.storage.record import RecordFile

BY_BURSTS, QUEUED = "teachmover", "grbl"
STREAMED = "cia402"
"""Its drives get targets in each cycle, also while they stand in a pause."""
two_kinds = pytest.mark.parametrize("dialect", [BY_BURSTS, QUEUED])
"""Conformance does the same for all dialects."""

WAY_DEG = 30.0
SETTLES_S = 1.5
"""The longest of all dialects goes on for so long at most: a burst, or what was sent ahead."""


def moving(arm: Arm, after_s: float = 0.4):
    handle = arm.move_j(base_deg=WAY_DEG, speed=0.7, wait=False)
    arm.sleep(after_s)
    assert arm.status.state is State.MOVING
    return handle


def paused(arm: Arm, after_s: float = 0.4):
    """Return a motion that waits in a pause, and where the motors stand."""
    handle = moving(arm, after_s)
    arm.pause()
    arm.sleep(SETTLES_S)
    assert "PAUSED" in str(arm.status)
    assert arm.status.state is State.MOVING
    return handle, arm.twin.world.motors


@pytest.mark.parametrize(
    "dialect", amount(["armdroid", "grbl", "mks"], ["armdroid", "grbl", "mks", "cia402"])
)
def test_a_pause_ends_the_way_within_the_time_and_way_that_were_announced(dialect):
    """By whole bursts, in what a board has queued, and in what drives on a bus were sent ahead."""
    arm = standing(dialect)
    world, handle = arm.twin.world, arm.move_j(base_deg=50.0, speed=0.7, wait=False)
    for after_s in (0.4, 0.02, 0.05, 0.09, 0.13, 0.21, 0.3):
        arm.sleep(after_s)
        status, tip = arm.status, world.tip
        assert status.state is State.MOVING
        arm.pause()
        arm.sleep(status.pause_time_s)
        stood = world.motors
        arm.sleep(0.6)
        assert world.motors == stood
        assert math.dist(world.tip, tip) <= status.pause_distance_mm
        arm.resume()
    handle.wait()
    assert arm.joints.deg["base"] == pytest.approx(50.0, abs=0.1)
    assert arm.status.acknowledged == world.motors


def test_a_pause_drops_a_burst_that_is_still_being_prepared():
    arm = standing("armdroid")  # its board repeats the numbers before it is told to go
    world = arm.twin.world
    stood, handle = world.motors, arm.move_j(base_deg=WAY_DEG, wait=False)
    arm.sleep(0.1)
    assert arm.parts.engine.busy
    arm.pause()
    arm.sleep(1.0)
    assert world.motors == stood
    arm.resume()
    handle.wait()
    assert arm.joints.deg["base"] == pytest.approx(WAY_DEG, abs=0.1)
    assert arm.status.trust is Trust.REFERENCED


@pytest.mark.parametrize("pause_first", [True, False])
def test_a_board_restart_during_a_dropped_burst_ends_the_motion(pause_first):
    arm = standing("armdroid")
    handle = arm.move_j(base_deg=WAY_DEG, wait=False)
    arm.sleep(0.05)
    for act in (arm.pause, arm.twin.board.reset)[:: 1 if pause_first else -1]:
        act()
        arm.sleep(0.02)
    arm.sleep(4.0)
    stood = arm.twin.world.motors
    arm.resume()
    with pytest.raises(ArmError):
        handle.wait()
    assert arm.status.trust is not Trust.REFERENCED
    assert arm.twin.world.motors == stood


def test_a_motion_that_is_asked_for_in_a_pause_waits_for_its_end():
    arm = standing(BY_BURSTS)
    arm.pause()
    before = arm.twin.world.motors
    handle = arm.move_j(base_deg=10.0, wait=False)
    arm.sleep(5.0)
    assert arm.twin.world.motors == before
    arm.resume()
    handle.wait()
    assert not arm.parts.core.speed_override.waits
    assert arm.joints.deg["base"] == pytest.approx(10.0, abs=0.1)


@pytest.mark.parametrize(
    ("end", "error"),
    [(lambda arm: arm.estop(), ArmError), (lambda arm: arm.twin.link.unplug(), LinkLost)],
    ids=["emergency stop", "lost wire"],
)
@two_kinds
def test_nothing_goes_on_after_what_ended_the_motion_in_a_pause(dialect, end, error):
    arm = standing(dialect)
    handle, stood = paused(arm)
    end(arm)
    arm.sleep(0.5)
    assert not arm.status.paused
    arm.resume()
    with pytest.raises(error):
        handle.wait()
    arm.sleep(1.0)
    if arm.status.state is State.ERROR_STOP:
        arm.reset()
        arm.sleep(2.0)
    assert arm.twin.world.motors == stood


@pytest.mark.parametrize("moved_by_pendant", [True, False])
def test_an_arm_that_was_moved_or_doubted_in_a_pause_does_not_go_on(moved_by_pendant):
    arm = standing(BY_BURSTS)
    handle, _ = paused(arm)
    if moved_by_pendant:
        arm.twin.device.jog((50, 0, 0, 0, 0, 0))
    else:
        arm.parts.core.learn(Evidence.READ_BACK_DIFFERS, arm.status.time_s)
    moved = arm.twin.world.motors
    arm.resume()
    with pytest.raises(WrongState, match="no longer where it was paused"):
        handle.wait()
    assert arm.twin.world.motors == moved


def test_a_paused_increment_reports_that_it_fell_short():
    arm = standing(BY_BURSTS)
    arm.jogging.nudge(Jog.joint(base=20.0), speed=0.3)
    arm.sleep(0.5)
    arm.pause()
    arm.sleep(SETTLES_S)
    assert 0.0 < arm.joints.deg["base"] < 19.0
    assert arm.status.state is State.STANDBY
    assert "paused" in arm.status.notice
    for jog in (arm.jogging.nudge, partial(arm.jogging.hold, for_s=1.0)):
        jog(Jog.joint(base=-1.0), speed=0.5)
        assert "paused" in arm.status.notice
    with pytest.raises(WrongState, match="resume"):
        arm.jog_j(base_deg=2.0)


@two_kinds
def test_an_override_makes_a_motion_last_as_much_longer_and_end_on_the_same_step(dialect):
    arm = standing(dialect)
    took_s, ends = [], []
    for share in (1.0, 0.25, 0.1):
        arm.move_j(base_deg=0.0)
        arm.speed_override = share
        took_s.append(arm.move_j(base_deg=20.0).duration_s)
        ends.append(arm.twin.world.motors)
        arm.speed_override = 1.0
    assert took_s[1] == pytest.approx(4.0 * took_s[0], rel=0.25)
    assert took_s[2] == pytest.approx(10.0 * took_s[0], rel=0.3)
    assert ends == [ends[0]] * 3


@pytest.mark.parametrize("after_s", [0.0, 0.3])
@two_kinds
def test_a_slowed_motion_has_its_timeout_at_full_speed(dialect, after_s):
    arm = standing(dialect)
    handle, began_s = arm.move_j(base_deg=40.0 if after_s else 10.0, wait=False), arm.status.time_s
    handle._timeout_s = 2.0 + 3 * after_s
    device = arm.twin.device
    device.at(device.now_s + after_s, lambda: setattr(arm, "speed_override", 0.1))
    handle.wait()
    assert arm.status.time_s - began_s > 4.0
    handle = arm.move_j(base_deg=-80.0, wait=False)
    handle._timeout_s = 0.5
    with pytest.raises(NoAnswer, match="had not ended"):
        handle.wait()


@two_kinds
def test_an_override_holds_for_held_jogs(dialect):
    arm = standing(dialect)
    arm.speed_override = 0.1
    assert "slowed to 10%" in str(arm.status)
    before = arm.joints.deg["base"]
    arm.jog_j(base=-1.0, speed=1.0, duration_s=1.0)
    assert 0.0 < before - arm.joints.deg["base"] < 21.2 * 0.1 * 1.6


def test_a_paused_script_on_simulated_time_waits_for_a_resume():
    arm = standing(BY_BURSTS)
    arm.pause()
    soon(arm.resume)
    arm.move_j(base_deg=10.0)
    assert arm.joints.deg["base"] == pytest.approx(10.0, abs=0.1)


@pytest.mark.parametrize("dialect", [BY_BURSTS, QUEUED, STREAMED])
def test_time_in_a_pause_does_not_count_towards_a_motions_timeout(monkeypatch, dialect):
    monkeypatch.setattr(overrides, "NAP_S", 0.0)  # no other thread resumes it
    arm = standing(dialect)
    handle, _ = paused(arm)
    handle._timeout_s = 5.0
    device = arm.twin.device
    device.at(device.now_s + 2.0 * handle._timeout_s, arm.resume)
    handle.wait()
    assert arm.joints.deg["base"] == pytest.approx(WAY_DEG, abs=0.1)


def test_a_stream_that_stands_in_an_endless_pause_does_not_hang(monkeypatch):
    monkeypatch.setattr(overrides, "LONGEST_SIMULATED_WAIT_S", 4.0)
    monkeypatch.setattr(runner, "PATIENCE_S", 2.0)
    handle, _ = paused(standing(STREAMED))
    with pytest.raises(NoAnswer, match="had not ended"):
        handle.wait()


def test_an_arm_that_is_killed_in_a_pause_is_remembered_where_it_stands(tmp_path):
    recorder = RecordFile(tmp_path / "record.json")
    arm = Arm(connect_simulated(simulated_config(BY_BURSTS), record_store=recorder))
    arm.home()
    paused(arm)
    record = RecordFile(tmp_path / "record.json").load()
    assert not record.in_motion
    assert record.registers == arm.status.acknowledged - arm.parts.core.position.offset


ASKED = ("move", "pause", "pause", "resume", "slow", "jog", "nudge", "sleep", "stop", "estop")


def ask(arm: Arm, what: str, chance: random.Random) -> None:
    match what:
        case "move":
            arm.move_j(base_deg=chance.uniform(-40, 40), wait=False)
        case "slow":
            arm.speed_override = chance.choice((0.1, 0.5, 1.0))
        case "jog":
            arm.jogging.hold(Jog.joint(base=chance.choice((-1, 1))), speed=0.5, for_s=0.5)
        case "nudge":
            arm.jogging.nudge(Jog.joint(shoulder=chance.choice((-3, 3))), speed=0.5)
        case "sleep":
            arm.sleep(chance.uniform(0.0, 1.0))
        case "estop":
            arm.estop()
            arm.sleep(1.0)
            arm.reset()
            arm.enable()
        case _:
            getattr(arm, what)()


@pytest.mark.parametrize("seed", range(amount(2, 8)))
@two_kinds
def test_in_any_order_of_calls_a_paused_arm_stands_and_its_position_is_right(dialect, seed):
    chance, arm = random.Random(seed), standing(dialect)
    for _ in range(20):
        with contextlib.suppress(WrongState, NotReferenced):
            ask(arm, chance.choice(ASKED), chance)
        arm.sleep(0.2)
        if arm.status.paused:
            arm.sleep(SETTLES_S)
            stood = arm.twin.world.motors
            arm.sleep(0.5)
            assert arm.twin.world.motors == stood
    arm.stop()
    assert arm.status.state is State.STANDBY
    if arm.status.trust is Trust.REFERENCED:  # a board that was stopped dead has lost steps
        assert arm.status.acknowledged == arm.twin.world.motors
