"""GRBL's machines: the host's, the device's, and the two together."""

import pytest
from amounts import every_row
from cases_grbl import COMMANDS, SIX_AXES
from chunks import carried, events
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol import grbl
from firmware_protocol.errors import LocalProtocolError

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


def test_realtime_commands_are_bytes_of_their_own_and_legal_at_any_time():
    host = sent(X1)
    assert host.send_realtime(grbl.Realtime.STATUS) == b"?"
    assert host.send_realtime(grbl.Realtime.JOG_CANCEL) == b"\x85"
    assert host.outstanding == X1
    with pytest.raises(LocalProtocolError):
        host.send_realtime("?")


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


def test_the_machine_position_is_known_once_the_offset_was_reported():
    host = grbl.Host()
    found = heard(
        host,
        b"<Idle|WPos:1.000,2.000,3.000>\n<Idle|WPos:1.000,2.000,3.000|WCO:0.100,0.200,-4.000>\n"
        b"<Jog|MPos:1.100,2.200,3.300>\n<Jog|WPos:1.000,2.000,3.100>\n",
    )
    positions = [None, (1.1, 2.2, -1.0), (1.1, 2.2, 3.3), (1.1, 2.2, -0.9)]
    assert [event.machine_position for event in found] == positions
    heard(host, BANNER)
    (after,) = heard(host, b"<Idle|WPos:1.000,2.000,3.000>\n")
    assert isinstance(after, grbl.StatusReported)
    assert after.machine_position is None


def test_an_offset_of_other_axes_than_the_board_has_is_not_used():
    host = grbl.Host()
    heard(host, b"<Idle|WPos:1.000,2.000,3.000|WCO:0.100,0.200,-4.000>\n")
    host.dialect = SIX_AXES
    (report,) = heard(host, b"<Idle|WPos:1,2,3,4,5,6>\n")
    assert report.machine_position is None


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


def test_refusals_and_alarms_in_words_are_not_lost():
    host = sent(grbl.Line("G4P1"))
    (refused, alarm) = heard(host, b"error:Bad number format\r\nALARM: Hard limit\r\n")
    assert (refused.command, refused.code, refused.meaning) == (
        grbl.Line("G4P1"),
        None,
        "Bad number format",
    )
    assert (alarm.code, alarm.meaning, alarm.position_kept) == (None, "Hard limit", False)


# -- The device, and both machines wired to each other ---------------------------------------------

TEXT = X1.text
NOISE = st.binary(min_size=1, max_size=300)


def test_a_stream_is_parted_into_realtime_commands_and_text_in_their_order():
    data = b"G1?X\x85\xff1\x91\n"
    commands = (grbl.Realtime.STATUS, grbl.Realtime.JOG_CANCEL, grbl.Realtime.FEED_PLUS_10)
    status, cancel, plus = commands
    assert [*grbl.pieces(data)] == [b"G1", status, b"X", cancel, b"1", plus, b"\n"]
    assert grbl.split_realtime(data) == (commands, b"G1X1\n")
    assert grbl.split_realtime(b"\x19\x80G\n") == ((), b"\x19G\n")
    both = (grbl.Realtime.STOP, grbl.Realtime.STATUS_ALIAS)
    assert grbl.split_realtime(b"\x19\x80G\n", grbl.Variant.GRBLHAL) == (both, b"G\n")


@every_row("command", grbl.Realtime)
def test_every_realtime_command_arrives_where_the_firmware_has_it(command):
    byte = grbl.Host().send_realtime(command)
    assert grbl.split_realtime(byte, grbl.Variant.GRBLHAL) == ((command,), b"")
    known = command not in grbl.GRBLHAL_ONLY
    assert grbl.split_realtime(byte)[0] == ((command,) if known else ())


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


def test_after_a_banner_nothing_is_owed_and_discarded_bytes_are_gone():
    device = grbl.Device(SIX_AXES)
    device.receive_data(b"G0\nG1\nG")
    device.next_event()
    device.discard()
    assert (device.unanswered, events(device)) == (0, [])
    device.receive_data(b"$X\n")
    assert device.next_event() == grbl.LineReceived("$X", grbl.SystemCommand.UNLOCK)
    assert device.send(grbl.Banner()) == b"\r\nGrbl 1.1h ['$' for help]\r\n"
    assert device.unanswered == 0


@given(st.lists(st.tuples(COMMANDS, st.booleans()), max_size=6), st.data())
def test_every_script_arrives_whole_at_both_ends(script, data):
    host, device = grbl.Host(SIX_AXES), grbl.Device(SIX_AXES)
    for command, taken in script:
        (line,) = carried(data.draw, host.send(command), device)
        assert (line.text, line.content) == (
            command.text,
            grbl.parse_line(command.text, SIX_AXES),
        )
        (event,) = carried(data.draw, device.send(grbl.Ok() if taken else grbl.Error(9)), host)
        assert isinstance(event, grbl.Acknowledged if taken else grbl.Refused)
        assert event.command == command
    assert (host.outstanding, device.unanswered) == (None, 0)
