"""The Armdroid's codec: the host's machine, the device's, and the two back to back."""

import pytest
from amounts import every_row
from cases_armdroid import ANSWERS, COMMANDS, answer_to, events, some_answer
from chunks import chunked
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol import armdroid
from firmware_protocol.armdroid import (
    LINE_BYTES,
    ArgumentsReported,
    Clear,
    Completed,
    DriveAll,
    DriveOne,
    DropArguments,
    HomeToOffsets,
    Host,
    OffsetsReported,
    ReportArguments,
    ReportOffsets,
    SetSpeed,
    SpeedReported,
    Stray,
    Torque,
    TorqueReported,
    Unreadable,
    Version,
    VersionReported,
    Welcome,
    ZeroOffsets,
)
from firmware_protocol.armdroid.messages import decode_answer, encode_answer
from firmware_protocol.errors import BadField, LocalProtocolError

# -- The host --------------------------------------------------------------------------------------

OFFSETS = OffsetsReported((1, -2, 3, -4, 5, -6))
OFFSETS_LINE = b"offsets = 1,-2,3,-4,5,-6\r\n"


def cleared() -> Host:
    """Return a host whose board has nothing half received."""
    host = Host()
    host.send(Clear())
    host.receive_data(OFFSETS_LINE)
    assert events(host) == [Completed(Clear(), OFFSETS)]
    return host


@every_row(
    "command, data",
    [
        (DriveOne(3, 120), b"3,120d"),
        (DriveOne(3, -120), b"3,120-d"),
        (DriveOne(6, -32768), b"6,32768-d"),
        (DriveAll((1, -2, 0, 4, -5, 32767)), b"1,2-,0,4,5-,32767D"),
        (DriveAll((0,) * 6), b"0,0,0,0,0,0D"),
        (HomeToOffsets(), b"h"),
        (ReportOffsets(), b"o"),
        (ZeroOffsets(), b"r"),
        (SetSpeed(100), b"100s"),
        (Torque(True), b"1t"),
        (Torque(False), b"0t"),
        (Version(), b"v"),
        (ReportArguments(), b"g"),
        (Clear(), b",d"),
        (DropArguments(), b",,,,,d"),
    ],
)
def test_a_command_becomes_these_characters(command, data):
    host = cleared()
    assert host.send(command) == data
    assert host.outstanding == command


@every_row(
    "command, line, answer",
    [
        (DriveAll((1, 2, 3, 4, 5, 6)), OFFSETS_LINE, OFFSETS),
        (HomeToOffsets(), b"offsets = 0,0,0,0,0,0\r\n", OffsetsReported((0,) * 6)),
        (SetSpeed(100), b"speed = 100\r\n", SpeedReported(100)),
        (Torque(True), b"torque = enabled\r\n", TorqueReported(True)),
        (Torque(False), b"torque = disabled\r\n", TorqueReported(False)),
        (Version(), b"firmware version = 2.0/protocol = 1.0a\r\n", VersionReported("2.0", "1.0a")),
        (Version(), b"version = 1.3\r\n", VersionReported("1.3", None)),
        (ReportArguments(), b"debug = 1 2 3 4 -5 6\r\n", ArgumentsReported((1, 2, 3, 4, -5), 6)),
    ],
)
def test_its_own_kind_of_line_completes_a_command(command, line, answer):
    host = Host()
    host.send(command)
    host.receive_data(line)
    assert events(host) == [Completed(command, answer)]
    assert host.outstanding is None


@every_row(
    "line",
    [
        b"offsets = 1,2,3,4,5",
        b"offsets = 1,2,3,4,5,6,7",
        b"offsets = 1,2,3,4,5,40000",
        b"offsets = 1,2,3,4,5,",
        b"offsets=1,2,3,4,5,6",
        b"noise offsets = 1,2,3,4,5,6",
        b"speed = ",
        b"torque = maybe",
        b"firmware version = 2.0/protocol = ",
        b"Welcome, Arm",
        b"1",
        b"\xff\x00",
    ],
)
def test_a_damaged_line_completes_nothing(line):
    host = Host()
    host.send(ReportOffsets())
    host.receive_data(line + b"\r\n" + OFFSETS_LINE)
    bad, good = events(host)
    assert isinstance(bad, Unreadable)
    assert bad.data == line
    assert good == Completed(ReportOffsets(), OFFSETS)


def test_a_version_tells_that_a_given_up_motion_is_over():
    host = Host()
    host.send(DriveOne(1, 30000))
    with pytest.raises(LocalProtocolError, match="DriveOne is unanswered"):
        host.send(Version())
    host.give_up()
    host.send(Version())
    host.receive_data(OFFSETS_LINE + b"version = 1.3\r\n")
    assert events(host) == [Stray(OFFSETS), Completed(Version(), VersionReported("1.3", None))]


