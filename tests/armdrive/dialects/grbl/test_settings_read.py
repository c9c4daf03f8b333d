"""Settings that are read over a wire without check bytes: a difference is believed twice over."""

from dataclasses import replace

import pytest
from grbl_arm import Disturbed, config, rule, without

from armdrive import Arm
from armdrive.connect.parts import connect_simulated
from armdrive.errors import SettingsDiffer
from armdrive.registry.simulate import simulate

A_HUNDRED_BECOMES_TEN = without(3)
"""What is left of `$100=` sets what reports tell to another number."""


def connected(times):
    twin = simulate(config())
    link = Disturbed(twin.link)
    link.back.append(rule(rb"\$100=", A_HUNDRED_BECOMES_TEN, times=times))
    return Arm(connect_simulated(config(), twin=replace(twin, link=link)))


def test_a_setting_that_lost_a_byte_on_the_wire_keeps_no_arm_from_moving():
    arm = connected(times=1)
    assert arm.core.differences == ()
    arm.jog_j(base_deg=1.0)


def test_a_setting_that_differs_whenever_it_is_read_does():
    arm = connected(times=99)
    assert arm.core.differences
    with pytest.raises(SettingsDiffer):
        arm.jog_j(base_deg=1.0)
