"""What the TeachMover tests draw from: every command and reply, and every way to cut a stream."""

import string

from hypothesis import strategies as st

from firmware_protocol.teachmover import (
    Arm,
    Close,
    Delay,
    ProgramRow,
    QDump,
    QWrite,
    Read,
    Registers,
    Reset,
    Run,
    Set,
    Status,
    Step,
)

BYTE = st.integers(0, 255)
SPEED = st.integers(0, 245)
SIX_STEPS = st.tuples(*[st.integers(-32768, 32767)] * 6)
ROWS = st.builds(ProgramRow, st.integers(0, 65535), BYTE, SIX_STEPS, BYTE)
SIGNS = st.sampled_from(sorted(set(string.punctuation) - set(",-")))
MAYBE_SPEED = st.none() | SPEED
COMMANDS = st.one_of(
    st.builds(Step, SPEED, SIX_STEPS, st.none() | BYTE),
    st.sampled_from([Read(), Reset(), Run(), QDump()]),
    st.builds(Close, MAYBE_SPEED),
    st.builds(Set, MAYBE_SPEED),
    st.builds(QWrite, ROWS),
    st.builds(Arm, SIGNS),
    st.builds(Delay, st.integers(0, 65535)),
)
REGISTERS = st.builds(Registers, SIX_STEPS, BYTE, BYTE)
STATUSES = st.sampled_from(Status)
REPLIES = st.one_of(STATUSES, REGISTERS, ROWS)
