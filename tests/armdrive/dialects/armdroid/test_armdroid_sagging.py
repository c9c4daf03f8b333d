"""An Armdroid that lets its motors go as it is switched on: a number was lost before the letter."""

import pytest
from armdroid_bench import CONFIG

from armdrive import Arm
from armdrive.connect.parts import connect_simulated
from armdrive.errors import DeviceFault
from armdrive.registry.simulate import simulate
from armdrive.status import State, Trust
from armdrive.storage.record import FileRecorder

TURNED = (40, 30, -20, 5, 9, 12)


@pytest.fixture
def left(tmp_path):
    """A twin on which a program has ended well, and the record that it left."""
    twin = simulate(CONFIG)
    recorder = FileRecorder(tmp_path / "record.json")
    twin.device.jog(TURNED)
    with Arm(connect_simulated(CONFIG, twin=twin, recorder=recorder)) as arm:
        arm.declare_posture(twin.world.joints, opening_mm=twin.world.opening_mm)
    twin.link.reopen()
    return twin, recorder


def test_motors_that_are_told_to_be_off_while_connecting_leave_no_record_to_be_believed(left):
    twin, recorder = left
    before = twin.world.motors
    twin.link.line.send(b"t", twin.device.now_s)  # the 1 before it was lost with a program
    arm = Arm(connect_simulated(CONFIG, twin=twin, recorder=recorder, allow_restored=True))
    assert twin.world.motors != before
    assert arm.status.trust is Trust.SUSPECT
    assert "motors are off" in arm.status.trust_reason
    assert arm.status.state is State.DISABLED
    assert arm.status.error == ""
    arm.close()
    twin.link.reopen()
    again = Arm(connect_simulated(CONFIG, twin=twin, recorder=recorder))
    assert again.status.trust is Trust.SUSPECT


def test_an_arm_that_sagged_as_it_was_switched_on_is_not_believed(left):
    twin, recorder = left
    arm = Arm(connect_simulated(CONFIG, twin=twin, recorder=recorder, allow_restored=True))
    assert arm.status.trust is Trust.RESTORED
    before = twin.world.motors
    twin.faults.add("drop", "#1", side="host")
    with pytest.raises(DeviceFault, match="motors are off"):
        arm.enable()
    assert twin.world.motors != before
    assert arm.status.trust is Trust.SUSPECT
    arm.reset()
    arm.enable()
    assert arm.status.state is State.STANDBY
