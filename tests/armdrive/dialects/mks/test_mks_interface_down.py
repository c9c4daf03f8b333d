"""The way to the drives ends in mid-motion: it is said, the arm stands, it is fixed on the spot.

In real time, by the links of real adapters: an interface of the kernel, and an adapter with slcan
firmware.
"""

from __future__ import annotations

import math
import re
import sys

import can
import pytest
from can_kernel_bus import Interface
from served import Served
from waiting import FOREVER_S, at_last, looks, until
from watched_sim import Watch

from armdrive import Arm
from armdrive.errors import DeviceFault, LinkLost, NoAnswer, PortUnavailable
from armdrive.status import State, Trust
from armdrive.transports import ports as can_refusals

needs_pty = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
GOAL = {"base_deg": 60, "shoulder_deg": 60, "elbow_deg": -60}
UNDER_WAY = 2000


def in_motion(arm, device):
    """Take the arm for referenced where it is, and have it on its way; return the motion."""
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


def comes_to_rest(device):
    """Wait until the arm has stood for a while on its own clock; return where."""
    look = lambda: (device.now_s, {"motors": device.world.motors, "moving": device.moving})  # noqa: E731
    Watch(look).last_moved_s()
    return device.world.motors


def fails_and_ends(arm, device, fail, error, words):
    """Check that a motion ends in words, within what was announced, and trusts nothing.

    Return where the arm came to rest.
    """
    world, motion = device.world, in_motion(arm, device)
    fail()
    tip, most_mm = world.tip, arm.status.silent_distance_mm
    with pytest.raises(error, match=words):
        motion.wait(FOREVER_S)
    assert arm.status.error_code == ("E407" if error is LinkLost else "E502")
    assert re.search(words, arm.status.error), arm.status.error
    stood = comes_to_rest(device)
    assert math.dist(tip, world.tip) <= most_mm
    assert world.joints.deg["base"] < GOAL["base_deg"] - 1.0
    assert arm.status.trust is Trust.SUSPECT
    assert arm.status.state is (State.DISCONNECTED if error is LinkLost else State.ERROR_STOP)
    return stood


def goes_on(arm, device, stood):
    """Do what a person does next; nothing moves before it is asked to."""
    world = device.world
    if arm.status.state is State.DISCONNECTED:
        arm.reconnect()
    if arm.status.state is State.ERROR_STOP:  # not where the program has connected anew
        arm.reset()
    arm.enable()
    assert comes_to_rest(device) == stood

    def move():
        arm.reference.declare(world.joints, opening_mm=world.opening_mm)
        arm.move_j(base_deg=arm.joints.deg["base"] + 2.0)

    def fix():
        arm.reset()
        comes_to_rest(device)

    at_last(move, fix, (DeviceFault, NoAnswer))
    assert world.motors != stood
    assert (comes_to_rest(device) - arm.status.acknowledged).largest <= 8
    assert arm.status.trust is Trust.REFERENCED


def check_ends_and_goes_on(port, device, fail, error, words, fix, refused=""):
    """Check that a motion ends, and that the same program goes on once the bus is there again."""
    with Arm.connect(port, dialect="mks") as arm:
        stood = fails_and_ends(arm, device, fail, error, words)
        if refused:
            with pytest.raises(PortUnavailable, match=refused):
                arm.reconnect()
            assert arm.status.state is State.DISCONNECTED
        fix()
        goes_on(arm, device, stood)


# -- an interface of the kernel -------------------------------------------------------------------


@pytest.fixture
def can0(monkeypatch):
    """An interface of the kernel with drives on it; `armdrive` finds it where it finds such."""
    interface = Interface()
    monkeypatch.setattr(can, "Bus", interface.open)
    there = lambda *_: {"can0": interface.up} if interface.there else {}  # noqa: E731
    monkeypatch.setattr(can_refusals, "can_interfaces", there)
    yield interface
    interface.end()


@pytest.mark.parametrize(
    ("falls", "words", "refused"),
    [
        (Interface.down, "interface is down", "sudo ip link set can0 up type can bitrate"),
        # the thread that speaks may be told of it before the one that hears
        (lambda interface: interface.down(heard=False), "interface is down", ""),
        (Interface.remove, "adapter has gone", "no CAN interface can0"),
    ],
    ids=["down", "down as an order is sent", "unplugged"],
)
def test_an_interface_that_falls_away_ends_a_motion_and_is_found_when_it_is_up(
    can0, falls, words, refused
):
    check_ends_and_goes_on(
        "can:socketcan:can0",
        can0.device,
        lambda: falls(can0),
        LinkLost,
        words,
        can0.bring_up,
        refused,
    )


# -- an adapter with slcan firmware ---------------------------------------------------------------


@pytest.fixture
def bus(tmp_path):
    """Drives behind a serial adapter in a thread of this process."""
    with Served("mks", pty=tmp_path / "can0") as served:
        yield served


def unplug(bus):
    bus.tell("fault unplug")


def restart(bus):
    """Have the adapter restart, its USB port left as it is: its channel is closed."""
    bus.server.adapters[0].restart()


def hang(bus):
    bus.server.adapters[0].faults.dead = True


def leave_the_bus(bus):
    bus.tell("fault bus-off")


def be_alone(bus):
    """Have no node acknowledge what the adapter sends."""
    bus.tell("fault alone")


def fix(bus):
    """Plug the adapter in again, or have it answer and its frames acknowledged again."""
    bus.tell("fault replug")
    bus.tell("fault off")
    bus.server.adapters[0].faults.dead = False


@needs_pty
@pytest.mark.parametrize(
    ("fail", "error", "words", "refused"),
    [
        (unplug, LinkLost, "gone|lost", "."),
        (restart, LinkLost, "refuses frames: .* restarted", ""),
        (hang, NoAnswer, "answer", ""),
        (leave_the_bus, LinkLost, "bus", ""),
        (be_alone, LinkLost, "no node on the bus receives", ""),
    ],
)
def test_a_serial_adapter_that_fails_ends_a_motion_and_goes_on_when_it_is_well(
    bus, fail, error, words, refused
):
    check_ends_and_goes_on(
        bus.port, bus.device, lambda: fail(bus), error, words, lambda: fix(bus), refused
    )


@needs_pty
def test_an_adapter_that_closes_its_channel_silently_is_reopened_by_the_next_connection(bus):
    """A CANable's first firmware refuses no frame: what it drops looks like drives that are off."""
    bus.server.adapters[0].faults.mute = True
    with Arm.connect(bus.port, dialect="mks") as arm:
        stood = fails_and_ends(arm, bus.device, lambda: restart(bus), NoAnswer, "answer")
        with pytest.raises(NoAnswer):
            arm.reset()
    with Arm.connect(bus.port, dialect="mks") as arm:
        goes_on(arm, bus.device, stood)
