"""Commissioning: new drives come out ready, and nothing is written or turned without a yes."""

import contextlib
import math
import tomllib
from dataclasses import replace
from itertools import count

import pytest
from amounts import amount
from can_setup_bench import NAMES, READING, TURNING, Bench, arm

from armdrive.dialog import About
from armdrive.errors import BadRequest
from armdrive.setup.commissioning import ask_together, measure_units, plan_of
from armdrive.setup.dialog_runner import STOP_S, DialogClock, carry_out
from armdrive.setup.filing import propose_drives
from armdrive.tasks import (
    Alert,
    AlertKind,
    Done,
    MeasureUnits,
    RequestRejected,
    SwitchOn,
    Timeout,
)
from firmware_protocol import mks
from firmware_protocol.frames import pack

IDS = (1, 2, 3, 4, 5, 6)
PORT = "can:slcan:/dev/ttyACM0?bitrate=500000"


@pytest.fixture(scope="module")
def walked():
    """Return a bus whose six drives were new, and what came of the whole talk."""
    bench = Bench()
    before = bench.twin.world.motors
    outcome = bench.walk()
    assert bench.twin.world.motors == pytest.approx(before, abs=40)  # in counts
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
    assert bench.person.text.count("The watchdog works") == len(NAMES)
    assert set(outcome.currents_ma) == set(NAMES)
    assert all(outcome.currents_ma.values())


LINKED = """\
# mine
model = "teachmover"

# slowly
[speeds_deg_s]
base = 30
"""


def test_the_arm_file_gets_the_port_and_the_drives_and_keeps_what_it_has(walked, tmp_path):
    bench, outcome = walked
    path = tmp_path / "bench.toml"
    for before in ("", LINKED):
        path.write_text(before, encoding="utf-8")
        text = propose_drives(path, bench.plan, outcome.currents_ma, PORT).after
        read = tomllib.loads(text)
        assert read["mks"]["ids"] == list(IDS)
        assert read["connection"] == {"dialect": "mks", "port": PORT}
        assert all(line in text for line in before.splitlines() if line.startswith("#"))
    assert read["speeds_deg_s"] == {"base": 30}
    currents_ma = {**outcome.currents_ma, "base": 700}  # the section has one for all drives
    after = propose_drives(path, bench.plan, currents_ma, PORT).after
    assert "current_ma" not in tomllib.loads(after)["mks"]


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
TRIAL = {mks.Code.ENABLE, mks.Code.ABSOLUTE_AXIS}
AFTER = (
    set(),
    {mks.Code.NODE},
    {mks.Code.NODE, *SETTINGS},
    {mks.Code.NODE, *SETTINGS, *TRIAL},
)
"""What may have been said, beside readings, after so many yeses: id, settings, watchdog."""


@pytest.mark.parametrize("yeses", range(len(AFTER)))
def test_no_is_no_at_every_single_question(yeses):
    """From the first no on, only what was agreed to before has been said to drives."""
    bench = Bench(arm(ids=(2, 3, 4, 5, 6, 7)))
    met = [0]

    def sometimes() -> str:
        met[0] += 1
        return "yes" if met[0] <= yeses else "no"

    bench.person.says["It says that it is calibrated"] = "no"
    bench.person.says[About.AGREEMENT] = sometimes
    bench.walk()
    assert bench.codes() - READING == AFTER[yeses]
    assert {node for node, request in bench.said if request.code not in READING} <= {1, 2}


class Leaves(Exception):
    """Somebody has had enough."""


def leaves() -> str:
    raise Leaves


def test_a_drive_that_has_its_id_and_its_settings_is_left_alone_unless_asked_for_again():
    bench = Bench()
    bench.person.says["Try the watchdog?"] = leaves
    with pytest.raises(Leaves):
        bench.one()
    del bench.person.says["Try the watchdog?"]
    bench.said.clear()
    bench.person.asked.clear()
    current_ma = bench.one()
    assert current_ma == bench.board.nodes[1].flash.of(mks.SetCurrent).current_ma
    assert "its settings: nothing to do" in bench.person.text
    assert bench.codes() <= READING
    assert bench.person.asked == []
    assert bench.one(again=True) == current_ma
    assert "Its settings are right: mode 5" in bench.person.text
    assert "The watchdog works" in bench.person.text
    bench.board.node(1).set_mode(mks.Mode.PULSE_FOC, bench.board.now_s)
    assert bench.one()
    assert (2, mks.SetMode(mks.Mode.BUS_FOC)) in bench.said
    bench.board.nodes[1].calibrated = False
    bench.person.says["Is the shaft of the shoulder motor free"] = "no"
    assert bench.one() is None


def test_an_arm_without_such_drives_is_refused():
    from armdrive.connect.target import simulated_config

    with pytest.raises(BadRequest, match='dialect = "mks"'):
        plan_of(simulated_config("grbl"))
    with pytest.raises(BadRequest, match="6 motors"):
        plan_of(arm(ids=(1, 2, 3)))


