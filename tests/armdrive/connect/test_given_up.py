"""How soon an arm that falls silent is given up, by the times of the page on reconnecting."""

from __future__ import annotations

import pytest
from pages import page

from armdrive import Arm
from armdrive.registry import DIALECTS
from armdrive.status import State

GIVEN_UP_AFTER_S = {
    "teachmover": 2.3,
    "armdroid": 2.4,
    "robko01": 3.4,
    "grbl": 1.7,
    "mks": 1.7,
    "cia402": 1.7,
}
"""From the first look that a standing arm does not answer."""


@pytest.mark.parametrize("after_s", [2.0, 2.3, 2.6])
@pytest.mark.parametrize("dialect", DIALECTS)
def test_a_standing_arm_that_falls_silent_is_given_up_as_soon_as_the_page_says(dialect, after_s):
    with Arm.connect(f"sim:{dialect}") as arm:
        arm.sleep(after_s)
        arm.twin.faults.add("mute")
        arm.sleep(GIVEN_UP_AFTER_S[dialect] + arm.config.motion.idle_poll_s)
        assert arm.status.state is State.ERROR_STOP
        assert arm.status.error_code == "E502"


def test_the_page_tells_those_times():
    times = " | ".join(f"{time_s} s" for time_s in GIVEN_UP_AFTER_S.values())
    assert f"| at rest | {times} |" in page("sharing")
