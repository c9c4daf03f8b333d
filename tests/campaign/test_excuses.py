"""What the watch excuses: the motors and joints of a fault alone, and for a bounded time."""

import contextlib
import math
import random

import pytest
from amounts import every_row

from armdrive.dialects.bus.intervals import MAX_DELAY_S
from armdrive.errors import ArmError, NoAnswer
from kinematics import Motors

from .actions import connect
from .excuses import (
    HOLDS_WITHIN_S,
    SPRINGS_BACK_S,
    MissedOrders,
    SpringBack,
    TurnedByHand,
    one_motor_rates_rad_s,
)
from .faults import FAULTS, CampaignFault
from .missed_orders import orders_cut_short, orders_ignored, orders_lost
from .physical import Bound, Command
from .speeds import WINDOW_S
from .stage import Stage

NOTICED_S = 0.1
BASE, SHOULDER, FINGERS = 0, 1, 5


def a_stage(dialect: str = "mks", seed: int = 1) -> Stage:
    return Stage(dialect, random.Random(seed), 0)


def with_program(dialect: str = "mks", seed: int = 1) -> Stage:
    """Return a stage whose arm is connected to a program that trusts no record."""
    stage = a_stage(dialect, seed)
    stage.connect(allow_restored=False, automatic=False)
    return stage


def the_fault(name: str) -> CampaignFault:
    return next(fault for fault in FAULTS if fault.name == name)


def only(motor: int, count: int) -> Motors:
    return Motors(count if each == motor else 0 for each in range(6))


# -- Orders that a drive missed excuse its joints alone, for a bounded time in each command --------


def test_a_wrist_motor_turns_pitch_and_roll():
    stage = a_stage()
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


@pytest.mark.parametrize(("is_pause", "longer_s"), [(True, 0.4), (False, 0.0)])
def test_a_pause_may_last_longer_by_the_time_that_a_drive_missed_orders(is_pause, longer_s):
    stage = a_stage()
    fault_ends_s = stage.now_s + 0.4
    stage.watch.missed_orders = MissedOrders({"elbow": 1.0}, fault_ends_s, noticed_s=NOTICED_S)
    stage.watch.begin(Command("move_j"))
    stage.world.drive(only(0, 1), stage.now_s)
    stage.sleep(1.0)
    stage.add_bound("a pause or a stop", 0.1, 50.0, is_pause=is_pause)
    (bound,) = stage.watch._bounds
    assert bound.time_s == pytest.approx(0.1 + longer_s, abs=1e-6)


def test_a_joint_may_go_no_further_beyond_its_limit_after_the_excuse():
    stage = a_stage()
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
        stage = a_stage()
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
    stage = a_stage()
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
    stage = a_stage()
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
    stage = a_stage("cia402")
    stage.watch.missed_orders = MissedOrders({joint: 1.0}, fault_ends_s=5.0, noticed_s=NOTICED_S)
    stage.watch.begin(Command("move_j", position_known=True))
    far = stage.world.joints.replace(wrist_roll=stage.config.model.arm.limits[4].high_rad + 1.0)
    there = stage.world.body.transmission.to_motors(far, 0.0)
    stage.world.drive(there - stage.world.motors, 1.0)
    stops = [each for each in stage.watch.broken if "driven into a mechanical stop" in each]
    assert bool(stops) is not excused, stage.watch.broken


def test_a_program_that_dies_between_the_orders_to_its_drives_is_excused_for_the_silent_time():
    stage = a_stage()
    assert orders_cut_short(stage) is None  # no program is connected
    stage.connect(allow_restored=False, automatic=False)
    excuse = orders_cut_short(stage)
    assert excuse.joints == {"elbow", "wrist_pitch", "wrist_roll"}
    assert excuse.noticed_s == stage.arm.status.silent_time_s
    stands_by_s = stage.now_s + stage.arm.status.silent_time_s
    assert excuse.excuses(stands_by_s - 0.1)
    assert not excuse.excuses(stands_by_s + 0.01)  # however late the first motion is
    assert orders_cut_short(a_stage("grbl")) is None


