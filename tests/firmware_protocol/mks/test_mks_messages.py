"""MKS messages and their frames, ids first, as the manuals print them.

Examples of the manuals 1.0.6 and 1.0.9 (makerbase-motor/MKS-SERVO42D-57D), and by hand what they
have no example of. An F4 of nine bytes behind its id, which is printed too, is a misprint: no
frame of CAN has room for it.
"""

import contextlib
import math

import pytest
from amounts import every_row
from cases_mks import NODES, READINGS, REQUESTS, SETTINGS, setting_reads
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol import mks
from firmware_protocol.errors import BadField, LocalProtocolError, RemoteProtocolError
from firmware_protocol.frames import Frame


def other(code: mks.Code, payload: str) -> mks.OtherMotion:
    return mks.OtherMotion(code, bytes.fromhex(payload))


MANUAL_REQUESTS = [
    (mks.ReadEncoder(), "01 31 32"),
    (mks.EmergencyStop(), "01 F7 F8"),
    (mks.SetMode(mks.Mode.BUS_FOC), "01 82 05 88"),
    (mks.SetMode(mks.Mode.BUS_FOC), "00 82 05 87"),
    (mks.Home(), "01 91 92"),
    (mks.SetZero(), "01 92 93"),
    (mks.MoveAbsoluteAxis(0x4000, 600, 2), "01 F5 02 58 02 00 40 00 92"),
    (mks.MoveAbsoluteAxis(-0x4000, 600, 2), "01 F5 02 58 02 FF C0 00 11"),
    (other(mks.Code.RELATIVE_AXIS, "02 58 02 00 40 00"), "01 F4 02 58 02 00 40 00 91"),
    (other(mks.Code.RELATIVE_PULSES, "80 64 02 04 E2 00"), "02 FD 80 64 02 04 E2 00 CB"),
    (other(mks.Code.ABSOLUTE_PULSES, "02 58 02 00 0C 80"), "01 FE 02 58 02 00 0C 80 E7"),
    (other(mks.Code.SPEED_MODE, "81 40 02"), "01 F6 81 40 02 BA"),
    (mks.Stop(4), "01 F5 00 00 04 00 00 00 FA"),
    (mks.ArmSynchronous(True), "00 4A 01 4B"),
    (other(mks.Code.GO, ""), "00 4B 4B"),
    (mks.ReadSetting(mks.Code.CURRENT), "01 00 83 84"),
    (mks.Calibrate(), "01 80 00 81"),
]
# of these the check byte is the sum, done by hand
OTHER_REQUESTS = [
    (mks.ReadRawEncoder(), "01 35 36"),
    (mks.ReadAngleError(), "01 39 3A"),
    (mks.ReadEnabled(), "01 3A 3B"),
    (mks.ReadHoming(), "01 3B 3C"),
    (mks.ClearStall(), "01 3D 3E"),
    (mks.ReadStall(), "01 3E 3F"),
    (mks.ReadVersion(), "01 40 41"),
    (mks.ReadState(), "06 F1 F7"),
    (mks.Enable(True), "06 F3 01 FA"),
    (mks.Enable(False), "06 F3 00 F9"),
    (mks.SetCurrent(3200), "01 83 0C 80 10"),
    (mks.SetMicrosteps(16), "01 84 10 95"),
    (mks.SetMicrosteps(256), "01 84 00 85"),
    (mks.SetStallProtection(True), "01 88 01 8A"),
    (mks.SetHoming(False, True, 60, True, 1), "01 90 00 01 00 3C 01 01 D0"),
    (mks.SilenceWatchdog(500), "01 98 00 00 01 F4 8E"),
    (mks.SetBitrate(mks.Bitrate.K1000), "01 8A 03 8E"),
    (mks.SetId(0x123), "01 8B 01 23 B0"),
    (mks.SetReplies(mks.ReplyMode.IMMEDIATE), "01 8C 01 00 8E"),
    (mks.SetReplies(mks.ReplyMode.NONE), "01 8C 00 00 8D"),
]
ANSWER_BYTES = [
    (mks.EncoderRead(4), "01 31 00 00 00 00 00 04 36"),  # the manual's
    (mks.EncoderRead(0x3FF0 - 0x4000), "01 31 FF FF FF FF FF F0 1D"),  # its value a turn clockwise
    (mks.RawEncoderRead(0x7FF0), "01 35 00 00 00 00 7F F0 A5"),
    (mks.AngleErrorRead(142), "01 39 00 00 00 8E C8"),
    (mks.EnabledRead(True), "01 3A 01 3C"),
    (mks.HomingRead(mks.HomingState.DONE), "01 3B 01 3D"),
    (mks.HomingRead(mks.HomingState.DONE, mks.HomingState.FAILED), "01 3B 01 02 3F"),
    (mks.StallRead(False), "01 3E 00 3F"),
    (mks.StateRead(mks.MotorState.FULL_SPEED), "01 F1 04 F6"),
    (mks.VersionRead(True, 2, (1, 0, 9)), "01 40 12 01 00 09 5D"),
    (mks.VersionRead(False, 4, (1, 0, 9)), "01 40 04 01 00 09 4F"),
    (mks.VersionRead(True, 2, (1, 0, 1), e_series=True), "01 40 92 01 00 01 D5"),
    (mks.Status(mks.Code.ABSOLUTE_AXIS, mks.Outcome.STARTED), "01 F5 01 F7"),
    (mks.Status(mks.Code.ABSOLUTE_AXIS, mks.Outcome.DONE), "01 F5 02 F8"),
    (mks.Status(mks.Code.RELATIVE_PULSES, mks.Outcome.LIMIT_STOP), "01 FD 03 01"),
    (mks.Status(mks.Code.SPEED_MODE, mks.Outcome.STORED), "01 F6 05 FC"),
    (mks.Status(mks.Code.RELATIVE_AXIS, mks.Outcome.FAILED), "01 F4 00 F5"),
    (mks.Status(mks.Code.HOME, mks.Outcome.STARTED), "01 91 01 93"),
    (mks.Status(mks.Code.HOME, mks.Outcome.FAILED), "01 91 00 92"),
    (mks.Status(mks.Code.CALIBRATE, mks.Outcome.STARTED), "01 80 00 81"),
    (mks.Status(mks.Code.CALIBRATE, mks.Outcome.FAILED), "01 80 02 83"),
    (mks.Status(mks.Code.ENABLE, mks.Outcome.DONE), "01 F3 01 F5"),
    (mks.Status(mks.Code.MODE, mks.Outcome.FAILED), "01 82 00 83"),
]

