"""Received lines: what they ask for, which code refuses them, and what they do to the modes."""

import pytest
from grbl_strategies import GCODE, JOGS, SYSTEM
from hypothesis import given

from firmware_protocol import grbl

REFUSED = [
    *(("1X", 1), ("G1X1=", 1), ("GX", 2), ("G1X", 2), ("X-", 2), ("F-1", 4), ("M3S-1", 4)),
    *(("G5", 20), ("M6", 20), ("G59.4", 23), ("G1.5", 23), ("M3.5", 23), ("G38", 20), ("D1", 20)),
    *(
        ("G90.1", 20),
        ("G0G1", 24),
        ("G90G91", 21),
        ("M3M5", 21),
        ("G20G21", 21),
        ("M62P0M63P0", 21),
    ),
    *(("G92X0G1X1", 24), ("X1X2", 25), ("F1F2", 25), ("N99999999", 27), ("T256", 38)),
    *(("$X1", 3), ("$Q", 2), ("$JX", 3), ("$1=", 2), ("$1=2X", 3), ("$256=1", 3), ("$1", 3)),
    *(("$RST=!", 3), ("$RST", 3), ("$HQ", 3), ("$HXY", 3), ("$SLEEP", 3), ("$N2=G54", 3)),
    ("G1" + "X" * 78, 11),
]

MODAL_REFUSED = [
    *(("G1X1", 22), ("G1", 22), ("X1G80", 31), ("G2X1I1", 22), ("G2F1I1", 26), ("G2F1Z1I1", 32)),
    *(("G2F1X1", 35), ("G2F1X1I1R1", 36), ("G4", 28), ("G10L2X1", 28), ("G10L2P1", 26)),
    *(("G10L2P7X1", 29), ("G10L3P1X1", 20), ("G92", 26), ("G53G2F1X1I1", 30), ("G43.1X1", 37)),
    *(("G1F1X1P1", 36), ("M62", 28), ("M67E1", 28), ("G93G1X1", 22), ("G38.2F1", 26)),
]

JOGS_REFUSED = [
    *(("X1", 22), ("G91F1", 26), ("X1F1S1", 36), ("G1X1F1", 16), ("G54X1F1", 16), ("M3X1F1", 16)),
    *(("G92X1F1", 16), ("X1F0", 22), ("G0X1F1", 16)),
]


@pytest.mark.parametrize(("text", "code"), REFUSED)
def test_lines_that_no_state_admits_carry_their_code(text, code):
    content = grbl.parse_line(text, grbl.MEGA_5X)
    assert isinstance(content, grbl.Rejected)
    assert content.code == code, content.reason


@pytest.mark.parametrize(("text", "code"), MODAL_REFUSED)
def test_blocks_that_the_modes_do_not_admit_carry_their_code(text, code):
    with pytest.raises(grbl.GcodeError) as caught:
        grbl.Modal().after(grbl.parse_block(text, grbl.MEGA_5X))
    assert caught.value.code == code


@pytest.mark.parametrize(("text", "code"), JOGS_REFUSED)
def test_jogs_that_are_not_admitted_carry_their_code(text, code):
    with pytest.raises(grbl.GcodeError) as caught:
        grbl.Modal().after(grbl.parse_line(f"$J={text}", grbl.MEGA_5X))
    assert caught.value.code == code


def test_a_lost_line_end_gives_the_error_that_was_seen():
    assert grbl.parse_line("G1X1F100G1X2F100", grbl.MEGA_5X).code == 24


def test_what_a_board_lacks_it_refuses():
    assert grbl.parse_line("A1", grbl.GRBL).code == 20
    assert grbl.parse_line("M62P0", grbl.GRBL).code == 20
    assert grbl.parse_line("$HX", grbl.GRBL).code == 3
    assert grbl.parse_line("$HXY", grbl.GRBLHAL) == grbl.Home("XY")
    assert grbl.parse_line("$300=1", grbl.GRBLHAL) == grbl.SetSetting(300, 1.0)


def test_a_block_holds_its_words():
    block = grbl.parse_line("N7G90G1X-1.5A2F300", grbl.MEGA_5X)
    assert block == grbl.Block(
        {grbl.Group.DISTANCE: "G90", grbl.Group.MOTION: "G1"},
        {"X": -1.5, "A": 2.0},
        {"N": 7.0, "F": 300.0},
        grbl.AxisUse.MOTION,
    )
    assert grbl.parse_line("$J=G53X1F9", grbl.MEGA_5X) == grbl.Block(
        {grbl.Group.NON_MODAL: "G53"}, {"X": 1.0}, {"F": 9.0}, None, jog=True
    )
    assert grbl.parse_line("", grbl.MEGA_5X) == grbl.Empty()
    assert grbl.parse_line("$N0=G54", grbl.MEGA_5X) == grbl.StoreStartupLine(0, "G54")


