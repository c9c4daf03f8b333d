"""Every call ends within its announced time, on every wire and in every dialect, and says why."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest
from amounts import in_pairs
from endless_wires import KINDS, Pace, connected, wire_to
from faults import as_it_stands

from armdrive.arm import Arm
from armdrive.config.sections import HomingSettings
from armdrive.connect.parts import assemble
from armdrive.connect.target import simulated_config
from armdrive.dialects.grbl.settings import GrblSettings
from armdrive.errors import ArmError, DeviceFault, NoAnswer, Refused
from armdrive.registry import DIALECTS
from armdrive.runtime.engine import CALL_LIMIT_S, Received, call_limit_s, excerpt
from armdrive.status import State
from firmware_protocol.frames import Frame, Unpacker, pack

AFTER_S = 3.0
"""What has been waited for in a motion before its look is answered by nobody: a few exchanges."""
FOUND = re.compile(
    r"within (\d+\.\d) s on .*: (nothing was received"
    r"|\d+ bytes? (?:was|were) received, but not the answer: '.*'"
    r"|\d+ frames? (?:was|were) received, but not the answer: ids [0-9A-F, ]+)"
)


def ready(dialect: str) -> tuple[Arm, Pace]:
    """Return an arm in standby whose position is known, on a wire that behaves."""
    wire, pace = wire_to(dialect)
    arm = connected(dialect, wire, pace)
    arm.enable()
    world = wire.twin.world
    arm.declare_posture(world.joints, opening_mm=world.opening_mm)
    return arm, pace


def latched(arm: Arm) -> None:
    arm.estop()
    arm.sleep(1.0)


def switched_off(arm: Arm) -> None:
    if arm.abilities.current.name != "NONE":
        arm.disable()


CALLS = {
    "reset": (latched, lambda arm: arm.reset(), 0.0),
    "enable": (switched_off, lambda arm: arm.enable(), 0.0),
    "look": (lambda _: None, lambda arm: arm.read_inputs(), 0.0),
    "outputs": (lambda _: None, lambda arm: arm.set_outputs(1), 0.0),
    "move": (lambda _: None, lambda arm: arm.move_j(base_deg=5.0), AFTER_S),
    "home": (lambda _: None, lambda arm: arm.home(), AFTER_S),
    "close": (lambda _: None, lambda arm: arm.close(), 0.0),
}
"""What comes before a call, the call, and how much longer than its limit it may take."""


def told(error: ArmError, took_s: float) -> None:
    """Check that a silence tells what was received, and the time that it really took."""
    found = FOUND.search(str(error))
    assert found, str(error)
    assert float(found[1]) == pytest.approx(took_s, abs=0.06)
    assert not re.search(r"[\x00-\x1f\x7f-\x9f]", str(error))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("dialect", DIALECTS)
def test_connecting_ends_on_time_and_quotes_what_was_received(dialect, kind):
    wire, pace = wire_to(dialect)
    wire.spoil(kind)
    if kind == "answering at the last moment":
        assert call_limit_s(simulated_config(dialect).device) == CALL_LIMIT_S
        connected(dialect, wire, pace)
        assert pace.now_s() < CALL_LIMIT_S / 2.0
    else:
        with pytest.raises(NoAnswer, match="connect again") as silence:
            connected(dialect, wire, pace)
        told(silence.value, pace.now_s())
        assert "reset()" not in str(silence.value)
    assert pace.now_s() <= CALL_LIMIT_S + 0.05


@in_pairs("dialect, call, kind", list(DIALECTS), list(CALLS), list(KINDS))
def test_a_call_ends_on_time_and_the_arm_comes_back(dialect, kind, call):
    before, act, longer_s = CALLS[call]
    arm, pace = ready(dialect)
    before(arm)
    pace.wire.spoil(kind)
    began_s = pace.now_s()
    slow = kind == "answering at the last moment"
    try:
        act(arm)
    except NoAnswer as error:
        if not longer_s:
            told(error, pace.now_s() - began_s)
    except (DeviceFault, Refused):
        pass
    if not (slow and call == "home"):  # its operator jogs for long, and each of it ends
        assert pace.now_s() - began_s <= CALL_LIMIT_S + longer_s + 0.05
    pace.wire.spoil(None)
    if call != "close" and not comes_back(arm):  # the wire's lies were believed until a motion
        assert comes_back(arm)


def comes_back(arm: Arm) -> bool:
    """Tell whether an arm whose wire is good again can be reset, enabled and moved."""
    arm.sleep(3.0)
    if arm.status.state is State.ERROR_STOP:
        arm.reset()
    if arm.status.state is State.DISABLED:
        arm.enable()
    assert arm.status.state is State.STANDBY
    as_it_stands(arm)
    try:
        arm.move_j(base_deg=arm.joints.deg["base"] + 3.0)
    except DeviceFault:
        return False
    assert arm.status.acknowledged == arm.twin.world.motors
    return True


def test_a_background_poll_times_out_without_using_the_next_calls_time():
    arm, pace = ready("teachmover")
    pace.wire.spoil("dripping")
    arm.sleep(1.0)
    assert arm.engine.busy
    began_s = pace.now_s()
    with pytest.raises(ArmError):
        arm.read_inputs()
    assert pace.now_s() - began_s <= CALL_LIMIT_S + 0.05
    assert arm.status.state is State.ERROR_STOP


def test_time_in_which_the_motion_of_another_call_is_waited_for_does_not_count():
    arm, pace = ready("teachmover")
    handle = arm.move_j(base_deg=80.0, speed=0.1, wait=False)
    arm.sleep(0.5)
    began_s = pace.now_s()
    arm.read_inputs()
    assert pace.now_s() - began_s > CALL_LIMIT_S
    assert handle.done
    assert arm.joints.deg["base"] == pytest.approx(80.0, abs=0.1)


def test_a_suspension_does_not_count_towards_a_devices_timeout():
    arm, pace = ready("teachmover")
    pace.wire.spoil("dripping")
    task = arm.runner.submit(arm_look(arm), within_s=CALL_LIMIT_S)
    pace.wait(lambda: task.done, 10.0)
    arm.engine.suspended(60.0)
    pace.wait(lambda: task.done, 0.0)
    assert task.until_s == pytest.approx(60.0 + CALL_LIMIT_S, abs=1.0)


def arm_look(arm: Arm):
    yield from arm.wire.look()


def test_an_arm_file_that_has_its_device_waited_for_longer_gets_more_time():
    settings = GrblSettings()
    assert call_limit_s(settings) == CALL_LIMIT_S
    assert call_limit_s(replace(settings, boot_s=3.0 * settings.boot_s)) == 3.0 * CALL_LIMIT_S
    assert call_limit_s(replace(settings, boot_s=0.5)) == CALL_LIMIT_S
    assert call_limit_s(None) == CALL_LIMIT_S


def test_what_was_received_in_words():
    heard = Received()
    assert str(heard) == "nothing was received"
    assert heard.look_at("the cable") == "the cable"
    heard.add(b"\x1b]0;owned\x07")
    assert str(heard) == "10 bytes were received, but not the answer: '\\x1b]0;owned\\x07'"
    assert "baud rate" in heard.look_at("the cable")
    heard.add(b"x" * 100_000)
    assert str(heard).startswith("100010 bytes were received")
    assert len(str(heard)) < 200
    heard.clear()
    assert str(heard) == "nothing was received"


def test_received_frames_are_reported_by_their_ids():
    heard = Received(Unpacker)
    heard.add(pack(Frame(0x701, b"\x05")))
    assert str(heard) == "1 frame was received, but not the answer: ids 701"
    for can_id in range(0x10, 0x30):
        heard.add(pack(Frame(can_id)))
    assert str(heard).endswith("ids 701, 10, 11, 12, 13, 14, ...")
    assert heard.look_at("the bus") == "the bus"


def test_an_excerpt_holds_nothing_that_a_terminal_obeys():
    every = bytes(range(256))
    assert excerpt(every, 256).isprintable()
    assert excerpt(every, 256).isascii()


@pytest.mark.parametrize("kind", ["silent", "flooding with noise", "dripping"])
def test_homing_by_switches_ends_on_time_and_quotes_what_was_received(kind):
    wire, pace = wire_to("grbl")
    config = simulated_config("grbl")
    joints = config.model.arm.ik(config.model.reference.pose)
    config = replace(config, homing=HomingSettings(joints=joints))
    arm = Arm(assemble(config, wire, pace, simulated=True, operator=wire.twin.operator))
    arm.enable()
    wire.spoil(kind)
    began_s = pace.now_s()
    with pytest.raises(DeviceFault, match=r"not ended after 1\d\d s, .*received"):
        arm.home()
    assert pace.now_s() - began_s <= config.device.homing_s + CALL_LIMIT_S