REQUEST_BYTES = MANUAL_REQUESTS + OTHER_REQUESTS


def frame_of(text: str) -> Frame:
    number, *data = bytes.fromhex(text)
    return Frame(number, bytes(data))


# -- Messages --------------------------------------------------------------------------------------

REFUSED = [
    (lambda: mks.MoveAbsoluteAxis(1 << 23, 1, 0), "counts"),
    (lambda: mks.MoveAbsoluteAxis(-(1 << 23), 1, 0), "counts"),  # the manual leaves it out
    (lambda: mks.MoveAbsoluteAxis(1, 0, 0), "speed_rpm"),  # would be a stop
    (lambda: mks.MoveAbsoluteAxis(1, 3001, 0), "speed_rpm"),
    (lambda: mks.MoveAbsoluteAxis(1, 1, 256), "acc"),
    (lambda: mks.OtherMotion(mks.Code.ABSOLUTE_AXIS, b""), "code"),
    (lambda: mks.Stop(256), "acc"),
    (lambda: mks.SetMode(5), "mode"),
    (lambda: mks.SetCurrent(5201), "current_ma"),
    (lambda: mks.SetMicrosteps(0), "microsteps"),
    (lambda: mks.SetHoming(False, False, 60, False, 3), "method"),
    (lambda: mks.SilenceWatchdog(-1), "timeout_ms"),
    (lambda: mks.SetId(0), "node"),
    (lambda: mks.ReadSetting(mks.Code.ENCODER), "setting"),
    (lambda: mks.EncoderRead(1 << 47), "counts"),
    (lambda: mks.VersionRead(True, 16, (1, 0, 6)), "board"),
    (lambda: mks.VersionRead(True, 2, (1, 0, 256)), "version"),
    (lambda: mks.SettingRead(mks.Code.MODE, b"\xff\xff"), "value"),
    (lambda: mks.Status(mks.Code.ENABLE, mks.Outcome.STARTED), "outcome"),
    (lambda: mks.ramp_rpm_s(256), "acc"),
]


@every_row("build, field", REFUSED)
def test_what_does_not_fit_is_refused_by_name(build, field):
    with pytest.raises(BadField) as refusal:
        build()
    assert refusal.value.field == field


# 1 rpm every (256 - acc) * 50 us
@every_row("acc, rpm_s", [(0, math.inf), (1, 20000 / 255), (56, 100), (236, 1000), (255, 20000)])
def test_a_ramp_is_a_rpm_every_so_many_times_50_us(acc, rpm_s):
    assert mks.ramp_rpm_s(acc) == pytest.approx(rpm_s)


