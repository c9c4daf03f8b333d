"""The board's end: the sketch's character machine, with all that it keeps."""

import pytest
from armdroid_strategies import events, some_answer
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol import armdroid
from firmware_protocol.errors import LocalProtocolError

ZEROS = (0,) * 5


def said(data: bytes, device: armdroid.Device | None = None) -> list[object]:
    """Give a device bytes, and leave out what it ignores."""
    device = device or armdroid.Device()
    device.receive_data(data)
    return [event for event in events(device) if not isinstance(event, armdroid.Ignored)]


# each worked out by hand along the sketch's loop()
@pytest.mark.parametrize(
    ("data", "expected"),
    [
        (b"3,120d", [armdroid.DriveOne(3, 120)]),
        (b"3,120-d", [armdroid.DriveOne(3, -120)]),
        (b"3,-120d", [armdroid.DriveOne(3, 120)]),  # a minus in front negates the 0 it finds
        (b"3,12-0d", [armdroid.DriveOne(3, -120)]),  # -12 * 10 + 0
        (b"3,12-3d", [armdroid.DriveOne(3, -117)]),  # -12 * 10 + 3
        (b"1,2,3,4,5,6D", [armdroid.DriveAll((1, 2, 3, 4, 5, 6))]),
        (b"1,2-,3,4-,5,6-D", [armdroid.DriveAll((1, -2, 3, -4, 5, -6))]),
        (b"9D", [armdroid.DriveAll((0, 0, 0, 0, 0, 9))]),
        (b"d", [armdroid.DriveNone(0, 0)]),
        (b"7,5d", [armdroid.DriveNone(7, 5)]),
        (b"257,5d", [armdroid.DriveOne(1, 5)]),  # the motor is a uint8_t
        (b"1-,5d", [armdroid.DriveNone(255, 5)]),
        (b"1,32768d", [armdroid.DriveOne(1, -32768)]),  # 3276 * 10 + 8 wraps
        (b"1,32768-d", [armdroid.DriveOne(1, -32768)]),  # and its negative is itself
        (b"1,65537d", [armdroid.DriveOne(1, 1)]),
        (b"h", [armdroid.HomeToOffsets()]),
        (b"o", [armdroid.ReportOffsets()]),
        (b"r", [armdroid.ZeroOffsets()]),
        (b"100s", [armdroid.SetSpeed(100)]),
        (b"s", [armdroid.OddSpeed(0)]),
        (b"5-s", [armdroid.OddSpeed(-5)]),
        (b"2000s", [armdroid.OddSpeed(2000)]),
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
        (b"V", [armdroid.InterfaceKind()]),
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


def test_driving_one_motor_leaves_its_number_behind_as_an_argument():
    device = armdroid.Device()
    said(b"10,20,30,40,50,60D4,200d", device)
    assert device.arguments == (4, 20, 30, 40, 50)
    assert said(b"D", device) == [armdroid.DriveAll((4, 20, 30, 40, 50, 0))]


# what is left of "7,8" (index 1, accumulator 8) behind each letter
@pytest.mark.parametrize(
    ("letter", "arguments", "accumulator", "next_argument_goes_to"),
    [
        (b"h", (7, 0, 0, 0, 0), 8, 1),
        (b"o", (7, 0, 0, 0, 0), 8, 1),
        (b"v", (7, 0, 0, 0, 0), 8, 1),
        (b"V", (7, 0, 0, 0, 0), 8, 1),
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
    assert device.clean is (next_argument_goes_to == 0 and accumulator == 0)
    said(b",", device)
    changed = list(arguments)
    changed[next_argument_goes_to] = accumulator
    assert device.arguments == tuple(changed)


def test_a_sixth_comma_starts_the_arguments_anew():
    device = armdroid.Device()
    said(b"1,2,3,4,5,6,7,", device)
    assert device.arguments == (7, 2, 3, 4, 5)


def test_a_new_session_forgets_everything_half_received():
    device = armdroid.Device()
    said(b"1,2,3", device)
    assert device.send(armdroid.Welcome()) == b"Welcome, Armdroid!\r\n"
    assert (device.arguments, device.accumulator, device.clean) == (ZEROS, 0, True)


@pytest.mark.parametrize(
    ("data", "answer", "line"),
    [
        (b"o", armdroid.OffsetsReported((1, -2, 3, -4, 5, -6)), b"offsets = 1,-2,3,-4,5,-6\r\n"),
        (b"100s", armdroid.SpeedReported(100), b"speed = 100\r\n"),
        (b"1t", armdroid.TorqueReported(True), b"torque = enabled\r\n"),
        (b"0t", armdroid.TorqueReported(False), b"torque = disabled\r\n"),
        (b"v", armdroid.VersionReported(), b"firmware version = 2.0/protocol = 1.0a\r\n"),
        (b"v", armdroid.VersionReported("1.3", None), b"version = 1.3\r\n"),
        (b"V", armdroid.InterfaceReported(), b"interface = direct-drive\r\n"),
        (b"g", armdroid.ArgumentsReported((1, 2, 3, 4, -5), 6), b"debug = 1 2 3 4 -5 6\r\n"),
    ],
)
def test_answers_are_printed_as_the_sketch_prints_them(data, answer, line):
    device = armdroid.Device()
    device.receive_data(data)
    assert device.next_event() is not None
    assert device.send(answer) == line
    assert device.unanswered is None


def test_what_comes_during_a_motion_waits_for_its_answer():
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


def test_what_finds_no_room_is_lost_and_told_where_it_stood():
    device = armdroid.Device(room_bytes=8)
    device.receive_data(b"1,5d")
    assert device.next_event() == armdroid.DriveOne(1, 5)
    device.receive_data(b"2,6d3,7d4,8d")
    device.receive_data(b"o")
    assert device.buffered == 8
    device.send(some_answer(device))
    assert events(device) == [armdroid.DriveOne(2, 6), armdroid.DriveOne(3, 7), armdroid.Overrun(5)]
    assert said(b"o", device) == [armdroid.ReportOffsets()]


def test_a_loss_of_power_forgets_everything():
    device = armdroid.Device()
    device.receive_data(b"1,5d2,6")
    assert device.next_event() == armdroid.DriveOne(1, 5)
    assert device.forget() == armdroid.DriveOne(1, 5)
    assert (device.unanswered, device.buffered, device.arguments) == (None, 0, ZEROS)


@given(st.binary(max_size=60), st.text("0123456789,-", max_size=40))
def test_a_comma_and_a_d_clear_whatever_was_left_and_move_nothing(noise, numbers):
    device = armdroid.Device()
    said(noise + numbers.encode(), device)
    (event,) = said(b",d", device)
    assert isinstance(event, armdroid.DriveOne | armdroid.DriveNone)
    assert event.steps == 0
    assert device.clean
    assert said(b",,,,,d", device) == [armdroid.DriveNone(0, 0)]
    assert device.arguments == ZEROS
    assert said(b"@READ\r", device) == [armdroid.DriveAll((0,) * 6)]
