"""The motor current as an arm's drives tell it: at contact, as asked for, in doubt."""

from __future__ import annotations

from cia402_rig import Rig

from armdrive import Arm
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import simulated_config
from armdrive.registry.simulate import simulate
from armdrive.status import Current, State
from armdrive.tasks import ReadPosition


def connected() -> Arm:
    config = simulated_config("cia402")
    return Arm(connect_simulated(config, twin=simulate(config)))


def test_drives_that_are_found_switched_off_are_told_as_off():
    arm = connected()
    assert arm.status.state is State.DISABLED
    assert arm.status.current is Current.OFF


def test_drives_that_hold_are_told_as_held_whoever_switched_them_on():
    rig = Rig()
    assert rig.do(ReadPosition()).held is False
    assert rig.ready().do(ReadPosition()).held is True


def test_drives_that_hold_but_have_to_be_enabled_first_are_not_told_as_held():
    rig = Rig().ready()
    rig.controller.group.on = False  # as behind a wire that was lost
    assert rig.do(ReadPosition()).held is None


def test_the_current_follows_what_is_asked_for():
    arm = connected()
    arm.enable()
    assert arm.status.current is Current.HELD
    arm.disable()
    assert arm.status.current is Current.OFF


def test_of_drives_that_differ_it_is_not_said_that_they_hold():
    arm = connected()
    arm.enable()
    arm.twin.faults.add("drive-fault", "2", "4310")
    arm.sleep(1.0)
    assert arm.status.state is State.ERROR_STOP
    assert arm.status.current is not Current.HELD