class Executor:
    """Carries a request out: tells of these events at once, and is busy until it is stopped."""

    busy = True

    def __init__(self, *events):
        self.events, self.calls = list(events), []

    def __getattr__(self, name):
        return lambda *_, **_how: self.calls.append(name)

    def next_event(self):
        return self.events.pop(0) if self.events else None

    def next_s(self):
        return 0.0 if self.events else math.inf

    def advance(self, now_s):
        return b""


def test_after_an_alert_no_reply_counts():
    executor = Executor(Done(), Alert(AlertKind.RESTARTED, "drive 2 restarted"), Done())
    executor.advance = lambda now_s: setattr(executor, "busy", False)
    replied = carry_out(executor, None, Bench().twin.link, DialogClock())
    assert replied == RequestRejected("drive 2 restarted")


def test_a_motion_that_is_left_is_stopped_and_given_up_if_it_does_not_end():
    clock, executor = DialogClock(), Executor()
    executor.advance = lambda now_s: b"" if "stop" in executor.calls else interrupt()
    with pytest.raises(KeyboardInterrupt):
        carry_out(executor, None, Bench().twin.link, clock)
    assert [each for each in executor.calls if each != "receive"] == ["begin", "stop", "abandon"]
    assert clock.now_s() == STOP_S


@pytest.mark.parametrize(
    ("word", "replies", "asked"),
    [
        ("no", [], []),
        ("yes", [RequestRejected("a fault")], [SwitchOn]),
        ("yes", [Done(), Timeout("", 1.0)], [SwitchOn, MeasureUnits]),
    ],
)
def test_units_are_measured_after_a_yes_while_the_motors_are_on(word, replies, asked):
    bench, requests = Bench(), []
    bench.person.says["Switch the motors on"] = word

    def carry_out_next(_executor, request):
        requests.append(type(request))
        return replies[len(requests) - 1]

    dialog = replace(bench.dialog, carry_out=carry_out_next)
    assert measure_units(dialog, bench.config, None) == ()
    assert requests == asked


# Which drives are on the bus: old firmware, two at once, none, another program.


@pytest.mark.parametrize("others", amount([(0, 2, 3, 4, 5)], [(2,), (0, 2, 3, 4, 5)]))
def test_new_drives_at_once_are_found_out_and_explained(others):
    bench = Bench()
    plugged: list[int] = []

    def all_then_one() -> str:
        for motor in others:
            bench.board.node(motor).port.plugged = not plugged
        plugged.append(1)
        return "yes"

    bench.person.says["drive of the shoulder plugged"] = all_then_one
    bench.one()
    assert "More than one drive answers as id 1" in bench.person.text
    assert "plug in one new drive at a time" in bench.person.text
    assert len(plugged) == 2
    assert bench.ids() == (1, 2, 1, 1, 1, 1)


def test_a_second_new_drive_that_is_plugged_in_late_is_found_out():
    bench = Bench()
    late = bench.board.node(3).port
    bench.at_first_wait(lambda: setattr(late, "plugged", True), lambda: bench.ids()[1] == 2)
    bench.one()
    assert "Id 2 answers now, but id 1 still does" in bench.person.text


def test_a_drive_of_id_1_may_be_any_new_one_until_a_person_confirms_it():
    bench = Bench(factory=False)
    bench.board.node(0).port.plugged = True
    bench.person.says["drive of the base plugged in"] = "no"
    assert bench.one("base") is None


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
    assert bench.one() == 900
    node = bench.board.nodes[1]
    assert (node.device.node, node.flash.mode) == (2, mks.Mode.BUS_FOC)
    assert node.flash.of(mks.SetCurrent).current_ma == 900
    guarded = firmware == "1.0.9"
    assert ("The watchdog works: it stopped after" in bench.person.text) is guarded
    assert ("no watchdog (98" in bench.person.text) is not guarded
    assert "did not accept" not in bench.person.text


@pytest.mark.parametrize("firmware", amount(["1.0.9"], ["1.0.4", "1.0.9"]))
def test_a_drive_that_is_deaf_while_it_writes_a_setting_is_set_up(firmware):
    bench = Bench(firmware=firmware, flash_ms=200)
    bench.person.says["Current of the"] = "900"  # the oldest does not tell what it has
    bench.one()
    node = bench.board.nodes[1]
    assert (node.device.node, node.flash.mode) == (2, mks.Mode.BUS_FOC)
    assert "did not accept" not in bench.person.text


@pytest.mark.parametrize("factory", amount([True], [True, False]))
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


# What turns: a calibration and the watchdog's trial, and what stops them.


