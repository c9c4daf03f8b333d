"""The watch judges the physical arm, and excuses only what no driver can know or prevent."""

import math
import random

import pytest
from amounts import every_row

from kinematics import Motors

from .actions import connect
from .arrival import GraspAim, JointsAim, PoseAim
from .faults import FAULTS, CampaignFault
from .goals import certain_goal, place_near_limits
from .laws import FRESH_S, Broken, call, check_arrival
from .mission import Mission
from .physical import NOTICED_S, TURNS_BACK_S, Bound, Command
from .speeds import SPEED_TOLERANCE, WINDOW_S
from .stage import VARIANTS, Stage

BASE, SHOULDER, ELBOW, FINGERS = 0, 1, 2, 5


def a_stage(dialect: str = "teachmover", variant: int = 0) -> Stage:
    return Stage(dialect, random.Random(1), variant)


def steps(**counts: int) -> Motors:
    names = ("base", "shoulder", "elbow", "right", "left", "fingers")
    return Motors(counts.get(name, 0) for name in names)


def the_fault(name: str) -> CampaignFault:
    return next(fault for fault in FAULTS if fault.name == name)


def commanded(stage: Stage, by: Motors, **words) -> None:
    """Begin a command that moves the arm by some steps from where it stands."""
    here = stage.world.motors
    stage.watch.begin(Command("move_j", position_known=True, span=(here, here + by), **words))


def test_a_slipped_motor_leaves_the_others_on_their_path():
    stage = a_stage()
    stage.world.lose(ELBOW, 20)
    commanded(stage, steps(base=30, elbow=20))
    stage.world.drive(steps(base=30, elbow=20), 1.0)
    assert stage.watch.doubts.unknown == {ELBOW}
    assert not stage.watch.broken
    stage.world.drive(steps(base=5), 2.0)
    assert "motor 1 was at" in stage.watch.broken[0]


@pytest.mark.parametrize(("well", "left"), [(True, set()), (False, {ELBOW})])
def test_a_slip_ends_only_with_a_successful_reference(well, left):
    stage = a_stage()
    stage.world.lose(ELBOW, 20)
    stage.world.drive(steps(elbow=20), 1.0)
    with stage.watch.reference_attempt() as succeeded:
        stage.watch.begin_reference()
        assert not stage.watch.doubts.unknown
        if well:
            succeeded.append(True)
    assert stage.watch.doubts.off_path == stage.watch.doubts.unknown == left


def test_the_limits_hold_for_joints_that_a_slipped_motor_does_not_turn():
    stage = a_stage()
    limit = stage.config.model.arm.limits[BASE].high_rad
    transmission = stage.world.body.transmission
    stage.world.lose(FINGERS, 3)
    stage.watch.begin(Command("move_j", position_known=True))
    stage.world.drive(steps(fingers=3), 1.0)
    there = transmission.to_motors(stage.world.joints.replace(base=limit + 0.03), 0.0)
    stage.world.drive(steps(base=there[BASE] - stage.world.motors[BASE]), 9.0)
    assert any("base was" in each and "beyond its limit" in each for each in stage.watch.broken)


def test_a_restarted_drive_excuses_only_its_own_joints_from_their_limits():
    stage = a_stage("mks")
    stage.watch.lose_track({BASE})
    stage.watch.begin(Command("move_j", position_known=True))
    transmission, arm = stage.world.body.transmission, stage.config.model.arm

    def turn(joint: int) -> None:
        name = arm.joint_names[joint]
        past_rad = arm.limits[joint].high_rad + 0.03
        goal = transmission.to_motors(stage.world.joints.replace(**{name: past_rad}), 0.0)
        stage.world.drive_to(Motors((*goal[:FINGERS], stage.world.motors[FINGERS])), 9.0)

    turn(BASE)
    assert not any("base" in each and "limit" in each for each in stage.watch.broken)
    turn(SHOULDER)
    assert any("shoulder" in each for each in stage.watch.broken)


