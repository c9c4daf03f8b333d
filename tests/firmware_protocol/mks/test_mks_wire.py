"""MKS frames both ways: the bytes of each, that all can be read back, and what the sum misses."""

import contextlib

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mks_strategies import NODES, READINGS, REQUESTS, SETTINGS, setting_reads
from mks_vectors import ANSWER_BYTES, REQUEST_BYTES, frame_of

from firmware_protocol import mks
from firmware_protocol.errors import LocalProtocolError, RemoteProtocolError
from firmware_protocol.frames import Frame


@pytest.mark.parametrize(("request_", "text"), REQUEST_BYTES)
def test_a_request_is_these_bytes(request_, text):
    frame = frame_of(text)
    assert mks.encode(frame.can_id, request_) == frame
    assert mks.decode_request(frame) == request_


@pytest.mark.parametrize(("answer", "text"), ANSWER_BYTES)
def test_an_answer_is_these_bytes(answer, text):
    frame = frame_of(text)
    assert mks.encode(frame.can_id, answer) == frame
    assert mks.decode_answer(frame) == answer


def test_the_table_leaves_no_code_out():
    assert {request.code for request, _ in REQUEST_BYTES} == set(mks.Code)


@given(NODES, REQUESTS)
def test_every_request_can_be_read(node, request_):
    assert mks.decode_request(mks.encode(node, request_)) == request_


@given(NODES, READINGS)
def test_every_reading_can_be_read(node, reading):
    assert mks.decode_answer(mks.encode(node, reading)) == reading


@given(NODES, SETTINGS)
def test_a_setting_that_is_read_back_is_what_was_set(node, setting):
    told = mks.SettingRead(setting.code, setting.payload)
    assert mks.decode_answer(mks.encode(node, told), setting=True) == told
    assert mks.as_setting(told) == setting


@given(NODES, st.sampled_from(sorted(mks.SETTING_CODES)).flatmap(setting_reads))
def test_a_value_of_a_setting_means_something_or_says_why_not(node, told):
    assert mks.decode_answer(mks.encode(node, told), setting=True) == told
    with contextlib.suppress(RemoteProtocolError):
        setting = mks.as_setting(told)
        assert (setting is None) == (told.value is None)


def test_a_setting_that_the_drive_does_not_tell_is_none():
    # 83 is the code; 01 + 83 + FF + FF = 282
    told = mks.decode_answer(frame_of("01 83 FF FF 82"), setting=True)
    assert told == mks.SettingRead(mks.Code.CURRENT, None)
    assert mks.as_setting(told) is None
    with pytest.raises(LocalProtocolError, match="ENCODER is no setting"):
        mks.as_setting(mks.SettingRead(mks.Code.ENCODER, b"\1"))


def test_the_answers_to_setting_and_to_reading_a_mode_look_alike():
    frame = frame_of("01 82 01 84")
    assert mks.decode_answer(frame) == mks.Status(mks.Code.MODE, mks.Outcome.DONE)
    assert mks.as_setting(mks.decode_answer(frame, setting=True)) == mks.SetMode(
        mks.Mode.PULSE_CLOSED
    )


@pytest.mark.parametrize("code", sorted(mks.SETTING_CODES | mks.COURSE_CODES))
def test_every_outcome_of_a_code_is_read_back(code):
    for outcome in mks.Outcome:
        with contextlib.suppress(LocalProtocolError):
            status = mks.Status(code, outcome)
            assert mks.decode_answer(mks.encode(1, status)) == status


def test_a_current_that_is_not_kept_is_done_too():
    # the manual 1.0.9 answers 2; 01 + 83 + 02 = 86
    assert mks.decode_answer(frame_of("01 83 02 86")) == mks.Status(
        mks.Code.CURRENT, mks.Outcome.DONE
    )


