"""A sample of the campaign, its repeatability, and faulty drivers that it has to find."""

import math
import random
from dataclasses import dataclass, replace

import pytest
from amounts import amount

from armdrive.arm import moving
from armdrive.arm.moving import Gripper
from armdrive.connect.runner import TaskRunner
from armdrive.dialects.bus import phases
from armdrive.dialects.bus.phases import Phase, Signal
from armdrive.dialects.mks import contact
from armdrive.errors import OutOfBounds
from armdrive.motion import deviation
from armdrive.motion import execute as motion
from armdrive.motion import gripper as gripping
from armdrive.motion import jog as held_jog
from armdrive.motion import jog as jog_aims
from armdrive.motion import jog as jogging
from armdrive.motion import plan as planning
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


@dataclass(frozen=True)
class Faulty:
    """A driver that breaks a law: what is put in place of what, and what the campaign says of it.

    With an `action`, missions draw that alone. `first` is the first seed.
    """

    what: str
    patches: tuple[tuple[object, str, object], ...]
    says: str = ""
    dialect: str = "teachmover"
    first: int = 0
    action: str = ""


def nothing(*_, **__):
    """Stand for a function that does nothing."""


def refuse(*_):
    """Stand for an audit that allows no motion."""
    raise OutOfBounds("no", name="base", value=1.0, bound=0.0)


GRASP, LEAST_S = Gripper.grasp, MotionLimits.least_s
FAULTY = (
    Faulty("does not audit", ((planning, "audit", nothing), (jog_aims, "audit", nothing)),
           first=10),
    Faulty("has limits three degrees too wide", ((planning, "SLACK_RAD", math.radians(3.0)),),
           "beyond its limit", first=10),
    Faulty("ignores the speed override",
           ((SpeedOverride, "slowed_s", lambda _, duration_s: duration_s),),
           "degrees a second", "grbl", 2, "pause"),
    Faulty("does not say that it has clipped a jog", ((jogging, "show_end", nothing),),
           "ended well, but", first=1, action="jog by an increment"),
    Faulty("sends all at once",
           ((motion, "next_share", lambda _context, _leg, _burst_s, done: 1.0 - done),), first=4),
    Faulty("makes no jogs", ((jogging, "drive_legs", lambda *_, **__: iter(())),),
           "ended well, but", action="jog by an increment"),
    Faulty("does not grasp", ((Gripper, "grasp", lambda *_, **__: 0.0),), "hold nothing",
           action="gripper"),
    Faulty("measures a grasp wrongly",
           ((Gripper, "grasp", lambda self, **words: GRASP(self, **words) + 3.0),),
           "between the fingers", first=3, action="gripper"),
    Faulty("refuses the last motion", ((planning, "audit", refuse),),
           "nothing forbids was refused"),
    Faulty("ignores a stop", ((TaskRunner, "request_stop", nothing),), "stop", "grbl", 3),
    Faulty("ignores a pause", ((SpeedOverride, "pause", nothing),), "pause", "grbl", 1, "pause"),
    Faulty("doubles its speeds",
           ((MotionLimits, "least_s", lambda self, change: LEAST_S(self, change) / 2.0),),
           "degrees a second"),
    Faulty("passes limits within a burst", ((deviation, "within_limits", lambda *_: True),),
           "beyond its limit", "armdroid", 6, "pause"),
    Faulty("ends with a traceback", ((moving, "prepare", lambda *_: 1 / 0),), "a traceback"),
)  # fmt: skip


@pytest.mark.parametrize("faulty", FAULTY, ids=lambda row: row.what)
def test_a_faulty_driver_is_found_out(monkeypatch, faulty):
    if faulty.action:
        only(monkeypatch, faulty.action)
    for owner, name, value in faulty.patches:
        monkeypatch.setattr(owner, name, value)
    found = found_by_the_campaign(faulty.dialect, faulty.first)
    assert found
    assert faulty.says in found


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


def only(monkeypatch, action):
    """Make missions draw one action only."""
    monkeypatch.setattr(mission, "ACTIONS", {action: ACTIONS[action]})
    monkeypatch.setattr(mission, "HOMING_ACTIONS", {})


def test_an_arm_that_is_recovered_and_never_moves_is_found_out(monkeypatch):
    faulty, fault = set(), Core.fault

    def remembered(self, *words):
        faulty.add(id(self))
        fault(self, *words)

    monkeypatch.setattr(Core, "fault", remembered)
    with_legs(monkeypatch, lambda context, legs: () if id(context.core) in faulty else legs)
    assert "ended well, but" in found_by_the_campaign(first=5)


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
