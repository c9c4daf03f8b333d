"""The benchmarks of drives on a CAN bus run, with counts too small to measure anything."""

import json
import sys

import can_codecs
import can_coordination
import can_overhead
import can_rounds
import can_silence
import can_strategies
import can_streaming
import pytest
from amounts import THOROUGH

from firmware_protocol.canopen import Command, Controlword, OperationMode
from firmware_protocol.canopen import Host as CanopenHost
from firmware_protocol.frames import pack

needs_pty = pytest.mark.skipif(
    sys.platform == "win32", reason="Windows has no pseudo-terminal that a test could open"
)

needs_a_quiet_computer = pytest.mark.skipif(
    not THOROUGH, reason="real drives rightly stop where their program is kept from its work"
)
"""Measures in real time with a program that streams, which needs a core to itself (THOROUGH=1)."""


def run(capsys, program, *words):
    """Return the exit code of a benchmark, and its rows by what they say and their unit."""
    code = program.main([*words, "--json"])
    _, *rows = map(json.loads, capsys.readouterr().out.splitlines())
    return code, {(row["what"], row["unit"]): row for row in rows}


@pytest.mark.parametrize(
    ("strategy", "plain"),
    [("steered", "plain"), *([("cyclic", "plain CiA")] if THOROUGH else [])],
)
def test_coordinated_drives_keep_their_path_and_others_leave_it(
    capsys, monkeypatch, strategy, plain
):
    monkeypatch.setattr(can_coordination, "KINDS", {})
    beside = "joint motions: the tip beside its way", "mm"
    code, steered = run(capsys, can_coordination, strategy, "--times", "1")
    assert code == 0
    assert 0.0 < steered[beside]["worst"] < steered[beside]["bound"]
    _, alone = run(capsys, can_coordination, plain, "--times", "1")
    assert alone[beside]["worst"] > 10.0 * steered[beside]["worst"]


def test_rounds_of_targets_begin_with_sync_and_drives_are_held_to_the_one_before():
    wire, bus = can_rounds.Wire(can_rounds.SyncRounds()), CanopenHost((1, 2))
    word, mode = Controlword.of(Command.ENABLE_OPERATION), OperationMode.CYCLIC_POSITION

    def turn(time_s, target, told, nodes=(1, 2)):
        for node in nodes:
            wire.sent(bus.command(node, word, mode, target), time_s)
        wire.sent(bus.sync(), time_s)
        for node in (1, 2):
            wire.heard(pack(can_codecs.told(node, told)), time_s)

    turn(0.0, 100, 0)
    turn(0.01, 200, 0)
    turn(0.021, 300, 200)
    wire.sent(bus.sync(), 0.5)  # a look, between two motions
    turn(0.9, 300, 300)
    turn(0.91, 310, 300, nodes=(1,))  # the other one has its target already
    turn(0.92, 310, 300)
    rounds = wire.rounds()
    assert rounds.periods_s() == pytest.approx([0.01, 0.011, 0.01, 0.01])
    assert rounds.behind == [100, 100, 0, 0, 0, 0, 0, 0, 10, 0]


def test_codec_and_link_stand_beside_their_floors():
    for measure in (can_codecs.mks, *([can_codecs.canopen, can_overhead.link] if THOROUGH else [])):
        section = measure(rounds=20)
        assert all(row.value > 0.0 for row in section.rows)
        assert any(row.times for row in section.rows)


@needs_pty
@needs_a_quiet_computer
def test_an_adapter_on_a_pty_is_slower_than_its_bus():
    floor, *measured = can_overhead.slcan(rounds=3).rows
    assert all(row.value > floor.value for row in measured)


@needs_pty
@needs_a_quiet_computer
def test_a_killed_program_leaves_drives_that_stop(capsys, monkeypatch):
    monkeypatch.setattr(can_silence, "BEGINNINGS", {"jog": "a jog"})
    monkeypatch.setattr(can_silence, "GUARDS", {"steered": can_silence.GUARDS["steered"][:1]})
    monkeypatch.setattr(can_silence, "SILENCES", {"mks": can_silence.SILENCES["mks"][:1]})
    _, rows = run(capsys, can_silence, "steered", "--quick")
    stood, moved, way = rows.values()
    assert (stood["unit"], moved["unit"], way["unit"]) == ("ms", "ms", "mm")
    assert moved["worst"] <= stood["worst"]
    assert {row["bound"] for row in (stood, moved)} == {stood["bound"]}
    assert 0.0 < way["worst"] <= way["bound"]


@needs_pty
@needs_a_quiet_computer
@pytest.mark.parametrize(("rate", "period_ms"), [("25 Hz", 40.0), ("CSP 100 Hz", 10.0)])
def test_a_path_is_streamed(capsys, rate, period_ms):
    _, rows = run(capsys, can_streaming, rate, "--quick")
    periods = rows["from one round of targets to the next", "ms"]
    assert periods["n"] > 5
    assert periods["p50"] >= period_ms / 2.0
    assert 0.0 < rows["the bus, used both ways", "%"]["worst"] < 100.0


@needs_pty
@needs_a_quiet_computer
def test_drives_that_tell_where_they_are_are_held_to_their_targets(capsys, monkeypatch):
    # drives that hear no heartbeat for as long as a busy computer may take would rightly stop
    rate = can_strategies.Strategy("cia402", "period_ms = 20\nheartbeat_timeout_ms = 2000\n")
    monkeypatch.setattr(can_streaming, "RATES", {**can_strategies.RATES, "CSP 50 Hz": rate})
    _, rows = run(capsys, can_streaming, "CSP 50 Hz", "--quick")
    behind = rows["a drive from its target at the SYNC behind", "inc"]
    assert behind["n"] > 50
    assert behind["p50"] <= behind["bound"]
