"""What passes on a bus in words, and the command that listens."""

from __future__ import annotations

import contextlib
import json
import sys
import threading

import pytest
from can_bench import frames_of
from can_setup_bench import ServedBus, another_program
from hypothesis import given
from hypothesis import strategies as st
from waiting import LONG_S, at_last

from armdrive import Arm
from armdrive.dialects.bus.words import FrameCheck, FrameKind
from armdrive.dialects.mks.words import MksFrameDescriber
from armdrive.errors import NoAnswer
from armdrive.storage.files import replace_file
from armdrive.storage.lock_client import notice_path
from armdrive.transports.opening import open_link
from firmware_protocol.canopen import Heartbeat, NodeState
from firmware_protocol.frames import Frame, pack
from firmware_protocol.mks import (
    Code,
    EnabledRead,
    EncoderRead,
    GoSynchronous,
    Mode,
    MoveAbsoluteAxis,
    Outcome,
    ReadEncoder,
    ReadSetting,
    SetMode,
    SettingRead,
    Status,
    encode,
)

needs_pty = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
REQUEST, ANSWER, UNKNOWN = FrameKind.REQUEST, FrameKind.ANSWER, FrameKind.UNKNOWN

CONVERSATION = (
    (encode(1, ReadEncoder()), REQUEST, "drive 1: read encoder"),
    (encode(1, EncoderRead(16384)), ANSWER, "the encoder is at 16384"),
    (encode(1, MoveAbsoluteAxis(-9, 600, 2)), REQUEST, "drive 1: go to -9 at 600 rpm, acc 2"),
    (encode(1, Status(Code.ABSOLUTE_AXIS, Outcome.STARTED)), ANSWER, "absolute axis: started"),
    (encode(1, Status(Code.ABSOLUTE_AXIS, Outcome.LIMIT_STOP)), ANSWER, "stopped by a limit"),
    # the same bytes: first the request, then its answer
    (encode(2, SetMode(Mode.PULSE_CLOSED)), REQUEST, "drive 2: set mode: pulse closed"),
    (encode(2, Status(Code.MODE, Outcome.DONE)), ANSWER, "mode: done"),
    (encode(2, ReadSetting(Code.MODE)), REQUEST, "drive 2: read setting mode"),
    (encode(2, SettingRead(Code.MODE, b"\x05")), ANSWER, "setting mode: bus foc"),
    (encode(0, GoSynchronous()), REQUEST, "all: start the stored moves"),
    (encode(3, EnabledRead(on=True)), ANSWER, "the motor is on"),
    (Frame(1, bytes.fromhex("3133")), UNKNOWN, "perhaps encoder, but its last byte would be 32"),
    (Frame(0x123, b"\xde\xad\xbe\xef"), UNKNOWN, "not of an MKS drive"),
    (Frame(0x123, b"", extended=True), UNKNOWN, "(extended)"),
    (Frame(5, b"", remote=True), UNKNOWN, "(remote)"),
    (Frame(5, b"\x01"), UNKNOWN, "(short)"),
)


def test_frames_are_described_in_words():
    describer = MksFrameDescriber()
    for frame, kind, words in CONVERSATION:
        said = describer.describe(frame)
        assert said.kind is kind, frame
        assert words in said.words
        assert str(frame) in said.line(1.5)


def test_a_wrong_check_byte_is_reported():
    said = MksFrameDescriber().describe(Frame(1, bytes.fromhex("3133")))
    assert said.check is FrameCheck.WRONG
    assert "CHECK BYTE WRONG" in said.line(0.0)
    assert said.view(0.25) == {
        "time_s": 0.25,
        "id": 1,
        "node": 1,
        "frame": "001#3133",
        "kind": "unknown",
        "command": "encoder",
        "words": said.words,
        "check": "wrong",
    }


frames = st.builds(
    Frame, st.integers(0, 0x7FF), st.binary(max_size=8), st.booleans(), st.just(False)
)


@given(st.lists(frames, max_size=20))
def test_nothing_on_a_bus_confuses_the_ear_for_good(noise):
    describer = MksFrameDescriber()
    for frame in noise:
        assert describer.describe(frame).frame == frame
    assert describer.describe(encode(0x7F0, ReadEncoder())).words == "drive 2032: read encoder"


@pytest.fixture
def bus(tmp_path):
    served = ServedBus(tmp_path)
    yield served
    served.end()