@pytest.mark.parametrize("code", sorted(mks.MOTION_CODES - {mks.Code.SPEED_MODE}))
def test_a_speed_of_zero_is_a_stop_wherever_it_is_to_go(code):
    data = bytes((code, 0, 0, 7, 0, 0x40, 0))
    frame = Frame(1, data + bytes((mks.check_byte(1, data),)))
    assert mks.decode_request(frame) == mks.Stop(code, 7)


@given(st.one_of(REQUESTS, READINGS), NODES, st.integers(0, 7), st.integers(1, 255))
def test_one_changed_byte_is_always_noticed(message, node, at, change):
    good = mks.encode(node, message)
    data = bytearray(good.data)
    data[at % len(data)] ^= change
    for decode in (mks.decode_request, mks.decode_answer):
        with pytest.raises(RemoteProtocolError, match="the check byte should be"):
            decode(Frame(node, bytes(data)))


def test_a_sum_does_not_notice_what_adds_up_to_nothing():
    good = mks.encode(1, mks.MoveAbsoluteAxis(0x1234, 600, 2)).data
    swapped = good[:5] + good[6:4:-1] + good[7:]
    moved = good[:2] + bytes((good[2] + 1, good[3] - 1)) + good[4:]
    assert mks.decode_request(Frame(1, swapped)) == mks.MoveAbsoluteAxis(0x3412, 600, 2)
    assert mks.decode_request(Frame(1, moved)) == mks.MoveAbsoluteAxis(0x1234, 601, 1)
    assert mks.decode_request(Frame(0x101, good)) == mks.MoveAbsoluteAxis(0x1234, 600, 2)
    with pytest.raises(RemoteProtocolError):
        mks.decode_request(Frame(2, good))


@given(
    st.integers(0, 0x7FF), st.sampled_from(mks.Code) | st.integers(0, 255), st.binary(max_size=6)
)
def test_any_frame_has_a_meaning_or_a_typed_reason(node, code, payload):
    data = bytes((code,)) + payload
    frame = Frame(node, data + bytes((mks.check_byte(node, data),)))
    for decode in (mks.decode_request, mks.decode_answer):
        with contextlib.suppress(RemoteProtocolError):
            message = decode(frame)
            assert decode(mks.encode(node, message)) == message


@pytest.mark.parametrize(
    ("frame", "reason"),
    [
        (Frame(1), "length 0 where 2 to 8 belong"),
        (Frame(1, b"\x31"), "length 1 where 2 to 8 belong"),
        (Frame(1, b"\x31\x33"), "the check byte should be 32"),
        (Frame(1, b"\x31\x32", extended=True), "of another kind"),
        (Frame(1, remote=True), "of another kind"),
        (Frame(1, b"\x77\x78"), "no code has the number 77"),
        (Frame(1, b"\x31\x01\x33"), "ENCODER: length 1 where 0 belong"),
        (Frame(1, b"\x82\x06\x89"), "MODE: 6 is not a valid Mode"),
        (Frame(1, b"\xf3\x02\xf6"), "ENABLE: 2 where 0 or 1 belongs"),
        (Frame(1, b"\x00\x31\x32"), "READ_SETTING: setting must be the Code of a setting"),
    ],
)
def test_a_frame_that_is_no_request_says_why(frame, reason):
    with pytest.raises(RemoteProtocolError, match=reason):
        mks.decode_request(frame)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("01 4B 01 4D", "1 says nothing of GO"),
        ("01 F5 04 FA", "4 says nothing of ABSOLUTE_AXIS"),
        ("01 F5 F6", "length 0 where 1 belong"),
        ("01 F1 07 F9", "7 is not a valid MotorState"),
        ("01 3B 3C", "length 0 where 1 or 2 belong"),
        ("01 40 12 53", "length 1 where 3 or 4 belong"),
        ("01 01 82 01 85", "reading must be a reading's Code"),
    ],
)
def test_a_frame_that_is_no_answer_says_why(text, reason):
    with pytest.raises(RemoteProtocolError, match=reason):
        mks.decode_answer(frame_of(text))
