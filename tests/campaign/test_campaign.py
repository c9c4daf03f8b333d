"""A sample of the campaign, its repeatability, and faulty drivers that it has to find."""

import math
import random
from dataclasses import replace

import pytest
from amounts import amount

from armdrive.arm.moving import Gripper
from armdrive.connect.runner import TaskRunner
from armdrive.dialects.bus import phases
from armdrive.dialects.bus.phases import Phase, Signal
from armdrive.dialects.mks import contact
from armdrive.errors import OutOfBounds
from armdrive.motion import execute as motion
from armdrive.motion import gripper as gripping
from armdrive.motion import jog as held_jog
from armdrive.motion import jog as jog_aims
from armdrive.motion import jog as jogging
from armdrive.motion import plan as planning
from armdrive.motion.deviation import Corridor
from armdrive.registry import DIALECTS
from armdrive.runtime.arm_state import Core
from armdrive.runtime.overrides import SpeedOverride
from armdrive.runtime.states import Belief
from armdrive.runtime.stop_bounds import StopForecast
from armdrive.sim.grbl.firmware import FIRMWARES
from armdrive.status import Evidence
from kinematics.paths.timing import MotionLimits

from . import mission
from .actions import ACTIONS
from .faults import FAULTS
from .mission import Outcome, Result, run_mission
from .run import main, story, table_of, tasks
from .stage import Stage
from .switches import SETTINGS

SAMPLE = {"mks": 2, "cia402": 2, "teachmover": 8}
"""Missions of an everyday run; 4 of those that take neither so long nor so little."""
HOMING_SAMPLE = {"mks": 1, "cia402": 1}
"""The same for arms that home, whose drives seek their switches for half a minute each time."""
ENOUGH = 60
"""This many missions find each of the faulty drivers below."""


@pytest.mark.parametrize("dialect", DIALECTS)
def test_no_promise_is_broken_in_a_sample(dialect):
    for seed in range(amount(SAMPLE.get(dialect, 4), 25)):
        result = run_mission(dialect, seed)
        assert result.outcome is not Outcome.VIOLATION, story(result)


def test_a_motor_turned_while_a_program_connects_is_judged_by_the_next_poll():
    """Over a slow wire, a hand turns a motor after connecting has read the position."""
    result = run_mission("grbl", 651000660)
    assert result.outcome is not Outcome.VIOLATION, story(result)


def test_every_grbl_firmware_takes_part():
    stages = (Stage("grbl", random.Random(seed)) for seed in range(30))
    assert {stage.twin.board.firmware.name for stage in stages} == set(FIRMWARES)


@pytest.mark.parametrize("dialect", ["grbl", "mks"])  # one with a board of its own, one on a bus
def test_a_seed_repeats_its_mission(dialect):
    first, second = (run_mission(dialect, 0, keep_log=True) for _ in range(2))
    assert first == second
    assert first.log


def found_by_the_campaign(dialect="teachmover", first=0):
    """Return the violations of the first mission that has any; empty if none has.

    `first` is the seed that found the faulty driver when the test was written.
    """
    results = (run_mission(dialect, seed) for seed in range(first, first + ENOUGH))
    return "; ".join(next((each.broken for each in results if each.broken), ()))


def test_a_driver_without_an_audit_is_found_out(monkeypatch):
    monkeypatch.setattr(planning, "audit", lambda *_: None)
    monkeypatch.setattr(jog_aims, "audit", lambda *_: None)
    assert found_by_the_campaign(first=10)


def test_limits_that_are_three_degrees_too_wide_are_found_out(monkeypatch):
    monkeypatch.setattr(planning, "SLACK_RAD", math.radians(3.0))
    assert "beyond its limit" in found_by_the_campaign(first=10)


def test_a_speed_override_that_is_ignored_is_found_out(monkeypatch):
    only(monkeypatch, "pause")
    monkeypatch.setattr(SpeedOverride, "slowed_s", lambda _, duration_s: duration_s)
    assert "degrees a second" in found_by_the_campaign("grbl", first=2)


def test_a_jog_that_is_clipped_and_does_not_say_so_is_found_out(monkeypatch):
    only(monkeypatch, "jog by an increment")
    monkeypatch.setattr(jogging, "show_end", lambda *_: None)
    assert "ended well, but" in found_by_the_campaign(first=1)


def test_a_driver_that_sends_all_at_once_is_found_out(monkeypatch):
    monkeypatch.setattr(motion, "next_share", lambda _context, _leg, _burst_s, done: 1.0 - done)
    assert found_by_the_campaign(first=4)


