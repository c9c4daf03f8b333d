"""A drive's end of the bus: what it hears, what it says, and what it keeps quiet about."""

import pytest
from chunks import events
from hypothesis import given
from hypothesis import strategies as st
from mks_strategies import ACTIONS, MOTIONS, REPORTS, SETTINGS

from firmware_protocol import mks
from firmware_protocol.errors import BadField, LocalProtocolError
from firmware_protocol.frames import Frame, Unpacker, pack

MOVE = mks.MoveAbsoluteAxis(0x4000, 600, 2)
HERE = mks.EncoderRead(5)
ENDS = (mks.Outcome.DONE, mks.Outcome.LIMIT_STOP)


def put(can_id, *requests) -> bytes:
    return b"".join(pack(mks.encode(can_id, request)) for request in requests)


def said(data: bytes):
    """Return who said what, or None where nothing was said."""
    frames = Unpacker().feed(data)
    return (frames[0].can_id, mks.decode_answer(frames[0])) if frames else None


def test_a_drive_hears_what_is_for_it_for_its_group_and_for_all():
    device = mks.Device(3, group=0x50)
    data = (
        put(3, MOVE)
        + put(2, mks.ReadState())
        + put(0x50, MOVE)
        + put(mks.BROADCAST, mks.GoSynchronous())
    )
    assert events(device, data) == [
        mks.Asked(MOVE),
        mks.Asked(MOVE, alone=False),
        mks.Asked(mks.GoSynchronous(), alone=False),
    ]


def test_frames_of_another_kind_are_nothing_to_it():
    frames = [Frame(1, b"\x31\x32", extended=True), Frame(1, remote=True), Frame(0x181, b"\1")]
    assert events(mks.Device(1), b"".join(map(pack, frames))) == []


def test_what_it_cannot_read_is_ignored_with_a_reason():
    device = mks.Device(1)
    bad, odd = Frame(1, b"\x31\x33"), Frame(1, b"\x77\x78")
    assert events(device, pack(bad) + pack(odd)) == [
        mks.UnreadableFrame(bad, "the check byte should be 32"),
        mks.UnreadableFrame(odd, "no code has the number 77"),
    ]


def test_an_older_firmware_ignores_what_it_does_not_have():
    device = mks.Device(1, (1, 0, 8))
    assert device.abilities == mks.abilities_of((1, 0, 8))
    (ignored,) = events(device, put(1, mks.SilenceWatchdog(500)))
    assert ignored.reason == "firmware 1.0.8 has no SilenceWatchdog"
    assert events(device, put(mks.BROADCAST, mks.GoSynchronous())) == [
        mks.Asked(mks.GoSynchronous(), alone=False)
    ]


def test_it_answers_reads_and_says_how_motions_go():
    device = mks.Device(3)
    assert said(device.answer(mks.Asked(mks.ReadEncoder()), HERE)) == (3, HERE)
    for what in (mks.Outcome.STARTED, mks.Outcome.DONE):
        assert said(device.tell(mks.Asked(MOVE), what)) == (3, mks.Status(MOVE.code, what))
    assert said(device.report(HERE)) == (3, HERE)


def test_a_setting_is_answered_by_its_code_and_value():
    told = mks.SettingRead(mks.Code.MODE, b"\5")
    (frame,) = Unpacker().feed(
        mks.Device(1).answer(mks.Asked(mks.ReadSetting(mks.Code.MODE)), told)
    )
    assert mks.decode_answer(frame, setting=True) == told


@pytest.mark.parametrize(
    ("request_", "answer"),
    [
        (mks.ReadState(), HERE),
        (mks.Enable(True), mks.EnabledRead(True)),
        (mks.ReadEncoder(), mks.SettingRead(mks.Code.MODE, b"\5")),
        (mks.ReadSetting(mks.Code.MODE), mks.SettingRead(mks.Code.CURRENT, b"\5")),
        (mks.ReadSetting(mks.Code.MODE), HERE),
    ],
)
def test_only_what_fits_answers_a_read(request_, answer):
    with pytest.raises(LocalProtocolError, match="is no answer to"):
        mks.Device(1).answer(mks.Asked(request_), answer)


