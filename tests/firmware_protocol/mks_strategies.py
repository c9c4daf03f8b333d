"""What the MKS tests draw from: every request, every answer, and an answer that fits a request."""

from hypothesis import strategies as st

from firmware_protocol.mks import (
    MOTION_CODES,
    READ_CODES,
    SETTING_CODES,
    AngleErrorRead,
    ArmSynchronous,
    Bitrate,
    Calibrate,
    ClearStall,
    EmergencyStop,
    Enable,
    EnabledRead,
    EncoderRead,
    GoSynchronous,
    GoToZero,
    Home,
    HomingRead,
    HomingState,
    InputsRead,
    Mode,
    MotorState,
    MoveAbsoluteAxis,
    MoveAbsolutePulses,
    MoveRelativeAxis,
    MoveRelativePulses,
    PulsesRead,
    RawEncoderRead,
    ReadAngleError,
    ReadEnabled,
    ReadEncoder,
    ReadHoming,
    ReadInputs,
    ReadPulses,
    ReadRawEncoder,
    ReadSetting,
    ReadSpeed,
    ReadStall,
    ReadState,
    ReadVersion,
    ReplyMode,
    ReportByItself,
    Restart,
    RunAtSpeed,
    RunFor,
    SetArrival,
    SetBitrate,
    SetCurrent,
    SetDirection,
    SetGroup,
    SetHoldingCurrent,
    SetHoming,
    SetId,
    SetMicrosteps,
    SetMode,
    SetPositionProtection,
    SetReplies,
    SetStallProtection,
    SettingRead,
    SetZero,
    SilenceWatchdog,
    SpeedRead,
    StallRead,
    StateRead,
    Stop,
    VersionRead,
)

NODES = st.integers(1, 0x7FF)
SPEED, ACC, BOOLS = st.integers(1, 3000), st.integers(0, 255), st.booleans()
SIGNED_SPEED = SPEED | SPEED.map(lambda speed_rpm: -speed_rpm)
TARGET, WORD = st.integers(-8388607, 8388607), st.integers(0, 0xFFFF)
INT48 = st.integers(-(1 << 47), (1 << 47) - 1)
INT32 = st.integers(-(1 << 31), (1 << 31) - 1)

MOVES = st.one_of(
    *[
        st.builds(kind, TARGET, SPEED, ACC)
        for kind in (MoveRelativeAxis, MoveAbsoluteAxis, MoveAbsolutePulses)
    ],
    st.builds(MoveRelativePulses, st.integers(-0xFFFFFF, 0xFFFFFF), SPEED, ACC),
)
MOTIONS = st.one_of(
    MOVES,
    st.builds(RunAtSpeed, SIGNED_SPEED, ACC),
    st.builds(RunFor, SIGNED_SPEED, ACC, st.integers(1, 0xFFFFFF).map(lambda ticks: ticks * 10)),
    st.builds(Stop, st.sampled_from(sorted(MOTION_CODES)), ACC),
    st.sampled_from([Home(), GoToZero(), Calibrate()]),
)
SETTINGS = st.one_of(
    st.builds(SetMode, st.sampled_from(Mode)),
    st.builds(SetCurrent, st.integers(1, 5200), BOOLS),
    st.builds(SetHoldingCurrent, st.sampled_from(range(10, 100, 10))),
    st.builds(SetMicrosteps, st.integers(1, 256)),
    st.builds(SetDirection, BOOLS),
    st.builds(SetStallProtection, BOOLS),
    st.builds(SetPositionProtection, BOOLS, WORD, WORD),
    st.builds(SetHoming, BOOLS, BOOLS, st.integers(0, 3000), BOOLS, st.integers(0, 2)),
    st.builds(SetArrival, BOOLS, WORD),
    st.builds(SilenceWatchdog, st.integers(0, 0xFFFFFFFF)),
    st.builds(SetBitrate, st.sampled_from(Bitrate)),
    st.builds(SetId, NODES),
    st.builds(SetGroup, NODES),
    st.builds(SetReplies, st.sampled_from(ReplyMode)),
)
PLAIN_READS = {
    ReadEncoder: st.builds(EncoderRead, INT48),
    ReadRawEncoder: st.builds(RawEncoderRead, INT48),
    ReadSpeed: st.builds(SpeedRead, st.integers(-32768, 32767)),
    ReadPulses: st.builds(PulsesRead, INT32),
    ReadInputs: st.builds(InputsRead, st.integers(0, 255)),
    ReadAngleError: st.builds(AngleErrorRead, INT32),
    ReadEnabled: st.builds(EnabledRead, BOOLS),
    ReadHoming: st.builds(
        HomingRead, st.sampled_from(HomingState), st.none() | st.sampled_from(HomingState)
    ),
    ReadStall: st.builds(StallRead, BOOLS),
    ReadVersion: st.builds(
        VersionRead, BOOLS, st.integers(0, 15), st.binary(min_size=2, max_size=3)
    ),
    ReadState: st.builds(StateRead, st.sampled_from(MotorState)),
}
READS = st.sampled_from([kind() for kind in PLAIN_READS])
READ_SETTINGS = st.builds(ReadSetting, st.sampled_from(sorted(SETTING_CODES)))
REPORTS = st.builds(ReportByItself, st.sampled_from(sorted(READ_CODES)), WORD)
ACTIONS = st.one_of(
    st.builds(Enable, BOOLS),
    st.builds(ArmSynchronous, BOOLS),
    st.sampled_from([EmergencyStop(), SetZero(), ClearStall(), Restart()]),
)
REQUESTS = st.one_of(
    MOTIONS, SETTINGS, READS, READ_SETTINGS, REPORTS, ACTIONS, st.just(GoSynchronous())
)
READINGS = st.one_of(*PLAIN_READS.values())


def setting_reads(code):
    """Draw what a drive may tell of a setting."""
    values = st.binary(min_size=1, max_size=6).filter(lambda value: value != b"\xff\xff")
    return st.builds(SettingRead, st.just(code), st.none() | values)


def readings_for(read):
    """Draw an answer to a read."""
    if isinstance(read, ReadSetting):
        return setting_reads(read.setting)
    return PLAIN_READS[type(read)]


def events(machine, data=b""):
    """Feed bytes and return every event."""
    machine.receive_data(data)
    return list(iter(machine.next_event, None))
