"""A drive's end of the bus: what it hears, what it says, and what it keeps quiet about."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mks_strategies import ACTIONS, MOTIONS, REPORTS, SETTINGS, events

from firmware_protocol.errors import BadField, LocalProtocolError
from firmware_protocol.frames import Frame, Unpacker, pack
from firmware_protocol.mks import (
    BROADCAST,
    COURSE_CODES,
    Asked,
    Bitrate,
    Code,
    Device,
    Enable,
    EnabledRead,
    EncoderRead,
    GoSynchronous,
    Home,
    Ignored,
    MoveAbsoluteAxis,
    Outcome,
    Overrun,
    ReadEncoder,
    ReadSetting,
    ReadState,
    ReplyMode,
    ReportByItself,
    SetBitrate,
    SetGroup,
    SetId,
    SetReplies,
    SettingRead,
    SilenceWatchdog,
    Status,
    abilities_of,
    decode_answer,
    encode,
)

MOVE = MoveAbsoluteAxis(0x4000, 600, 2)
HERE = EncoderRead(5)
ENDS = (Outcome.DONE, Outcome.LIMIT_STOP)


def put(can_id, *requests) -> bytes:
    return b"".join(pack(encode(can_id, request)) for request in requests)


def said(data: bytes):
    """Return who said what, or None where nothing was said."""
    frames = Unpacker().feed(data)
    return (frames[0].can_id, decode_answer(frames[0])) if frames else None


def test_a_drive_hears_what_is_for_it_for_its_group_and_for_all():
    device = Device(3, group=0x50)
    data = put(3, MOVE) + put(2, ReadState()) + put(0x50, MOVE) + put(BROADCAST, GoSynchronous())
    assert events(device, data) == [
        Asked(MOVE),
        Asked(MOVE, alone=False),
        Asked(GoSynchronous(), alone=False),
    ]


def test_frames_of_another_kind_are_nothing_to_it():
    frames = [Frame(1, b"\x31\x32", extended=True), Frame(1, remote=True), Frame(0x181, b"\1")]
    assert events(Device(1), b"".join(map(pack, frames))) == []


def test_what_it_cannot_read_is_ignored_with_a_reason():
    device = Device(1)
    bad, odd = Frame(1, b"\x31\x33"), Frame(1, b"\x77\x78")
    assert events(device, pack(bad) + pack(odd)) == [
        Ignored(bad, "the check byte should be 32"),
        Ignored(odd, "no code has the number 77"),
    ]


def test_an_older_firmware_ignores_what_it_does_not_have():
    device = Device(1, (1, 0, 8))
    assert device.abilities == abilities_of((1, 0, 8))
    (ignored,) = events(device, put(1, SilenceWatchdog(500)))
    assert ignored.reason == "firmware 1.0.8 has no SilenceWatchdog"
    assert events(device, put(BROADCAST, GoSynchronous())) == [Asked(GoSynchronous(), alone=False)]


def test_it_answers_reads_and_says_how_motions_go():
    device = Device(3)
    assert said(device.answer(Asked(ReadEncoder()), HERE)) == (3, HERE)
    for what in (Outcome.STARTED, Outcome.DONE):
        assert said(device.tell(Asked(MOVE), what)) == (3, Status(MOVE.code, what))
    assert said(device.report(HERE)) == (3, HERE)


def test_a_setting_is_answered_by_its_code_and_value():
    told = SettingRead(Code.MODE, b"\5")
    (frame,) = Unpacker().feed(Device(1).answer(Asked(ReadSetting(Code.MODE)), told))
    assert decode_answer(frame, setting=True) == told


@pytest.mark.parametrize(
    ("request_", "answer"),
    [
        (ReadState(), HERE),
        (Enable(True), EnabledRead(True)),
        (ReadEncoder(), SettingRead(Code.MODE, b"\5")),
        (ReadSetting(Code.MODE), SettingRead(Code.CURRENT, b"\5")),
        (ReadSetting(Code.MODE), HERE),
    ],
)
def test_only_what_fits_answers_a_read(request_, answer):
    with pytest.raises(LocalProtocolError, match="is no answer to"):
        Device(1).answer(Asked(request_), answer)


def test_only_what_fits_is_said_of_a_request():
    device = Device(1)
    with pytest.raises(LocalProtocolError, match="ReadState is answered by a reading"):
        device.tell(Asked(ReadState()), Outcome.DONE)
    with pytest.raises(BadField, match="outcome must be for ENABLE one of: DONE, FAILED"):
        device.tell(Asked(Enable(True)), Outcome.STARTED)
    with pytest.raises(BadField, match="outcome must be for GO one of: none"):
        device.tell(Asked(GoSynchronous(), alone=False), Outcome.DONE)


@given(st.one_of(MOTIONS, ACTIONS, SETTINGS, REPORTS), st.sampled_from(ReplyMode), st.booleans())
def test_it_says_what_its_replies_let_it_and_nothing_to_several(request_, replies, alone):
    for what in Outcome:
        device = Device(1, replies=replies)
        reading = request_.reading if isinstance(request_, ReportByItself) else None
        try:
            Status(request_.code, what, reading)
        except BadField:
            continue
        ends = request_.code in COURSE_CODES and what in ENDS
        speaks = alone and (
            replies is ReplyMode.FULL or (replies is ReplyMode.IMMEDIATE and not ends)
        )
        assert bool(device.tell(Asked(request_, alone), what)) == speaks


@pytest.mark.parametrize("replies", ReplyMode)
def test_reads_are_answered_whatever_its_replies_but_not_to_several(replies):
    device = Device(1, replies=replies)
    assert device.answer(Asked(ReadEncoder()), HERE)
    assert device.answer(Asked(ReadEncoder(), alone=False), HERE) == b""


@pytest.mark.parametrize(("new_id_answers", "by"), [(True, 9), (False, 1)])
def test_a_new_id_takes_effect_once_it_is_done(new_id_answers, by):
    device = Device(1, new_id_answers=new_id_answers)
    assert said(device.tell(Asked(SetId(9)), Outcome.FAILED)) == (
        1,
        Status(Code.NODE, Outcome.FAILED),
    )
    assert device.node == 1
    assert said(device.tell(Asked(SetId(9)), Outcome.DONE)) == (
        by,
        Status(Code.NODE, Outcome.DONE),
    )
    assert device.node == 9
    assert events(device, put(1, MOVE) + put(9, MOVE)) == [Asked(MOVE)]


def test_groups_replies_and_bitrates_take_effect_for_several_too():
    device = Device(1)
    for request in (SetGroup(0x50), SetReplies(ReplyMode.NONE), SetBitrate(Bitrate.K1000)):
        assert device.tell(Asked(request, alone=False), Outcome.DONE) == b""
    assert (device.group, device.replies, device.bitrate) == (
        0x50,
        ReplyMode.NONE,
        Bitrate.K1000,
    )


def test_the_oldest_firmware_answers_what_is_put_to_several():
    device = Device(3, (1, 0, 1))
    assert said(device.tell(Asked(Home(), alone=False), Outcome.STARTED)) == (
        3,
        Status(Code.HOME, Outcome.STARTED),
    )


def test_the_answers_of_a_second_drive_of_its_id_are_commands_to_it():
    # why several drives of one id on a bus switch each other's modes
    first, second = Device(1), Device(1)
    enabled = first.tell(Asked(Enable(False)), Outcome.DONE)
    assert events(second, enabled) == [Asked(Enable(True))]


def test_a_flood_that_nobody_fetches_is_bounded_and_ends_with_the_newest():
    device = Device(1)
    device.receive_data(put(1, *[Home()] * 300))
    lost, *kept = events(device)
    assert lost == Overrun(44)
    assert kept == [Asked(Home())] * 256


def test_without_current_it_has_heard_nothing():
    device = Device(1)
    device.receive_data(put(1, MOVE) + put(1, MOVE)[:5])
    assert device.buffered == 5
    device.discard()
    assert device.buffered == 0
    assert events(device) == []


@pytest.mark.parametrize("build", [lambda: Device(0), lambda: Device(1, group=0)])
def test_no_drive_has_the_id_of_all(build):
    with pytest.raises(BadField):
        build()
