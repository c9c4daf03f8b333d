"""A serial CAN adapter that fails in mid-motion: the motion ends in words, and the program goes on.

In real time, because a thread of the link notices the loss. `tests/armdrive/transports` has every
loss that a link can notice, and the conformance suite what an arm does after one.
"""

from __future__ import annotations

import math
import re
import sys

import pytest
from served import Served
from waiting import FOREVER_S, at_last, looks, until
from watched_sim import Watch

from armdrive import Arm
from armdrive.errors import DeviceFault, LinkLost, NoAnswer, PortUnavailable
from armdrive.status import State, Trust

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
GOAL = {"base_deg": 60, "shoulder_deg": 60, "elbow_deg": -60}
UNDER_WAY = 2000


@pytest.fixture
def bus(tmp_path):
    """Drives behind a serial adapter in a thread of this process."""
    with Served("mks", pty=tmp_path / "can0") as served:
        yield served


def comes_to_rest(device):
    """Wait until the arm has stood for a while on its own clock; return where."""
    look = lambda: (device.now_s, {"motors": device.world.motors, "moving": device.moving})  # noqa: E731
    Watch(look).last_moved_s()
    return device.world.motors


def in_motion(arm, device):
    """Reference the arm where it is, and begin a motion; return its handle."""
    world = device.world
    for _ in looks("the arm was never on its way"):
        arm.enable()
        arm.reference.declare(world.joints, opening_mm=world.opening_mm)
        stood = world.motors
        motion = arm.move_j(wait=False, speed=0.5, **GOAL)
        until(lambda: motion.done or (world.motors - stood).largest > UNDER_WAY)  # noqa: B023
        if not motion.done:
            break
        assert arm.status.state is State.ERROR_STOP, "it is there already"
        arm.reset()  # a busy computer kept the drives, or this program, from their work
        comes_to_rest(device)
    return motion


def check_motion_ends(arm, device, fail, error, words):
    """Check that a motion ends within the announced distance, and that its position is suspect.

    Return where the arm came to rest.
    """
    world, motion = device.world, in_motion(arm, device)
    fail()
    tip, most_mm = world.tip, arm.status.silent_distance_mm
    with pytest.raises(error, match=words):
        motion.wait(FOREVER_S)
    assert re.search(words, arm.status.error), arm.status.error
    stood = comes_to_rest(device)
    assert math.dist(tip, world.tip) <= most_mm
    assert world.joints.deg["base"] < GOAL["base_deg"] - 1.0
    assert arm.status.trust is Trust.SUSPECT
    return stood


def check_goes_on(arm, device, stood):
    """Do what a person does next; check that nothing moves before it is asked to."""
    world = device.world
    if arm.status.state is State.DISCONNECTED:
        arm.reconnect()
    if arm.status.state is State.ERROR_STOP:  # not if the program has connected again
        arm.reset()
    arm.enable()
    assert comes_to_rest(device) == stood

    def move():
        arm.reference.declare(world.joints, opening_mm=world.opening_mm)
        arm.move_j(base_deg=arm.joints.deg["base"] + 2.0)

    def mend():
        arm.reset()
        comes_to_rest(device)

    at_last(move, mend, (DeviceFault, NoAnswer))
    assert world.motors != stood
    assert (comes_to_rest(device) - arm.status.acknowledged).largest <= 8
    assert arm.status.trust is Trust.REFERENCED


def test_an_adapter_that_is_unplugged_in_motion_is_found_again_by_the_same_program(bus):
    with Arm.connect(bus.port, dialect="mks") as arm:
        unplug = lambda: bus.tell("fault unplug")  # noqa: E731
        stood = check_motion_ends(arm, bus.device, unplug, LinkLost, "gone|lost")
        assert arm.status.state is State.DISCONNECTED
        assert arm.status.error_code == "E407"
        with pytest.raises(PortUnavailable):
            arm.reconnect()
        assert arm.status.state is State.DISCONNECTED
        bus.tell("fault replug")
        check_goes_on(arm, bus.device, stood)


def test_an_adapter_that_restarts_has_closed_its_channel_and_is_reopened(bus):
    """One that refuses no frame looks like drives that are off, as in the conformance suite."""
    adapter = bus.server.adapters[0]
    with Arm.connect(bus.port, dialect="mks") as arm:
        words = "refuses frames: .* restarted"
        stood = check_motion_ends(arm, bus.device, adapter.restart, LinkLost, words)
        arm.reconnect()
        check_goes_on(arm, bus.device, stood)
