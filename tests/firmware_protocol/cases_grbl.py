"""What the GRBL tests draw from: every line and answer, and every way to cut a stream."""

import string

from chunks import events
from fuzzing import FuzzCase
from hypothesis import strategies as st

from firmware_protocol import grbl
from firmware_protocol.grbl.answers import Alarm

AXES = "XYZABC"
SIX_AXES = grbl.Dialect(axes=AXES, outputs=True, single_axis_homing=True)
"""A build with six axes that knows every word."""
NUMBERS = st.integers(-9_999_999, 9_999_999).map(lambda n: n / 1000)
FEEDS = st.integers(1, 9_999_999).map(lambda n: n / 1000)
TARGETS = st.dictionaries(st.sampled_from(AXES), NUMBERS, min_size=1, max_size=6)
NAMES = st.text(string.ascii_letters + string.digits + ".-", min_size=1, max_size=12)
COORDINATES = st.tuples(*[NUMBERS] * 6)
BYTE = st.integers(1, 255)

_WORDS = TARGETS.map(lambda axes: "".join(f"{a}{grbl.write_number(n)}" for a, n in axes.items()))
_MOVES = st.one_of(
    st.builds("{}G0{}".format, st.sampled_from(["", "G90", "G91"]), _WORDS),
    st.builds("{}G1{}F{}".format, st.sampled_from(["", "G90", "G91"]), _WORDS, FEEDS),
    st.builds("M3S{}".format, FEEDS),
    st.just("M5"),
    st.builds("M{}E{}Q{}".format, st.sampled_from([67, 68]), st.integers(0, 7), NUMBERS),
    st.builds("G17G21G9{}G94G{}".format, st.integers(0, 1), st.integers(54, 59)),
    st.sampled_from(["M8", "M9"]),
    st.builds("M{}P{}".format, st.sampled_from([64, 65]), st.integers(0, 7)),
)
GCODE = _MOVES.map(grbl.Line)
JOGS = st.builds("$J=G21{}{}F{}".format, st.sampled_from(["G90", "G91"]), _WORDS, FEEDS).map(
    grbl.Line
)
SYSTEM = st.one_of(
    st.sampled_from(grbl.SystemCommand),
    st.builds(grbl.Home, st.sampled_from(["", *AXES])),
    st.builds(grbl.SetSetting, st.integers(0, 255), NUMBERS),
)
COMMANDS = st.one_of(GCODE, JOGS, SYSTEM)

COUNTS = st.integers(0, 255)
BANNERS = st.one_of(
    st.builds(grbl.Banner, NAMES, st.sampled_from([grbl.Variant.GRBL, grbl.Variant.GRBLHAL])),
    st.builds(grbl.Banner, NAMES, st.just(grbl.Variant.FLUIDNC), NAMES),
)


@st.composite
def reports(draw: st.DrawFn) -> grbl.StatusReport:
    """Draw a status report with any fields."""
    free, rates = draw(st.booleans()), draw(st.booleans())
    return grbl.StatusReport(
        draw(st.sampled_from(grbl.State) | st.text(string.ascii_letters, min_size=1, max_size=8)),
        draw(st.none() | st.integers(0, 999)),
        draw(st.none() | COORDINATES),
        free_blocks=draw(COUNTS) if free else None,
        free_bytes=draw(COUNTS) if free else None,
        feed=draw(FEEDS) if rates else None,
        speed=draw(FEEDS) if rates else None,
        pins=draw(st.none() | st.text("XYZPDHRS", max_size=4)),
        others=draw(st.sampled_from([(), ("Ov:100,50,100", "A:SF"), ("WCO:1.000", "SD:3.5,/a")])),
    )


INFO = st.one_of(
    st.builds(grbl.Setting, st.integers(0, 400), NAMES),
    st.builds(grbl.Setting, st.sampled_from(["N0", "N1", "/axes/x/steps_per_mm"]), NAMES),
    st.builds(grbl.Feedback, NAMES),
    st.builds(
        grbl.Remark,
        st.sampled_from(
            ["[HLP:$$ $#]", "[echo: G1X1]", "[FIRMWARE:grblHAL]", "[G54:0.000]", ">G54:error:7"]
        ),
    ),
)
ANSWERS = st.one_of(
    *(
        st.just(grbl.Ok()),
        st.builds(grbl.Error, BYTE),
        st.builds(Alarm, BYTE),
        BANNERS,
        reports(),
        INFO,
    )
)


# -- The ends of the codec for the long fuzz run ---------------------------------------------------

REALTIME = st.sampled_from((b"", b"", b"?", b"!", b"\x85"))
LINES = st.builds(
    lambda realtime, command: realtime + command.text.encode() + b"\n", REALTIME, COMMANDS
)


def _host_saw_one(host: grbl.Host) -> bool:
    found = events(host)
    if host.outstanding is None:
        host.send(grbl.SystemCommand.QUERY_SETTINGS)
    return any(not isinstance(event, grbl.Unreadable) for event in found)


class Board:
    """A device behind the receive interrupt of its board."""

    def __init__(self) -> None:
        self.device = grbl.Device(grbl.GRBLHAL)

    def receive_data(self, data: bytes) -> None:
        for piece in grbl.pieces(data):
            if isinstance(piece, bytes):
                self.device.receive_data(piece)

    def next_event(self) -> grbl.LineReceived | None:
        return self.device.next_event()


def _board_saw_one(board: Board) -> bool:
    lines = events(board)
    for _ in lines:
        board.device.send(grbl.Ok())
    return any(not isinstance(line.content, grbl.Rejected | grbl.Empty) for line in lines)


HOST = FuzzCase(
    "grbl host",
    lambda: grbl.Host(SIX_AXES),
    ANSWERS.map(grbl.encode_answer),
    _host_saw_one,
)
DEVICE = FuzzCase("grbl device", Board, LINES, _board_saw_one)
