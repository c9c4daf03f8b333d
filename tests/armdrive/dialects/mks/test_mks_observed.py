"""What owners have seen real MKS drives do, beyond the manuals: the arm copes, or says what to do.

The rows of `QUIRKS` in `armdrive/sim/mks` name who has seen it.
"""

from __future__ import annotations

from dataclasses import replace

import pytest
from faults import arm_config, driven

from armdrive import Arm
from armdrive.config.sections import HomingSettings
from armdrive.moves import Jog
from armdrive.status import State, Trust
from kinematics import Joints

OVER = Joints.of(40.0, 40.0, -80.0, -40.0, 0.0)
STRATEGIES = {
    "steered": {},
    "started together": {"segment_s": 0.0},
    "one after another": {"segment_s": 0.0, "firmware": "1.0.4"},
}


def arm_of(strategy: str = "steered", **options) -> Arm:
    """An arm that stands in the air, referenced, with homing set up."""
    homing = HomingSettings(OVER, 20.0, ((1,), (2,), (0,), (3, 4), (5,)))
    config = arm_config("mks", device=STRATEGIES[strategy])
    return driven(replace(config, homing=homing), **options)


class TestDrivesThatReportBrakingForEver:
    @pytest.mark.parametrize("strategy", STRATEGIES)
    def test_motions_and_jogs_end(self, strategy):
        arm = arm_of(strategy, brakes_on=True)
        arm.move_j(base_deg=20.0)
        arm.jog_j(base_deg=1.0)
        assert arm.twin.world.motors == arm.status.acknowledged
        assert arm.status.trust is Trust.REFERENCED

    def test_a_stop_ends_a_jog(self):
        arm = arm_of(brakes_on=True)
        arm.hold(Jog.joint(base=1.0), speed=0.5, for_s=20.0)
        arm.sleep(1.0)
        arm.stop()
        assert arm.status.state is State.STANDBY
        assert arm.twin.world.motors == arm.status.acknowledged
        assert arm.status.trust is Trust.REFERENCED

    def test_the_arm_homes(self):
        arm = arm_of(brakes_on=True)
        arm.home()
        assert arm.status.trust is Trust.REFERENCED

    def test_the_next_program_connects_without_a_stop(self):
        arm = arm_of(brakes_on=True)
        arm.move_j(base_deg=20.0)
        arm.reset()
        arm.enable()
        arm.move_j(base_deg=10.0)
        assert arm.status.trust is Trust.REFERENCED
