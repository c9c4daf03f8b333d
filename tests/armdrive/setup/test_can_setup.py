"""Commissioning: new drives come out ready, and nothing is written or turned without a yes."""

import contextlib
import math
import tomllib
from dataclasses import replace
from itertools import count

import pytest
from amounts import amount
from can_setup_bench import NAMES, READING, TURNING, Bench, arm, arm_as_built

from armdrive.dialects.bus.tools import DrivePlace
from armdrive.dialog import About
from armdrive.errors import BadRequest
from armdrive.registry.arm_files import parse_arm
from armdrive.setup.commissioning import TriedMotor, ask_together
from armdrive.setup.directions import NOTHING, OTHER
from armdrive.setup.filing import commissioned, new_text, signs_of
from armdrive.setup.plan import Notes, plan_of
from firmware_protocol import mks
from firmware_protocol.frames import pack

IDS = (1, 2, 3, 4, 5, 6)


SIGNS = (1, -1, 1, 1, -1, -1)
TRUTH = arm_as_built(SIGNS, (1.0, 2.0, 1.0, 1.0, 1.0, 1.0))


@pytest.fixture(scope="module")
def walked():
    """Return a bus whose six drives were new, and what came of the whole talk."""
    bench = Bench(truth=TRUTH)
    before = bench.twin.world.motors
    outcome = bench.walk()
    assert bench.twin.world.motors == before  # every motor is back where it was
    return bench, outcome


def test_new_drives_come_out_with_ids_settings_and_a_watchdog_that_was_seen_to_work(walked):
    bench, outcome = walked
    assert outcome.finished
    assert bench.ids() == IDS
    for node in bench.board.nodes:
        assert node.flash.mode is mks.Mode.BUS_FOC
        assert node.flash.of(mks.SetReplies).mode is mks.ReplyMode.FULL
        assert node.flash.of(mks.SilenceWatchdog).timeout_ms == 500
        assert node.motion.watchdog_stops == 1
    assert set(outcome.notes) == set(NAMES)
    assert all(each.done and each.watchdog for each in outcome.notes.values())


def test_directions_are_found_by_looking(walked):
    bench, outcome = walked
    found = signs_of(bench.plan, outcome.notes)
    reversed_ones = [name for name, sign in zip(NAMES, SIGNS, strict=True) if sign < 0]
    assert sorted(found.motors) == sorted(reversed_ones)
    assert found.joints == found.unclear == ()


def test_the_arm_file_that_comes_of_it_is_the_arm_as_it_is_built(walked):
    bench, outcome = walked
    port = "can:slcan:/dev/ttyACM0?bitrate=500000"
    text = commissioned(new_text(bench.config), bench.config, bench.plan, outcome.notes, port)
    read = tomllib.loads(text)
    assert read["mks"]["ids"] == list(IDS)
    assert read["connection"] == {"dialect": "mks", "port": port}
    assert read["motor_signs"] == {"shoulder": -1, "left wrist": -1, "gripper": -1}
    built = parse_arm(read, name="bench").model.transmission
    for is_so, found in zip(TRUTH.transmission.motors, built.motors, strict=True):
        assert found.steps_per_unit == pytest.approx(is_so.steps_per_unit, rel=0.01)
        assert found.sees == is_so.sees


LINKED = """\
# mine
model = "models/a.toml"

# in the controller's order
[[motors]]
name = "base"
steps_per_turn = 1
sees = { base = 1 }

[[motors]]
name = "shoulder"
steps_per_turn = 1
sees = { shoulder = 1, elbow = -1 }

[[motors]]
name = "gripper"
steps_per_mm = 1

# slowly
[speeds_deg_s]
base = 30
"""


