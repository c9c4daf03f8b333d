"""MKS machines: the host's, the device's, and the two back to back."""

from collections.abc import Iterable

import pytest
from cases_mks import (
    ACTIONS,
    ANSWER_RECORDS,
    DRIVES,
    HALT,
    HERE,
    ONE,
    READ_SETTINGS,
    READS,
    REQUEST_RECORDS,
    SETTINGS,
    STARTED,
    asked,
    readings_for,
    said,
)
from chunks import events
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol import mks
from firmware_protocol.errors import BadField, LocalProtocolError
from firmware_protocol.frames import Frame, Unpacker, pack

# -- The host --------------------------------------------------------------------------------------


def test_an_answer_belongs_to_the_request_of_its_drive_and_code():
    host = mks.Host(DRIVES)
    for node in DRIVES:
        host.send(node, mks.ReadEncoder())
        host.send(node, mks.ReadState())
    for node in reversed(DRIVES):
        assert events(
            host, said(node, mks.StateRead(mks.MotorState.STOPPED), mks.EncoderRead(node))
        ) == [
            mks.Answered(node, mks.StateRead(mks.MotorState.STOPPED), mks.ReadState()),
            mks.Answered(node, mks.EncoderRead(node), mks.ReadEncoder()),
        ]


def test_a_newer_request_with_the_same_code_replaces_an_older_one():
    host = asked(ONE, HALT, mks.SetMode(mks.Mode.BUS_FOC), mks.ReadSetting(mks.Code.MODE))
    told = mks.SettingRead(mks.Code.MODE, b"\5")
    assert events(host, said(1, told, STARTED)) == [
        mks.Answered(1, told, mks.ReadSetting(mks.Code.MODE)),
        mks.Answered(1, STARTED, HALT),
    ]


def test_an_id_is_one_of_a_drive():
    with pytest.raises(BadField, match="node"):
        mks.Host([0])
    host = mks.Host(DRIVES)
    with pytest.raises(LocalProtocolError, match="no drive of this host has the id 9"):
        host.send(9, mks.ReadEncoder())


def test_what_nobody_asked_for_belongs_to_no_request():
    assert events(mks.Host(DRIVES), said(1, HERE)) == [mks.Answered(1, HERE)]
    assert events(asked(mks.ReadEncoder()), said(1, HERE, HERE)) == [
        mks.Answered(1, HERE, mks.ReadEncoder()),
        mks.Answered(1, HERE),  # a second drive of this id
    ]


def test_a_late_answer_to_a_forgotten_request_belongs_to_none():
    host = asked(mks.ReadEncoder(), ONE)
    host.forget(1)
    assert events(host, said(1, HERE, STARTED)) == [
        mks.Answered(1, HERE),
        mks.Answered(1, STARTED),
    ]


def test_what_came_before_a_request_does_not_answer_it():
    host = mks.Host(DRIVES)
    host.receive_data(said(1, HERE))
    host.send(1, mks.ReadEncoder())
    assert events(host) == [mks.Answered(1, HERE)]
    assert events(host, said(1, HERE)) == [mks.Answered(1, HERE, mks.ReadEncoder())]


def test_what_is_not_from_a_drive_is_foreign():
    frames = [Frame(0x181, b"\1"), Frame(1, b"\x31", extended=True), Frame(1, remote=True)]
    host = asked(mks.ReadEncoder())
    assert events(host, b"".join(map(pack, frames))) == [mks.Foreign(frame) for frame in frames]


def test_a_bad_check_byte_is_garbled_and_answers_nothing():
    host = asked(mks.ReadEncoder())
    good = mks.encode(1, HERE)
    bad = Frame(1, good.data[:-1] + b"\0")
    assert events(host, pack(bad) + pack(good)) == [
        mks.UnreadableFrame(bad, "the check byte should be ad"),
        mks.Answered(1, HERE, mks.ReadEncoder()),
    ]


# -- The device ------------------------------------------------------------------------------------


def put(can_id, *requests) -> list[Frame]:
    return [mks.encode(can_id, request) for request in requests]


def heard_of(frame: Frame):
    """Return who heard_of what."""
    return frame.can_id, mks.decode_answer(frame)


def events_of(device: mks.Device, frames: Iterable[Frame]) -> list[mks.Asked]:
    """Return the requests that a drive hears in frames."""
    return [asked for frame in frames if (asked := device.hear(frame)) is not None]