def test_a_sag_is_no_motion_and_leaves_the_bounds_in_force():
    stage = a_stage()
    stage.world.energised = True
    stage.watch.add_bound(Bound("stop", 1.0, stage.world.tip, 0.5, 5.0))
    stage.world.cut_current(1.1)
    assert stage.watch.doubts.off_path
    assert not stage.watch.broken
    stage.world.energised = True
    stage.world.drive(steps(base=3), 1.2)
    assert not [each for each in stage.watch.broken if "stop" in each]
    stage.world.drive(steps(base=3), 2.0)
    assert any("stop: it moved" in each for each in stage.watch.broken)


@pytest.mark.parametrize(
    ("after_s", "suspended_s", "excused"),
    [(0.01, 0.0, True), (FRESH_S + 0.1, 0.0, False), (FRESH_S + 0.1, 0.2, True)],
)
def test_an_arm_that_sags_when_its_command_ends_has_arrived(after_s, suspended_s, excused):
    stage = a_stage("cia402")
    stage.suspended_s = suspended_s
    commanded(stage, steps())
    assert stage.watch._command is not None
    aim = JointsAim(stage.world.motors, {})
    stage.world.give_way(steps(elbow=200), stage.now_s)
    stage.watch.note_change(stage.now_s, math.inf)
    stage.sleep(after_s)
    if excused:
        check_arrival(stage, stage.watch._command, aim, None)
    else:
        with pytest.raises(Broken, match="ended well, but"):
            check_arrival(stage, stage.watch._command, aim, None)


def at_rest(dialect: str) -> Stage:
    """Return an arm whose last command ended long ago."""
    stage = a_stage(dialect)
    stage.watch.begin(Command("move_j"))
    stage.watch.end(1.0, 0.0)
    return stage


@every_row(
    "dialect, way, moves",
    [("mks", 1, False), ("mks", 8, False), ("mks", 9, True), ("teachmover", 1, True)],
)
def test_only_drives_that_hold_may_turn_without_a_command_and_only_in_their_rest_window(
    dialect, way, moves
):
    stage = at_rest(dialect)
    for count in (way, -way, way):
        stage.world.drive(steps(right=count, left=count), 3.0)
    assert any("without a command" in each for each in stage.watch.broken) is moves


def test_a_drive_that_creeps_is_seen_to_move():
    stage = at_rest("mks")
    for number in range(9):
        stage.world.drive(steps(right=1), 3.0 + number)
    assert any("without a command" in each for each in stage.watch.broken)


def test_a_drive_that_trembles_has_come_to_rest():
    stage = a_stage("mks")
    stage.watch.begin(Command("move_j"))
    stage.watch.add_bound(Bound("stop", 1.0, stage.world.tip, 0.5, 50.0))
    stage.world.drive(steps(right=800), 1.2)
    for at_s, count in ((1.6, 3), (1.7, -3)):
        stage.world.drive(steps(right=count), at_s)
    assert not stage.watch.broken
    stage.world.drive(steps(right=30), 1.8)
    assert any("stop: it moved" in each for each in stage.watch.broken)


# -- Drives that miss orders: their path is excused, and they must come to rest in time ------------


@every_row("is_pause, more_s", [(True, 2.0), (False, 0.0)])
def test_a_stop_on_a_damaged_line_has_the_time_of_a_silent_program_and_a_pause_the_faults(
    is_pause, more_s
):
    stage = a_stage("mks")
    connect(stage)
    silent_s = stage.arm.status.silent_time_s
    stage.disturb(2.0)
    stage.add_bound("a pause or a stop", 0.1, 50.0, is_pause=is_pause)
    (bound,) = stage.watch.bounds
    assert bound.time_s == pytest.approx(silent_s + NOTICED_S + more_s, abs=1e-6)


