"""Connecting with the wrong dialect: the error names the controller, and nothing moves."""

from __future__ import annotations

import itertools
from dataclasses import replace

import pytest
from doctor_bench import (
    LINE_ENDS_ACT,
    PREPARED,
    SPOKEN,
    ScriptedDevice,
    SimPort,
    check_unmoved,
    prepared,
)

from armdrive.arm import Arm
from armdrive.config.sections import Connection
from armdrive.connect.parts import assemble
from armdrive.connect.port import explained, explaining
from armdrive.connect.target import simulated_config
from armdrive.errors import DeviceFault
from armdrive.errors.printable import command_line
from armdrive.registry import DIALECTS
from armdrive.runtime.clock import SimulatedPace
from armdrive.trace.recorder import FlightRecorder

ON_SERIAL = [name for name, row in DIALECTS.items() if not row.can]
PAIRS = [(x, y) for x, y in itertools.product(ON_SERIAL, SPOKEN) if x != y]
PORT = "/dev/ttyARM"


def connected(dialect: str, port: SimPort, baud: int | None = None) -> Arm:
    config = simulated_config(dialect)
    wire = replace(config.connection, port=PORT)
    port.tune(baud or wire.baud)
    pace = SimulatedPace()
    pace.clock.now_s = port.now
    try:
        recorder = FlightRecorder()
        with explaining(recorder.ring.entries, wire):
            return Arm(assemble(config, port, pace, simulated=True, tracer=recorder))
    finally:
        port.now = max(port.now, pace.clock.now_s)


def refused(dialect: str, port: SimPort, baud: int | None = None) -> str:
    with pytest.raises(DeviceFault) as fault:
        connected(dialect, port, baud).close()
    sentence = str(fault.value)
    assert f"`armdrive doctor {PORT}`" in sentence
    assert "\n" not in sentence
    return sentence


@pytest.mark.parametrize(("asked", "there"), PAIRS)
@pytest.mark.parametrize("same_baud", [True, False])
def test_the_wrong_dialect_moves_nothing_and_says_so(asked, there, same_baud):
    for state in PREPARED[there]:
        if (there, state) not in LINE_ENDS_ACT:
            port = prepared(there, state)
            refused(asked, port, port.device.board.baud if same_baud else None)
            check_unmoved(port, there, state)


@pytest.mark.parametrize(
    ("asked", "says", "named"),
    [
        ("teachmover", b"Welcome, Armdroid!\r\n", "set the dialect to armdroid"),
        (
            "teachmover",
            b"\r\nGrbl 1.1h ['$' for help]\r\n",
            "it is Grbl 1.1h; set the dialect to grbl",
        ),
        ("armdroid", b"1\r0,0,0,0,0,0,0\r", "set the dialect to teachmover"),
        ("armdroid", b"\xaa\x02\x02\x01\x01\xa9\x03", "set the dialect to robko01"),
        ("teachmover", b"0,0,0,0,0,0,0\r", "Robko 01 retrofit, in its text mode"),
        ("teachmover", b"\x00\x80\xe0\x00\xf8", "is the baud rate right?"),
        ("teachmover", b"hello, who is there?\r\n", "answer: 'hello, who is there?"),
        (
            "teachmover",
            b"hello, who is there?\r\n",
            "The bytes received are not in the teachmover dialect. ",
        ),
        ("teachmover", b"@,d,,,", "The bytes received are not in the teachmover dialect"),
    ],
)
def test_the_error_quotes_what_was_received(asked, says, named):
    port = SimPort(ScriptedDevice(answers=says))
    assert named in refused(asked, port)


def test_silence_is_reported_as_silence():
    sentence = refused("teachmover", SimPort(ScriptedDevice()))
    assert "The bytes received" not in sentence
    assert "The device" not in sentence
    assert "no answer" in sentence


@pytest.mark.parametrize("half", [b"1", b"1\r0,0,0", b"1\r0,0,0,0,0,0,"])
def test_half_an_answer_of_the_right_dialect_does_not_count(half):
    port = SimPort(ScriptedDevice(answers=half))
    assert "no answer" in refused("teachmover", port)


@pytest.mark.parametrize("asked", SPOKEN)
def test_a_banner_in_mid_stream_does_no_harm(asked):
    """The board starts while its port is opened: what it had begun to say breaks off."""
    port = prepared(asked, "fresh")
    before = port.device.world.motors
    if hasattr(port.device.board, "opened"):
        port.device.board.opened()
    port.line.say(b"offse\r\n<Idle|MP\xaa\x02\x0e", port.now)
    connected(asked, port).close()
    port.pass_time(20.0)
    assert port.device.world.motors == before


@pytest.mark.parametrize(
    ("port", "named"),
    [
        (PORT, f"`armdrive doctor {PORT}` finds"),
        ("/dev/my arm", f"`{command_line('doctor', '/dev/my arm')}` finds"),
        ("", "`armdrive ports` shows"),
    ],
)
def test_an_arm_that_is_found_by_its_number_alone_has_no_port_to_name(port, named):
    wire = Connection("teachmover", port, usb_serial="A50285BI")
    assert named in str(explained(DeviceFault("no answer"), b"", wire))


def test_a_bus_is_looked_at_by_the_survey_of_buses():
    wire = Connection("mks", "can:slcan:/dev/ttyACM0?bitrate=500000")
    sentence = str(explained(DeviceFault("no answer"), b"\xc5\x08\x00\x01", wire))
    assert "baud rate" not in sentence
    assert "`armdrive doctor --can 'slcan:/dev/ttyACM0?bitrate=500000'`" in sentence