@pytest.mark.parametrize("name", ["unplugged, replugged", "the adapter bus-off"])
@pytest.mark.parametrize("overtaken", [True, False])
def test_drives_that_are_cut_off_while_an_order_waits_to_be_overtaken_are_excused(name, overtaken):
    stage = with_program()
    if overtaken:
        stage.late_orders_until_s = stage.now_s + 0.5
    the_fault(name).begin(stage)
    assert (stage.watch.missed_orders is not None) is overtaken


def test_a_line_that_damages_every_other_frame_excuses_shared_joints():
    noise = the_fault("a noisy line")
    words_by_case = {}
    for seed in range(10):
        stage = with_program(seed=seed)
        words = noise.begin(stage)
        damages = "host" in words and "0.025" not in words
        excused = stage.watch.missed_orders is not None and stage.commands_lost
        assert excused is damages, words
        words_by_case[damages] = words
    assert set(words_by_case) == {True, False}


def test_a_joint_may_be_faster_until_its_mks_drives_would_stand_after_a_noisy_line():
    stage = with_program()
    excuse = orders_lost(stage, 3.0)
    ends_s = stage.now_s + 3.0 + stage.arm.status.silent_time_s
    assert excuse.excuses(ends_s - 0.01)
    assert not excuse.excuses(ends_s + 0.01)


def test_a_long_fault_takes_a_joint_no_further_beyond_its_limit_than_the_driver_lets_a_drive_lag():
    stage = with_program()
    excuse, rates_rad_s = orders_lost(stage, 3.0), one_motor_rates_rad_s(stage.config)
    assert excuse.excuses(stage.now_s)
    allowed: dict[str, float] = {}
    excuse.allow_excess(allowed, {"wrist_roll": 9.0}, 0.5)
    lags_s = MAX_DELAY_S + 2.0 * stage.config.device.poll_s
    assert allowed == {"wrist_roll": pytest.approx(0.5 * lags_s * rates_rad_s["wrist_roll"])}


def test_cia402_drives_may_lose_targets_but_no_orders():
    stage = with_program("cia402")
    assert orders_lost(stage, 3.0) is None


# -- Lost targets: shared joints are excused by a bounded angle, while the bus loses targets -------

LOSES = the_fault("frames lost")


def losing(words: str) -> Stage:
    """Return a stage of CiA 402 drives on which the fault with these words has begun."""
    for seed in range(100):
        stage = a_stage("cia402", seed)
        if words in LOSES.begin(stage):
            return stage
    raise AssertionError(words)


def breaks(stage: Stage, joint: str, beyond_deg: float, speed: float = 1.0) -> bool:
    """Move a joint beyond its limit during a command; return whether the watch finds that."""
    arm = stage.config.model.arm
    past_rad = arm.limits[arm.joint_names.index(joint)].low_rad - math.radians(beyond_deg)
    there = stage.world.body.transmission.to_motors(
        stage.world.joints.replace(**{joint: past_rad}), 0.0
    )
    stage.watch.begin(Command("move_j", position_known=True, speed=speed))
    stage.world._shift(there - stage.world.motors, stage.now_s)
    return any("beyond its limit" in each for each in stage.watch.broken)


@pytest.mark.parametrize(
    ("joint", "beyond_deg", "speed", "broken"),
    [
        ("wrist_pitch", 0.79, 1.0, False),
        ("wrist_roll", 0.79, 1.0, False),
        ("wrist_pitch", 3.0, 0.5, True),
        ("wrist_pitch", 2.0, 0.2, True),
        ("base", 0.79, 1.0, True),
    ],
)
def test_a_shared_joint_may_leave_its_path_by_the_targets_that_one_motor_may_miss(
    joint, beyond_deg, speed, broken
):
    assert breaks(losing("0.1 from=host"), joint, beyond_deg, speed) is broken


@pytest.mark.parametrize("words", ["next from=host", "0.1 from=device"])
def test_only_targets_that_may_be_lost_in_a_row_excuse_it(words):
    assert breaks(losing(words), "wrist_pitch", 0.79)


def test_the_excuse_ends_with_the_fault():
    stage = losing("0.1 from=host")
    stage.sleep(2.1)
    assert breaks(stage, "wrist_pitch", 0.79)