@every_row("is_pause, more_s", [(True, 2.0), (False, 0.0)])
def test_a_line_that_is_damaged_after_a_stop_loosens_its_bound(is_pause, more_s):
    stage = a_stage("mks")
    connect(stage)
    stage.add_bound("a pause or a stop", 0.1, 50.0, is_pause=is_pause)
    stage.disturb(2.0)
    (bound,) = stage.watch.bounds
    silent_s = stage.arm.status.silent_time_s
    assert bound.time_s == pytest.approx(silent_s + NOTICED_S + more_s, abs=1e-6)


@every_row(
    "dialect, begins_s, law, broken",
    [
        ("mks", 0.5, "motor 1 was at", False),
        ("mks", 0.5, "it moved", True),
        ("mks", 3.0, "motor 1 was at", True),
        ("teachmover", 0.5, "motor 1 was at", True),
    ],
)
def test_only_drives_may_leave_their_path_and_only_in_a_command_that_is_disturbed(
    dialect, begins_s, law, broken
):
    stage = a_stage(dialect)
    stage.disturb(1.0)
    commanded(stage, steps(base=30))
    stage.watch.add_bound(Bound("stop", 0.0, stage.world.tip, 4.0, 500.0))
    for time_s in (begins_s, 3.5, 5.0):
        stage.world.drive(steps(base=40), time_s)
    assert any(law in each for each in stage.watch.broken) is broken, stage.watch.broken


@every_row(
    "name, words, disturbs",
    [
        ("a noisy line", "from=host", True),
        ("a noisy line", "from=device", False),
        ("frames lost", "0.1 from=host", True),
        ("frames lost", "next", False),
        ("frames overtaken", "from=host", True),
        ("messages late", "0.4 next from=host", True),
        ("a drive in another mode", "", True),
        ("no acknowledgement", "", True),
        ("a mute drive", "", False),
        ("unplugged, replugged", "", False),
    ],
)
def test_a_fault_disturbs_drives_if_they_may_miss_orders(name, words, disturbs):
    for seed in range(100):
        stage = Stage("mks", random.Random(seed), 0)
        if words in the_fault(name).begin(stage):
            break
    assert (stage.watch.disturbed_until_s > stage.now_s) is disturbs


@every_row(
    "dialect, counts, hidden",
    [("mks", 64, True), ("mks", 65, False), ("teachmover", 0, True), ("teachmover", 1, False)],
)
def test_a_restart_hides_only_from_a_driver_that_has_counted_next_to_nothing(
    dialect, counts, hidden
):
    stage = a_stage(dialect)
    stage.turn_by_hand(steps(base=counts))
    stage.connect(allow_restored=False, automatic=False)
    the_fault("brown-out").begin(stage)
    assert bool(stage.watch.doubts.unknown) is hidden
    assert len(stage.watch.doubts.off_path) == 6


# -- A shaft that was blocked or turned goes back to its set-point, and only for a moment ----------


def displaced(cause: str, dialect: str = "cia402") -> Stage:
    """Return an arm that was stopped, and one of whose shafts is then blocked or turned."""
    stage = a_stage(dialect)
    stage.world.energised = True
    stage.watch.add_bound(Bound("stop", -9.0, stage.world.tip, 0.2, 20.0))
    if cause == "turned":
        stage.watch.note_displaced({BASE}, 0.0)
    else:
        stage.world.stalled.add(BASE)
        stage.world.drive(steps(base=80), 0.0)
        stage.world.stalled.clear()
    return stage


@pytest.mark.parametrize("cause", ["turned", "blocked"])
@every_row(
    "dialect, motor, time_s, broken",
    [
        ("cia402", "base", TURNS_BACK_S, False),
        ("cia402", "base", TURNS_BACK_S + 0.01, True),
        ("cia402", "shoulder", 0.01, True),
        ("teachmover", "base", 0.01, True),
    ],
)
def test_only_this_shaft_turns_back_and_no_stepper(cause, dialect, motor, time_s, broken):
    stage = displaced(cause, dialect)
    stage.world.drive(steps(**{motor: 80}), time_s)
    assert any("stop: it moved" in each for each in stage.watch.broken) is broken


