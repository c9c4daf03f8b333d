"""What the MKS tests draw from, and what a host of six drives says and hears."""

from chunks import events
from fuzzing import FuzzCase
from hypothesis import strategies as st

from firmware_protocol import mks
from firmware_protocol.frames import pack

NODES = st.integers(1, 0x7FF)
SPEED, ACC, BOOLS = st.integers(1, 3000), st.integers(0, 255), st.booleans()
TARGET, WORD = st.integers(-8388607, 8388607), st.integers(0, 0xFFFF)
INT48 = st.integers(-(1 << 47), (1 << 47) - 1)
INT32 = st.integers(-(1 << 31), (1 << 31) - 1)


def _other_motions(code):
    size = mks.OTHER_MOTIONS[code]
    return st.builds(mks.OtherMotion, st.just(code), st.binary(min_size=size, max_size=size))


MOTIONS = st.one_of(
    st.builds(mks.MoveAbsoluteAxis, TARGET, SPEED, ACC),
    st.sampled_from(sorted(mks.OTHER_MOTIONS)).flatmap(_other_motions),
    st.builds(mks.Stop, ACC),
    st.sampled_from([mks.Home(), mks.Calibrate()]),
)
SETTINGS = st.one_of(
    st.builds(mks.SetMode, st.sampled_from(mks.Mode)),
    st.builds(mks.SetCurrent, st.integers(1, 5200)),
    st.builds(mks.SetMicrosteps, st.integers(1, 256)),
    st.builds(mks.SetStallProtection, BOOLS),
    st.builds(mks.SetHoming, BOOLS, BOOLS, st.integers(0, 3000), BOOLS, st.integers(0, 2)),
    st.builds(mks.SilenceWatchdog, st.integers(0, 0xFFFFFFFF)),
    st.builds(mks.SetBitrate, st.sampled_from(mks.Bitrate)),
    st.builds(mks.SetId, NODES),
    st.builds(mks.SetReplies, st.sampled_from(mks.ReplyMode)),
)
PLAIN_READS = {
    mks.ReadEncoder: st.builds(mks.EncoderRead, INT48),
    mks.ReadRawEncoder: st.builds(mks.RawEncoderRead, INT48),
    mks.ReadAngleError: st.builds(mks.AngleErrorRead, INT32),
    mks.ReadEnabled: st.builds(mks.EnabledRead, BOOLS),
    mks.ReadHoming: st.builds(
        mks.HomingRead,
        st.sampled_from(mks.HomingState),
        st.none() | st.sampled_from(mks.HomingState),
    ),
    mks.ReadStall: st.builds(mks.StallRead, BOOLS),
    mks.ReadVersion: st.builds(
        mks.VersionRead, BOOLS, st.integers(0, 15), st.tuples(*[st.integers(0, 255)] * 3)
    ),
    mks.ReadState: st.builds(mks.StateRead, st.sampled_from(mks.MotorState)),
}
READS = st.sampled_from([kind() for kind in PLAIN_READS])
READ_SETTINGS = st.builds(mks.ReadSetting, st.sampled_from(sorted(mks.SETTING_CODES)))
ACTIONS = st.one_of(
    st.builds(mks.Enable, BOOLS),
    st.builds(mks.ArmSynchronous, BOOLS),
    st.sampled_from([mks.EmergencyStop(), mks.SetZero(), mks.ClearStall()]),
)
REQUESTS = st.one_of(MOTIONS, SETTINGS, READS, READ_SETTINGS, ACTIONS)
READINGS = st.one_of(*PLAIN_READS.values())


def setting_reads(code):
    """Draw what a drive may tell of a setting."""
    values = st.binary(min_size=1, max_size=6).filter(lambda value: value != b"\xff\xff")
    return st.builds(mks.SettingRead, st.just(code), st.none() | values)


def readings_for(read):
    """Draw an answer to a read."""
    if isinstance(read, mks.ReadSetting):
        return setting_reads(read.setting)
    return PLAIN_READS[type(read)]


# -- The ends of the codec for the long fuzz run ---------------------------------------------------

DRIVES = range(1, 7)
MOTION_CODES = st.sampled_from(sorted(mks.MOTION_CODES))
STATUSES = st.one_of(
    st.builds(mks.Status, MOTION_CODES, st.sampled_from(mks.Outcome)),
    st.sampled_from(
        [
            mks.Status(mks.Code.ENABLE, mks.Outcome.FAILED),
            mks.Status(mks.Code.MODE, mks.Outcome.DONE),
        ]
    ),
)


def _records(nodes, messages):
    return st.builds(lambda node, message: pack(mks.encode(node, message)), nodes, messages)


ANSWER_RECORDS = _records(st.sampled_from(DRIVES), READINGS | STATUSES)
REQUEST_RECORDS = _records(st.sampled_from((0, 1)), REQUESTS)


def _host_saw_one(host: mks.Host) -> bool:
    found = any(isinstance(event, mks.Answered) for event in events(host))
    for node in DRIVES:
        host.send(node, mks.MoveAbsoluteAxis(1, 1, 1))
        host.send(node, mks.ReadEncoder())
    return found


HOST = FuzzCase("mks host", lambda: mks.Host(DRIVES), ANSWER_RECORDS, _host_saw_one)


# -- What the tests of the host of six drives say and hear -----------------------------------------

ONE = mks.MoveAbsoluteAxis(0x4000, 600, 2)
HALT = mks.Stop(4)
HERE = mks.EncoderRead(123)


def said(node, *answers) -> bytes:
    return b"".join(pack(mks.encode(node, answer)) for answer in answers)


STARTED = mks.Status(mks.Code.ABSOLUTE_AXIS, mks.Outcome.STARTED)


def asked(*requests, node=1) -> mks.Host:
    host = mks.Host(DRIVES)
    for request in requests:
        host.send(node, request)
    return host