def test_an_arm_of_a_link_table_gets_its_numbers_where_its_motors_are(walked):
    bench, outcome = walked
    text = commissioned(LINKED, bench.config, bench.plan, outcome.notes, "")
    read = tomllib.loads(text)
    assert all(line in text for line in LINKED.splitlines() if line.startswith("#"))
    assert read["speeds_deg_s"] == {"base": 30}
    base, shoulder, gripper = read["motors"]
    assert base == {"name": "base", "steps_per_turn": 50 * 16384, "sees": {"base": 1}}
    assert shoulder["sees"] == {"shoulder": -1, "elbow": 1}
    assert shoulder["steps_per_turn"] == pytest.approx(100 * 16384, rel=0.01)
    assert gripper["steps_per_mm"] == 2400


def test_after_no_to_every_question_nothing_is_written_or_turned():
    bench = Bench()
    bench.person.says[About.AGREEMENT] = bench.person.says[About.CONNECT] = "no"
    flashes, motors = bench.flashes(), bench.twin.world.motors
    outcome = bench.walk()
    assert sorted(outcome.left_out) == sorted(NAMES)
    assert bench.codes() <= READING
    assert bench.flashes() == flashes
    assert bench.twin.world.motors == motors


SETTINGS = {mks.Code.MODE, mks.Code.WATCHDOG}
CURRENT = {mks.Code.ENABLE}
"""Whoever switches a motor on sees to it that its orders are not kept for a common start."""
AFTER = (
    set(),
    {mks.Code.NODE},
    {mks.Code.NODE, *SETTINGS},
    {mks.Code.NODE, *SETTINGS},
    {mks.Code.NODE, *SETTINGS, *CURRENT},
    {mks.Code.NODE, *SETTINGS, *CURRENT, mks.Code.ABSOLUTE_AXIS},
    {mks.Code.NODE, *SETTINGS, *CURRENT, mks.Code.ABSOLUTE_AXIS},
)
"""What may have been said, beside readings, after so many yeses: id, settings, built in, current,
the smallest motion, the trial."""


@pytest.mark.parametrize("yeses", range(len(AFTER)))
def test_no_is_no_at_every_single_question(yeses):
    """From the first no on, only what was agreed to before has been said to drives."""
    bench = Bench(arm(ids=(2, 3, 4, 5, 6, 7)))
    met = [0]

    def sometimes() -> str:
        met[0] += 1
        return "yes" if met[0] <= yeses else "no"

    bench.person.says["It says that it is calibrated"] = "no"
    for kind in (About.AGREEMENT, About.MOUNTED):
        bench.person.says[kind] = sometimes
    bench.walk()
    assert bench.codes() - READING == AFTER[yeses]
    assert {node for node, request in bench.said if request.code not in READING} <= {1, 2}


class Leaves(Exception):
    """Somebody has had enough."""


def leaves() -> str:
    raise Leaves


def test_a_setup_that_was_left_in_the_middle_resumes_there():
    bench = Bench()
    bench.person.says["Try the watchdog?"] = leaves
    with pytest.raises(Leaves):
        bench.one()
    del bench.person.says["Try the watchdog?"]
    bench.said.clear()
    bench.person.asked.clear()
    assert bench.one()
    words = [ask.question.words for ask in bench.person.asked]
    assert not any("plugged in" in each or "Write" in each or "Which way" in each for each in words)
    assert any("Try the watchdog?" in each for each in words)
    assert bench.kept["shoulder"].way
    assert mks.SetId(2) not in [request for _, request in bench.said]
    bench.said.clear()
    assert bench.one()
    assert "its settings: nothing to do" in bench.person.text
    assert bench.codes() <= READING


@pytest.mark.parametrize("question", ["Was that about", "Which way did it go?", "How far did"])
def test_leaving_while_a_motor_is_away_says_that_it_was_not_turned_back(question):
    bench = Bench()
    bench.person.says[question] = leaves
    with pytest.raises(Leaves):
        bench.one()
    assert bench.person.heard[-1] == "The shoulder motor was not turned back to where it began."


def test_finished_steps_are_listed_at_the_beginning():
    bench = Bench()
    bench.person.says[About.CONNECT] = bench.person.says[About.AGREEMENT] = "no"
    bench.walk({"elbow": Notes(done=True)})
    assert "Done in an earlier run: elbow" in bench.person.text


