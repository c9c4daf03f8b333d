"""What the GRBL tests draw from: every line and answer, and every way to cut a stream."""

import string

from hypothesis import strategies as st

from firmware_protocol.grbl import (
    AxesInfo,
    Banner,
    Bracketed,
    BuildInfo,
    CheckMode,
    Coolant,
    DigitalOutput,
    Error,
    Feedback,
    Help,
    Home,
    Line,
    Modes,
    Ok,
    Parameter,
    ParserState,
    QueryBuildInfo,
    QueryParameters,
    QueryParserState,
    QuerySettings,
    QueryStartupLines,
    Restore,
    SetSetting,
    Setting,
    Sleep,
    StartupEcho,
    State,
    StatusReport,
    StoreBuildInfo,
    StoreStartupLine,
    Unlock,
    Variant,
    Version,
    write_number,
)
from firmware_protocol.grbl.answers import Alarm

AXES = "XYZABC"
NUMBERS = st.integers(-9_999_999, 9_999_999).map(lambda n: n / 1000)
FEEDS = st.integers(1, 9_999_999).map(lambda n: n / 1000)
TARGETS = st.dictionaries(st.sampled_from(AXES), NUMBERS, min_size=1, max_size=6)
NAMES = st.text(string.ascii_letters + string.digits + ".-", min_size=1, max_size=12)
COORDINATES = st.tuples(*[NUMBERS] * 6)
BYTE = st.integers(1, 255)

_WORDS = TARGETS.map(lambda axes: "".join(f"{a}{write_number(n)}" for a, n in axes.items()))
_MOVES = st.one_of(
    st.builds("{}G0{}".format, st.sampled_from(["", "G90", "G91", "G90G53"]), _WORDS),
    st.builds("{}G1{}F{}".format, st.sampled_from(["", "G90", "G91", "G90G53"]), _WORDS, FEEDS),
    st.builds("M{}S{}".format, st.sampled_from([3, 4]), FEEDS),
    st.just("M5"),
    st.builds("M{}E{}Q{}".format, st.sampled_from([67, 68]), st.integers(0, 7), NUMBERS),
    st.builds("G4P{}".format, FEEDS),
)
GCODE = st.one_of(
    _MOVES.map(Line),
    st.builds(Modes, st.booleans(), st.integers(54, 59)),
    st.builds(Coolant, st.booleans()),
    st.builds(DigitalOutput, st.integers(0, 7), st.booleans(), st.booleans()),
)
JOGS = st.builds("$J=G21{}{}F{}".format, st.sampled_from(["G90", "G91"]), _WORDS, FEEDS).map(Line)
SYSTEM = st.one_of(
    st.sampled_from([Help(), QuerySettings(), QueryBuildInfo(), QueryParameters(), CheckMode()]),
    st.sampled_from([QueryParserState(), QueryStartupLines(), Unlock(), Sleep()]),
    st.builds(Home, st.sampled_from(["", *AXES])),
    st.builds(SetSetting, st.integers(0, 255), NUMBERS),
    st.builds(StoreStartupLine, st.integers(0, 1), st.sampled_from(["", "G54", "G21G90"])),
    st.builds(StoreBuildInfo, st.text(string.ascii_uppercase, max_size=12)),
    st.builds(Restore, st.sampled_from("$#*")),
)
COMMANDS = st.one_of(GCODE, JOGS, SYSTEM)

COUNTS = st.integers(0, 255)
BANNERS = st.one_of(
    st.builds(Banner, NAMES, st.sampled_from([Variant.GRBL, Variant.GRBLHAL])),
    st.builds(Banner, NAMES, st.just(Variant.FLUIDNC), NAMES),
)


@st.composite
def reports(draw: st.DrawFn) -> StatusReport:
    """Draw a status report with any fields."""
    where = draw(st.sampled_from(["machine_position", "work_position"]))
    free = draw(st.booleans())
    rates = draw(st.lists(FEEDS, max_size=3))
    return StatusReport(
        draw(st.sampled_from(State) | st.text(string.ascii_letters, min_size=1, max_size=8)),
        draw(st.none() | st.integers(0, 999)),
        free_blocks=draw(COUNTS) if free else None,
        free_bytes=draw(COUNTS) if free else None,
        line_number=draw(st.none() | st.integers(0, 99999)),
        **dict(zip(("feed", "speed", "actual_speed"), rates, strict=False)),
        pins=draw(st.none() | st.text("XYZPDHRS", max_size=4)),
        work_offset=draw(st.none() | COORDINATES),
        overrides=draw(st.none() | st.tuples(COUNTS, COUNTS, COUNTS)),
        accessories=draw(st.none() | st.text("SCFM", max_size=3)),
        others=draw(st.sampled_from([(), ("MPG:1",), ("Qm:12", "SD:3.5,/a.nc")])),
        **{where: draw(COORDINATES)},
    )


INFO = st.one_of(
    st.builds(Setting, st.integers(0, 400), NAMES),
    st.builds(Setting, st.sampled_from(["N0", "N1", "/axes/x/steps_per_mm"]), NAMES),
    st.builds(Feedback, NAMES),
    st.builds(Version, NAMES, NAMES),
    st.builds(BuildInfo, st.text("VNMZHL*$#", max_size=6)),
    st.builds(BuildInfo, st.just("VZ"), COUNTS, st.integers(0, 1024), st.just(("6", "0"))),
    st.builds(AxesInfo, st.integers(1, 6), st.just(AXES)),
    st.builds(ParserState, st.lists(NAMES, min_size=1, max_size=9).map(tuple)),
    st.builds(Parameter, st.sampled_from(["G54", "G28", "G92", "G59.1", "TLO"]), COORDINATES),
    st.builds(Parameter, st.just("PRB"), COORDINATES, st.booleans()),
    st.builds(StartupEcho, NAMES, st.none() | BYTE),
    st.builds(Bracketed, st.sampled_from(["HLP:$$ $#", "echo: G1X1", "FIRMWARE:grblHAL", "x"])),
)
ANSWERS = st.one_of(
    *(st.just(Ok()), st.builds(Error, BYTE), st.builds(Alarm, BYTE), BANNERS, reports(), INFO)
)
