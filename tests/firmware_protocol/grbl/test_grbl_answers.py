"""The bytes of every GRBL answer, both ways, and what is read with patience."""

from typing import get_args

import pytest
from grbl_strategies import ANSWERS
from hypothesis import given

from firmware_protocol import grbl
from firmware_protocol.errors import RemoteProtocolError
from firmware_protocol.grbl.answers import WordedAlarm, WordedError, decode_answer

PLACE = (0.0, -10.0, 5.125)
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
    (grbl.Version("1.1h.20190825", "arm"), "[VER:1.1h.20190825:arm]"),
    (grbl.BuildInfo("VNMG", 35, 254, ("16",)), "[OPT:VNMG,35,254,16]"),
    (grbl.BuildInfo("PHS"), "[OPT:PHS]"),
    (grbl.AxesInfo(6, "XYZABC"), "[AXS:6:XYZABC]"),
    (grbl.ParserState(("G0", "G54", "M5", "F0.", "S0.")), "[GC:G0 G54 M5 F0. S0.]"),
    (grbl.Parameter("G54", PLACE), "[G54:0.000,-10.000,5.125]"),
    (grbl.Parameter("PRB", PLACE, success=False), "[PRB:0.000,-10.000,5.125:0]"),
    (grbl.StartupEcho("G54G20"), ">G54G20:ok"),
    (grbl.StartupEcho("", 7), ">:error:7"),
    (grbl.Bracketed("HLP:$$ $# $G"), "[HLP:$$ $# $G]"),
    (grbl.StatusReport(grbl.State.IDLE, None, PLACE), "<Idle|MPos:0.000,-10.000,5.125>"),
    (
        grbl.StatusReport(grbl.State.HOLD, 1, None, PLACE, feed=500.0, speed=8000.0, pins="PZ"),
        "<Hold:1|WPos:0.000,-10.000,5.125|FS:500,8000|Pn:PZ>",
    ),
    (
        grbl.StatusReport(
            *(grbl.State.RUN, None, PLACE, None, 15, 128, 99, 1.5),
            work_offset=(1.0, 2.0, 3.0),
            overrides=(100, 50, 100),
            accessories="SF",
            others=("Qm:7",),
        ),
        (
            "<Run|MPos:0.000,-10.000,5.125|Bf:15,128|Ln:99|F:1.5"
            "|WCO:1.000,2.000,3.000|Ov:100,50,100|A:SF|Qm:7>"
        ),
    ),
]

TOLERATED = [
    (b"\0\0ok ", grbl.Ok()),
    (b"error: 9", grbl.Error(9)),
    (b"error:Bad number format", WordedError("Bad number format")),
    (b"ALARM: Hard limit", WordedAlarm("Hard limit")),
    (b"$0=10 (step pulse, usec)", grbl.Setting(0, "10")),
    (b"[AXS: 5: XYZAB]", grbl.AxesInfo(5, "XYZAB")),
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
    *(b"[MSG:open", b"[OPT:V,x,128]", b"[AXS:x:XYZ]", b"[GC:]", b"[G54:]", b"[PRB:0,0:2]", b"$5"),
    *(b"Grbl 1.1h", b"Grbl 1.1h ['$' for hel", b">G54", b"\xffok", b"ok\x80", b"$100=\x01"),
]


def test_the_table_has_every_answer():
    assert {type(answer) for answer, _ in LINES} == set(get_args(grbl.Answer))


@pytest.mark.parametrize(("answer", "line"), LINES)
def test_the_bytes_of_every_answer_both_ways(answer, line):
    before = b"\r\n" if isinstance(answer, grbl.Banner) else b""
    assert grbl.encode_answer(answer) == before + line.encode() + b"\r\n"
    assert decode_answer(line.encode()) == answer


@pytest.mark.parametrize(("line", "answer"), TOLERATED)
def test_what_other_firmwares_send_is_understood(line, answer):
    assert decode_answer(line) == answer


@pytest.mark.parametrize("line", UNREADABLE)
def test_a_doubtful_line_is_the_other_sides_fault(line):
    with pytest.raises(RemoteProtocolError):
        decode_answer(line)


@given(ANSWERS)
def test_every_answer_is_read_back_as_it_was(answer):
    assert decode_answer(answer.line.encode()) == answer
