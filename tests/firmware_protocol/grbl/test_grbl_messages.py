"""GRBL's lines both ways: commands, answers, G-code."""

import math
import struct
from typing import get_args

import pytest
from amounts import every_row
from cases_grbl import ANSWERS, COMMANDS, SIX_AXES
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol import grbl
from firmware_protocol.errors import BadField, RemoteProtocolError
from firmware_protocol.grbl.answers import WordedAlarm, WordedError, decode_answer
from firmware_protocol.grbl.dialect import NUMBER_MAX, take_number

# -- Commands --------------------------------------------------------------------------------------

PLACE = (0.0, -10.0, 5.125)
TEXTS = [
    *zip(
        grbl.SystemCommand,
        ("$$", "$I", "$G", "$X", "$C", "$SLP"),
        strict=True,
    ),
    (grbl.Home(), "$H"),
    (grbl.Home("B"), "$HB"),
    (grbl.SetSetting(100, 26.667), "$100=26.667"),
    (grbl.Line(), ""),
    (grbl.Line("G91"), "G91"),
]

REFUSED = [
    *(
        (lambda bad=bad: grbl.SetSetting(1, bad), "value")
        for bad in (math.nan, math.inf, "1", True, 2e7)
    ),
    (lambda: grbl.SetSetting(-1, 0), "setting"),
    (lambda: grbl.Home("XX"), "axes"),
    *((lambda bad=bad: grbl.Line(bad), "text") for bad in ("G1\n", "é", "?", "a!", "~", "\x18", 7)),
    (lambda: grbl.Error(0), "code"),
    (lambda: grbl.Banner("1 1"), "version"),
    (lambda: grbl.Banner(""), "version"),
    (lambda: grbl.Banner("1.1", firmware="v3"), "firmware"),
    (lambda: grbl.Setting("12", "on"), "key"),
    (lambda: grbl.Setting(1, " on"), "value"),
    (lambda: grbl.StatusReport(grbl.State.IDLE), "machine_position"),
    (lambda: grbl.StatusReport("Id|le", None, PLACE), "state"),
    (lambda: grbl.StatusReport(grbl.State.IDLE, None, PLACE, others=("FS:1",)), "others"),
    (lambda: grbl.Dialect(axes="XX"), "axes"),
]


@every_row("command, text", TEXTS)
def test_the_text_of_every_line(command, text):
    assert command.text == text
    assert not isinstance(grbl.parse_line(text.replace(" ", ""), SIX_AXES), grbl.Rejected)


def test_the_table_has_every_line():
    assert {type(command) for command, _ in TEXTS} == set(get_args(grbl.Command))


@every_row("build, field", REFUSED)
def test_what_does_not_fit_is_refused_by_its_name(build, field):
    with pytest.raises(BadField) as caught:
        build()
    assert caught.value.field == field


@given(COMMANDS)
def test_every_line_with_three_decimals_and_four_digits_fits_a_board_of_six_axes(command):
    assert not set(command.text) & set("?!~ \n")
    assert len(command.text) <= SIX_AXES.max_line
    assert not isinstance(grbl.parse_line(command.text, SIX_AXES), grbl.Rejected)


@given(st.floats(-NUMBER_MAX, NUMBER_MAX))
def test_numbers_are_written_without_exponent_and_as_near_as_eight_digits_and_a_float32_allow(
    value,
):
    text = grbl.write_number(value)
    assert set(text) <= set("-.0123456789")
    assert take_number(text, 0) == (float(text), len(text))
    as_float32 = struct.unpack("f", struct.pack("f", float(text)))[0]
    assert abs(float(text) - value) <= max(5.1e-5, abs(value) * 6e-8)
    assert abs(as_float32 - value) <= max(6e-5, abs(value) * 1.3e-7)


@every_row(
    "text, value",
    [("+1.5", 1.5), (".5", 0.5), ("5.", 5.0), ("-0.25", -0.25), ("123456789", 123456780.0)],
)
def test_numbers_are_read_as_grbl_reads_them(text, value):
    assert take_number(text, 0) == (value, len(text))


@every_row("text", ["", "-", ".", "X", "--1", "e5"])
def test_what_is_no_number(text):
    assert take_number(text, 0) is None


# -- Answers ---------------------------------------------------------------------------------------