def test_a_drive_that_was_done_and_has_lost_its_mode_is_set_up_once_more():
    bench = Bench(factory=False)
    bench.board.node(2).port.plugged = True
    bench.board.node(2).set_mode(mks.Mode.PULSE_FOC, bench.board.now_s)
    bench.kept["elbow"] = Notes(done=True, watchdog=True)
    assert bench.one("elbow")
    assert (3, mks.SetMode(mks.Mode.BUS_FOC)) in bench.said
    assert not bench.codes() & TURNING


def test_an_arm_without_such_drives_is_refused():
    from armdrive.connect.target import simulated_config

    with pytest.raises(BadRequest, match='dialect = "mks"'):
        plan_of(simulated_config("grbl"))
    with pytest.raises(BadRequest, match="6 motors"):
        plan_of(arm(ids=(1, 2, 3)))


# Which drives are on the bus: old firmware, two at once, none, another program.


@pytest.mark.parametrize("others", [(2,), (0, 2, 3, 4, 5)])
def test_new_drives_at_once_are_found_out_and_explained(others):
    bench = Bench()
    plugged: list[int] = []

    def all_then_one() -> str:
        for motor in others:
            bench.board.node(motor).port.plugged = not plugged
        plugged.append(1)
        return "yes"

    bench.person.says["drive of the shoulder plugged"] = all_then_one
    bench.set_up()
    assert "More than one drive answers as id 1" in bench.person.text
    assert "plug in one new drive at a time" in bench.person.text
    assert len(plugged) == 2
    assert bench.ids() == (1, 2, 1, 1, 1, 1)


def test_a_second_new_drive_that_speaks_up_once_the_id_was_given_is_told_of():
    bench = Bench()
    taken, put = bench.board.nodes[1].flash, []

    def plug_another(data: bytes, now_s: float) -> None:
        if taken.of(mks.SetId).node == 2 and not put:
            bench.board.node(0).port.plugged = True
            put.append(1)
        send(data, now_s)

    send, bench.twin.link.line.send = bench.twin.link.line.send, plug_another
    turns = iter(["yes", "no"])
    bench.person.says["drive of the shoulder plugged"] = lambda: next(turns)
    assert not bench.one()
    assert "but id 1 still does as well" in bench.person.text


def test_a_drive_without_power_is_looked_for_with_what_to_check():
    bench = Bench()
    bench.twin.faults.add("drive-dead", "shoulder")
    turns = iter(["yes", "no"])
    bench.person.says["drive of the shoulder plugged"] = lambda: next(turns)
    assert not bench.one()
    assert "motor supply" in bench.person.text
    assert "120 ohm" in bench.person.text


def test_in_the_end_all_drives_are_queried_and_missing_ones_are_named():
    bench = Bench(factory=False)
    for motor in (0, 1, 2, 3, 5):
        bench.board.node(motor).port.plugged = True
    answers = iter(["yes", "no"])
    bench.person.says["in all? Then they are asked"] = lambda: next(answers)
    missing = ask_together(bench.dialog, bench.plan)
    assert "Not there, or two drives with one id: left wrist (drive 5)" in bench.person.text
    assert missing == NAMES


@pytest.mark.parametrize("firmware", ["1.0.4", "1.0.8", "1.0.9"])
def test_every_firmware_is_set_up_as_far_as_it_goes(firmware):
    bench = Bench(firmware=firmware)
    bench.person.says["Current of the"] = "900"  # the oldest does not tell what it has
    assert bench.one()
    node = bench.board.nodes[1]
    assert (node.device.node, node.flash.mode) == (2, mks.Mode.BUS_FOC)
    assert node.flash.of(mks.SetCurrent).current_ma == 900
    guarded = bench.kept["shoulder"].watchdog is True
    assert guarded is (firmware == "1.0.9")
    assert ("no watchdog (98" in bench.person.text) is not guarded


