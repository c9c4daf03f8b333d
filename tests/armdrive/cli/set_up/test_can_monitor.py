"""What passes on a bus in words, and the command that listens."""

import contextlib
import json
import sys
import threading
import tomllib
from types import SimpleNamespace

import pytest
from can_setup_bench import ServedBus, another_program, arm
from cli_calls import Terminal, typed, write_arm_file
from hypothesis import given
from hypothesis import strategies as st
from waiting import LONG_S, at_last

from armdrive import Arm
from armdrive.cli.set_up import can_setup
from armdrive.dialects.bus.words import FrameKind
from armdrive.dialects.mks.words import MksFrameDescriber
from armdrive.dialog import About
from armdrive.errors import NoAnswer
from armdrive.registry import simulate
from armdrive.registry.arm_files import load_arm
from armdrive.setup.commissioning import plan_of
from armdrive.setup.dialog_runner import DialogClock
from armdrive.setup.simulated_person import SimulatedPerson
from armdrive.storage import files as places
from armdrive.storage.files import replace_file
from armdrive.storage.lock_client import ask_holder, notice_path
from armdrive.tasks import MeasuredUnits
from armdrive.transports.opening import open_link
from firmware_protocol.canopen import Heartbeat, NodeState
from firmware_protocol.frames import Frame
from firmware_protocol.mks import (
    Code,
    EnabledRead,
    EncoderRead,
    Mode,
    MoveAbsoluteAxis,
    OtherMotion,
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
    (encode(0, OtherMotion(Code.GO, b"")), REQUEST, "all: go"),
    (encode(3, EnabledRead(on=True)), ANSWER, "the motor is on"),
    (Frame(1, bytes.fromhex("3133")), UNKNOWN, "perhaps encoder: the check byte should be 32"),
    (Frame(0x123, b"\xde\xad\xbe\xef"), UNKNOWN, "not of an MKS drive"),
    (Frame(0x123, b"", extended=True), UNKNOWN, "not of an MKS drive"),
    (Frame(5, b"\x31", extended=True), UNKNOWN, "perhaps encoder: a frame of another kind"),
    (Frame(5, b"\x31"), UNKNOWN, "perhaps encoder: length 1"),
)


def test_frames_are_described_in_words():
    describer = MksFrameDescriber()
    for frame, kind, words in CONVERSATION:
        said = describer.describe(frame)
        assert said.kind is kind, frame
        assert words in said.words
        assert str(frame) in said.line(1.5)
    said = MksFrameDescriber().describe(Frame(1, bytes.fromhex("3133")))
    view = {"time_s": 0.25, "id": 1, "node": 1, "frame": "001#3133", "kind": "unknown"}
    view |= {"command": "encoder", "words": said.words}
    assert said.view(0.25) == view


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
    assert "unknown" not in {each["kind"] for each in views}
    assert "read encoder" in told
    assert bus.server.adapters[1].refused == 0


@needs_pty
def test_the_holder_of_an_arm_reports_its_frames(call, bus):
    with Arm.connect(bus.port, dialect="mks") as arm:
        told = call("can", "monitor", bus.port, "--seconds", "0.1", code=0).out
        lines = call("can", "monitor", bus.port, "--id", "3", "--count", "2", "--json", code=0)
        at_last(arm.enable, arm.reset, NoAnswer)
    assert "holds" in told
    assert "these are its frames" in told
    views = lines.json_lines
    assert {each["kind"] for each in views} <= {"request", "answer"}
    assert {each["words"] for each in views} >= {"drive 3: read encoder"}
    assert {each["id"] for each in views} == {3}
    assert "unknown" not in {each["kind"] for each in views}


@needs_pty
def test_listening_to_a_held_arm_ends_when_it_is_given_back(call, bus):
    arm = Arm.connect(bus.port, dialect="mks")
    since, listened = arm.parts.tracer.since, threading.Event()

    def told(*words):
        listened.set()
        return since(*words)

    arm.parts.tracer.since = told
    giving_back = threading.Thread(target=lambda: listened.wait(LONG_S) and arm.close())
    giving_back.start()
    call("can", "monitor", bus.port, "--json", code=0)
    giving_back.join()
    assert arm.closed


