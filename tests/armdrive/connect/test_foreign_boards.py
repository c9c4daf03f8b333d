"""Other firmware, other settings, an echo: the difference is named, and nothing moves."""

from __future__ import annotations

import pytest
from doctor_bench import Echo, EchoingBoard, SimPort, Talker, made
from test_wrong_dialect import ON_SERIAL, connected, refused

from armdrive.config.sections import Connection
from armdrive.dialects.recognition import comes_back
from armdrive.dialog.conversation import Grade
from armdrive.errors import SettingsDiffer
from armdrive.setup import survey as after

SMOOTHIE_STATUS = b"<Idle|MPos:0.0000,0.0000,0.0000|WPos:0.0000,0.0000,0.0000|F:0,100.0>\r\n"
OLD_STATUS = b"<Idle,MPos:0.000,0.000,0.000,WPos:0.000,0.000,0.000>\r\n"
OLD_GREETING = b"\r\nGrbl 0.9j ['$' for help]\r\n"
FOREIGN = {
    "Marlin, the firmware of a 3D printer": Talker(
        {}, b'echo:Unknown command: ""\nok\n', b"start\r\necho:Marlin 2.1.2\r\n"
    ),
    "Smoothieware": Talker({b"?": SMOOTHIE_STATUS}, b"ok\r\n", b"Smoothie\r\nok\r\n"),
    "Grbl 0.9j, whose reports have an older form": Talker(
        {b"?": OLD_STATUS, b"\x18": OLD_GREETING, b"$I": b"[0.9j.20150930:]\r\nok\r\n"},
        b"ok\r\n",
        OLD_GREETING,
    ),
    "an ESP32 whose firmware has sent nothing yet": Talker(
        {}, b"", b"ets Jun  8 2016 00:22:57\r\n\r\nrst:0x1 (POWERON_RESET),boot:0x13\r\n"
    ),
}
MOTION = (b"G1", b"G0", b"$J", b"$H", b"X")


@pytest.mark.parametrize("name", FOREIGN)
def test_other_firmware_is_named_with_the_remedy_and_gets_no_motion(name):
    device = FOREIGN[name]
    sentence = refused("grbl", SimPort(device))
    assert f"The device does not speak grbl: it is {name}; " in sentence
    assert not any(word in device.heard for word in MOTION)


def test_the_doctor_says_what_helps_where_it_knows_the_firmware():
    found = SimPort(Talker({}, b"ok\r\n", OLD_GREETING)).examine(115_200)
    (first, *_) = after.of_examination(found, wire=Connection("grbl"))
    assert first.grade is Grade.PROBLEM
    assert "Grbl 0.9j" in first.what
    assert "grblHAL" in first.mend


@pytest.mark.parametrize("dialect", ON_SERIAL)
def test_an_echoing_line_is_recognised(dialect):
    sentence = refused(dialect, SimPort(Echo(baud=115_200)), 115_200)
    assert "Everything that is sent comes straight back" in sentence


def test_a_board_behind_such_a_line_moves_nothing():
    board = made("grbl")
    before = board.world.motors
    sentence = refused("grbl", SimPort(EchoingBoard(board)))
    assert "Everything that is sent comes straight back" in sentence
    assert board.world.motors == before


def test_the_doctor_finds_an_echo_and_takes_it_for_no_answer():
    echo = SimPort(Echo(baud=115_200)).examine()
    assert echo.identity is None
    assert "comes straight back" in after.of_examination(echo)[0].what
    board = SimPort(EchoingBoard(made("robko01"))).examine(115_200)
    assert board.identity.dialect == "robko01"
    assert any(
        "echoes everything that is sent" in each.what for each in after.of_examination(board)
    )


@pytest.mark.parametrize(
    ("sent", "heard", "echoed"),
    [
        ([b"?", b"?", b"\x18"], b"??\x18", True),
        ([b"?", b"?", b"?"], b"<Idle|MPos:0,0,0>", False),
        ([b"$I\n", b"$$\n"], b"$I\r\n[VER:1.1h]\r\nok\r\n$$\r\nok\r\n", True),
        ([b"$I\n", b"$$\n"], b"$$\r\n$I\r\n", False),
        ([b"?", b"$I\n"], b"?ok\r\n", False),
        ([b"?"], b"?", False),
        ([], b"ok", False),
    ],
)
def test_an_echo_is_what_was_sent_in_its_order(sent, heard, echoed):
    assert comes_back(sent, heard) is echoed


@pytest.mark.parametrize(
    ("key", "value", "named"),
    [
        (13, 1.0, "reports in inches"),
        (10, 0.0, "what reports contain"),
        (10, 1.0, "what reports contain"),
        (100, 250.0, "steps per unit of X"),
        (104, 80.0, "steps per unit of B"),
        (1, 25.0, "motors on while standing"),
    ],
)
def test_a_foreign_setting_is_named_and_nothing_moves_before_it_is_mended(key, value, named):
    board = made("grbl")
    board.board.settings.values[key] = value
    arm = connected("grbl", SimPort(board))
    before = board.world.motors
    assert named in arm.status.notice
    for move in (
        lambda: arm.move_motors(1, 0, 0, 0, 0, 0),
        lambda: arm.jog_j(base_deg=1.0),
    ):
        with pytest.raises(SettingsDiffer, match=named):
            move()
    assert board.world.motors == before
