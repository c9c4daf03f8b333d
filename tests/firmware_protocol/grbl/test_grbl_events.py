"""What a board's lines mean to the host's machine: positions, alarms, the firmware itself."""

import pytest
from chunks import events

from firmware_protocol.grbl import (
    ALARMS,
    FLUIDNC,
    GRBL,
    GRBLHAL,
    MEGA_5X,
    AlarmRaised,
    Host,
    Line,
    StatusReported,
    Unreadable,
    Variant,
)

X1, X2, X3 = (Line(f"G90G1X{n}F100") for n in (1, 2, 3))
BANNER = b"\r\nGrbl 1.1h ['$' for help]\r\n"


def heard(host: Host, data: bytes) -> list:
    host.receive_data(data)
    return events(host)


def sent(*commands, dialect=MEGA_5X) -> Host:
    host = Host(dialect)
    for command in commands:
        host.send(command)
    return host


def test_positions_are_known_in_both_spaces_once_the_offset_was_reported():
    host = Host()
    found = heard(
        host,
        b"<Idle|WPos:1.000,2.000,3.000>\n<Idle|WPos:1.000,2.000,3.000|WCO:0.100,0.200,-4.000>\n"
        b"<Jog|MPos:1.100,2.200,3.300>\n",
    )
    places = [(event.machine_position, event.work_position) for event in found]
    assert places == [
        (None, (1.0, 2.0, 3.0)),
        ((1.1, 2.2, -1.0), (1.0, 2.0, 3.0)),
        ((1.1, 2.2, 3.3), (1.0, 2.0, 7.3)),
    ]
    heard(host, BANNER)
    (after,) = heard(host, b"<Idle|WPos:1.000,2.000,3.000>\n")
    assert isinstance(after, StatusReported)
    assert after.machine_position is None


def test_a_report_with_another_number_of_axes_is_not_believed():
    (event,) = heard(Host(MEGA_5X), b"<Idle|MPos:0.000,0.000,0.000>\n")
    assert isinstance(event, Unreadable)
    assert event.reason == "3 coordinates, but the board has 6 axes"


@pytest.mark.parametrize("code", range(1, 19))
def test_an_alarm_tells_whether_the_position_is_kept(code):
    (event,) = heard(Host(), b"ALARM:%d\r\n" % code)
    assert isinstance(event, AlarmRaised)
    assert event.position_kept == (code in (2, 4, 5))
    assert event.meaning == (ALARMS[code].meaning if code <= 9 else event.meaning)


def test_codes_above_grbls_mean_what_the_firmware_says():
    texts = {
        heard(Host(dialect), b"ALARM:10\r\n")[0].meaning for dialect in (GRBL, GRBLHAL, FLUIDNC)
    }
    assert len(texts) == 3


def test_the_firmware_is_found_out():
    host = Host(MEGA_5X)
    heard(host, b"GrblHAL 1.1f ['$' or '$HELP' for help]\r\n")
    assert host.dialect.variant is Variant.GRBLHAL
    host = Host(MEGA_5X)
    heard(host, b"[FIRMWARE:grblHAL]\r\n" + BANNER)
    assert host.dialect.variant is Variant.GRBLHAL
    heard(host, b"[VER:3.7 FluidNC v3.7.8:]\r\n")
    assert host.dialect.variant is Variant.FLUIDNC


def test_refusals_and_alarms_in_words_are_not_lost():
    host = sent(Line("G4P1"))
    (refused, alarm) = heard(host, b"error:Bad number format\r\nALARM: Hard limit\r\n")
    assert (refused.command, refused.code, refused.meaning) == (
        Line("G4P1"),
        None,
        "Bad number format",
    )
    assert (alarm.code, alarm.meaning, alarm.position_kept) == (None, "Hard limit", False)
