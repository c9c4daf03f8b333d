"""The rates of joints under a moving tip."""

import math

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from kinematics.five_axis.closed_form import forward
from kinematics.five_axis.rates import joint_rates, task_jacobian
from kinematics.frames.matrices import times
from kinematics.presets import preset
from kinematics.spaces import Joints

ARM = preset("teachmover").arm
LENGTHS = ARM.lengths
BOUNDS = tuple((one.low_rad, one.high_rad) for one in ARM.limits)
POSTURES = st.tuples(*[st.floats(low, high) for low, high in BOUNDS])
TIPS = st.tuples(*[st.floats(-100.0, 100.0)] * 3, *[st.floats(-1.0, 1.0)] * 2)


@given(POSTURES, TIPS)
def test_joint_rates_are_the_inverse_of_the_jacobian_in_front_and_behind(angles, tip):
    assume(abs(math.sin(angles[2])) > 0.02)
    r = math.hypot(*forward(angles, LENGTHS)[:2])
    assume(r > 5.0)
    rates = joint_rates(angles, tip, LENGTHS)
    made = times(task_jacobian(ARM, Joints(angles)), rates)
    assert made == pytest.approx(tip, abs=1e-6)


@pytest.mark.parametrize("angles", [(0.0, 1.0, 0.0, 0.0, 0.0), (0.0, 0.5, math.pi, 0.0, 0.0)])
def test_a_straight_or_folded_elbow_gives_no_rates(angles):
    assert joint_rates(angles, (1.0, 0.0, 0.0, 0.0, 0.0), LENGTHS) is None


def test_a_tip_on_the_base_axis_moves_only_in_the_arms_plane():
    angles = (0.0, math.pi / 2 + 0.5, -1.0, 0.0, 0.0)
    wrist_r = LENGTHS[1] * math.cos(angles[1]) + LENGTHS[2] * math.cos(angles[1] + angles[2])
    third = math.acos(-wrist_r / LENGTHS[3])
    angles = (0.0, angles[1], angles[2], third - angles[1] - angles[2], 0.0)
    assert joint_rates(angles, (10.0, 0.0, 0.0, 0.0, 0.0), LENGTHS) is not None
    assert joint_rates(angles, (0.0, 10.0, 0.0, 0.0, 0.0), LENGTHS) is None
