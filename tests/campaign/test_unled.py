"""The excuse of a drive that obeys no more: bounded in time, for its own joints, and once."""

from __future__ import annotations

import random

import pytest

from .faults import FAULTS
from .physical import Command
from .stage import Stage
from .unled import Unled, half_told, unled

KNOWN_S = 0.1


def test_what_a_wrist_motor_turns_is_pitch_and_roll():
    stage = Stage("mks", random.Random(1), 0)
    assert unled(stage, 4, 0.5).joints == {"wrist_pitch", "wrist_roll"}
    assert unled(stage, 2, 0.5).joints == {"elbow", "wrist_pitch"}


def test_it_runs_from_the_first_motion_without_the_drive_and_not_for_ever():
    excuse = Unled(frozenset({"elbow"}), ends_s=5.0, known_s=KNOWN_S)
    assert excuse.excuses(2.0)
    assert excuse.excuses(2.0 + KNOWN_S)
    assert not excuse.excuses(2.01 + KNOWN_S)
    excuse.begin()
    assert excuse.excuses(3.0)
    excuse.begin()
    assert not excuse.excuses(5.01)


def test_a_joint_may_go_no_farther_than_it_came_meanwhile():
    stage = Stage("mks", random.Random(1), 0)
    world, watch = stage.world, stage.watch
    arm = stage.config.model.arm
    high = arm.limits[4].high_rad

    def at_roll(past_rad):
        return world.body.transmission.to_motors(
            world.joints.replace(wrist_roll=high + past_rad), 0.0
        )

    watch.unled = Unled(frozenset({"wrist_roll"}), ends_s=5.0, known_s=KNOWN_S)
    watch.begin(Command("move_j", known=True))
    for time_s, past_rad, broken in (
        (1.0, 0.02, 0),
        (1.1, 0.03, 0),
        (1.2, 0.035, 0),
        (1.3, 0.05, 1),
    ):
        world._shift(at_roll(past_rad) - world.motors, time_s)
        assert len(watch.broken) == broken, watch.broken


@pytest.mark.parametrize(("joint", "excused"), [("wrist_roll", True), ("elbow", False)])
def test_its_own_joints_alone_may_come_to_their_mechanical_stops(joint, excused):
    stage = Stage("cia402", random.Random(1), 0)
    stage.watch.unled = Unled(frozenset({joint}), ends_s=5.0, known_s=KNOWN_S)
    stage.watch.begin(Command("move_j", known=True))
    far = stage.world.joints.replace(wrist_roll=stage.config.model.arm.limits[4].high_rad + 1.0)
    there = stage.world.body.transmission.to_motors(far, 0.0)
    stage.world.drive(there - stage.world.motors, 1.0)
    stops = [each for each in stage.watch.broken if "driven into a mechanical stop" in each]
    assert bool(stops) is not excused, stage.watch.broken


def test_a_program_that_dies_between_the_orders_of_drives_is_excused_for_as_long_as_announced():
    stage = Stage("mks", random.Random(1), 0)
    assert half_told(stage) is None  # nobody drives it
    stage.connect(allow_restored=False, automatic=False, recorded=False)
    excuse = half_told(stage)
    assert excuse.joints == {"elbow", "wrist_pitch", "wrist_roll"}
    assert excuse.known_s == stage.arm.status.silent_time_s
    assert half_told(Stage("grbl", random.Random(1), 0)) is None


@pytest.mark.parametrize("name", ["unplugged, replugged", "the adapter bus-off"])
@pytest.mark.parametrize("overtaken", [True, False])
def test_drives_that_are_cut_off_while_an_order_waits_to_be_overtaken_are_excused(name, overtaken):
    stage = Stage("mks", random.Random(1), 0)
    stage.connect(allow_restored=False, automatic=False, recorded=False)
    if overtaken:
        stage.late_orders_until_s = stage.now_s + 0.5
    next(fault for fault in FAULTS if fault.name == name).begin(stage)
    assert (stage.watch.unled is not None) is overtaken


def test_a_line_that_spoils_every_other_frame_excuses_what_several_drives_turn_together():
    noise = next(fault for fault in FAULTS if fault.name == "a noisy line")
    seen = {}
    for seed in range(10):
        stage = Stage("cia402", random.Random(seed), 0)
        stage.connect(allow_restored=False, automatic=False, recorded=False)
        words = noise.begin(stage)
        spoils = "host" in words and "0.005" not in words
        excused = stage.watch.unled is not None and stage.unheard
        assert excused is spoils, words
        seen[spoils] = words
    assert set(seen) == {True, False}
