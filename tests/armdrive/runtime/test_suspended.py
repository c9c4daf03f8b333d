"""A program that stood still: its motion does not go on, and what it was to say is not sent."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from faults import as_it_stands

from armdrive import Arm
from armdrive.arm.connected import Handle
from armdrive.connect.parts import assemble, connect_simulated
from armdrive.connect.target import simulated_config
from armdrive.errors import DeviceFault, Stopped
from armdrive.registry import DIALECTS, simulate
from armdrive.runtime.clock import SimulatedPace
from armdrive.status import State

ASLEEP_S = 400.0


class SleepyPace(SimulatedPace):
    """Simulated time that can jump, and tells the engine as the thread of real time does."""

    def sleep(self):
        with self.lock:
            self.clock.now_s += ASLEEP_S
            self._engine.suspended(ASLEEP_S)


def connected(dialect):
    config = simulated_config(dialect)
    twin = simulate(config)
    arm = Arm(assemble(config, twin.link, SleepyPace(), simulated=True, operator=twin.operator))
    if arm.status.state is State.DISABLED:
        arm.enable()
    refer(arm, twin)
    return arm, twin


def refer(arm, twin):
    joints, opening_mm = twin.world.body.transmission.to_joints(twin.world.motors)
    arm.declare_posture(joints, opening_mm=opening_mm)


def jogged_deg(arm, twin, direction):
    first = arm.model.arm.joint_names[0]
    before = twin.world.joints.deg[first]
    arm.jog_j(**{first: direction}, speed=1.0, duration_s=0.5)
    return abs(twin.world.joints.deg[first] - before)


@pytest.mark.parametrize("dialect", DIALECTS)
def test_a_motion_does_not_go_on_when_its_program_wakes_and_the_arm_is_no_slower(dialect):
    arm, twin = connected(dialect)
    jogged_deg(arm, twin, 1.0)
    as_before_deg = jogged_deg(arm, twin, -1.0)
    first = arm.model.arm.joint_names[0]
    handle = arm.move_j(wait=False, **{f"{first}_deg": arm.joints.deg[first] + 40.0})
    arm.sleep(0.3)
    assert twin.device.moving
    arm.pace.sleep()
    arm.sleep(1.0)
    woken = twin.world.motors
    with pytest.raises((Stopped, DeviceFault)):  # or the deadline of an answer has passed
        handle.wait()
    arm.sleep(2.0)
    assert twin.world.motors == woken
    if arm.status.state is State.ERROR_STOP:
        arm.reset()
        refer(arm, twin)
    # what was measured over the sleep is not taken for the arm's speed
    assert jogged_deg(arm, twin, -1.0) == pytest.approx(as_before_deg, rel=0.2)


def test_a_lost_answer_makes_a_robko_no_slower():
    config = simulated_config("robko01")
    twin = simulate(config)
    with Arm(connect_simulated(config, twin=twin)) as arm:
        refer(arm, twin)
        arm.move_j(base_deg=30.0)
        arm.move_j(base_deg=0.0)
        as_before_s = arm.move_j(base_deg=30.0).duration_s
        twin.faults.add("drop", 0.005, side="device", seed=1, for_s=5.0)
        arm.move_j(base_deg=0.0)
        assert arm.move_j(base_deg=30.0).duration_s == pytest.approx(as_before_s, rel=0.05)


# -- orders that were prepared before a suspension ------------------------------------------------


@pytest.fixture
def arm() -> Iterator[Arm]:
    with Arm.connect("sim:cia402") as arm:
        yield as_it_stands(arm)


def moving(arm: Arm) -> Handle:
    handle = arm.move_j(base_deg=40.0, wait=False)
    arm.sleep(0.3)
    return handle


@pytest.fixture
def said(arm, monkeypatch) -> list[bytes]:
    said: list[bytes] = []
    write = arm.engine.link.write
    monkeypatch.setattr(
        arm.engine.link, "write", lambda data, now_s: (said.append(data), write(data, now_s))
    )
    return said


def test_bytes_prepared_before_the_drives_stopped_are_not_sent(arm, said):
    moving(arm)
    arm.engine.round_s = lambda: arm.engine.controller.abilities.order_s + 0.01
    said.clear()
    arm.sleep(0.05)
    assert said == []


def test_a_stop_is_sent_however_late_it_is(arm, said):
    handle = moving(arm)
    arm.engine.round_s = lambda: 0.9
    said.clear()
    arm.request_stop()
    with pytest.raises(Stopped):
        handle.wait()
    assert said


def test_bytes_of_a_round_of_usual_length_are_sent(arm, said):
    handle = moving(arm)
    arm.engine.round_s = lambda: arm.engine.controller.abilities.order_s - 0.01
    said.clear()
    arm.sleep(0.6)
    assert not handle.done
    assert len(said) > 50


def test_orders_of_other_arms_may_be_late():
    with Arm.connect("sim:teachmover") as arm:
        arm.engine.round_s = lambda: 0.9
        arm.home()
        arm.move_j(base_deg=10.0)
        assert arm.joints.deg["base"] == pytest.approx(10.0, abs=0.5)