def ignoring(monkeypatch, *ignored):
    """Make the driver ignore these kinds of evidence."""
    after = Belief.after

    def trusting(self, evidence, now_s, detail=""):
        return self if evidence in ignored else after(self, evidence, now_s, detail)

    monkeypatch.setattr(Belief, "after", trusting)


def test_a_driver_that_keeps_its_trust_is_found_out(monkeypatch):
    ignoring(monkeypatch, Evidence.ANSWER_LOST, Evidence.READ_BACK_DIFFERS, Evidence.SILENT)
    assert found_by_the_campaign(first=27)


@pytest.mark.parametrize(("dialect", "first"), [("teachmover", 6), ("robko01", 8)])
def test_a_driver_that_trusts_a_board_that_was_reset_is_found_out(monkeypatch, dialect, first):
    ignoring(monkeypatch, Evidence.RESTARTED, Evidence.CONTROLLER_RESTARTED, Evidence.SILENT)
    index = next(i for i, each in enumerate(FAULTS) if each.name == "brown-out")
    monkeypatch.setattr(mission.Mission, "_fault", lambda _: index)
    assert found_by_the_campaign(dialect, first)


DRIVES_LEGS = (motion, jogging, gripping)
"""Every module that calls `drive_legs`."""


def with_legs(monkeypatch, change):
    """Make each motion drive other legs than planned, and report success all the same."""
    drive_legs = motion.drive_legs

    def drive(context, legs, burst_s, *, released=None):
        yield from drive_legs(context, change(context, legs), burst_s, released=released)

    for module in DRIVES_LEGS:
        monkeypatch.setattr(module, "drive_legs", drive)