LINES = [
    (grbl.Ok(), "ok"),
    (grbl.Error(24), "error:24"),
    (grbl.Alarm(3), "ALARM:3"),
    (grbl.Banner(), "Grbl 1.1h ['$' for help]"),
    (grbl.Banner("1.1f", grbl.Variant.GRBLHAL), "GrblHAL 1.1f ['$' or '$HELP' for help]"),
    (
        grbl.Banner("3.7", grbl.Variant.FLUIDNC, "v3.7.12 (wifi)"),
        "Grbl 3.7 [FluidNC v3.7.12 (wifi) '$' for help]",
    ),
    (grbl.Setting(1, "255"), "$1=255"),
    (grbl.Setting("N0", "G54"), "$N0=G54"),
    (grbl.Setting("/axes/x/steps_per_mm", "80.000"), "$/axes/x/steps_per_mm=80.000"),
    (grbl.Feedback("'$H'|'$X' to unlock"), "[MSG:'$H'|'$X' to unlock]"),
    *(
        (grbl.Remark(line), line)
        for line in ("[HLP:$$ $# $G]", "[GC:G0 G54 F0.]", "[PRB:0.000,-10.000,5.125:0]", ">G54:ok")
    ),
    (grbl.StatusReport(grbl.State.IDLE, None, PLACE), "<Idle|MPos:0.000,-10.000,5.125>"),
    (
        grbl.StatusReport(grbl.State.HOLD, 1, None, PLACE, feed=500.0, speed=8000.0, pins="PZ"),
        "<Hold:1|WPos:0.000,-10.000,5.125|FS:500,8000|Pn:PZ>",
    ),
    (
        grbl.StatusReport(
            *(grbl.State.RUN, None, PLACE, None, 15, 128, 1.5),
            work_offset=(1.0, 2.0, 3.0),
            overrides=(100, 50, 100),
            accessories="SF",
            others=("Ln:99", "Qm:7"),
        ),
        (
            "<Run|MPos:0.000,-10.000,5.125|Bf:15,128|F:1.5"
            "|WCO:1.000,2.000,3.000|Ov:100,50,100|A:SF|Ln:99|Qm:7>"
        ),
    ),
]

TOLERATED = [
    (b"\0\0ok ", grbl.Ok()),
    (b"error: 9", grbl.Error(9)),
    (b"error:Bad number format", WordedError("Bad number format")),
    (b"ALARM: Hard limit", WordedAlarm("Hard limit")),
    (b"$0=10 (step pulse, usec)", grbl.Setting(0, "10")),
    (b"[AXS:6:XYZABC]", grbl.AxesInfo("XYZABC")),
    (b"[AXS: 5: XYZAB]", grbl.AxesInfo("XYZAB")),
    (b"[VER:1.1h.20190825:arm]", grbl.Version("1.1h.20190825")),
    (b"[OPT:VNMG,35,254,16]", grbl.BuildInfo(35)),
    (b"[OPT:PHS]", grbl.BuildInfo()),
    (
        b"<Run|MPos:0.000|Ln:9|FS:1,2,3>",
        grbl.StatusReport(grbl.State.RUN, None, (0.0,), feed=1.0, speed=2.0, others=("Ln:9",)),
    ),
    (
        b"<Tool|MPos:1,2.5,-3.|Pn:>",
        grbl.StatusReport(grbl.State.TOOL, None, (1.0, 2.5, -3.0), pins=""),
    ),
    (b"<Starting|MPos:0.000>", grbl.StatusReport("Starting", None, (0.0,))),
]

UNREADABLE = [
    *(b"okk", b"ok1", b"o", b"error:", b"error:0", b"error:2x", b"error:1000", b"ALARM:", b"hello"),
    *(
        b"<Idle",
        b"<Idle>",
        b"<|MPos:0>",
        b"<Idle|MPos:0,,0>",
        b"<Idle|MPos:0|MPos:0>",
        b"<1|MPos:0>",
    ),
    *(b"<Idle|MPos:1|WPos:1>", b"<Idle|MPos:1e3>", b"<Idle|MPos:nan>", b"<Idle|MPos:1|Bf:1>"),
    *(
        b"<Idle|MPos:0|Ov:1,2>",
        b"<Idle|MPos:0<Idle|MPos:0>",
        b"<Idle|MPos:0|F:1|FS:1,2>",
        b"<Idle|MPos:0|F:1,2>",
    ),
    *(b"[MSG:open", b"[OPT:V,x,128]", b"[AXS:6:]", b"[AXS:3:XYQ]", b"$5"),
    *(b"Grbl 1.1h", b"Grbl 1.1h ['$' for hel", b"\xffok", b"ok\x80", b"$100=\x01"),
]


