"""GRBL's lines both ways, its host and its device."""

import math
import struct

import pytest
from amounts import every_row
from cases_grbl import ANSWERS, COMMANDS, SIX_AXES
from chunks import carried, events
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol import grbl
from firmware_protocol.errors import BadField, LocalProtocolError, RemoteProtocolError
from firmware_protocol.grbl.answers import WordedError, decode_answer
from firmware_protocol.grbl.dialect import NUMBER_MAX, take_number

# -- Commands --------------------------------------------------------------------------------------

PLACE = (0.0, -10.0, 5.125)
TEXTS = [
    *zip(
        grbl.SystemCommand,
        ("$$", "$I", "$X", "$SLP"),
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
    (lambda: grbl.StatusReport("Id|le", None, PLACE), "state"),
    (lambda: grbl.StatusReport(grbl.State.IDLE, None, PLACE, others=("FS:1",)), "others"),
    (lambda: grbl.Dialect(axes="XX"), "axes"),
]


@every_row("command, text", TEXTS)
def test_the_text_of_every_line(command, text):
    assert command.text == text
    assert not isinstance(grbl.parse_line(text.replace(" ", ""), SIX_AXES), grbl.Rejected)


@every_row("build, field", REFUSED)
def test_what_does_not_fit_is_refused_by_its_name(build, field):
    with pytest.raises(BadField) as caught:
        build()
    assert caught.value.field == field


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
        grbl.StatusReport(
            *(grbl.State.HOLD, 1, PLACE, 15, 128, 500.0, 8000.0, "PZ"),
            others=("Ov:100,50,100", "A:SF", "WCO:1.000,2.000,3.000", "Ln:99"),
        ),
        (
            "<Hold:1|MPos:0.000,-10.000,5.125|Bf:15,128|FS:500,8000|Pn:PZ|Ov:100,50,100|A:SF"
            "|WCO:1.000,2.000,3.000|Ln:99>"
        ),
    ),
]

TOLERATED = [
    (b"\0\0ok ", grbl.Ok()),
    (b"error: 9", grbl.Error(9)),
    (b"error:Bad number format", WordedError("Bad number format")),
    (b"<Idle|WPos:1.000|F:1.5>", grbl.StatusReport("Idle", others=("WPos:1.000", "F:1.5"))),
    (b"$0=10 (step pulse, usec)", grbl.Setting(0, "10")),
    (b"[AXS:6:XYZABC]", grbl.AxesInfo("XYZABC")),
    (b"[AXS: 5: XYZAB]", grbl.AxesInfo("XYZAB")),
    (b"[VER:1.1h.20190825:arm]", grbl.Version("1.1h.20190825")),
    (b"[OPT:VNMG,35,254,16]", grbl.Remark("[OPT:VNMG,35,254,16]")),
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
    *(b"<Idle", b"<|MPos:0>", b"<Idle|MPos:0,,0>", b"<Idle|MPos:0|MPos:0>", b"<1|MPos:0>"),
    *(b"<Idle|MPos:1e3>", b"<Idle|MPos:nan>", b"<Idle|MPos:1|Bf:1>"),
    *(b"<Idle|MPos:0<Idle|MPos:0>", b"<Idle|MPos:0|FS:1>", b"ALARM: Hard limit"),
    *(b"[MSG:open", b"[AXS:6:]", b"[AXS:3:XYQ]", b"$5"),
    *(b"Grbl 1.1h", b"Grbl 1.1h ['$' for hel", b"\xffok", b"ok\x80", b"$100=\x01"),
]


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
    *((word, 20) for word in ("G5", "M6", "G1.5", "D1", "G2X1I1F1", "G4P1", "G28", "G92X1")),
    *((word, 20) for word in ("G93", "M0", "M30", "M62P0")),
    *(
        ("G0G1", 24),
        ("G1X1F100G1X2F100", 24),
        ("G90G91", 21),
        ("M3M5", 21),
        ("G20G21", 21),
        ("M64P0M65P0", 21),
    ),
    *(("X1X2", 25), ("F1F2", 25), ("$", 3)),
    *(("$X1", 3), ("$Q", 3), ("$JX", 3), ("$1=", 2), ("$1=2X", 3), ("$1", 3)),
    *(("$RST=!", 3), ("$RST", 3), ("$HQ", 3), ("$HXY", 3), ("$SLEEP", 3), ("$N2=G54", 3)),
]

