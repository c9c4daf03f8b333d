"""The simulated GRBL board's wire: its ring, its lines, its answers, and how fast they come."""

from __future__ import annotations

from dataclasses import replace

import pytest
from grbl_bench import BYTE_S, MACHINE, Bench, stream

from firmware_protocol.grbl import Host, Line, State, Variant


@pytest.mark.parametrize(
    ("firmware", "variant", "opt", "ring"),
    [
        ("grbl", Variant.GRBL, "[OPT:V,15,128]", 128),
        ("mega5x", Variant.GRBL, "[OPT:VNMGH,35,255,0]", 255),
        ("grblhal", Variant.GRBLHAL, "[OPT:VNM,35,1024]", 1024),
        ("fluidnc", Variant.FLUIDNC, "[OPT:PHS]", 256),
    ],
)
def test_every_firmware_says_what_it_is_and_its_full_ring_drops_bytes_silently(
    firmware, variant, opt, ring
):
    bench = Bench(firmware=firmware)
    assert [one.variant for one in bench.banners] == [variant]
    said = bench.say("$I")
    assert opt in said
    assert said[-1] == "ok"
    assert ("[AXS:6:XYZABC]" in said) == (firmware in ("mega5x", "grblhal"))
    bench.heard.clear()
    bench.say("!")  # nothing is read any more
    lines = 150
    bench.put("G4P0.001\n" * lines)
    assert bench.wait(0.2) == []
    assert bench.ask().free_bytes == 0
    assert bench.device.board.details()["lost_bytes"] == lines * 9 - ring
    bench.say("~", 2.0)
    assert bench.heard.count("ok") == ring // 9


def test_an_empty_line_is_answered_within_two_milliseconds():
    bench = Bench()
    bench.say("")
    assert bench.heard[-1] == "ok"
    assert stream(bench, []) == 0.0
    one = stream(bench, [Line("G90G0X0")])  # no way at all
    assert one < 10e-3


def test_a_lost_byte_is_silent_and_moves_twelve_where_twelve_and_a_half_was_meant():
    bench = Bench()
    assert bench.say("G1X12.F3000", 2.0) == ["ok"]  # G1X12.5F3000 less one character
    assert bench.x == 12.0


def test_a_lost_line_end_gives_one_answer_too_few_and_then_an_error():
    bench = Bench()
    bench.put("G1X1F3000")
    bench.put("G1X2F3000\n")
    assert bench.wait(1.0) == ["error:24"]
    assert bench.x == 0.0


def test_a_mega_takes_lines_of_two_hundred_characters():
    assert Bench(firmware="mega5x").say("G1F300X" + "0" * 200 + "1", 3.0) == ["ok"]


@pytest.mark.parametrize(("firmware", "most"), [("grbl", 79), ("grblhal", 256)])
def test_a_line_that_is_too_long_is_refused_whole(firmware, most):
    bench = Bench(firmware=firmware)
    assert bench.say("G1F300" + "X" + "0" * (most - 8) + "1", 3.0) == ["ok"]
    assert bench.say("G1F300" + "X" + "0" * (most - 7) + "1", 3.0) == ["error:11"]


def test_real_time_bytes_are_picked_out_of_the_middle_of_a_line():
    bench = Bench()
    bench.put("G1X5?F3000\n")
    said = bench.wait(2.0)
    assert [line for line in said if line == "ok"] == ["ok"]
    assert bench.reports[-1].state is State.IDLE
    assert bench.x == 5.0


def test_the_rate_of_short_segments_is_the_measured_one():
    """317 a second by counting characters on a 328p, at 500 units/s^2: it waits for the motion."""
    names = [Line(f"G90G1X{0.1 * (n + 1):.3g}F6000") for n in range(150)]
    counting = len(names) / stream(Bench(firmware="grbl"), names)
    one_by_one = Host(replace(Bench(firmware="grbl").board.codec.dialect, ring_bytes=None))
    single = len(names) / stream(Bench(firmware="grbl"), names, one_by_one)
    assert counting == pytest.approx(317, rel=0.1)
    assert single < counting


def test_in_check_mode_the_wire_is_the_limit():
    """485 to 534 lines a second, against 235 to 250 one at a time (and a slower host)."""
    lines = [Line("G90G1X10.123Y-4.5F1500") for _ in range(150)]
    bench = Bench()
    bench.say("$C")
    rate = len(lines) / stream(bench, lines)
    bytes_each = len(lines[0].text) + 1
    assert rate * bytes_each * BYTE_S > 0.95
    one_by_one = Host(replace(bench.board.codec.dialect, ring_bytes=None))
    assert len(lines) / stream(bench, lines, one_by_one) < 0.85 * rate


