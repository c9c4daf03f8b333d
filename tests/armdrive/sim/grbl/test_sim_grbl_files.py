"""Arm files that no GRBL board can be set up for: a sentence that names the key, never a crash."""

from __future__ import annotations

import contextlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from armdrive.errors import ArmError, ArmFileError
from armdrive.registry import simulate_device
from armdrive.registry.arm_files import parse_arm
from kinematics import JOINT_NAMES, KinematicsError

HUGE = 1.7e308


def board(**table):
    connection = {"dialect": "grbl"}
    return simulate_device(
        parse_arm({"model": "teachmover", "connection": connection, **table}, name="bench")
    )


@pytest.mark.parametrize(
    ("table", "named"),
    [
        ({"grbl": {"accelerations": [500.0]}}, "grbl.accelerations must have 6 entries"),
        ({"grbl": {"rates": [500.0] * 5}}, "grbl.rates must have 6 entries"),
        ({"grbl": {"travel": [500.0] * 7}}, "grbl.travel must have 6 entries"),
        (
            {"grbl": {"gripper_output": 6}, "gripper": {"kind": "output"}},
            "grbl.gripper_output is bit 6",
        ),
        ({"limits_deg": {"base": [-HUGE, 90.0]}}, "limits_deg.base"),
        (
            {"homing": {"joints_deg": dict.fromkeys(JOINT_NAMES, HUGE)}},
            "homing.joints_deg.base",
        ),
        (
            {"speeds_deg_s": {"base": 3600.0}, "steps_per_turn": {"base": 1e7}},
            "a greatest rate",
        ),
        ({"grbl": {"unit": "degrees"}, "steps_per_turn": {"base": 0.1}}, "grbl.unit: motor 1"),
    ],
)
def test_what_no_board_can_be_set_up_for_is_refused_by_the_name_of_its_key(table, named):
    with pytest.raises(ArmFileError, match=named):
        board(**table)


def lists(low, high):
    return st.lists(st.floats(low, high), max_size=7)


SECTIONS = st.fixed_dictionaries(
    {},
    optional={
        "grbl": st.fixed_dictionaries(
            {},
            optional={
                "rates": lists(0.1, 1e6),
                "accelerations": lists(0.1, 1e8),
                "travel": lists(0.1, 1e6),
                "axes": st.permutations("XYZABC").map("".join),
                "unit": st.sampled_from(["steps", "degrees"]),
                "ramp_s": st.floats(0.005, 10.0),
                "junction_steps": st.floats(0.001, 1000.0),
                "outputs": st.lists(st.sampled_from(["flood", "mist", "P0", "P99"]), max_size=3),
                "gripper_output": st.integers(0, 7),
            },
        ),
        "gripper": st.fixed_dictionaries({"kind": st.sampled_from(["servo", "output", "none"])}),
        "speeds_deg_s": st.dictionaries(st.sampled_from(JOINT_NAMES), st.floats(0.01, 3600.0)),
        "steps_per_turn": st.dictionaries(
            st.sampled_from(JOINT_NAMES[:3]), st.floats(0.1, 1e7), max_size=2
        ),
        "limits_deg": st.dictionaries(
            st.sampled_from(JOINT_NAMES), st.tuples(st.floats(-HUGE, 0), st.floats(1, HUGE))
        ).map(lambda limits: {joint: list(ends) for joint, ends in limits.items()}),
    },
)


@given(SECTIONS)
def test_any_arm_file_gives_a_board_or_a_sentence(table):
    with contextlib.suppress(ArmError, KinematicsError):
        board(**table).to_json()