@every_row("referencing", [True, False])
def test_only_a_reference_that_is_being_taken_hides_the_hand(referencing):
    stage = a_stage("armdroid")
    hand = the_fault("pendant used")
    with stage.watch.reference_attempt() as succeeded:
        stage.referenced_s = stage.now_s
        if referencing:
            hand.begin(stage)
        succeeded.append(True)
    if not referencing:
        hand.begin(stage)
    assert bool(stage.watch.doubts.unknown) is referencing


# -- Speeds, goals, and motion that outlasts its command -------------------------------------------


def test_a_joint_is_no_faster_than_its_limit_or_the_request():
    stage = a_stage("mks")
    limit, name = stage.config.model.joint_speeds_rad_s[BASE], "base"
    per_rad = stage.world.body.transmission.matrix[BASE][BASE]

    def turn(share: float, asked: float) -> list[str]:
        stage.watch.begin(Command("jog", speed=asked))
        count = round(share * limit * WINDOW_S * per_rad)
        for number in range(3):
            stage.world.drive(steps(base=count), 10.0 + number * WINDOW_S)
        found, stage.watch.broken = stage.watch.broken, []
        return [each for each in found if name in each]

    assert not turn(1.0, 1.0)
    assert turn(1.2 * SPEED_TOLERANCE, 1.0)
    assert turn(1.0, 0.5)
    assert not turn(0.5, 0.5)


@pytest.mark.parametrize(("runs_on_s", "too_fast"), [(0.8, False), (0.1, True)])
def test_a_faster_command_may_run_on_into_the_next(runs_on_s, too_fast):
    """A board goes on with a line after its cable was pulled, while a slower call is refused."""
    stage = a_stage("mks")
    per_rad = stage.world.body.transmission.matrix[BASE][BASE]
    count = round(stage.config.model.joint_speeds_rad_s[BASE] * WINDOW_S * per_rad)
    stage.watch.begin(Command("move_j", speed=1.0))
    stage.watch.end(10.0, runs_on_s)
    stage.watch.begin(Command("move_j", speed=0.1))
    for number in range(3):
        stage.world.drive(steps(base=count), 10.0 + number * WINDOW_S)
    assert any("degrees a second" in each for each in stage.watch.broken) is too_fast


@pytest.mark.parametrize(("at_s", "unasked"), [(90.0, False), (101.0, True)])
def test_what_an_earlier_command_has_sent_may_outlast_a_later_one(at_s, unasked):
    """Mission grbl 710001049: a board homed on without its wire, after a jog that moved nothing."""
    stage = a_stage("grbl")
    stage.watch.begin(Command("home by its switches"))
    stage.watch.end(10.0, 90.0)
    stage.watch.begin(Command("a jog"))
    stage.watch.end(11.0, 0.2)
    stage.world.drive(steps(base=3), at_s)
    assert any("without a command" in each for each in stage.watch.broken) is unasked


def test_a_goal_is_missed_by_one_step_more_than_rounding():
    stage = a_stage()
    world, arm = stage.world, stage.config.model.arm
    aim = JointsAim(world.motors, {"base": world.joints[BASE] + 0.2})
    there = aim.goal(world.body.transmission)
    assert "motors [1]" in aim.missed(world, None, ())
    assert not aim.missed(world, None, {BASE})
    world.drive(there - world.motors)
    assert not aim.missed(world, None, ())
    pose = PoseAim(world.motors, arm.fk(world.joints))
    assert not pose.missed(world, None, ())
    world.drive(steps(base=1, shoulder=6))
    assert "motors [2]" in aim.missed(world, None, ())
    assert "mm from" in pose.missed(world, None, ())


