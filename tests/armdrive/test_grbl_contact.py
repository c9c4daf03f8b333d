"""First contact with a GRBL board: its axes are learnt, and nothing moves, whatever was left."""

import pytest
from grbl_arm import config, found, ready

from armdrive.connecting import connect_simulated
from armdrive.errors import DeviceFault
from armdrive.sim.twin import make_twin
from armdrive.status import State

FIRMWARES = ["grbl", "mega5x", "grblhal", "fluidnc"]


# The axes of the board.


@pytest.mark.parametrize("firmware", FIRMWARES)
@pytest.mark.parametrize("letters", ["XYZABC", "XZYBA", "XYZAC"])
def test_a_board_may_have_more_axes_than_the_arm_has_motors(firmware, letters):
    made = config(gripper="servo", device={"axes": letters})
    arm = ready(made, firmware=firmware, axes="XYZABC")
    assert arm.core.differences == ()
    arm.move_motors(5, -4, 3, -2, 1)
    assert arm.twin.world.motors == arm.status.acknowledged == arm.status.read_back


@pytest.mark.parametrize("banner", [True, False])
def test_the_axes_are_learnt_whether_the_board_begins_anew_or_not(banner):
    arm = found(config(gripper="servo"), firmware="fluidnc", axes="XYZABC")
    if banner:
        arm.twin.device.reset()
        arm.sleep(3.0)
        arm.reset()
    assert arm.status.state is State.STANDBY
    assert len(arm.status.read_back) == 5


@pytest.mark.parametrize("firmware", FIRMWARES)
def test_a_board_with_too_few_axes_is_told_of_in_words(firmware):
    twin = make_twin(config(gripper="servo", device={"axes": "XYZAB"}), firmware=firmware)
    with pytest.raises(DeviceFault, match=r"the board has the axes XYZAB.* on C"):
        connect_simulated(config(), twin=twin)