def test_a_drive_that_answers_its_new_id_by_the_old_one_is_no_trouble():
    bench = Bench(new_id_answers=False)
    bench.set_up()
    assert bench.ids()[1] == 2


def test_a_drive_far_from_its_zero_is_offered_a_new_one():
    bench = Bench()
    bench.board.nodes[1].motor.zero -= 3_000_000
    bench.set_up()
    assert any(request.code is mks.Code.ZERO and node == 2 for node, request in bench.said)
    assert abs(bench.board.nodes[1].motor.counts) < 1000


def test_a_drive_whose_reading_ignores_its_new_zero_is_to_be_switched_off():
    bench = Bench(keeps_count=True)
    motor = bench.board.nodes[1].motor
    bench.board.nodes[1].power_on_zero = motor.zero = motor.zero - 3_000_000
    bench.set_up()
    assert "its reading did not become 0" in bench.person.text


@pytest.mark.parametrize("firmware", ["1.0.4", "1.0.9"])
def test_a_drive_that_is_deaf_while_it_writes_a_setting_is_set_up(firmware):
    bench = Bench(firmware=firmware, flash_ms=200)
    bench.person.says["Current of the"] = "900"  # the oldest does not tell what it has
    bench.set_up()
    node = bench.board.nodes[1]
    assert (node.device.node, node.flash.mode) == (2, mks.Mode.BUS_FOC)
    assert "did not accept" not in bench.person.text


@pytest.mark.parametrize("factory", [True, False], ids=["new", "with its id"])
def test_a_drive_of_the_e_series_is_named_and_nothing_is_written(factory):
    bench = Bench(e_series=True, factory=factory)
    bench.person.says["plugged in"] = iter(("yes", "no")).__next__
    assert not bench.one()
    assert "E series" in bench.person.text
    assert not [each for _, each in bench.said if isinstance(each, mks.Setting)]


def test_no_drive_is_queried_while_another_program_commands_drives():
    bench, spoken = Bench(), pack(mks.encode(2, mks.ReadEncoder()))
    bench.at_first_wait(lambda: bench.twin.link.line.say(spoken, 0.0))
    outcome = bench.walk()
    assert outcome.left_out == NAMES
    assert bench.said == bench.person.asked == []
    assert "Another program commands drives" in bench.person.text


# What turns: small motions, what is seen of them, and what stops them.


def test_ctrl_c_in_motion_stops_the_motor():
    bench = Bench()
    bench.at_first_wait(
        interrupt,
        lambda: any(isinstance(each, mks.MoveAbsoluteAxis) for _, each in bench.said),
    )
    with pytest.raises(KeyboardInterrupt):
        bench.one()
    assert (2, mks.EmergencyStop()) in bench.said[-9:]
    moved = abs(bench.twin.world.motors[1] - bench.plan.drives[1].trial.steps)
    bench.listen(1.0)
    assert not any(node.motor.point.moving(bench.clock.now_s()) for node in bench.board.nodes)
    assert abs(bench.twin.world.motors[1] - bench.plan.drives[1].trial.steps) == moved


@pytest.mark.parametrize("seed", range(amount(2, 20)))
def test_lost_frames_turn_nothing_farther_than_was_announced(seed):
    bench = Bench()
    bench.twin.faults.add("drop", 0.04, seed=seed)
    most, start = [0], bench.twin.world.motors

    def watched():
        off = [abs(now - was) for now, was in zip(bench.twin.world.motors, start, strict=True)]
        most[0] = max(most[0], *off)

    bench.at_waits(watched)
    for _ in range(2):  # a trial that was broken off is not where it began
        start = bench.twin.world.motors
        bench.one()
    assert bench.ids()[1] == 2
    assert most[0] <= abs(bench.plan.drives[1].trial.steps) + 2