@given(st.floats(20000 / 255, 1e6))
def test_the_ramp_of_an_acceleration_is_the_steepest_that_is_no_steeper(most_rpm_s):
    acc = mks.acc_of(most_rpm_s)
    assert mks.ramp_rpm_s(acc) <= most_rpm_s * (1 + 1e-9)
    assert acc == 255 or mks.ramp_rpm_s(acc + 1) > most_rpm_s


@every_row("microsteps, rpm", [(16, 100), (64, 100), (8, 200), (128, 12.5)])
def test_a_speed_is_in_rpm_with_the_usual_microsteps(microsteps, rpm):
    assert mks.true_rpm(100, microsteps) == rpm


def test_modes_and_bitrates_tell_what_they_are():
    assert [mode for mode in mks.Mode if mode.on_bus] == [3, 4, 5]
    assert [mode.top_rpm for mode in mks.Mode] == [400, 1500, 3000] * 2
    assert [rate.bits_s for rate in mks.Bitrate] == [125_000, 250_000, 500_000, 1_000_000]


# as the maker's version notes say
FIRST = {
    mks.Ability.EMERGENCY_STOP: (1, 0, 4),
    mks.Ability.CHOICE_OF_COMPLETION: (1, 0, 4),
    mks.Ability.RETARGET: (1, 0, 5),
    mks.Ability.READ_SETTINGS: (1, 0, 6),
    mks.Ability.RAW_ENCODER: (1, 0, 6),
    mks.Ability.SYNCHRONOUS_START: (1, 0, 8),
    mks.Ability.SILENCE_WATCHDOG: (1, 0, 9),
}


def test_each_firmware_can_do_what_the_older_could():
    assert {ability: ability.since for ability in FIRST} == FIRST
    for version in ((1, 0, 0), (1, 0, 4), (1, 0, 8), mks.LATEST, (1, 1, 0)):
        able = {each for each in mks.Ability if each.since <= version}
        assert mks.abilities_of(version) == able


# -- Frames ----------------------------------------------------------------------------------------


@every_row("request_, text", REQUEST_BYTES)
def test_a_request_is_these_bytes(request_, text):
    frame = frame_of(text)
    assert mks.encode(frame.can_id, request_) == frame
    assert mks.decode_request(frame) == request_


@every_row("answer, text", ANSWER_BYTES)
def test_an_answer_is_these_bytes(answer, text):
    frame = frame_of(text)
    assert mks.encode(frame.can_id, answer) == frame
    assert mks.decode_answer(frame) == answer


def test_the_table_leaves_no_code_out():
    assert {request.code for request, _ in REQUEST_BYTES} == set(mks.Code)


@given(NODES, REQUESTS)
def test_every_request_can_be_read(node, request_):
    assert mks.decode_request(mks.encode(node, request_)) == request_


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


def test_a_speed_of_zero_is_a_stop_wherever_it_is_to_go():
    data = bytes((mks.Code.ABSOLUTE_AXIS, 0, 0, 7, 0, 0x40, 0))
    frame = Frame(1, data + bytes((mks.check_byte(1, data),)))
    assert mks.decode_request(frame) == mks.Stop(7)


@given(st.one_of(REQUESTS, READINGS), NODES, st.integers(0, 7), st.integers(1, 255))
def test_one_changed_byte_is_always_noticed(message, node, at, change):
    good = mks.encode(node, message)
    data = bytearray(good.data)
    data[at % len(data)] ^= change
    for decode in (mks.decode_request, mks.decode_answer):
        with pytest.raises(RemoteProtocolError, match="the check byte should be"):
            decode(Frame(node, bytes(data)))


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


@every_row(
    "frame, reason",
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


@every_row(
    "text, reason",
    [
        ("01 4B 01 4D", "1 says nothing of GO"),
        ("01 F5 04 FA", "4 says nothing of ABSOLUTE_AXIS"),
        ("01 F5 F6", "length 0 where 1 belong"),
        ("01 F1 07 F9", "7 is not a valid MotorState"),
        ("01 3B 3C", "length 0 where 1 or 2 belong"),
        ("01 40 12 53", "length 1 where 4 belong"),
    ],
)
def test_a_frame_that_is_no_answer_says_why(text, reason):
    with pytest.raises(RemoteProtocolError, match=reason):
        mks.decode_answer(frame_of(text))