MODAL_REFUSED = [
    *(("G1X1", 22), ("G1", 22), ("G1F1X1P1", 36), ("M64", 28), ("M67E1", 28)),
    *(("$J=X1", 22), ("$J=X1F0", 22), ("$J=X1F1S1", 36)),
    *((f"$J={word}X1F1", 16) for word in ("G0", "G1", "G54", "M3")),
]


@every_row("text, code", REFUSED_LINES)
def test_lines_that_no_state_admits_carry_their_code(text, code):
    content = grbl.parse_line(text, SIX_AXES)
    assert isinstance(content, grbl.Rejected)
    assert content.code == code


@every_row("text, code", MODAL_REFUSED)
def test_blocks_and_jogs_that_the_modes_do_not_admit_carry_their_code(text, code):
    with pytest.raises(grbl.GcodeError) as caught:
        grbl.Modal().after(grbl.parse_line(text, SIX_AXES))
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
    assert grbl.parse_line("M64P0", grbl.GRBL).code == 20
    assert grbl.parse_line("X" * 80, grbl.GRBL).code == 11
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
    assert modes == grbl.Modal(*("G1", "G20", "G91", "M3", "M8"), feed=254.0, speed=100.0)
    assert modes.unit_mm == 25.4


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


def test_the_names_of_settings_keep_their_slashes_on_fluidnc_alone():
    for dialect, stored in (
        (SIX_AXES, "$AXES=1"),
        (grbl.GRBLHAL, "$AXES=1"),
        (grbl.FLUIDNC, "$/A/XES=1"),
    ):
        assert grbl.LineReader(dialect).feed(b"$/a/xes=1\n/G1X1\n") == [stored, "G1X1"]


def test_the_rest_of_a_line_that_is_too_long_is_dropped():
    found = grbl.LineReader().feed(b"X" * 79 + b"\n" + b"X " * 99 + b"\nG0\n")
    assert found == ["X" * 79, "X" * 80, "G0"]


# -- The host --------------------------------------------------------------------------------------


X1, X2 = (grbl.Line(f"G90G1X{n}F100") for n in (1, 2))
BANNER = b"\r\nGrbl 1.1h ['$' for help]\r\n"


def heard(host: grbl.Host, data: bytes) -> list:
    host.receive_data(data)
    return events(host)


def sent(command, dialect=SIX_AXES) -> grbl.Host:
    host = grbl.Host(dialect)
    host.send(command)
    return host


def test_an_answer_belongs_to_the_line_that_was_sent():
    host = sent(X1)
    assert host.outstanding == X1
    assert heard(host, b"ok\r\n") == [grbl.Acknowledged(X1)]
    host.send(X2)
    refused = grbl.Refused(X2, 24, grbl.ERRORS[24].meaning, grbl.ERRORS[24].remedy)
    assert heard(host, b"error:24\r\nok\r\n") == [refused, grbl.Stray(grbl.Ok())]
    assert host.outstanding is None
    host.send(X1)
    (refused,) = heard(host, b"error:Bad number format\r\n")
    assert refused == grbl.Refused(X1, None, "Bad number format", refused.remedy)


def test_what_is_pushed_answers_nothing():
    host = sent(X1)
    found = heard(host, b"[MSG:Pgm End]\r\n<Idle|MPos:0,0,0,0,0,0>\r\n>G54:ok\r\n$1=255\r\n")
    assert found[3] == grbl.Setting(1, "255")
    assert len(found) == 4
    assert host.outstanding == X1


def test_nothing_is_sent_while_a_line_is_unanswered():
    host = sent(X1)
    with pytest.raises(LocalProtocolError, match="'G90G1X1F100' is unanswered"):
        host.send(X2)
    assert host.outstanding == X1
    host.forget_outstanding()
    assert heard(host, b"error:9\r\n") == [grbl.Stray(grbl.Error(9))]
    host.send(X2)
    assert heard(host, b"ok\r\n" + BANNER) == [
        grbl.Acknowledged(X2),
        grbl.Restarted(grbl.Banner()),
    ]


def test_a_line_that_is_too_long_for_the_board_is_not_sent():
    host = sent(grbl.Line("X" * 79), grbl.GRBL)
    host.forget_outstanding()
    with pytest.raises(LocalProtocolError, match="has 80 characters, the board takes 79"):
        host.send(grbl.Line("X" * 80))
    assert host.outstanding is None