def test_reports_are_answered_at_a_hundred_hertz_and_run_together_at_five_hundred():
    for asked_hz, least, most in ((100, 99, 101), (500, 140, 210)):
        bench = Bench({**MACHINE, 10: 1})
        bench.say("$J=G91X100F600")
        before = len(bench.reports)
        for _ in range(asked_hz):
            bench.say("?", 1 / asked_hz)
        assert least <= len(bench.reports) - before <= most


def test_offset_and_overrides_come_now_and_then():
    bench = Bench()
    for _ in range(40):
        bench.ask()
    assert [n for n, one in enumerate(bench.reports) if one.work_offset] == [0, 10, 20, 30]
    assert [n for n, one in enumerate(bench.reports) if one.overrides] == [1, 11, 21, 31]
    assert not any(one.work_offset and one.overrides for one in bench.reports)
    bench.say("G92X5")
    assert bench.ask().work_offset[0] == -5.0


def test_the_mask_says_what_reports_tell():
    bench = Bench()
    bench.say("G10L2P1X3")
    first = bench.ask()
    assert (first.machine_position[0], first.free_blocks, first.free_bytes) == (0.0, 35, 255)
    bench.say("$10=0")
    second = bench.ask()
    assert (second.machine_position, second.work_position[0]) == (None, -3.0)
    assert second.free_blocks is None


def test_a_change_of_settings_blocks_and_loses_what_arrives_meanwhile():
    bench = Bench()
    bench.put("$110=5000\n")
    bench.put("G1X1F600\n")
    assert bench.wait(0.5) == ["ok"]
    assert bench.device.board.details()["lost_bytes"] == 9
    assert bench.board.settings[110] == 5000.0
    patient = Bench(firmware="grblhal")
    patient.put("$110=5000\nG1X1F600\n")
    assert patient.wait(0.5) == ["ok", "ok"]


@pytest.mark.parametrize(
    ("line", "answer"),
    [
        ("$0=2", "error:6"),
        ("$100=-1", "error:4"),
        ("$99=1", "error:3"),
        ("$20=1", "error:10"),
        ("$H", "error:5"),
        ("G2X1Y1I1F100", "error:20"),
        ("G1X1", "error:22"),
        ("$J=X1", "error:22"),
        ("X1X2", "error:25"),
        ("G93X1F60", "error:20"),
        ("$N", "error:3"),
        ("$N0=G91", "error:3"),
        ("$I=mine", "error:3"),
        ("$RST=$", "error:3"),
    ],
)
def test_what_is_wrong_is_refused_by_its_number(line, answer):
    assert Bench().say(line)[-1:] == [answer]


def test_fluidnc_names_its_settings():
    bench = Bench(firmware="fluidnc")
    assert not [line for line in bench.say("$$", 0.5) if line.startswith("$1=")]
    assert bench.say("$/stepping/idle_ms") == ["$/stepping/idle_ms=255", "ok"]
    assert bench.say("$/Stepping/Idle_ms=25") == ["ok"]
    assert bench.board.settings[1] == 25
    assert bench.say("$/axes/y/max_rate_mm_per_min=70") == ["ok"]
    assert bench.board.settings[111] == 70
    for line, answer in (
        ("$/stepping/idle", "error:3"),
        ("$/axes/w/steps_per_mm", "error:3"),
        ("$/axes/x/steps_per_mm=x", "error:2"),
        ("$/axes/x/steps_per_mm=nan", "error:2"),
    ):
        assert bench.say(line) == [answer]
    assert Bench().say("$/stepping/idle_ms") == ["error:3"]


def test_settings_of_the_factory_are_the_published_ones():
    said = Bench({}, factory=True).say("$$", 0.5)
    for line in ("$1=25", "$10=1", "$100=250.000", "$110=500.000", "$120=10.000", "$130=200.000"):
        assert line in said


def test_noise_is_answered_by_errors_and_breaks_nothing():
    bench = Bench()
    noise = bytes(byte for byte in range(256) if byte not in b"!~\x18\x84") * 8
    for start in range(0, len(noise), 37):
        bench.put(noise[start : start + 37])
        bench.wait(0.01)
    bench.wait(5.0)
    assert {line.partition(":")[0] for line in bench.heard if line[0] not in "<[G"} <= {
        "ok",
        "error",
    }
    bench.say("")  # an end for what has been begun
    assert bench.say("G1X1F3000", 1.0)[-1] == "ok"
    assert bench.x == 1.0
