"""The log, its wording, and the wire tap."""

import os
from types import SimpleNamespace

import pytest
from amounts import every_row
from hypothesis import given
from hypothesis import strategies as st
from recorder_bench import recorded_arm

from armdrive import ArmError, GripperMove, Jog, LinePart, Pose
from armdrive.connect.control_socket import (
    MESSAGE_BYTES,
    TAP_BACK,
    traffic,
)
from armdrive.dialects.words import plain
from armdrive.registry import DIALECTS
from armdrive.tasks import FixSetting, MoveBy, ReadPosition
from armdrive.trace.entries import (
    ENTRY_BYTES,
    EntryKind,
    EntryRing,
    TraceEntry,
)
from armdrive.trace.log import LogFilter, LogLine, LogReader, Narrator, Topic, describer
from armdrive.trace.recorder import FlightRecorder
from firmware_protocol.armdroid import DriveOne
from firmware_protocol.events import Stray, Unreadable, UnreadableFrame
from firmware_protocol.frames import Frame, pack
from firmware_protocol.mks import Foreign
from firmware_protocol.teachmover.messages import Close, Key, Registers, Status
from kinematics import Motors


@pytest.fixture
def arm():
    with recorded_arm() as arm:
        yield arm


def line(number, kind=EntryKind.REPLY, words="done", **more):
    return LogLine(number, float(number), kind, **({"shown": "", "words": words} | more))


def reader(ring, **how):
    return LogReader(ring.since, "teachmover", 0.0, **how)


def test_a_motion_is_read_in_words_with_its_intent_and_its_bytes(arm):
    log = arm.recorder.log()
    while log.read():
        pass
    arm.move_motors(37, 0, 0, 0, 0, 0)
    lines = log.read()
    (asked,) = [each for each in lines if each.topic is Topic.CALLS]
    assert asked.words == "move_motors 37, 0, 0, 0, 0, 0"
    sent = next(each for each in lines if each.shown.startswith("@STEP"))
    assert "base +" in sent.words
    assert "->" in str(sent)
    assert "<-" in "\n".join(map(str, lines))
    assert [each.number for each in lines] == sorted(each.number for each in lines)
    assert log.read() == ()


def test_errors_carry_the_code_of_the_catalogue(arm):
    arm.reference.confirm()
    arm.twin.faults.add("mute")
    with pytest.raises(ArmError):
        arm.move_motors(0, 0, 0, 0, 5, 0)
    lines = arm.recorder.log().read()
    codes = {each.kind: each.code for each in lines if each.code}
    assert codes[EntryKind.RAISED] == "E502"
    assert codes[EntryKind.ERROR] == arm.status.error_code
    assert codes[EntryKind.TRUST] in ("E706", "E707")


# -- reading as it comes -------------------------------------------------------------------------


@given(
    st.lists(st.integers(0, 9), max_size=40),
    st.integers(1, 7),
    st.integers(0, 30),
    st.integers(2, 60),
)
def test_whatever_comes_is_read_once_in_order_or_counted_as_gone(runs, most, sealed, kept):
    """`runs` are so many entries between two looks; what is missing is always said."""
    entry = TraceEntry(0.0, EntryKind.REPLY, "done")
    ring = EntryRing(most_bytes=kept * (ENTRY_BYTES + len(entry.what)))
    log = reader(ring, back=1000)
    read, added = [], 0
    for run in [*runs, *[0] * 60]:
        for _ in range(run):
            if added == sealed:
                ring.seal()
            ring.add(entry)
            added += 1
        read += log.read(most)
    told = [each.number for each in read if each.kind is not EntryKind.DROPPED]
    gone = sum(int(each.words.split()[0]) for each in read if each.kind is EntryKind.DROPPED)
    assert told == sorted(set(told))
    assert len(told) + gone == added == ring.added


def test_a_message_that_began_before_a_gap_is_no_message():
    ring = EntryRing(most_bytes=2 * (ENTRY_BYTES + 2))
    ring.seal()
    log = reader(ring)
    ring.add(TraceEntry(0.0, EntryKind.RECEIVED, b"1,"))
    log.read()
    for piece in (b"x", b"x", b"x", b"1", b"\r"):
        ring.add(TraceEntry(0.0, EntryKind.RECEIVED, piece))
    assert log.read()[-1].words == "done"


# -- sieving -----------------------------------------------------------------------------------