def test_between_a_soft_reset_and_its_banner_no_line_goes_out():
    host = sent(X1)
    assert host.send_realtime(grbl.Realtime.SOFT_RESET) == b"\x18"
    with pytest.raises(LocalProtocolError, match="its banner has not come"):
        host.send(X2)
    assert heard(host, BANNER) == [grbl.Restarted(grbl.Banner())]
    assert host.outstanding is None
    host.send_realtime(grbl.Realtime.SOFT_RESET)
    host.forget_outstanding()
    host.send(X2)


# -- the events that it makes of what is heard ----------------------------------------------------


def test_a_report_with_another_number_of_axes_is_not_believed():
    (event,) = heard(grbl.Host(SIX_AXES), b"<Idle|MPos:0.000,0.000,0.000>\n")
    assert isinstance(event, grbl.Unreadable)
    assert event.reason == "coordinates: 3, but the board has 6 axes"


@every_row("code", range(1, 19))
def test_an_alarm_tells_whether_the_position_is_kept(code):
    (event,) = heard(grbl.Host(), b"ALARM:%d\r\n" % code)
    assert isinstance(event, grbl.AlarmRaised)
    assert event.position_kept == (code in (2, 4, 5))
    assert event.meaning == (grbl.ALARMS[code].meaning if code <= 9 else event.meaning)


def test_codes_above_grbls_mean_what_the_firmware_says():
    texts = {
        heard(grbl.Host(dialect), b"ALARM:10\r\n")[0].meaning
        for dialect in (grbl.GRBL, grbl.GRBLHAL, grbl.FLUIDNC)
    }
    assert len(texts) == 3


def test_a_host_learns_the_firmware():
    host = grbl.Host(SIX_AXES)
    heard(host, b"GrblHAL 1.1f ['$' or '$HELP' for help]\r\n")
    assert host.dialect.variant is grbl.Variant.GRBLHAL
    host = grbl.Host(SIX_AXES)
    heard(host, b"[FIRMWARE:grblHAL]\r\n" + BANNER)
    assert host.dialect.variant is grbl.Variant.GRBLHAL
    heard(host, b"[VER:3.7 FluidNC v3.7.8:]\r\n")
    assert host.dialect.variant is grbl.Variant.FLUIDNC


# -- The device, and both machines wired to each other ---------------------------------------------


def test_a_stream_is_parted_into_realtime_commands_and_text_in_their_order():
    status, cancel = grbl.Realtime.STATUS, grbl.Realtime.JOG_CANCEL
    assert [*grbl.pieces(b"G1?X\x85\xff1\x91\n")] == [b"G1", status, b"X", cancel, b"1", b"\n"]
    host = sent(X1)
    for command in grbl.Realtime:
        assert [*grbl.pieces(host.send_realtime(command))] == [command]
    with pytest.raises(LocalProtocolError):
        host.send_realtime("?")


def test_each_line_is_answered_once():
    device = grbl.Device(SIX_AXES)
    with pytest.raises(LocalProtocolError, match="no line is unanswered"):
        device.send(grbl.Ok())
    device.receive_data(b"\nG5\n")
    assert events(device)[0] == grbl.LineReceived("", grbl.Empty())
    assert device.unanswered == 2
    assert device.send(grbl.Ok()) == b"ok\r\n"
    assert device.send(grbl.Feedback("Pgm End")) == b"[MSG:Pgm End]\r\n"
    assert device.send(grbl.Error(20)) == b"error:20\r\n"
    with pytest.raises(LocalProtocolError):
        device.send(grbl.Error(20))


@given(st.lists(st.tuples(COMMANDS, st.booleans()), max_size=6), st.data())
def test_every_script_arrives_whole_at_both_ends(script, data):
    host, device = grbl.Host(SIX_AXES), grbl.Device(SIX_AXES)
    for command, taken in script:
        (line,) = carried(data.draw, host.send(command), device)
        assert line.text == command.text
        assert not isinstance(line.content, grbl.Rejected)
        (event,) = carried(data.draw, device.send(grbl.Ok() if taken else grbl.Error(9)), host)
        assert isinstance(event, grbl.Acknowledged if taken else grbl.Refused)
        assert event.command == command
    assert (host.outstanding, device.unanswered) == (None, 0)
