"""Several arms in one simulated time: whichever is waited for, it passes for all of them."""

from __future__ import annotations

import math

import pytest

from armdrive import Arm, SimulatedClock
from armdrive.errors import ArmError, LinkLost, Stopped
from armdrive.status import State


def two(clock, first="sim:teachmover", second="sim:teachmover"):
    """Return two referenced arms on one clock."""
    arms = Arm.connect(first, pace=clock), Arm.connect(second, pace=clock)
    for arm in arms:
        arm.enable()
        arm.home()
    return arms


def test_two_motions_that_were_begun_run_side_by_side():
    clock = SimulatedClock()
    arms = two(clock)
    began_s = clock.now_s
    handles = [arm.move_j(base_deg=20, wait=False) for arm in arms]
    arms[0].sleep(0.5)
    assert {arm.status.state for arm in arms} == {State.MOVING}
    assert len({arm.status.time_s for arm in arms}) == 1
    for arm, handle in zip(arms, handles, strict=True):
        handle.wait()
        assert arm.joints.deg["base"] == pytest.approx(20, abs=0.2)
    both_s = clock.now_s - began_s

    alone = []
    for arm in arms:
        began_s = clock.now_s
        arm.move_j(base_deg=0)
        alone.append(clock.now_s - began_s)
    assert both_s == pytest.approx(max(alone), rel=0.1)
    assert both_s < 0.6 * sum(alone)


def test_an_arm_that_connects_later_begins_now_and_the_other_goes_on():
    clock = SimulatedClock()
    a = Arm.connect("sim:teachmover", pace=clock)
    a.home()
    a.sleep(20.0)
    handle = a.move_j(base_deg=30, wait=False)
    b = Arm.connect("sim:grbl", pace=a.pace)
    assert b.status.time_s >= 20.0
    b.sleep(10.0)
    assert handle.done


@pytest.mark.parametrize(
    ("end", "error"),
    [
        (lambda arm: arm.close(), Stopped),
        (lambda arm: arm.stop(), Stopped),
        (lambda arm: arm.twin.link.unplug(), LinkLost),
    ],
    ids=["closed", "stopped", "lost"],
)
def test_what_ends_the_motion_of_one_arm_ends_that_of_no_other(end, error):
    clock = SimulatedClock()
    a, b = two(clock)
    first, second = (arm.move_j(base_deg=20, wait=False) for arm in (a, b))
    a.sleep(0.5)
    end(a)
    second.wait()
    with pytest.raises(error):
        first.wait()
    assert b.joints.deg["base"] == pytest.approx(20, abs=0.2)
    assert b.status.state is State.STANDBY


def test_a_closed_arm_is_off_its_clock():
    clock = SimulatedClock()
    a, _ = two(clock)
    a.close()
    assert a.status.state is State.DISCONNECTED
    assert len(clock.engines) == 1
    with pytest.raises(LinkLost):
        a.read_inputs()


def test_arms_without_a_clock_in_common_do_not_wait_for_one_another():
    a, b = Arm.connect("sim:teachmover"), Arm.connect("sim:teachmover")
    a.sleep(5.0)
    assert b.pace.now_s() < 1.0


def test_the_same_program_gives_the_same_result_each_time():
    def run():
        clock = SimulatedClock()
        a, b = two(clock, second="sim:grbl")
        seen = []
        handles = [arm.move_j(base_deg=15, wait=False) for arm in (a, b)]
        while not all(handle.done for handle in handles):
            a.sleep(0.1)
            seen.append((clock.now_s, a.twin.world.motors, b.twin.world.motors))
        return seen

    first = run()
    assert len(first) > 5
    assert run() == first


@pytest.mark.parametrize("creep_s", [0.0, 1e-15])
def test_of_several_arms_the_one_is_named_that_lets_no_time_pass(creep_s, monkeypatch):
    monkeypatch.setattr("armdrive.runtime.clock.STUCK_TURNS", 200)
    clock = SimulatedClock()
    a, b = two(clock, second="sim:grbl")
    link, inner_s = a.twin.link, a.twin.link.next_s
    link.next_s = lambda: min(inner_s(), clock.now_s + creep_s)
    with pytest.raises(ArmError, match="time is stuck") as raised:
        b.sleep(1.0)
    assert a.engine.link.description in str(raised.value)
    assert b.engine.link.description not in str(raised.value)


def test_a_wait_for_ever_is_an_error_once_nothing_is_left_to_do():
    clock = SimulatedClock()
    a, b = two(clock)
    for arm in (a, b):
        arm.twin.link.unplug()
        arm.sleep(0.1)
    with pytest.raises(ArmError, match="nothing left"):
        a.pace.wait(lambda: False, math.inf)