@pytest.mark.parametrize(
    ("after_s", "share", "brakes", "broken"),
    [
        (0.0, 1.4, False, False),
        (2.6, 1.4, False, True),
        (0.0, 1.5, False, True),
        (0.0, 5.0, True, False),
        (2.6, 5.0, True, True),
        (0.0, 5.5, True, True),
    ],
)
def test_a_drive_that_catches_up_and_one_that_brakes_then_may_be_that_much_faster(
    after_s, share, brakes, broken
):
    stage = losing("0.1 from=host for=2.0")
    stage.sleep(after_s)
    stage.watch.lost_targets.brakes = lambda: brakes
    limit = stage.config.model.joint_speeds_rad_s[0]
    per_rad = stage.world.body.transmission.matrix[0][0]
    turn = round(share * limit * WINDOW_S * per_rad)
    stage.watch.begin(Command("move_j", position_known=True))
    for number in range(3):
        stage.world.drive(Motors((turn, 0, 0, 0, 0, 0)), stage.now_s + number * WINDOW_S)
    assert any("its limit is" in each for each in stage.watch.broken) is broken


# -- A motor that was blocked springs back, and only for a moment ----------------------------------

STOPPED_S, BLOCKED_S = 1.0, 3.0


def blocked_stage(can_hold) -> Stage:
    """Return an arm that was stopped, and one of whose motors is blocked long after that."""
    stage = a_stage("cia402")
    stage.watch.spring_back.can_hold = can_hold
    stage.watch.add_bound(Bound("stop", STOPPED_S, stage.world.tip, 0.2, 20.0))
    stage.world.stalled.add(FINGERS)
    stage.world.drive(only(FINGERS, 80), BLOCKED_S)
    stage.world.stalled.clear()
    assert not stage.watch.broken
    return stage


def all_but_fingers(motor: int, _time_s: float) -> bool:
    return motor != FINGERS


def test_the_shaft_of_a_drive_without_contact_goes_to_its_set_point():
    stage = blocked_stage(all_but_fingers)
    stage.world.drive(only(FINGERS, 80), BLOCKED_S + 0.01)
    assert not stage.watch.broken


@pytest.mark.parametrize(("motor", "after_s"), [(BASE, 0.01), (FINGERS, SPRINGS_BACK_S + 0.01)])
def test_no_other_motor_moves_and_none_later(motor, after_s):
    stage = blocked_stage(all_but_fingers)
    stage.world.drive(only(motor, 80), BLOCKED_S + after_s)
    assert any("stop: it moved" in each for each in stage.watch.broken)


def test_the_shaft_of_a_drive_in_contact_stays():
    stage = blocked_stage(lambda _motor, _time_s: True)
    stage.world.drive(only(FINGERS, 80), BLOCKED_S + 0.01)
    assert any("stop: it moved" in each for each in stage.watch.broken)


def test_motors_that_are_not_blocked_are_not_excused():
    spring_back = SpringBack(can_hold=lambda _motor, _time_s: False)
    assert not spring_back.excuses({FINGERS}, 0.0)
    spring_back.note_blocked({FINGERS}, 1.0)
    assert spring_back.excuses({FINGERS}, 1.0)
    assert not spring_back.excuses({FINGERS, BASE}, 1.0)


@pytest.mark.parametrize(
    ("in_motion", "lasts_s", "excused"),
    [(True, HOLDS_WITHIN_S - 0.01, True), (True, HOLDS_WITHIN_S + 0.2, False), (False, 0.0, False)],
)
def test_a_drive_in_contact_holds_in_time_and_only_a_motion_runs_ahead_of_its_shaft(
    in_motion, lasts_s, excused
):
    spring_back = SpringBack()
    for time_s in (1.0 + 0.05 * step for step in range(round(lasts_s / 0.05) + 1)):
        spring_back.note_blocked({FINGERS}, time_s, in_motion=in_motion and time_s < 1.2)
    assert spring_back.excuses({FINGERS}, 1.0 + lasts_s) is excused