@pytest.mark.parametrize("word", ["no", "yes"])
def test_calibration_turns_a_motor_only_after_its_own_yes(word):
    bench = Bench()
    bench.board.nodes[1].calibrated = False
    bench.person.says["Is the shaft of the shoulder motor free"] = word
    assert bool(bench.one()) is (word == "yes")
    calibrated = [node for node, request in bench.said if isinstance(request, mks.Calibrate)]
    assert calibrated == ([2] if word == "yes" else [])
    assert ("Drive 2 is calibrated." in bench.person.text) is (word == "yes")
    assert word == "yes" or not bench.codes() & TURNING


def interrupt():
    raise KeyboardInterrupt


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


def ready_for_the_trial():
    """Return a bus on which only the shoulder's drive is, with everything but a tried watchdog."""
    bench = Bench(factory=False)
    bench.board.node(1).port.plugged = True
    bench.person.says["Calibrate it again?"] = "no"
    return bench


def test_the_trial_of_a_watchdog_turns_the_shaft_by_a_twentieth_and_back():
    bench = ready_for_the_trial()
    start, most = bench.twin.world.motors[1], [0]
    bench.at_waits(lambda: most.append(max(most.pop(), abs(bench.twin.world.motors[1] - start))))
    assert bench.one(again=True)
    assert 40 < most[0] < 16384 / 20
    assert bench.twin.world.motors[1] == pytest.approx(start, abs=40)
    assert bench.board.nodes[1].flash.of(mks.SilenceWatchdog) == mks.SilenceWatchdog(500)
    assert "may still be" not in bench.person.text


def test_a_watchdog_that_does_not_stop_the_motor_is_found_out():
    bench = ready_for_the_trial()
    node = bench.board.nodes[1]
    receive = node.receive

    def deaf_to_silence(frame, now_s):
        receive(frame, now_s)
        node.motion.heard_s = math.inf

    node.receive = deaf_to_silence
    bench.one(again=True)
    assert "The watchdog did not stop it." in bench.person.text


def deaf_to(node, *kinds):
    """Have a drive ignore these requests."""
    receive = node.receive
    node.receive = lambda frame, now_s: (
        None if isinstance(mks.decode_request(frame), kinds) else receive(frame, now_s)
    )


@pytest.mark.parametrize("kind", [mks.Enable, mks.SilenceWatchdog])
def test_a_drive_that_is_not_ready_for_the_trial_is_not_turned(kind):
    bench = ready_for_the_trial()
    bench.board.nodes[1].flash.put(mks.SilenceWatchdog(500))
    deaf_to(bench.board.nodes[1], kind)
    bench.one(again=True)
    assert "did not take part in the trial" in bench.person.text
    assert mks.Code.ABSOLUTE_AXIS not in bench.codes()


def test_a_drive_that_does_not_accept_a_setting_is_not_ready():
    bench = Bench()
    deaf_to(bench.board.nodes[1], mks.SetMode)
    assert bench.one() is None
    assert "did not accept: mode 5" in bench.person.text


def test_a_motor_that_does_not_turn_says_nothing_about_its_watchdog():
    bench = ready_for_the_trial()
    bench.twin.faults.add("stall", "shoulder")
    bench.one(again=True)
    assert "did not move at all, so the trial shows nothing" in bench.person.text


@pytest.mark.parametrize("trouble", ["interrupted", "unplugged"])
def test_a_watchdog_trial_that_is_cut_short_sets_it_back_or_tells_the_user(trouble):
    shortened = 0
    for waits in range(1, 60, amount(8, 1)):
        bench = ready_for_the_trial()
        left = count(waits, -1)

        def cut(bench=bench, left=left):
            if next(left) == 1:
                if trouble == "interrupted":
                    interrupt()
                bench.board.node(1).port.plugged = False

        bench.person.says["Try the watchdog?"] = lambda bench=bench, cut=cut: (
            bench.at_waits(cut) or "yes"
        )
        with contextlib.suppress(KeyboardInterrupt):
            bench.one(again=True)
        if (2, mks.SilenceWatchdog(100)) in bench.said:
            shortened += 1
            told = "The watchdog of drive 2 may still be at 100 ms" in bench.person.text
            bench.listen(0.1 if trouble == "interrupted" else 1.0)
            is_set = bench.board.nodes[1].flash.of(mks.SilenceWatchdog) == mks.SilenceWatchdog(500)
            assert is_set or (told and trouble == "unplugged")
            assert not bench.board.nodes[1].motor.point.moving(bench.clock.now_s())
    assert shortened > 2


@pytest.mark.parametrize("seed", range(amount(1, 20)))
def test_lost_frames_leave_no_drive_with_the_short_time_unsaid(seed):
    bench = Bench()
    bench.twin.faults.add("drop", 0.04, seed=seed)
    bench.one()
    assert bench.ids()[1] == 2
    is_set = bench.board.nodes[1].flash.of(mks.SilenceWatchdog) == mks.SilenceWatchdog(500)
    assert is_set or "may still be at 100 ms" in bench.person.text