@needs_pty
def test_a_second_adapter_shows_both_sides_and_sends_nothing(call, bus):
    with another_program(bus.port, encode(3, ReadEncoder()), encode(1, ReadEncoder())):
        lines = call("can", "monitor", bus.beside, "--id", "3", "--count", "6", "--json", code=0)
        told = call("can", "monitor", bus.beside, "--count", "4", code=0).out
    views = lines.json_lines
    assert {each["id"] for each in views} == {3}
    assert {each["kind"] for each in views} == {"request", "answer"}
    assert {each["check"] for each in views} == {"right"}
    assert "read encoder" in told
    assert bus.server.second.adapter.refused == 0


@needs_pty
def test_frames_sent_by_a_second_program_reach_the_first_one(bus):
    first = open_link(bus.port, 0)
    second = open_link(bus.beside, 0)
    with contextlib.closing(first), contextlib.closing(second):
        second.write(pack(encode(4, ReadEncoder())), 0.0)
        assert frames_of(first, 2) == [encode(4, ReadEncoder()), encode(4, EncoderRead(0))]


@needs_pty
def test_the_holder_of_an_arm_reports_its_frames(call, bus):
    with Arm.connect(bus.port, dialect="mks") as arm:
        told = call("can", "monitor", bus.port, "--count", "4", code=0).out
        lines = call("can", "monitor", bus.port, "--id", "3", "--count", "4", "--json", code=0)
        view = call("can", "monitor", bus.port, "--seconds", "0.1", code=0).out
        at_last(arm.enable, arm.reset, NoAnswer)
    assert "holds" in told
    assert "these are its frames" in view
    assert "read encoder" in told
    views = lines.json_lines
    kinds = [each["kind"] for each in views]
    assert set(kinds) == {"request", "answer"}
    assert kinds.count("answer") <= kinds.count("request") + 1  # a busy drive may be asked again
    assert {each["id"] for each in views} == {3}
    assert {each["check"] for each in views} == {"right"}


@needs_pty
def test_listening_to_a_held_arm_ends_when_it_is_given_back(call, bus):
    arm = Arm.connect(bus.port, dialect="mks")
    since, listened = arm.tracer.since, threading.Event()

    def told(*words):
        listened.set()
        return since(*words)

    arm.tracer.since = told
    giving_back = threading.Thread(target=lambda: listened.wait(LONG_S) and arm.close())
    giving_back.start()
    call("can", "monitor", bus.port, "--json", code=0)
    giving_back.join()
    assert arm.closed


@needs_pty
def test_a_silent_bus_is_explained_and_ends_in_time(call, bus):
    said = call("can", "monitor", bus.beside, "--seconds", "0.1", code=0).out
    assert "An idle bus of these drives is silent" in said
    assert call("can", "monitor", bus.beside, "--seconds", "0.1", "--json", code=0).out == ""


@needs_pty
def test_frames_of_another_protocol_suggest_that_protocol(call, bus):
    beside = ["can", "monitor", bus.beside, "--count", "2"]
    with another_program(bus.port, Heartbeat(5, NodeState.OPERATIONAL).frame):
        wrong = call(*beside, code=0).out
        right = call(*beside, "--protocol", "canopen", "--id", "5", code=0).out
    assert "2 of 2 frames are not from MKS drives: try --protocol canopen" in wrong
    assert "node 5: heartbeat: operational" in right
    assert "try" not in right


@needs_pty
def test_a_busy_adapter_is_reported_with_an_alternative(call, bus):
    with contextlib.closing(open_link(bus.beside, 0)):
        said = call.refused("can", "monitor", bus.beside, code=4)
    assert "in use" in said
    assert "a second adapter" in said


@needs_pty
def test_the_notice_of_a_killed_program_holds_no_bus(call, bus):
    left = notice_path(bus.beside, "holder")
    replace_file(left, json.dumps({"address": f"{left}.gone"}))
    with contextlib.closing(open_link(bus.beside, 0)):
        assert "a second adapter" in call.refused("can", "monitor", bus.beside, code=4)


def test_no_bus_is_opened_while_simulation_is_forced(call, monkeypatch):
    monkeypatch.setenv("ARMDRIVE_FORCE_SIM", "1")
    assert "clear that variable" in call.refused("can", "monitor", "can:virtual:0", code=4)


@pytest.mark.parametrize(
    ("words", "code", "sentence"),
    [
        ((), 2, "name one bus"),
        (("/dev/ttyUSB0",), 2, "no CAN bus"),
        (("can:nothing:0",), 4, "python-can has no interface"),
    ],
)
def test_a_bus_that_cannot_be_monitored_is_reported(call, words, code, sentence):
    assert sentence in call.refused("can", "monitor", *words, code=code)


def test_an_id_is_a_number(call):
    assert "an id is a number" in call("can", "monitor", "can:virtual:x", "--id", "x", code=2).err