def test_a_welcome_is_told_and_answers_nothing():
    host = Host()
    host.send(Version())
    host.receive_data(b"Welcome, Armdroid!\r\nversion = 1.3\r\n")
    found = events(host)
    assert found == [Welcome(), Completed(Version(), VersionReported("1.3", None))]
    assert not host.clean


def test_arguments_are_dropped_only_where_nothing_can_be_left_in_the_board():
    host = Host()
    with pytest.raises(LocalProtocolError, match="send Clear"):
        host.send(DropArguments())
    host.receive_data(b"Welcome, Armdroid!\r\n")
    events(host)
    assert host.clean
    host.send(DropArguments())
    host.give_up()
    assert not host.clean


@given(ANSWERS)
def test_every_answer_reads_back_as_itself_in_one_short_line(answer):
    line = encode_answer(answer)
    assert line.endswith(b"\r\n")
    assert len(line) <= LINE_BYTES
    assert decode_answer(line[:-2]) == answer


REFUSED = [
    (lambda: DriveOne(256, 5), "motor"),
    (lambda: DriveOne(True, 5), "motor"),
    (lambda: DriveOne(1, 32768), "steps"),
    (lambda: DriveOne(1, 1.0), "steps"),
    (lambda: DriveAll((1, 2, 3, 4, 5)), "steps"),
    (lambda: DriveAll("123456"), "steps"),
    (lambda: DriveAll((0, 0, 0, -32769, 0, 0)), "steps[3]"),
    (lambda: SetSpeed(32768), "rpm"),
    (lambda: Torque(1), "on"),
    (lambda: OffsetsReported((0,) * 7), "offsets"),
    (lambda: SpeedReported(40000), "rpm"),
    (lambda: TorqueReported("on"), "on"),
    (lambda: VersionReported(""), "firmware"),
    (lambda: VersionReported("2.0", "1/0"), "protocol"),
    (lambda: ArgumentsReported((0,) * 6, 0), "arguments"),
    (lambda: ArgumentsReported((0,) * 5, None), "accumulator"),
]


@every_row("build, field", REFUSED)
def test_numbers_out_of_range_are_refused_by_name(build, field):
    with pytest.raises(BadField) as refusal:
        build()
    assert refusal.value.field == field


# -- The device ------------------------------------------------------------------------------------

ZEROS = (0,) * 5


def said(data: bytes, device: armdroid.Device | None = None) -> list[object]:
    device = device or armdroid.Device()
    device.receive_data(data)
    return events(device)


# each worked out by hand along the sketch's loop()
@every_row(
    "data, expected",
    [
        (b"3,120d", [armdroid.DriveOne(3, 120)]),
        (b"3,120-d", [armdroid.DriveOne(3, -120)]),
        (b"3,-120d", [armdroid.DriveOne(3, 120)]),  # a minus in front negates the 0 it finds
        (b"3,12-0d", [armdroid.DriveOne(3, -120)]),  # -12 * 10 + 0
        (b"3,12-3d", [armdroid.DriveOne(3, -117)]),  # -12 * 10 + 3
        (b"1,2,3,4,5,6D", [armdroid.DriveAll((1, 2, 3, 4, 5, 6))]),
        (b"1,2-,3,4-,5,6-D", [armdroid.DriveAll((1, -2, 3, -4, 5, -6))]),
        (b"9D", [armdroid.DriveAll((0, 0, 0, 0, 0, 9))]),
        (b"d", [armdroid.DriveOne(0, 0)]),
        (b"7,5d", [armdroid.DriveOne(7, 5)]),
        (b"257,5d", [armdroid.DriveOne(1, 5)]),  # the motor is a uint8_t
        (b"1-,5d", [armdroid.DriveOne(255, 5)]),
        (b"1,32768d", [armdroid.DriveOne(1, -32768)]),  # 3276 * 10 + 8 wraps
        (b"1,32768-d", [armdroid.DriveOne(1, -32768)]),  # and its negative is itself
        (b"1,65537d", [armdroid.DriveOne(1, 1)]),
        (b"h", [armdroid.HomeToOffsets()]),
        (b"o", [armdroid.ReportOffsets()]),
        (b"r", [armdroid.ZeroOffsets()]),
        (b"100s", [armdroid.SetSpeed(100)]),
        (b"s", [armdroid.SetSpeed(0)]),
        (b"5-s", [armdroid.SetSpeed(-5)]),
        (b"2000s", [armdroid.SetSpeed(2000)]),
        (
            b"1t0tt7-t",
            [
                armdroid.Torque(True),
                armdroid.Torque(False),
                armdroid.Torque(False),
                armdroid.Torque(True),
            ],
        ),
        (b"v", [armdroid.Version()]),
        (b"g", [armdroid.ReportArguments()]),
    ],
)
def test_characters_are_read_as_the_sketch_reads_them(data, expected):
    assert said(data) == expected


