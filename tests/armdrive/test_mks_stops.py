"""A stop that one drive did not hear: it is told again at once, since others brake already."""

from __future__ import annotations

import pytest
from mks_bench import MksBench
from test_mks_controller_motion import along, straight

from armdrive.controllers.requests import Halted
from firmware_protocol.mks import EmergencyStop, Stop, decode_request

WAY = (0, 0, 0, 3000, -3000, 0)
"""Counts in 0.1 s, of the two motors of a wrist."""
SOON_S = 0.005


def stops_of(bench, number):
    """Return when one drive was told to stop."""
    return [
        at_s
        for at_s, frame in bench.sent
        if frame.can_id == number and isinstance(decode_request(frame), Stop | EmergencyStop)
    ]


def stopping(*, hard, loses):
    """Have a wrist in motion be told to stop, and some frames be lost."""
    bench = MksBench(starts=(50_000,) * 6).ready()
    bench.begin(along(straight(30, WAY)))
    bench.run(0.8)
    bench.loses = loses
    bench.controller.stop(hard=hard)
    assert isinstance(bench.finish(), Halted)
    return bench


@pytest.mark.parametrize("hard", [False, True])
@pytest.mark.parametrize("number", [4, 5])
def test_the_other_motor_of_a_joint_is_not_left_running(number, hard):
    lost = []

    def loses(frame, host):
        asked = decode_request(frame) if host and frame.can_id == number else None
        strikes = isinstance(asked, Stop | EmergencyStop) and not lost
        lost.extend([frame] if strikes else [])
        return strikes

    bench = stopping(hard=hard, loses=loses)
    first_s, second_s = stops_of(bench, number)
    assert second_s <= first_s + SOON_S
    apart = bench.positions[3] - 50_000 + bench.positions[4] - 50_000
    assert abs(apart) <= 30_000 * SOON_S


@pytest.mark.parametrize("hard", [False, True])
def test_drives_that_brake_are_told_once(hard):
    bench = stopping(hard=hard, loses=lambda *_: False)
    assert [len(stops_of(bench, number)) for number in (4, 5)] == [1, 1]
