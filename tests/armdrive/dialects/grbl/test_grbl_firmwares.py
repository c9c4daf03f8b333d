"""Every firmware of the GRBL family, from the cable to a stop: one arm, one day at the bench."""

from dataclasses import replace

import pytest
from grbl_arm import config, found

from armdrive.config.sections import HomingSettings
from armdrive.errors import Stopped
from armdrive.status import State, Trust
from kinematics import Joints

HOMED = Joints.of(60.0, 20.0, -90.0, -20.0, 0.0)


@pytest.mark.parametrize("firmware", ["grbl", "mega5x", "grblhal", "fluidnc"])
def test_an_arm_connects_homes_moves_jogs_stops_and_goes_on(firmware):
    made = config(device={"homing": True})
    arm = found(replace(made, homing=HomingSettings(HOMED, 60.0, ())), firmware=firmware)
    assert arm.core.differences == ()
    arm.home()
    assert arm.status.trust is Trust.REFERENCED
    arm.move_j(base_deg=50, elbow_deg=-80)
    arm.jog_j(base_deg=-2)
    handle = arm.move_j(base_deg=0, wait=False)
    arm.sleep(0.5)
    status = arm.status
    arm.stop()
    with pytest.raises(Stopped):
        handle.wait()
    assert arm.status.time_s - status.time_s <= status.stop_time_s
    assert arm.status.state is State.STANDBY
    assert arm.status.trust is Trust.REFERENCED
    arm.move_j(base_deg=0)
    assert arm.twin.world.motors == arm.status.acknowledged == arm.status.read_back
    assert arm.joints.deg["base"] == pytest.approx(0.0, abs=0.1)