def test_topics_and_texts_are_sieved():
    sent = line(0, EntryKind.SENT, "base +37", shown="@STEP")
    failed = line(1, EntryKind.RAISED, "NoAnswer: no answer", code="E502")
    for sieve, passed in (
        (LogFilter(frozenset({Topic.BYTES})), [sent]),
        (LogFilter(text="ANSWER"), [failed]),
        (LogFilter(text="e502"), [failed]),
        (LogFilter(text="step,37"), [sent]),
        (LogFilter(text="step,38"), []),
        (LogFilter().toggled(Topic.BYTES), [failed]),
        (LogFilter().toggled(Topic.BYTES).toggled(Topic.BYTES), [sent, failed]),
    ):
        assert list(filter(sieve.passes, [sent, failed])) == passed


# -- the command ---------------------------------------------------------------------------------


@pytest.fixture
def recording(arm, tmp_path):
    arm.move_motors(0, 0, 0, 0, 5, 0)
    return str(arm.recorder.save(tmp_path / "some.jsonl"))


def test_a_recording_is_printed_in_the_same_words_as_the_arm_is_read(call, arm, recording):
    printed = call("log", recording, code=0).out.splitlines()[1:]
    live = [str(each) for each in arm.recorder.log().read()]
    assert printed == live
    views = call("log", recording, "--json", code=0).json_lines
    assert [each["words"] for each in views] == [each.words for each in arm.recorder.log().read()]


def test_the_newest_recording_is_read_where_none_is_named(call, arm):
    assert "there is no recording" in call.refused("log", code=2)
    for number in range(2):
        file = arm.recorder.save()
        os.utime(file, (number, number))
    assert call("log", code=0).out.startswith(f"{file}: ")


# -- Wording ---------------------------------------------------------------------------------------


def sent(dialect, data):
    row = describer(dialect)
    return row.words(data, row.sent)


SENT = [
    (
        "teachmover",
        b"@STEP 214,37,0,-4,0,0,0\r",
        "step at speed 214: base +37, elbow -4",
    ),
    ("teachmover", b"@READ\r", "read the registers"),
    ("teachmover", b"@NONSENSE\r", "unreadable"),
    ("armdroid", b"6,20-d", "move the base by -20"),
    ("armdroid", b"oD", "read the offsets; move by the stored numbers"),
    ("grbl", b"G91G1F11014Y+8Z+3\n!", "feed hold; G91G1F11014Y+8Z+3"),
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
]  # fmt: skip


@every_row("dialect, data, words", SENT)
def test_host_messages_are_described(dialect, data, words):
    assert sent(dialect, data) == words


HEARD = [
    ("teachmover", b"2", "the pendant's STOP key was pressed"),
    (
        "teachmover",
        b"1,-2,3,4,5,6,0",
        "registers: base 1, shoulder -2, elbow 3, right wrist 4, left wrist 5, gripper 6",
    ),
    ("armdroid", b"torque = disabled", "the motors are off"),
    ("grbl", b"error:9", "refused (9): locked: alarm or jog"),
    ("grbl", b"ALARM:1", "alarm 1: "),
    ("grbl", b"<Run|MPos:1.000,-2.500|FS:300,0|Bf:12,200>", "Run at 1 -2.5, feed 300"),
    ("mks", pack(Frame(4, bytes.fromhex("3100000000000136"))), "4: the encoder is at 1"),
    ("cia402", pack(Frame(0x184, bytes.fromhex("37020801000000"))), "4: 0237 enabled"),
]


@every_row("dialect, data, words", HEARD)
def test_device_messages_are_described(dialect, data, words):
    assert describer(dialect).words(data, describer(dialect).received).startswith(words)


def test_any_message_has_words_of_its_name_and_its_fields():
    wording = describer("teachmover").wording
    assert wording(DriveOne(2, 12)) == "drive one: motor 2, steps 12"
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
     "start gripper move: opening 30 mm, speed 1"),
    ("move_to", (TIPS,), {"wait": False}, f"move_to {TIPS}, wait no"),
    ("move_path", ([LinePart(TIPS)],), {}, f"move_path line part: goal {TIPS}, blend 0 mm"),
    ("move_j", ({"shoulder_deg": 40},), {"frame": None}, "move_j shoulder 40 deg"),
    ("release", (), {}, "release"),
]  # fmt: skip


@every_row("name, arguments, named, words", CALLS)
def test_a_call_is_told_in_words(name, arguments, named, words):
    assert told_by(lambda recorder: recorder.called(name, arguments, named)) == words


