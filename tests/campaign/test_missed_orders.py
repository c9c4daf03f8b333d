"""`MissedOrders` excuses the joints of the drive alone, and for a bounded time in each command."""

import random

import pytest

from armdrive.dialects.bus.observer import MAX_DELAY_S

from .excuses import MissedOrders, one_motor_rates_rad_s
from .faults import FAULTS
from .missed_orders import orders_cut_short, orders_ignored, orders_lost
from .physical import Command
from .stage import Stage

NOTICED_S = 0.1


def test_what_a_wrist_motor_turns_is_pitch_and_roll():
    stage = Stage("mks", random.Random(1), 0)
    assert orders_ignored(stage, 4, 0.5).joints == {"wrist_pitch", "wrist_roll"}
    assert orders_ignored(stage, 2, 0.5).joints == {"elbow", "wrist_pitch"}


def test_the_excuse_runs_from_the_first_motion_without_the_drive_for_a_bounded_time():
    excuse = MissedOrders({"elbow": 1.0}, fault_ends_s=5.0, noticed_s=NOTICED_S)
    assert excuse.excuses(2.0)
    assert excuse.excuses(2.0 + NOTICED_S)
    assert not excuse.excuses(2.01 + NOTICED_S)
    excuse.begin()
    assert excuse.excuses(3.0)
    excuse.begin()
    assert not excuse.excuses(5.01)


def test_a_joint_may_go_no_further_beyond_its_limit_after_the_excuse():
    stage = Stage("mks", random.Random(1), 0)
    world, watch = stage.world, stage.watch
    arm = stage.config.model.arm
    high = arm.limits[4].high_rad

    def at_roll(past_rad):
        return world.body.transmission.to_motors(
            world.joints.replace(wrist_roll=high + past_rad), 0.0
        )

    watch.missed_orders = MissedOrders({"wrist_roll": 1.0}, fault_ends_s=5.0, noticed_s=NOTICED_S)
    watch.begin(Command("move_j", position_known=True))
    for time_s, past_rad, broken in (
        (1.0, 0.02, 0),
        (1.1, 0.03, 0),
        (1.2, 0.035, 0),
        (1.3, 0.05, 1),
    ):
        world._shift(at_roll(past_rad) - world.motors, time_s)
        assert len(watch.broken) == broken, watch.broken


def rates(stage, *joints):
    """Return the excused joints, with the speeds at which one motor turns them."""
    found = one_motor_rates_rad_s(stage.config)
    return {joint: found[joint] for joint in joints}


def test_a_joint_goes_no_further_beyond_its_limit_than_one_motor_turns_it():
    for share, broken in ((0.9, False), (1.6, True)):
        stage = Stage("mks", random.Random(1), 0)
        excused = rates(stage, "wrist_roll")
        stage.watch.missed_orders = MissedOrders(excused, fault_ends_s=5.0, noticed_s=NOTICED_S)
        stage.watch.begin(Command("move_j", position_known=True, speed=0.2))
        past_rad = share * 0.2 * excused["wrist_roll"] * NOTICED_S
        high = stage.config.model.arm.limits[4].high_rad
        there = stage.world.body.transmission.to_motors(
            stage.world.joints.replace(wrist_roll=high + past_rad), 0.0
        )
        stage.world._shift(there - stage.world.motors, 1.0)
        beyond = any("beyond its limit" in each for each in stage.watch.broken)
        assert beyond is broken, stage.watch.broken


@pytest.mark.parametrize(("share", "broken"), [(0.9, False), (1.4, True)])
def test_a_joint_turns_no_faster_than_one_motor_turns_it(share, broken):
    stage = Stage("mks", random.Random(1), 0)
    world, excused = stage.world, rates(stage, "elbow")
    stage.watch.missed_orders = MissedOrders(excused, fault_ends_s=5.0, noticed_s=1.0)
    stage.watch.begin(Command("home", position_known=False))
    for step in range(1, 10):
        ahead = world.joints.replace(elbow=world.joints[2] + 0.05 * share * excused["elbow"])
        there = world.body.transmission.to_motors(ahead, 0.0)
        world._shift(there - world.motors, 0.05 * step)
    assert any("elbow turned" in each for each in stage.watch.broken) is broken


@pytest.mark.parametrize(("joint", "excused"), [("elbow", True), ("wrist_roll", False)])
def test_only_the_joints_of_the_drive_may_turn_too_fast(joint, excused):
    stage = Stage("mks", random.Random(1), 0)
    world, watch = stage.world, stage.watch
    watch.missed_orders = MissedOrders(rates(stage, joint), fault_ends_s=5.0, noticed_s=1.0)
    watch.begin(Command("home", position_known=False))
    fast_rad_s = 1.4 * stage.config.model.joint_speeds_rad_s[2]
    for step in range(1, 30):
        ahead = world.joints.replace(elbow=world.joints[2] + 0.05 * fast_rad_s)
        there = world.body.transmission.to_motors(ahead, 0.0)
        world._shift(there - world.motors, 0.05 * step)
        if step == 20:
            assert any("elbow turned" in each for each in watch.broken) is not excused
    assert any("elbow turned" in each for each in watch.broken)  # the excuse has ended


