"""The host's end: which messages can be built, their bytes, and which line completes each."""

import pytest
from armdroid_strategies import ANSWERS, events
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol.armdroid import (
    LINE_BYTES,
    ArgumentsReported,
    Clear,
    Completed,
    DriveAll,
    DriveNone,
    DriveOne,
    DropArguments,
    HomeToOffsets,
    Host,
    InterfaceKind,
    InterfaceReported,
    OddSpeed,
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

OFFSETS = OffsetsReported((1, -2, 3, -4, 5, -6))
OFFSETS_LINE = b"offsets = 1,-2,3,-4,5,-6\r\n"


def cleared() -> Host:
    """Return a host whose board has nothing half received."""
    host = Host()
    host.send(Clear())
    host.receive_data(OFFSETS_LINE)
    assert events(host) == [Completed(Clear(), OFFSETS)]
    return host


@pytest.mark.parametrize(
    ("command", "data"),
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
        (InterfaceKind(), b"V"),
        (ReportArguments(), b"g"),
        (Clear(), b",d"),
        (DropArguments(), b",,,,,d"),
    ],
)
def test_a_command_becomes_these_characters(command, data):
    host = cleared()
    assert host.send(command) == data
    assert host.outstanding == command


@pytest.mark.parametrize(
    ("command", "line", "answer"),
    [
        (DriveAll((1, 2, 3, 4, 5, 6)), OFFSETS_LINE, OFFSETS),
        (HomeToOffsets(), b"offsets = 0,0,0,0,0,0\r\n", OffsetsReported((0,) * 6)),
        (SetSpeed(100), b"speed = 100\r\n", SpeedReported(100)),
        (Torque(True), b"torque = enabled\r\n", TorqueReported(True)),
        (Torque(False), b"torque = disabled\r\n", TorqueReported(False)),
        (Version(), b"firmware version = 2.0/protocol = 1.0a\r\n", VersionReported("2.0", "1.0a")),
        (Version(), b"version = 1.3\r\n", VersionReported("1.3", None)),
        (InterfaceKind(), b"interface = logic-drive\r\n", InterfaceReported("logic-drive")),
        (ReportArguments(), b"debug = 1 2 3 4 -5 6\r\n", ArgumentsReported((1, 2, 3, 4, -5), 6)),
    ],
)
def test_its_own_kind_of_line_completes_a_command(command, line, answer):
    host = Host()
    host.send(command)
    host.receive_data(line)
    assert events(host) == [Completed(command, answer)]
    assert host.outstanding is None


@pytest.mark.parametrize(
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


def test_one_command_is_outstanding_at_a_time():
    host = Host()
    host.send(DriveOne(1, 5))
    with pytest.raises(LocalProtocolError, match="DriveOne is unanswered"):
        host.send(ReportOffsets())
    assert host.outstanding == DriveOne(1, 5)


def test_a_version_tells_that_a_given_up_motion_is_over():
    host = Host()
    host.send(DriveOne(1, 30000))
    assert host.give_up() == DriveOne(1, 30000)
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


def test_a_number_that_the_board_repeats_is_compared():
    assert Completed(SetSpeed(100), SpeedReported(100)).as_asked
    assert not Completed(SetSpeed(100), SpeedReported(7100)).as_asked
    assert not Completed(Torque(False), TorqueReported(True)).as_asked
    assert Completed(DriveOne(1, 5), OFFSETS).as_asked


@given(ANSWERS)
def test_every_answer_reads_back_as_itself_in_one_short_line(answer):
    line = encode_answer(answer)
    assert line.endswith(b"\r\n")
    assert len(line) <= LINE_BYTES
    assert decode_answer(line[:-2]) == answer


@given(st.binary(max_size=400))
def test_after_any_garbage_the_second_answer_is_read(garbage):
    host = Host()
    host.receive_data(garbage)
    host.receive_data(OFFSETS_LINE * 2)
    assert events(host)[-1] == Stray(OFFSETS)


REFUSED = [
    (lambda: DriveOne(0, 5), "motor"),
    (lambda: DriveOne(7, 5), "motor"),
    (lambda: DriveOne(True, 5), "motor"),
    (lambda: DriveOne(1, 32768), "steps"),
    (lambda: DriveOne(1, 1.0), "steps"),
    (lambda: DriveAll((1, 2, 3, 4, 5)), "steps"),
    (lambda: DriveAll("123456"), "steps"),
    (lambda: DriveAll((0, 0, 0, -32769, 0, 0)), "steps[3]"),
    (lambda: SetSpeed(0), "rpm"),  # the sketch divides by it
    (lambda: SetSpeed(1251), "rpm"),  # the interval becomes 0 ms
    (lambda: Torque(1), "on"),
    (lambda: DriveNone(3, 5), "motor"),
    (lambda: DriveNone(256, 5), "motor"),
    (lambda: OddSpeed(100), "rpm"),
    (lambda: OffsetsReported((0,) * 7), "offsets"),
    (lambda: SpeedReported(40000), "rpm"),
    (lambda: TorqueReported("on"), "on"),
    (lambda: VersionReported(""), "firmware"),
    (lambda: VersionReported("2.0", "1/0"), "protocol"),
    (lambda: InterfaceReported("two words"), "kind"),
    (lambda: ArgumentsReported((0,) * 6, 0), "arguments"),
    (lambda: ArgumentsReported((0,) * 5, None), "accumulator"),
]


@pytest.mark.parametrize(("build", "field"), REFUSED)
def test_what_does_not_fit_is_refused_by_name(build, field):
    with pytest.raises(BadField) as refusal:
        build()
    assert refusal.value.field == field


def test_a_list_of_steps_becomes_a_value():
    assert DriveAll([1, 2, 3, 4, 5, 6]) == DriveAll((1, 2, 3, 4, 5, 6))
    assert hash(OffsetsReported([0] * 6)) == hash(OffsetsReported((0,) * 6))
