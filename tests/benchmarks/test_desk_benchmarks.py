"""The benchmarks of the desk run on a real terminal, with counts too small to measure anything."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from random import Random

import pytest

if sys.platform == "win32":
    pytest.skip("Windows has no pseudo-terminals", allow_module_level=True)

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))
import desk
import desk_ends
import desk_release
from amounts import THOROUGH
from feel_keys import Press

real_time = pytest.mark.skipif(not THOROUGH, reason="takes a minute of real time")


@real_time
def test_the_arm_stands_when_its_desk_is_killed(capsys, monkeypatch):
    monkeypatch.setattr(desk_ends, "ENDS", desk_ends.ENDS[:1])
    desk_ends.main(["teachmover", "--quick", "--json"])
    _, stood, way, code = map(json.loads, capsys.readouterr().out.splitlines())
    assert (stood["unit"], way["unit"]) == ("ms", "mm")
    assert stood["worst"] < stood["bound"] + 250.0  # what a busy computer may add
    assert way["kept"]
    assert code["kept"]


@real_time
def test_starts_and_keys_stand_beside_their_floors(monkeypatch):
    bare, floor, ours = desk.starting(rounds=1).rows
    assert 0.0 < bare.value < ours.value
    assert len(floor.times) == 1
    assert len(ours.times) == 2
    monkeypatch.setattr(desk, "WRITES", desk.WRITES[:1])
    floor, ours = desk.keys(count=2).rows
    assert floor.value > 0.0
    assert ours.value > 0.0
    assert ours.times["the floor"] == pytest.approx(ours.value / floor.value)


def test_a_bad_link_loses_repeats_and_never_the_first_touch():
    way = Press(tuple(index / 25.0 for index in range(50)), 2.0)
    kept = desk_release.losing(Random(1), way)
    assert kept.arrivals_s[0] == 0.0
    assert set(kept.arrivals_s) < set(way.arrivals_s)
    assert len(kept.arrivals_s) > 25
    assert kept.lifted_s == way.lifted_s