@pytest.mark.parametrize(("joint", "excused"), [("wrist_roll", True), ("elbow", False)])
def test_only_the_joints_of_the_drive_may_reach_their_mechanical_stops(joint, excused):
    stage = Stage("cia402", random.Random(1), 0)
    stage.watch.missed_orders = MissedOrders({joint: 1.0}, fault_ends_s=5.0, noticed_s=NOTICED_S)
    stage.watch.begin(Command("move_j", position_known=True))
    far = stage.world.joints.replace(wrist_roll=stage.config.model.arm.limits[4].high_rad + 1.0)
    there = stage.world.body.transmission.to_motors(far, 0.0)
    stage.world.drive(there - stage.world.motors, 1.0)
    stops = [each for each in stage.watch.broken if "driven into a mechanical stop" in each]
    assert bool(stops) is not excused, stage.watch.broken


def test_a_program_that_dies_between_the_orders_to_its_drives_is_excused_for_the_silent_time():
    stage = Stage("mks", random.Random(1), 0)
    assert orders_cut_short(stage) is None  # no program is connected
    stage.connect(allow_restored=False, automatic=False, recorded=False)
    excuse = orders_cut_short(stage)
    assert excuse.joints == {"elbow", "wrist_pitch", "wrist_roll"}
    assert excuse.noticed_s == stage.arm.status.silent_time_s
    stands_by_s = stage.now_s + stage.arm.status.silent_time_s
    assert excuse.excuses(stands_by_s - 0.1)
    assert not excuse.excuses(stands_by_s + 0.01)  # however late the first motion is
    assert orders_cut_short(Stage("grbl", random.Random(1), 0)) is None


@pytest.mark.parametrize("name", ["unplugged, replugged", "the adapter bus-off"])
@pytest.mark.parametrize("overtaken", [True, False])
def test_drives_that_are_cut_off_while_an_order_waits_to_be_overtaken_are_excused(name, overtaken):
    stage = Stage("mks", random.Random(1), 0)
    stage.connect(allow_restored=False, automatic=False, recorded=False)
    if overtaken:
        stage.late_orders_until_s = stage.now_s + 0.5
    next(fault for fault in FAULTS if fault.name == name).begin(stage)
    assert (stage.watch.missed_orders is not None) is overtaken


def test_a_line_that_damages_every_other_frame_excuses_shared_joints():
    noise = next(fault for fault in FAULTS if fault.name == "a noisy line")
    words_by_case = {}
    for seed in range(10):
        stage = Stage("mks", random.Random(seed), 0)
        stage.connect(allow_restored=False, automatic=False, recorded=False)
        words = noise.begin(stage)
        damages = "host" in words and "0.005" not in words
        excused = stage.watch.missed_orders is not None and stage.commands_lost
        assert excused is damages, words
        words_by_case[damages] = words
    assert set(words_by_case) == {True, False}


def test_a_joint_may_be_faster_until_its_mks_drives_would_stand_after_a_noisy_line():
    stage = Stage("mks", random.Random(1), 0)
    stage.connect(allow_restored=False, automatic=False, recorded=False)
    excuse = orders_lost(stage, 3.0)
    ends_s = stage.now_s + 3.0 + stage.arm.status.silent_time_s
    assert excuse.excuses(ends_s - 0.01)
    assert not excuse.excuses(ends_s + 0.01)


def test_a_long_fault_takes_a_joint_no_further_beyond_its_limit_than_the_driver_lets_a_drive_lag():
    stage = Stage("mks", random.Random(1), 0)
    stage.connect(allow_restored=False, automatic=False, recorded=False)
    excuse, rates_rad_s = orders_lost(stage, 3.0), one_motor_rates_rad_s(stage.config)
    assert excuse.excuses(stage.now_s)
    allowed: dict[str, float] = {}
    excuse.allow_excess(allowed, {"wrist_roll": 9.0}, 0.5)
    lags_s = MAX_DELAY_S + 2.0 * stage.config.device.poll_s
    assert allowed == {"wrist_roll": pytest.approx(0.5 * lags_s * rates_rad_s["wrist_roll"])}


def test_cia402_drives_may_lose_targets_but_no_orders():
    stage = Stage("cia402", random.Random(1), 0)
    stage.connect(allow_restored=False, automatic=False, recorded=False)
    assert orders_lost(stage, 3.0) is None