def test_modes_last_from_block_to_block():
    modes = grbl.Modal()
    for text in ("G91", "G20", "G1X1F10", "M3S100", "X2", "M8"):
        modes = modes.after(grbl.parse_block(text, grbl.MEGA_5X))
    assert modes == grbl.Modal(
        *("G1", "G54", "G17", "G20", "G91", "G94", "M3", "M8"), feed=254.0, speed=100.0
    )
    assert modes.report.line == "[GC:G1 G54 G17 G20 G91 G94 M3 M8 T0 F254 S100]"
    assert grbl.lengths_mm(grbl.parse_block("X2A-1", grbl.MEGA_5X), modes) == {
        "X": 50.8,
        "A": -25.4,
    }
    ended = modes.after(grbl.parse_block("M30", grbl.MEGA_5X))
    assert ended == grbl.Modal("G1", units="G20", feed=254.0, speed=100.0)


def test_a_jog_changes_no_mode_but_has_its_own_while_it_lasts():
    modes = grbl.Modal(units="G20")
    jog = grbl.parse_line("$J=G21G91X1F60", grbl.MEGA_5X)
    during = modes.during(jog)
    assert (during.motion, during.units, during.distance, during.feed) == ("G1", "G21", "G91", 60.0)
    assert modes.after(jog) == modes


def test_a_refused_block_leaves_the_modes():
    modes = grbl.Modal()
    with pytest.raises(grbl.GcodeError):
        modes.after(grbl.parse_block("G91G1X1", grbl.MEGA_5X))
    assert modes == grbl.Modal()


def written(block: grbl.Block) -> str:
    """Return the axis words of a block as a host writes them."""
    return "".join(f"{letter}{grbl.write_number(value)}" for letter, value in block.axes.items())


@given(GCODE)
def test_every_line_of_the_hosts_is_admitted_with_a_feed_and_keeps_its_numbers(command):
    block = grbl.parse_block(command.text, grbl.MEGA_5X)
    grbl.Modal(feed=1.0).after(block)
    assert written(block) in command.text


@given(JOGS)
def test_every_jog_of_the_hosts_is_admitted(jog):
    block = grbl.parse_block(jog.text[len("$J=") :], grbl.MEGA_5X, jog=True)
    grbl.Modal().after(block)
    assert f"{written(block)}F{block.values['F']}" in jog.text


@given(SYSTEM)
def test_every_system_command_is_read_back_as_it_was(command):
    assert grbl.parse_line(command.text, grbl.MEGA_5X) == command


@pytest.mark.parametrize(
    ("raw", "stored"),
    [
        *(("g1 x1.5", "G1X1.5"), ("G1 (a;b) X1 ;end X2", "G1X1"), ("/G0\tX1", "G0X1")),
        *(("(only)", ""), ("(open X1", ""), ("$$ ", "$$"), ("", "")),
    ],
)
def test_lines_are_stored_as_grbl_stores_them(raw, stored):
    assert grbl.clean_line(raw) == stored


def test_each_line_end_counts_on_grbl_and_a_pair_is_one_on_grblhal():
    for dialect, lines in ((grbl.MEGA_5X, ["G0", "", "G1", ""]), (grbl.GRBLHAL, ["G0", "G1", ""])):
        reader = grbl.LineReader(dialect)
        for byte in b"G0\r\nG1\n\n":
            reader.feed(bytes([byte]))
        assert [reader.next_line() for _ in lines] == lines
        assert reader.next_line() is None


def test_the_names_of_settings_keep_their_slashes_on_fluidnc_alone():
    for dialect, stored in (
        (grbl.MEGA_5X, "$AXES=1"),
        (grbl.GRBLHAL, "$AXES=1"),
        (grbl.FLUIDNC, "$/A/XES=1"),
    ):
        reader = grbl.LineReader(dialect)
        reader.feed(b"$/a/xes=1\n/G1X1\n")
        assert reader.next_line() == stored
        assert reader.next_line() == "G1X1"


def test_the_longest_line_passes_and_one_character_more_does_not():
    reader = grbl.LineReader()
    reader.feed(b"X" * 79 + b"\n" + b"X " * 80 + b"\nG0\n")
    assert reader.next_line() == "X" * 79
    assert reader.next_line() == grbl.Unusable("X" * 79, "a line of more than 79 characters")
    assert reader.next_line() == "G0"