@needs_pty
def test_silence_and_frames_of_another_protocol_are_explained(call, bus):
    silent = call("can", "monitor", bus.beside, "--seconds", "0.1", code=0).out
    assert "An idle bus of these drives is silent" in silent
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
    # the notice of a killed program holds no bus
    left = notice_path(bus.beside, "holder")
    replace_file(left, json.dumps({"address": str(left.with_name("gone"))}))
    with contextlib.closing(open_link(bus.beside, 0)):
        assert "a second adapter" in call.refused("can", "monitor", bus.beside, code=4)


def test_no_bus_is_opened_while_simulation_is_forced(call, monkeypatch):
    monkeypatch.setenv("ARMDRIVE_FORCE_SIM", "1")
    assert "clear that variable" in call.refused("can", "monitor", "can:virtual:0", code=4)


# `armdrive can setup`: the command around the talk, and the file that it writes.


PORT = "can:slcan:/dev/ttyACM7?bitrate=500000"


def lead_to(monkeypatch, config):
    """Have the adapter lead to simulated new drives, with eyes and hands that need no terminal."""
    twin = simulate(config, factory=True)
    monkeypatch.setattr(twin.link, "close", lambda: None)
    monkeypatch.setattr("armdrive.transports.opening.open_link", lambda port, baud: twin.link)
    clock = DialogClock()  # one for all calls, as the drives' time goes on between them
    monkeypatch.setattr("armdrive.setup.dialog_runner.RealClock", lambda: clock)
    person = SimulatedPerson(twin, print)
    monkeypatch.setattr(can_setup, "TerminalPerson", lambda name: person)
    return twin, person


@pytest.fixture
def drives(monkeypatch):
    """New drives of which only some are there."""
    config = arm()
    twin, person = lead_to(monkeypatch, config)
    person.unplug_all(len(plan_of(config).drives))
    answer = person.answer
    seen = SimpleNamespace(link=twin.link, there={1, 2}, on_plugged=None)

    def told(asked):
        if asked.about is About.CONNECT and seen.on_plugged is not None:
            return seen.on_plugged(asked)
        if asked.about is About.CONNECT and asked.motor not in seen.there:
            return asked.read("no")  # as if the other drives were not there yet
        return answer(asked)

    person.answer = told
    return seen


def type_in(monkeypatch, *lines):
    monkeypatch.setattr(sys, "stdin", Terminal(typed(*lines)))


def test_practice_needs_no_drives_and_writes_nothing(call):
    called = call("can", "setup", "bench", "--sim", "--json", code=0)
    assert called.json["left_out"] == []
    assert tomllib.loads(called.json["arm_file"])["mks"]["ids"] == [1, 2, 3, 4, 5, 6]
    assert not places.arm_files().exists() or not list(places.arm_files().iterdir())


def test_the_file_is_written_once_that_is_agreed_to_and_the_rest_goes_on_later(
    call, drives, monkeypatch
):
    path = places.arm_files() / "bench.toml"
    type_in(monkeypatch, "no")
    called = call("can", "setup", "bench", "--port", PORT, code=1)
    assert "Left out: right wrist, left wrist, gripper, base" in called.out
    assert not path.exists()
    drives.there = set()
    type_in(monkeypatch, "yes")
    called = call("can", "setup", "bench", "--port", PORT, code=1)
    assert called.out.count("its settings: nothing to do") == 2
    table = tomllib.loads(path.read_text())
    assert table["connection"]["port"] == PORT
    assert "armdrive config signs bench" in called.out
    before = path.read_text()
    type_in(monkeypatch)
    called = call("can", "setup", "bench", code=1)  # the port is the file's now
    assert "contains all this already" in called.out
    assert path.read_text() == before


