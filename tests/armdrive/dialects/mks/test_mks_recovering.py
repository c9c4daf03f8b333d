"""What was wrong with drives is seen when they stop, and is over when somebody has mended it."""

from __future__ import annotations

import pytest
from mks_bench import MksBench, along, straight

from armdrive import Arm
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import simulated_config
from armdrive.errors import ArmError, DeviceFault
from armdrive.registry.simulate import simulate
from armdrive.status import State
from armdrive.tasks import AlertKind, Halted


def test_a_drive_that_is_reset_while_it_stops_is_not_taken_for_being_where_it_counts():
    bench = MksBench(starts=(-13, 0, 0, 0, 0, 0)).ready()
    bench.begin(along(straight(30)))
    bench.run(0.6)
    bench.controller.stop(hard=False)
    bench._speak()
    bench.node(1).reset(bench.now_s)
    bench.finish()
    (alert,) = bench.alerts()
    assert alert.kind is AlertKind.RESTARTED
    assert "drive 1 (base) was reset or lost its power" in alert.text


@pytest.mark.parametrize("hard", [False, True])
@pytest.mark.parametrize("after_s", [0.05, 0.3, 0.9, 1.9])
def test_drives_that_stop_as_they_should_alarm_nobody(hard, after_s):
    bench = MksBench(starts=(-13, 0, 0, 0, 0, 0)).ready()
    bench.begin(along(straight(20)))
    bench.run(after_s)
    bench.controller.stop(hard=hard)
    assert isinstance(bench.finish(), Halted)
    assert not bench.alerts()


def other_mode():
    """An arm of which one drive was in another mode while it was connected, and the fault."""
    config = simulated_config("mks")
    twin = simulate(config)
    twin.faults.add("drive-mode", "3", "2")
    arm = Arm(connect_simulated(config, twin=twin))
    with pytest.raises(DeviceFault, match="in mode 2"):
        arm.enable()
    return arm


def test_a_mode_that_was_set_right_is_found_by_the_reset():
    arm = other_mode()
    arm.twin.faults.end()
    arm.reset()
    arm.enable()
    assert arm.status.state is State.STANDBY
    before = arm.twin.world.motors
    arm.jog_j(base_deg=1.0)
    assert arm.twin.world.motors[0] > before[0] + 2000


def test_a_mode_that_is_wrong_still_keeps_the_arm_from_moving():
    arm = other_mode()
    arm.reset()
    with pytest.raises(DeviceFault, match="in mode 2"):
        arm.enable()
    with pytest.raises(ArmError):
        arm.jog_j(base_deg=1.0)
