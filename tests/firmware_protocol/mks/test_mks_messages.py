"""What an MKS drive cannot carry cannot be built; units; and what each firmware can do."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mks_strategies import ACC, REQUESTS

from firmware_protocol import mks
from firmware_protocol.errors import BadField

REFUSED = [
    (lambda: mks.MoveAbsoluteAxis(1 << 23, 1, 0), "counts"),
    (lambda: mks.MoveAbsoluteAxis(-(1 << 23), 1, 0), "counts"),  # the manual leaves it out
    (lambda: mks.MoveAbsoluteAxis(1.0, 1, 0), "counts"),
    (lambda: mks.MoveAbsoluteAxis(1, 0, 0), "speed_rpm"),  # would be a stop
    (lambda: mks.MoveAbsoluteAxis(1, 3001, 0), "speed_rpm"),
    (lambda: mks.MoveAbsoluteAxis(1, 1, 256), "acc"),
    (lambda: mks.MoveAbsolutePulses(1 << 23, 1, 0), "pulses"),
    (lambda: mks.MoveRelativePulses(1 << 24, 1, 0), "pulses"),
    (lambda: mks.MoveRelativePulses(1, -1, 0), "speed_rpm"),
    (lambda: mks.RunAtSpeed(0, 2), "speed_rpm"),
    (lambda: mks.RunAtSpeed(-3001, 2), "speed_rpm"),
    (lambda: mks.RunFor(1, 2, 0), "duration_ms"),
    (lambda: mks.RunFor(1, 2, 15), "duration_ms"),
    (lambda: mks.Stop(mks.Code.ENABLE, 2), "code"),
    (lambda: mks.Stop(0xF5, 2), "code"),
    (lambda: mks.SetMode(5), "mode"),
    (lambda: mks.SetCurrent(0), "current_ma"),
    (lambda: mks.SetCurrent(5201), "current_ma"),
    (lambda: mks.SetCurrent(100, keep=0), "keep"),
    (lambda: mks.SetHoldingCurrent(55), "percent"),
    (lambda: mks.SetHoldingCurrent(100), "percent"),
    (lambda: mks.SetMicrosteps(0), "microsteps"),
    (lambda: mks.SetHoming(False, False, 3001, False, 0), "speed_rpm"),
    (lambda: mks.SetHoming(False, False, 60, False, 3), "method"),
    (lambda: mks.SetArrival(1), "on"),
    (lambda: mks.SilenceWatchdog(-1), "timeout_ms"),
    (lambda: mks.SetBitrate(500), "bitrate"),
    (lambda: mks.SetId(0), "node"),
    (lambda: mks.SetGroup(0x800), "node"),
    (lambda: mks.SetReplies(1), "mode"),
    (lambda: mks.ReadSetting(mks.Code.ENCODER), "setting"),
    (lambda: mks.ReadSetting(0x82), "setting"),
    (lambda: mks.ReportByItself(mks.Code.MODE, 100), "reading"),
    (lambda: mks.ReportByItself(mks.Code.ENCODER, 65536), "period_ms"),
    (lambda: mks.EncoderRead(1 << 47), "counts"),
    (lambda: mks.SpeedRead(40000), "speed_rpm"),
    (lambda: mks.HomingRead(1), "at_power_on"),
    (lambda: mks.VersionRead(True, 16, b"\1\0\6"), "board"),
    (lambda: mks.VersionRead(True, 2, b"\1"), "firmware"),
    (lambda: mks.SettingRead(mks.Code.MODE, b""), "value"),
    (lambda: mks.SettingRead(mks.Code.MODE, b"\xff\xff"), "value"),
    (lambda: mks.Status(mks.Code.ENCODER, mks.Outcome.DONE), "outcome"),
    (lambda: mks.Status(mks.Code.ENABLE, mks.Outcome.STARTED), "outcome"),
    (lambda: mks.Status(mks.Code.REPORT, mks.Outcome.DONE), "reading"),
    (lambda: mks.Status(mks.Code.MODE, mks.Outcome.DONE, mks.Code.ENCODER), "reading"),
    (lambda: mks.ramp_rpm_s(256), "acc"),
    (lambda: mks.acc_of(0), "most_rpm_s"),
    (lambda: mks.acc_of(math.nan), "most_rpm_s"),
    (lambda: mks.abilities_of("1.0.6"), "version"),
    (lambda: mks.abilities_of((1, 0)), "version"),
]


@pytest.mark.parametrize(("build", "field"), REFUSED)
def test_what_does_not_fit_is_refused_by_name(build, field):
    with pytest.raises(BadField) as refusal:
        build()
    assert refusal.value.field == field


# 1 rpm every (256 - acc) * 50 us
@pytest.mark.parametrize(
    ("acc", "rpm_s"), [(0, math.inf), (1, 20000 / 255), (56, 100), (236, 1000), (255, 20000)]
)
def test_a_ramp_is_a_rpm_every_so_many_times_50_us(acc, rpm_s):
    assert mks.ramp_rpm_s(acc) == pytest.approx(rpm_s)


@given(st.floats(20000 / 255, 1e6))
def test_the_ramp_of_an_acceleration_is_the_steepest_that_is_no_steeper(most_rpm_s):
    acc = mks.acc_of(most_rpm_s)
    assert mks.ramp_rpm_s(acc) <= most_rpm_s * (1 + 1e-9)
    assert acc == 255 or mks.ramp_rpm_s(acc + 1) > most_rpm_s


def test_no_ramp_is_gentler_than_the_gentlest():
    assert mks.acc_of(1) == 1


@given(ACC.filter(bool))
def test_a_ramp_gives_its_acc_back(acc):
    assert abs(mks.acc_of(mks.ramp_rpm_s(acc)) - acc) <= 1


@pytest.mark.parametrize(("microsteps", "rpm"), [(16, 100), (64, 100), (8, 200), (128, 12.5)])
def test_a_speed_is_in_rpm_with_the_usual_microsteps(microsteps, rpm):
    assert mks.true_rpm(100, microsteps) == rpm


def test_modes_and_bitrates_tell_what_they_are():
    assert [mode for mode in mks.Mode if mode.on_bus] == [3, 4, 5]
    assert [mode.top_rpm for mode in mks.Mode] == [400, 1500, 3000] * 2
    assert [rate.bits_s for rate in mks.Bitrate] == [125_000, 250_000, 500_000, 1_000_000]


@pytest.mark.parametrize(("firmware", "version"), [(b"\1\0\x09", (1, 0, 9)), (b"\1\x09", None)])
def test_a_version_of_two_bytes_is_not_guessed_at(firmware, version):
    assert mks.VersionRead(True, 2, firmware).version == version


FIRST = {
    (1, 0, 0): set(),
    (1, 0, 4): {
        mks.Ability.EMERGENCY_STOP,
        mks.Ability.ABSOLUTE_PULSES,
        mks.Ability.CHOICE_OF_COMPLETION,
    },
    (1, 0, 5): {mks.Ability.RETARGET, mks.Ability.RESTART},
    (1, 0, 6): {mks.Ability.READ_SETTINGS, mks.Ability.RAW_ENCODER},
    (1, 0, 7): {mks.Ability.TIMED_RUN, mks.Ability.UNKEPT_CURRENT},
    (1, 0, 8): {mks.Ability.SYNCHRONOUS_START},
    (1, 0, 9): {mks.Ability.SILENCE_WATCHDOG, mks.Ability.REPORTS_BY_ITSELF},
}


def test_each_firmware_can_do_what_the_older_could_and_more():
    could = frozenset()
    for version, learnt in FIRST.items():
        can = mks.abilities_of(version)
        assert could <= can
        assert learnt <= can - could
        could = can
    assert mks.abilities_of(mks.LATEST) == mks.abilities_of((1, 1, 0)) == set(mks.Ability)
    assert mks.abilities_of((1, 0, 0)) == set()


@pytest.mark.parametrize(
    ("request_", "ability"),
    [
        (mks.ReadEncoder(), None),
        (mks.ReadVersion(), mks.Ability.VERSION),
        (mks.GoSynchronous(), mks.Ability.SYNCHRONOUS_START),
        (mks.GoToZero(), mks.Ability.GO_TO_ZERO),
        (mks.SetCurrent(100), None),
        (mks.SetCurrent(100, keep=False), mks.Ability.UNKEPT_CURRENT),
        (mks.SetReplies(mks.ReplyMode.FULL), mks.Ability.CHOICE_OF_COMPLETION),
        (mks.SetReplies(mks.ReplyMode.IMMEDIATE), mks.Ability.CHOICE_OF_COMPLETION),
        (mks.RunFor(1, 1, 10), mks.Ability.TIMED_RUN),
        (mks.SilenceWatchdog(0), mks.Ability.SILENCE_WATCHDOG),
    ],
)
def test_a_request_needs_an_ability(request_, ability):
    assert mks.needed_for(request_) is ability


@given(REQUESTS)
def test_the_newest_firmware_understands_every_request(request_):
    assert mks.needed_for(request_) in mks.abilities_of(mks.LATEST) | {None}
