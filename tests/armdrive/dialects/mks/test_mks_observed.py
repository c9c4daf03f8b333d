"""What owners have seen real MKS drives do, beyond the manuals: the arm copes, or says what to do.

The quirks of `armdrive/sim/mks/quirks.py` name who has seen it.
"""

from __future__ import annotations

from dataclasses import replace

import pytest
from amounts import each_value
from faults import arm_config, driven

from armdrive import Arm
from armdrive.config.sections import HomingSettings
from armdrive.connect.parts import connect_simulated
from armdrive.errors import DeviceFault
from armdrive.runtime.clock import SimulatedClock
from armdrive.status import Trust
from armdrive.trace.entries import EntryKind
from firmware_protocol import mks
from firmware_protocol.frames import Unpacker
from kinematics import Joints

OVER = Joints.of(40.0, 40.0, -80.0, -40.0, 0.0)
STRATEGIES = {"steered": {}, "bursts": {"segment_s": 0.0}}


def arm_of(strategy: str = "steered", **options) -> Arm:
    """An arm that stands in the air, referenced, with homing set up."""
    homing = HomingSettings(OVER, 20.0, ((1,), (2,), (0,), (3, 4), (5,)))
    config = arm_config("mks", device=STRATEGIES[strategy])
    return driven(replace(config, homing=homing), **options)


def next_program(arm: Arm) -> Arm:
    """Connect another program to an arm that was closed."""
    arm.twin.link.reopen()
    clock = SimulatedClock(arm.twin.device.now_s)
    return Arm(connect_simulated(arm.config, twin=arm.twin, pace=clock))


class TestDrivesThatReportBrakingForEver:
    @pytest.mark.parametrize("strategy", STRATEGIES)
    def test_motions_jogs_and_homing_end(self, strategy):
        arm = arm_of(strategy, brakes_on=True)
        arm.home()
        arm.move_j(base_deg=20.0)
        arm.jog_j(base_deg=1.0)
        assert arm.twin.world.motors == arm.status.acknowledged
        assert arm.status.trust is Trust.REFERENCED

    def test_the_next_program_connects_without_a_stop(self):
        arm = arm_of(brakes_on=True)
        arm.move_j(base_deg=20.0)
        arm.close()
        again = next_program(arm)
        entries = again.parts.tracer.since(0, 10_000, 10_000)[1]
        sent = [
            frame
            for each in entries
            if each.kind is EntryKind.SENT
            for frame in Unpacker().feed(each.what)
        ]
        assert sent
        assert not [frame for frame in sent if frame.data[0] == mks.Code.ABSOLUTE_AXIS]
        before = again.twin.world.joints.deg["base"]
        again.enable()
        again.jog_j(base_deg=10.0)
        assert again.twin.world.joints.deg["base"] == pytest.approx(before + 10.0, abs=0.01)


class TestDrivesWhoseReadingIgnoresTheirZero:
    def test_homing_says_so_and_this_program_moves_nothing_more(self):
        arm = arm_of(keeps_count=True)
        with pytest.raises(DeviceFault, match="targets count from another place"):
            arm.home()
        assert arm.status.trust is Trust.SUSPECT
        arm.reset()
        before = arm.twin.world.motors
        with pytest.raises(DeviceFault, match="Switch the drives' supply off and on"):
            arm.jog_j(base_deg=1.0)
        assert arm.twin.world.motors == before

    def test_after_a_power_cycle_the_next_program_moves_them(self):
        arm = arm_of(keeps_count=True)
        with pytest.raises(DeviceFault, match="targets count from another place"):
            arm.home()
        arm.close()
        for on in (False, True):
            arm.twin.device.set_power(on)
            arm.twin.link.line.advance(arm.twin.device.now_s + 1.0)
        again = next_program(arm)
        again.enable()
        again.reference.declare(arm.twin.world.joints, opening_mm=arm.twin.world.opening_mm)
        again.jog_j(base_deg=1.0)
        assert again.twin.world.motors == again.status.acknowledged

    @each_value("by, strategy", [100_000, -100_000, 3000], [*STRATEGIES])
    def test_a_zero_that_another_program_set_shows_after_a_degree_or_two(self, by, strategy):
        arm = arm_of(strategy, keeps_count=True)
        motor = arm.twin.device.board.nodes[0].motor
        motor.count_from(motor.counts + by)
        before = arm.twin.world.motors
        with pytest.raises(DeviceFault):
            arm.jog_j(base_deg=1.0)
        assert abs((arm.twin.world.motors - before)[0]) < 3500
        stood = arm.twin.world.motors
        arm.sleep(3.0)
        assert arm.twin.world.motors == stood
        assert arm.status.trust is Trust.SUSPECT


class TestTheWatchdogInTheMemory:
    def test_it_is_written_once_and_only_compared_from_then_on(self):
        arm = arm_of()
        written = [node.flash.of(mks.SilenceWatchdog) for node in arm.twin.device.board.nodes]
        arm.disable()
        arm.enable()
        again = [node.flash.of(mks.SilenceWatchdog) for node in arm.twin.device.board.nodes]
        assert all(a is b for a, b in zip(written, again, strict=True))

    def test_drives_that_are_deaf_while_they_write_are_waited_for(self):
        arm = arm_of(flash_ms=200)
        for node in arm.twin.device.board.nodes:
            assert node.flash.of(mks.SilenceWatchdog).timeout_ms == 500
        arm.move_j(base_deg=20.0)


def test_a_drive_of_the_e_series_is_named_and_nothing_is_written():
    with pytest.raises(DeviceFault, match="E series"):
        driven(arm_config("mks"), e_series=True)


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_a_drive_that_ignores_its_first_motion_after_a_limit_stop_gets_it_again(strategy):
    homing = HomingSettings(Joints.of(5.0, 40.0, -80.0, -40.0, 0.0), 20.0)
    config = replace(arm_config("mks", device=STRATEGIES[strategy]), homing=homing)
    below = Joints.of(0.0, 40.0, -80.0, -40.0, 0.0)
    arm = driven(config, limits=True, deaf_after_limit=True, at=below)
    with pytest.raises(DeviceFault, match="limit switch"):
        arm.jog_j(base_deg=10.0)
    arm.reset()
    stood = arm.twin.world.joints.deg["base"]
    arm.jog_j(base_deg=-1.0)
    assert arm.twin.world.joints.deg["base"] == pytest.approx(stood - 1.0, abs=0.01)


class TestDrivesThatCreepAtNewTargets:
    def test_a_fast_motion_ends_and_names_the_setting_that_avoids_them(self):
        arm = arm_of(retarget_creeps=True)
        with pytest.raises(DeviceFault, match="segment_s = 0"):
            arm.move_j(base_deg=20.0, shoulder_deg=30.0)

    def test_with_that_setting_they_are_like_any_others(self):
        arm = arm_of("bursts", retarget_creeps=True)
        arm.move_j(base_deg=20.0, shoulder_deg=30.0)
        arm.jog_j(base_deg=1.0)
        assert arm.twin.world.motors == arm.status.acknowledged