def test_only_what_fits_is_said_of_a_request():
    device = mks.Device(1)
    with pytest.raises(LocalProtocolError, match="ReadState is answered by a reading"):
        device.tell(mks.Asked(mks.ReadState()), mks.Outcome.DONE)
    with pytest.raises(BadField, match="outcome must be for ENABLE one of: DONE, FAILED"):
        device.tell(mks.Asked(mks.Enable(True)), mks.Outcome.STARTED)
    with pytest.raises(BadField, match="outcome must be for GO one of: none"):
        device.tell(mks.Asked(mks.GoSynchronous(), alone=False), mks.Outcome.DONE)


@given(
    st.one_of(MOTIONS, ACTIONS, SETTINGS, REPORTS), st.sampled_from(mks.ReplyMode), st.booleans()
)
def test_it_says_what_its_replies_let_it_and_nothing_to_several(request_, replies, alone):
    for what in mks.Outcome:
        device = mks.Device(1, replies=replies)
        reading = request_.reading if isinstance(request_, mks.ReportByItself) else None
        try:
            mks.Status(request_.code, what, reading)
        except BadField:
            continue
        ends = request_.code in mks.COURSE_CODES and what in ENDS
        speaks = alone and (
            replies is mks.ReplyMode.FULL or (replies is mks.ReplyMode.IMMEDIATE and not ends)
        )
        assert bool(device.tell(mks.Asked(request_, alone), what)) == speaks


@pytest.mark.parametrize("replies", mks.ReplyMode)
def test_reads_are_answered_whatever_its_replies_but_not_to_several(replies):
    device = mks.Device(1, replies=replies)
    assert device.answer(mks.Asked(mks.ReadEncoder()), HERE)
    assert device.answer(mks.Asked(mks.ReadEncoder(), alone=False), HERE) == b""


@pytest.mark.parametrize(("new_id_answers", "by"), [(True, 9), (False, 1)])
def test_a_new_id_takes_effect_once_it_is_done(new_id_answers, by):
    device = mks.Device(1, new_id_answers=new_id_answers)
    assert said(device.tell(mks.Asked(mks.SetId(9)), mks.Outcome.FAILED)) == (
        1,
        mks.Status(mks.Code.NODE, mks.Outcome.FAILED),
    )
    assert device.node == 1
    assert said(device.tell(mks.Asked(mks.SetId(9)), mks.Outcome.DONE)) == (
        by,
        mks.Status(mks.Code.NODE, mks.Outcome.DONE),
    )
    assert device.node == 9
    assert events(device, put(1, MOVE) + put(9, MOVE)) == [mks.Asked(MOVE)]


def test_groups_replies_and_bitrates_take_effect_for_several_too():
    device = mks.Device(1)
    for request in (
        mks.SetGroup(0x50),
        mks.SetReplies(mks.ReplyMode.NONE),
        mks.SetBitrate(mks.Bitrate.K1000),
    ):
        assert device.tell(mks.Asked(request, alone=False), mks.Outcome.DONE) == b""
    assert (device.group, device.replies, device.bitrate) == (
        0x50,
        mks.ReplyMode.NONE,
        mks.Bitrate.K1000,
    )


def test_the_oldest_firmware_answers_what_is_put_to_several():
    device = mks.Device(3, (1, 0, 1))
    assert said(device.tell(mks.Asked(mks.Home(), alone=False), mks.Outcome.STARTED)) == (
        3,
        mks.Status(mks.Code.HOME, mks.Outcome.STARTED),
    )


def test_the_answers_of_a_second_drive_of_its_id_are_commands_to_it():
    # why several drives of one id on a bus switch each other's modes
    first, second = mks.Device(1), mks.Device(1)
    enabled = first.tell(mks.Asked(mks.Enable(False)), mks.Outcome.DONE)
    assert events(second, enabled) == [mks.Asked(mks.Enable(True))]


def test_a_flood_that_nobody_fetches_is_bounded_and_ends_with_the_newest():
    device = mks.Device(1)
    device.receive_data(put(1, *[mks.Home()] * 300))
    lost, *kept = events(device)
    assert lost == mks.Overrun(44)
    assert kept == [mks.Asked(mks.Home())] * 256


def test_without_current_it_has_heard_nothing():
    device = mks.Device(1)
    device.receive_data(put(1, MOVE) + put(1, MOVE)[:5])
    assert device.buffered == 5
    device.discard()
    assert device.buffered == 0
    assert events(device) == []


@pytest.mark.parametrize("build", [lambda: mks.Device(0), lambda: mks.Device(1, group=0)])
def test_no_drive_has_the_id_of_all(build):
    with pytest.raises(BadField):
        build()
