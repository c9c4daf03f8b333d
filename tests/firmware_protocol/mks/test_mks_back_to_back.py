"""One host and six drives on a bus, and what the bus may do to their bytes."""

from chunks import events
from fuzzing_mks import ANSWER_RECORDS, REQUEST_RECORDS
from hypothesis import given
from hypothesis import strategies as st
from mks_strategies import (
    ACTIONS,
    MOVES,
    READ_SETTINGS,
    READS,
    REPORTS,
    SETTINGS,
    readings_for,
)

from firmware_protocol import mks
from firmware_protocol.frames import Frame, pack

NODES = range(1, 7)
ONE_OF_NODES = st.sampled_from(NODES)


class Bus:
    """A host and its drives: whatever is sent is heard by all others."""

    def __init__(self, nodes=NODES) -> None:
        self.host = mks.Host(nodes)
        self.drives = {node: mks.Device(node) for node in nodes}

    def put(self, node, request) -> dict[int, list[mks.Asked]]:
        """Have the host send, and return what each drive hears."""
        data = self.host.send(node, request)
        heard = {node: events(drive, data) for node, drive in self.drives.items()}
        return {node: found for node, found in heard.items() if found}

    def say(self, node, data) -> list[object]:
        """Have a drive send; the others hear it too, and nothing in it is for them."""
        assert all(
            events(drive, data) == [] for other, drive in self.drives.items() if other != node
        )
        return events(self.host, data)


@given(st.lists(st.tuples(ONE_OF_NODES, READS | READ_SETTINGS), max_size=6), st.data())
def test_every_read_is_answered_by_its_drive(script, data):
    bus = Bus()
    for node, read in script:
        assert bus.put(node, read) == {node: [mks.Asked(read)]}
        reading = data.draw(readings_for(read))
        answer = bus.drives[node].answer(mks.Asked(read), reading)
        assert bus.say(node, answer) == [mks.Answered(node, read, reading)]


TOLD = (ACTIONS | SETTINGS | REPORTS).filter(
    lambda request: not isinstance(request, mks.SetId | mks.SetGroup | mks.SetReplies)
)


@given(st.lists(st.tuples(ONE_OF_NODES, TOLD, st.booleans()), max_size=6))
def test_every_setting_and_action_is_done_or_failed(script):
    bus = Bus()
    for node, request, works in script:
        outcome, kind = (mks.Outcome.DONE, mks.Done) if works else (mks.Outcome.FAILED, mks.Failed)
        assert bus.put(node, request) == {node: [mks.Asked(request)]}
        told = bus.drives[node].tell(mks.Asked(request), outcome)
        assert bus.say(node, told) == [kind(node, request)]


@given(st.lists(MOVES, min_size=6, max_size=6), st.permutations(NODES), st.booleans())
def test_six_motions_are_stored_and_start_together(moves, ends, limit):
    bus = Bus()
    assert bus.put(mks.BROADCAST, mks.ArmSynchronous(True)) == {
        node: [mks.Asked(mks.ArmSynchronous(True), alone=False)] for node in NODES
    }
    for node, move in zip(NODES, moves, strict=True):
        assert bus.put(node, move) == {node: [mks.Asked(move)]}
        stored = bus.drives[node].tell(mks.Asked(move), mks.Outcome.STORED)
        assert bus.say(node, stored) == [mks.StoredForStart(node, move)]
    assert bus.put(mks.BROADCAST, mks.GoSynchronous()) == {
        node: [mks.Asked(mks.GoSynchronous(), alone=False)] for node in NODES
    }
    outcome, kind = (
        (mks.Outcome.LIMIT_STOP, mks.LimitStop) if limit else (mks.Outcome.DONE, mks.Done)
    )
    for node in ends:
        move = moves[node - 1]
        told = bus.drives[node].tell(mks.Asked(move), outcome)
        assert bus.say(node, told) == [kind(node, move)]


@given(ONE_OF_NODES, MOVES)
def test_without_completions_a_motion_is_over_when_its_owner_says_so(node, move):
    bus = Bus()
    bus.put(node, mks.SetReplies(mks.ReplyMode.IMMEDIATE))
    told = bus.drives[node].tell(
        mks.Asked(mks.SetReplies(mks.ReplyMode.IMMEDIATE)), mks.Outcome.DONE
    )
    assert bus.say(node, told) == [mks.Done(node, mks.SetReplies(mks.ReplyMode.IMMEDIATE))]
    bus.put(node, move)
    started = bus.drives[node].tell(mks.Asked(move), mks.Outcome.STARTED)
    assert bus.say(node, started) == [mks.Started(node, move)]
    assert bus.drives[node].tell(mks.Asked(move), mks.Outcome.DONE) == b""
    bus.host.settle(node)
    done = mks.Status(move.code, mks.Outcome.DONE)
    assert bus.say(node, pack(mks.encode(node, done))) == [mks.Stray(node, done)]


@given(st.booleans())
def test_a_drive_as_shipped_gets_an_id_of_its_own(new_id_answers):
    host, drive = mks.Host([1]), mks.Device(new_id_answers=new_id_answers)
    assert events(drive, host.send(1, mks.SetId(4))) == [mks.Asked(mks.SetId(4))]
    assert events(host, drive.tell(mks.Asked(mks.SetId(4)), mks.Outcome.DONE)) == [
        mks.Done(1, mks.SetId(4))
    ]
    assert events(drive, host.send(4, mks.ReadEncoder())) == [mks.Asked(mks.ReadEncoder())]


def test_a_broadcast_stop_reaches_all_and_is_answered_by_none():
    bus = Bus()
    heard = bus.put(mks.BROADCAST, mks.EmergencyStop())
    assert set(heard) == set(NODES)
    for node, (asked,) in heard.items():
        assert bus.drives[node].tell(asked, mks.Outcome.DONE) == b""


FRAMES = ANSWER_RECORDS | REQUEST_RECORDS
MESSES = st.lists(
    st.one_of(
        FRAMES,
        FRAMES.map(lambda frame: frame[: len(frame) // 2]),
        st.binary(max_size=30),
        st.builds(
            lambda node, data: pack(Frame(node, data)), st.integers(0, 7), st.binary(max_size=8)
        ),
    ),
    max_size=10,
)


@given(MESSES, ONE_OF_NODES, READS, st.data())
def test_after_any_mess_a_read_is_answered_once_a_silence_follows(messes, node, read, data):
    host, drive = mks.Host(NODES), mks.Device(node)
    stream = b"".join(messes)
    events(host, stream)
    events(drive, stream)
    host.silence()
    drive.silence()
    events(host)
    events(drive)
    reading = data.draw(readings_for(read))
    assert events(drive, host.send(node, read)) == [mks.Asked(read)]
    assert events(host, drive.answer(mks.Asked(read), reading)) == [
        mks.Answered(node, read, reading)
    ]


@given(st.integers(0, 0x7FF), st.binary(min_size=1, max_size=7))
def test_a_well_checked_frame_of_anything_is_heard_by_whom_it_is_for(can_id, data):
    record = pack(Frame(can_id, data + bytes((mks.check_byte(can_id, data),))))
    (event,) = events(mks.Host(NODES), record)
    assert isinstance(event, mks.Foreign) == (can_id not in NODES)
    found = events(mks.Device(1), record)
    assert len(found) == (can_id in (0, 1))
    assert all(isinstance(event, mks.Asked | mks.UnreadableFrame) for event in found)
