"""What an arm file says of CiA 402 drives: numbers in their bounds, and what goes together."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest

from armdrive.config.sections import Connection
from armdrive.connect.target import simulated_config
from armdrive.dialects.cia402.controller import Cia402Controller
from armdrive.dialects.cia402.settings import Cia402Settings
from armdrive.errors import ArmFileError, Refused
from armdrive.registry import DIALECTS
from armdrive.text.toml import Problems, TomlTable


def made(**changes) -> Cia402Controller:
    return Cia402Controller(
        DIALECTS["cia402"].abilities, replace(simulated_config("cia402"), **changes)
    )


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({"ids": [1, 2, 2]}, "a node number of its own"),
        ({"ids": [0, 1]}, r"ids\[0\] must be from 1 to 127"),
        ({"ids": []}, "a node number of its own"),
        ({"master_id": 3}, "3 is a drive's"),
        ({"strategy": "fast"}, "is one of cyclic, profile"),
        ({"period_ms": 2}, "period_ms must be from 4 to 50"),
        ({"heartbeat_ms": 80}, "2 times cia402.beat_ms"),
        ({"smoothing_ms": 500}, "smoothing_ms must be from 0 to 200"),
        ({"quick_stop_s": 0.0}, "quick_stop_s"),
        ({"homing_methods": [17]}, "one for each of the 6 drives"),
        ({"homing_methods": [99] * 6}, r"homing_methods\[0\]"),
        ({"homing_speeds": [-1, 0]}, r"homing_speeds\[0\]"),
        ({"hearbeat_ms": 100}, "heartbeat_ms"),
    ],
)
def test_what_is_wrong_is_named(table, words):
    problems = Problems()
    TomlTable(table, "cia402", problems).section(Cia402Settings)
    (said,) = problems.found
    assert re.search(words, said)


def test_an_arm_with_too_few_drives_another_port_or_a_servo_is_refused():
    with pytest.raises(ArmFileError, match="names 3 drives"):
        made(device=Cia402Settings(ids=(1, 2, 3)))
    with pytest.raises(Refused, match="no CAN adapter"):
        made(connection=Connection("cia402", "/dev/ttyUSB0", 500_000))
    gripper = replace(simulated_config("cia402").gripper, kind="servo")
    with pytest.raises(Refused, match="which no drive commands"):
        made(gripper=gripper)


def test_the_announced_stop_covers_what_the_settings_make_of_it():
    quick = made(device=Cia402Settings(quick_stop_s=0.05, heartbeat_ms=100, beat_ms=20))
    slow = made(device=Cia402Settings(quick_stop_s=0.5, heartbeat_ms=500))
    for burst_s in (0.15, 0.5):
        one, other = quick.stopping(burst_s), slow.stopping(burst_s)
        assert one.asked_s < other.asked_s
        assert one.silent_s < other.silent_s
        assert other.silent_s >= 0.5 + 0.5
