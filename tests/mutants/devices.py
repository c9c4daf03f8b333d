"""What drivers and codecs send, and what they make of what they hear."""

from __future__ import annotations

from .mutant import Mutant

MUTANTS = (
    Mutant(
        name="a reset after a feed hold is not waited for",
        promise="a feed hold, a wait for its end and then a reset keep the position",
        path="armdrive/controllers/grbl_stops.py",
        old="                (self.state in HELD and not self.sub_state)\n",
        new="                self.state in HELD\n",
        tests=(
            (
                "tests/armdrive/test_grbl_controller.py::test_a_stopped_arm_stan"
                "ds_in_time_and_keeps_its_position"
            ),
        ),
    ),
)
