"""What an arm file says of drives on a bus: numbers in their bounds, and what goes together."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest
from amounts import every_row

from armdrive.config.sections import Connection
from armdrive.connect.target import simulated_config
from armdrive.dialects.cia402.settings import Cia402Settings, period_ms
from armdrive.dialects.mks.settings import MksSettings
from armdrive.errors import ArmFileError, Refused
from armdrive.registry import DIALECTS
from armdrive.text.toml import Problems, TomlTable

SECTIONS = {"mks": MksSettings, "cia402": Cia402Settings}
KINDS = pytest.mark.parametrize("dialect", SECTIONS)


def made(dialect, **changes):
    """Return the controller of an arm whose file is changed."""
    return DIALECTS[dialect].controller(replace(simulated_config(dialect), **changes))


@every_row(
    "dialect, table, words",
    [
        ("mks", {"ids": [1, 1]}, "an id of its own"),
        ("mks", {"ids": []}, "an id of its own"),
        ("mks", {"ids": [0]}, r"mks.ids\[0\] must be from 1 to 2047"),
        ("mks", {"ids": [2048]}, r"mks.ids\[0\] must be from 1 to 2047"),
        ("mks", {"firmware": "new"}, 'mks.firmware must look like "1.0.9"'),
        ("mks", {"microsteps": 8}, "mks.microsteps must be one of 16, 32, 64"),
        ("mks", {"acceleration": 256}, "mks.acceleration must be from 0 to 255"),
        ("mks", {"segment_s": 0.5}, "mks.segment_s"),
        ("mks", {"watchdog_s": 0.15}, "mks.watchdog_s must be at least 2 times mks.poll_s"),
        ("mks", {"poll_s": 0.3}, "mks.watchdog_s must be at least 2 times mks.poll_s"),
        ("cia402", {"ids": [1, 2, 2]}, "a node number of its own"),
        ("cia402", {"ids": [0, 1]}, r"ids\[0\] must be from 1 to 127"),
        ("cia402", {"ids": []}, "a node number of its own"),
        ("cia402", {"master_id": 3}, "3 is a drive's"),
        ("cia402", {"strategy": "fast"}, "one of cyclic, profile"),
        ("cia402", {"period_ms": 2}, "period_ms must be from 4 to 50"),
        ("cia402", {"heartbeat_timeout_ms": 80}, "2 times cia402.heartbeat_period_ms"),
        ("cia402", {"smoothing_ms": 500}, "smoothing_ms must be from 0 to 200"),
        ("cia402", {"quick_stop_s": 0.0}, "quick_stop_s"),
        ("cia402", {"homing_methods": [17]}, "one for each of the 6 drives"),
        ("cia402", {"homing_methods": [99] * 6}, r"homing_methods\[0\]"),
        ("cia402", {"homing_speeds": [-1, 0]}, r"homing_speeds\[0\]"),
        ("cia402", {"hearbeat_timeout_ms": 100}, "heartbeat_timeout_ms"),
    ],
)
def test_wrong_settings_are_named(dialect, table, words):
    problems = Problems()
    TomlTable(table, dialect, problems).section(SECTIONS[dialect])
    (said,) = problems.found
    assert re.search(words, said)


@KINDS
def test_an_arm_with_too_few_drives_another_port_or_a_servo_is_refused(dialect):
    with pytest.raises(ArmFileError, match="names 3 drives"):
        made(dialect, device=SECTIONS[dialect](ids=(1, 2, 3)))
    with pytest.raises(Refused, match=r"not a CAN adapter.*can:slcan"):
        made(dialect, connection=Connection(dialect, "/dev/ttyUSB0", 500_000))
    gripper = replace(simulated_config(dialect).gripper, kind="servo")
    with pytest.raises(Refused, match=r"gripper\.kind.*have no such output"):
        made(dialect, gripper=gripper)


def test_the_announced_stop_covers_what_the_settings_make_of_it():
    settings = Cia402Settings(quick_stop_s=0.05, heartbeat_timeout_ms=100, heartbeat_period_ms=20)
    quick = made("cia402", device=settings)
    slow = made("cia402", device=Cia402Settings(quick_stop_s=0.5, heartbeat_timeout_ms=500))
    for burst_s in (0.15, 0.5):
        one, other = quick.stopping(burst_s), slow.stopping(burst_s)
        assert one.asked_s < other.asked_s
        assert one.silent_s < other.silent_s
        assert other.silent_s >= 0.5 + 0.5


def test_reports_that_come_more_rarely_than_the_heartbeat_timeout_allows_are_refused():
    made("cia402", device=Cia402Settings(period_ms=25, heartbeat_timeout_ms=100))
    with pytest.raises(ArmFileError, match=r"heartbeat_timeout_ms must be at least 101.*26 ms"):
        made("cia402", device=Cia402Settings(period_ms=26, heartbeat_timeout_ms=100))


def test_a_bus_that_is_slow_has_a_longer_period():
    assert period_ms(Cia402Settings(), 6, 500_000) == 10
    assert period_ms(Cia402Settings(), 6, 125_000) > 14
