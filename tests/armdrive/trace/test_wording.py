"""What passes on the wire is told in words, in every dialect, and nothing in it is unreadable."""

from __future__ import annotations

import pytest
from recorder_bench import recorded_arm

from armdrive import GripperMove, Jog, LinePart, Pose
from armdrive.dialects.teachmover.controller import FIRST_LINE
from armdrive.dialects.words import plain
from armdrive.registry import DIALECTS
from armdrive.tasks import MendSetting, MoveBy, ReadPosition, SetOutputs
from armdrive.trace.entries import EntryKind
from armdrive.trace.log import Narrator, describer
from armdrive.trace.recorder import FlightRecorder
from firmware_protocol.events import Overrun, Stray, Unreadable, UnreadableFrame
from firmware_protocol.frames import Frame, pack
from firmware_protocol.mks import Foreign
from firmware_protocol.teachmover.messages import Close, Delay, Key, Registers, Status
from kinematics import Motors


def sent(dialect, data):
    row = describer(dialect)
    return row.words(data, row.sent)


SENT = [
    (
        "teachmover",
        b"@STEP 214,37,0,-4,0,0,0\r",
        "step at speed 214: base +37, elbow -4",
    ),
    ("teachmover", b"@STEP 214,0,0,0,0,0,0,5\r", "step at speed 214: no motor; outputs 5"),
    ("teachmover", b"@READ\r", "read the registers"),
    ("teachmover", b"@RESET\r", "zero the registers and switch the motors off"),
    ("teachmover", b"@NONSENSE\r", "unreadable"),
    (
        "teachmover",
        FIRST_LINE,
        "moves nothing, and makes an Armdroid harmless that was taken for a TeachMover",
    ),
    ("robko01", bytes.fromhex("aa 01 01 0b ab 0a"), "read the positions"),
    ("armdroid", b"6,20-d", "move the base by -20"),
    ("armdroid", b"d", "empty what is kept"),
    ("armdroid", b"3-,0,0,0,0,12D", "move: gripper -3, base +12"),
    ("armdroid", b"9,4-g", "keep these numbers and tell them: gripper +9, left wrist -4"),
    ("armdroid", b"oD", "read the offsets; move by the numbers that are kept"),
    ("armdroid", b"0t", "switch the motors off"),
    ("armdroid", b"9z", "z: no command of the sketch"),
    ("grbl", b"?", "status"),
    ("grbl", b"\x18", "soft reset"),
    ("grbl", b"G91G1F11014Y+8Z+3\n!", "feed hold; relative straight: feed 11014, Y +8, Z +3"),
    ("grbl", b"$J=G91X-5F300\n", "jog relative: X -5, feed 300"),
    ("grbl", b"$$\n$X\n", "read the settings; unlock"),
    ("grbl", b"$110=500\n", "set $110=500"),
    ("grbl", b"G21G94\n", "set the modes"),
    ("grbl", b"))GG\n", "no G-code"),
    ("mks", pack(Frame(3, bytes.fromhex("f301f7"))), "3: switch the motor on"),
    (
        "mks",
        pack(Frame(1, bytes.fromhex("3132"))) + pack(Frame(2, bytes.fromhex("3133"))),
        "1 2: read encoder",
    ),
    (
        "cia402",
        pack(Frame(0x201, bytes.fromhex("0f000805000000"))) + pack(Frame(0x080)),
        "1: 000F enable operation; mode 8, cyclic position; target 5; SYNC",
    ),
    ("cia402", pack(Frame(0, b"\x01\x00")), "all: start: become operational"),
]  # fmt: skip


@pytest.mark.parametrize(("dialect", "data", "words"), SENT)
def test_what_a_host_writes_is_told_in_words(dialect, data, words):
    assert sent(dialect, data) == words


HEARD = [
    ("teachmover", b"1", "done"),
    ("teachmover", b"2", "the pendant's STOP key was pressed"),
    (
        "teachmover",
        b"1,-2,3,4,5,6,0",
        "registers: base 1, shoulder -2, elbow 3, right wrist 4, left wrist 5, gripper 6",
    ),
    ("armdroid", b"torque = disabled", "the motors are off"),
    ("grbl", b"ok", "taken"),
    ("grbl", b"error:9", "refused (9): locked: alarm or jog"),
    ("grbl", b"ALARM:1", "alarm 1: "),
    ("grbl", b"<Run|MPos:1.000,-2.500|FS:300,0|Bf:12,200>", "Run at 1 -2.5, feed 300"),
    ("mks", pack(Frame(4, bytes.fromhex("3100000000000136"))), "4: the encoder is at 1"),
    ("cia402", pack(Frame(0x704, b"\x00")), "4: boot-up: it has restarted"),
    ("cia402", pack(Frame(0x184, bytes.fromhex("37020801000000"))), "4: 0237 operation enabled"),
]