@pytest.mark.parametrize("lasts_s", [HOLDS_WITHIN_S + 0.2, 2.0 * HOLDS_WITHIN_S])
def test_a_block_that_lasts_is_not_excused_again_in_the_same_motion(lasts_s):
    spring_back = SpringBack()
    for time_s in (1.0 + 0.05 * step for step in range(round(lasts_s / 0.05) + 1)):
        spring_back.note_blocked({FINGERS}, time_s, in_motion=True)
    assert not spring_back.excuses({FINGERS}, 1.0 + lasts_s)


@pytest.mark.parametrize("stopped", [False, True], ids=["", "with an emergency stop"])
def test_no_drive_is_ordered_to_hold_between_a_lost_wire_and_the_reset(stopped):
    stage = a_stage()
    connect(stage)
    arm = stage.arm
    arm.enable()
    assert stage._can_hold(FINGERS, stage.now_s)
    stage.twin.faults.add("bus-off", for_s=0.2)
    if stopped:
        with contextlib.suppress(ArmError):
            arm.estop()
    arm.sleep(3.0)
    arm.reconnect()
    assert not stopped or arm.status.error_code == "E303"
    assert not stage._can_hold(FINGERS, stage.now_s)
    arm.reset()
    assert stage._can_hold(FINGERS, stage.now_s)


def test_no_drive_is_ordered_to_hold_while_the_device_is_mute():
    stage = a_stage("cia402")
    connect(stage)
    the_fault("a mute device").begin(stage)
    assert not stage._can_hold(FINGERS, stage.now_s)
    assert stage._can_hold(FINGERS, stage.now_s + 10.0)


def test_no_drive_is_ordered_to_hold_between_a_lost_reply_and_the_reset():
    stage = a_stage("cia402")
    connect(stage)
    arm = stage.arm
    arm.enable()
    stage.twin.faults.add("mute")
    with pytest.raises(NoAnswer):
        arm.jog_j(base_deg=1.0)
    stage.twin.faults.end()
    assert not stage._can_hold(FINGERS, stage.now_s)
    arm.reset()
    assert stage._can_hold(FINGERS, stage.now_s)


# -- A turned shaft is excused alone, between the two places, for a moment -------------------------

BY = 25
SOON_S, LATE_S = 0.02, 0.1
RESTS = 8
"""How many counts a drive that holds may be off its target."""


def turned(dialect: str = "cia402") -> Stage:
    """Return a standing arm whose base a hand has turned."""
    stage = a_stage(dialect)
    stage.watch.add_bound(Bound("stop", -9.0, stage.world.tip, 0.2, 20.0))
    before = stage.world.motors
    assert stage.turn_by_hand(only(BASE, BY))
    stage.watch.turned_by_hand = excuse_of(stage, before)
    return stage


def excuse_of(stage: Stage, before: Motors) -> TurnedByHand | None:
    return TurnedByHand.of(stage.config, before, stage.world.motors, stage.now_s)


@pytest.mark.parametrize("counts", [(-BY,), (-10,), (-BY, BY)])
def test_its_drive_may_turn_it_back_and_forth(counts):
    stage = turned()
    for count in counts:
        stage.world.drive(only(BASE, count), SOON_S)
    assert not stage.watch.broken


@every_row(
    "motor, count, time_s",
    [
        (BASE, -BY, LATE_S),
        (BASE, -BY - 1, SOON_S),
        (BASE, RESTS + 1, SOON_S),
        (SHOULDER, RESTS + 1, SOON_S),
    ],
)
def test_nothing_else_moves(motor, count, time_s):
    stage = turned()
    stage.world.drive(only(motor, count), time_s)
    assert any("stop: it moved" in each for each in stage.watch.broken)


def test_no_stepper_is_turned_back():
    stage = a_stage("teachmover")
    assert excuse_of(stage, stage.world.motors) is None


@pytest.mark.parametrize("referencing", [True, False])
def test_only_a_reference_that_is_being_taken_hides_the_hand(referencing):
    stage = a_stage("armdroid")
    hand = the_fault("pendant used")
    with stage.watch.reference_attempt() as ended_well:
        stage.referenced_s = stage.now_s
        if referencing:
            hand.begin(stage)
        ended_well()
    if not referencing:
        hand.begin(stage)
    assert bool(stage.watch.slipped) is referencing