def test_a_pose_is_missed_if_the_hand_points_elsewhere():
    stage = a_stage()
    world = stage.world
    pose = PoseAim(world.motors, stage.config.model.arm.fk(world.joints))
    world.drive(steps(right=12, left=-12))
    assert "hand points" in pose.missed(world, None, ())


def test_a_grasp_of_nothing_is_no_grasp():
    stage = a_stage()
    assert "hold nothing" in GraspAim().missed(stage.world, 12.0, ())


def test_a_command_that_begins_while_the_arm_stops_promises_no_range():
    stage = a_stage("grbl")
    arm = stage.connect(allow_restored=False, automatic=False)
    joints, opening_mm = stage.posture()
    arm.reference.declare(joints, opening_mm=opening_mm)
    stage.watch.begin(Command("move_j", position_known=True))
    arm.move_j(wait=False, **certain_goal(stage))
    arm.sleep(0.3)
    here = stage.look()
    call(stage, arm.stop, Command("stop", position_known=True, span=(here, here)))
    assert stage.look() != here
    assert not stage.watch.broken
    arm.close()


@pytest.mark.parametrize("variant", range(VARIANTS))
def test_the_driver_allows_the_last_goal(variant):
    for seed in range(3):
        stage = Stage("teachmover", random.Random(seed), variant)
        place_near_limits(stage)
        goal = certain_goal(stage)
        arm = stage.connect(allow_restored=False, automatic=False)
        joints, opening_mm = stage.posture()
        arm.reference.declare(joints, opening_mm=opening_mm)
        before = stage.look()
        arm.move_j(**goal)
        assert sum(map(bool, stage.look() - before)) >= 3
        arm.close()


def test_faults_strike_while_a_program_connects_and_between_programs():
    struck, wanted = set(), {"connect", "close and connect"}
    for seed in range(40):
        if wanted <= struck:
            break
        mission = Mission("teachmover", seed)
        mission.run(keep_log=True)
        act = ""
        for line in mission.log:
            words = line.split("] ", 1)[1]
            act = act if words.startswith(" ") else words
            if words.startswith("  fault") and "[no program]" in line:
                struck.add(act)
    assert wanted <= struck


def test_a_program_fault_needs_a_program():
    stage = a_stage()
    assert not stage.has_program
    stage.connect(allow_restored=False, automatic=False)
    assert stage.has_program
    stage.remove_killed_program()
    assert not stage.has_program
    assert math.isfinite(stage.now_s)


@pytest.mark.parametrize(("slips", "broken"), [(False, True), (True, False)])
def test_how_far_the_tip_moves_is_not_judged_once_a_stepper_has_slipped(slips, broken):
    stage = a_stage("grbl")
    if slips:
        stage.watch.lose_track({SHOULDER})
    stage.add_bound("a stop", 1.0, 1.0)
    stage.world.drive(steps(base=2000), stage.now_s)
    assert any("it went" in each for each in stage.watch.broken) is broken


@pytest.mark.parametrize("late_s", [0.0, 0.4])
def test_a_stop_that_may_be_the_late_message_goes_as_far_as_a_silent_program(late_s):
    """Mission mks 470000865: the adapter held up an emergency stop for 0.4 s."""
    stage = a_stage("mks")
    connect(stage)
    stage.watch.doubts.late_s = late_s
    stage.add_bound("a stop", 0.0, 0.0)
    (bound,) = stage.watch.bounds
    assert (bound.time_s > 0.0, bound.distance_mm > 0.0) == (late_s > 0.0,) * 2


def test_a_late_message_is_excused_until_it_has_come():
    stage = a_stage()
    connect(stage)
    stage.twin.faults.add("delay", 0.4, "next", side="host")
    stage.watch.doubts.late_s = 0.4
    call(stage, lambda: None)
    assert stage.watch.doubts.late_s == 0.4  # the program has sent nothing yet
    call(stage, stage.arm.stop)
    stage.sleep(5.0)
    call(stage, lambda: None)
    assert stage.watch.doubts.late_s == 0.0
