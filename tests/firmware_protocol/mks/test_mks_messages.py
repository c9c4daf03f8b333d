"""What an MKS drive cannot carry cannot be built; units; and what each firmware can do."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mks_strategies import ACC, REQUESTS

from firmware_protocol.errors import BadField
from firmware_protocol.mks import (
    LATEST,
    SINCE,
    Ability,
    Bitrate,
    Code,
    EncoderRead,
    GoSynchronous,
    GoToZero,
    HomingRead,
    Mode,
    MoveAbsoluteAxis,
    MoveAbsolutePulses,
    MoveRelativePulses,
    Outcome,
    ReadEncoder,
    ReadSetting,
    ReadVersion,
    ReplyMode,
    ReportByItself,
    RunAtSpeed,
    RunFor,
    SetArrival,
    SetBitrate,
    SetCurrent,
    SetGroup,
    SetHoldingCurrent,
    SetHoming,
    SetId,
    SetMicrosteps,
    SetMode,
    SetReplies,
    SettingRead,
    SilenceWatchdog,
    SpeedRead,
    Status,
    Stop,
    VersionRead,
    abilities_of,
    acc_of,
    needed_for,
    ramp_rpm_s,
    true_rpm,
)

REFUSED = [
    (lambda: MoveAbsoluteAxis(1 << 23, 1, 0), "counts"),
    (lambda: MoveAbsoluteAxis(-(1 << 23), 1, 0), "counts"),  # the manual leaves it out
    (lambda: MoveAbsoluteAxis(1.0, 1, 0), "counts"),
    (lambda: MoveAbsoluteAxis(1, 0, 0), "speed_rpm"),  # would be a stop
    (lambda: MoveAbsoluteAxis(1, 3001, 0), "speed_rpm"),
    (lambda: MoveAbsoluteAxis(1, 1, 256), "acc"),
    (lambda: MoveAbsolutePulses(1 << 23, 1, 0), "pulses"),
    (lambda: MoveRelativePulses(1 << 24, 1, 0), "pulses"),
    (lambda: MoveRelativePulses(1, -1, 0), "speed_rpm"),
    (lambda: RunAtSpeed(0, 2), "speed_rpm"),
    (lambda: RunAtSpeed(-3001, 2), "speed_rpm"),
    (lambda: RunFor(1, 2, 0), "duration_ms"),
    (lambda: RunFor(1, 2, 15), "duration_ms"),
    (lambda: Stop(Code.ENABLE, 2), "code"),
    (lambda: Stop(0xF5, 2), "code"),
    (lambda: SetMode(5), "mode"),
    (lambda: SetCurrent(0), "current_ma"),
    (lambda: SetCurrent(5201), "current_ma"),
    (lambda: SetCurrent(100, keep=0), "keep"),
    (lambda: SetHoldingCurrent(55), "percent"),
    (lambda: SetHoldingCurrent(100), "percent"),
    (lambda: SetMicrosteps(0), "microsteps"),
    (lambda: SetHoming(False, False, 3001, False, 0), "speed_rpm"),
    (lambda: SetHoming(False, False, 60, False, 3), "method"),
    (lambda: SetArrival(1), "on"),
    (lambda: SilenceWatchdog(-1), "timeout_ms"),
    (lambda: SetBitrate(500), "bitrate"),
    (lambda: SetId(0), "node"),
    (lambda: SetGroup(0x800), "node"),
    (lambda: SetReplies(1), "mode"),
    (lambda: ReadSetting(Code.ENCODER), "setting"),
    (lambda: ReadSetting(0x82), "setting"),
    (lambda: ReportByItself(Code.MODE, 100), "reading"),
    (lambda: ReportByItself(Code.ENCODER, 65536), "period_ms"),
    (lambda: EncoderRead(1 << 47), "counts"),
    (lambda: SpeedRead(40000), "speed_rpm"),
    (lambda: HomingRead(1), "at_power_on"),
    (lambda: VersionRead(True, 16, b"\1\0\6"), "board"),
    (lambda: VersionRead(True, 2, b"\1"), "firmware"),
    (lambda: SettingRead(Code.MODE, b""), "value"),
    (lambda: SettingRead(Code.MODE, b"\xff\xff"), "value"),
    (lambda: Status(Code.ENCODER, Outcome.DONE), "outcome"),
    (lambda: Status(Code.ENABLE, Outcome.STARTED), "outcome"),
    (lambda: Status(Code.REPORT, Outcome.DONE), "reading"),
    (lambda: Status(Code.MODE, Outcome.DONE, Code.ENCODER), "reading"),
    (lambda: ramp_rpm_s(256), "acc"),
    (lambda: acc_of(0), "most_rpm_s"),
    (lambda: acc_of(math.nan), "most_rpm_s"),
    (lambda: abilities_of("1.0.6"), "version"),
    (lambda: abilities_of((1, 0)), "version"),
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
    assert ramp_rpm_s(acc) == pytest.approx(rpm_s)


@given(st.floats(20000 / 255, 1e6))
def test_the_ramp_of_an_acceleration_is_the_steepest_that_is_no_steeper(most_rpm_s):
    acc = acc_of(most_rpm_s)
    assert ramp_rpm_s(acc) <= most_rpm_s * (1 + 1e-9)
    assert acc == 255 or ramp_rpm_s(acc + 1) > most_rpm_s


def test_no_ramp_is_gentler_than_the_gentlest():
    assert acc_of(1) == 1


@given(ACC.filter(bool))
def test_a_ramp_gives_its_acc_back(acc):
    assert abs(acc_of(ramp_rpm_s(acc)) - acc) <= 1


@pytest.mark.parametrize(("microsteps", "rpm"), [(16, 100), (64, 100), (8, 200), (128, 12.5)])
def test_a_speed_is_in_rpm_with_the_usual_microsteps(microsteps, rpm):
    assert true_rpm(100, microsteps) == rpm


def test_modes_and_bitrates_tell_what_they_are():
    assert [mode for mode in Mode if mode.on_bus] == [3, 4, 5]
    assert [mode.top_rpm for mode in Mode] == [400, 1500, 3000] * 2
    assert [rate.bits_s for rate in Bitrate] == [125_000, 250_000, 500_000, 1_000_000]


@pytest.mark.parametrize(("firmware", "version"), [(b"\1\0\x09", (1, 0, 9)), (b"\1\x09", None)])
def test_a_version_of_two_bytes_is_not_guessed_at(firmware, version):
    assert VersionRead(True, 2, firmware).version == version


FIRST = {
    (1, 0, 0): set(),
    (1, 0, 4): {Ability.EMERGENCY_STOP, Ability.ABSOLUTE_PULSES, Ability.CHOICE_OF_COMPLETION},
    (1, 0, 5): {Ability.RETARGET, Ability.RESTART},
    (1, 0, 6): {Ability.READ_SETTINGS, Ability.RAW_ENCODER},
    (1, 0, 7): {Ability.TIMED_RUN, Ability.UNKEPT_CURRENT},
    (1, 0, 8): {Ability.SYNCHRONOUS_START},
    (1, 0, 9): {Ability.SILENCE_WATCHDOG, Ability.REPORTS_BY_ITSELF},
}


def test_each_firmware_can_do_what_the_older_could_and_more():
    could = frozenset()
    for version, learnt in FIRST.items():
        can = abilities_of(version)
        assert could <= can
        assert learnt <= can - could
        could = can
    assert abilities_of(LATEST) == abilities_of((1, 1, 0)) == set(Ability)
    assert abilities_of((1, 0, 0)) == set()


def test_what_is_not_in_the_version_notes_is_marked():
    assert set(SINCE) == set(Ability)
    assert [ability for ability, since in SINCE.items() if not since.verified] == [Ability.VERSION]


@pytest.mark.parametrize(
    ("request_", "ability"),
    [
        (ReadEncoder(), None),
        (ReadVersion(), Ability.VERSION),
        (GoSynchronous(), Ability.SYNCHRONOUS_START),
        (GoToZero(), Ability.GO_TO_ZERO),
        (SetCurrent(100), None),
        (SetCurrent(100, keep=False), Ability.UNKEPT_CURRENT),
        (SetReplies(ReplyMode.FULL), Ability.CHOICE_OF_COMPLETION),
        (SetReplies(ReplyMode.IMMEDIATE), Ability.CHOICE_OF_COMPLETION),
        (RunFor(1, 1, 10), Ability.TIMED_RUN),
        (SilenceWatchdog(0), Ability.SILENCE_WATCHDOG),
    ],
)
def test_a_request_needs_an_ability(request_, ability):
    assert needed_for(request_) is ability


@given(REQUESTS)
def test_the_newest_firmware_understands_every_request(request_):
    assert needed_for(request_) in abilities_of(LATEST) | {None}