def test_it_ignores_what_is_for_others_or_unreadable_or_not_in_its_firmware():
    device = mks.Device(1, (1, 0, 8))
    assert device.abilities == mks.abilities_of((1, 0, 8))
    frames = [
        Frame(1, b"\x31\x33"),
        Frame(1, b"\x77\x78"),
        Frame(1, b"\x31\x32", extended=True),
        Frame(1, remote=True),
        Frame(0x181, b"\1"),
        *put(2, mks.ReadState()),
        *put(1, mks.SilenceWatchdog(500)),
    ]
    assert events_of(device, frames) == []
    assert events_of(device, put(mks.BROADCAST, mks.ReadState())) == [
        mks.Asked(mks.ReadState(), alone=False)
    ]


def test_without_replies_at_the_end_no_end_of_a_motion_is_reported():
    device = mks.Device(1, replies=mks.ReplyMode.IMMEDIATE)
    silent = {each for each in mks.Outcome if device.tell(mks.Asked(ONE), each) is None}
    assert silent == {mks.Outcome.DONE, mks.Outcome.LIMIT_STOP}


def test_a_new_id_answers_once_it_is_done():
    for outcome, by in ((mks.Outcome.FAILED, 1), (mks.Outcome.DONE, 9)):
        told = mks.Device(1).tell(mks.Asked(mks.SetId(9)), outcome)
        assert heard_of(told) == (by, mks.Status(mks.Code.NODE, outcome))


def test_the_answers_of_a_second_drive_of_its_id_are_commands_to_it():
    # why several drives of one id on a bus switch each other's modes
    first, second = mks.Device(1), mks.Device(1)
    enabled = first.tell(mks.Asked(mks.Enable(False)), mks.Outcome.DONE)
    assert events_of(second, [enabled]) == [mks.Asked(mks.Enable(True))]


def test_no_drive_has_the_id_of_all():
    with pytest.raises(BadField):
        mks.Device(0)


# -- Back to back ----------------------------------------------------------------------------------

ONE_OF_NODES = st.sampled_from(DRIVES)


def heard_by(drive: mks.Device, data: bytes) -> list[object]:
    """Return what a drive makes of what a host has sent."""
    return events_of(drive, Unpacker().feed(data))


class Bus:
    """A host and its drives: whatever is sent is heard by all others."""

    def __init__(self, nodes=DRIVES) -> None:
        self.host = mks.Host(nodes)
        self.drives = {node: mks.Device(node) for node in nodes}

    def put(self, node, request) -> dict[int, list[mks.Asked]]:
        """Have the host send, and return what each drive hears."""
        one = node in self.drives
        data = self.host.send(node, request) if one else pack(mks.encode(node, request))
        heard = {node: heard_by(drive, data) for node, drive in self.drives.items()}
        return {node: found for node, found in heard.items() if found}

    def say(self, node, frame) -> list[object]:
        """Have a drive send; the others hear it too, and nothing in it is for them."""
        others = [drive for other, drive in self.drives.items() if other != node]
        assert all(events_of(drive, [frame]) == [] for drive in others)
        return events(self.host, pack(frame))


@given(st.lists(st.tuples(ONE_OF_NODES, READS | READ_SETTINGS), max_size=6), st.data())
def test_every_read_is_answered_by_its_drive(script, data):
    bus = Bus()
    for node, read in script:
        assert bus.put(node, read) == {node: [mks.Asked(read)]}
        reading = data.draw(readings_for(read))
        answer = bus.drives[node].answer(mks.Asked(read), reading)
        assert bus.say(node, answer) == [mks.Answered(node, reading, read)]


TOLD = (ACTIONS | SETTINGS).filter(
    lambda request: not isinstance(request, mks.SetId | mks.SetReplies)
)


@given(st.lists(st.tuples(ONE_OF_NODES, TOLD, st.booleans()), max_size=6))
def test_every_setting_and_action_is_done_or_failed(script):
    bus = Bus()
    for node, request, works in script:
        outcome = mks.Outcome.DONE if works else mks.Outcome.FAILED
        assert bus.put(node, request) == {node: [mks.Asked(request)]}
        told = bus.drives[node].tell(mks.Asked(request), outcome)
        (event,) = bus.say(node, told)
        assert (event.request, event.answer.outcome) == (request, outcome)


def test_a_broadcast_stop_reaches_all_and_is_answered_by_none():
    bus = Bus()
    heard = bus.put(mks.BROADCAST, mks.EmergencyStop())
    assert set(heard) == set(DRIVES)
    for node, (stop,) in heard.items():
        assert bus.drives[node].tell(stop, mks.Outcome.DONE) is None


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
    host, drive = mks.Host(DRIVES), mks.Device(node)
    stream = b"".join(messes)
    events(host, stream)
    heard_by(drive, stream)
    host.silence()
    events(host)
    reading = data.draw(readings_for(read))
    assert heard_by(drive, host.send(node, read)) == [mks.Asked(read)]
    assert events(host, pack(drive.answer(mks.Asked(read), reading))) == [
        mks.Answered(node, reading, read)
    ]