def test_the_table_has_every_answer():
    assert {type(answer) for answer, _ in LINES} == set(get_args(grbl.Answer))


@every_row("answer, line", LINES)
def test_the_bytes_of_every_answer_both_ways(answer, line):
    before = b"\r\n" if isinstance(answer, grbl.Banner) else b""
    assert grbl.encode_answer(answer) == before + line.encode() + b"\r\n"
    assert decode_answer(line.encode()) == answer


@every_row("line, answer", TOLERATED)
def test_what_other_firmwares_send_is_understood(line, answer):
    assert decode_answer(line) == answer


@every_row("line", UNREADABLE)
def test_a_doubtful_line_is_the_other_sides_fault(line):
    with pytest.raises(RemoteProtocolError):
        decode_answer(line)


@given(ANSWERS)
def test_every_answer_is_read_back_as_it_was(answer):
    assert decode_answer(answer.line.encode()) == answer


# -- G-code ----------------------------------------------------------------------------------------

REFUSED_LINES = [
    *(("1X", 1), ("G1X1=", 1), ("GX", 2), ("G1X", 2), ("X-", 2), ("F-1", 4), ("M3S-1", 4)),
    *((word, 20) for word in ("G5", "M6", "G1.5", "D1", "G2X1I1F1", "G28", "G92X1", "G93", "M0")),
    *(
        ("G0G1", 24),
        ("G1X1F100G1X2F100", 24),
        ("G90G91", 21),
        ("M3M5", 21),
        ("G20G21", 21),
        ("M62P0M63P0", 21),
    ),
    *(("X1X2", 25), ("F1F2", 25), ("$", 3)),
    *(("$X1", 3), ("$Q", 2), ("$JX", 3), ("$1=", 2), ("$1=2X", 3), ("$1", 3)),
    *(("$RST=!", 3), ("$RST", 3), ("$HQ", 3), ("$HXY", 3), ("$SLEEP", 3), ("$N2=G54", 3)),
]

MODAL_REFUSED = [
    *(("G1X1", 22), ("G1", 22), ("G4", 28), ("G1F1X1P1", 36), ("M62", 28), ("M67E1", 28)),
]

JOGS_REFUSED = [
    *(("X1", 22), ("X1F1S1", 36), ("G1X1F1", 16), ("G54X1F1", 16), ("M3X1F1", 16)),
    *(("X1F0", 22), ("G0X1F1", 16)),
]


@every_row("text, code", REFUSED_LINES)
def test_lines_that_no_state_admits_carry_their_code(text, code):
    content = grbl.parse_line(text, SIX_AXES)
    assert isinstance(content, grbl.Rejected)
    assert content.code == code, content.reason


@every_row("text, code", MODAL_REFUSED)
def test_blocks_that_the_modes_do_not_admit_carry_their_code(text, code):
    with pytest.raises(grbl.GcodeError) as caught:
        grbl.Modal().after(grbl.parse_block(text, SIX_AXES))
    assert caught.value.code == code


@every_row("text, code", JOGS_REFUSED)
def test_jogs_that_are_not_admitted_carry_their_code(text, code):
    with pytest.raises(grbl.GcodeError) as caught:
        grbl.Modal().after(grbl.parse_line(f"$J={text}", SIX_AXES))
    assert caught.value.code == code


@every_row("text", ["G91F1", "G20G91F1", "F1"])
def test_a_jog_without_an_axis_word_is_admitted_and_changes_nothing(text):
    """Observed on grbl-Mega-5X, grblHAL and FluidNC."""
    assert grbl.Modal().after(grbl.parse_line(f"$J={text}", SIX_AXES)) == grbl.Modal()