def test_a_file_that_is_there_is_taken_as_it_is_and_its_old_text_kept(call, drives, monkeypatch):
    path = write_arm_file(
        "bench",
        '# mine\nmodel = "minimover5-mks"\ntitle = "Mine"\n\n[connection]\ndialect = "mks"\n'
        f'port = "{PORT}"\n\n[limits_deg]\nbase = [-80, 80]\n',
    )
    old = path.read_text()
    type_in(monkeypatch, "yes")
    call("can", "setup", "bench", code=1)
    table = tomllib.loads(path.read_text())
    assert table["title"] == "Mine"
    assert table["limits_deg"] == {"base": [-80, 80]}
    assert path.with_name("bench.toml.before").read_text() == old
    type_in(monkeypatch)
    assert "contains all this already" in call("can", "setup", "bench", code=1).out


CIA402 = f"""\
model = "minimover5-cia402"
[connection]
dialect = "cia402"
port = "{PORT}"
[cia402]
period_ms = 20
"""
RPM_HZ = 166.6667


@pytest.fixture
def untold(monkeypatch):
    """CiA 402 drives that count speeds in rpm and do not say."""
    config = load_arm(write_arm_file("bench", CIA402))
    twin, person = lead_to(monkeypatch, config)
    return SimpleNamespace(twin=twin, person=person, path=config.source.folder / "bench.toml")


def test_units_are_written_once_that_is_agreed_to(call, untold, monkeypatch):
    found = (MeasuredUnits(RPM_HZ, RPM_HZ, reported=False, words="rpm"),) * 6
    monkeypatch.setattr(can_setup, "measure_units", lambda *_: found)
    practised = call("can", "setup", "bench", "--sim", "--json", code=0).json
    assert practised["units"] == {name: [RPM_HZ] * 6 for name in ("speed_units", "ramp_units")}
    type_in(monkeypatch, "no")
    call("can", "setup", "bench", code=0)
    assert untold.path.read_text() == CIA402
    type_in(monkeypatch, "yes")
    assert "written:" in call("can", "setup", "bench", code=0).out
    device = load_arm(untold.path).device
    assert device.speed_units == device.ramp_units == (RPM_HZ,) * 6
    type_in(monkeypatch)
    assert "Nothing to write" in call("can", "setup", "bench", code=0).out  # as it is


def test_without_a_yes_no_motor_is_switched_on(call, untold, monkeypatch):
    untold.person.answer = lambda asked: asked.read("no")
    type_in(monkeypatch)
    call("can", "setup", "bench", code=1)
    assert not any(node.motor.holding for node in untold.twin.board.nodes)
    assert untold.path.read_text() == CIA402


def test_practising_the_measurement_needs_no_drives(call):
    path = write_arm_file("bench", CIA402)
    said = call("can", "setup", "bench", "--sim", "--yes", code=0).out
    assert "base: one unit of speed is 1 rpm, one of ramps 1 rpm a second" in said
    assert f"+speed_units = {[RPM_HZ] * 6}" in said
    assert path.read_text() == CIA402


def test_answers_that_end_leave_what_was_done(call, drives, monkeypatch):
    monkeypatch.undo()
    monkeypatch.setattr("armdrive.transports.opening.open_link", lambda port, baud: drives.link)
    monkeypatch.setattr("armdrive.setup.dialog_runner.RealClock", DialogClock)
    type_in(monkeypatch, "?", "back", "yes")
    called = call("can", "setup", "bench", "--port", PORT, code=3)
    assert "`armdrive can setup bench` continues there" in called.err
    assert "shipped as id 1" in called.out  # what ? explains
    assert "you cannot go back from here" in called.out
    assert "which adapter? --port names it" in call.refused("can", "setup", "bench", code=2)


def test_another_program_can_stop_a_setup(call, drives, monkeypatch):
    type_in(monkeypatch)
    said = []

    def stop(asked):
        said.append(ask_holder("bench", "status")["error"])
        ask_holder("bench", "stop")
        return asked.read("yes")

    drives.on_plugged = stop
    called = call("can", "setup", "bench", "--port", PORT, code=130)
    assert "sets its drives up" in said[0]
    assert "interrupted" in called.err
    assert not (places.arm_files() / "bench.toml").exists()
