"""A disk without room, a dying one, a folder that is read-only, a clock that is set: what moves."""

from __future__ import annotations

import math
import time

import pytest
from power_disk import Moments
from power_life import PATH, believed, move, recorded_life, wrong

from armdrive.errors import StateFileError
from armdrive.status import Current, State, Trust
from armdrive.storage.record import from_text


@pytest.mark.parametrize("also_removing", [False, True])
def test_a_disk_that_fills_up_or_dies_at_any_moment_leads_to_nothing_wrong(also_removing):
    moment, outcomes = 0, set()
    while True:
        life = recorded_life()
        life.disk.moments = Moments()
        life.disk.fails_from, life.disk.fails_to_remove = moment, also_removing
        try:
            move(life)
        except StateFileError:
            life.arm.close()
        life.end()
        if not life.disk.failed:
            break
        trust, position = believed(life, life.disk.after_kill(PATH))
        outcomes.add(trust)
        assert not list(wrong([(moment, trust, position, life.motors)])), moment
        moment += 1
    assert outcomes == {Trust.RESTORED, Trust.SUSPECT}


@pytest.mark.parametrize("room", [0, 1, 100, 200])
def test_without_room_for_the_mark_nothing_moves_and_the_position_stays_known(room):
    life = recorded_life()
    arm = life.connect(allow_restored=True)
    life.disk.room = room
    before = life.motors
    with pytest.raises(StateFileError, match=r"No space left on device.*free some disk space"):
        arm.move_j(base_deg=4.0)
    assert arm.status.state is State.STANDBY
    assert life.motors == before
    life.disk.room = math.inf
    arm.move_j(base_deg=4.0)
    assert life.motors != before
    arm.close()
    life.end()
    assert believed(life, life.disk.after_kill(PATH)) == (Trust.RESTORED, life.motors)


def test_a_full_disk_in_mid_motion_is_reported_and_the_motion_goes_on():
    life = recorded_life()
    arm = life.connect(allow_restored=True)
    handle = arm.move_j(base_deg=10.0, wait=False)
    arm.sleep(0.3)
    life.disk.room = 0
    handle.wait()
    arm.sleep(3.0)
    assert "No space" in arm.status.notice
    assert "Errno" not in arm.status.notice
    life.disk.room = math.inf
    arm.sleep(3.0)
    life.end()
    assert believed(life, life.disk.after_kill(PATH)) == (Trust.RESTORED, life.motors)


def test_a_record_that_is_no_longer_true_is_removed_from_a_full_disk():
    life = recorded_life()
    arm = life.connect()
    life.disk.room = 0
    life.twin.device.jog((30, 0, 0, 0, 0, 0))
    arm.read_inputs()
    assert arm.status.trust is Trust.SUSPECT
    assert life.disk.after_kill(PATH) is None
    life.twin.device.jog((-30, 0, 0, 0, 0, 0))
    life.end()
    assert believed(life, None)[0] is Trust.UNKNOWN


def test_a_full_disk_keeps_no_motor_on_and_leaves_nothing_to_believe():
    life = recorded_life()
    arm = life.connect(allow_restored=True)
    life.disk.room = 0
    arm.disable()
    assert arm.status.current is Current.OFF
    assert life.disk.after_kill(PATH) is None


@pytest.mark.parametrize("to_s", [-1e6, 0.0, 4e9])
def test_a_clock_that_is_set_changes_nothing(monkeypatch, to_s):
    life = recorded_life()
    arm = life.connect(allow_restored=True)
    arm.move_j(base_deg=4.0)
    monkeypatch.setattr(time, "time", lambda: to_s)
    assert from_text(life.disk.after_kill(PATH)).in_motion
    arm.sleep(2.5)
    assert not from_text(life.disk.after_kill(PATH)).in_motion
    life.end()
    assert believed(life, life.disk.after_kill(PATH)) == (Trust.RESTORED, life.motors)


def test_the_mark_is_written_once_for_many_bursts_and_moves_and_cleared_once():
    life = recorded_life()
    arm = life.connect(allow_restored=True)
    kept = []
    replace = life.disk.replace
    life.disk.replace = lambda *names: (replace(*names), kept.append(life.disk.after_kill(PATH)))
    for angle_deg in (10.0, 0.0, 10.0):
        arm.move_j(base_deg=angle_deg)
    arm.jog_j(base_deg=-2.0)
    arm.sleep(10.0)
    assert [from_text(text).in_motion for text in kept] == [True, False]