@every_row("dialect, codes", [(SIX_AXES, (1, 1)), (grbl.GRBLHAL, (0, 2)), (grbl.FLUIDNC, (0, 2))])
def test_a_bracket_that_ends_no_comment_is_refused_or_dropped(dialect, codes):
    device = grbl.Device(dialect)
    device.receive_data(b"))\n))GG\n")
    contents = [device.next_event().content for _ in codes]
    assert tuple(getattr(each, "code", 0) for each in contents) == codes


def test_what_a_board_lacks_it_refuses():
    assert grbl.parse_line("A1", grbl.GRBL).code == 20
    assert grbl.parse_line("M62P0", grbl.GRBL).code == 20
    assert grbl.parse_line("$HX", grbl.GRBL).code == 3
    assert grbl.parse_line("$HXY", grbl.GRBLHAL).code == 3
    assert grbl.parse_line("$HC", grbl.GRBLHAL) == grbl.Home("C")
    assert grbl.parse_line("$300=1", grbl.GRBLHAL) == grbl.SetSetting(300, 1.0)


def test_a_block_holds_its_words():
    block = grbl.parse_line("G90G01X-1.5A2F300", SIX_AXES)
    assert block == grbl.Block(
        {grbl.Group.DISTANCE: "G90", grbl.Group.MOTION: "G1"},
        {"X": -1.5, "A": 2.0},
        {"F": 300.0},
    )
    assert grbl.parse_line("$J=G91X1F9", SIX_AXES) == grbl.Block(
        {grbl.Group.DISTANCE: "G91"}, {"X": 1.0}, {"F": 9.0}, jog=True
    )
    assert grbl.parse_line("", SIX_AXES) == grbl.Empty()


def test_modes_last_from_block_to_block():
    modes = grbl.Modal()
    for text in ("G91", "G20", "G1X1F10", "M3S100", "X2", "M8"):
        modes = modes.after(grbl.parse_block(text, SIX_AXES))
    assert modes == grbl.Modal(
        *("G1", "G54", "G17", "G20", "G91", "M3", "M8"), feed=254.0, speed=100.0
    )
    assert modes.report.line == "[GC:G1 G54 G17 G20 G91 G94 M3 M8 T0 F254 S100]"
    assert modes.unit_mm == 25.4
    ended = modes.after(grbl.parse_block("M30", SIX_AXES))
    assert ended == grbl.Modal("G1", units="G20", feed=254.0, speed=100.0)


def test_a_jog_changes_no_mode_but_has_its_own_while_it_lasts():
    modes = grbl.Modal(units="G20")
    jog = grbl.parse_line("$J=G21G91X1F60", SIX_AXES)
    during = modes.during(jog)
    assert (during.motion, during.units, during.distance, during.feed) == ("G1", "G21", "G91", 60.0)
    assert modes.after(jog) == modes


@every_row(
    "raw, stored",
    [
        *(("g1 x1.5", "G1X1.5"), ("G1 (a;b) X1 ;end X2", "G1X1"), ("/G0\tX1", "G0X1")),
        *(("(only)", ""), ("(open X1", ""), ("$$ ", "$$"), ("", "")),
    ],
)
def test_lines_are_stored_as_grbl_stores_them(raw, stored):
    assert grbl.LineReader().feed(raw.encode() + b"\n") == [stored]


def test_each_line_end_counts_on_grbl_and_a_pair_is_one_on_grblhal():
    for dialect, lines in ((SIX_AXES, ["G0", "", "G1", ""]), (grbl.GRBLHAL, ["G0", "G1", ""])):
        reader = grbl.LineReader(dialect)
        found = [line for byte in b"G0\r\nG1\n\n" for line in reader.feed(bytes([byte]))]
        assert found == lines


def test_the_names_of_settings_keep_their_slashes_on_fluidnc_alone():
    for dialect, stored in (
        (SIX_AXES, "$AXES=1"),
        (grbl.GRBLHAL, "$AXES=1"),
        (grbl.FLUIDNC, "$/A/XES=1"),
    ):
        assert grbl.LineReader(dialect).feed(b"$/a/xes=1\n/G1X1\n") == [stored, "G1X1"]


def test_the_longest_line_passes_and_one_character_more_does_not():
    found = grbl.LineReader().feed(b"X" * 79 + b"\n" + b"X " * 80 + b"\nG0\n")
    too_long = grbl.Unusable("X" * 79, "a line of more than 79 characters")
    assert found == ["X" * 79, too_long, "G0"]
