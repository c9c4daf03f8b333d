"""Commissioning, what turns: small motions, what is seen of them, and what stops them."""

from __future__ import annotations

import math

import pytest
from can_setup_bench import TURNING, Bench, really

from armdrive.dialects.bus.tools import DrivePlace
from armdrive.dialog.conversation import About
from armdrive.setup.commissioning import TriedMotor
from armdrive.setup.directions import NOTHING, OTHER
from firmware_protocol.mks import COUNTS_PER_TURN, Calibrate, EmergencyStop, MoveAbsoluteAxis


def test_ctrl_c_in_motion_stops_the_motor():
    bench = Bench()
    sleep, end = bench.clock.sleep, []

    def interrupted(link, until_s):
        if not end and any(isinstance(each, MoveAbsoluteAxis) for _, each in bench.said):
            end.append(bench.clock.now_s())
            raise KeyboardInterrupt
        sleep(link, until_s)

    bench.clock.sleep = interrupted
    with pytest.raises(KeyboardInterrupt):
        bench.one()
    assert (2, EmergencyStop()) in bench.said[-9:]
    moved = abs(bench.twin.world.motors[1] - bench.plan.drives[1].trial.steps)
    bench.listen(1.0)
    assert not any(node.motor.point.moving(bench.clock.now_s()) for node in bench.board.nodes)
    assert abs(bench.twin.world.motors[1] - bench.plan.drives[1].trial.steps) == moved


@pytest.mark.parametrize("seed", range(5))
def test_lost_frames_turn_nothing_farther_than_was_announced(seed):
    bench = Bench()
    bench.twin.faults.add("lose-frame", 0.04, seed=seed)
    most, sleep = [0], bench.clock.sleep

    def watched(link, until_s):
        sleep(link, until_s)
        off = [abs(now - was) for now, was in zip(bench.twin.world.motors, start, strict=True)]
        most[0] = max(most[0], *off)

    bench.clock.sleep = watched
    for _ in range(2):  # a trial that was broken off is not where it began
        start = bench.twin.world.motors
        bench.one()
    assert bench.ids()[1] == 2
    assert most[0] <= abs(bench.plan.drives[1].trial.steps) + 2


def test_a_gear_that_is_believed_ten_times_too_high_shows_at_the_first_small_motion():
    bench = Bench(truth=really(gears=(1.0, 0.1, 1.0, 1.0, 1.0, 1.0)))
    start, most = bench.twin.world.joints[1], [0.0]
    sleep = bench.clock.sleep

    def watched(link, until_s):
        sleep(link, until_s)
        most[0] = max(most[0], abs(bench.twin.world.joints[1] - start))

    bench.clock.sleep = watched
    assert bench.one()
    assert bench.kept["shoulder"].gear == pytest.approx(5.0, rel=0.05)
    assert most[0] < 0.12  # rad: what was announced, or an eighth of it ten times


def test_a_gear_that_is_off_by_two_is_corrected_by_what_was_measured():
    bench = Bench(truth=really(gears=(1.0, 0.5, 1.0, 1.0, 1.0, 1.0)))
    assert bench.one()
    assert bench.kept["shoulder"].gear == pytest.approx(25.0, rel=0.02)
    bench = Bench()
    assert bench.one("gripper")
    assert bench.kept["gripper"].gear == bench.plan.drives[5].gear  # to the last digit


@pytest.mark.parametrize(
    ("word", "told"), [(NOTHING, "sits firmly"), (OTHER, "Exchange the cables")]
)
def test_a_motor_of_which_nothing_was_seen_is_left_for_later(word, told):
    bench = Bench()
    bench.person.says[About.WAY] = word
    assert not bench.one()
    assert told in bench.person.text
    assert not bench.kept["shoulder"].way


def test_what_was_not_seen_well_is_shown_again():
    bench = Bench()
    words = iter(["again", "out"])
    bench.person.says[About.WAY] = lambda: next(words)
    assert bench.one()
    assert bench.kept["shoulder"].way == "out"


def test_a_blocked_motor_ends_its_trial_and_says_where_it_stands():
    bench = Bench(stall_protection=False)
    bench.twin.faults.add("stall", "shoulder")
    assert not bench.one()
    assert "where it should not" in bench.person.text


@pytest.mark.parametrize("word", ["no", "yes"])
def test_calibration_turns_a_motor_only_after_its_own_yes(word):
    bench = Bench()
    bench.board.nodes[1].calibrated = False
    bench.person.says["Is the shaft of the shoulder motor free"] = word
    bench.one()
    calibrated = [node for node, request in bench.said if isinstance(request, Calibrate)]
    assert calibrated == ([2] if word == "yes" else [])
    assert ("Drive 2 is calibrated." in bench.person.text) is (word == "yes")


def test_ctrl_c_stops_a_motor_that_is_calibrated():
    bench = Bench()
    node = bench.board.nodes[1]
    node.calibrated = False
    sleep = bench.clock.sleep

    def interrupted(link, until_s):
        if node.motion.searching:
            bench.clock.sleep = sleep
            raise KeyboardInterrupt
        sleep(link, until_s)

    bench.clock.sleep = interrupted
    with pytest.raises(KeyboardInterrupt):
        bench.one()
    assert bench.said[-3:] == [(2, EmergencyStop())] * 3
    bench.listen(0.1)
    assert not node.motion.searching


def test_a_motor_is_turned_by_the_controller_which_finds_a_drive_that_restarts():
    bench = Bench()
    node = bench.board.nodes[1]

    def restarts():
        node.restart(bench.clock.now_s())
        bench.listen(1.0)
        return "out"

    bench.person.says["Which way did it go?"] = restarts
    assert not bench.one()
    assert "was reset or lost its power" in bench.person.text


def test_a_motor_is_not_sent_back_by_more_than_it_was_sent():
    bench = Bench()
    motor = TriedMotor(bench.plan.controller(at_hand(bench).by_itself), COUNTS_PER_TURN)
    assert bench.run(motor.switch_on())
    bench.said.clear()
    told = bench.run(motor.turn_to(3000, 1000))
    assert "stands at 0 counts, too far from 3000" in told
    assert not bench.codes() & TURNING


def at_hand(bench):
    """Return the drive of the shoulder, set up."""
    assert bench.one()
    place = DrivePlace(1, "shoulder", 2)
    return bench.run(bench.plan.tools.arrive(bench.config, place, False))


def test_a_watchdog_that_does_not_stop_the_motor_is_found_out():
    bench = Bench()
    node = bench.board.nodes[1]
    bench.person.says["Try the watchdog?"] = lambda: deafen() or "yes"
    hear = node.hear

    def deafen():
        node.motion.heard_s = math.inf

    def deaf_to_silence(frame, now_s):
        hear(frame, now_s)
        deafen()

    node.hear = deaf_to_silence
    bench.one()
    assert "The watchdog did not stop it." in bench.person.text
    assert bench.kept["shoulder"].watchdog is False