def test_the_letters_of_another_dialect_repeat_the_last_motion_of_motors_1_to_5():
    device = armdroid.Device()
    assert said(b"10,20,30,40,50,60D", device) == [armdroid.DriveAll((10, 20, 30, 40, 50, 60))]
    assert said(b"@READ\r", device) == [armdroid.DriveAll((10, 20, 30, 40, 50, 0))]
    assert said(b"@DELAY 3\r", device) == [armdroid.DriveAll((10, 20, 30, 40, 50, 0))]
    assert said(b"@QDUMP\r", device) == [armdroid.DriveAll((10, 20, 30, 40, 50, 3))]


# what is left of "7,8" (index 1, accumulator 8) behind each letter
@every_row(
    "letter, arguments, accumulator, next_argument_goes_to",
    [
        (b"h", (7, 0, 0, 0, 0), 8, 1),
        (b"o", (7, 0, 0, 0, 0), 8, 1),
        (b"v", (7, 0, 0, 0, 0), 8, 1),
        (b"g", (7, 0, 0, 0, 0), 8, 1),
        (b"s", (7, 0, 0, 0, 0), 0, 1),
        (b"t", (7, 0, 0, 0, 0), 0, 1),
        (b"d", (7, 0, 0, 0, 0), 0, 0),
        (b"D", (7, 0, 0, 0, 0), 0, 0),
        (b"r", ZEROS, 0, 0),
    ],
)
def test_each_letter_forgets_what_the_sketch_forgets(
    letter, arguments, accumulator, next_argument_goes_to
):
    device = armdroid.Device()
    said(b"7,8" + letter, device)
    assert (device.arguments, device.accumulator) == (arguments, accumulator)
    said(b",", device)
    changed = list(arguments)
    changed[next_argument_goes_to] = accumulator
    assert device.arguments == tuple(changed)


def test_commands_during_a_motion_wait_for_its_answer():
    device = armdroid.Device()
    device.receive_data(b"1,5d1,6dv")
    assert device.next_event() == armdroid.DriveOne(1, 5)
    assert device.next_event() is None
    with pytest.raises(LocalProtocolError, match="OffsetsReported is owed"):
        device.send(armdroid.VersionReported())
    with pytest.raises(LocalProtocolError, match="between commands"):
        device.send(armdroid.Welcome())
    device.send(some_answer(device))
    assert events(device) == [armdroid.DriveOne(1, 6), armdroid.Version()]
    with pytest.raises(LocalProtocolError, match="nothing is owed"):
        device.send(armdroid.VersionReported())


@given(st.binary(max_size=60), st.text("0123456789,-", max_size=40))
def test_a_comma_and_a_d_clear_whatever_was_left_and_move_nothing(noise, numbers):
    device = armdroid.Device()
    said(noise + numbers.encode(), device)
    (event,) = said(b",d", device)
    assert isinstance(event, armdroid.DriveOne)
    assert event.steps == 0
    assert said(b",,,,,d", device) == [armdroid.DriveOne(0, 0)]
    assert device.arguments == ZEROS
    assert said(b"@READ\r", device) == [armdroid.DriveAll((0,) * 6)]


# -- Back to back ----------------------------------------------------------------------------------


def carry(draw, data: bytes, machine: armdroid.Host | armdroid.Device) -> None:
    for chunk in draw(chunked(data)):
        machine.receive_data(chunk)


@given(st.lists(COMMANDS, max_size=6), st.data())
def test_every_script_arrives_whole_at_both_ends(script, data):
    host, device = armdroid.Host(), armdroid.Device()
    for command in [armdroid.Clear(), *script]:
        carry(data.draw, host.send(command), device)
        request = device.next_event()
        if isinstance(command, armdroid.Clear | armdroid.DropArguments):
            assert isinstance(request, armdroid.DriveOne)
            assert request.steps == 0
        else:
            assert request == command
        answer = data.draw(answer_to(request))
        carry(data.draw, device.send(answer), host)
        assert events(host) == [armdroid.Completed(command, answer)]
        assert (host.outstanding, device.unanswered) == (None, None)
        assert host.clean