@every_row(
    "request_, words",
    [
        (ReadPosition(), "read position"),
        (FixSetting("$110=500 (mm)"), "fix setting line $110=500 (mm)"),
        (MoveBy(Motors((37, 0, -4)), 219.5), "move by 37 0 -4; 219.5 steps/s"),
    ],
)
def test_a_request_is_told_in_words(request_, words):
    assert told_by(lambda recorder: recorder.requested(request_)) == words


def told_by(happens):
    """Return the words of what a recorder notes."""
    recorder = FlightRecorder()
    happens(recorder)
    _, (entry,) = recorder.since(0, 1, 1)
    return Narrator("teachmover").line(0, entry).words


@pytest.mark.parametrize("dialect", sorted(DIALECTS))
def test_a_whole_session_has_words_and_none_of_them_is_python(dialect):
    arm = recorded_arm(dialect)
    arm.move_motors(0, 0, 0, 0, 3, 0)
    arm.jogging.nudge(Jog.joint(base=1), speed=0.1)
    arm.sleep(1.0)
    entries = arm.parts.tracer.ring.entries()
    arm.close()
    narrator = Narrator(dialect)
    told = [(entry, narrator.line(0, entry).words) for entry in entries]
    assert all(words for entry, words in told if entry.kind is EntryKind.SENT)
    assert any(words for entry, words in told if entry.kind is EntryKind.RECEIVED)
    if dialect == "mks":  # frames of a bus are written as frames
        sent = next(entry for entry in entries if entry.kind is EntryKind.SENT)
        first = Narrator(dialect).line(0, sent)
        assert (first.shown[:4], first.words) == ("001#", "1 2 3 4 5 6: read encoder")
    for _, words in told:
        assert not {"(", "<", "unreadable"} & set(words.split()[:1])
        for python in ("()", "=<", "<Space", "=("):
            assert python not in words


@every_row(
    "event, words",
    [
        (Unreadable(b"ok1\xff", "no answer"), r"unreadable: `ok1\xff`: no answer"),
        (Stray(Status.DONE), "stray: answer done"),
        (Stray(DriveOne(2, 12)), "stray: answer drive one: motor 2, steps 12"),
        (UnreadableFrame(Frame(1, b"\x31\x02"), "bad sum"), "unreadable frame: 001#3102: bad sum"),
        (Foreign(Frame(0x123)), "foreign: frame 123#"),
    ],
)
def test_unsolicited_messages_are_described(event, words):
    assert plain(event) == words


# -- The wire tap ----------------------------------------------------------------------------------


def held():
    """An arm of which nothing is there but its recorder."""
    ring = EntryRing()
    ring.seal()
    return ring, SimpleNamespace(
        core=SimpleNamespace(tracer=ring), pace=SimpleNamespace(now_s=lambda: 7.0), closed=False
    )


def told(arm, ring, entries):
    """Begin to listen, have entries come, and return all that is told until the arm is closed."""
    stream = traffic(arm, 0.0)
    assert next(stream) == {}
    for each in entries:
        ring.add(each)
    arm.closed = True
    return list(stream)


def test_bytes_are_told_in_their_order_and_nothing_else_is():
    ring, arm = held()
    ring.add(TraceEntry(1.0, EntryKind.SENT, b"before"))
    entries = [
        TraceEntry(2.0, EntryKind.SENT, b"\x01\xff"),
        TraceEntry(2.1, EntryKind.STATE, "moving"),
        TraceEntry(2.2, EntryKind.RECEIVED, b"\x02"),
    ]
    (message,) = told(arm, ring, entries)
    wire = [(2.0, "sent", "01ff"), (2.2, "received", "02")]
    assert message == {"wire": wire, "missed": 0, "now_s": 7.0}


def test_messages_are_bounded_and_what_is_passed_over_is_counted():
    ring, arm = held()
    sizes = [5000, 300, 1024, 1025, *[40] * (TAP_BACK - 4)]
    entries = [TraceEntry(3.0, EntryKind.RECEIVED, bytes([7]) * size) for size in sizes]
    messages = told(arm, ring, [*entries[:10], *entries])
    wires = [message["wire"] for message in messages]
    assert sum(len(data) // 2 for wire in wires for _, _, data in wire) == sum(sizes)
    assert max(sum(len(data) for _, _, data in wire) for wire in wires) <= MESSAGE_BYTES
    assert sum(message["missed"] for message in messages) == 10
