"""A seeded sample of the campaign, that it repeats, and that it sees a driver without its care."""

from __future__ import annotations

import pytest
from amounts import amount

from armdrive import planning
from armdrive.dialects import DIALECTS
from armdrive.flows import jog_aims, motion
from armdrive.flows.turns import Corridor
from armdrive.trust import Belief, Evidence

from .faults import FAULTS
from .mission import run_mission
from .outcome import Outcome, Result
from .run import main, story, table_of, tasks

SAMPLE = {"mks": 4, "teachmover": 20}
"""Missions of an everyday run; 8 of those that take neither so long nor so little."""
ENOUGH = 60
"""So many missions find any of the flaws below."""


@pytest.mark.parametrize("dialect", DIALECTS)
def test_no_promise_is_broken_in_a_sample(dialect):
    for seed in range(amount(SAMPLE.get(dialect, 8), 25)):
        result = run_mission(dialect, seed)
        assert result.outcome is not Outcome.VIOLATION, story(result)


@pytest.mark.parametrize("dialect", DIALECTS)
def test_a_mission_comes_again_by_its_seed(dialect):
    first, second = (run_mission(dialect, 3, keep_log=True) for _ in range(2))
    assert first == second
    assert first.log


def found_by_the_campaign(dialect="teachmover", first=0):
    return any(run_mission(dialect, seed).broken for seed in range(first, first + ENOUGH))


def test_a_driver_without_an_audit_is_found_out(monkeypatch):
    monkeypatch.setattr(planning, "audit", lambda *_: None)
    monkeypatch.setattr(jog_aims, "audit", lambda *_: None)
    assert found_by_the_campaign()


def test_a_driver_that_sends_all_at_once_is_found_out(monkeypatch):
    monkeypatch.setattr(motion, "next_share", lambda _wire, _leg, _burst_s, done: 1.0 - done)
    assert found_by_the_campaign()


def test_a_driver_that_trusts_on_is_found_out(monkeypatch):
    after = Belief.after
    ignored = (Evidence.ANSWER_LOST, Evidence.READ_BACK_DIFFERS, Evidence.SILENT)

    def trusting(self, evidence, now_s, detail=""):
        return self if evidence in ignored else after(self, evidence, now_s, detail)

    monkeypatch.setattr(Belief, "after", trusting)
    assert found_by_the_campaign()


def test_a_driver_whose_joints_pass_their_limits_within_a_burst_is_found_out(monkeypatch):
    monkeypatch.setattr(Corridor, "holds", lambda *_: True)
    assert found_by_the_campaign("armdroid", first=30)


def test_a_traceback_is_found_out(monkeypatch):
    monkeypatch.setattr(planning, "speed_fraction", lambda _: 1 / 0)
    monkeypatch.setattr("armdrive.calls.moving.speed_fraction", lambda _: 1 / 0)
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