def test_a_gear_that_is_believed_ten_times_too_high_shows_at_the_first_small_motion():
    bench = Bench(truth=arm_as_built(gears=(1.0, 0.1, 1.0, 1.0, 1.0, 1.0)))
    start, most = bench.twin.world.joints[1], [0.0]

    def watched():
        most[0] = max(most[0], abs(bench.twin.world.joints[1] - start))

    bench.at_waits(watched)
    assert bench.one()
    assert bench.kept["shoulder"].gear == pytest.approx(5.0, rel=0.05)
    assert most[0] < 0.12  # rad: what was announced, or an eighth of it ten times


def test_a_gear_that_is_off_by_two_is_corrected_by_what_was_measured():
    bench = Bench(truth=arm_as_built(gears=(1.0, 0.5, 1.0, 1.0, 1.0, 1.0)))
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


def test_a_motion_can_be_shown_again():
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
    bench.set_up()
    calibrated = [node for node, request in bench.said if isinstance(request, mks.Calibrate)]
    assert calibrated == ([2] if word == "yes" else [])
    assert ("Drive 2 is calibrated." in bench.person.text) is (word == "yes")


def test_ctrl_c_stops_a_motor_that_is_calibrated():
    bench = Bench()
    node = bench.board.nodes[1]
    node.calibrated = False
    bench.at_first_wait(interrupt, lambda: node.motion.searching)
    with pytest.raises(KeyboardInterrupt):
        bench.one()
    assert bench.said[-3:] == [(2, mks.EmergencyStop())] * 3
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
    controller = bench.plan.controller(at_hand(bench).by_itself)
    motor = TriedMotor(bench.dialog, controller, mks.COUNTS_PER_TURN)
    assert motor.switch_on()
    bench.said.clear()
    told = motor.turn_to(3000, 1000)
    assert "stands at 0 counts, too far from 3000" in told
    assert not bench.codes() & TURNING


def at_hand(bench):
    """Return the drive of the shoulder, set up."""
    bench.set_up()
    place = DrivePlace(1, "shoulder", 2)
    return bench.plan.tools.arrive(bench.dialog, bench.config, place, False)


def test_a_watchdog_that_does_not_stop_the_motor_is_found_out():
    bench = Bench()
    node = bench.board.nodes[1]
    bench.person.says["Try the watchdog?"] = lambda: deafen() or "yes"
    receive = node.receive

    def deafen():
        node.motion.heard_s = math.inf

    def deaf_to_silence(frame, now_s):
        receive(frame, now_s)
        deafen()

    node.receive = deaf_to_silence
    bench.one()
    assert "The watchdog did not stop it." in bench.person.text
    assert bench.kept["shoulder"].watchdog is False


def interrupt(_bench=None):
    raise KeyboardInterrupt


def unplug(bench):
    bench.board.node(1).port.plugged = False


@pytest.fixture(scope="module")
def untried():
    """Return the notes about a shoulder of which only the watchdog was not tried."""
    bench = Bench()
    bench.person.says["Try the watchdog?"] = "no"
    bench.one()
    return replace(bench.kept["shoulder"], done=False)


@pytest.mark.parametrize("trouble", [interrupt, unplug])
def test_a_watchdog_trial_that_is_cut_short_sets_it_back_or_tells_the_user(untried, trouble):
    shortened, told = 0, 0
    for waits in range(1, 70, 6):
        bench = Bench(factory=False)
        bench.board.node(1).port.plugged = True
        bench.kept["shoulder"] = replace(untried)
        left = count(waits, -1)

        def yes(bench=bench, left=left):
            bench.at_waits(lambda: next(left) == 1 and trouble(bench))
            return "yes"

        bench.person.says["Try the watchdog?"] = yes
        with contextlib.suppress(KeyboardInterrupt):
            bench.one()
        if (2, mks.SilenceWatchdog(100)) in bench.said:
            shortened += not bench.kept["shoulder"].watchdog
            is_told = "The watchdog of drive 2 may still be at 100 ms" in bench.person.text
            is_set = bench.board.nodes[1].flash.of(mks.SilenceWatchdog) == mks.SilenceWatchdog(500)
            assert is_set or is_told
            told += is_told
    assert shortened > 2
    assert bool(told) is (trouble is unplug)
