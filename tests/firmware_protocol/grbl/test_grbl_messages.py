"""The bytes of every GRBL line that a host sends, and what is refused before it is sent."""

import math
import struct
from typing import get_args

import pytest
from grbl_strategies import COMMANDS
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol import grbl
from firmware_protocol.errors import BadField
from firmware_protocol.grbl.dialect import NUMBER_MAX, take_number

PLACE = (0.0, -10.0, 5.125)
TEXTS = [
    (grbl.Modes(), "G17G21G90G94G54"),
    (grbl.Modes(relative=True, coordinate_system=59), "G17G21G91G94G59"),
    (grbl.Coolant(on=True), "M8"),
    (grbl.Coolant(on=False), "M9"),
    (grbl.DigitalOutput(0, on=True), "M62P0"),
    (grbl.DigitalOutput(1, on=False), "M63P1"),
    (grbl.DigitalOutput(2, on=True, at_once=True), "M64P2"),
    (grbl.DigitalOutput(3, on=False, at_once=True), "M65P3"),
    (grbl.Help(), "$"),
    (grbl.QuerySettings(), "$$"),
    (grbl.QueryBuildInfo(), "$I"),
    (grbl.QueryParameters(), "$#"),
    (grbl.QueryParserState(), "$G"),
    (grbl.QueryStartupLines(), "$N"),
    (grbl.Unlock(), "$X"),
    (grbl.CheckMode(), "$C"),
    (grbl.Sleep(), "$SLP"),
    (grbl.Home(), "$H"),
    (grbl.Home("B"), "$HB"),
    (grbl.SetSetting(100, 26.667), "$100=26.667"),
    (grbl.StoreStartupLine(1, "G54"), "$N1=G54"),
    (grbl.StoreBuildInfo("ARM 3"), "$I=ARM 3"),
    (grbl.Restore("#"), "$RST=#"),
    (grbl.Line(), ""),
    (grbl.Line("G28.1"), "G28.1"),
]

REFUSED = [
    *(
        (lambda bad=bad: grbl.SetSetting(1, bad), "value")
        for bad in (math.nan, math.inf, "1", True, 2e7)
    ),
    (lambda: grbl.Modes(coordinate_system=60), "coordinate_system"),
    (lambda: grbl.DigitalOutput(-1, on=True), "port"),
    (lambda: grbl.SetSetting(-1, 0), "setting"),
    (lambda: grbl.Home("XX"), "axes"),
    (lambda: grbl.Restore("x"), "what"),
    *((lambda bad=bad: grbl.Line(bad), "text") for bad in ("G1\n", "é", "?", "a!", "~", "\x18", 7)),
    (lambda: grbl.Error(0), "code"),
    (lambda: grbl.Banner("1 1"), "version"),
    (lambda: grbl.Banner(""), "version"),
    (lambda: grbl.Banner("1.1", firmware="v3"), "firmware"),
    (lambda: grbl.Setting("12", "on"), "key"),
    (lambda: grbl.Setting(1, " on"), "value"),
    (lambda: grbl.BuildInfo("V", None, 128), "blocks"),
    (lambda: grbl.Parameter("X", PLACE), "name"),
    (lambda: grbl.StatusReport(grbl.State.IDLE, None, PLACE, free_blocks=1), "free_bytes"),
    (lambda: grbl.StatusReport(grbl.State.IDLE, None, PLACE, speed=1.0), "speed"),
    (lambda: grbl.Parameter("PRB", PLACE), "success"),
    (lambda: grbl.StatusReport(grbl.State.IDLE), "machine_position"),
    (lambda: grbl.StatusReport("Id|le", None, PLACE), "state"),
    (lambda: grbl.StatusReport(grbl.State.IDLE, None, PLACE, others=("FS:1",)), "others"),
    (lambda: grbl.Dialect(axes="XX"), "axes"),
]


@pytest.mark.parametrize(("command", "text"), TEXTS)
def test_the_text_of_every_line(command, text):
    assert command.text == text
    assert not isinstance(grbl.parse_line(text.replace(" ", ""), grbl.MEGA_5X), grbl.Rejected)


def test_the_table_has_every_line():
    assert {type(command) for command, _ in TEXTS} == set(get_args(grbl.Command))


@pytest.mark.parametrize(("build", "field"), REFUSED)
def test_what_does_not_fit_is_refused_by_its_name(build, field):
    with pytest.raises(BadField) as caught:
        build()
    assert caught.value.field == field


@given(COMMANDS)
def test_every_line_with_three_decimals_and_four_digits_fits_a_board_of_six_axes(command):
    assert not set(command.text) & set("?!~ \n")
    assert len(command.text) <= grbl.MEGA_5X.max_line
    assert not isinstance(grbl.parse_line(command.text, grbl.MEGA_5X), grbl.Rejected)


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


@pytest.mark.parametrize(
    ("text", "value"),
    [("+1.5", 1.5), (".5", 0.5), ("5.", 5.0), ("-0.25", -0.25), ("123456789", 123456780.0)],
)
def test_numbers_are_read_as_grbl_reads_them(text, value):
    assert take_number(text, 0) == (value, len(text))


@pytest.mark.parametrize("text", ["", "-", ".", "X", "--1", "e5"])
def test_what_is_no_number(text):
    assert take_number(text, 0) is None


@pytest.mark.parametrize(
    ("text", "writes"),
    [
        *(("$1=255", True), ("$N0=G54", True), ("$I=arm", True), ("$RST=*", True)),
        *(("G10L2P1X0", True), ("g 28.1", True), ("G90G30.1", True), ("(a)G10L20P0X1", True)),
        *(("$$", False), ("$J=G91X1F1", False), ("G1X10", False), ("G28", False), ("$N", False)),
        *(("G100", False), ("", False), ("G92.1", False)),
    ],
)
def test_what_writes_eeprom_is_known(text, writes):
    assert grbl.writes_eeprom(text) is writes
