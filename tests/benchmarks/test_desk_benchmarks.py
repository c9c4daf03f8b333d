"""The benchmarks of the desk run on a real terminal, with counts too small to measure anything."""

import json
import sys

import pytest

if sys.platform == "win32":
    pytest.skip("Windows has no pseudo-terminals", allow_module_level=True)

import desk
import desk_ends
from amounts import THOROUGH

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
