"""Drives home towards the side of their switches; in the wrong direction, homing fails."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from faults import arm_config, driven

from armdrive import Arm
from armdrive.config.sections import HomingSettings
from armdrive.errors import DeviceFault
from armdrive.status import State, Trust
from kinematics import Joints

FOUND = Joints.of(0.0, 40.0, -80.0, -40.0, 0.0)
SIDES = pytest.mark.parametrize("side", [1, -1], ids=["above", "below"])
DIALECTS = pytest.mark.parametrize("dialect", ["mks", "cia402"])


def arm_with_switch(dialect: str, side: int, *, wrong: bool = False) -> Arm:
    """Return an arm whose base has its switch on one side, and may be set to search on the other.

    Only the base homes. Its switch is 15 degrees away.
    """
    method = 18 if (side > 0) is not wrong else 17
    device = {"homing_methods": (method,) * 6, "homing_speeds": (40_000, 4000), "period_ms": 40}
    config = arm_config(dialect, device=device if dialect == "cia402" else {})
    homing = HomingSettings(FOUND.replace(base=math.radians(15.0) * side), 20.0, ((1,),))
    quirks = {"homes_reversed": wrong} if dialect == "mks" else {}
    return driven(replace(config, homing=homing), at=FOUND, **quirks)


@DIALECTS
@SIDES
def test_homing_ends_where_the_arm_file_says_on_either_side(dialect, side):
    arm = arm_with_switch(dialect, side)
    for _ in range(2):  # the second time, it begins at its switch
        arm.home()
        assert arm.twin.world.joints.deg["base"] == pytest.approx(15.0 * side, abs=0.01)
        assert arm.joints.deg["base"] == pytest.approx(15.0 * side, abs=0.01)
    assert arm.status.trust is Trust.REFERENCED


@pytest.mark.parametrize(("dialect", "side"), [("mks", 1), ("cia402", -1), ("cia402", 1)])
def test_a_search_in_the_wrong_direction_ends_in_an_error_and_references_nothing(dialect, side):
    arm = arm_with_switch(dialect, side, wrong=True)
    with pytest.raises(DeviceFault, match="base") as failed:
        arm.home()
    method = "17, down to the negative" if side > 0 else "18, up to the positive"
    words = f"homing method (6098) of drive 1 (base): {method} limit switch"
    assert (words in str(failed.value)) is (dialect == "cia402")  # the others have no methods
    assert arm.twin.world.joints.deg["base"] * side < 0.0
    assert arm.status.state is State.ERROR_STOP
    assert arm.status.trust is Trust.SUSPECT
    stood = arm.twin.world.motors
    arm.sleep(2.0)
    assert arm.twin.world.motors == stood