def half(legs):
    whole = legs[: len(legs) // 2]
    if whole or not legs:
        return whole
    (leg,) = legs
    return (replace(leg, end=leg.start.towards(leg.end, 0.5)),)


@pytest.mark.parametrize("dialect", ["teachmover", "mks"])
def test_motions_that_do_nothing_are_found_out(monkeypatch, dialect):
    with_legs(monkeypatch, lambda _context, _legs: ())
    assert "ended well, but" in found_by_the_campaign(dialect)


def test_motions_that_go_half_way_are_found_out(monkeypatch):
    with_legs(monkeypatch, lambda _context, legs: half(legs))
    assert "ended well, but" in found_by_the_campaign()


def test_jogs_that_do_nothing_are_found_out(monkeypatch):
    only(monkeypatch, "jog by an increment")
    monkeypatch.setattr(jogging, "drive_legs", lambda *_, **__: iter(()))
    assert "ended well, but" in found_by_the_campaign()


def test_a_grasp_that_does_nothing_is_found_out(monkeypatch):
    only(monkeypatch, "gripper")
    monkeypatch.setattr(Gripper, "grasp", lambda *_, **__: 0.0)
    assert "hold nothing" in found_by_the_campaign()


def only(monkeypatch, action):
    """Make missions draw one action only."""
    monkeypatch.setattr(mission, "ACTIONS", {action: ACTIONS[action]})
    monkeypatch.setattr(mission, "HOMING_ACTIONS", {})


def test_a_grasp_that_measures_wrongly_is_found_out(monkeypatch):
    only(monkeypatch, "gripper")
    grasp = Gripper.grasp
    monkeypatch.setattr(Gripper, "grasp", lambda self, **words: grasp(self, **words) + 3.0)
    assert "between the fingers" in found_by_the_campaign(first=3)


def test_an_arm_that_is_recovered_and_never_moves_is_found_out(monkeypatch):
    faulty, fault = set(), Core.fault

    def remembered(self, *words):
        faulty.add(id(self))
        fault(self, *words)

    monkeypatch.setattr(Core, "fault", remembered)
    with_legs(monkeypatch, lambda context, legs: () if id(context.core) in faulty else legs)
    assert "ended well, but" in found_by_the_campaign(first=5)


def test_a_final_motion_that_is_refused_is_found_out(monkeypatch):
    def refuse(*_):
        raise OutOfBounds("no", name="base", value=1.0, bound=0.0)

    monkeypatch.setattr(planning, "audit", refuse)
    assert "nothing forbids was refused" in found_by_the_campaign()


@pytest.mark.parametrize(
    ("dialect", "more_s"), [("teachmover", 0.6), ("grbl", math.inf), ("mks", 0.6)]
)
def test_a_hold_that_expires_late_or_never_is_found_out(monkeypatch, dialect, more_s):
    def held(context):
        hold = context.core.hold
        return hold is not None and hold.until_s + more_s > context.now_s

    only(monkeypatch, "abandon a hold")
    for module in (held_jog, jogging):
        monkeypatch.setattr(module, "is_held", held)
    assert "an abandoned hold expired" in found_by_the_campaign(dialect)


def test_a_stop_that_is_ignored_is_found_out(monkeypatch):
    monkeypatch.setattr(TaskRunner, "request_stop", lambda *_, **__: None)
    assert "stop" in found_by_the_campaign("grbl", first=3)


def homing_only(monkeypatch):
    """Make all arms of these missions home by their switches, and do nothing else."""
    monkeypatch.setattr(mission, "HOMING_SHARE", 1.0)
    monkeypatch.setattr(mission, "ACTIONS", {})


@pytest.mark.parametrize("dialect", SETTINGS)
def test_no_promise_is_broken_by_arms_that_home(monkeypatch, dialect):
    homing_only(monkeypatch)
    for seed in range(amount(HOMING_SAMPLE.get(dialect, 4), 25)):
        result = run_mission(dialect, seed)
        assert result.outcome is not Outcome.VIOLATION, story(result)


def test_a_driver_that_trusts_an_arm_whose_homing_failed_is_found_out(monkeypatch):
    homing_only(monkeypatch)
    ignoring(monkeypatch, Evidence.HOMING_FAILED)
    assert "but the motors stand at" in found_by_the_campaign("mks")


def test_a_bound_that_does_not_cover_homing_is_found_out(monkeypatch):
    homing_only(monkeypatch)
    monkeypatch.setattr(StopForecast, "home", lambda *_: None)
    assert "it moved" in found_by_the_campaign("grbl", first=21)


def test_homing_that_a_stop_does_not_end_is_found_out(monkeypatch):
    homing_only(monkeypatch)
    rows = {each: row for each, row in phases.TABLE.items() if each != (Phase.HOMING, Signal.STOP)}
    monkeypatch.setattr(phases, "TABLE", rows)
    assert "stop: it moved" in found_by_the_campaign("mks", first=2)


def test_a_program_that_lets_drives_of_an_earlier_one_home_on_is_found_out(monkeypatch):
    """Mission mks 710000137 found this in the driver."""
    homing_only(monkeypatch)
    end = phases.end_earlier_motion
    monkeypatch.setattr(contact, "end_earlier_motion", lambda *words: end(*words[:3]))
    assert "it moved" in found_by_the_campaign("mks", first=3)


def test_a_pause_that_is_ignored_is_found_out(monkeypatch):
    only(monkeypatch, "pause")
    monkeypatch.setattr(SpeedOverride, "pause", lambda _: None)
    assert "pause" in found_by_the_campaign("grbl", first=1)


def test_doubled_speeds_are_found_out(monkeypatch):
    least_s = MotionLimits.least_s
    twice = lambda self, change: least_s(self, change) / 2.0  # noqa: E731
    monkeypatch.setattr(MotionLimits, "least_s", twice)
    assert "degrees a second" in found_by_the_campaign()


def test_a_driver_whose_joints_pass_their_limits_within_a_burst_is_found_out(monkeypatch):
    only(monkeypatch, "pause")
    monkeypatch.setattr(Corridor, "holds", lambda *_: True)
    assert "beyond its limit" in found_by_the_campaign("armdroid", first=6)


def test_a_traceback_is_found_out(monkeypatch):
    monkeypatch.setattr("armdrive.arm.moving.prepare", lambda *_: 1 / 0)
    assert found_by_the_campaign()


def test_dialects_take_turns():
    assert tasks(("a", "b"), 5, 7) == [("a", 7), ("b", 7), ("a", 8), ("b", 8), ("a", 9)]


def test_a_mission_counts_for_each_of_its_faults():
    names = (FAULTS[0].name, FAULTS[1].name)
    table = table_of([Result("teachmover", 1, Outcome.LINK_LOST, names)])
    assert f"| {names[0]} | 0 | 0 | 0 | 0 | 1 | 0 |" in table
    assert f"| {names[1]} | 0 | 0 | 0 | 0 | 1 | 0 |" in table


def test_the_command_runs_missions_and_repeats_one(capsys):
    assert main(["--missions", "2", "--jobs", "1", "--dialect", "teachmover"]) == 0
    assert "2 missions" in capsys.readouterr().out
    assert main(["--only", "1", "--dialect", "teachmover"]) == 0
    assert "teachmover 1: " in capsys.readouterr().out