@pytest.mark.parametrize(("dialect", "data", "words"), HEARD)
def test_what_a_device_says_is_told_in_words(dialect, data, words):
    assert describer(dialect).words(data, describer(dialect).received).startswith(words)


def test_any_message_has_words_of_its_name_and_its_fields():
    wording = describer("teachmover").wording
    assert wording(Delay(12)) == "delay: count 12"
    assert wording(Close()) == "close the gripper until its switch trips"
    assert wording(Close(90)) == "close the gripper until its switch trips at speed 90"
    pressed = Registers((0,) * 6, Key.STOP, 3)
    assert wording(pressed).endswith("; last key stop; inputs 3")
    assert wording(Status.FAILED) == "failed, or not understood"
    assert wording("as it is") == "as it is"


TIPS = Pose.of(x_mm=250, y_mm=0, z_mm=120, pitch_deg=-90)
CALLS = [
    ("hold", (Jog.joint(shoulder=1),), {"speed": 0.25}, "hold shoulder +1, speed 0.25"),
    ("nudge", (Jog.cartesian(z=-2, frame="tool"),), {}, "nudge z -2 in the tool frame"),
    ("start", (GripperMove(30.0),), {"stops": 3},
     "start gripper move: opening 30 mm, speed 1, stops 3"),
    ("move_to", (TIPS,), {"wait": False}, f"move_to {TIPS}, wait no"),
    ("move_path", ([LinePart(TIPS)],), {}, f"move_path line part: goal {TIPS}, blend 0 mm"),
    ("move_j", ({"shoulder_deg": 40},), {"frame": None}, "move_j shoulder 40 deg"),
    ("release", (), {}, "release"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "arguments", "named", "words"), CALLS)
def test_a_call_is_told_in_words(name, arguments, named, words):
    recorder = FlightRecorder()
    recorder.called(name, arguments, named)
    _, (entry,) = recorder.since(0, 1, 1)
    assert entry.what == words


REQUESTS = [
    (ReadPosition(), "read position"),
    (SetOutputs(3), "set outputs bits 3"),
    (MendSetting("$110=500 (mm)"), "mend setting line $110=500 (mm)"),
    (MoveBy(Motors((37, 0, -4)), 219.5), "move by 37 0 -4; 219.5 steps/s"),
]


@pytest.mark.parametrize(("request_", "words"), REQUESTS)
def test_a_request_is_told_in_words(request_, words):
    recorder = FlightRecorder()
    recorder.requested(request_)
    _, (entry,) = recorder.since(0, 1, 1)
    assert Narrator("teachmover").line(0, entry).words == words


@pytest.mark.parametrize("dialect", sorted(DIALECTS))
def test_a_whole_session_has_words_and_none_of_them_is_python(dialect):
    arm = recorded_arm(dialect)
    arm.move_motors(0, 0, 0, 0, 3, 0)
    arm.nudge(Jog.joint(base=1), speed=0.1)
    arm.sleep(1.0)
    entries = arm.tracer.ring.entries()
    arm.close()
    narrator = Narrator(dialect)
    told = [(entry, narrator.line(0, entry).words) for entry in entries]
    assert all(words for entry, words in told if entry.kind is EntryKind.SENT)
    assert any(words for entry, words in told if entry.kind is EntryKind.RECEIVED)
    for _, words in told:
        assert not {"(", "<", "unreadable"} & set(words.split()[:1])
        for python in ("()", "=<", "<Space", "=("):
            assert python not in words


@pytest.mark.parametrize(
    ("event", "words"),
    [
        (Unreadable(b"ok1\xff", "no answer"), r"unreadable: `ok1\xff`: no answer"),
        (Stray(Status.DONE), "stray: answer done"),
        (Stray(Delay(12)), "stray: answer delay: count 12"),
        (Overrun(3), "overrun: count 3"),
        (UnreadableFrame(Frame(1, b"\x31\x02"), "bad sum"), "unreadable frame: 001#3102: bad sum"),
        (Foreign(Frame(0x123)), "foreign: frame 123#"),
    ],
)
def test_what_no_request_awaits_is_told_in_words(event, words):
    assert plain(event) == words
